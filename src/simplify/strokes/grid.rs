//! Points as integers, so that it is decided without rounding on which side of a plane a point lies.
//!
//! Coordinates are counted in a unit of which the largest has between 2³⁹ and 2⁴⁰. A coordinate down
//! to a 65,536th of the largest is a whole number of units as it is, since an `f32` has 24 binary
//! digits; a smaller one is rounded to the nearest unit, by less than 10⁻¹² of the largest: of a tree
//! 10 m tall, five picometres. After that nothing is rounded: differences have 41 digits, the cross
//! product of two 83, its product with a third 126, so all fit `i128`. Expansions of floats would
//! spare that one rounding and cost branches in every sum; here a hull is exact for points that cannot
//! be told from the leaves' own, and the same on every machine.
//!
//! Most questions are answered by `f64` before, whose error is bounded; only points nearer to a plane
//! than some 10⁻¹⁵ of the extent are asked about in integers.

use std::cmp::Ordering;

use crate::math::Vec3;

/// Binary digits of the largest coordinate.
const DIGITS: i32 = 40;

/// Distinct points, in lexicographic order; what it holds are whole numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    /// Coordinates: integers of at most [`DIGITS`] digits, which `f64` holds without loss.
    points: Vec<[f64; 3]>,
    /// The originals at each point: `originals[firsts[p] .. firsts[p + 1]]`.
    originals: Vec<u32>,
    firsts: Vec<u32>,
    /// The largest difference of two coordinates on one axis.
    extent: f64,
}

impl Grid {
    /// The grid points of finite positions; equal ones become one.
    pub(super) fn new(positions: &[Vec3]) -> Self {
        let largest = positions.iter().fold(0.0_f32, |largest, position| {
            largest.max(position.abs().max_element())
        });
        let scale = power_of_two(DIGITS - exponent(largest));
        let on_grid = |value: f32| (f64::from(value) * scale).round_ties_even() + 0.0;
        let mut sorted: Vec<([f64; 3], u32)> = (0_u32..)
            .zip(positions)
            .map(|(original, at)| (at.to_array().map(on_grid), original))
            .collect();
        sorted.sort_unstable_by(|(first, a), (second, b)| {
            lexicographic(first, second).then(a.cmp(b))
        });
        let (mut points, mut firsts, mut originals) = (Vec::new(), Vec::new(), Vec::new());
        for (point, original) in sorted {
            if points.last() != Some(&point) {
                firsts.push(crate::math::index_u32(originals.len()));
                points.push(point);
            }
            originals.push(original);
        }
        firsts.push(crate::math::index_u32(originals.len()));
        let extent = (0..3).fold(0.0_f64, |extent, axis| {
            let values = points.iter().map(|point| point[axis]);
            let low = values.clone().fold(f64::INFINITY, f64::min);
            let high = values.fold(f64::NEG_INFINITY, f64::max);
            extent.max(high - low)
        });
        Self {
            points,
            originals,
            firsts,
            extent,
        }
    }

    /// How many distinct points there are.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The originals at a point, ascending.
    pub(super) fn originals(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.originals[self.firsts[point] as usize..self.firsts[point + 1] as usize]
    }

    /// The originals at some points, ascending.
    pub(super) fn originals_of(&self, points: &[u32]) -> Vec<u32> {
        let originals = points.iter().flat_map(|&point| self.originals(point));
        let mut originals: Vec<u32> = originals.copied().collect();
        originals.sort_unstable();
        originals
    }

    /// The coordinates of a point.
    #[inline]
    pub(super) fn at(&self, point: u32) -> [f64; 3] {
        self.points[point as usize]
    }

    /// The plane through three points.
    pub(super) fn plane(&self, [a, b, c]: [u32; 3]) -> Plane {
        let anchor = self.at(a);
        let u = minus(self.at(b), anchor);
        let v = minus(self.at(c), anchor);
        let products = [
            (u[1] * v[2], u[2] * v[1]),
            (u[2] * v[0], u[0] * v[2]),
            (u[0] * v[1], u[1] * v[0]),
        ];
        // Each product, the difference of two, and the sum of three round by at most five times
        // 2⁻⁵³ of these magnitudes together; eight leave room for rounding the bound itself.
        let magnitude = products
            .iter()
            .fold(0.0, |sum, (plus, minus)| sum + (plus.abs() + minus.abs()));
        Plane {
            anchor,
            normal: products.map(|(plus, minus)| plus - minus),
            slack: 8.0 * 0.5 * f64::EPSILON * magnitude * self.extent,
        }
    }

    /// On which side of the plane through three points a fourth lies: greater on that from which they
    /// turn counter-clockwise, equal within it. Exact.
    pub(super) fn side(&self, corners: [u32; 3], point: u32) -> Ordering {
        let plane = self.plane(corners);
        let height = plane.height(self.at(point));
        if height.abs() > plane.slack {
            height.total_cmp(&0.0)
        } else {
            self.exact_side(corners, point)
        }
    }

    /// [`Self::side`] in integers alone.
    pub(super) fn exact_side(&self, [a, b, c]: [u32; 3], point: u32) -> Ordering {
        let normal = self.exact_normal([a, b, c]);
        let offset = minus(self.at(point), self.at(a)).map(whole);
        let terms = [0, 1, 2].map(|axis: usize| normal[axis] * offset[axis]);
        (terms[0] + terms[1] + terms[2]).cmp(&0)
    }

    /// The cross product of two sides of a triangle; zero where its corners lie on a line.
    pub(super) fn exact_normal(&self, [a, b, c]: [u32; 3]) -> [i128; 3] {
        let u = minus(self.at(b), self.at(a)).map(whole);
        let v = minus(self.at(c), self.at(a)).map(whole);
        [
            u[1] * v[2] - u[2] * v[1],
            u[2] * v[0] - u[0] * v[2],
            u[0] * v[1] - u[1] * v[0],
        ]
    }
}

/// A plane, rounded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    anchor: [f64; 3],
    normal: [f64; 3],
    /// What heights may be wrong by.
    pub(super) slack: f64,
}

impl Plane {
    /// The height above the plane times the length of its normal.
    #[inline]
    pub(super) fn height(&self, point: [f64; 3]) -> f64 {
        let [x, y, z] = minus(point, self.anchor);
        let [a, b, c] = self.normal;
        a * x + b * y + c * z
    }
}

/// A difference of grid points: whole, and exact.
#[inline]
pub(super) fn minus(first: [f64; 3], second: [f64; 3]) -> [f64; 3] {
    [
        first[0] - second[0],
        first[1] - second[1],
        first[2] - second[2],
    ]
}

/// A whole number as an integer.
pub(super) fn whole(value: f64) -> i128 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "differences on the grid are whole and below 2⁴²"
    )]
    let whole = value as i64;
    i128::from(whole)
}

/// By x, then y, then z.
pub(super) fn lexicographic(first: &[f64; 3], second: &[f64; 3]) -> Ordering {
    let axes = first.iter().zip(second);
    axes.map(|(a, b)| a.total_cmp(b))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

/// The least `e` with `value < 2ᵉ`, for a finite number; 0 for 0.
fn exponent(value: f32) -> i32 {
    if value == 0.0 {
        return 0;
    }
    // As f64, every f32 is normal.
    let bits = f64::from(value).to_bits() >> 52 & 0x7ff;
    i32::try_from(bits).expect("eleven bits") - 1022
}

fn power_of_two(exponent: i32) -> f64 {
    let bits = u64::try_from(exponent + 1023).expect("f32 has exponents of -149 to 128");
    f64::from_bits(bits << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_kept_to_the_last_digit_or_rounded_by_a_trillionth() {
        let values = [1.0_f32, 0.1, 1e-4, 0.3e-3];
        let points: Vec<Vec3> = values.iter().map(|x| Vec3::new(*x, 1.0, -1.0)).collect();
        let grid = Grid::new(&points);
        assert_eq!(grid.len(), 4);
        for point in 0..4_u32 {
            let original = grid.originals(point)[0] as usize;
            let unit = power_of_two(-39);
            assert_eq!(grid.at(point)[0] * unit, f64::from(values[original]));
        }
        let tiny = Grid::new(&[Vec3::splat(1.0), Vec3::splat(1.0e-9)]);
        let error = tiny.at(0)[0] / power_of_two(39) - f64::from(1.0e-9_f32);
        assert!(error.abs() <= 0.5 / power_of_two(39), "{error}");
    }

    #[test]
    fn extreme_numbers_have_places() {
        let least = f32::from_bits(1);
        for largest in [0.0, least, f32::MIN_POSITIVE, 1.0, f32::MAX] {
            let grid = Grid::new(&[Vec3::splat(largest), Vec3::splat(-largest)]);
            let furthest = grid.at(0)[0].abs();
            assert!(furthest <= power_of_two(40), "{largest}: {furthest}");
            assert!(
                largest == 0.0 || furthest >= power_of_two(39),
                "{largest}: {furthest}"
            );
        }
    }

    #[test]
    fn equal_points_are_one_and_signs_of_zero_do_not_count() {
        let grid = Grid::new(&[Vec3::ZERO, Vec3::X, Vec3::new(-0.0, 0.0, -0.0), Vec3::X]);
        assert_eq!(grid.len(), 2);
        assert_eq!(grid.originals(0), [0, 2]);
        assert_eq!(grid.originals(1), [1, 3]);
    }

    /// In `f64`, 1 + 2⁻⁶⁰ is 1; in integers the side is known.
    #[test]
    fn sides_are_exact_where_floats_are_not() {
        let far = 1.0_f32;
        let near = far - f32::EPSILON / 2.0;
        let points = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(far, near, 0.1),
            Vec3::new(near, far, 0.1),
            Vec3::new(far, far, 0.1 + 1e-8),
            Vec3::new(0.5 * far, 0.5 * near, 0.05),
        ];
        let grid = Grid::new(&points);
        let place = |original: u32| {
            let found = (0..5).find(|point| grid.originals(*point) == [original]);
            found.expect("all are distinct")
        };
        let corners = [0, 1, 2].map(place);
        assert_eq!(grid.side(corners, place(4)), Ordering::Equal);
        let [a, b, c] = corners;
        for point in 0..5 {
            let side = grid.side(corners, point);
            assert_eq!(side, grid.exact_side(corners, point), "{point}");
            assert_eq!(side, grid.side([b, c, a], point), "{point}");
            assert_eq!(side, grid.side([b, a, c], point).reverse(), "{point}");
        }
    }
}
