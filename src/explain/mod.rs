//! Why: what a pixel of a run shows, and where two runs part.
//!
//! ```text
//!  out/x ─RecordedRun::read─▶ RecordedRun ─┬─ explain_pixel ─▶ PixelReport   leaf, cluster, collapse, rivals
//!    scene, plants, states, ledger         │
//!  out/y ─RecordedRun::read─▶ RecordedRun ─┴─ explain_runs ──▶ RunsReport    asked, leaves, collapses,
//!                                                                            transfers, bytes, pixels
//! ```
//!
//! A run's folder says all that decided it, so it is simply run again: nothing here is guessed from
//! pictures. Whether the frames that come of it are those of the ledger is checked, and told.
//!
//! **Invariant.** Nothing is written and nothing printed; what is told is a function of the folders'
//! contents, and serializes under [`EXPLAIN_SCHEMA`].

mod asked;
mod buffers;
mod compare;
mod face;
mod leaf;
mod leaves;
mod operations;
mod pixel;
mod pixels;
mod replay;
mod rivals;
mod sequences;
mod summary;
mod trunk;
mod trunks;
mod uploads;

pub use asked::{AskedDifference, PlantFileDifference};
pub use buffers::{BufferDifference, Insertion, RecordDifference};
pub use compare::{FirstDifference, RunsReport, SideReport, explain_runs};
pub use face::FaceStory;
pub use leaf::{ClusterStory, CollapseStory, LeafStory, MaterialStory, VertexStory};
pub use leaves::{LeafPlace, MovedLeaf, PlantDifference};
pub use operations::{OperationDifference, OperationSide};
pub use pixel::{ColourStory, PixelPlace, PixelReport, TreeStory, explain_pixel};
pub use pixels::FramePixels;
pub use replay::{RecordedRun, Replay, ReplayedFrame};
pub use rivals::{Fate, Rival, SampleStory, Verdict};
pub use sequences::{ClusterPlace, CollapsePlace, SequenceDifference};
pub use trunk::{BranchStory, TrunkLevelStory, TrunkStory, VertexCollapseStory};
pub use trunks::{LevelDifference, TrunkDifference, VertexCollapsePlace};
pub use uploads::UploadStory;

use std::path::PathBuf;

use crate::document::DocumentError;
use crate::report::ReportError;
use crate::run::RunError;
use crate::scene::SceneError;

/// The value of `schema` in reports.
pub const EXPLAIN_SCHEMA: &str = "spinney.explain/1";

/// The most entries of one list in a report; how many there are stands beside it.
pub const MAX_LISTED: usize = 10_000;

/// Why nothing can be explained.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExplainError {
    /// A folder is no run's.
    #[error("{}: {message}", folder.display())]
    NotARun {
        /// The folder.
        folder: PathBuf,
        /// What is missing or wrong, and what would be right.
        message: String,
    },
    /// A file of the run cannot be read.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Its scene says something wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It cannot be run again.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A line of its states or a picture says something that cannot be.
    #[error("{}: {source}", folder.display())]
    Report {
        /// The run's folder.
        folder: PathBuf,
        /// What is wrong.
        source: ReportError,
    },
    /// The run does not have the frame.
    #[error("frame {frame} is not in the run, which has {known}")]
    Frame {
        /// The frame that was asked for.
        frame: u32,
        /// The frames that it has, in words.
        known: String,
    },
    /// The picture does not have the pixel.
    #[error("pixel {},{} lies outside of the picture of {} × {}", pixel[0], pixel[1], size[0], size[1])]
    Pixel {
        /// The pixel that was asked for: column, row.
        pixel: [u32; 2],
        /// Columns and rows.
        size: [u32; 2],
    },
}

/// The first of a list, and how many there are.
fn bounded<T>(mut list: Vec<T>) -> (u64, Vec<T>) {
    let count = list.len() as u64;
    list.truncate(MAX_LISTED);
    (count, list)
}
