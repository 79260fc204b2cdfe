//! Reports: what people get to see and to keep.
//!
//! ```text
//! frames ──▶ Picture ──PNG──┐                     ┌─▶ OutputFolder ──commit──▶ out/<scene>/
//! layers ──▶ EXR            ├─▶ Page ──HTML───────┤
//! ledger ──▶ Table ─────────┤   Plot ──SVG────────┤
//!            text, CSV      └─────────────────────┘
//! ```
//!
//! Of these pieces [`RunFolder`] makes what `run` leaves, [`write_sweep`] and [`write_bytes`] what `sweep`
//! leaves, and [`storage_report`] what `storage` prints. [`QualityMeter`] judges pictures of levels,
//! [`StandInMeter`] those of what stands in for leaves; [`write_stand_ins`] makes what `stand-ins` leaves.
//!
//! **Invariant.** The bytes of a report are a function of what is reported: nothing in them names
//! a host, path, clock, thread or the order in which things were done. A folder is there whole or
//! not at all, and nothing is replaced that spinney did not write.

mod axis;
mod branches;
mod bytes;
mod chain;
mod channels;
mod compare;
mod diff;
mod file;
mod folder;
mod growing;
mod html;
mod image;
mod judge;
mod number;
mod paint;
mod parallax;
mod plot;
mod quality;
mod run;
mod scatter;
mod shard;
mod sheet;
mod stack;
mod staging;
mod stand_ins;
mod storage;
mod sweep;
mod table;
mod thumbnail;
mod transparency;

pub use axis::{Axis, Scale};
pub use branches::{
    BranchReport, branch_level_table, branch_mode_table, branch_step_table, branch_text, edge_plot,
    method_table, write_branches,
};
pub use bytes::{
    BYTES_SCHEMA, ByteReport, bytes_csv, bytes_json, bytes_markdown, bytes_page, bytes_plots,
    bytes_text, write_bytes,
};
pub use chain::{BUILD_SCHEMA, ChainReport, chain_json, chain_text, write_chain};
pub use channels::{Channel, ImageFile, SampleKind};
pub use compare::{
    COMPARE_SCHEMA, CompareReport, STAY, SchemeSums, compare_json, compare_text, write_compare,
};
pub use diff::{
    ChannelDifference, ChannelDifferences, DIFF_SCHEMA, DiffFolder, Difference, FieldDifference,
    FileDifference, FileState, Flip, FlipReference, FrameDifference, ImageDifference,
    LookDifference, Metrics, RunDifference, SizeMismatch, flip, ssim, triptych,
};
pub use file::write_file;
pub use folder::{MARKER, OutputFolder};
pub use html::{Choice, Comparison, Page, PageImage, Section};
pub use image::{Layer, LayerSamples, Picture, encode_exr, encode_png};
pub use judge::FlipWhereShown;
pub use number::{decimal, grouped, hundredths};
pub use paint::{
    PUBLISHED_PAINTING, PaintHeader, PaintReport, PublishedLevel, paint_cost_table,
    paint_count_table, paint_notes, paint_shimmer_table, paint_storage_table, paint_text,
    paint_time_table, write_painting,
};
pub use parallax::{PARALLAX_SCHEMA, parallax_json, parallax_table, parallax_text, write_parallax};
pub use plot::{Plot, Series};
pub use quality::{
    PictureView, QualityMeter, QualitySummary, Spread, StepQuality, SweepQuality, ViewQuality,
};
pub use run::{
    ComputeEntry, FETCH_BYTES_PER_LEAF, FrameRow, INDEX_BYTES_PER_LEAF, LEDGER_SCHEMA, LedgerEntry,
    LedgerHead, NO_NUMBER, OpsReader, PING_PONG_FRAMES, PathEntry, RunFolder, RunHeader, RunLedger,
    ShareEntry, TrafficEntry, WorkEntry, frame_layers, run_notes, run_table,
};
pub use scatter::{Panel, Point, Scatter, Thing};
pub use shard::{Merged, RunShare, SHARD_SCHEMA, SweepShare, merge, write_sweep_shard};
pub use stack::{Stack, StackLayer};
pub use stand_ins::{
    Crossover, EqualDirect, STAND_IN_SCHEMA, StandInHeader, StandInMeter, StandInQuality,
    StandInReport, StepChange, SwitchQuality, TextureQuality, TextureReport, crossover,
    equal_direct, stand_in_cost_table, stand_in_json, stand_in_notes, stand_in_plots,
    stand_in_table, stand_in_text, switch_table, texture_table, write_stand_ins,
};
pub use storage::{
    Accounting, FaceCounts, LeafCounts, ModelStorage, PrintedSize, STORAGE_SCHEMA, StorageReport,
    TrunkStorage, is_paper_tree, storage_report,
};
pub use sweep::{
    SWEEP_SCHEMA, SweepHeader, SweepPictures, quality_notes, quality_plots, quality_table,
    sweep_csv, sweep_json, sweep_markdown, sweep_notes, sweep_page, sweep_plots, sweep_table,
    sweep_text, write_sweep,
};
pub use table::{Align, Cell, Column, Table, csv_row};
pub use transparency::{transparency_table, transparency_text, write_transparency};

use std::path::{Path, PathBuf};

/// Why a report could not be made or an image not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file or folder cannot be written.
    #[error("cannot write {}: {cause}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        #[source]
        cause: std::io::Error,
    },
    /// The path of a folder leads through a file.
    #[error("cannot write {}: {} is a file, wanted a folder", path.display(), file.display())]
    NoFolder {
        /// The folder that was asked for.
        path: PathBuf,
        /// The file in its way.
        file: PathBuf,
    },
    /// The folder holds something that is not ours to replace.
    #[error(
        "cannot write {}: it holds {found}, which spinney did not write; wanted a new or empty \
         folder, or one from an earlier run",
        path.display()
    )]
    Foreign {
        /// The folder that was asked for.
        path: PathBuf,
        /// What was found there, relative to it.
        found: String,
    },
    /// A file of the report would lie outside of its folder.
    #[error("{name:?} is no name for a file of a report, wanted a relative path below its folder")]
    Name {
        /// The name that was asked for.
        name: String,
    },
    /// An image file cannot be read: a fault of the input, not of writing.
    #[error("{}: {message}", file.display())]
    Image {
        /// The file.
        file: PathBuf,
        /// What is wrong with it, and what would be right.
        message: String,
    },
    /// A folder does not hold a run: a fault of the input.
    #[error("{}: no whole run folder: {message}", folder.display())]
    Run {
        /// The folder.
        folder: PathBuf,
        /// What is missing or wrong.
        message: String,
    },
    /// A layer of an EXR file has a name that no channel can have, or one that another has.
    #[error(
        "{name:?} is no name for a layer, wanted 1 to 31 printable ASCII characters, each name once"
    )]
    LayerName {
        /// The name that was asked for.
        name: String,
    },
    /// An encoder refuses what it should take.
    #[error("cannot encode {format}: {message}")]
    Encode {
        /// The format.
        format: &'static str,
        /// What the encoder says.
        message: String,
    },
    /// Samples do not fill an image, or its sides are out of range.
    #[error("{what}: {found} samples for {width} × {height} pixels, wanted {wanted}")]
    Samples {
        /// The image or layer.
        what: String,
        /// How many samples there are.
        found: usize,
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// What would be right.
        wanted: String,
    },
    /// Folders of shards cannot be joined: a fault of the input.
    #[error("{}{}: {message}", file.display(), at_line(*line))]
    Shard {
        /// The file, or the folder.
        file: PathBuf,
        /// The line, from 1; 0 for all of it.
        line: usize,
        /// What is missing or wrong.
        message: String,
    },
    /// A line of `ops.jsonl` says something that cannot be.
    #[error("ops.jsonl:{line}: {message}")]
    Ops {
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        message: String,
    },
    /// A report would be larger than it may.
    #[error("{what}: {found} exceed the limit of {limit}")]
    TooLarge {
        /// What was counted.
        what: &'static str,
        /// How much there is.
        found: usize,
        /// How much there may be.
        limit: usize,
    },
}

/// `:7`, or nothing for a whole file.
fn at_line(line: usize) -> String {
    match line {
        0 => String::new(),
        line => format!(":{line}"),
    }
}

impl ReportError {
    /// Whether the output cannot be written, as opposed to a fault of the input.
    #[must_use]
    pub fn is_write(&self) -> bool {
        matches!(
            self,
            Self::Write { .. } | Self::NoFolder { .. } | Self::Foreign { .. }
        )
    }

    fn write(path: &Path, cause: std::io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            cause,
        }
    }
}
