//! A box of a placed plant in clip space: whether it may show at all, and where, and how near.

use super::Placement;
use crate::math::{Aabb, Mat4, Vec3, Vec4, whole_u32};

/// The corners of a placed box in clip space.
#[derive(Debug)]
pub(super) struct ClipBox {
    /// `x`, `y`, `z`, `w` of each corner.
    corners: [[f32; 4]; 8],
    /// What bounds the terms that each coordinate is summed from.
    terms: [f32; 4],
}

/// Where on a target something may show: columns and rows from the first to the last, none where the
/// last is before the first; and how near at most, as depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    pub(super) first: [u32; 2],
    pub(super) last: [u32; 2],
    pub(super) nearest: f32,
}

impl ClipBox {
    pub(super) fn new(clip_from_world: &Mat4, placement: &Placement, bounds: &Aabb) -> Self {
        let farthest = bounds.min.abs().max(bounds.max.abs()).length();
        let size = placement.position.abs() + Vec3::splat(placement.scale * farthest);
        let rows = [0, 1, 2, 3].map(|row| clip_from_world.row(row));
        let terms = rows.map(|row: Vec4| row.truncate().abs().dot(size) + row.w.abs());
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: u32| {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    bounds.min[axis]
                } else {
                    bounds.max[axis]
                }
            };
            let point = placement.to_world(Vec3::new(pick(0), pick(1), pick(2)));
            rows.map(|row| row.truncate().dot(point) + row.w)
        });
        Self { corners, terms }
    }

    /// Whether all of it lies outside of one plane of clip space, by more than a vertex in it can be
    /// moved by rounding.
    pub(super) fn is_out_of_sight(&self) -> bool {
        // A few roundings of numbers as large as these, each by 2⁻²⁴ at most; 2⁻¹⁶ leaves ample room.
        const ROUNDING: f32 = 1.0 / 65_536.0;
        let [x_room, y_room, z_room, w_room] = self.terms.map(|terms| ROUNDING * terms);
        // Inside is where all six are at least 0.
        let mut outside = [true; 6];
        for [x, y, z, w] in self.corners {
            let insides = [
                w + x + w_room + x_room,
                w - x + w_room + x_room,
                w + y + w_room + y_room,
                w - y + w_room + y_room,
                z + z_room,
                w - z + w_room + z_room,
            ];
            for (all, inside) in outside.iter_mut().zip(insides) {
                // What is no number is drawn.
                *all &= inside < 0.0;
            }
        }
        outside.contains(&true)
    }

    /// Where anything in it may show on a target of `size` pixels; `None` where that cannot be told,
    /// since it may reach the near plane, where projecting ends.
    ///
    /// What is in a box before the viewer is projected into what its corners enclose: a point is a
    /// mean of corners, and a quotient of means lies between the quotients of the corners.
    pub(super) fn reach(&self, size: [u32; 2]) -> Option<Reach> {
        // A vertex is turned (16 roundings at most), moved (1) and taken through a row of the matrix
        // (4), each of at most 2⁻²⁴ of the sum of terms, and so is a corner of the box: 42 of them,
        // below 2⁻¹⁸. Culling in depth lives on this being small: at 100 m from a camera whose near
        // plane is at 0.1 m, 2⁻¹⁸ is about a metre.
        const ROUNDING: f32 = 1.0 / 262_144.0;
        // Depth is interpolated in `f32` from corners within [0, 1]; the rasterizer itself allows for
        // 2⁻²⁰.
        const DEPTH_ROUNDING: f32 = 1.0 / 524_288.0;
        let [x_room, y_room, z_room, w_room] = self.terms.map(|terms| ROUNDING * terms);
        let (mut least, mut greatest) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        let mut nearest = f32::INFINITY;
        for [x, y, z, w] in self.corners {
            let before = z - z_room > 0.0 && w - w_room > 0.0;
            if !(before && x.is_finite() && y.is_finite()) {
                return None;
            }
            for w in [w - w_room, w + w_room] {
                for (axis, (at, room)) in [(x, x_room), (y, y_room)].into_iter().enumerate() {
                    least[axis] = least[axis].min((at - room) / w);
                    greatest[axis] = greatest[axis].max((at + room) / w);
                }
                nearest = nearest.min((z - z_room) / w);
            }
        }
        // A pixel further to each side is more than vertices are moved by snapping to sub-pixels, and
        // than is rounded here.
        let pixels = |side: u32, from: f32, to: f32| {
            let at = |place: f32| f64::from(side) / 2.0 * (f64::from(place) + 1.0);
            let last = whole_u32(at(to) + 1.0).min(side.saturating_sub(1));
            (whole_u32(at(from) - 1.0), last)
        };
        let (left, right) = pixels(size[0], least[0], greatest[0]);
        // Rows run downwards.
        let (top, bottom) = pixels(size[1], -greatest[1], -least[1]);
        Some(Reach {
            first: [left, top],
            last: [right, bottom],
            nearest: nearest - DEPTH_ROUNDING,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One unit of the world is one of clip space, seen in parallel.
    fn seen(min: [f32; 3], max: [f32; 3]) -> ClipBox {
        let bounds = Aabb {
            min: Vec3::from_array(min),
            max: Vec3::from_array(max),
        };
        ClipBox::new(&Mat4::IDENTITY, &Placement::IDENTITY, &bounds)
    }

    #[test]
    fn a_box_reaches_a_pixel_beyond_where_it_lies() {
        let reach = seen([-0.5, 0.0, 0.25], [0.0, 0.75, 0.5]).reach([16, 16]);
        let reach = reach.expect("before the viewer");
        // Columns 4 to 8, rows from 1 − 0.75 down to 1 − 0.
        assert_eq!((reach.first, reach.last), ([2, 0], [9, 9]));
        assert!(reach.nearest < 0.25 && reach.nearest > 0.2499);
    }

    #[test]
    fn what_touches_the_near_plane_cannot_be_told() {
        assert_eq!(seen([0.0; 3], [0.5; 3]).reach([16, 16]), None);
        assert_eq!(seen([0.0; 3], [f32::NAN; 3]).reach([16, 16]), None);
        assert_eq!(
            seen([f32::INFINITY; 3], [f32::MAX; 3]).reach([16, 16]),
            None
        );
    }

    #[test]
    fn beside_the_target_there_is_no_pixel() {
        let beside = seen([1.5, 0.0, 0.25], [2.0, 0.5, 0.5]);
        let reach = beside.reach([16, 16]).expect("before the viewer");
        assert!(reach.first[0] > reach.last[0], "{reach:?}");
        assert!(beside.is_out_of_sight());
        assert!(!seen([0.5, 0.0, 0.25], [2.0, 0.5, 0.5]).is_out_of_sight());
    }
}
