//! Schemes of level of detail on one tree, held against each other at the same visible error, and which to take.
//!
//! ```text
//! run::compare ─▶ SchemeFound, … ─add─▶ CompareReport ─┬─ compare.json, compare.csv, distances.csv
//!                                                      ├─ plots/*.svg, sheet.png
//!                                                      └─ report.html
//! ```
//!
//! The tree stays at each distance for [`STAY`] frames: what a change sends is spread over them, what
//! a frame sends or fetches is paid each time.

use serde_json::{Value, json};

use super::thumbnail::shrink;
use super::{
    Axis, Cell, Column, Comparison, OutputFolder, Page, PageImage, Panel, PictureView, Point,
    ReportError, Scale, Scatter, Section, Table, Thing, ViewQuality, grouped, sheet,
};
use crate::gpu::{Card, Ledger, Link, Ticks, nanoseconds};
use crate::run::{COMPARE_VIEWS, SchemeFound, SchemeStep, Shot};

/// The value of `schema` in `compare.json`.
pub const COMPARE_SCHEMA: &str = "spinney.compare/1";

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
    /// What was found, scheme by scheme.
    pub schemes: Vec<SchemeFound>,
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

/// How schemes are judged: FLIP, the mean over the pictures.
///
/// # Errors
///
/// When pictures are too large, or not of one size.
pub fn mean_flip(full: &[Shot], level: &[Shot]) -> Result<f64, ReportError> {
    let views = |shots: &[Shot]| -> Result<Vec<PictureView>, ReportError> {
        shots.iter().cloned().map(PictureView::of).collect()
    };
    let found = ViewQuality::all(&views(full)?, &views(level)?)?;
    let sum = found.iter().fold(0.0, |sum, one| sum + one.flip);
    Ok(sum / found.len().max(1) as f64)
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
    fn within(&self, error: f64) -> bool {
        error <= self.tolerance
    }

    /// The schemes that stay within the tolerance at every distance, the fastest first; of those that are as
    /// fast as the one before them, the one that holds less.
    fn sound(&self) -> Vec<(&SchemeFound, SchemeSums)> {
        let all = self
            .schemes
            .iter()
            .map(|scheme| (scheme, SchemeSums::of(scheme)));
        let mut sound: Vec<_> = all.filter(|(_, sums)| self.within(sums.error)).collect();
        sound.sort_by(|(_, a), (_, b)| a.mean_ms.total_cmp(&b.mean_ms));
        if let Some(fastest) = sound.first().map(|(_, sums)| sums.mean_ms) {
            let ties = sound.partition_point(|(_, sums)| sums.mean_ms <= AS_FAST * fastest);
            sound[..ties].sort_by_key(|(scheme, _)| scheme.resident_bytes);
        }
        sound
    }

    /// Which scheme to take, and why: a sentence each.
    #[must_use]
    pub fn advice(&self) -> Vec<String> {
        let sound = self.sound();
        let Some((best, sums)) = sound.first() else {
            return vec!["No scheme stays within the tolerance; ask for more.".to_owned()];
        };
        let mut said = vec![format!(
            "Take {}: {:.3} ms a frame on average over {} distances on {} and {}, {} B over the bus, {} B on \
             the device, FLIP at most {:.3}.",
            best.variant.label(),
            sums.mean_ms,
            best.steps.len(),
            self.card.name(),
            self.link.name(),
            grouped(sums.bytes, " "),
            grouped(best.resident_bytes, " "),
            sums.error,
        )];
        let full = self
            .schemes
            .iter()
            .find(|scheme| !scheme.variant.has_levels());
        let full = full.filter(|full| full.variant.kind.shows_leaves());
        if let Some(full) = full.filter(|full| full.variant != best.variant) {
            let all = SchemeSums::of(full);
            said.push(format!(
                "Without levels of detail it would be {:.3} ms and {} B on the device: {:.1} times as long.",
                all.mean_ms,
                grouped(full.resident_bytes, " "),
                all.mean_ms / sums.mean_ms.max(f64::MIN_POSITIVE),
            ));
        }
        let least = sound.iter().min_by_key(|(_, sums)| sums.bytes);
        if let Some((scheme, least)) = least.filter(|(scheme, _)| scheme.variant != best.variant) {
            said.push(format!(
                "{} sends least: {} B, at {:.3} ms a frame.",
                scheme.variant.label(),
                grouped(least.bytes, " "),
                least.mean_ms
            ));
        }
        let small = sound.iter().min_by_key(|(scheme, _)| scheme.resident_bytes);
        if let Some((scheme, least)) = small.filter(|(scheme, _)| scheme.variant != best.variant) {
            said.push(format!(
                "{} holds least on the device: {} B, at {:.3} ms a frame.",
                scheme.variant.label(),
                grouped(scheme.resident_bytes, " "),
                least.mean_ms
            ));
        }
        said.extend(self.far_advice(best));
        said
    }

    /// What is faster from some distance on.
    fn far_advice(&self, best: &SchemeFound) -> Option<String> {
        let cards = self
            .schemes
            .iter()
            .filter(|scheme| !scheme.variant.kind.shows_leaves());
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
            scheme.variant.label(),
            frame_ms(card),
            frame_ms(leaf),
            grouped(scheme.resident_bytes, " "),
        ))
    }

    /// A row a scheme.
    #[must_use]
    pub fn table(&self) -> Table {
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
                Cell::Text(scheme.variant.label()),
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
    #[must_use]
    pub fn distance_table(&self) -> Table {
        let numbers = [
            "pixels a side",
            "level",
            "leaves",
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
                    Cell::Text(scheme.variant.label()),
                    Cell::Count(step.side.into()),
                    number(step.level, 3),
                    Cell::Count(step.leaves),
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
    let mut text = report.table().to_text(width);
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
    let schemes = report.schemes.iter().map(|scheme| {
        let sums = SchemeSums::of(scheme);
        let steps = scheme.steps.iter().map(|step| {
            let [bytes, transfers] = traffic(&step.change);
            json!({
                "side": step.side, "level": step.level, "leaves": step.leaves, "flip": step.error,
                "change_payload_bytes": bytes, "change_transfers": transfers,
                "change_ms": change_ms(step), "frame_ms": frame_ms(step),
                "frame_fetch_bytes": step.frames.fetch.payload_bytes / u64::from(COMPARE_VIEWS),
            })
        });
        json!({
            "scheme": scheme.variant.label(),
            "initial_payload_bytes": scheme.initial.upload.payload_bytes,
            "resident_bytes": scheme.resident_bytes,
            "bytes": sums.bytes, "transfers": sums.transfers,
            "mean_frame_ms": sums.mean_ms, "worst_frame_ms": sums.worst_ms, "worst_flip": sums.error,
            "distances": steps.collect::<Vec<Value>>(),
        })
    });
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
        "schemes": schemes.collect::<Vec<Value>>(),
    });
    format!("{document:#}\n")
}

/// Bytes against time, and against what is held: a point a scheme.
fn plots(report: &CompareReport) -> Scatter {
    let sums: Vec<SchemeSums> = report.schemes.iter().map(SchemeSums::of).collect();
    let things = report.schemes.iter().enumerate();
    let things = things.map(|(color, scheme)| Thing {
        name: scheme.variant.label(),
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
        title: "What schemes send, hold and take at the same visible error".to_owned(),
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
                        report.schemes[number].resident_bytes as f64,
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
    let plot = plots(report).to_svg();
    let mut rows = Vec::new();
    let mut images = Vec::new();
    for scheme in &report.schemes {
        let mut row = Vec::new();
        for step in &scheme.steps {
            let picture = PictureView::of(step.shot.clone())?.picture;
            if row.is_empty() {
                let small = shrink(&picture, step.side / THUMBNAIL_SIDE)?;
                images.push(PageImage {
                    caption: format!("{}, FLIP {:.3}", scheme.variant.label(), step.error),
                    png: small.to_small_png()?,
                });
            }
            row.push(shrink(&picture, step.side / SHEET_SIDE)?);
        }
        rows.push(row);
    }
    // Leaf models that are as coarse show the same: one of them will do.
    images.dedup_by(|one, before| one.png == before.png);
    images.truncate(Page::MAX_IMAGES);
    if let Some(sheet) = sheet::of(&rows)? {
        output.write("sheet.png", &sheet.to_small_png()?)?;
    }
    let mut sections = vec![Section::Text(format!(
        "{}, {} leaves, walking away: at each distance every scheme shows the coarsest of its levels whose \
         difference from full detail, FLIP, is at most {}; cards that have none show their finest. Bytes of {STAY} \
         frames a distance. Times are modelled: {}, {}. Foliage alone.",
        report.plant,
        grouped(report.leaves, " "),
        report.tolerance,
        report.card.name(),
        report.link.name()
    ))];
    sections.extend(report.advice().into_iter().map(Section::Text));
    sections.push(Section::Table {
        caption: "Schemes".to_owned(),
        table: report.table(),
    });
    sections.push(Section::Figure(plot.clone()));
    sections.push(Section::Heading(
        "Any two, at the nearest distance".to_owned(),
    ));
    sections.push(Section::Comparison(Comparison::of_ways("scheme", images)));
    sections.push(Section::Table {
        caption: "Distance by distance".to_owned(),
        table: report.distance_table(),
    });
    sections.extend(report.remarks.iter().cloned().map(Section::Text));
    let page = Page {
        title: format!("Levels of detail for {}", report.plant),
        sections,
    };
    output.write("report.html", page.to_html()?.as_bytes())?;
    output.write("plots/schemes.svg", plot.as_bytes())?;
    output.write("compare.csv", report.table().to_csv().as_bytes())?;
    output.write("distances.csv", report.distance_table().to_csv().as_bytes())?;
    output.write("compare.json", compare_json(report).as_bytes())
}

/// Pixels of pictures on the sheet and on the page.
const SHEET_SIDE: u32 = 128;
const THUMBNAIL_SIDE: u32 = 256;
