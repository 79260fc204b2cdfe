//! What a pair costs at least, for one leaf and many others at once.

use super::cost::Weights;
use super::shape::Shape;
use crate::math::Vec3;

/// What is known of a leaf at a glance, or of many leaves, a list for each number.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline<T> {
    /// The least coordinates of what distance is measured from.
    pub(super) low: [T; 3],
    /// The greatest coordinates.
    pub(super) high: [T; 3],
    /// The middle of a ball around the corners.
    pub(super) middle: [T; 3],
    /// The radius of that ball.
    pub(super) radius: T,
    /// The unit normal.
    pub(super) normal: [T; 3],
    /// The least area that may be wanted for the originals under it.
    pub(super) area: T,
    /// What counts of it: [`Weights::seen`].
    pub(super) seen: T,
}

/// The outlines of the leaves of a block, by slot: number by number, as a processor takes several at
/// once.
#[derive(Debug, Clone, Default)]
pub(super) struct Bounds(Outline<Vec<f32>>);

impl Bounds {
    pub(super) fn push(&mut self, outline: Outline<f32>) {
        let values = outline.into_rows();
        for (row, value) in self.0.rows_mut().into_iter().zip(values) {
            row.push(value);
        }
    }

    pub(super) fn swap_remove(&mut self, slot: usize) {
        for row in self.0.rows_mut() {
            row.swap_remove(slot);
        }
    }

    /// What the pair of a leaf with each leaf costs at least; for itself, something.
    ///
    /// Three bounds, each of its own term of the cost:
    /// - Hausdorff's distance, or that of the middles, is no less than the furthest that a side of
    ///   the box moves;
    /// - bend is what it is;
    /// - a quad within a ball of radius `r` has an area of `2 r²` at most: each of its triangles has
    ///   the diagonal for a side, at most `2 r`, and a height over it, of at most `r` on average for
    ///   the two. `r` is that of the least ball around both leaves' balls.
    ///
    /// All are taken a little lower than computed, so that rounding never makes them too high.
    pub(super) fn to(&self, slot: usize, weights: &Weights, least: &mut Vec<f32>) {
        let Outline {
            low,
            high,
            middle,
            radius,
            normal,
            area,
            seen,
        } = &self.0;
        let count = radius.len();
        // All lists cut to one length: the loop then needs no checks, and runs four lanes wide.
        let [low_x, low_y, low_z] = low.each_ref().map(|list| &list[..count]);
        let [high_x, high_y, high_z] = high.each_ref().map(|list| &list[..count]);
        let [x, y, z] = middle.each_ref().map(|list| &list[..count]);
        let [normal_x, normal_y, normal_z] = normal.each_ref().map(|list| &list[..count]);
        let (radius, area, seen) = (&radius[..count], &area[..count], &seen[..count]);
        least.clear();
        least.resize(count, 0.0);
        let least_area = weights.least_area();
        let greater = |a: f32, b: f32| if a > b { a } else { b };
        for (other, least) in least[..count].iter_mut().enumerate() {
            let far = |list: &[f32]| (list[slot] - list[other]).abs();
            let low = greater(greater(far(low_x), far(low_y)), far(low_z));
            let high = greater(greater(far(high_x), far(high_y)), far(high_z));
            let along = |list: &[f32]| list[slot] * list[other];
            let bend = 1.0 - (along(normal_x) + along(normal_y) + along(normal_z)).abs();
            let square = |list: &[f32]| (list[slot] - list[other]) * (list[slot] - list[other]);
            let apart = (square(x) + square(y) + square(z)).sqrt();
            let ball = greater(
                0.5 * (apart + (radius[slot] + radius[other])),
                greater(radius[slot], radius[other]),
            );
            let wanted = greater(area[slot] + area[other], least_area);
            let missing = greater(1.0 - 2.000_1 * (ball * ball) / wanted, 0.0);
            let placed = weights.placed(greater(low, high), greater(bend - 1e-6, 0.0));
            *least = weights.least(placed, missing, [seen[slot], seen[other]]);
        }
    }
}

impl<T> Outline<T> {
    fn into_rows(self) -> [T; 15] {
        let [a, b, c] = self.low;
        let [d, e, f] = self.high;
        let [g, h, i] = self.middle;
        let [j, k, l] = self.normal;
        [
            a,
            b,
            c,
            d,
            e,
            f,
            g,
            h,
            i,
            j,
            k,
            l,
            self.radius,
            self.area,
            self.seen,
        ]
    }

    fn rows_mut(&mut self) -> [&mut T; 15] {
        let [a, b, c] = &mut self.low;
        let [d, e, f] = &mut self.high;
        let [g, h, i] = &mut self.middle;
        let [j, k, l] = &mut self.normal;
        [
            a,
            b,
            c,
            d,
            e,
            f,
            g,
            h,
            i,
            j,
            k,
            l,
            &mut self.radius,
            &mut self.area,
            &mut self.seen,
        ]
    }
}

impl Outline<f32> {
    /// The outline of a leaf: `ends` are the least and the greatest coordinates, `area` and `seen` what
    /// the cost says of it.
    pub(super) fn of(shape: &Shape, ends: [Vec3; 2], area: f32, seen: f32) -> Self {
        let middle = shape.points.middle();
        let squares = shape
            .points
            .all()
            .map(|point| (point - middle).length_squared());
        let [low, high] = ends.map(|end| end.to_array());
        Self {
            low,
            high,
            middle: middle.to_array(),
            radius: squares.into_iter().fold(0.0, f32::max).sqrt(),
            normal: shape.normal.to_array(),
            area,
            seen,
        }
    }
}
