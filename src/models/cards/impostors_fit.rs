//! Where an impostor lies in its plane: the rectangle around its leaves.

use super::bake::{Rectangle, ViewFrame};
use crate::math::{DVec2, DVec3, Vec3};
use crate::simplify::Plane;

/// The rectangle of least area in a plane around the projections of points, and its axes.
///
/// ```text
///         up
///     ┌───┼──────┐     `right` runs along an edge of the projections' convex hull,
///     │  ·│·   · │     `toward` is the plane's normal, the origin the projection of
///     │ ──┼── right    the points' mean
///     └───┼──────┘
/// ```
///
/// [GSS05](crate::references), § 2.2 leaves the axes open. A rectangle of least area has a side along an
/// edge of the hull ([FS75](crate::references)), so all edges are tried; of equal areas the first
/// edge's is taken, counted from the hull's lowest, then leftmost corner. Points of which all
/// projections fall together, or into a line, have a rectangle along the axes of
/// [`axes_in`], or along the line. Computed in `f64`.
pub(super) fn least_rectangle(plane: Plane, points: &[Vec3]) -> (ViewFrame, Rectangle) {
    let toward = plane.normal.as_dvec3().normalize_or(DVec3::Y);
    let (first, second) = axes_in(toward);
    let count = points.len().max(1) as f64;
    let sum = points
        .iter()
        .fold(DVec3::ZERO, |sum, point| sum + point.as_dvec3());
    let mean = sum / count;
    let origin = mean - toward * (mean.dot(toward) + f64::from(plane.distance));
    let seen = points.iter().map(|point| {
        let from = point.as_dvec3() - origin;
        DVec2::new(from.dot(first), from.dot(second))
    });
    let hull = convex_hull(seen.collect());
    let mut best = (f64::INFINITY, DVec2::X);
    for (place, from) in hull.iter().enumerate() {
        let to = hull[(place + 1) % hull.len()];
        let Some(along) = (to - *from).try_normalize() else {
            continue;
        };
        let [least, greatest] = extent(&hull, along);
        let sides = greatest - least;
        let area = sides.x * sides.y;
        if area < best.0 {
            best = (area, along);
        }
    }
    let along = best.1;
    let right = first * along.x + second * along.y;
    let frame = ViewFrame {
        origin: origin.as_vec3(),
        right: right.as_vec3(),
        up: toward.cross(right).as_vec3(),
        toward: toward.as_vec3(),
    };
    // From the frame as it is rounded, so that it holds all points.
    let rectangle = Rectangle::around(&frame, points.iter().copied());
    (frame, rectangle)
}

/// Two unit vectors at right angles to a third and to each other, right-handed with it.
///
/// The first is at a right angle to the coordinate axis that lies nearest to the third's plane, the
/// first of equals.
pub(super) fn axes_in(toward: DVec3) -> (DVec3, DVec3) {
    let [x, y, z] = toward.to_array().map(f64::abs);
    let axis = if x <= y && x <= z {
        DVec3::X
    } else if y <= z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let first = axis.cross(toward).normalize_or(DVec3::X);
    (first, toward.cross(first))
}

/// The corners of the convex hull, counter-clockwise from the lowest, of equals the leftmost; without
/// corners that lie on an edge.
///
/// Andrew's monotone chain ([AND79](crate::references)), along the second axis.
pub(super) fn convex_hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    // With equal heights from left to right, going up keeps the hull on the left of its right side.
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..]
                && (last - before).perp_dot(point - last) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// The least and greatest coordinate of points along a unit vector and at a right angle to it.
fn extent(points: &[DVec2], along: DVec2) -> [DVec2; 2] {
    let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    points.iter().fold(none, |[least, greatest], point| {
        let at = DVec2::new(point.dot(along), along.perp_dot(*point));
        [least.min(at), greatest.max(at)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;

    const FLOOR: Plane = Plane {
        normal: Vec3::Z,
        distance: -2.0,
    };

    /// ```text
    ///      ◇        a square on its corner, with a point in the middle, above and below z = 2
    /// ```
    #[test]
    fn a_turned_square_has_its_own_rectangle() {
        let points = [
            Vec3::new(0.0, -1.0, 2.0),
            Vec3::new(1.0, 0.0, 2.5),
            Vec3::new(0.0, 1.0, 1.5),
            Vec3::new(-1.0, 0.0, 2.0),
            Vec3::new(0.0, 0.0, 7.0),
        ];
        let (frame, rectangle) = least_rectangle(FLOOR, &points);
        let sides = rectangle.sides();
        assert!((sides - Vec2::splat(2.0_f32.sqrt())).abs().max_element() < 1e-6);
        assert!((frame.right.cross(frame.up) - frame.toward).length() < 1e-6);
        assert!((frame.origin.z - 2.0).abs() < 1e-6, "{:?}", frame.origin);
        for point in points {
            let seen = frame.seen(point);
            assert!(seen.cmpge(rectangle.least).all() && seen.cmple(rectangle.greatest).all());
        }
    }

    #[test]
    fn few_points_have_a_rectangle_too() {
        for points in [
            &[][..],
            &[Vec3::ONE],
            &[Vec3::ONE; 5],
            &[Vec3::ZERO, Vec3::ONE],
        ] {
            let (frame, rectangle) = least_rectangle(FLOOR, points);
            assert!(frame.right.is_normalized() && frame.up.is_normalized());
            assert!(rectangle.sides().min_element() > 0.0);
        }
        let line = [Vec3::ZERO, Vec3::new(3.0, 4.0, 0.0)];
        let (frame, rectangle) = least_rectangle(FLOOR, &line);
        assert!((rectangle.sides().x - 5.0).abs() < 1e-5, "{frame:?}");
        assert!(rectangle.sides().y < 1e-3);
    }

    #[test]
    fn hulls_leave_out_what_lies_on_edges_and_within() {
        let at = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        let grid = (0..9).map(|cell| at(cell % 3, cell / 3)).collect();
        assert_eq!(convex_hull(grid), [at(0, 0), at(2, 0), at(2, 2), at(0, 2)]);
        assert_eq!(convex_hull(vec![at(1, 1); 4]), [at(1, 1)]);
        let line = (0..4).map(|x| at(x, 2 * x)).collect();
        assert_eq!(convex_hull(line), [at(0, 0), at(3, 6)]);
    }

    #[test]
    fn axes_are_right_handed() {
        for toward in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, -0.8, 0.0)] {
            let (first, second) = axes_in(toward);
            assert!((first.cross(second) - toward).length() < 1e-12);
        }
    }
}
