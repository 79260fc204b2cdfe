//! Vertex collapse over a triangle mesh, for trunks and branches ([GH97](crate::references)).
//!
//! ```text
//!   a───b            a───b
//!   │ ╲ │ ╲          │  ╱│        u goes to v: the two triangles with the edge u v go,
//!   │  u───v   ──▶   │ ╱ v        those that are left at u move their corner to v;
//!   │ ╱ │ ╱          │╱ ╱         no vertex is made or moved
//!   c───d            c─d
//! ```
//!
//! The quadric error metric, with the choices that its paper leaves open or that a model with a fixed
//! set of vertices needs:
//!
//! - *Half-edge collapse*: a point goes to one that stays, `cost(u → v) = (Q_u + Q_v)(v)`. The paper's
//!   optimal placement would make vertices.
//! - *Area*: a collapse costs at least the square of the change of area around `u`. Planes know nothing
//!   of surface that ends: those of a twig meet in its axis, along which its tip could be drawn in, and
//!   at last the whole twig, for next to nothing; and a bent limb could become a sail.
//! - *Weights*: a triangle's plane counts with a third of its area at each corner, so that costs are
//!   about squared distances over the surface, in m⁴. Edges where the surface or its texture ends have
//!   a plane across the surface too ([`EDGE_WEIGHT`]).
//! - *Refused* is what changes the topology (the link condition) or turns a triangle by more than
//!   [`LEAST_COSINE`] allows.
//! - *Order*: always the cheapest by (cost, u, v).
//!
//! # The end of a branch
//!
//! Trees consist of hundreds of tubes that do not touch. The link condition alone leaves of each a
//! cone of three triangles; but a tree far away should lose its twigs at last. So in a component of
//! at most [`LAST_TRIANGLES`] triangles the link condition is waived: a cone becomes a blade (a
//! triangle with two sides), and a blade goes, at the cost of the square of its area. So twigs go in
//! the order of size, and after the rings of all that is thicker.
//!
//! # The error
//!
//! Each point carries how far the surface that it stands for may have moved: when `u` goes to `v`,
//! that of `u` and the distance from `u` to the triangles that take its place (to `v`, where none
//! do). A collapse's error is the greatest so far. It is measured at vertices alone, so it is an
//! estimate; where collapses follow one another it adds up their distances, which is from above.

mod collapses;
mod order;
mod quadric;
mod restore;
mod strips;
mod surface;

pub use collapses::{VertexCollapse, VertexCollapses, lowest_first};
pub use restore::{SimplifiedMesh, SimplifiedParts, simplify_mesh};
pub use strips::{Strips, strips_of};

use crate::plant::Mesh;

/// Counts up whenever [`collapse_vertices`] or [`strips_of`] answers otherwise than before: what is kept
/// of them elsewhere is of no use then.
pub const VERTEX_COLLAPSE_VERSION: u32 = 1;

/// When vertex collapse stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexCollapseOptions {
    /// How many triangles are left in the end, at most; more where every collapse that is left would
    /// be refused.
    pub stop_triangles: u32,
}

impl VertexCollapseOptions {
    /// Down to a twentieth of the triangles. No paper says where trunks stop; a tree of tubes then has
    /// its stem and limbs, and of its twigs the longest.
    #[must_use]
    pub fn usual(mesh: &Mesh) -> Self {
        Self {
            stop_triangles: mesh.triangle_count().div_ceil(20),
        }
    }
}

/// The weight of the plane across an open edge, as a multiple of the edge's squared length: such
/// edges move only along themselves until little else is left.
pub const EDGE_WEIGHT: f64 = 1000.0;

/// The least cosine of the angle by which a collapse turns a triangle: less refuses needles that
/// would stand across the surface, more keeps bends from being cut.
pub const LEAST_COSINE: f64 = 0.2;

/// Components of no more triangles may be folded flat and go: a tetrahedron has so many.
pub const LAST_TRIANGLES: u32 = 4;

/// Collapses the points of a mesh, the cheapest first.
///
/// Corners at the same position are one point, bit by bit. Triangles with two corners at one point
/// are never shown.
#[must_use]
pub fn collapse_vertices(mesh: &Mesh, options: VertexCollapseOptions) -> VertexCollapses {
    order::collapse(mesh, options)
}
