//! glTF 2.0, in and out: trees of other programs as plants, plants for other programs.
//!
//! ```text
//!  .glb, .gltf ─container─▶ JSON + bytes ─scan, parse─▶ document ─scene─▶ placed primitives
//!                                                          │                   │
//!                                        our own extras ◀──┴──▶ none, or edited│
//!                                              │                               ▼
//!                                              ▼                      leaves or wood: as any mesh
//!                                         Plant, exact
//!
//!  Plant ─export_glb─▶ .glb: meshes that any viewer draws, and `extras.spinney` with the rest
//!  levels of detail ─export_chain─▶ .glb: each a node, with MSFT_lod
//!  meshes at their places ─export_instances─▶ .glb: what a frame draws, for other renderers
//! ```
//!
//! glTF has +Y up and metres, as [`Plant`](super::Plant) has: only the placement of nodes is applied, unless
//! the user says otherwise or the tree stands far from the origin.
//!
//! **Invariants.** No byte of a file is believed before it is checked: lengths, offsets and counts
//! against what is there, indices against what they name, in checked arithmetic. Memory stays in
//! proportion to the file and below stated limits. Nothing is dropped, guessed or left out without
//! an entry in the [`ImportReport`](super::import::ImportReport). A plant that was written by [`export_glb`] comes back with the
//! same [`Plant::digest`](super::Plant::digest).

mod accessor;
mod buffers;
mod chain;
mod container;
mod error;
mod export;
mod import;
mod instances;
mod material;
mod native;
mod placement;
mod record;
mod scan;
mod scene;
mod sources;
mod surface;
mod uri;

#[cfg(test)]
mod tests;

pub use chain::{ChainLevel, ChainPart, Sides, export_chain};
pub use error::ExportError;
pub use export::export_glb;
pub use instances::{InstancedMesh, MeshPlace, TextureRim, export_instances};

#[cfg(test)]
pub(super) use export::encode_png;
pub(super) use import::read;
pub(super) use sources::named_files;

use error::Fault;
use material::Materials;
