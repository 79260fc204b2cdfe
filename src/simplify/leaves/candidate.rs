//! Two leaves become one: the quads that a pair offers, and which of them is taken.

use super::super::measure::quad_is_folded;
use super::cost::Weights;
use super::shape::{Four, Shape, pick, square_root};
use crate::math::{Vec3, Vec4};

/// A quad that may replace two leaves.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Bit `r` says that the corner of role `r` is that of the second leaf.
    choice: u8,
    /// What its area and form cost.
    pub(super) penalty: f32,
}

impl Candidate {
    /// The best quad of the 14 that take each corner role from either leaf and corners from both;
    /// `None` when all are folded or cost more than `limit`.
    ///
    /// The least penalty wins, then the longer least edge, then the lower vertex numbers.
    pub(super) fn best(pair: [&Shape; 2], weights: &Weights, limit: f32) -> Option<Self> {
        let wanted = weights.wanted_area(pair);
        let area_weight = weights.area / wanted;
        let points = [&pair[0].points, &pair[1].points];
        let ends = ends(points);
        let mut best: Option<Self> = None;
        let mut most = limit;
        for zero in 0..2 {
            for two in 0..2 {
                let start = points[zero].lane(0);
                let end = points[two].lane(2);
                let from_start = ends.from(start);
                let from_end = ends.from(end);
                // Twice the area of the triangle on each end, as a vector: corners 1 turn one way
                // about the diagonal, corners 3 the other.
                let normals = from_start.cross(end - start);
                let squares = normals.length_squared();
                let halves = 0.5 * square_root(squares);
                let edges = from_start.length_squared() + from_end.length_squared();
                // From here each lane is a quad.
                let area = pick(halves, ONE) + pick(halves, THREE);
                let misfit = (area - wanted) / wanted;
                let misfits = weights.area * (misfit * misfit);
                if misfits.min_element() > most {
                    continue;
                }
                let fold = -normals.pick(ONE).dot(&normals.pick(THREE));
                let square = (pick(squares, ONE) + pick(squares, THREE)) + 2.0 * fold;
                let vector = square_root(square.max(Vec4::ZERO));
                let form = vector / (pick(edges, ONE) + pick(edges, THREE));
                let forms = weights.form * (1.0 - weights.form_scale * form).max(Vec4::ZERO);
                let penalties = (misfits + forms).to_array();
                for (penalty, ends) in penalties.into_iter().zip(CHOICES) {
                    let choice = u8::from(zero == 1) | u8::from(two == 1) << 2 | ends;
                    if penalty > most || choice == 0 || choice == ALL {
                        continue;
                    }
                    let candidate = Self { choice, penalty };
                    if best.is_none_or(|best| candidate.beats(&best, pair))
                        && !candidate.is_folded(pair)
                    {
                        best = Some(candidate);
                        most = penalty;
                    }
                }
            }
        }
        best
    }

    fn is_folded(&self, pair: [&Shape; 2]) -> bool {
        let at = |role: usize| self.source(role, pair).points.lane(role).as_dvec3();
        quad_is_folded([at(0), at(1), at(2), at(3)])
    }

    fn beats(&self, other: &Self, pair: [&Shape; 2]) -> bool {
        if self.penalty < other.penalty || self.penalty > other.penalty {
            return self.penalty < other.penalty;
        }
        self.least_edge(pair)
            .total_cmp(&other.least_edge(pair))
            .reverse()
            .then_with(|| self.corners(pair).cmp(&other.corners(pair)))
            .is_lt()
    }

    /// The square of the shortest edge.
    fn least_edge(&self, pair: [&Shape; 2]) -> f32 {
        let [a, b, c, d] = self.points(pair).lanes();
        let [a, b, c, d] = [a - b, b - c, c - d, d - a].map(Vec3::length_squared);
        a.min(b).min(c.min(d))
    }

    /// The positions by corner role.
    pub(super) fn points(&self, pair: [&Shape; 2]) -> Four {
        let at = |role: usize| self.source(role, pair).points.lane(role);
        Four::new([at(0), at(1), at(2), at(3)])
    }

    /// The vertex numbers by corner role.
    pub(super) fn corners(&self, pair: [&Shape; 2]) -> [u32; 4] {
        let at = |role: usize| self.source(role, pair).corners[role];
        [at(0), at(1), at(2), at(3)]
    }

    /// The leaf that the corner is from.
    fn source<'a>(&self, role: usize, [first, second]: [&'a Shape; 2]) -> &'a Shape {
        if self.choice >> role & 1 == 0 {
            first
        } else {
            second
        }
    }
}

/// Lanes of [`ends`]: corner 1 of the four quads on a diagonal.
const ONE: [usize; 4] = [0, 0, 1, 1];
/// Lanes of [`ends`]: corner 3 of the four quads on a diagonal.
const THREE: [usize; 4] = [2, 3, 2, 3];
/// What the four quads on a diagonal choose for corners 1 and 3.
const CHOICES: [u8; 4] = [0b0000, 0b1000, 0b0010, 0b1010];
/// All corners are those of the second leaf.
const ALL: u8 = 0b1111;

/// The ends of the diagonal 1-3: corner 1 of both leaves, then corner 3 of both.
fn ends([first, second]: [&Four; 2]) -> Four {
    let each = |first: Vec4, second: Vec4| Vec4::new(first.y, second.y, first.w, second.w);
    Four {
        x: each(first.x, second.x),
        y: each(first.y, second.y),
        z: each(first.z, second.z),
    }
}
