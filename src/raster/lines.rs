//! Blended lines: set up eight at a time, kept as what they are, one record each instead of two triangles.
//!
//! ```text
//!            q ────────── r        p and q lie to the left of the line from its first to its second
//!  first end │            │ …      end, s and r to the right; triangles are p-q-r and p-r-s
//! ```
//!
//! Lanes compute what [`stroke`] does, operation by operation. Only lines that are blended at one sample a
//! pixel, without an alpha test, go this way; others are triangles from the start.

use std::borrow::Cow;
use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, dispatch, f64x8};

use super::bin::Grid;
use super::clip::ClipVertex;
use super::line_records::{Ends, Line, Lines};
use super::project::{Onto, TOGETHER, snap as snap_lanes};
use super::reach::Reach;
use super::setup::{Chunk, CutVertices, check, widen};
use super::source::{ALL, PART, Part};
use super::view::{Projected, SUBPIXELS, View, inverse_w, snap};
use super::{Batch, Blend, Geometry, MAX_VARYINGS, Samples, Topology};
use crate::math::index_u32;

/// Lines of a part, one after the other, that may show on a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) tile: u32,
    first: u16,
    end: u16,
}

impl Run {
    /// The run in a number that is less than `u32::MAX`.
    pub(super) fn code(self) -> u32 {
        u32::from(self.end) << 16 | u32::from(self.first)
    }

    /// The lines of a run told by its number.
    pub(super) fn lines(code: u32) -> Range<usize> {
        (code & 0xFFFF) as usize..(code >> 16) as usize
    }
}

/// Whether the primitives of a batch are kept as lines.
pub(super) fn are_lines(view: &View, batch: &Batch<'_>) -> bool {
    batch.topology == Topology::LineList
        && batch.blend == Blend::Alpha
        && view.count() == Samples::One
        && !batch.kernel.tests_alpha()
}

/// Parts of a batch of lines that are set up together.
///
/// A tile looks at a few lines of each: with more of them it finds fewer places to look at. Flats are read
/// from the geometry of one part.
pub(super) fn parts_together(batch: &Batch<'_>) -> usize {
    if batch.kernel.flats() == 0 {
        TOGETHER_PARTS
    } else {
        1
    }
}

const TOGETHER_PARTS: usize = 16;
const _: () = assert!(
    PART * TOGETHER_PARTS < 0xFFFF,
    "places of lines have 16 bits"
);

/// Sets up some parts of a batch of lines, of which the number and the first part are told.
pub(super) fn set_up<'a>(view: &View, batch: &Batch<'a>, [number, part]: [u32; 2]) -> Chunk<'a> {
    let first = part as usize;
    let parts = batch.geometry.parts(batch.topology);
    let last = parts.min(first + parts_together(batch));
    let varyings = batch.kernel.varyings();
    let room = (last - first) * PART;
    let mut lines = Lines::new(varyings, batch.kernel.flats(), room);
    let (mut kept, mut spare) = (Cow::Owned(Geometry::default()), Geometry::default());
    for part in first..last {
        let Part {
            geometry,
            primitives,
        } = batch.geometry.part(part, batch.topology, ALL, spare);
        check(batch, &geometry);
        let mut builder = Builder {
            view,
            geometry: &geometry,
            lines,
        };
        let corners = &geometry.corners[2 * primitives.start..2 * primitives.end];
        let primitive = index_u32(primitives.start);
        dispatch!(view.level, simd => builder.all(simd, corners, primitive));
        lines = builder.lines;
        spare = Geometry::default();
        if batch.kernel.flats() > 0 {
            kept = geometry;
        } else if let Cow::Owned(geometry) = geometry {
            spare = geometry;
        }
    }
    lines.end();
    Chunk {
        batch: number,
        part,
        wanted: ALL,
        geometry: kept,
        triangles: Vec::new(),
        cut: CutVertices::default(),
        lines,
    }
}

impl Lines {
    /// Where they may show, and the runs of lines on each tile, those of a tile in order; `None` if there
    /// are none.
    pub(super) fn sort(&self, view: &View, grid: Grid) -> Option<(Reach, Vec<Run>)> {
        /// Further back nobody looks for a run that goes on.
        const BACK: usize = 8;
        let mut runs: Vec<Run> = Vec::new();
        let mut reach: Option<Reach> = None;
        for (place, number) in (0..self.count()).zip(0_u16..) {
            let line = self.line(place, self.varyings_each());
            let Some(pixels) = line.pixels(view) else {
                continue;
            };
            let here = Reach {
                pixels,
                nearest: 0.0,
            };
            reach = Some(reach.map_or(here, |reach| reach.and(here)));
            let [columns, rows] = grid.tiles(pixels);
            let apart = columns.len() > 1 && rows.len() > 1;
            // Backwards the corners are clockwise to the eye: of positive area with rows downwards.
            let [x, y] = [line.x, line.y].map(|[p, q, r, s]| [s, r, q, p]);
            for row in rows {
                for column in columns.clone() {
                    if apart && !grid.touches(x, y, column, row) {
                        continue;
                    }
                    let tile = index_u32(row * grid.columns + column);
                    let open = runs.iter_mut().rev().take(BACK);
                    let mut open = open.filter(|run| run.tile == tile && run.end == number);
                    match open.next() {
                        Some(run) => run.end = number + 1,
                        None => runs.push(Run {
                            tile,
                            first: number,
                            end: number + 1,
                        }),
                    }
                }
            }
        }
        Some((reach?, runs))
    }
}

/// What is left of a line on the target.
#[derive(Debug)]
pub(super) struct Stroke {
    /// The corners of the geometry, the one with the lower vertex id first.
    pub(super) corners: [u32; 2],
    /// The vertex id of the first of them.
    pub(super) vertex: u32,
    pub(super) ends: [ClipVertex; 2],
    /// The rectangle of width 1 around it, its ends cut square.
    pub(super) rectangle: [Projected; 4],
}

/// Cuts and projects one line; `None` when nothing is left.
pub(super) fn stroke(view: &View, geometry: &Geometry, corners: [u32; 2]) -> Option<Stroke> {
    let [a, b] = corners;
    let id = |corner: u32| geometry.vertex_ids.get(corner as usize).copied();
    let (vertex, other) = (id(a)?, id(b)?);
    let corners = if vertex <= other { [a, b] } else { [b, a] };
    let clip = corners.map(|corner| geometry.clip[corner as usize]);
    if !clip.iter().all(|position| position.is_finite()) {
        return None;
    }
    let ends = view.volume.clip_line(clip.map(widen))?;
    let [from, to] = ends.map(|end| view.subpixels(end.position));
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = (dx * dx + dy * dy).sqrt();
    if length == 0.0 {
        return None;
    }
    // Half a pixel to the side on which the rectangle turns counter-clockwise to the eye.
    let half = f64::from(SUBPIXELS / 2);
    let side = [dy / length * half, -dx / length * half];
    let [a, b] = ends.map(|end| view.project(end.position));
    let beside = |end: Projected, at: [f64; 2], sign: f64| Projected {
        x: snap(at[0] + sign * side[0]),
        y: snap(at[1] + sign * side[1]),
        ..end
    };
    Some(Stroke {
        corners,
        vertex,
        ends,
        rectangle: [
            beside(a, from, -1.0),
            beside(b, to, -1.0),
            beside(b, to, 1.0),
            beside(a, from, 1.0),
        ],
    })
}

struct Builder<'b> {
    view: &'b View,
    geometry: &'b Geometry,
    lines: Lines,
}

/// One end of eight lines.
#[derive(Default)]
struct End {
    /// Which corner of the geometry it is.
    corner: [u32; TOGETHER],
    /// The coordinates in clip space.
    clip: [[f32; TOGETHER]; 4],
    depth: [f32; TOGETHER],
    inverse_w: [f32; TOGETHER],
}

impl Builder<'_> {
    /// Eight lines at a time, as far as they need not be cut.
    #[inline(always)]
    fn all<S: Simd>(&mut self, simd: S, corners: &[u32], first: u32) {
        let mut primitive = first;
        for corners in corners.chunks(2 * TOGETHER) {
            self.eight(simd, corners, primitive);
            primitive += index_u32(TOGETHER);
        }
    }

    #[inline(always)]
    fn eight<S: Simd>(&mut self, simd: S, corners: &[u32], first: u32) {
        let geometry = self.geometry;
        let count = corners.len() / 2;
        let vertices = geometry.clip.len().min(geometry.vertex_ids.len());
        let (mut one, mut other) = (End::default(), End::default());
        let mut alone = 0_u64;
        for lane in 0..count {
            let (mut a, mut b) = (corners[2 * lane], corners[2 * lane + 1]);
            let (place_a, place_b) = (a as usize, b as usize);
            if place_a >= vertices || place_b >= vertices {
                alone |= 1 << lane;
                continue;
            }
            if geometry.vertex_ids[place_a] > geometry.vertex_ids[place_b] {
                (a, b) = (b, a);
            }
            one.gather(geometry, lane, a);
            other.gather(geometry, lane, b);
        }
        let (within_one, from) = one.project(simd, self.view);
        let (within_other, to) = other.project(simd, self.view);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).sqrt();
        let zero = f64x8::splat(simd, 0.0);
        let long = length.simd_gt(zero).to_bitmask();
        let half = f64x8::splat(simd, f64::from(SUBPIXELS / 2));
        let side = [dy / length * half, (zero - dx) / length * half];
        let [mut x, mut y] = [[[0; TOGETHER]; 4]; 2];
        snap_lanes(simd, from[0] - side[0], &mut x[0]);
        snap_lanes(simd, from[1] - side[1], &mut y[0]);
        snap_lanes(simd, to[0] - side[0], &mut x[1]);
        snap_lanes(simd, to[1] - side[1], &mut y[1]);
        snap_lanes(simd, to[0] + side[0], &mut x[2]);
        snap_lanes(simd, to[1] + side[1], &mut y[2]);
        snap_lanes(simd, from[0] + side[0], &mut x[3]);
        snap_lanes(simd, from[1] + side[1], &mut y[3]);
        let there = (1_u64 << count) - 1;
        alone |= !(within_one & within_other) & there;
        let mut rest = (long & there) | alone;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % TOGETHER;
            rest &= rest - 1;
            let primitive = first + index_u32(lane);
            if alone >> lane & 1 == 1 {
                self.alone(primitive, [corners[2 * lane], corners[2 * lane + 1]]);
                continue;
            }
            let line = Line {
                x: [x[0][lane], x[1][lane], x[2][lane], x[3][lane]],
                y: [y[0][lane], y[1][lane], y[2][lane], y[3][lane]],
                depth: [one.depth[lane], other.depth[lane]],
                inverse_w: [one.inverse_w[lane], other.inverse_w[lane]],
                primitive,
            };
            if line.pixels(self.view).is_some() {
                let ends = self.whole(one.corner[lane], other.corner[lane]);
                self.lines.push(&line, &ends);
            }
        }
    }

    /// The varyings of a line that is not cut: sums of three with two weights of 0, as cutting has them.
    #[inline(always)]
    fn whole(&self, one: u32, other: u32) -> Ends {
        let count = self.lines.varyings_each();
        let of = |corner: u32| &self.geometry.varyings[corner as usize * count..][..count];
        let (one, other) = (of(one), of(other));
        let mut ends = [[0; MAX_VARYINGS]; 2];
        for varying in 0..count.min(MAX_VARYINGS) {
            let (a, b) = (one[varying], other[varying]);
            ends[0][varying] = (a + b * 0.0 + b * 0.0).to_bits();
            ends[1][varying] = (a * 0.0 + b + b * 0.0).to_bits();
        }
        ends
    }

    /// A line that may have to be cut.
    #[inline(never)]
    fn alone(&mut self, primitive: u32, corners: [u32; 2]) {
        let Some(stroke) = stroke(self.view, self.geometry, corners) else {
            return;
        };
        let [p, q, ..] = stroke.rectangle;
        let line = Line {
            x: stroke.rectangle.map(|corner| corner.x),
            y: stroke.rectangle.map(|corner| corner.y),
            depth: [p.depth, q.depth],
            inverse_w: stroke.ends.map(|end| inverse_w(end.position[3])),
            primitive,
        };
        if line.pixels(self.view).is_none() {
            return;
        }
        let mut cut = CutVertices::default();
        let count = self.lines.varyings_each();
        for end in &stroke.ends {
            cut.push_end(self.geometry, count, stroke.corners, end);
        }
        let mut ends = [[0; MAX_VARYINGS]; 2];
        for (end, varyings) in ends.iter_mut().zip(&cut.varyings) {
            for (bits, value) in end.iter_mut().zip(varyings).take(count) {
                *bits = value.to_bits();
            }
        }
        self.lines.push(&line, &ends);
    }
}

impl End {
    #[inline(always)]
    fn gather(&mut self, geometry: &Geometry, lane: usize, corner: u32) {
        let clip = geometry.clip[corner as usize];
        self.corner[lane] = corner;
        self.clip[0][lane] = clip.x;
        self.clip[1][lane] = clip.y;
        self.clip[2][lane] = clip.z;
        self.clip[3][lane] = clip.w;
    }

    /// Answers a bit for each that needs no cut, and where they lie, in sub-pixels.
    #[inline(always)]
    fn project<S: Simd>(&mut self, simd: S, view: &View) -> (u64, [f64x8<S>; 2]) {
        let mut at = [[0.0_f64; TOGETHER]; 4];
        for (at, clip) in at.iter_mut().zip(&self.clip) {
            for (at, &clip) in at.iter_mut().zip(clip) {
                *at = f64::from(clip);
            }
        }
        let lanes = [
            f64x8::from_slice(simd, &at[0]),
            f64x8::from_slice(simd, &at[1]),
            f64x8::from_slice(simd, &at[2]),
            f64x8::from_slice(simd, &at[3]),
        ];
        let onto = Onto::the_target(simd, view, lanes);
        self.depth = onto.depth;
        let mut over = [0.0; TOGETHER];
        onto.inverse_w.store_slice(&mut over);
        for (kept, over) in self.inverse_w.iter_mut().zip(over) {
            *kept = rounded(over);
        }
        (onto.within, onto.at)
    }
}

#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "attributes are f32, rounded once"
)]
fn rounded(inverse_w: f64) -> f32 {
    inverse_w as f32
}
