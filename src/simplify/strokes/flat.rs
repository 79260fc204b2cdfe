//! Extreme points of sets that fill no space: polygons and segments.

use super::grid::{Grid, lexicographic, minus, whole};

/// The ends of points on a line; grid points are numbered in lexicographic order, in which the ends of
/// a segment come first and last.
pub(super) fn ends_of_line(points: &[u32]) -> Vec<u32> {
    let ends = points.iter().min().into_iter().chain(points.iter().max());
    ends.copied().collect()
}

/// The corners of the convex polygon around points of one plane, which three of them span, by
/// Andrew's chains ([AND79](crate::references)) along an axis onto which the plane does not vanish.
pub(super) fn polygon(grid: &Grid, corners: [u32; 3], points: &[u32]) -> Vec<u32> {
    let normal = grid.exact_normal(corners).map(i128::unsigned_abs);
    let axes = if normal[2] > 0 {
        [0, 1]
    } else if normal[1] > 0 {
        [0, 2]
    } else {
        [1, 2]
    };
    // Along the axis that is left out, the plane is seen from the front, so no two points fall together.
    let seen = |point: u32| {
        let at = grid.at(point);
        [at[axes[0]], at[axes[1]], 0.0]
    };
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| lexicographic(&seen(*a), &seen(*b)));
    let turns_left = |a: u32, b: u32, c: u32| {
        let [ux, uy, _] = minus(seen(b), seen(a)).map(whole);
        let [vx, vy, _] = minus(seen(c), seen(a)).map(whole);
        ux * vy - uy * vx > 0
    };
    let chain = |points: &mut dyn Iterator<Item = u32>| {
        let mut chain: Vec<u32> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && !turns_left(a, b, point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = chain(&mut sorted.iter().copied());
    lower.extend(chain(&mut sorted.iter().rev().copied()));
    lower
}
