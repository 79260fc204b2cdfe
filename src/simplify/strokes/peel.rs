//! Nested convex hulls: points taken off layer by layer, as an onion is peeled.

use super::grid::Grid;
use super::onion::Onion;
use crate::math::Vec3;

/// How far points are peeled, at most until three or fewer are left ([CQHCVL06](crate::references),
/// section 4.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeelUntil {
    /// To the end.
    Over,
    /// For so many hulls.
    Hulls(u32),
    /// Up to and including the smallest hull that holds at least so many percent of the points, those
    /// at its corners counted.
    Percent(u32),
}

/// Points by the hull they are corners of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Peeling {
    /// The corners of each hull, the largest first; point numbers, ascending.
    pub layers: Vec<Vec<u32>>,
    /// What was not peeled; ascending.
    pub rest: Vec<u32>,
}

/// Peels points: finds their convex hull, takes its corners off, and goes on with the others.
///
/// Corners are the extreme points of what is left. A point in a face or an edge of a hull is no corner
/// of it and stays for the next, and points at the same place go together; so layers do not depend on
/// the order of the points, nor on how a flat face was cut into triangles. Where the points that are
/// left lie in a plane, their polygon's corners are peeled, and on a line its two ends. Coordinates are
/// put on a grid of a trillionth of the largest; from there on all is exact.
///
/// # Panics
///
/// When a coordinate is not finite; a [`Plant`](crate::plant::Plant)'s are.
#[must_use]
pub fn peel(points: &[Vec3], until: PeelUntil) -> Peeling {
    assert!(
        points.iter().all(|point| point.is_finite()),
        "points have places"
    );
    let grid = Grid::new(points);
    let mut onion = Onion::new(&grid);
    let mut count = points.len();
    let mut layers: Vec<Vec<u32>> = Vec::new();
    let goes_on = |peeled: usize, count: usize| match until {
        PeelUntil::Over => true,
        PeelUntil::Hulls(hulls) => peeled < hulls as usize,
        PeelUntil::Percent(percent) => {
            100 * count as u64 >= u64::from(percent) * points.len() as u64
        }
    };
    while onion.left() > LAST_POINTS && goes_on(layers.len(), count) {
        let layer = grid.originals_of(&onion.peel());
        count -= layer.len();
        layers.push(layer);
    }
    Peeling {
        layers,
        rest: grid.originals_of(&onion.rest()),
    }
}

/// With so many points left, or fewer, peeling ends.
const LAST_POINTS: usize = 3;

#[cfg(test)]
mod tests {
    use super::super::hull::HullFinder;
    use super::*;
    use crate::math::{Stream, index_u32};

    /// Against hulls of all that is left, on clouds of several bins, with many copies and shared planes.
    #[test]
    fn layers_are_the_hulls_of_what_is_left() {
        for seed in 0..6 {
            let draws = Stream::new(seed, 41);
            let side = [5, 12, 1 << 20][(seed % 3) as usize];
            let points: Vec<Vec3> = (0..900)
                .map(|point| {
                    let axis = |axis: u64| draws.below(3 * point + axis, side) as f32;
                    Vec3::new(axis(0), axis(1), axis(2))
                })
                .collect();
            let grid = Grid::new(&points);
            let mut finder = HullFinder::new(&grid);
            let mut left: Vec<u32> = (0..index_u32(grid.len())).collect();
            let found = peel(&points, PeelUntil::Over);
            for layer in &found.layers {
                let corners = finder.extremes(&left);
                assert_eq!(*layer, grid.originals_of(&corners), "seed {seed}");
                left.retain(|point| corners.binary_search(point).is_err());
            }
            assert!(left.len() <= 3, "seed {seed}: {} are left", left.len());
            assert_eq!(found.rest, grid.originals_of(&left));
            let three = peel(&points, PeelUntil::Hulls(3));
            assert_eq!(three.layers, found.layers[..3]);
        }
    }
}
