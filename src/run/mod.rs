//! The frame loop: a scene, its plants, a model and a device become frames and their ledgers.
//!
//! ```text
//! Scene ─World::build─▶ World ─Session::new─▶ Session ─┬─ frame(n): select, commit, draw, count
//!            (offline)           (uploads)             └─▶ Frame { image, ledger, change, states }
//! ```
//!
//! **Invariant.** What a frame shows and counts depends on the scene and the frame's number alone:
//! every session commits every frame in order, also those that it does not draw.

mod branches;
mod bytes;
mod cache;
mod chain;
mod collapse_file;
mod compare;
mod crowns;
mod export;
mod frame;
mod looks;
mod mass;
mod methods;
mod options;
mod paint;
mod parallax;
mod plants;
mod popping;
mod progress;
mod selector;
mod session;
mod shadow;
mod shard;
mod stand_in_switches;
mod stand_in_textures;
mod stand_ins;
mod studio;
mod sweep;
mod transparency;
mod trunks;
mod views;
mod world;

pub use branches::{
    BranchLook, BranchModeCost, BranchStep, BranchStudy, SkeletonLine, StudyLevel, StudyWay,
    branch_looks, branch_modes, branch_steps, edge_curves, helix,
};
pub use bytes::{ByteOptions, ModelBytes, PlantBytes, StepBytes, StepTraffic, bytes};
pub use cache::{CacheLimit, ModelCache};
pub use chain::{ChainOptions, LodChain, Rung, lod_chain};
pub use collapse_file::{COLLAPSE_SCHEMA, collapse_file};
pub use compare::{
    COMPARE_VIEWS, CompareOptions, Compared, Judge, LeftOut, Scheme, SchemeFound, SchemeStep,
    Verdict, WalkAway, compare,
};
pub use crowns::CrownStore;
pub use export::{FrameExport, camera_json, export_frame};
pub use frame::Frame;
pub use looks::{Appearance, Look, LookOptions, Subject, looked_at, looks};
pub use mass::{Mass, mass};
pub use methods::{Method, MethodFound, methods};
pub use options::SessionOptions;
pub use paint::{
    PaintCost, PaintLevel, PaintPart, PaintPicture, PaintStorage, PaintStudy, Shimmer,
    ShimmerSubject, shimmer,
};
pub use parallax::{
    FlowPicture, FlowPixel, Parallax, ParallaxDistance, ParallaxMeasure, ParallaxOptions,
    ParallaxScale, ParallaxSubject, PixelSpread, parallax,
};
pub use plants::{MAX_PLANT_FILE_BYTES, PlantFiles};
pub use popping::{PopMeter, Popping};
pub use progress::{Progress, Silent};
pub use session::{Owner, Session};
pub use shard::Shard;
pub use stand_in_switches::{SwitchLook, level_switches, switched_levels};
pub use stand_in_textures::{
    TextureCost, TextureFound, TextureLook, TextureSetting, texture_looks,
};
pub use stand_ins::{
    CURVE_VIEWS, ClusterLook, CurvePoint, Leaves, StandIn, StandInCost, StandInFound, StandInLook,
    StandInOptions, ViewScale, stand_ins,
};
pub use studio::STUDIO_SKY;
pub use sweep::{Sweep, SweepModel, SweepOptions, SweepStep, Variant, finest, sweep, sweep_seen};
pub use transparency::{TransparencyLook, TransparencyWay, transparency_looks, transparency_ways};
pub use views::{Shot, VIEW_SIDE, Views, corner_directions, directions};
pub use world::{StandingGrove, StandingTree, World, crown};

use crate::document::DocumentError;
use crate::gpu::GpuError;
use crate::math::Digest;
use crate::plant::GrowError;
use crate::plant::gltf::ExportError;
use crate::plant::import::ImportError;

/// Why a run cannot be.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// A species file says something wrong.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A species cannot grow as it says.
    #[error("{species}: {source}")]
    Grow {
        /// The species file.
        species: String,
        /// Why.
        source: GrowError,
    },
    /// A plant file cannot be imported.
    #[error(transparent)]
    Import(#[from] ImportError),
    /// A frame is too much for a file.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// The device refused something.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A plant is not the one that the scene pins.
    #[error("plant {name:?} has digest {found}, but the scene wants {wanted}")]
    Plant {
        /// The plant.
        name: String,
        /// Its digest.
        found: Digest,
        /// The digest in the scene.
        wanted: Digest,
    },
    /// The plants' files are more than a run keeps copies of.
    #[error("the plants' files have {found} bytes or more, at most {limit} are copied to a run")]
    PlantFiles {
        /// Bytes when counting stopped.
        found: u64,
        /// How many there may be.
        limit: u64,
    },
    /// The trees of a scene are too much together.
    #[error("{what}: {found} up to tree {tree} exceed the limit of {limit}")]
    TooMany {
        /// What was counted.
        what: &'static str,
        /// The tree, from 0, with which it became too much.
        tree: usize,
        /// How many there were then.
        found: u64,
        /// How many there may be.
        limit: u64,
    },
    /// A name in the scene means nothing here.
    #[error("{what} {found:?} is unknown; known are {known}")]
    Name {
        /// The key of the scene, such as `device.link`.
        key: &'static str,
        /// What is named.
        what: &'static str,
        /// The name.
        found: String,
        /// All names.
        known: String,
    },
}
