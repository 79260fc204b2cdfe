//! Cards: textured polygons that stand in for leaves.
//!
//! ```text
//! Foliage ─LeafTriangles─▶ bake(views) ─▶ BakedView, … ─▶ Atlas ─▶ models of cards
//! ```
//!
//! **Invariant.** No light is baked in: what a card keeps is albedo, alpha, normal and depth.

mod atlas;
mod bake;
mod bake_program;
mod bake_resolve;
mod bake_sheet;
mod triangles;
