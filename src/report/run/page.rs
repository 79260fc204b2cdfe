//! `report.html`: a run on one page.

use std::collections::{BTreeMap, BTreeSet};

use super::ledger::{LedgerHead, microseconds};
use super::rows::{
    FETCH_BYTES_PER_LEAF, FrameRow, INDEX_BYTES_PER_LEAF, note, run_notes, run_table,
};
use super::{PathEntry, RunHeader};
use crate::gpu::{Ledger, Link, Stream, Ticks, Traffic};
use crate::report::html::{SMALLER, THIN_SPACE, fitting};
use crate::report::thumbnail::small;
use crate::report::{
    Axis, Cell, Choice, Column, Comparison, Page, PageImage, Picture, Plot, ReportError, Scale,
    Section, Series, Stack, StackLayer, Table, decimal, grouped,
};
use crate::run::Popping;

/// Rows of the table of frames.
const MOST_ROWS: usize = 120;

/// Pictures for the page, evenly chosen from frames that come one after another, however many.
#[derive(Debug)]
pub(super) struct Thumbnails {
    kept: Vec<(u32, Picture)>,
    /// Every so many frames one is kept.
    stride: u64,
    seen: u64,
}

impl Thumbnails {
    pub(super) fn new() -> Self {
        Self {
            kept: Vec::new(),
            stride: 1,
            seen: 0,
        }
    }

    /// Takes a frame; when there are too many, every second goes.
    pub(super) fn add(&mut self, frame: u32, picture: &Picture) -> Result<(), ReportError> {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == Page::MAX_IMAGES {
                self.halve();
            }
            if self.seen.is_multiple_of(self.stride) {
                self.kept.push((frame, small(picture)?));
            }
        }
        self.seen += 1;
        Ok(())
    }

    fn halve(&mut self) {
        self.stride *= 2;
        let kept = std::mem::take(&mut self.kept);
        self.kept = kept.into_iter().step_by(2).collect();
    }

    /// The pictures, each once, with the frames that show it, and which frame shows which.
    fn distinct(self) -> (Vec<Picture>, FrameChoice) {
        let (mut pictures, mut choice) = (Vec::new(), FrameChoice::default());
        for (frame, picture) in self.kept {
            let known = pictures.iter().position(|known| *known == picture);
            let place = known.unwrap_or(pictures.len());
            if known.is_none() {
                pictures.push(picture);
                choice.captions.push(format!("frame {frame}"));
            } else if let Some(caption) = choice.captions.get_mut(place) {
                *caption += &format!(", {frame}");
            }
            choice.frames.push(frame.to_string());
            choice.shows.push(place);
        }
        (pictures, choice)
    }
}

/// The frames of which a page has pictures.
#[derive(Debug, Default)]
struct FrameChoice {
    frames: Vec<String>,
    /// The number of each frame's picture.
    shows: Vec<usize>,
    /// A caption a picture.
    captions: Vec<String>,
}

impl FrameChoice {
    /// The first frame against the last.
    fn comparison(&self, files: Vec<Vec<u8>>) -> Comparison {
        let captions = self.captions.iter().cloned();
        let image = |(caption, png)| PageImage { caption, png };
        Comparison {
            ways: Choice {
                name: String::new(),
                values: vec![String::new()],
            },
            places: Choice {
                name: "frame".to_owned(),
                values: self.frames.clone(),
            },
            shows: vec![self.shows.clone()],
            pictures: captions.zip(files).map(image).collect(),
            begin: [[0, 0], [0, self.frames.len().saturating_sub(1)]],
        }
    }
}

/// What the same uploads and fetches would take on every link.
#[derive(Debug)]
pub(super) struct Links {
    sums: Vec<(Link, Traffic, Ticks)>,
}

impl Links {
    pub(super) fn new() -> Self {
        let zero = |link| (link, Traffic::default(), 0);
        Self {
            sums: Link::ALL.into_iter().map(zero).collect(),
        }
    }

    pub(super) fn add(&mut self, ledger: &Ledger) {
        for transfer in &ledger.transfers {
            let payload_bytes = transfer.payload_bytes;
            for (link, upload, fetch) in &mut self.sums {
                match transfer.stream {
                    Stream::Upload => upload.add(&Traffic {
                        transfers: 1,
                        payload_bytes,
                        wire_bytes: link.wire_bytes(payload_bytes),
                        ticks: link.ticks_down(payload_bytes),
                    }),
                    Stream::Fetch => *fetch += link.ticks_down(payload_bytes),
                    Stream::Readback => {}
                }
            }
        }
    }

    fn table(&self) -> Table {
        let headings = [
            "uploaded, B",
            "transfers",
            "on the wire, B",
            "upload, µs",
            "fetch, µs",
        ];
        let row = |(link, upload, fetch): &(Link, Traffic, Ticks)| {
            let time = |ticks| Cell::Number {
                value: microseconds(ticks),
                digits: 1,
            };
            vec![
                Cell::Text(link.name().to_owned()),
                Cell::Count(upload.payload_bytes),
                Cell::Count(upload.transfers),
                Cell::Count(upload.wire_bytes),
                time(upload.ticks),
                time(*fetch),
            ]
        };
        let columns = headings.into_iter().map(Column::numbers);
        Table {
            columns: [Column::words("link")].into_iter().chain(columns).collect(),
            rows: self.sums.iter().map(row).collect(),
        }
    }
}

/// The page; pictures become smaller until it is as small as a page must be.
pub(super) fn run_page(
    header: &RunHeader,
    initial: &Ledger,
    rows: &[FrameRow],
    path: Option<&PathEntry>,
    links: &Links,
    thumbnails: Thumbnails,
) -> Result<String, ReportError> {
    let before = Section::Text(what_was_run(header, rows));
    let facts = Section::Facts(facts(header, rows));
    let mut after = vec![
        Section::Heading("What crossed the bus".to_owned()),
        Section::Text(note("Before the first frame", &initial.upload)),
    ];
    let notes = run_notes(rows, header.link).into_iter();
    after.extend(notes.chain(path.map(PathEntry::note)).map(Section::Text));
    after.extend(
        cause_stacks(rows)
            .iter()
            .map(|stack| Section::Figure(stack.to_svg())),
    );
    after.extend([
        Section::Figure(bytes_plot(rows).to_svg()),
        Section::Figure(leaves_plot(rows).to_svg()),
        Section::Figure(time_plot(rows).to_svg()),
    ]);
    if rows.iter().any(|row| row.popping.is_some()) {
        after.push(Section::Figure(popping_plot(rows).to_svg()));
    }
    after.extend([
        Section::Heading("Frames".to_owned()),
        Section::Text(
            "Sent: uploads of changes of detail. Beside them what sending the indices of all \
             visible leaves (16 B a leaf) and fetching all from host memory (64 B a leaf) would \
             move. Bus times are modelled."
                .to_owned(),
        ),
        Section::Table {
            caption: String::new(),
            table: run_table(rows, MOST_ROWS),
        },
        Section::Heading("Device memory after the first upload".to_owned()),
        Section::Table {
            caption: String::new(),
            table: resident_table(header),
        },
        Section::Heading("Other links".to_owned()),
        Section::Text(
            "The same transfers of all frames, the view's included, on each link; modelled."
                .to_owned(),
        ),
        Section::Table {
            caption: String::new(),
            table: links.table(),
        },
    ]);
    after.extend(Section::scene(&header.resolved));
    after.push(Section::Text(format!(
        "Scene digest: {}.",
        header.scene_digest
    )));
    let title = format!("{}, {}", header.scene, header.model);
    let (pictures, choice) = thumbnails.distinct();
    fitting(pictures, |files| {
        let mut sections = vec![before.clone()];
        if !files.is_empty() {
            sections.push(Section::Comparison(choice.comparison(files)));
            sections.push(Section::Text(SMALLER.to_owned()));
        }
        sections.push(facts.clone());
        sections.extend(after.iter().cloned());
        Page {
            title: title.clone(),
            sections,
        }
    })
}

/// The few numbers that say the most. Streams stand apart.
fn facts(header: &RunHeader, rows: &[FrameRow]) -> Vec<(String, String)> {
    let sum = FrameRow::sum(rows);
    let count = |count| grouped(count, THIN_SPACE);
    let leaves = rows.iter().map(|row| row.leaves);
    let leaves = match (leaves.clone().min(), leaves.max()) {
        (Some(least), Some(most)) if least < most => format!("{} – {}", count(least), count(most)),
        (_, most) => count(most.unwrap_or(0)),
    };
    let time = |ticks| format!("{}{THIN_SPACE}µs", decimal(microseconds(ticks), 1));
    let bytes = |bytes| format!("{}{THIN_SPACE}B", count(bytes));
    let mut facts = vec![
        ("leaves a frame", leaves),
        (
            "sent for changes of detail",
            bytes(sum.changes.payload_bytes),
        ),
        ("in transfers", count(sum.changes.transfers)),
        ("on the bus, modelled", time(sum.changes.ticks)),
    ];
    if sum.fetch.transfers > 0 {
        facts.push(("fetched by draws", bytes(sum.fetch.payload_bytes)));
        facts.push(("fetching, modelled", time(sum.fetch.ticks)));
    }
    let resident = header.resident.iter().map(|(_, bytes)| bytes).sum();
    facts.push(("device memory", bytes(resident)));
    let named = |(name, value): (&str, String)| (name.to_owned(), value);
    facts.into_iter().map(named).collect()
}

fn what_was_run(header: &RunHeader, rows: &[FrameRow]) -> String {
    let LedgerHead {
        version,
        scene,
        link,
        card,
        size: [width, height],
        samples,
        ..
    } = LedgerHead::of(header);
    let frames = match (rows.first(), rows.last()) {
        (Some(first), Some(last)) if rows.len() > 1 => {
            format!("{} frames, {} to {}", rows.len(), first.frame, last.frame)
        }
        (Some(only), _) => format!("frame {}", only.frame),
        _ => "no frames".to_owned(),
    };
    let model = &header.model;
    let samples = match samples {
        1 => "1 sample".to_owned(),
        _ => format!("{samples} samples"),
    };
    format!(
        "Scene {scene} with model {model}: {frames}, {width} × {height} pixels, {samples} a \
         pixel. Times are modelled for the link {link} and the card {card}. spinney {version}."
    )
}

/// Uploads by cause and, where there are any, fetches by cause: streams of their own.
fn cause_stacks(rows: &[FrameRow]) -> Vec<Stack> {
    let sum = FrameRow::sum(rows);
    let causes: BTreeSet<&String> = sum
        .upload_by_cause
        .keys()
        .chain(sum.fetch_by_cause.keys())
        .collect();
    let stack = |title: &str, of: fn(&FrameRow) -> &BTreeMap<String, u64>| {
        let layer = |(color, cause): (usize, &&String)| {
            let bytes = |row: &FrameRow| of(row).get(*cause).copied().unwrap_or(0);
            StackLayer {
                name: (*cause).clone(),
                color,
                values: rows.iter().map(|row| bytes(row) as f64).collect(),
            }
        };
        let there = |(_, cause): &(usize, &&String)| of(&sum).contains_key(**cause);
        Stack {
            title: title.to_owned(),
            x: Axis {
                label: "frame".to_owned(),
                scale: Scale::Linear,
            },
            label: "bytes".to_owned(),
            places: rows.iter().map(|row| f64::from(row.frame)).collect(),
            layers: causes.iter().enumerate().filter(there).map(layer).collect(),
            size: Stack::WIDE,
        }
    };
    let mut stacks = vec![stack("Uploads of each frame by cause", |row| {
        &row.upload_by_cause
    })];
    if !sum.fetch_by_cause.is_empty() {
        stacks.push(stack("Fetches of each frame by cause", |row| {
            &row.fetch_by_cause
        }));
    }
    stacks
}

/// Uploads by cause, fetches, and what others would have sent.
fn bytes_plot(rows: &[FrameRow]) -> Plot {
    let sum = FrameRow::sum(rows);
    let mut lines: Vec<Series> = sum
        .upload_by_cause
        .keys()
        .map(|cause| {
            let bytes = |row: &FrameRow| row.upload_by_cause.get(cause).copied().unwrap_or(0);
            curve(rows, cause, |row| bytes(row) as f64)
        })
        .collect();
    if sum.fetch.transfers > 0 {
        lines.push(curve(rows, "fetched by draws", |row| {
            row.fetch.payload_bytes as f64
        }));
    }
    lines.push(curve(rows, "16 B a leaf", |row| {
        (INDEX_BYTES_PER_LEAF * row.leaves) as f64
    }));
    lines.push(curve(rows, "64 B a leaf", |row| {
        (FETCH_BYTES_PER_LEAF * row.leaves) as f64
    }));
    plot(
        "Bytes a frame: uploads by cause, and what others would move",
        "bytes",
        Scale::Log,
        lines,
    )
}

fn leaves_plot(rows: &[FrameRow]) -> Plot {
    let line = curve(rows, "leaves", |row| row.leaves as f64);
    plot("Leaves a frame", "leaves", Scale::Linear, vec![line])
}

/// What switches of detail show; frames of which nothing is told have no point.
fn popping_plot(rows: &[FrameRow]) -> Plot {
    let line = |name, pixels: fn(&Popping) -> u64| {
        let value = |row: &FrameRow| row.popping.map_or(f64::NAN, |found| pixels(&found) as f64);
        curve(rows, name, value)
    };
    plot(
        "Popping: pixels that a switch of detail changes, and leaves that come and go",
        "pixels",
        Scale::Linear,
        vec![
            line("changed by the switch alone", |found| found.popped),
            line("toggled", |found| found.toggled),
            line("toggled at full detail", |found| {
                found.toggled_at_full_detail
            }),
            line("toggled beyond full detail", |found| found.toggled_beyond),
        ],
    )
}

fn time_plot(rows: &[FrameRow]) -> Plot {
    let mut lines = vec![curve(rows, "bus", |row| microseconds(row.bus_ticks()))];
    if rows.iter().any(|row| row.gpu_ticks.is_some()) {
        let gpu = |row: &FrameRow| row.gpu_ticks.map_or(f64::NAN, microseconds);
        lines.push(curve(rows, "card", gpu));
    }
    plot("Modelled time a frame", "µs", Scale::Log, lines)
}

fn curve(rows: &[FrameRow], name: &str, value: impl Fn(&FrameRow) -> f64) -> Series {
    let point = |row: &FrameRow| [f64::from(row.frame), value(row)];
    Series {
        name: name.to_owned(),
        points: rows.iter().map(point).collect(),
    }
}

fn plot(title: &str, label: &str, scale: Scale, series: Vec<Series>) -> Plot {
    Plot {
        title: title.to_owned(),
        x: Axis {
            label: "frame".to_owned(),
            scale: Scale::Linear,
        },
        y: Axis {
            label: label.to_owned(),
            scale,
        },
        series,
    }
}

/// Device memory by label, and its sum.
fn resident_table(header: &RunHeader) -> Table {
    let row = |(label, bytes): &(String, u64)| vec![Cell::Text(label.clone()), Cell::Count(*bytes)];
    let mut rows: Vec<Vec<Cell>> = header.resident.iter().map(row).collect();
    let sum = header.resident.iter().map(|(_, bytes)| bytes).sum();
    rows.push(vec![Cell::Text("all".to_owned()), Cell::Count(sum)]);
    Table {
        columns: vec![Column::words("label"), Column::numbers("bytes")],
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream as Noise;

    #[test]
    fn thumbnails_stay_even_however_many_frames_come() {
        let picture = Picture::new(1, 1, vec![9; 4]).unwrap();
        let mut thumbnails = Thumbnails::new();
        for frame in 0..100 {
            thumbnails.add(frame, &picture).unwrap();
        }
        let frames: Vec<u32> = thumbnails.kept.iter().map(|kept| kept.0).collect();
        assert_eq!(frames, (0..100).step_by(8).collect::<Vec<u32>>());
        // They are all the same, so one is enough.
        let (pictures, choice) = thumbnails.distinct();
        assert_eq!((pictures.len(), choice.shows), (1, vec![0; 13]));
        assert!(choice.captions[0].starts_with("frame 0, 8, 16, "));
    }

    #[test]
    fn pages_are_as_small_as_they_must_be() {
        // Noise does not compress: 24 pictures of 300 KiB each, in base64, are too much.
        let mut thumbnails = Thumbnails::new();
        for frame in 0..24 {
            let noise = Noise::new(1, u64::from(frame));
            let bytes = (0..4 * 80_000_u64).map(|index| noise.below(index, 256));
            let rgba = bytes.map(|byte| u8::try_from(byte).unwrap());
            let picture = Picture::new(320, 250, rgba.collect()).unwrap();
            thumbnails.add(frame, &picture).unwrap();
        }
        let header = RunHeader {
            scene: "noise".to_owned(),
            scene_digest: crate::math::Digest([7; 32]),
            model: "full".to_owned(),
            link: Link::ALL[0],
            card: crate::gpu::Card::ALL[0],
            size: [320, 250],
            samples: 4,
            resolved: String::new(),
            resident: Vec::new(),
        };
        let html = run_page(
            &header,
            &Ledger::default(),
            &[],
            None,
            &Links::new(),
            thumbnails,
        )
        .unwrap();
        assert!(
            (1_000_000..Page::MAX_BYTES).contains(&html.len()),
            "{}",
            html.len()
        );
        assert_eq!(html.matches("<img ").count(), 24);
        assert!(html.contains("no frames, 320 × 250 pixels, 4 samples a pixel"));
    }

    #[test]
    fn large_frames_become_small_pictures() {
        let picture = Picture::new(1000, 500, vec![200; 4 * 500_000]).unwrap();
        let mut thumbnails = Thumbnails::new();
        thumbnails.add(7, &picture).unwrap();
        let (frame, small) = &thumbnails.kept[0];
        assert_eq!((*frame, small.width(), small.height()), (7, 500, 250));
    }
}
