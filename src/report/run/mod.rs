//! The folder of a run: frames one after another become pictures, ledgers, states and a page.
//!
//! ```text
//!  header, initial ─create─▶ RunFolder ◀─add── Frame, Frame, …     RunFolder ─finish─▶ out/<scene>/
//!                               │ └─▶ frame-0000.png, .exr; a line of ledger.json, ledger.csv,
//!                               │     ops.jsonl, trace.json
//!                               └─▶ FrameRow, thumbnails ──▶ report.html
//! ```
//!
//! **Invariant.** What is kept of a frame after [`RunFolder::add`] are numbers, and of at most 24
//! frames small pictures. Files tell of the frames that they hold and of nothing else: a folder of
//! some frames says of these what the folder of all says.

mod layers;
mod ledger;
mod ops;
mod page;
mod path;
mod rows;
mod trace;

pub use layers::{NO_NUMBER, frame_layers};
pub use ledger::{
    ComputeEntry, LEDGER_SCHEMA, LedgerEntry, LedgerHead, RunLedger, ShareEntry, TrafficEntry,
    WorkEntry,
};
pub use ops::OpsReader;
pub use path::{PING_PONG_FRAMES, PathEntry};
pub use rows::{FETCH_BYTES_PER_LEAF, FrameRow, INDEX_BYTES_PER_LEAF, run_notes, run_table};

pub(super) use ledger::{json, microseconds};
pub(super) use rows::{VIEW, evenly, fetch_by_cause, note, upload_by_cause};

use std::path::Path;

use self::ops::OpsWriter;
use self::page::{Links, Thumbnails, run_page};
use self::path::PathSum;
use self::trace::Trace;
use super::growing::GrowingFile;
use super::shard::{RunShard, RunShare};
use super::{Layer, OutputFolder, Picture, ReportError, csv_row, encode_exr};
use crate::gpu::{Card, Ledger, Link, nanoseconds};
use crate::math::Digest;
use crate::run::{Frame, PlantFiles};

/// What was run.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunHeader {
    /// The scene's name.
    pub scene: String,
    /// The scene's digest.
    pub scene_digest: Digest,
    /// Model and mode in one word, such as `lodf-slots`.
    pub model: String,
    /// The link.
    pub link: Link,
    /// The card.
    pub card: Card,
    /// Pixels of a frame: width, height.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// Everything that decided the run, as a scene file: becomes `scene.resolved.toml`. Its plants are
    /// those of [`RunFolder::add_plants`].
    pub resolved: String,
    /// Device memory by label before the first frame, largest first.
    pub resident: Vec<(String, u64)>,
}

/// A run's folder that is being written.
#[derive(Debug)]
pub struct RunFolder {
    // Files are closed before the folder goes.
    ledger: GrowingFile,
    transfers: GrowingFile,
    ops: GrowingFile,
    timeline: GrowingFile,
    header: RunHeader,
    initial: Ledger,
    totals: LedgerEntry,
    rows: Vec<FrameRow>,
    path: PathSum,
    states: OpsWriter,
    trace: Trace,
    thumbnails: Thumbnails,
    links: Links,
    shard: Option<RunShard>,
    folder: OutputFolder,
}

impl RunFolder {
    /// Begins the folder that will be `target`; `initial` is what was sent before the first frame.
    ///
    /// # Errors
    ///
    /// As [`OutputFolder::create`], and when a file cannot be written.
    pub fn create(target: &Path, header: RunHeader, initial: &Ledger) -> Result<Self, ReportError> {
        let folder = OutputFolder::create(target)?;
        folder.write("scene.resolved.toml", header.resolved.as_bytes())?;
        let mut ledger = GrowingFile::create(&folder, "ledger.json")?;
        ledger.add(&LedgerHead::of(&header).opening())?;
        let mut transfers = GrowingFile::create(&folder, "ledger.csv")?;
        transfers.add(&csv_row(CSV_COLUMNS))?;
        transfers.add(&csv_rows("initial", initial))?;
        let ops = GrowingFile::create(&folder, "ops.jsonl")?;
        let mut timeline = GrowingFile::create(&folder, "trace.json")?;
        let (trace, opening) = Trace::opening(&header, initial);
        timeline.add(&opening)?;
        Ok(Self {
            ledger,
            transfers,
            ops,
            timeline,
            header,
            initial: initial.clone(),
            totals: LedgerEntry::default(),
            rows: Vec::new(),
            path: PathSum::default(),
            states: OpsWriter::default(),
            trace,
            thumbnails: Thumbnails::new(),
            links: Links::new(),
            shard: None,
            folder,
        })
    }

    /// Says that the frames to come are a share of the run's: all that is counted of them is also
    /// written to `shard.jsonl`, so that [`merge`](super::merge) can join the shares.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn share(&mut self, share: &RunShare) -> Result<(), ReportError> {
        let shard = RunShard::create(&self.folder, (&self.header, &self.initial), share)?;
        self.shard = Some(shard);
        Ok(())
    }

    /// Where the files lie until the end.
    pub(super) fn folder(&self) -> &OutputFolder {
        &self.folder
    }

    /// Writes copies of the files that the plants come from, to which the resolved scene refers: with
    /// them the folder can be run anew wherever it lies, whatever became of the originals.
    ///
    /// # Errors
    ///
    /// When a file cannot be written, or a plant's files lie too deep below one another.
    pub fn add_plants(&self, plants: &PlantFiles) -> Result<(), ReportError> {
        for folder in plants.folders() {
            // Made on the way to a file in it, which is never written.
            self.folder.file(&format!("{folder}/x"))?;
        }
        plants
            .files()
            .try_for_each(|(name, bytes)| self.folder.write(name, bytes))
    }

    /// Writes a frame. Frames come in ascending order.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn add(&mut self, frame: &Frame) -> Result<(), ReportError> {
        let image = &frame.image;
        let picture = Picture::new(image.width, image.height, image.rgba.clone())?;
        let number = frame.frame;
        self.folder
            .write(&format!("frame-{number:04}.png"), &picture.to_png()?)?;
        self.thumbnails.add(number, &picture)?;
        if let Some(shard) = &mut self.shard {
            shard.add(frame)?;
        }

        let entry = LedgerEntry::of(frame);
        let comma = if self.rows.is_empty() { "" } else { "," };
        self.ledger.add(&format!("{comma}\n{}", json(&entry)))?;
        self.totals.add(&entry);
        self.transfers
            .add(&csv_rows(&number.to_string(), &frame.ledger))?;
        self.ops.add(&self.states.line(number, &frame.states))?;
        let row = FrameRow::of(frame);
        self.path.add(frame, &row);
        self.timeline.add(&self.trace.frame(&row, &frame.ledger))?;
        self.links.add(&frame.ledger);
        self.rows.push(row);
        Ok(())
    }

    /// Writes the layers of a frame, as of [`frame_layers`].
    ///
    /// # Errors
    ///
    /// As [`encode_exr`], and when the file cannot be written.
    pub fn add_layers(&mut self, frame: u32, layers: Vec<Layer>) -> Result<(), ReportError> {
        let [width, height] = self.header.size;
        let file = encode_exr(width, height, layers)?;
        self.folder.write(&format!("frame-{frame:04}.exr"), &file)
    }

    /// How detail followed the camera over the frames so far, if there are several.
    #[must_use]
    pub fn path(&self) -> Option<PathEntry> {
        self.path.entry()
    }

    /// The frames so far.
    #[must_use]
    pub fn rows(&self) -> &[FrameRow] {
        &self.rows
    }

    /// Ends all files and puts the folder in its place; answers the frames in numbers.
    ///
    /// # Errors
    ///
    /// When a file cannot be written, as [`OutputFolder::commit`], or when the page is too large even
    /// without pictures.
    pub fn finish(mut self) -> Result<Vec<FrameRow>, ReportError> {
        let initial = LedgerEntry::of_ledger(&self.initial);
        let path = self.path.entry();
        let closing = ledger::closing(&initial, &self.totals, path.as_ref());
        self.ledger.add(&closing)?;
        self.timeline.add(Trace::closing())?;
        for file in [self.ledger, self.transfers, self.ops, self.timeline] {
            file.finish()?;
        }
        if let Some(shard) = self.shard {
            shard.finish()?;
        }
        let page = run_page(
            &self.header,
            &self.initial,
            &self.rows,
            path.as_ref(),
            &self.links,
            self.thumbnails,
        )?;
        self.folder.write("report.html", page.as_bytes())?;
        self.folder.commit()?;
        Ok(self.rows)
    }
}

const CSV_COLUMNS: [&str; 9] = [
    "frame", "stream", "resource", "cause", "id", "ranges", "payload", "wire", "ns",
];

/// One row a transfer; times are rounded up to nanoseconds each for itself.
fn csv_rows(frame: &str, ledger: &Ledger) -> String {
    let row = |transfer: &crate::gpu::Transfer| {
        let id = transfer.cause.id.map_or(String::new(), |id| id.to_string());
        let numbers = [
            transfer.ranges,
            transfer.payload_bytes,
            transfer.wire_bytes,
            nanoseconds(transfer.ticks),
        ];
        let [ranges, payload, wire, time] = numbers.map(|number| number.to_string());
        csv_row([
            frame,
            transfer.stream.name(),
            &transfer.resource,
            transfer.cause.kind,
            &id,
            &ranges,
            &payload,
            &wire,
            &time,
        ])
    };
    ledger.transfers.iter().map(row).collect()
}
