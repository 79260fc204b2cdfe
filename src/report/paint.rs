//! Painting, measured: contact sheets of the paper's figures 3 to 5, its Table 1, and what levels cost.
//!
//! ```text
//! run::PaintStudy ─▶ PaintReport ─┬─ figure-3.png, figure-4.png, figure-5.png
//!                                 ├─ counts.csv, costs.csv, shimmer.csv, storage.csv
//!                                 └─ report.html
//! ```

use super::thumbnail::shrink;
use super::{Cell, Column, OutputFolder, Page, PageImage, Picture, ReportError, Section, Table};
use crate::gpu::{Card, Ledger, Link, nanoseconds};
use crate::math::index_u32;
use crate::run::{PaintCost, PaintLevel, PaintPart, PaintPicture, PaintStorage, Shimmer};

/// What was painted, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintHeader {
    /// The scene's name.
    pub scene: String,
    /// The plant's name.
    pub plant: String,
    /// Pixels a side of the screen, and the angle that its rows span, in degrees.
    pub camera: ([u32; 2], f32),
    /// From how far levels are drawn at one size, in metres.
    pub near: f32,
    /// The link by which times are modelled.
    pub link: Link,
    /// The card by which times are modelled.
    pub card: Card,
    /// Whether the plant is the paper's, so that its numbers stand beside ours.
    pub is_published: bool,
}

/// What [CQHCVL06](crate::references) prints of its test tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedLevel {
    /// Strokes of branches (figure 3).
    pub branches: u32,
    /// Strokes of leaves (figure 4).
    pub leaves: u32,
    /// Milliseconds of branches alone, and of all (Table 1).
    pub times: [f64; 2],
}

/// The paper's four levels.
pub const PUBLISHED_PAINTING: [PublishedLevel; 4] = [
    PublishedLevel {
        branches: 33_663,
        leaves: 8748,
        times: [66.7, 250.0],
    },
    PublishedLevel {
        branches: 3754,
        leaves: 4156,
        times: [27.8, 125.0],
    },
    PublishedLevel {
        branches: 1159,
        leaves: 2463,
        times: [13.5, 91.0],
    },
    PublishedLevel {
        branches: 363,
        leaves: 761,
        times: [13.5, 66.7],
    },
];

/// Everything that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintReport {
    /// What was painted.
    pub header: PaintHeader,
    /// The levels.
    pub levels: Vec<PaintLevel>,
    /// For each level the number of leaf strokes that a mix of rows by plain thresholds comes to, where the
    /// paper's is wanted; empty where no paper tells.
    pub mixed: Vec<u32>,
    /// Pictures, part by part, level by level.
    pub pictures: Vec<PaintPicture>,
    /// What levels take.
    pub costs: Vec<PaintCost>,
    /// What it takes to keep them.
    pub storage: PaintStorage,
    /// What steps of the camera change.
    pub shimmer: Vec<Shimmer>,
}

fn number(value: f64, digits: usize) -> Cell {
    Cell::Number { value, digits }
}

/// Modelled milliseconds of a frame: what it sends and pulls, then what the card does.
fn milliseconds(frame: &Ledger) -> Cell {
    let ticks = frame
        .gpu_ticks
        .map(|gpu| frame.upload.ticks + frame.fetch.ticks + gpu);
    ticks.map_or(Cell::Missing, |ticks| {
        number(nanoseconds(ticks) as f64 / 1e6, 2)
    })
}

impl PaintReport {
    fn frame(&self, part: PaintPart, level: usize) -> Option<&Ledger> {
        let picture = self
            .pictures
            .iter()
            .find(|picture| picture.part == part && picture.level == level)?;
        Some(&picture.frames[0])
    }

    fn published(&self, level: usize) -> Option<&'static PublishedLevel> {
        let levels = PUBLISHED_PAINTING.get(level);
        levels.filter(|_| self.header.is_published)
    }
}

/// A row a level: from how far, strokes of branches and leaves, the paper's beside ours.
#[must_use]
pub fn paint_count_table(report: &PaintReport) -> Table {
    let columns = [
        "level",
        "distance, m",
        "branches, paper",
        "branches",
        "branches, each as seen",
        "leaves, paper",
        "leaves, row totals",
        "leaves, mixed rows",
        "leaves wanted there",
        "all, paper",
        "all",
    ];
    let rows = report.levels.iter().enumerate().map(|(level, found)| {
        let paper = report.published(level);
        let count = |count: Option<u32>| count.map_or(Cell::Missing, |n| Cell::Count(n.into()));
        vec![
            Cell::Count(level as u64),
            number(found.distance.into(), 2),
            count(paper.map(|paper| paper.branches)),
            Cell::Count(found.strokes[1].into()),
            Cell::Count(found.seen_branches.into()),
            count(paper.map(|paper| paper.leaves)),
            Cell::Count(found.strokes[0].into()),
            count(report.mixed.get(level).copied()),
            Cell::Count(found.wanted_leaves.into()),
            count(paper.map(|paper| paper.branches + paper.leaves)),
            Cell::Count(u64::from(found.strokes[0]) + u64::from(found.strokes[1])),
        ]
    });
    Table {
        columns: columns.into_iter().map(Column::numbers).collect(),
        rows: rows.collect(),
    }
}

/// Table 1: modelled times of branches alone and of all strokes from near, with the samples that strokes
/// cover.
#[must_use]
pub fn paint_time_table(report: &PaintReport) -> Table {
    let columns = [
        "level",
        "branches, paper ms",
        "branches, ms",
        "branches, samples",
        "all, paper ms",
        "all, ms",
        "all, samples",
        "samples a stroke",
    ];
    let rows = report.levels.iter().enumerate().map(|(level, found)| {
        let paper = report.published(level).map(|paper| paper.times);
        let of = |part| report.frame(part, level);
        let work = |frame: Option<&Ledger>| frame?.work.map(|work| work.covered);
        let covered = |part| work(of(part)).map_or(Cell::Missing, Cell::Count);
        let time = |part| of(part).map_or(Cell::Missing, milliseconds);
        let told = |which: usize| paper.map_or(Cell::Missing, |times| number(times[which], 1));
        let strokes = f64::from(found.strokes[0] + found.strokes[1]).max(1.0);
        vec![
            Cell::Count(level as u64),
            told(0),
            time(PaintPart::Branches),
            covered(PaintPart::Branches),
            told(1),
            time(PaintPart::Whole),
            covered(PaintPart::Whole),
            work(of(PaintPart::Whole))
                .map_or(Cell::Missing, |covered| number(covered as f64 / strokes, 1)),
        ]
    });
    Table {
        columns: columns.into_iter().map(Column::numbers).collect(),
        rows: rows.collect(),
    }
}

/// A row a mode and level: what the change to it sends, by cause, and what a frame sends and pulls.
#[must_use]
pub fn paint_cost_table(report: &PaintReport) -> Table {
    let numbers = [
        "level",
        "strokes",
        "ranges, B",
        "count, B",
        "order, B",
        "fetched a frame, B",
        "frame, ms",
    ];
    let rows = report.costs.iter().map(|cost| {
        let of = |ledger: &Ledger, cause: &str| {
            let share = ledger.by_cause.get(cause);
            Cell::Count(share.map_or(0, |share| share.payload_bytes))
        };
        let strokes = report.levels.get(cost.level).map_or(0, |level| {
            u64::from(level.strokes[0]) + u64::from(level.strokes[1])
        });
        vec![
            Cell::Text(cost.kind.label()),
            Cell::Count(cost.level as u64),
            Cell::Count(strokes),
            of(&cost.change, "stroke-ranges"),
            of(&cost.change, "draw-count"),
            of(&cost.frame, "stroke-order"),
            Cell::Count(cost.frame.fetch.payload_bytes),
            milliseconds(&cost.frame),
        ]
    });
    Table {
        rows: rows.collect(),
        columns: std::iter::once(Column::words("mode"))
            .chain(numbers.into_iter().map(Column::numbers))
            .collect(),
    }
}

/// What it takes to keep all levels, implicitly and as copies.
#[must_use]
pub fn paint_storage_table(report: &PaintReport) -> Table {
    let PaintStorage { leaves, branches } = report.storage;
    let all = [leaves[0] + branches[0], leaves[1] + branches[1]];
    let rows = [("leaves", leaves), ("branches", branches), ("both", all)];
    let rows = rows.map(|(what, [implicit, copied])| {
        vec![
            Cell::Text(what.to_owned()),
            Cell::Count(implicit),
            Cell::Count(copied),
            number(implicit as f64 / (copied as f64).max(1.0), 3),
        ]
    });
    Table {
        columns: std::iter::once(Column::words("strokes of"))
            .chain(["implicit, B", "copies of levels, B", "share"].map(Column::numbers))
            .collect(),
        rows: rows.to_vec(),
    }
}

/// What steps of the camera change.
#[must_use]
pub fn paint_shimmer_table(report: &PaintReport) -> Table {
    let numbers = [
        "step, degrees",
        "mean change, of 255",
        "worst step",
        "pixels changed by 1/8, %",
    ];
    let rows = report.shimmer.iter().map(|found| {
        vec![
            Cell::Text(found.subject.name().to_owned()),
            number(found.degrees.into(), 2),
            number(found.mean, 3),
            number(found.worst, 3),
            number(100.0 * found.changed, 2),
        ]
    });
    Table {
        rows: rows.collect(),
        columns: std::iter::once(Column::words("subject"))
            .chain(numbers.into_iter().map(Column::numbers))
            .collect(),
    }
}

/// What the tables say, from what camera.
#[must_use]
pub fn paint_notes(report: &PaintReport) -> Vec<String> {
    let header = &report.header;
    let ([width, height], angle) = header.camera;
    let mut notes = vec![format!(
        "The camera: {width} × {height} pixels, {angle}° from top to bottom, looking at the plant's middle. \
         Levels are drawn at one size from {:.2} m, and at true size from the distances of the table, at which \
         branch strokes are as many as they are; times are those of the one size, \
         modelled for {} on {}: what a frame sends and pulls, then what the card does.",
        header.near,
        header.card.name(),
        header.link.name(),
    )];
    let misses = |counts: &dyn Fn(usize) -> Option<u32>| {
        let levels = PUBLISHED_PAINTING.iter().enumerate();
        levels.fold(0, |sum, (level, paper)| {
            sum + counts(level).map_or(0, |found| found.abs_diff(paper.leaves))
        })
    };
    if header.is_published && !report.mixed.is_empty() {
        let rows = misses(&|level| report.levels.get(level).map(|level| level.strokes[0]));
        let mixed = misses(&|level| report.mixed.get(level).copied());
        let fits = if rows <= mixed {
            "totals of rows"
        } else {
            "mixtures of rows"
        };
        notes.push(format!(
            "Figure 4 read as totals of rows misses the paper's four numbers by {rows} strokes together, read \
             as mixtures of rows with plain thresholds by {mixed}: it shows {fits}."
        ));
    }
    notes
}

/// Everything for a terminal of so many columns.
#[must_use]
pub fn paint_text(report: &PaintReport, width: usize) -> String {
    let mut text = String::new();
    for (caption, table) in tables(report) {
        text.push_str(&format!("{caption}\n{}\n", table.to_text(width)));
    }
    for note in paint_notes(report) {
        text.push_str(&note);
        text.push('\n');
    }
    text
}

fn tables(report: &PaintReport) -> Vec<(&'static str, Table)> {
    let mut tables = vec![
        ("Strokes (figures 3 to 5)", paint_count_table(report)),
        ("Times (Table 1)", paint_time_table(report)),
        ("Changes of level", paint_cost_table(report)),
        ("Storage", paint_storage_table(report)),
    ];
    if !report.shimmer.is_empty() {
        tables.push(("Steps of the camera", paint_shimmer_table(report)));
    }
    tables
}

/// Writes everything into a folder.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_painting(folder: &OutputFolder, report: &PaintReport) -> Result<(), ReportError> {
    for (name, table) in [
        ("counts.csv", paint_count_table(report)),
        ("times.csv", paint_time_table(report)),
        ("costs.csv", paint_cost_table(report)),
        ("storage.csv", paint_storage_table(report)),
        ("shimmer.csv", paint_shimmer_table(report)),
    ] {
        if !table.rows.is_empty() {
            folder.write(name, table.to_csv().as_bytes())?;
        }
    }
    let mut images = Vec::new();
    for (part, name, caption) in [
        (
            PaintPart::Branches,
            "figure-3",
            "Branches at all levels, at one size",
        ),
        (
            PaintPart::Leaves,
            "figure-4",
            "Leaves at all levels, at one size; strokes that stand for several leaves in red",
        ),
        (
            PaintPart::Whole,
            "figure-5",
            "The whole tree at all levels: at one size, and as it is seen from where each is wanted",
        ),
    ] {
        if let Some(sheet) = sheet(report, part)? {
            let png = sheet.to_small_png()?;
            folder.write(&format!("{name}.png"), &png)?;
            images.push(PageImage {
                caption: caption.to_owned(),
                png,
            });
        }
    }
    let mut sections: Vec<Section> = images
        .into_iter()
        .map(|image| Section::Images(vec![image]))
        .collect();
    sections.extend(tables(report).into_iter().map(|(caption, table)| {
        let caption = caption.to_owned();
        Section::Table { caption, table }
    }));
    sections.extend(paint_notes(report).into_iter().map(Section::Text));
    let page = Page {
        title: format!("{}: painted", report.header.scene),
        sections,
    };
    folder.write("report.html", page.to_html()?.as_bytes())
}

/// Pixels of a cell's side: larger pictures are made smaller by a whole factor.
const CELL: u32 = 600;

/// White pixels between cells.
const GAP: u32 = 8;

/// The pictures of a part beside each other; of the whole tree a second row, at true size.
fn sheet(report: &PaintReport, part: PaintPart) -> Result<Option<Picture>, ReportError> {
    let pictures = report
        .pictures
        .iter()
        .filter(|picture| picture.part == part);
    let views = if part == PaintPart::Whole { 2 } else { 1 };
    let mut rows: Vec<Vec<Picture>> = vec![Vec::new(); views];
    for picture in pictures {
        for (row, image) in rows.iter_mut().zip(&picture.images) {
            let full = Picture::new(image.width, image.height, image.rgba.clone())?;
            let factor = image.width.max(image.height).div_ceil(CELL);
            row.push(shrink(&full, factor)?);
        }
    }
    let Some(first) = rows[0].first() else {
        return Ok(None);
    };
    let [across, down] = [first.width() + GAP, first.height() + GAP];
    let width = across * index_u32(rows[0].len()) - GAP;
    let height = down * index_u32(rows.len()) - GAP;
    let mut rgba = vec![u8::MAX; 4 * width as usize * height as usize];
    for (row, cells) in (0..).zip(&rows) {
        for (column, cell) in (0..).zip(cells) {
            let lines = cell.rgba().chunks_exact(4 * cell.width() as usize);
            for (y, line) in (row * down..).zip(lines) {
                let at = 4 * (y as usize * width as usize + (column * across) as usize);
                rgba[at..at + line.len()].copy_from_slice(line);
            }
        }
    }
    Picture::new(width, height, rgba).map(Some)
}
