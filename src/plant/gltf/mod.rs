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
//!  levels of detail ─export_chain─▶ .glb: each a node, with MSFT_lod
//!  meshes at their places ─export_instances─▶ .glb: what a frame draws, for other renderers
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
mod chain;
mod container;
mod error;
mod export;
mod foliage;
mod import;
mod instances;
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

pub use chain::{ChainLevel, ChainPart, Sides, export_chain};
pub use error::{ExportError, ImportError};
pub use export::export_glb;
pub use import::{import, import_bytes};
pub use instances::{InstancedMesh, MeshPlace, TextureRim, export_instances};
pub use report::{ImportReport, ReportEntry, ReportKind};
pub use sources::{PlantSources, read_sources};

use super::Plant;
use error::Fault;
use material::Materials;

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
