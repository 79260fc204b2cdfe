//! Points of the axis of detail.

use super::super::{Crown, State};
use super::{Importance, Sight, spread};
use crate::math::{index_u32, index_usize};

/// The state at a point of the axis of detail: 0 is full detail, 1 the coarsest; step `i` of `N` equal
/// ones stands at `floor(i · C / N)` collapses.
#[must_use]
pub fn level(crown: &Crown, step: u32, steps: u32) -> State {
    State::Uniform {
        collapses: collapses_at(crown, step, steps),
    }
}

/// The same number of leaves, spread over the clusters as a criterion says: the papers' tests of
/// variable detail.
#[must_use]
pub fn level_with(
    crown: &Crown,
    step: u32,
    steps: u32,
    importance: &dyn Importance,
    sight: &Sight,
) -> State {
    let leaves = crown.sequence().original_count() - collapses_at(crown, step, steps);
    spread(crown, leaves, importance, sight)
}

/// `floor(i · C / N)`.
fn collapses_at(crown: &Crown, step: u32, steps: u32) -> u32 {
    let all = u64::from(crown.sequence().collapse_count());
    index_u32(index_usize(
        u64::from(step.min(steps)) * all / u64::from(steps.max(1)),
    ))
}
