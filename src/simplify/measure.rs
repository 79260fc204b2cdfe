//! What a set of quad leaves amounts to: area, folds.
//!
//! Everything is computed in `f64` from `f32` corners, in a stated order: differences of two `f32`
//! lose nothing that matters there, and no finite coordinate overflows.

use super::CollapseSequence;
use crate::math::{DVec3, Vec3};

/// The area of one quad leaf in the square of the vertices' unit: that of its triangles 0-1-2 and
/// 0-2-3.
///
/// # Panics
///
/// When a corner is no index into `vertices`.
#[must_use]
pub fn leaf_area(vertices: &[Vec3], corners: [u32; 4]) -> f64 {
    quad_area(quad(vertices, corners))
}

/// Whether the two triangles of a quad leaf face away from each other: their normals have a negative
/// dot product.
///
/// A triangle without area has no normal and folds with nothing.
///
/// # Panics
///
/// When a corner is no index into `vertices`.
#[must_use]
pub fn is_folded(vertices: &[Vec3], corners: [u32; 4]) -> bool {
    quad_is_folded(quad(vertices, corners))
}

/// What the leaves of one level amount to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafMeasure {
    /// How many leaves there are.
    pub leaves: u32,
    /// Their areas, added in the order of the leaves; square of the vertices' unit.
    pub area: f64,
    /// How many of them are [folded](is_folded).
    pub folded: u32,
}

/// Measures some leaves of a sequence, such as [`CollapseSequence::visible_after`] names them.
///
/// # Panics
///
/// When a leaf is no record of `sequence` or `vertices` are not those it was made from.
#[must_use]
pub fn measure_leaves(
    vertices: &[Vec3],
    sequence: &CollapseSequence,
    leaves: impl IntoIterator<Item = u32>,
) -> LeafMeasure {
    let mut measure = LeafMeasure {
        leaves: 0,
        area: 0.0,
        folded: 0,
    };
    for leaf in leaves {
        let corners = sequence.corners()[leaf as usize];
        measure.leaves += 1;
        measure.area += leaf_area(vertices, corners);
        measure.folded += u32::from(is_folded(vertices, corners));
    }
    measure
}

/// [`is_folded`] by positions.
pub(super) fn quad_is_folded(quad: [DVec3; 4]) -> bool {
    let [first, second] = triangle_normals(quad);
    first.dot(second) < 0.0
}

/// The area of a quad by positions.
pub(super) fn quad_area(quad: [DVec3; 4]) -> f64 {
    let [first, second] = triangle_normals(quad);
    0.5 * first.length() + 0.5 * second.length()
}

/// The corners' positions.
fn quad(vertices: &[Vec3], corners: [u32; 4]) -> [DVec3; 4] {
    corners.map(|corner| vertices[corner as usize].as_dvec3())
}

/// The cross products of triangles 0-1-2 and 0-2-3: twice their areas long.
fn triangle_normals([a, b, c, d]: [DVec3; 4]) -> [DVec3; 2] {
    let diagonal = c - a;
    [(b - a).cross(diagonal), diagonal.cross(d - a)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ```text
    /// 3---2
    /// |  /|
    /// | / |   two by one
    /// 0---1
    /// ```
    const RECTANGLE: [Vec3; 4] = [
        Vec3::ZERO,
        Vec3::new(2.0, 0.0, 0.0),
        Vec3::new(2.0, 1.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
    ];

    #[test]
    fn a_rectangle_has_the_area_of_its_sides() {
        assert_eq!(
            leaf_area(&RECTANGLE, [0, 1, 2, 3]).to_bits(),
            2_f64.to_bits()
        );
        assert!(!is_folded(&RECTANGLE, [0, 1, 2, 3]));
        assert!(!is_folded(&RECTANGLE, [3, 2, 1, 0]));
    }

    #[test]
    fn crossed_corners_fold_and_points_do_not() {
        // 0-1-2 turns one way, 0-2-3 the other.
        assert!(is_folded(&RECTANGLE, [0, 2, 1, 3]));
        assert!(!is_folded(&RECTANGLE, [1, 1, 1, 1]));
        assert_eq!(
            leaf_area(&RECTANGLE, [1, 1, 1, 1]).to_bits(),
            0_f64.to_bits()
        );
    }

    #[test]
    fn the_largest_coordinates_do_not_overflow() {
        let far = RECTANGLE.map(|corner| corner * (f32::MAX / 2.0));
        assert!(leaf_area(&far, [0, 1, 2, 3]).is_finite());
    }
}
