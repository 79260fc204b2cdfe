//! Cards: textured polygons that stand in for leaves.
//!
//! ```text
//! Foliage ─LeafTriangles─▶ bake(views) ─▶ BakedView, … ─▶ Atlas ─▶ models of cards
//! ```
//!
//! **Invariant.** No light is baked in: what a card keeps is albedo, alpha, normal and depth.

mod atlas;
mod atlas_alpha;
mod bake;
mod bake_program;
mod bake_resolve;
mod bake_sheet;
mod eye;
mod impostors;
mod impostors_fit;
mod impostors_fragment;
mod impostors_outline;
mod impostors_program;
mod impostors_set;
mod indirect;
mod indirect_fragment;
mod indirect_map;
mod indirect_sprites;
mod meshes;
mod octahedral;
mod rival_card;
mod rival_carried;
mod rival_program;
mod rivals;
mod triangles;

pub(super) use eye::Eye;
pub(super) use impostors::Impostors;
pub(super) use indirect::IndirectImpostors;
pub use indirect_map::LeafMapFacts;
pub use meshes::{ImpostorMesh, impostor_meshes};
pub(super) use rivals::{Rival, RivalForm};
