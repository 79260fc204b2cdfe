//! What is drawn of an impostor: its rectangle, or less.

use super::bake_resolve::BakedView;
use super::impostors_fit::convex_hull;
use super::impostors_set::Impostor;
use crate::math::{DVec2, Vec2, Vec3};

/// The most corners of an outline.
pub(super) const MOST_CORNERS: usize = 8;

/// A convex polygon in an impostor's plane, counter-clockwise seen from the front.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Outline {
    /// The corners, at least 3 and at most [`MOST_CORNERS`].
    pub(super) corners: Vec<OutlineCorner>,
}

/// A corner of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OutlineCorner {
    /// In the plant's space, on the impostor's plane.
    pub(super) position: Vec3,
    /// In the impostor's texture, (0, 0) the upper left corner.
    pub(super) coordinate: Vec2,
}

impl Outline {
    fn of(impostor: &Impostor, coordinates: impl IntoIterator<Item = Vec2>) -> Self {
        let corner = |coordinate| {
            let seen = impostor.rectangle.at(coordinate);
            OutlineCorner {
                position: impostor.frame.point(seen, 0.0),
                coordinate,
            }
        };
        Self {
            corners: coordinates.into_iter().map(corner).collect(),
        }
    }
}

/// The rectangle.
pub(super) fn rectangle_outline(impostor: &Impostor) -> Outline {
    let corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
    Outline::of(impostor, corners.map(|(u, v)| Vec2::new(u, v)))
}

/// Cells of the grid along a side of an impostor's texture by which it is trimmed.
///
/// Texels of all smaller versions of at least so many texels a side lie within a cell each, so the
/// outline holds what any of them shows. Cards that are less than about so many pixels wide may lose
/// half a pixel at their rim. More cells trim closer, and hold at fewer sizes.
const TRIM_CELLS: u32 = 32;

/// At most eight corners around all cells of a grid that are not wholly empty in any of the views, which
/// all have one size, and around what reading between texels of the size of cells makes of them.
///
/// The hull of these cells, each with half a cell around it, loses edges as long as it has too many:
/// always the edge whose neighbours, drawn on until they meet, add the least area, the first of equals.
/// What is left holds the hull, and is cut to the rectangle.
pub(super) fn trimmed_outline(impostor: &Impostor, views: &[BakedView]) -> Outline {
    let Some(&[width, height]) = views.first().map(|view| &view.size) else {
        return rectangle_outline(impostor);
    };
    let cell = (width.min(height) / TRIM_CELLS).max(1);
    let shows = |column: u32, row: u32| {
        let rows = (cell * row..(cell * (row + 1)).min(height)).map(|row| row as usize);
        let columns = (cell * column) as usize..(cell * (column + 1)).min(width) as usize;
        rows.into_iter().any(|row| {
            let row = row * width as usize;
            let texels = 4 * (row + columns.start)..4 * (row + columns.end);
            let mut alphas = views.iter().flat_map(|view| {
                let texels = &view.colour[texels.clone()];
                texels.iter().skip(3).step_by(4)
            });
            alphas.any(|&alpha| alpha > 0)
        })
    };
    let mut rims = Vec::new();
    for row in 0..height.div_ceil(cell) {
        let mut columns = (0..width.div_ceil(cell)).filter(|&column| shows(column, row));
        let first = columns.next();
        let last = columns.next_back().or(first);
        if let Some((first, last)) = first.zip(last) {
            for y in [f64::from(row) - 0.5, f64::from(row) + 1.5] {
                for x in [f64::from(first) - 0.5, f64::from(last) + 1.5] {
                    rims.push(DVec2::new(x, y) * f64::from(cell));
                }
            }
        }
    }
    let size = DVec2::new(f64::from(width), f64::from(height));
    let hull = convex_hull(rims);
    if hull.len() < 3 {
        return rectangle_outline(impostor);
    }
    let polygon = cut_to_unit(fewer_corners(hull, size));
    if !(3..=MOST_CORNERS).contains(&polygon.len()) {
        return rectangle_outline(impostor);
    }
    // Rows go down, so what goes counter-clockwise in texels goes clockwise as it is seen.
    let corners = polygon.into_iter().rev().map(|corner| corner.as_vec2());
    Outline::of(impostor, corners)
}

/// In texture coordinates, with few enough edges that the four of the rectangle may come to them.
fn fewer_corners(hull: Vec<DVec2>, size: DVec2) -> Vec<DVec2> {
    let mut corners: Vec<DVec2> = hull.into_iter().map(|corner| corner / size).collect();
    // Cutting one straight off adds one corner more at the most.
    while corners.len() > 3 && cut_to_unit(corners.clone()).len() > MOST_CORNERS {
        let count = corners.len();
        let mut best: Option<(f64, usize, DVec2)> = None;
        for edge in 0..count {
            let at = |step: usize| corners[(edge + count - 1 + step) % count];
            let Some(meeting) = meeting_point(at(0), at(1), at(2), at(3)) else {
                continue;
            };
            let area = (at(2) - at(1)).perp_dot(meeting - at(1)).abs();
            if best.is_none_or(|(least, ..)| area < least) {
                best = Some((area, edge, meeting));
            }
        }
        let Some((_, edge, meeting)) = best else {
            break;
        };
        let next = (edge + 1) % count;
        corners[edge] = meeting;
        corners.remove(next);
    }
    corners
}

/// Where the edge from `a` to `b`, drawn on, meets the edge from `c` to `d`, drawn back; `None` where
/// they do not.
fn meeting_point(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> Option<DVec2> {
    let (along, back) = (b - a, c - d);
    let across = along.perp_dot(back);
    // Both must turn to the left by less than a half turn together.
    if across >= -1e-12 {
        return None;
    }
    let on = (c - b).perp_dot(back) / across;
    let meets = b + along * on;
    (on >= 0.0 && meets.is_finite()).then_some(meets)
}

/// The part of a convex polygon within the unit square ([SH74](crate::references)).
fn cut_to_unit(mut corners: Vec<DVec2>) -> Vec<DVec2> {
    for (normal, least) in [
        (DVec2::X, 0.0),
        (DVec2::NEG_X, -1.0),
        (DVec2::Y, 0.0),
        (DVec2::NEG_Y, -1.0),
    ] {
        let inside = |corner: DVec2| corner.dot(normal) - least;
        let mut kept = Vec::with_capacity(corners.len() + 1);
        for (place, &from) in corners.iter().enumerate() {
            let to = corners[(place + 1) % corners.len()];
            let [here, there] = [inside(from), inside(to)];
            if here >= 0.0 {
                kept.push(from);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(from + (to - from) * (here / (here - there)));
            }
        }
        corners = kept;
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::models::cards::bake::{Rectangle, ViewFrame};
    use crate::simplify::Plane;

    /// In the plane z = 0, from (0, 0) to (4, 2).
    fn impostor() -> Impostor {
        let plane = Plane {
            normal: Vec3::Z,
            distance: 0.0,
        };
        Impostor {
            level: 0,
            plane,
            next: plane,
            frame: ViewFrame {
                origin: Vec3::ZERO,
                right: Vec3::X,
                up: Vec3::Y,
                toward: Vec3::Z,
            },
            rectangle: Rectangle {
                least: Vec2::ZERO,
                greatest: Vec2::new(4.0, 2.0),
            },
            sites: vec![0],
        }
    }

    /// 64 × 64 texels of which some show.
    fn view(shows: impl Fn(u32, u32) -> bool) -> BakedView {
        let texels = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
        let colour = texels.flat_map(|(x, y)| [0, 0, 0, 255 * u8::from(shows(x, y))]);
        BakedView {
            size: [64, 64],
            depths: [0.0, 1.0],
            colour: colour.collect(),
            normals: vec![0; 4 * 64 * 64],
        }
    }

    fn doubled_area(outline: &Outline) -> f32 {
        let corners = &outline.corners;
        let next = corners.iter().cycle().skip(1);
        let pairs = corners.iter().zip(next);
        pairs
            .map(|(a, b)| a.position.truncate().perp_dot(b.position.truncate()))
            .sum()
    }

    #[test]
    fn a_rectangle_is_counter_clockwise_and_upright() {
        let outline = rectangle_outline(&impostor());
        assert_eq!(doubled_area(&outline), 16.0);
        let lower_left = outline.corners[0];
        assert_eq!(
            (lower_left.position, lower_left.coordinate),
            (Vec3::ZERO, Vec2::Y)
        );
    }

    #[test]
    fn a_disc_is_trimmed_to_eight_corners_that_hold_it() {
        let shows = |x: u32, y: u32| {
            let [x, y] = [x, y].map(|at| at as f32 - 31.5);
            x * x + y * y < 900.0
        };
        let outline = trimmed_outline(&impostor(), &[view(shows), view(|_, _| false)]);
        assert!(
            (4..=MOST_CORNERS).contains(&outline.corners.len()),
            "{outline:?}"
        );
        let area = doubled_area(&outline);
        // An octagon around a disc of 30 texels has 0.73 of the square; half a cell more is added.
        assert!((11.6..15.0).contains(&area), "{area}");
        let corners = outline.corners.iter().map(|corner| corner.coordinate);
        let corners: Vec<Vec2> = corners.collect();
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let point = (Vec2::new(x as f32, y as f32) + 0.5) / 64.0;
            let next = corners.iter().cycle().skip(1);
            // Counter-clockwise as it is seen is clockwise with rows that go down.
            let inside = corners
                .iter()
                .zip(next)
                .all(|(a, b)| (*b - *a).perp_dot(point - *a) <= 1e-6);
            assert!(inside || !shows(x, y), "{point}");
        }
    }

    #[test]
    fn what_fills_or_is_empty_keeps_its_rectangle() {
        for all in [true, false] {
            let outline = trimmed_outline(&impostor(), &[view(|_, _| all)]);
            assert_eq!(outline.corners.len(), 4);
            assert!((doubled_area(&outline) - 16.0).abs() < 1e-5);
        }
    }
}
