//! As few leaves as a permitted error in pixels allows.

use super::super::{Crown, State};
use super::{Extent, Sight};

/// The coarsest state in which no leaf's [error](super::super::LeafErrors) spans more than `pixels`,
/// seen from the nearest point of its cluster.
///
/// For the whole crown: as many collapses as go before the first that would exceed it anywhere.
#[must_use]
pub fn within_pixels(crown: &Crown, pixels: f64, extent: Extent, sight: &Sight) -> State {
    let most = (0..).zip(crown.cluster_bounds()).map(|(cluster, bounds)| {
        let scale = sight.pixels_per_metre_at(bounds);
        let fits = |error: f32| f64::from(error) * scale <= pixels;
        crown.errors().collapses_while(cluster, fits)
    });
    match extent {
        Extent::Variable => State::Variable {
            counts: most.collect(),
        },
        Extent::Uniform => {
            let all = crown.sequence().collapse_count();
            let clusters = &crown.clusters().clusters;
            let refused = clusters
                .iter()
                .zip(most)
                .filter_map(|(cluster, count)| cluster.ops.get(count as usize).copied());
            State::Uniform {
                collapses: refused.min().unwrap_or(all),
            }
        }
    }
}
