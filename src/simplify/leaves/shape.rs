//! Leaves as the simplifier compares them, and what they are like on average.

use crate::math::{DVec3, Vec3};

/// A quad leaf, ready to be compared with others; small, since much of the time goes into fetching
/// leaves from memory.
///
/// Lengths are in [`Scale::unit`], in which products of four of them stay within the range of `f32`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Vertex numbers by corner role.
    pub(super) corners: [u32; 4],
    /// Their positions.
    pub(super) points: Four,
    /// The normalised cross product of the diagonals; zero for a leaf without area.
    pub(super) normal: Vec3,
    /// The originals under it.
    pub(super) under: Originals,
}

/// The originals that a leaf stands for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Originals {
    /// How many there are.
    pub(super) count: u32,
    /// Their areas together.
    pub(super) area: f64,
    /// What is seen of them, in what is seen of a mean original.
    pub(super) seen: f32,
}

impl Originals {
    /// Both together.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            count: self.count.saturating_add(other.count),
            area: self.area + other.area,
            seen: self.seen + other.seen,
        }
    }
}

impl Shape {
    pub(super) fn new(corners: [u32; 4], points: Four, under: Originals) -> Self {
        let [a, b, c, d] = points.all().map(Vec3::as_dvec3);
        Self {
            corners,
            points,
            normal: (c - a).cross(d - b).normalize_or_zero().as_vec3(),
            under,
        }
    }
}

/// Four points, coordinate by coordinate: the order in which a processor takes all four at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Four {
    pub(super) x: [f32; 4],
    pub(super) y: [f32; 4],
    pub(super) z: [f32; 4],
}

impl Four {
    pub(super) fn new([a, b, c, d]: [Vec3; 4]) -> Self {
        Self {
            x: [a.x, b.x, c.x, d.x],
            y: [a.y, b.y, c.y, d.y],
            z: [a.z, b.z, c.z, d.z],
        }
    }

    pub(super) fn at(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// The mean of the four.
    pub(super) fn middle(&self) -> Vec3 {
        let [a, b, c, d] = self.all();
        0.25 * ((a + b) + (c + d))
    }

    /// The longer diagonal.
    pub(super) fn extent(&self) -> f32 {
        let [a, b, c, d] = self.all();
        (c - a).length().max((d - b).length())
    }

    pub(super) fn all(&self) -> [Vec3; 4] {
        [self.at(0), self.at(1), self.at(2), self.at(3)]
    }
}

/// What the leaves of a foliage are like, so that costs have no unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scale {
    /// Units a world unit: the power of two that brings the spacing to between 1 and 2, so that
    /// nothing is lost.
    pub(super) unit: f64,
    /// The side of the cube that one leaf has to itself, where there are leaves at all; in units.
    pub(super) spacing: f64,
    /// The mean area of a leaf, in square units.
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
        for &quad in leaves {
            let [a, b, c, d] = quad;
            low = low.min(a.min(b).min(c.min(d)));
            high = high.max(a.max(b).max(c.max(d)));
            area += 0.5 * (c - a).cross(d - b).length();
            forms += form(quad);
        }
        let extent = (high - low).max(DVec3::ZERO);
        let longest = extent.max_element();
        // Flat and thin foliage has its volume in a slab, so that no distance is infinitely far.
        let solid = extent.max(DVec3::splat(longest / 1024.0));
        let of_box = libm::cbrt(solid.x / count) * libm::cbrt(solid.y) * libm::cbrt(solid.z);
        let of_box = if of_box > 0.0 { of_box } else { 1.0 };
        // Most of the box is empty: only cells with leaves count.
        let spacing = of_box * libm::cbrt(occupied_cells(leaves, low, of_box) / count);
        let unit = power_of_two_below(1.0 / spacing);
        Self {
            unit,
            spacing: unit * spacing,
            area: unit * (unit * area) / count,
            form: forms / count,
        }
    }
}

/// How compact a quad is: its vector area over that of a square with edges as long; 1 for a flat
/// square, less for a sliver and for a bent or twisted quad, 0 for a point.
fn form([a, b, c, d]: [DVec3; 4]) -> f64 {
    let edges = (b.distance_squared(a) + c.distance_squared(b))
        + (d.distance_squared(c) + a.distance_squared(d));
    if edges > 0.0 {
        2.0 * (c - a).cross(d - b).length() / edges
    } else {
        0.0
    }
}

/// How many cells of a grid hold the middle of a leaf, at least 1.
fn occupied_cells(leaves: &[[DVec3; 4]], low: DVec3, cell: f64) -> f64 {
    let along = |distance: f64| -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and a slab is at most 1024 ∛leaves cells long"
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

/// The largest power of two that is not above a positive, normal number.
fn power_of_two_below(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & (0x7ff << 52))
}
