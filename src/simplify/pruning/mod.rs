//! Stochastic pruning: leaves go in a random order, and what stays takes over their area.
//!
//! ```text
//!  A 3──2    B 3──2        3────2
//!    │  │  +   │  │  ──▶   │    │      B goes; A is scaled about its middle until it has the area of
//!    0──1      0──1        │    │      both: four vertices of its own
//!                          0────1
//! ```
//!
//! After [CHPR07](crate::references): of `N` elements, in an order drawn once, `n` are kept, and each is
//! scaled in area by `N / n`, which keeps the expected area. What is ours makes a
//! [forest of binary trees](CollapseSequence) of it, so that every model of LoDF shows pruned foliage:
//!
//! - A collapse takes one leaf away and hands its area to *one* other, which stays where it is. So the
//!   area of all leaves stays exactly the same, not only in the mean; but a leaf has grown by the area of
//!   the leaves that it stands for, and not all by the same share. Of two leaves of a cluster one stands
//!   for at most twice as many originals as the other, or for four times where an odd number left one
//!   over: leaves are paired off in rounds, each of which takes all that are left.
//! - Clusters are [boxes](partition) with nearly equally many leaves, and area stays within them. The order is
//!   random within a cluster, and all clusters shrink at the same rate.
//! - Growth may be [capped](PruningOptions::most_growth), at the price of area. Nothing is capped by
//!   itself.
//!
//! The paper's correction of contrast, which moves the colours of what is left towards their mean, is
//! not done, nor does a leaf shrink smoothly before it goes.
//!
//! The order is first in, first out: in each cluster leaves are consumed in the order in which they are
//! born. That is the one order in which the papers' static list is right as printed, see
//! [`literal_visible`](super::literal_visible).

mod growth;
mod order;
mod partition;

use super::CollapseSequence;
use crate::math::DVec3;
use crate::plant::Foliage;

pub use growth::hand_on_areas;

/// When pruning stops, and what it draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PruningOptions {
    /// How many leaves are left in the end, over all groups; one of each group stays in any case.
    pub stop_leaves: u32,
    /// Decides the order.
    pub seed: u64,
    /// How many times its own area a leaf shows at most; `None` for any number. Less than 1 counts
    /// as 1, NaN as none.
    pub most_growth: Option<f32>,
}

impl PruningOptions {
    /// Down to `stop_leaves`, with seed 0 and without a cap, so that area stays.
    #[must_use]
    pub fn to(stop_leaves: u32) -> Self {
        Self {
            stop_leaves,
            seed: 0,
            most_growth: None,
        }
    }
}

/// Prunes quad leaves, each time one of two in a cluster, never across groups.
///
/// The sequence ends with exactly [`stop_leaves`](PruningOptions::stop_leaves) leaves, or with one a
/// group where that is more, or all where that is less. The cost of a collapse is how many times its
/// original's area the new leaf has.
#[must_use]
#[expect(clippy::missing_panics_doc, reason = "no input reaches it")]
pub fn prune_leaves(foliage: &Foliage, options: &PruningOptions) -> CollapseSequence {
    let clusters = partition::clusters(foliage, options.stop_leaves);
    let pairs = order::pairs(clusters, options.seed);
    hand_on_areas(foliage, &pairs, options.most_growth).expect("pairs are of leaves that are left")
}

/// The mean of four corners.
fn middle(corners: [DVec3; 4]) -> DVec3 {
    ((corners[0] + corners[1]) + (corners[2] + corners[3])) * 0.25
}

/// The corners of every quad leaf.
fn quads(foliage: &Foliage) -> Vec<[DVec3; 4]> {
    let vertices = foliage.quad_vertices();
    let (leaves, _) = vertices.as_chunks::<4>();
    let leaves = leaves.iter();
    leaves
        .map(|leaf| leaf.map(|corner| corner.as_dvec3()))
        .collect()
}

#[cfg(test)]
mod tests;
