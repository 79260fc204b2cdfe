//! What joining two leaves costs.

use super::bound::Outline;
use super::candidate::Candidate;
use super::shape::{Four, Scale, Shape};
use super::{LeafCollapseOptions, LeafDistance};

/// What pairs cost, with weights in the units of [`Shape`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    measure: LeafDistance,
    /// Cost of a unit of distance.
    distance: f32,
    /// Cost of a right angle between normals.
    coplanarity: f32,
    /// Cost of an area that is wrong by all that is wanted.
    area: f32,
    /// Cost of a quad without form.
    form: f32,
    /// Twice the vector area over the squared edges, times this, is the form as a share of that of
    /// the originals.
    form_scale: f32,
    /// The least area that is ever wanted.
    least_area: f64,
    /// How many times their area four originals want.
    gain: f64,
    /// How far costs go by what is seen, from 0 to 1.
    exposure: f32,
    most_bend: f32,
    most_distance: f32,
}

impl Weights {
    pub(super) fn new(options: &LeafCollapseOptions, scale: &Scale) -> Self {
        let weight = |weight: f32| if weight > 0.0 { weight.min(1e6) } else { 0.0 };
        let threshold = |most: Option<f32>| most.map_or(f32::INFINITY, |most| most.max(0.0));
        Self {
            measure: options.distance,
            distance: single(f64::from(weight(options.distance_weight)) / scale.spacing),
            coplanarity: weight(options.coplanarity_weight),
            area: weight(options.area_weight),
            form: weight(options.form_weight),
            form_scale: single(2.0 / scale.form.max(1e-6)),
            // Leaves without area must not make every misfit infinite.
            least_area: (1e-6 * scale.area).max(1e-12),
            gain: if options.area_gain.is_nan() {
                1.0
            } else {
                f64::from(options.area_gain.clamp(0.25, 4.0))
            },
            exposure: if options.exposure > 0.0 {
                options.exposure.min(1.0)
            } else {
                0.0
            },
            most_bend: threshold(options.coplanarity_threshold),
            most_distance: single(f64::from(threshold(options.distance_threshold)) * scale.spacing),
        }
    }

    /// What the pair costs, and the quad that replaces it; `None` when it is refused or costs more
    /// than `limit`. The same for a pair and its reverse.
    ///
    /// Terms are added from cheap to dear to compute, and each may end it: all are at least 0, and
    /// rounding never makes a sum less than its parts.
    pub(super) fn cost(&self, pair: [&Shape; 2], limit: f32) -> Option<(f32, Candidate)> {
        let [first, second] = pair;
        let bend = 1.0 - first.normal.dot(second.normal).abs().min(1.0);
        if bend > self.most_bend {
            return None;
        }
        let seen = pair.map(|leaf| self.seen(leaf));
        let reach = self.reach(limit / least_move(seen));
        let apart = distance(self.measure, &first.points, &second.points, reach);
        if apart > self.most_distance {
            return None;
        }
        let placed = self.placed(apart, bend).min(f32::MAX);
        if least_move(seen) * placed > limit * 1.000_01 {
            return None;
        }
        let candidate = Candidate::best(pair, self, placed, limit)?;
        Some((candidate.cost, candidate))
    }

    /// What a leaf counts: what is seen of the originals under it, in mean originals, as far as that
    /// is to count at all.
    pub(super) fn seen(&self, shape: &Shape) -> f32 {
        (1.0 - self.exposure) + self.exposure * shape.under.seen
    }

    /// What it costs to move a leaf that counts 1 by a distance and a bend.
    #[inline]
    pub(super) fn placed(&self, apart: f32, bend: f32) -> f32 {
        self.distance * apart + self.coplanarity * bend
    }

    /// The area that a quad should have that replaces both: that of all originals under it, times
    /// the gain as far as there are four.
    pub(super) fn wanted_area(&self, [first, second]: [&Shape; 2]) -> f32 {
        let under = first.under.and(second.under);
        let part = f64::from(under.count.min(4) - 1) / 3.0;
        let gain = 1.0 + (self.gain - 1.0) * part;
        single((gain * under.area).max(self.least_area))
    }

    /// The least area that is ever wanted.
    pub(super) fn least_area(&self) -> f32 {
        single(self.least_area)
    }

    /// What quads cost that have these areas.
    pub(super) fn area_penalties(&self, [a, b, c, d]: [f32; 4], wanted: f32) -> [f32; 4] {
        let scale = self.area / (wanted * wanted);
        let penalty = |area: f32| scale * ((area - wanted) * (area - wanted));
        [penalty(a), penalty(b), penalty(c), penalty(d)]
    }

    /// What a quad costs that is less compact than the originals.
    pub(super) fn form_penalty(&self, quad: &Four) -> f32 {
        let [a, b, c, d] = quad.all();
        let edges = ((b - a).length_squared() + (c - b).length_squared())
            + ((d - c).length_squared() + (a - d).length_squared());
        let twice_area = (c - a).cross(d - b).length_squared().sqrt();
        let missing = edges - self.form_scale * twice_area;
        if missing > 0.0 {
            self.form * (missing / edges)
        } else {
            0.0
        }
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

    /// What is known of a leaf at a glance.
    ///
    /// Distance is bounded by the box of the vertices, no side of which moves by more than
    /// Hausdorff's distance; or it is that of the middles.
    pub(super) fn outline(&self, shape: &Shape) -> Outline<f32> {
        let [a, b, c, d] = shape.points.all();
        let ends = match self.measure {
            LeafDistance::Hausdorff => [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))],
            LeafDistance::Centers => [shape.points.middle(); 2],
        };
        let area = shape.under.area * self.gain.min(1.0);
        Outline::of(shape, ends, single(area), self.seen(shape))
    }

    /// What a pair costs at least that costs so much to place and whose area is short by so much.
    #[inline]
    pub(super) fn least(&self, placed: f32, missing: f32, seen: [f32; 2]) -> f32 {
        let area = self.area * (missing * missing);
        0.999_9 * (least_move(seen) * placed + mean(seen) * area)
    }
}

/// What two leaves count of which the one that counts more loses one of its corners, and the other
/// three: no quad with corners of both costs less.
#[inline]
fn least_move([first, second]: [f32; 2]) -> f32 {
    let lesser = if first < second { first } else { second };
    0.25 * (first + second) + 0.5 * lesser
}

/// What two leaves count of which each loses half, and what their new leaf's area and form count.
#[inline]
pub(super) fn mean([first, second]: [f32; 2]) -> f32 {
    0.5 * (first + second)
}

/// The distance, or infinity for more than `reach`.
fn distance(measure: LeafDistance, first: &Four, second: &Four, reach: f32) -> f32 {
    match measure {
        LeafDistance::Hausdorff => hausdorff(first, second, reach),
        LeafDistance::Centers => (first.middle() - second.middle()).length_squared().sqrt(),
    }
}

/// Hausdorff's distance between two sets of four points: the furthest that a point of either lies
/// from the other set. Infinite when it is more than `reach`.
fn hausdorff(first: &Four, second: &Four, reach: f32) -> f32 {
    let from_second = largest(nearest(first, second));
    if from_second > reach * reach {
        return f32::INFINITY;
    }
    let from_first = largest(nearest(second, first));
    greater(from_second, from_first).sqrt()
}

/// The squared distance of each point to the nearest of the others.
///
/// Kept apart so that the compiler takes the four lanes at once: inlined, it does not.
#[inline(never)]
fn nearest(points: &Four, others: &Four) -> [f32; 4] {
    let lesser = |a: f32, b: f32| if a < b { a } else { b };
    let mut least = [f32::INFINITY; 4];
    for other in 0..4 {
        let (x, y, z) = (others.x[other], others.y[other], others.z[other]);
        let square = |lane: usize| {
            let (x, y, z) = (points.x[lane] - x, points.y[lane] - y, points.z[lane] - z);
            (x * x + y * y) + z * z
        };
        let squares = [square(0), square(1), square(2), square(3)];
        least = [
            lesser(squares[0], least[0]),
            lesser(squares[1], least[1]),
            lesser(squares[2], least[2]),
            lesser(squares[3], least[3]),
        ];
    }
    least
}

fn largest([a, b, c, d]: [f32; 4]) -> f32 {
    greater(greater(a, b), greater(c, d))
}

fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Rounds to `f32`, to the largest finite number at most.
fn single(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounds, and is clamped")]
    let rounded = value.min(f64::from(f32::MAX)) as f32;
    rounded
}
