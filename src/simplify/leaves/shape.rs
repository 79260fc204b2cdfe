//! Leaves as the simplifier compares them, and what they are like on average.

use crate::math::{DVec3, Vec3, Vec4};

/// A quad leaf, ready to be compared with others; small, since much of the time goes into fetching
/// leaves from memory.
///
/// Lengths are in units near the mean spacing of the leaves: world units times a power of two, which
/// loses nothing and keeps products away from the ends of the range of `f32`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Vertex numbers by corner role.
    pub(super) corners: [u32; 4],
    /// Their positions.
    pub(super) points: Four,
    /// The normalised cross product of the diagonals; zero for a leaf without area.
    pub(super) normal: Vec3,
    /// The area of the originals under it.
    pub(super) original_area: f64,
}

impl Shape {
    pub(super) fn new(corners: [u32; 4], points: Four, original_area: f64) -> Self {
        let [a, b, c, d] = points.lanes().map(Vec3::as_dvec3);
        Self {
            corners,
            points,
            normal: (c - a).cross(d - b).normalize_or_zero().as_vec3(),
            original_area,
        }
    }
}

/// Four points or vectors, coordinate by coordinate: the order in which a processor takes all four
/// at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Four {
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) z: Vec4,
}

impl Four {
    pub(super) fn new([a, b, c, d]: [Vec3; 4]) -> Self {
        Self {
            x: Vec4::new(a.x, b.x, c.x, d.x),
            y: Vec4::new(a.y, b.y, c.y, d.y),
            z: Vec4::new(a.z, b.z, c.z, d.z),
        }
    }

    pub(super) fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    pub(super) fn lanes(&self) -> [Vec3; 4] {
        [self.lane(0), self.lane(1), self.lane(2), self.lane(3)]
    }

    /// The ways from `point` to these points.
    pub(super) fn from(&self, point: Vec3) -> Self {
        Self {
            x: self.x - point.x,
            y: self.y - point.y,
            z: self.z - point.z,
        }
    }

    /// The cross product of each with `other`.
    pub(super) fn cross(&self, other: Vec3) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// The dot product of each with its counterpart.
    pub(super) fn dot(&self, other: &Self) -> Vec4 {
        (self.x * other.x + self.y * other.y) + self.z * other.z
    }

    pub(super) fn length_squared(&self) -> Vec4 {
        self.dot(self)
    }

    /// The same lanes in another order, or some of them twice.
    pub(super) fn pick(&self, lanes: [usize; 4]) -> Self {
        Self {
            x: pick(self.x, lanes),
            y: pick(self.y, lanes),
            z: pick(self.z, lanes),
        }
    }
}

/// The same lanes in another order, or some of them twice.
#[inline]
pub(super) fn pick(four: Vec4, [a, b, c, d]: [usize; 4]) -> Vec4 {
    Vec4::new(four[a], four[b], four[c], four[d])
}

pub(super) fn square_root(four: Vec4) -> Vec4 {
    Vec4::new(four.x.sqrt(), four.y.sqrt(), four.z.sqrt(), four.w.sqrt())
}

/// What the leaves of a foliage are like, so that costs have no unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// The mean distance of neighbouring leaves: the side of the cube that one leaf has to itself.
    pub(super) spacing: f64,
    /// The mean area of a leaf.
    pub(super) area: f64,
    /// The mean [`form`] of a leaf.
    pub(super) form: f64,
}

impl Scale {
    pub(super) fn of(leaves: &[[DVec3; 4]]) -> Self {
        let count = leaves.len().max(1) as f64;
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        let (mut area, mut forms) = (0.0, 0.0);
        for [a, b, c, d] in leaves {
            low = low.min(a.min(*b).min(c.min(*d)));
            high = high.max(a.max(*b).max(c.max(*d)));
            let edges = (b.distance_squared(*a) + c.distance_squared(*b))
                + (d.distance_squared(*c) + a.distance_squared(*d));
            let vector = (c - a).cross(d - b).length();
            area += 0.5 * vector;
            forms += if edges > 0.0 {
                2.0 * vector / edges
            } else {
                0.0
            };
        }
        let extent = (high - low).max(DVec3::ZERO);
        let longest = extent.max_element();
        // Flat and thin foliage has its volume in a slab, so that no distance is infinitely far.
        let solid = extent.max(DVec3::splat(longest / 1024.0));
        let of_box = libm::cbrt(solid.x / count) * libm::cbrt(solid.y) * libm::cbrt(solid.z);
        let or_one = |value: f64| if value > 0.0 { value } else { 1.0 };
        let of_box = or_one(of_box);
        // Much of the box is empty: only cells with leaves count.
        let cells = occupied_cells(leaves, low, of_box);
        Self {
            spacing: of_box * libm::cbrt(cells / count),
            area: or_one(area / count),
            form: or_one(forms / count),
        }
    }

    /// The power of two that brings the spacing to between 1 and 2.
    pub(super) fn unit(&self) -> f64 {
        let exponent = self.spacing.to_bits() >> 52;
        f64::from_bits((2046 - exponent) << 52)
    }
}

/// How many cells of a grid hold the middle of a leaf, at least 1.
fn occupied_cells(leaves: &[[DVec3; 4]], low: DVec3, cell: f64) -> f64 {
    let along = |distance: f64| -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 1024 cells times the cube root of the leaf count, and saturating"
        )]
        let cell = (distance / cell) as u64;
        cell.min((1 << 21) - 1)
    };
    let mut cells: Vec<u64> = leaves
        .iter()
        .map(|[a, b, c, d]| {
            let at = 0.25 * ((a + b) + (c + d)) - low;
            along(at.x) | along(at.y) << 21 | along(at.z) << 42
        })
        .collect();
    cells.sort_unstable();
    cells.dedup();
    cells.len().max(1) as f64
}
