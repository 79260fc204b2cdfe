//! Schemes of level of detail on one tree, held against each other at the same visible error, and which to take.
//!
//! ```text
//! run::compare ─▶ SchemeFound, … ─add─▶ CompareReport ─┬─ compare.json, report.html
//!                                                      └─ leaves, wood: *.csv, plots/*.svg, sheets/*.png
//! ```
//!
//! The tree stays at each distance for [`STAY`] frames: what a change sends is spread over them, what
//! a frame sends or fetches is paid each time.

use serde_json::{Value, json};

use super::thumbnail::shrink;
use super::{
    Axis, Cell, Column, Comparison, OutputFolder, Page, PageImage, Panel, PictureView, Point,
    ReportError, Scale, Scatter, Section, Table, Thing, grouped, sheet,
};
use crate::gpu::{Card, Ledger, Link, Ticks, nanoseconds};
use crate::run::{COMPARE_VIEWS, LeftOut, SchemeFound, SchemeStep};

/// The value of `schema` in `compare.json`.
pub const COMPARE_SCHEMA: &str = "spinney.compare/2";

/// Frames that the tree stays at a distance: a second.
pub const STAY: u64 = 60;

/// A second scheme is as fast as the first if it takes at most so much more.
const AS_FAST: f64 = 1.05;

/// What was compared, and what was found.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareReport {
    /// The tree's name.
    pub plant: String,
    /// How many leaves it has.
    pub leaves: u64,
    /// The link by which times are modelled.
    pub link: Link,
    /// The card by which times are modelled.
    pub card: Card,
    /// The greatest [FLIP](crate::references) that goes unseen.
    pub tolerance: f64,
    /// What importing had to say.
    pub remarks: Vec<String>,
    /// How many triangles its wood has.
    pub triangles: u64,
    /// What was found of its foliage, scheme by scheme.
    pub leaf_schemes: Vec<SchemeFound>,
    /// What was found of its wood, scheme by scheme.
    pub wood_schemes: Vec<SchemeFound>,
    /// Schemes that cannot show it.
    pub left_out: Vec<LeftOut>,
}

/// What is held against each other: schemes of one part of the tree.
#[derive(Clone, Copy)]
struct Part<'r> {
    report: &'r CompareReport,
    /// As it is spoken of.
    what: &'static str,
    /// What files of it are called by.
    name: &'static str,
    /// What of it shows.
    shown: &'static str,
    schemes: &'r [SchemeFound],
}

/// What a scheme comes to over the whole walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SchemeSums {
    /// Payload of all changes, and of what frames sent and fetched, in bytes.
    pub bytes: u64,
    /// Transfers of the same.
    pub transfers: u64,
    /// The mean modelled time of a frame, in milliseconds.
    pub mean_ms: f64,
    /// The longest: the first frame after a change.
    pub worst_ms: f64,
    /// The greatest error.
    pub error: f64,
}

fn milliseconds(ticks: Ticks) -> f64 {
    nanoseconds(ticks) as f64 / 1e6
}

fn frame_ms(step: &SchemeStep) -> f64 {
    let ticks = step.frames.frame_ticks();
    ticks.map_or(0.0, milliseconds) / f64::from(COMPARE_VIEWS)
}

fn change_ms(step: &SchemeStep) -> f64 {
    milliseconds(step.change.upload.ticks)
}

/// What crossed the bus for drawing, whichever way.
fn traffic(ledger: &Ledger) -> [u64; 2] {
    let (upload, fetch) = (&ledger.upload, &ledger.fetch);
    [
        upload.payload_bytes + fetch.payload_bytes,
        upload.transfers + fetch.transfers,
    ]
}

impl SchemeSums {
    /// Of a scheme.
    #[must_use]
    pub fn of(scheme: &SchemeFound) -> Self {
        let mut sums = Self {
            bytes: 0,
            transfers: 0,
            mean_ms: 0.0,
            worst_ms: 0.0,
            error: 0.0,
        };
        for step in &scheme.steps {
            let (change, frames) = (traffic(&step.change), traffic(&step.frames));
            let views = u64::from(COMPARE_VIEWS);
            sums.bytes += change[0] + STAY * frames[0] / views;
            sums.transfers += change[1] + STAY * frames[1] / views;
            sums.mean_ms += frame_ms(step) + change_ms(step) / STAY as f64;
            sums.worst_ms = sums.worst_ms.max(frame_ms(step) + change_ms(step));
            sums.error = sums.error.max(step.error);
        }
        sums.mean_ms /= scheme.steps.len().max(1) as f64;
        sums
    }
}

impl CompareReport {
    /// Of what there is anything to say.
    fn parts(&self) -> Vec<Part<'_>> {
        let part = |what, name, shown, schemes| Part {
            report: self,
            what,
            name,
            shown,
            schemes,
        };
        let mut parts = vec![
            part("the leaves", "leaves", "leaves", &self.leaf_schemes[..]),
            part("the wood", "wood", "triangles, lines", &self.wood_schemes),
        ];
        parts.retain(|part| !part.schemes.is_empty());
        parts
    }

    /// Which schemes to take, and why: a sentence each.
    #[must_use]
    pub fn advice(&self) -> Vec<String> {
        let mut said: Vec<String> = self.parts().into_iter().flat_map(Part::advice).collect();
        if said.is_empty() {
            said.push("There are neither leaves nor wood, and nothing to compare.".to_owned());
        }
        let left_out = self.left_out.iter();
        said.extend(
            left_out.map(|left| format!("Without {}: {}.", left.scheme.label(), left.reason)),
        );
        said
    }
}

impl<'r> Part<'r> {
    fn within(self, error: f64) -> bool {
        error <= self.report.tolerance
    }

    /// The schemes that stay within the tolerance at every distance, the fastest first; of those that are as
    /// fast, first the one that holds and sends the least together.
    fn sound(self) -> Vec<(&'r SchemeFound, SchemeSums)> {
        let all = self
            .schemes
            .iter()
            .map(|scheme| (scheme, SchemeSums::of(scheme)));
        let mut sound: Vec<_> = all.filter(|(_, sums)| self.within(sums.error)).collect();
        sound.sort_by(|(_, a), (_, b)| a.mean_ms.total_cmp(&b.mean_ms));
        if let Some(fastest) = sound.first().map(|(_, sums)| sums.mean_ms) {
            let ties = sound.partition_point(|(_, sums)| sums.mean_ms <= AS_FAST * fastest);
            sound[..ties].sort_by_key(|(found, sums)| found.resident_bytes + sums.bytes);
        }
        sound
    }

    fn advice(self) -> Vec<String> {
        let sound = self.sound();
        let Some((best, sums)) = sound.first() else {
            let what = self.what;
            return vec![format!(
                "No scheme of {what} stays within the tolerance; ask for more."
            )];
        };
        let mut said = vec![format!(
            "For {} take {}: {:.3} ms a frame on average over {} distances on {} and {}, {} B over the bus, {} B on \
             the device, FLIP at most {:.3}.",
            self.what,
            best.scheme.label(),
            sums.mean_ms,
            best.steps.len(),
            self.report.card.name(),
            self.report.link.name(),
            grouped(sums.bytes, " "),
            grouped(best.resident_bytes, " "),
            sums.error,
        )];
        let full = self
            .schemes
            .iter()
            .find(|found| !found.scheme.has_levels() && !found.scheme.stands_in());
        if let Some(full) = full.filter(|full| full.scheme != best.scheme) {
            let all = SchemeSums::of(full);
            said.push(format!(
                "Without levels of detail it would be {:.3} ms and {} B on the device: {:.1} times as long.",
                all.mean_ms,
                grouped(full.resident_bytes, " "),
                all.mean_ms / sums.mean_ms.max(f64::MIN_POSITIVE),
            ));
        }
        let least = sound.iter().min_by_key(|(_, sums)| sums.bytes);
        if let Some((found, least)) = least.filter(|(found, _)| found.scheme != best.scheme) {
            said.push(format!(
                "{} sends least: {} B, at {:.3} ms a frame.",
                found.scheme.label(),
                grouped(least.bytes, " "),
                least.mean_ms
            ));
        }
        let small = sound.iter().min_by_key(|(scheme, _)| scheme.resident_bytes);
        if let Some((found, least)) = small.filter(|(found, _)| found.scheme != best.scheme) {
            said.push(format!(
                "{} holds least on the device: {} B, at {:.3} ms a frame.",
                found.scheme.label(),
                grouped(found.resident_bytes, " "),
                least.mean_ms
            ));
        }
        said.extend(self.far_advice(best));
        said
    }

    /// What is faster from some distance on.
    fn far_advice(self, best: &SchemeFound) -> Option<String> {
        let cards = self.schemes.iter().filter(|found| found.scheme.stands_in());
        let from = |scheme: &SchemeFound| -> Option<usize> {
            let pairs = scheme.steps.iter().zip(&best.steps);
            let pays: Vec<bool> = pairs
                .map(|(card, leaf)| self.within(card.error) && frame_ms(card) < frame_ms(leaf))
                .collect();
            let first = pays
                .iter()
                .rposition(|pays| !pays)
                .map_or(0, |last| last + 1);
            (first < pays.len()).then_some(first)
        };
        let found = cards.filter_map(|scheme| Some((from(scheme)?, scheme)));
        let (first, scheme) = found.min_by(|(first, a), (second, b)| {
            let last = |scheme: &SchemeFound| scheme.steps.last().map_or(0.0, frame_ms);
            first.cmp(second).then(last(a).total_cmp(&last(b)))
        })?;
        let (card, leaf) = (&scheme.steps[first], &best.steps[first]);
        Some(format!(
            "Where the crown is no more than {} pixels high, {} shows it within the tolerance in {:.3} ms for \
             {:.3}: let it stand for the leaves there (`[cards] from`), with {} B more on the device.",
            card.side * 9 / 10,
            scheme.scheme.label(),
            frame_ms(card),
            frame_ms(leaf),
            grouped(scheme.resident_bytes, " "),
        ))
    }

    /// A row a scheme.
    fn table(self) -> Table {
        let numbers = [
            "first upload, B",
            "on the device, B",
            "over the bus, B",
            "transfers",
            "frame, ms",
            "longest, ms",
            "FLIP at most",
        ];
        let number = |value, digits| Cell::Number { value, digits };
        let rows = self.schemes.iter().map(|scheme| {
            let sums = SchemeSums::of(scheme);
            vec![
                Cell::Text(scheme.scheme.label()),
                Cell::Count(scheme.initial.upload.payload_bytes),
                Cell::Count(scheme.resident_bytes),
                Cell::Count(sums.bytes),
                Cell::Count(sums.transfers),
                number(sums.mean_ms, 3),
                number(sums.worst_ms, 3),
                number(sums.error, 3),
            ]
        });
        Table {
            rows: rows.collect(),
            columns: words_then("scheme", &numbers),
        }
    }

    /// A row a scheme and distance.
    fn distance_table(self) -> Table {
        let numbers = [
            "pixels a side",
            "level",
            self.shown,
            "FLIP",
            "change, B",
            "change, transfers",
            "change, ms",
            "frame fetches, B",
            "frame, ms",
        ];
        let number = |value, digits| Cell::Number { value, digits };
        let rows = self.schemes.iter().flat_map(|scheme| {
            scheme.steps.iter().map(move |step| {
                let fetched = step.frames.fetch.payload_bytes / u64::from(COMPARE_VIEWS);
                vec![
                    Cell::Text(scheme.scheme.label()),
                    Cell::Count(step.side.into()),
                    number(step.level, 3),
                    Cell::Count(step.shown),
                    number(step.error, 4),
                    Cell::Count(step.change.upload.payload_bytes),
                    Cell::Count(step.change.upload.transfers),
                    number(change_ms(step), 4),
                    Cell::Count(fetched),
                    number(frame_ms(step), 4),
                ]
            })
        });
        Table {
            rows: rows.collect(),
            columns: words_then("scheme", &numbers),
        }
    }
}

fn words_then(word: &str, numbers: &[&str]) -> Vec<Column> {
    let numbers = numbers.iter().map(|heading| Column::numbers(*heading));
    std::iter::once(Column::words(word))
        .chain(numbers)
        .collect()
}

/// The table and the advice, for terminals.
#[must_use]
pub fn compare_text(report: &CompareReport, width: usize) -> String {
    let mut text = String::new();
    for part in report.parts() {
        text.push_str(&format!("Schemes of {}\n\n", part.what));
        text.push_str(&part.table().to_text(width));
        text.push('\n');
    }
    for sentence in report.advice() {
        text.push('\n');
        text.push_str(&sentence);
    }
    text.push('\n');
    text
}

/// Everything as JSON: `compare.json`.
#[must_use]
pub fn compare_json(report: &CompareReport) -> String {
    let of_scheme = |scheme: &SchemeFound, shown: &str| {
        let sums = SchemeSums::of(scheme);
        let steps = scheme.steps.iter().map(|step| {
            let [bytes, transfers] = traffic(&step.change);
            json!({
                "side": step.side, "level": step.level, shown: step.shown, "flip": step.error,
                "change_payload_bytes": bytes, "change_transfers": transfers,
                "change_ms": change_ms(step), "frame_ms": frame_ms(step),
                "frame_fetch_bytes": step.frames.fetch.payload_bytes / u64::from(COMPARE_VIEWS),
            })
        });
        json!({
            "scheme": scheme.scheme.label(),
            "initial_payload_bytes": scheme.initial.upload.payload_bytes,
            "resident_bytes": scheme.resident_bytes,
            "bytes": sums.bytes, "transfers": sums.transfers,
            "mean_frame_ms": sums.mean_ms, "worst_frame_ms": sums.worst_ms, "worst_flip": sums.error,
            "distances": steps.collect::<Vec<Value>>(),
        })
    };
    let schemes = |found: &[SchemeFound], shown| -> Vec<Value> {
        let found = found.iter();
        found.map(|scheme| of_scheme(scheme, shown)).collect()
    };
    let left_out = report.left_out.iter();
    let left_out =
        left_out.map(|left| json!({ "scheme": left.scheme.label(), "reason": left.reason }));
    let document = json!({
        "schema": COMPARE_SCHEMA,
        "plant": report.plant,
        "leaves": report.leaves,
        "link": report.link.name(),
        "card": report.card.name(),
        "tolerance": report.tolerance,
        "frames_a_distance": STAY,
        "advice": report.advice(),
        "remarks": report.remarks,
        "triangles": report.triangles,
        "schemes": schemes(&report.leaf_schemes, "leaves"),
        "wood_schemes": schemes(&report.wood_schemes, "primitives"),
        "left_out": left_out.collect::<Vec<Value>>(),
    });
    format!("{document:#}\n")
}

/// Bytes against time, and against what is held: a point a scheme.
fn plots(part: Part<'_>) -> Scatter {
    let sums: Vec<SchemeSums> = part.schemes.iter().map(SchemeSums::of).collect();
    let things = part.schemes.iter().enumerate();
    let things = things.map(|(color, scheme)| Thing {
        name: scheme.scheme.label(),
        color,
    });
    let log = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Log,
    };
    let panel = |title: &str, x: &str, y: &str, at: &dyn Fn(usize) -> [f64; 2]| Panel {
        title: title.to_owned(),
        x: log(x),
        y: log(y),
        points: {
            let all: Vec<[f64; 2]> = (0..sums.len()).map(at).collect();
            let beats = |other: &[f64; 2], one: &[f64; 2]| {
                other != one && other[0] <= one[0] && other[1] <= one[1]
            };
            let point = |one: &[f64; 2]| Point {
                at: *one,
                marked: !all.iter().any(|other| beats(other, one)),
            };
            all.iter().map(point).collect()
        },
    };
    Scatter {
        title: format!(
            "What schemes of {} send, hold and take at the same visible error",
            part.what
        ),
        things: things.collect(),
        panels: vec![
            panel(
                "bytes and time",
                "over the bus, B",
                "frame, ms",
                &|number| [sums[number].bytes as f64, sums[number].mean_ms],
            ),
            panel(
                "memory and time",
                "on the device, B",
                "frame, ms",
                &|number| {
                    [
                        part.schemes[number].resident_bytes as f64,
                        sums[number].mean_ms,
                    ]
                },
            ),
        ],
        columns: 2,
    }
}

/// Writes everything.
///
/// # Errors
///
/// When a file cannot be written, or a picture is too large.
pub fn write_compare(output: &OutputFolder, report: &CompareReport) -> Result<(), ReportError> {
    let mut sections = vec![Section::Text(format!(
        "{}, {} leaves, {} triangles of wood, walking away: at each distance every scheme shows the coarsest of its \
         levels whose difference from full detail, FLIP where anything shows, is at most {}; cards that have none show their finest. \
         Bytes of {STAY} frames a distance. Times are modelled: {}, {}. Leaves and wood are looked at one without \
         the other.",
        report.plant,
        grouped(report.leaves, " "),
        grouped(report.triangles, " "),
        report.tolerance,
        report.card.name(),
        report.link.name()
    ))];
    sections.extend(report.advice().into_iter().map(Section::Text));
    for part in report.parts() {
        write_part(output, part, &mut sections)?;
    }
    sections.extend(report.remarks.iter().cloned().map(Section::Text));
    let page = Page {
        title: format!("Levels of detail for {}", report.plant),
        sections,
    };
    output.write("report.html", page.to_html()?.as_bytes())?;
    output.write("compare.json", compare_json(report).as_bytes())
}

/// Writes what is of one part, but for its sections of the page.
fn write_part(
    output: &OutputFolder,
    part: Part<'_>,
    sections: &mut Vec<Section>,
) -> Result<(), ReportError> {
    let (what, name) = (part.what, part.name);
    let plot = plots(part).to_svg();
    let mut rows = Vec::new();
    let mut images = Vec::new();
    for found in part.schemes {
        let mut row = Vec::new();
        for step in &found.steps {
            let picture = PictureView::of(step.shot.clone())?.picture;
            if row.is_empty() {
                let small = shrink(&picture, step.side / THUMBNAIL_SIDE)?;
                images.push(PageImage {
                    caption: format!("{}, FLIP {:.3}", found.scheme.label(), step.error),
                    png: small.to_small_png()?,
                });
            }
            row.push(shrink(&picture, step.side / SHEET_SIDE)?);
        }
        rows.push(row);
    }
    // Schemes of leaves, or of a mesh, that are as coarse show the same: one of them will do.
    images.dedup_by(|one, before| one.png == before.png);
    images.truncate(Page::MAX_IMAGES / 2);
    if let Some(sheet) = sheet::of(&rows)? {
        output.write(&format!("sheets/{name}.png"), &sheet.to_small_png()?)?;
    }
    sections.push(Section::Table {
        caption: format!("Schemes of {what}"),
        table: part.table(),
    });
    sections.push(Section::Figure(plot.clone()));
    if images.len() > 1 {
        let heading = format!("Any two schemes of {what}, at the nearest distance");
        sections.push(Section::Heading(heading));
        sections.push(Section::Comparison(Comparison::of_ways("scheme", images)));
    }
    sections.push(Section::Table {
        caption: format!("Schemes of {what}, distance by distance"),
        table: part.distance_table(),
    });
    output.write(&format!("plots/{name}.svg"), plot.as_bytes())?;
    output.write(&format!("{name}.csv"), part.table().to_csv().as_bytes())?;
    let distances = part.distance_table().to_csv();
    output.write(&format!("{name}-distances.csv"), distances.as_bytes())
}

/// Pixels of pictures on the sheet and on the page.
const SHEET_SIDE: u32 = 128;
const THUMBNAIL_SIDE: u32 = 256;
