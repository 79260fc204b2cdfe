//! The numbers in tables.

use super::plots::{Crossover, crossover};
use super::switches::switch_table;
use super::textures::{refused, texture_table};
use super::{StandInQuality, StandInReport, frame_ns};
use crate::report::{Cell, Column, Spread, Table, decimal};
use crate::run::{CURVE_VIEWS, StandIn, directions};

/// What the measures mean.
const CAPTION: &str = "Each against what it stands for, foliage alone from 26 directions; the mean, and the \
     worst view. FLIP is the difference that is seen, 0 none; SSIM is structural similarity, 1 equal; \
     silhouette are pixels that show a leaf in one of the two pictures alone, as a share of those in \
     the reference; covered are pixels that show a leaf, as a share of the reference's. Fragments are \
     samples inside triangles, and time is modelled: uploads, fetches, then the card; both are means of \
     a frame.";

/// A row a stand-in and scale, for programs and people alike.
#[must_use]
pub fn stand_in_table(report: &StandInReport) -> Table {
    let columns = [
        "FLIP",
        "FLIP, worst",
        "SSIM",
        "SSIM, worst",
        "silhouette",
        "silhouette, worst",
        "covered",
        "covered, worst",
        "fragments",
        "texels",
        "frame, ns",
    ];
    let row = |look: &StandInQuality| {
        let mut cells = head(report, look);
        for Spread { mean, worst } in spreads(look) {
            cells.extend([mean, worst].map(|value| Cell::Number { value, digits: 4 }));
        }
        cells.extend(work(look));
        cells
    };
    Table {
        columns: heads()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
        rows: report.looks.iter().map(row).collect(),
    }
}

/// The same, narrower: the worst view in brackets.
pub(super) fn looks_for_people(report: &StandInReport) -> Table {
    let columns = [
        "FLIP",
        "SSIM",
        "silhouette",
        "covered",
        "fragments",
        "texels",
        "frame, ns",
    ];
    let row = |look: &StandInQuality| {
        let mut cells = head(report, look);
        cells.extend(spreads(look).map(|Spread { mean, worst }| {
            let [mean, worst] = [mean, worst].map(|value| decimal(value, 3));
            Cell::Text(format!("{mean} ({worst})"))
        }));
        cells.extend(work(look));
        cells
    };
    Table {
        columns: heads()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
        rows: report.looks.iter().map(row).collect(),
    }
}

fn heads() -> impl Iterator<Item = Column> {
    ["stand-in", "against", "scale"]
        .into_iter()
        .map(Column::words)
}

fn head(report: &StandInReport, look: &StandInQuality) -> Vec<Cell> {
    let scale = report.header.scales.get(look.scale);
    vec![
        Cell::Text(look.stand_in.label()),
        Cell::Text(look.stand_in.reference().label()),
        Cell::Text(scale.map_or_else(String::new, |scale| scale.name.to_owned())),
    ]
}

fn spreads(look: &StandInQuality) -> [Spread; 4] {
    let views = &look.views;
    [views.flip, views.ssim, views.silhouette, views.covered]
}

fn work(look: &StandInQuality) -> [Cell; 3] {
    let views = directions().len() as u64;
    let count = |count: Option<u64>| count.map_or(Cell::Missing, Cell::Count);
    let work = look.frames.work;
    [
        count(work.map(|work| work.covered / views)),
        count(work.map(|work| work.texels / views)),
        count(frame_ns(&look.frames, views)),
    ]
}

/// A row a stand-in: what is sent and kept, the time of a frame at the largest radius, and from which
/// radius on it is faster or slower than leaves.
#[must_use]
pub fn stand_in_cost_table(report: &StandInReport) -> Table {
    let columns = [
        "triangles",
        "uploaded, B",
        "resident, B",
        "fetched a frame, B",
        "frame at the largest, ns",
        "speed-up there",
        "as fast as leaves at, px",
    ];
    let leaves = report
        .costs
        .iter()
        .find(|cost| cost.stand_in == StandIn::LEAVES);
    let rows = report.costs.iter().map(|cost| {
        let last = cost.curve.last();
        let time = last.and_then(|point| frame_ns(&point.frames, CURVE_VIEWS));
        let of_leaves = leaves
            .and_then(|leaves| leaves.curve.last())
            .and_then(|point| frame_ns(&point.frames, CURVE_VIEWS));
        let speed_up = of_leaves.zip(time).map(|(leaves, time)| Cell::Number {
            value: leaves as f64 / time.max(1) as f64,
            digits: 2,
        });
        let crossing = leaves.map(|leaves| match crossover(leaves, cost) {
            Crossover::At(radius) => Cell::Number {
                value: radius,
                digits: 1,
            },
            Crossover::Faster => Cell::Text("faster throughout".to_owned()),
            Crossover::Slower => Cell::Text("slower throughout".to_owned()),
            Crossover::Same => Cell::Text("throughout".to_owned()),
            Crossover::Unknown => Cell::Missing,
        });
        vec![
            Cell::Text(cost.stand_in.label()),
            Cell::Count(cost.triangles),
            Cell::Count(cost.initial.upload.payload_bytes),
            Cell::Count(cost.resident_bytes),
            last.map_or(Cell::Missing, |point| {
                Cell::Count(point.frames.fetch.payload_bytes / CURVE_VIEWS)
            }),
            time.map_or(Cell::Missing, Cell::Count),
            speed_up.unwrap_or(Cell::Missing),
            crossing
                .filter(|_| cost.stand_in != StandIn::LEAVES)
                .unwrap_or(Cell::Missing),
        ]
    });
    Table {
        rows: rows.collect(),
        columns: [Column::words("stand-in")]
            .into_iter()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
    }
}

/// How it was looked at.
#[must_use]
pub fn stand_in_notes(report: &StandInReport) -> Vec<String> {
    let header = &report.header;
    let scales: Vec<String> = header
        .scales
        .iter()
        .map(|scale| format!("{} {} m", scale.name, scale.before))
        .collect();
    vec![
        CAPTION.to_owned(),
        format!(
            "Scales are distances from the eye to the sphere around the leaves: {}. Pixels are those of a \
             screen of {} rows that span {}°; of it only what the sphere takes is drawn, and no more than \
             its rows.",
            scales.join(", "),
            header.height,
            header.field_of_view
        ),
        format!(
            "Link {}, card {}. GSS05 tells 40 and 278 frames a second for leaves and 32 impostors: 6.95 \
             times; with 4.5 million triangles a second its leaves were not bound by the card.",
            header.link.name(),
            header.card.name()
        ),
    ]
}

/// Everything for a terminal of so many columns.
#[must_use]
pub fn stand_in_text(report: &StandInReport, width: usize) -> String {
    let looks = looks_for_people(report).to_text(width);
    let costs = stand_in_cost_table(report).to_text(width);
    let scales = &report.header.scales;
    let switches = switch_table(&report.switches, scales);
    let textures = texture_table(&report.textures, scales);
    let mut text = format!("{looks}\n{costs}");
    for table in [switches, textures] {
        if !table.rows.is_empty() {
            text.push_str(&format!("\n{}", table.to_text(width)));
        }
    }
    for line in refused(&report.textures) {
        text.push_str(&format!("\n{line}\n"));
    }
    text
}
