//! Shards: one run or walk shared out among processes, and joined again.
//!
//! ```text
//! run --shard 0/2 ──▶ folder 0 with shard.jsonl ─┐
//! run --shard 1/2 ──▶ folder 1 with shard.jsonl ─┴─merge─▶ the folder of `run`, byte for byte
//! ```
//!
//! `shard.jsonl` holds all that was counted, exactly: first a [head](Head) on a line of its own, then
//! a line a frame, or a line a model and step, one a level that was looked at, and one a picture of the page, which
//! lies beside it in `pictures/`. Joining feeds what it says to the same writers that an unsharded run feeds.
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
use super::{
    OutputFolder, QualitySummary, ReportError, Spread, StepQuality, SweepPictures, SweepQuality,
    ViewQuality,
};
use crate::gpu::Ledger;
use crate::math::{Digest, Digester};
use crate::run::{Appearance, Frame, Shard, Sweep, SweepModel, SweepStep};

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
        /// Whether frames tell of their popping.
        popping: bool,
        /// Whether everything was rasterized and counted.
        exact: bool,
    },
    /// The steps `0..=steps` of a walk.
    Sweep {
        header: Box<SweepHeader>,
        /// As [`SweepShare::scene_digest`].
        scene_digest: Digest,
        /// Whether everything was rasterized and counted.
        exact: bool,
        steps: u32,
        /// How many levels were looked at beyond full detail, if any were.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        looks: Option<u32>,
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

/// A line of a walk: a small picture for its page.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PictureLine {
    /// The digest of the frame that it shows, by which its file is called.
    picture: Digest,
    /// Of the file's bytes.
    file: Digest,
}

impl PictureLine {
    fn of(picture: Digest, png: &[u8]) -> Self {
        let file = Digester::new("spinney.shard picture").bytes(png).finish();
        Self { picture, file }
    }

    /// The file's name in the folder.
    fn name(&self) -> String {
        format!("pictures/{}.png", self.picture)
    }
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
            popping: share.popping,
            exact: share.exact,
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
    /// Whether frames tell of their popping.
    pub popping: bool,
    /// Whether everything is rasterized and counted, or architectural counters only.
    pub exact: bool,
}

/// Which share of a walk is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SweepShare {
    /// Which steps.
    pub shard: Shard,
    /// The digest of the scene with the flags' changes and the digests of its plants: what tells
    /// apart scenes of one name that cost the same.
    pub scene_digest: Digest,
    /// Whether everything is rasterized and counted, or architectural counters only.
    pub exact: bool,
    /// The last step of all shards together.
    pub steps: u32,
    /// How many levels all shards look at beyond full detail, if any.
    pub looks: Option<u32>,
}

/// Writes `shard.jsonl` of a walk, and beside it the pictures for its page.
///
/// # Errors
///
/// When it cannot be written.
pub fn write_sweep_shard(
    folder: &OutputFolder,
    header: &SweepHeader,
    share: SweepShare,
    sweep: &Sweep,
    quality: Option<&SweepQuality>,
    pictures: &SweepPictures,
) -> Result<(), ReportError> {
    let mut file = GrowingFile::create(folder, FILE)?;
    let without_steps = |model: &SweepModel| SweepModel {
        steps: Vec::new(),
        ..model.clone()
    };
    let SweepShare {
        shard,
        scene_digest,
        exact,
        steps,
        looks,
    } = share;
    let job = Job::Sweep {
        header: Box::new(header.clone()),
        scene_digest,
        exact,
        steps,
        looks,
        models: sweep.models.iter().map(without_steps).collect(),
    };
    file.add(&Head::line(shard, job))?;
    for (model, walked) in sweep.models.iter().enumerate() {
        for step in &walked.steps {
            let step = step.clone();
            file.add(&(json(&StepLine { model, step }) + "\n"))?;
        }
    }
    if let Some(quality) = quality {
        let appearances = Appearance::all_of(sweep.models.iter().map(|model| model.variant));
        // Every shard looks at full detail; one tells of it.
        for step in quality.steps.iter().filter(|step| shard.draws(step.step)) {
            let mut known = appearances.iter();
            let place = known.position(|known| *known == step.appearance);
            let line = LookLine::of(quality.plants, place.unwrap_or(0), step);
            file.add(&(json(&line) + "\n"))?;
        }
    }
    for (digest, picture) in pictures.iter() {
        let png = picture.to_png()?;
        let line = PictureLine::of(digest, &png);
        folder.write(&line.name(), &png)?;
        file.add(&(json(&line) + "\n"))?;
    }
    file.finish()
}

/// A line of a walk: a level that was looked at. Measures are their bits, as in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LookLine {
    plants: usize,
    /// The place of the appearance among those of the models.
    appearance: usize,
    look: u32,
    image_digest: Digest,
    frame: [u64; 3],
    frame_ssim: Option<u64>,
    leaf_area: u64,
    covered: [u64; 2],
    silhouette: [u64; 2],
    flip: [u64; 2],
    ssim: [u64; 2],
}

impl LookLine {
    fn of(plants: usize, appearance: usize, step: &StepQuality) -> Self {
        let ViewQuality {
            covered,
            silhouette,
            flip,
            ssim,
        } = step.frame;
        let spread = |spread: Spread| [spread.mean, spread.worst].map(f64::to_bits);
        let foliage = &step.foliage;
        Self {
            plants,
            appearance,
            look: step.step,
            image_digest: step.image_digest,
            frame: [covered, silhouette, flip].map(f64::to_bits),
            frame_ssim: ssim.map(f64::to_bits),
            leaf_area: step.leaf_area.to_bits(),
            covered: spread(foliage.covered),
            silhouette: spread(foliage.silhouette),
            flip: spread(foliage.flip),
            ssim: spread(foliage.ssim),
        }
    }

    fn quality(&self, appearance: Appearance) -> StepQuality {
        let [covered, silhouette, flip] = self.frame.map(f64::from_bits);
        let spread = |bits: [u64; 2]| {
            let [mean, worst] = bits.map(f64::from_bits);
            Spread { mean, worst }
        };
        StepQuality {
            step: self.look,
            appearance,
            image_digest: self.image_digest,
            frame: ViewQuality {
                covered,
                silhouette,
                flip,
                ssim: self.frame_ssim.map(f64::from_bits),
            },
            leaf_area: f64::from_bits(self.leaf_area),
            foliage: QualitySummary {
                covered: spread(self.covered),
                silhouette: spread(self.silhouette),
                flip: spread(self.flip),
                ssim: spread(self.ssim),
            },
        }
    }
}
