//! Shards: one run or walk shared out among processes, and joined again.
//!
//! ```text
//! run --shard 0/2 ──▶ folder 0 with shard.jsonl ─┐
//! run --shard 1/2 ──▶ folder 1 with shard.jsonl ─┴─merge─▶ the folder of `run`, byte for byte
//! ```
//!
//! `shard.jsonl` holds all that was counted, exactly: first a [head](Head) on a line of its own, then
//! a line a frame, or a line a model and step. Joining feeds what it says to the same writers that an
//! unsharded run feeds.
//!
//! **Invariant.** Nothing is joined that was not made from the same input: heads must be equal but for
//! the shard's index, every shard must be there once, and each picture must have the digest that its
//! line says.

mod merge;
mod read;

pub use merge::{Merged, merge};

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::growing::GrowingFile;
use super::run::{RunHeader, json};
use super::sweep::SweepHeader;
use super::{OutputFolder, ReportError};
use crate::gpu::Ledger;
use crate::run::{Frame, Shard, Sweep, SweepModel, SweepStep};

/// The value of `schema` in the first line of `shard.jsonl`.
pub const SHARD_SCHEMA: &str = "spinney.shard/1";

/// The file's name.
const FILE: &str = "shard.jsonl";

/// The first line of the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    schema: String,
    version: String,
    shard: Shard,
    #[serde(flatten)]
    job: Job,
}

/// What is shared out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Job {
    /// The frames of a run.
    Run {
        header: Box<RunHeader>,
        /// What was sent before the first frame.
        initial: Box<Ledger>,
        frames: Range<u32>,
        /// Whether there are layers beside the pictures.
        layers: bool,
    },
    /// The steps `0..=steps` of a walk.
    Sweep {
        header: SweepHeader,
        steps: u32,
        /// The models without their steps.
        models: Vec<SweepModel>,
    },
}

/// A line of a walk: a step of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StepLine {
    model: usize,
    step: SweepStep,
}

impl Head {
    fn line(shard: Shard, job: Job) -> String {
        let head = Self {
            schema: SHARD_SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            shard,
            job,
        };
        json(&head) + "\n"
    }
}

/// The shard's file of a run's folder.
#[derive(Debug)]
pub(super) struct RunShard(GrowingFile);

impl RunShard {
    pub(super) fn create(
        folder: &OutputFolder,
        (header, initial): (&RunHeader, &Ledger),
        share: &RunShare,
    ) -> Result<Self, ReportError> {
        let mut file = GrowingFile::create(folder, FILE)?;
        let job = Job::Run {
            header: Box::new(header.clone()),
            initial: Box::new(initial.clone()),
            frames: share.frames.clone(),
            layers: share.layers,
        };
        file.add(&Head::line(share.shard, job))?;
        Ok(Self(file))
    }

    pub(super) fn add(&mut self, frame: &Frame) -> Result<(), ReportError> {
        self.0.add(&(json(frame) + "\n"))
    }

    pub(super) fn finish(self) -> Result<(), ReportError> {
        self.0.finish()
    }
}

/// Which share of a run is drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunShare {
    /// Which frames of the range.
    pub shard: Shard,
    /// The frames of all shards together.
    pub frames: Range<u32>,
    /// Whether layers are written beside the pictures.
    pub layers: bool,
}

/// Writes `shard.jsonl` of a walk.
///
/// # Errors
///
/// When it cannot be written.
pub fn write_sweep_shard(
    folder: &OutputFolder,
    header: &SweepHeader,
    shard: Shard,
    steps: u32,
    sweep: &Sweep,
) -> Result<(), ReportError> {
    let mut file = GrowingFile::create(folder, FILE)?;
    let without_steps = |model: &SweepModel| SweepModel {
        steps: Vec::new(),
        ..model.clone()
    };
    let job = Job::Sweep {
        header: header.clone(),
        steps,
        models: sweep.models.iter().map(without_steps).collect(),
    };
    file.add(&Head::line(shard, job))?;
    for (model, walked) in sweep.models.iter().enumerate() {
        for step in &walked.steps {
            let step = step.clone();
            file.add(&(json(&StepLine { model, step }) + "\n"))?;
        }
    }
    file.finish()
}
