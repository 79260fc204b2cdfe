//! What keeps peeling from looking at every point for every hull.
//!
//! Points are put into bins by how deep they lie, roughly. For each bin, the extreme points of it and of
//! all deeper bins together are kept:
//!
//! ```text
//!   bin        0    1    2    3    …         outermost first
//!   extremes  E₀ ◀ E₁ ◀ E₂ ◀ E₃ ◀ …         Eᵢ = extremes of binᵢ ∪ Eᵢ₊₁
//!              └ the next layer
//! ```
//!
//! since a point that is extreme among many is so among fewer. Taking a layer off changes only the bins
//! that lose points and those outside them: a few thousand points instead of all. Which bin a point is
//! in decides how long this takes, never what is found.

use super::grid::Grid;
use super::hull::HullFinder;
use crate::math::index_u32;

/// Points that are peeled.
#[derive(Debug)]
pub(super) struct Onion<'a> {
    finder: HullFinder<'a>,
    /// Outermost first; what is peeled is gone.
    bins: Vec<Vec<u32>>,
    /// The extreme points of a bin and all after it.
    extremes: Vec<Vec<u32>>,
    /// The bin of each point.
    bin_of: Vec<u32>,
    /// So many bins, from the first, have extreme points that are not known.
    unknown: usize,
    left: usize,
}

impl<'a> Onion<'a> {
    pub(super) fn new(grid: &'a Grid) -> Self {
        let count = grid.len();
        let depths = depths(grid);
        let mut order: Vec<u32> = (0..index_u32(count)).collect();
        order.sort_unstable_by(|a, b| {
            let depth = |point: u32| depths[point as usize];
            depth(*a).total_cmp(&depth(*b)).then(a.cmp(b))
        });
        let bins: Vec<Vec<u32>> = order.chunks(bin_size(count)).map(<[u32]>::to_vec).collect();
        let mut bin_of = vec![0; count];
        for (number, bin) in (0_u32..).zip(&bins) {
            for &point in bin {
                bin_of[point as usize] = number;
            }
        }
        Self {
            finder: HullFinder::new(grid),
            extremes: vec![Vec::new(); bins.len()],
            unknown: bins.len(),
            bins,
            bin_of,
            left: count,
        }
    }

    /// How many points are left.
    pub(super) fn left(&self) -> usize {
        self.left
    }

    /// Takes the corners of the hull off, and answers them, ascending.
    pub(super) fn peel(&mut self) -> Vec<u32> {
        for bin in (0..self.unknown).rev() {
            let mut points = self.bins[bin].clone();
            points.extend(self.extremes.get(bin + 1).into_iter().flatten());
            self.extremes[bin] = self.finder.extremes(&points);
        }
        let layer = self.extremes.first().cloned().unwrap_or_default();
        let bins = layer
            .iter()
            .map(|point| self.bin_of[*point as usize] as usize);
        self.unknown = bins.max().map_or(0, |deepest| deepest + 1);
        for bin in &mut self.bins[..self.unknown] {
            bin.retain(|point| layer.binary_search(point).is_err());
        }
        self.left -= layer.len();
        layer
    }

    /// What is left, ascending.
    pub(super) fn rest(&self) -> Vec<u32> {
        let mut rest = self.bins.concat();
        rest.sort_unstable();
        rest
    }
}

/// Points of a bin. A hull of `n` points in a ball has some `4 √n` corners; bins of a few times as many
/// cost the least together, as measured.
fn bin_size(points: usize) -> usize {
    (8 * points.isqrt()).max(256)
}

/// Directions by whose extent depth is measured, with their opposites: to the corners, edges and faces
/// of a cube.
const DIRECTIONS: [[f64; 3]; 13] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.75, 0.75, 0.0],
    [0.75, -0.75, 0.0],
    [0.75, 0.0, 0.75],
    [0.75, 0.0, -0.75],
    [0.0, 0.75, 0.75],
    [0.0, 0.75, -0.75],
    [0.5, 0.5, 0.5],
    [0.5, 0.5, -0.5],
    [0.5, -0.5, 0.5],
    [0.5, -0.5, -0.5],
];

/// How far each point is at least from the planes around all that face some directions.
fn depths(grid: &Grid) -> Vec<f64> {
    let points = || (0..index_u32(grid.len())).map(|point| grid.at(point));
    let mut depths = vec![f64::INFINITY; grid.len()];
    for [x, y, z] in DIRECTIONS {
        let along = |[a, b, c]: [f64; 3]| a * x + b * y + c * z;
        let low = points().map(along).fold(f64::INFINITY, f64::min);
        let high = points().map(along).fold(f64::NEG_INFINITY, f64::max);
        for (depth, point) in depths.iter_mut().zip(points()) {
            let at = along(point);
            *depth = depth.min(at - low).min(high - at);
        }
    }
    depths
}
