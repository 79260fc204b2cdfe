//! Two leaves become one: the quads that a pair offers, and which of them is taken.

use super::super::measure::quad_is_folded;
use super::cost::{Weights, mean};
use super::shape::{Four, Shape};
use crate::math::Vec3;

/// A quad that may replace two leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Bit `r` says that the corner of role `r` is that of the second leaf.
    choice: usize,
    /// What the pair costs that it replaces.
    pub(super) cost: f32,
}

/// All corners are those of the second leaf.
const ALL: usize = 0b1111;

impl Candidate {
    /// The best quad of the 14 that take each corner role from either leaf and corners from both;
    /// `None` when all are folded or cost more than `limit`. `placed` is what it costs to move a leaf
    /// that counts 1.
    ///
    /// The least cost wins, then the longer least edge, then the lower vertex numbers. Areas are
    /// compared in `f32`, folds are decided as [`is_folded`](super::super::is_folded) does.
    pub(super) fn best(
        pair: [&Shape; 2],
        weights: &Weights,
        placed: f32,
        limit: f32,
    ) -> Option<Self> {
        let wanted = weights.wanted_area(pair);
        let ends = ends([&pair[0].points, &pair[1].points]);
        let seen = pair.map(|leaf| weights.seen(leaf));
        let mean = mean(seen);
        let moved = moved(seen);
        let mut best: Option<Self> = None;
        let mut most = limit;
        for diagonal in DIAGONALS {
            let start = source(pair, diagonal, 0).points.at(0);
            let end = source(pair, diagonal, 2).points.at(2);
            let penalties = weights.area_penalties(quad_areas(&ends, start, end), wanted);
            for (penalty, others) in penalties.into_iter().zip(OTHERS) {
                let choice = diagonal | others;
                if choice == 0 || choice == ALL {
                    continue;
                }
                let placed = moved[choice.count_ones() as usize] * placed;
                // Most end here: rounding never makes a sum less than its parts.
                if placed + mean * penalty > most {
                    continue;
                }
                let quad = points(pair, choice);
                let cost = placed + mean * (penalty + weights.form_penalty(&quad));
                let candidate = Self {
                    choice,
                    cost: cost.min(f32::MAX),
                };
                if candidate.cost <= most
                    && best.is_none_or(|best| candidate.beats(best, pair))
                    && !quad_is_folded(quad.all().map(Vec3::as_dvec3))
                {
                    best = Some(candidate);
                    most = candidate.cost;
                }
            }
        }
        best
    }

    fn beats(self, other: Self, pair: [&Shape; 2]) -> bool {
        let least_edge = |candidate: Self| {
            let [a, b, c, d] = points(pair, candidate.choice).all();
            let squares = [a - b, b - c, c - d, d - a].map(Vec3::length_squared);
            squares.into_iter().fold(f32::INFINITY, f32::min)
        };
        self.cost
            .total_cmp(&other.cost)
            .then_with(|| least_edge(other).total_cmp(&least_edge(self)))
            .then_with(|| corners(pair, self.choice).cmp(&corners(pair, other.choice)))
            .is_lt()
    }

    /// The new leaf.
    pub(super) fn shape(self, pair: [&Shape; 2]) -> Shape {
        Shape::new(
            corners(pair, self.choice),
            points(pair, self.choice),
            pair[0].under.and(pair[1].under),
        )
    }
}

/// The leaf whose corner is chosen for a role.
fn source([first, second]: [&Shape; 2], choice: usize, role: usize) -> &Shape {
    if choice >> role & 1 == 0 {
        first
    } else {
        second
    }
}

fn points(pair: [&Shape; 2], choice: usize) -> Four {
    let at = |role: usize| source(pair, choice, role).points.at(role);
    Four::new([at(0), at(1), at(2), at(3)])
}

fn corners(pair: [&Shape; 2], choice: usize) -> [u32; 4] {
    let at = |role: usize| source(pair, choice, role).corners[role];
    [at(0), at(1), at(2), at(3)]
}

/// What the corners 0 and 2 may be.
const DIAGONALS: [usize; 4] = [0b000, 0b001, 0b100, 0b101];

/// What the two leaves count that lose corners, by how many corners are the second's: each counts by
/// the share of its own that it loses.
fn moved([first, second]: [f32; 2]) -> [f32; 5] {
    [0.0, 1.0, 2.0, 3.0, 4.0].map(|corners| 0.25 * (corners * first + (4.0 - corners) * second))
}

/// What the four quads of [`quad_areas`] choose for corners 1 and 3.
const OTHERS: [usize; 4] = [0b0000, 0b1000, 0b0010, 0b1010];

/// The ends of the diagonal 1-3: corner 1 of both leaves, then corner 3 of both.
fn ends([first, second]: [&Four; 2]) -> Four {
    let each = |first: [f32; 4], second: [f32; 4]| [first[1], second[1], first[3], second[3]];
    Four {
        x: each(first.x, second.x),
        y: each(first.y, second.y),
        z: each(first.z, second.z),
    }
}

/// The areas of the four quads with a given diagonal 0-2, in the order of [`OTHERS`].
///
/// Kept apart so that the compiler takes the four lanes at once: inlined, it does not.
#[inline(never)]
fn quad_areas(ends: &Four, start: Vec3, end: Vec3) -> [f32; 4] {
    let edge = end - start;
    let triangle = |lane: usize| {
        let x = ends.x[lane] - start.x;
        let y = ends.y[lane] - start.y;
        let z = ends.z[lane] - start.z;
        let across = [
            y * edge.z - z * edge.y,
            z * edge.x - x * edge.z,
            x * edge.y - y * edge.x,
        ];
        let [x, y, z] = across;
        0.5 * ((x * x + y * y) + z * z).sqrt()
    };
    let [a, b, c, d] = [triangle(0), triangle(1), triangle(2), triangle(3)];
    [a + c, a + d, b + c, b + d]
}
