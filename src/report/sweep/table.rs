//! All models of a walk in one table, and what it says.

use super::plots::records;
use super::{changes, quality_heading, quality_notes, quality_table};
use crate::gpu::{Link, Stream};
use crate::models::Kind;
use crate::report::run::{microseconds, note};
use crate::report::{Cell, Column, SweepQuality, Table, decimal, grouped};
use crate::run::{Sweep, SweepModel, Variant};

/// What the columns mean.
pub(super) const CAPTION: &str = "First upload: everything before step 0. Payload, transfers and \
     wire bytes are those of changes of detail over all steps, without the view; fetched is what \
     draws pulled from host memory, times are modelled for both; resident is the device memory in \
     use at the begin.";

/// Levels in the terminal's table of what they do to the picture.
const TEXT_LEVELS: usize = 11;

/// The links of the table: those of the papers' years, and a new one.
const LINKS: [(&str, &str); 3] = [
    ("agp8x", "AGP 8x, ms"),
    ("pcie1x16", "PCIe 1, ms"),
    ("pcie5x16", "PCIe 5, ms"),
];

/// One row a model.
#[must_use]
pub fn sweep_table(sweep: &Sweep) -> Table {
    let headings = [
        "first upload, B",
        "payload, B",
        "transfers",
        "wire, B",
        "commands, B",
        "fetched, B",
    ];
    let times = LINKS.map(|(_, heading)| heading);
    let last = ["vertices", "resident, B"];
    let numbers = headings.into_iter().chain(times).chain(last);
    let columns = numbers.map(Column::numbers);
    Table {
        columns: [Column::words("model")]
            .into_iter()
            .chain(columns)
            .collect(),
        rows: sweep.models.iter().map(cells).collect(),
    }
}

fn cells(model: &SweepModel) -> Vec<Cell> {
    let changes = model.changes();
    let totals = model.totals();
    let mut cells = vec![Cell::Text(model.variant.label())];
    cells.extend(
        [
            model.initial.upload.payload_bytes,
            changes.payload_bytes,
            changes.transfers,
            changes.wire_bytes,
            totals.command_bytes,
            totals.fetch.payload_bytes,
        ]
        .map(Cell::Count),
    );
    cells.extend(LINKS.map(|(name, _)| match Link::named(name) {
        None => Cell::Missing,
        Some(link) => {
            let ticks = |stream| model.traffic_on(Some(link), stream).ticks;
            Cell::Number {
                value: microseconds(ticks(Stream::Upload) + ticks(Stream::Fetch)) / 1000.0,
                digits: 3,
            }
        }
    }));
    cells.extend([totals.vertices, model.initial.resident_bytes].map(Cell::Count));
    cells
}

/// The table for a terminal of so many columns, in several parts where it does not fit, then the
/// notes; then what levels do to the picture, if that was asked.
#[must_use]
pub fn sweep_text(sweep: &Sweep, quality: Option<&SweepQuality>, width: usize) -> String {
    let mut texts = sweep_table(sweep).to_parts(width);
    texts.push(lines(sweep_notes(sweep), ""));
    if let Some(quality) = quality {
        for look in quality.looks() {
            texts.extend(quality_heading(look).map(|heading| heading + "\n"));
            texts.extend(quality_table(quality, look, TEXT_LEVELS).to_parts(width));
        }
        texts.push(lines(quality_notes(sweep, quality), ""));
    }
    texts.join("\n")
}

fn lines(notes: Vec<String>, mark: &str) -> String {
    let notes = notes.into_iter();
    notes.map(|note| format!("{mark}{note}\n")).collect()
}

/// The table and the notes in Markdown; then what levels do to the picture, if that was asked.
#[must_use]
pub fn sweep_markdown(sweep: &Sweep, quality: Option<&SweepQuality>) -> String {
    let notes = lines(sweep_notes(sweep), "- ");
    let mut text = format!("{}\n{CAPTION}\n\n{notes}", sweep_table(sweep).to_markdown());
    if let Some(quality) = quality {
        for look in quality.looks() {
            if let Some(heading) = quality_heading(look) {
                text += &format!("\n{heading}\n");
            }
            let table = quality_table(quality, look, usize::MAX);
            text += &format!("\n{}", table.to_markdown());
        }
        text += &format!("\n{}", lines(quality_notes(sweep, quality), "- "));
    }
    text
}

/// How the modes of LoDF compare: what they send, and from where on a larger first upload has paid
/// off. Bytes stand with transfers and times, since many small transfers can lose to a large one.
#[must_use]
pub fn sweep_notes(sweep: &Sweep) -> Vec<String> {
    let mut notes = mode_notes(sweep);
    notes.extend(rival_notes(sweep));
    notes
}

/// How LoDF compares with VDF, as the papers compare them: over all changes of the walk, by records
/// read and written on the host and by modelled time of frames, in which the host has no part.
fn rival_notes(sweep: &Sweep) -> Vec<String> {
    let models = |kind: Kind| {
        let usual = move |model: &&SweepModel| {
            let foliage = Variant {
                trunk: None,
                ..model.variant
            };
            model.variant.kind == kind && foliage == Variant::usual(kind)
        };
        sweep.models.iter().filter(usual)
    };
    let mut notes = Vec::new();
    for own in [Kind::LodfHost, Kind::LodfCluster] {
        for rival in [Kind::VdfHost, Kind::VdfIndices] {
            for (own, rival) in models(own).flat_map(|own| models(rival).map(move |r| (own, r))) {
                if own.variant.trunk.is_some() == rival.variant.trunk.is_some() {
                    notes.extend(rival_note(own, rival));
                }
            }
        }
    }
    if !notes.is_empty() {
        notes.push(PRINTED_SAVINGS.to_owned());
    }
    notes
}

/// What the papers print of the same comparison, on a machine of their time.
const PRINTED_SAVINGS: &str = "The papers print, of LoDF on hardware against VDF: 42 % less extraction time \
    for Betula lenta, 70 % for Taxus baccata; 63 % and 88 % less time in all. Counts of records are not \
    times, and no time of the host is modelled here.";

fn rival_note(own: &SweepModel, rival: &SweepModel) -> Option<String> {
    // The first step changes nothing.
    let changes = |model: &SweepModel| -> u64 { model.steps.iter().map(records).sum() };
    let time = |model: &SweepModel| -> Option<u64> {
        let mut steps = model.steps.iter().filter(|step| step.step > 0);
        steps.try_fold(0, |sum, step| Some(sum + step.frame_ticks()?))
    };
    let saved = |own: u64, rival: u64| match own <= rival {
        true => format!(
            "{} % less",
            decimal(100.0 * (rival - own) as f64 / rival.max(1) as f64, 1)
        ),
        false => format!(
            "{} times as much",
            decimal(own as f64 / rival.max(1) as f64, 2)
        ),
    };
    let [ours, theirs] = [own, rival].map(changes);
    let (name, other) = (own.variant.label(), rival.variant.label());
    let mut text = format!(
        "Extraction, {name} against {other}: {} records against {}, {}",
        grouped(ours, ","),
        grouped(theirs, ","),
        saved(ours, theirs)
    );
    if let (Some(ours), Some(theirs)) = (time(own), time(rival)) {
        text += &format!("; modelled time of frames {}", saved(ours, theirs));
    }
    (theirs > 0).then(|| text + ".")
}

fn mode_notes(sweep: &Sweep) -> Vec<String> {
    let find = |variant| sweep.models.iter().find(|model| model.variant == variant);
    let Some(cluster) = find(Variant::usual(Kind::LodfCluster)) else {
        return Vec::new();
    };
    let [slots, stamps] = [Kind::LodfSlots, Kind::LodfStamps].map(Variant::usual);
    let [slots, gathered, stamps] = [slots, slots.gathered(), stamps].map(find);
    let compared = [slots, gathered, stamps].into_iter().flatten();
    let ratios = compared.map(|other| ratio_note(cluster, other));
    let paying = [slots.or(gathered), stamps].into_iter().flatten();
    let pay_offs = paying.map(|other| pay_off_note(cluster, other));
    let own = std::iter::once(note("Changes, lodf-cluster", &cluster.changes()));
    own.chain(ratios).chain(pay_offs).collect()
}

fn ratio_note(cluster: &SweepModel, other: &SweepModel) -> String {
    let [base, sent] = [cluster, other].map(SweepModel::changes);
    let text = note(&format!("Changes, {}", other.variant.label()), &sent);
    if sent.payload_bytes == 0 || sent.ticks == 0 {
        return text;
    }
    let ratio = |base: u64, sent: u64| decimal(base as f64 / sent as f64, 2);
    format!(
        "{text} lodf-cluster takes {} times these bytes and {} times this bus time.",
        ratio(base.payload_bytes, sent.payload_bytes),
        ratio(base.ticks, sent.ticks)
    )
}

fn pay_off_note(cluster: &SweepModel, other: &SweepModel) -> String {
    let (name, base) = (other.variant.label(), cluster.variant.label());
    let [first, larger] = [cluster, other].map(|model| model.initial.upload.payload_bytes);
    let begin = match larger.checked_sub(first) {
        Some(0) => format!("First upload: {name} sends as much as {base}"),
        Some(more) => format!(
            "First upload: {name} sends {} B more than {base}",
            grouped(more, ",")
        ),
        None => format!(
            "First upload: {name} sends {} B less than {base}",
            grouped(first - larger, ",")
        ),
    };
    match pay_off(cluster, other) {
        Some(0) => format!("{begin}; there is nothing to pay off."),
        Some(step) => {
            let steps = cluster.steps.last().map_or(0, |last| last.step);
            format!("{begin}; with its changes it has paid off at step {step} of {steps}.")
        }
        None => format!("{begin}; with its changes it does not pay off within this walk."),
    }
}

/// The first step at which `other` has sent no more than `base`, first uploads and changes so far
/// together.
fn pay_off(base: &SweepModel, other: &SweepModel) -> Option<u32> {
    let sums = |model: &SweepModel| -> Vec<u64> {
        let begin = model.initial.upload.payload_bytes;
        let steps = model.steps.iter().scan(begin, |sum, step| {
            *sum += changes(step);
            Some(*sum)
        });
        steps.collect()
    };
    let pairs = sums(base).into_iter().zip(sums(other));
    let paid = pairs
        .zip(&other.steps)
        .find(|((base, other), _)| other <= base);
    paid.map(|(_, step)| step.step)
}
