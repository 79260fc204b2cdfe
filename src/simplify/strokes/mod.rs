//! Strokes with several levels of detail: what painted trees are made of
//! ([CQHCVL06](crate::references)).
//!
//! ```text
//! Plant.foliage ─leaf_strokes─▶ LeafStroke ─┐ centres
//!   all leaves      one a leaf              ├──shells──▶ Shells: outermost … core
//!                                           ▼              by nested hulls
//!                      StrokeLevels::new: rows × shells ─extract─▶ Extraction
//!                        each stroke stored once        wanted     runs of the list
//! Plant.skeleton ─BranchStrokes::new─▶ a list a branch, coarse to fine ─read─▶ their beginnings
//! ```
//!
//! Nothing here knows where the viewer is: extraction wants a number of strokes, which follows from the
//! distance alone, and the tree looks as finely drawn from all sides (section 4.2).
//!
//! **Invariant.** Shells part the leaves, and each lies within the hull around the one before, exactly.
//! Every row stands for every leaf once, strokes join leaves of one shell and one foliage group alone,
//! and an outer shell is never drawn from a coarser row than an inner one.

mod branches;
mod collapse;
mod extract;
mod flat;
mod grid;
mod hull;
mod leaf;
mod levels;
mod onion;
mod peel;
mod shells;
#[cfg(test)]
mod tests;

pub use branches::{BranchStrokeOptions, BranchStrokes, BranchView};
pub use collapse::CollapseThresholds;
pub use extract::{Extraction, extract, strokes_at};
pub use leaf::{LeafStroke, leaf_strokes};
pub use levels::{LevelOptions, StrokeLevels, thresholds_for};
pub use peel::{PeelUntil, Peeling, peel};
pub use shells::{ShellOptions, Shells, shells};
