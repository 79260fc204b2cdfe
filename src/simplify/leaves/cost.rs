//! What joining two leaves costs.

use super::candidate::Candidate;
use super::grid::Site;
use super::shape::{Four, Scale, Shape};
use super::{LeafCollapseOptions, LeafDistance};
use crate::math::{Vec3, Vec4};

/// The cost of pairs, with the weights in the units of [`Shape`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    measure: LeafDistance,
    /// Cost a unit of distance.
    distance: f32,
    /// Cost of a right angle between normals.
    coplanarity: f32,
    /// Cost of an area that is wrong by all that is wanted.
    pub(super) area: f32,
    /// Cost of a quad without [`form`](Scale::form).
    pub(super) form: f32,
    /// Twice the vector area over the squared edges, times this, is the form over that of the
    /// originals.
    pub(super) form_scale: f32,
    /// What areas are divided by at least.
    least_area: f64,
    most_bend: f32,
    most_distance: f32,
}

impl Weights {
    pub(super) fn new(options: &LeafCollapseOptions, scale: &Scale) -> Self {
        let unit = scale.unit();
        let spacing = scale.spacing * unit;
        // Negative, infinite and missing numbers have no meaning; the clamp takes them to the ends.
        let weight = |weight: f32| weight.max(0.0).min(1e6);
        let threshold = |most: Option<f32>| most.map_or(f32::INFINITY, |most| most.max(0.0));
        Self {
            measure: options.distance,
            distance: single(f64::from(weight(options.distance_weight)) / spacing),
            coplanarity: weight(options.coplanarity_weight),
            area: weight(options.area_weight),
            form: weight(options.form_weight),
            form_scale: single(2.0 / scale.form),
            least_area: 1e-6 * scale.area * unit * unit,
            most_bend: threshold(options.coplanarity_threshold),
            most_distance: single(f64::from(threshold(options.distance_threshold)) * spacing),
        }
    }

    /// What the pair costs, and the quad that replaces it; `None` when it is refused or costs more
    /// than `limit`.
    ///
    /// Terms are added from cheap to dear to compute, and each may end it: all are at least 0, and
    /// rounding never makes a sum less than its parts.
    pub(super) fn of(&self, pair: [&Shape; 2], limit: f32) -> Option<(f32, Candidate)> {
        let [first, second] = pair;
        let bend = 1.0 - first.normal.dot(second.normal).abs().min(1.0);
        if bend > self.most_bend {
            return None;
        }
        let apart = distance(self.measure, &first.points, &second.points);
        if apart > self.most_distance {
            return None;
        }
        let placed = self.distance * apart + self.coplanarity * bend;
        if placed > limit {
            return None;
        }
        // A little more than what is left, so that rounding refuses nothing.
        let left = (limit - placed) + 1e-5 * limit;
        let candidate = Candidate::best(pair, self, left)?;
        let cost = (placed + candidate.penalty).min(f32::MAX);
        (cost <= limit).then_some((cost, candidate))
    }

    /// The area of the originals under both, and not nothing.
    pub(super) fn wanted_area(&self, [first, second]: [&Shape; 2]) -> f32 {
        single((first.original_area + second.original_area).max(self.least_area))
    }

    /// How far apart a pair may lie that costs no more than `cost`.
    pub(super) fn reach(&self, cost: f32) -> f32 {
        if self.distance > 0.0 {
            // The hundred-thousandth covers the rounding of distance and cost.
            cost * 1.000_01 / self.distance
        } else {
            f32::INFINITY
        }
    }

    /// What distance is measured from: two leaves are at least as far apart as the sides of these
    /// boxes.
    ///
    /// For Hausdorff's distance that is the box of the vertices, no side of which moves by more than
    /// the distance.
    pub(super) fn site(&self, shape: &Shape, leaf: u32) -> Site {
        let [a, b, c, d] = shape.points.lanes();
        let (low, high) = match self.measure {
            LeafDistance::Hausdorff => (a.min(b).min(c.min(d)), a.max(b).max(c.max(d))),
            LeafDistance::Centers => (center(&shape.points), center(&shape.points)),
        };
        Site { low, high, leaf }
    }
}

fn distance(measure: LeafDistance, first: &Four, second: &Four) -> f32 {
    match measure {
        LeafDistance::Hausdorff => hausdorff(first, second),
        LeafDistance::Centers => (center(first) - center(second)).length_squared().sqrt(),
    }
}

fn center(points: &Four) -> Vec3 {
    let [a, b, c, d] = points.lanes();
    0.25 * ((a + b) + (c + d))
}

/// Hausdorff's distance between two sets of four points: the furthest that a point of either lies
/// from the other set.
fn hausdorff(first: &Four, second: &Four) -> f32 {
    let squares = |lane: usize| second.from(first.lane(lane)).length_squared();
    let (a, b, c, d) = (squares(0), squares(1), squares(2), squares(3));
    let from_second = a.min(b).min(c.min(d));
    let from_first = Vec4::new(
        a.min_element(),
        b.min_element(),
        c.min_element(),
        d.min_element(),
    );
    from_first.max(from_second).max_element().sqrt()
}

/// Rounds to `f32`, to the largest finite number at most.
fn single(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounds, and is clamped")]
    let rounded = value.min(f64::from(f32::MAX)) as f32;
    rounded
}
