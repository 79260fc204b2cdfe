//! glTF 2.0, in and out: trees of other programs as plants, plants for other programs.
//!
//! ```text
//!  .glb, .gltf ─container─▶ JSON + bytes ─scan, parse─▶ document ─scene─▶ placed primitives
//!                                                          │                   │
//!                                        our own extras ◀──┴──▶ none, or edited│
//!                                              │                               ▼
//!                                              ▼                     cards? ─▶ foliage groups
//!                                         Plant, exact               rest  ─▶ trunk mesh
//!
//!  Plant ─export_glb─▶ .glb: meshes that any viewer draws, and `extras.spinney` with the rest
//! ```
//!
//! glTF has +Y up and metres, as [`Plant`] has; only the placement of nodes is applied.
//!
//! **Invariants.** No byte of a file is believed before it is checked: lengths, offsets and counts
//! against what is there, indices against what they name, in checked arithmetic. Memory stays in
//! proportion to the file and below stated limits. Nothing is dropped, guessed or left out without
//! an entry in the [`ImportReport`]. A plant that was written by [`export_glb`] comes back with the
//! same [`Plant::digest`].

mod accessor;
mod buffers;
mod cards;
mod container;
mod error;
mod export;
mod foliage;
mod import;
mod material;
mod native;
mod placement;
mod record;
mod report;
mod scan;
mod scene;
mod sources;
mod surface;
mod trunk;
mod uri;

#[cfg(test)]
mod tests;

pub use error::{ExportError, ImportError};
pub use export::export_glb;
pub use import::{import, import_bytes};
pub use report::{ImportReport, ReportEntry, ReportKind};
pub use sources::{PlantSources, read_sources};

use super::Plant;
use error::Fault;
use material::Materials;

/// The most bytes that one file, and all buffers of one document together, may have. Also the
/// most that is written: what is written can be read.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// The most objects in a document's JSON: some 500 bytes of memory each.
pub const MAX_JSON_OBJECTS: u64 = 1 << 19;

/// The most values of any kind in a document's JSON.
pub const MAX_JSON_VALUES: u64 = 1 << 24;

/// The most primitives that a scene may place, counting each placement of a mesh.
pub const MAX_PLACED_PRIMITIVES: usize = 1 << 20;

/// The most triangle corners that a foreign scene may place, counting each placement of a mesh:
/// some 80 bytes of memory each. What spinney wrote is bounded by its bytes alone.
pub const MAX_CORNERS: u64 = 1 << 25;

/// The most texels that all images of a document may have together.
pub const MAX_TEXELS: u64 = 1 << 28;

/// The most groups of cards, and the most groups of other leaves, that one material may get.
pub const MAX_GROUPS_PER_MATERIAL: usize = 64;

/// What the user says about a file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ImportOptions {
    /// What is foliage: names of nodes (with all that hangs below them), meshes or materials, or
    /// primitives as `MESH#INDEX`. If there are any, nothing is guessed, and all else is wood.
    pub foliage: Vec<String>,
}

/// A plant, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The plant.
    pub plant: Plant,
    /// What was counted, guessed, repaired and left out on the way.
    pub report: ImportReport,
}
