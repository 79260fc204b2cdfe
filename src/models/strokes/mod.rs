//! Painting: brush strokes in place of leaves and branches ([CQHCVL06](crate::references)).
//!
//! ```text
//!  offline                          once a species                  a change of level    a move of the eye
//! Foliage ─StrokeLevels─┐            all strokes, 44 B each ─┐       runs, 8 B each ─┐    order, 4 B ─┐
//! Skeleton ─BranchRanks─┴▶ Painting  brushes, ground ────────┴───────────────────────┴────────────────┴▶ one draw
//!  (which runs are a cut)
//! ```
//!
//! It is a model of the whole plant: where a skeleton is known, branch strokes take the place of the
//! trunk, whose mesh is then not drawn. A [`StrokeCut`](super::StrokeCut) says which strokes show: the
//! rows and the shell of an extraction, how many strokes the branches of each level have, and how many
//! branches, the longest first, are not pruned. Any cut is a few runs of one list.
//!
//! **Order.** Strokes are blended, so they are drawn far to near. They are sorted on the host, as on the
//! card of the paper, which computes nothing but pictures; what is sent is which stroke comes when, 4 B
//! each, under a cause of its own, `stroke-order`, and only where the eye has moved past something. The
//! order counts places among the strokes that show, so a change of level sends ranges and no strokes.
//!
//! **Invariant.** A stroke's brush, hue and place depend on its number and the painting's seed alone: a
//! camera that moves finds every stroke where it was, and one that stays sends nothing.

mod backdrop;
mod branch_ranks;
mod brushes;
mod fragment;
mod ground;
mod host;
mod oil;
mod order;
mod painting;
mod pixels;
mod program;
mod ranges;
mod record;
mod surface;
mod watercolour;

pub use painting::Painting;

pub(super) use host::HostStrokes;
pub(super) use ranges::StrokeRanges;
