//! Quadrics: how far a point is from many planes.

use crate::math::DVec3;

/// A weighted sum of squared distances to planes.
///
/// For planes `n · x + d = 0` with `|n| = 1` and weights `w` it keeps `A = Σ w n nᵀ`, `b = Σ w d n` and
/// `c = Σ w d²`, the ten numbers of [GH97](crate::references), section 5; the sum of squared
/// distances of `x` is `xᵀ A x + 2 b · x + c`. In `f64`, since the terms of far-away planes cancel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Quadric {
    /// `xx, yy, zz` of `A`.
    squares: DVec3,
    /// `yz, zx, xy` of `A`.
    products: DVec3,
    linear: DVec3,
    constant: f64,
}

impl Quadric {
    /// The plane through `point` with a unit `normal`.
    pub(super) fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let offset = -normal.dot(point);
        let weighted = normal * weight;
        Self {
            squares: weighted * normal,
            products: DVec3::new(
                weighted.y * normal.z,
                weighted.z * normal.x,
                weighted.x * normal.y,
            ),
            linear: weighted * offset,
            constant: weight * offset * offset,
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.squares += other.squares;
        self.products += other.products;
        self.linear += other.linear;
        self.constant += other.constant;
    }

    /// The weighted sum of squared distances of a point, at least 0.
    pub(super) fn at(&self, point: DVec3) -> f64 {
        let crossed = DVec3::new(point.y * point.z, point.z * point.x, point.x * point.y);
        let square = self.squares.dot(point * point) + 2.0 * self.products.dot(crossed);
        let sum = square + 2.0 * self.linear.dot(point) + self.constant;
        // Also what is no number, of coordinates beyond all trees, becomes 0.
        if sum > 0.0 { sum } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_two_planes_add_up_by_weight() {
        let mut quadric = Quadric::plane(DVec3::X, DVec3::new(1.0, 5.0, 5.0), 2.0);
        let slanted = DVec3::new(0.0, 0.6, 0.8);
        quadric.add(&Quadric::plane(slanted, DVec3::ZERO, 1.0));
        // Two from x = 1, and 3 · 0.6 + 1 · 0.8 = 2.6 from the slanted one.
        let found = quadric.at(DVec3::new(3.0, 3.0, 1.0));
        assert!((found - (2.0 * 4.0 + 2.6 * 2.6)).abs() < 1e-12, "{found}");
        assert!(quadric.at(DVec3::new(1.0, 0.8, -0.6)) < 1e-12);
    }
}
