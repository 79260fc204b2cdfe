//! Whether foliage keeps its mass: how much of a picture it covers, seen from everywhere.

use std::sync::Arc;

use super::RunError;
use super::views::{SPHERE_SHARE, VIEW_SIDE, Views};
use crate::models::{Crown, State};
use crate::simplify::measure_leaves;

/// How much foliage there is to see in one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Mass {
    /// Leaves shown.
    pub leaves: u32,
    /// Pixels that show a leaf, for each of [`directions`](super::directions).
    pub covered: Vec<u32>,
    /// The summed area of the leaves, in square metres.
    pub area: f64,
    /// Leaves that are folded.
    pub folded: u32,
}

impl Mass {
    /// The mean of the covered pixels.
    #[must_use]
    pub fn mean_covered(&self) -> f64 {
        let sum: u64 = self.covered.iter().map(|&pixels| u64::from(pixels)).sum();
        sum as f64 / self.covered.len().max(1) as f64
    }

    /// Covered pixels against `full`'s: the mean over all directions, and the one that is furthest
    /// from 1.
    #[must_use]
    pub fn against(&self, full: &Self) -> (f64, f64) {
        let mean = self.mean_covered() / full.mean_covered();
        let ratios = self.covered.iter().zip(&full.covered);
        let worst = ratios
            .map(|(&some, &all)| f64::from(some) / f64::from(all.max(1)))
            .max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
        (mean, worst.unwrap_or(1.0))
    }

    /// The share of the bounding sphere's disc that is covered, over all directions.
    #[must_use]
    pub fn share_of_disc(&self) -> f64 {
        let radius = f64::from(SPHERE_SHARE) * f64::from(VIEW_SIDE) / 2.0;
        self.mean_covered() / (std::f64::consts::PI * radius * radius)
    }
}

/// Measures states of a crown in the pictures of [`Views`].
///
/// # Errors
///
/// What the device refuses.
pub fn mass(crown: &Arc<Crown>, states: &[State]) -> Result<Vec<Mass>, RunError> {
    let mut views = Views::new(crown)?;
    let of_state = |state: &State| {
        views.show(state)?;
        let visible = state.visible(crown.clusters());
        let measure = measure_leaves(crown.vertices(), crown.sequence(), visible);
        Ok(Mass {
            leaves: measure.leaves + crown.faces().leaf_count(),
            covered: views.covered()?,
            area: measure.area + crown.faces().area(crown.plant()),
            folded: measure.folded,
        })
    };
    states.iter().map(of_state).collect()
}
