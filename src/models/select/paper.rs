//! From the viewer's distance to the number of leaves: the papers' criteria.

use super::super::{Crown, State};
use crate::math::{Vec3, whole_u32};

/// Between which distances detail falls, and whether over the whole crown or cluster by cluster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// Metres; nearer than this everything is shown (`D_MIN`).
    pub nearest: f32,
    /// Metres; farther than this only one leaf a cluster is shown (`D_MAX`), above `nearest`.
    pub farthest: f32,
    /// What the distance is measured to.
    pub extent: Extent,
}

/// What one number of leaves is chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// The whole crown, by the distance to its centre ([RRCGR](crate::references), Algorithm 1).
    Uniform,
    /// Each cluster, by the distance to its own centre
    /// ([RRCGR](crate::references), Algorithm 4 with `MostDetailedZone` linear in the distance).
    Variable,
}

/// The state for a viewer at `eye`, in the plant's own space.
#[must_use]
pub fn select(crown: &Crown, criterion: Criterion, eye: Vec3) -> State {
    match criterion.extent {
        Extent::Uniform => {
            let (most, least) = (
                crown.sequence().original_count(),
                crown.sequence().root_count(),
            );
            State::Uniform {
                collapses: collapses_at(criterion, eye, crown.center(), most, least),
            }
        }
        Extent::Variable => {
            let count =
                |(center, most): (&Vec3, u32)| collapses_at(criterion, eye, *center, most, 1);
            let sizes = crown
                .clusters()
                .clusters
                .iter()
                .map(|cluster| cluster.original_count());
            State::Variable {
                counts: crown
                    .cluster_centers()
                    .iter()
                    .zip(sizes)
                    .map(count)
                    .collect(),
            }
        }
    }
}

/// The collapses of `most` leaves to no fewer than `least` around `center`, for a viewer at `eye`, both
/// in the plant's own space: what a device that selects by itself calls too.
pub(in crate::models) fn collapses_at(
    criterion: Criterion,
    eye: Vec3,
    center: Vec3,
    most: u32,
    least: u32,
) -> u32 {
    most - leaf_count(criterion, eye.distance(center), most, least)
}

/// The number of leaves at a distance: `most` up to `nearest`, `least` from `farthest` on, linear
/// between, in such steps that the first leaf goes only when the law has lost a whole one.
pub(super) fn leaf_count(criterion: Criterion, distance: f32, most: u32, least: u32) -> u32 {
    let (nearest, farthest) = (f64::from(criterion.nearest), f64::from(criterion.farthest));
    let share = ((f64::from(distance) - nearest) / (farthest - nearest)).clamp(0.0, 1.0);
    most - whole_u32(share * f64::from(most - least))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_fall_linearly_between_the_two_distances() {
        let criterion = Criterion {
            nearest: 10.0,
            farthest: 20.0,
            extent: Extent::Uniform,
        };
        let leaves = |distance| leaf_count(criterion, distance, 110, 10);
        assert_eq!(
            [0.0, 10.0, 15.0, 20.0, 99.0].map(leaves),
            [110, 110, 60, 10, 10]
        );
        assert_eq!(leaves(10.05), 110);
        assert_eq!(leaves(10.15), 109);
    }
}
