//! Eight primitives at a time onto the target: most of a forest ends here, between two samples.
//!
//! Lanes compute what [`View::project`] does, operation by operation.

use fearless_simd::{Bytes, Simd, SimdBase, SimdMask, f64x8, i32x8, u64x8};

use super::Geometry;
use super::clip::LEAST_W;
use super::reach::Cover;
use super::setup::DEPTH_ERROR;
use super::view::{FURTHEST, Projected, ROUND, View, clamp_depth};

/// Primitives that are projected together.
pub(super) const TOGETHER: usize = 8;

/// The corners of eight primitives on the target.
#[derive(Debug)]
pub(super) struct Projection<const CORNERS: usize> {
    x: [[i32; TOGETHER]; CORNERS],
    y: [[i32; TOGETHER]; CORNERS],
    depth: [[f32; TOGETHER]; CORNERS],
    /// A bit for each primitive that must be looked at alone: a corner names no vertex, is no number, or
    /// lies where it must be cut.
    pub(super) alone: u64,
    /// A bit for each of the others whose box holds a sample.
    pub(super) seen: u64,
}

impl<const CORNERS: usize> Projection<CORNERS> {
    /// Of up to eight primitives, all their corners one after another.
    #[inline(always)]
    pub(super) fn new<S: Simd>(simd: S, view: &View, geometry: &Geometry, corners: &[u32]) -> Self {
        let mut projection = Self {
            x: [[0; TOGETHER]; CORNERS],
            y: [[0; TOGETHER]; CORNERS],
            depth: [[0.0; TOGETHER]; CORNERS],
            alone: 0,
            seen: 0,
        };
        let count = corners.len() / CORNERS;
        let there = (1_u64 << count) - 1;
        let vertices = geometry.clip.len().min(geometry.vertex_ids.len());
        let mut alone = 0_u64;
        for corner in 0..CORNERS {
            let mut at = [[0.0_f64; TOGETHER]; 4];
            for lane in 0..count {
                let vertex = corners[lane * CORNERS + corner] as usize;
                if vertex < vertices {
                    let clip = geometry.clip[vertex];
                    at[0][lane] = f64::from(clip.x);
                    at[1][lane] = f64::from(clip.y);
                    at[2][lane] = f64::from(clip.z);
                    at[3][lane] = f64::from(clip.w);
                } else {
                    alone |= 1 << lane;
                }
            }
            let lanes = [
                f64x8::from_slice(simd, &at[0]),
                f64x8::from_slice(simd, &at[1]),
                f64x8::from_slice(simd, &at[2]),
                f64x8::from_slice(simd, &at[3]),
            ];
            alone |= !projection.corner(simd, view, corner, lanes) & there;
        }
        projection.alone = alone;
        projection.seen = projection.seen(simd, view) & there & !alone;
        projection
    }

    /// Projects one corner of each; answers a bit for each that needs no cut.
    #[inline(always)]
    fn corner<S: Simd>(
        &mut self,
        simd: S,
        view: &View,
        corner: usize,
        lanes: [f64x8<S>; 4],
    ) -> u64 {
        let onto = Onto::the_target(simd, view, lanes);
        snap(simd, onto.at[0], &mut self.x[corner]);
        snap(simd, onto.at[1], &mut self.y[corner]);
        self.depth[corner] = onto.depth;
        onto.within
    }

    /// A bit for each whose box holds a sample.
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, view: &View) -> u64 {
        let shown = view.shown();
        let [least_sample, greatest_sample] = view.samples();
        let mut seen = u64::MAX;
        for axis in 0..2 {
            let values = if axis == 0 { &self.x } else { &self.y };
            let mut least = i32x8::from_slice(simd, &values[0]);
            let mut greatest = least;
            for value in &values[1..] {
                let value = i32x8::from_slice(simd, value);
                least = least.min(value);
                greatest = greatest.max(value);
            }
            let first = (least + i32x8::splat(simd, 255 - greatest_sample)) >> 8;
            let last = (greatest - i32x8::splat(simd, least_sample + 1)) >> 8;
            let first = first.max(i32x8::splat(simd, shown.first[axis]));
            let last = last.min(i32x8::splat(simd, shown.last[axis]));
            seen &= first.simd_le(last).to_bitmask();
        }
        seen
    }

    /// A bit for each that is seen and that is not behind what is there already.
    #[inline(always)]
    pub(super) fn uncovered(&self, view: &View, cover: &Cover<'_>) -> u64 {
        let mut uncovered = self.seen;
        let mut rest = self.seen;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % TOGETHER;
            rest &= rest - 1;
            let (mut x, mut y) = ([self.x[0][lane]; 2], [self.y[0][lane]; 2]);
            let mut nearest = self.depth[0][lane];
            for corner in 1..CORNERS {
                let (px, py) = (self.x[corner][lane], self.y[corner][lane]);
                x = [x[0].min(px), x[1].max(px)];
                y = [y[0].min(py), y[1].max(py)];
                nearest = nearest.min(self.depth[corner][lane]);
            }
            let hidden = view
                .pixels(x, y)
                .is_none_or(|pixels| cover.hides(pixels, nearest - DEPTH_ERROR));
            uncovered &= !(u64::from(hidden) << lane);
        }
        uncovered
    }

    /// Three corners of a primitive.
    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize, corners: [usize; 3]) -> [Projected; 3] {
        [
            self.at(lane, corners[0]),
            self.at(lane, corners[1]),
            self.at(lane, corners[2]),
        ]
    }

    #[inline(always)]
    fn at(&self, lane: usize, corner: usize) -> Projected {
        Projected {
            x: self.x[corner][lane],
            y: self.y[corner][lane],
            depth: self.depth[corner][lane],
        }
    }
}

/// Eight vertices on the target, not snapped yet.
pub(super) struct Onto<S: Simd> {
    /// A bit for each that needs no cut.
    pub(super) within: u64,
    /// Where they lie, in sub-pixels.
    pub(super) at: [f64x8<S>; 2],
    pub(super) depth: [f32; TOGETHER],
    /// One over `w`.
    pub(super) inverse_w: f64x8<S>,
}

impl<S: Simd> Onto<S> {
    #[inline(always)]
    pub(super) fn the_target(simd: S, view: &View, [x, y, z, w]: [f64x8<S>; 4]) -> Self {
        let zero = f64x8::splat(simd, 0.0);
        let guard = view.volume.guard();
        let wide = [
            f64x8::splat(simd, guard[0]) * w,
            f64x8::splat(simd, guard[1]) * w,
        ];
        // What is no number or infinite fails one of these, but w alone, which the last one catches.
        let within = w.simd_ge(f64x8::splat(simd, LEAST_W)).to_bitmask()
            & z.simd_ge(zero).to_bitmask()
            & z.simd_le(w).to_bitmask()
            & x.simd_le(wide[0]).to_bitmask()
            & (zero - x).simd_le(wide[0]).to_bitmask()
            & y.simd_le(wide[1]).to_bitmask()
            & (zero - y).simd_le(wide[1]).to_bitmask()
            & w.simd_lt(f64x8::splat(simd, f64::INFINITY)).to_bitmask();
        let inverse_w = f64x8::splat(simd, 1.0) / w;
        let half = view.half();
        let (width, height) = (f64x8::splat(simd, half[0]), f64x8::splat(simd, half[1]));
        let across = width + x * inverse_w * width;
        let down = height - y * inverse_w * height;
        let mut computed = [0.0; TOGETHER];
        (z * inverse_w).store_slice(&mut computed);
        let mut depths = [0.0; TOGETHER];
        for (kept, computed) in depths.iter_mut().zip(computed) {
            *kept = depth(computed);
        }
        Self {
            within,
            at: [across, down],
            depth: depths,
            inverse_w,
        }
    }
}

/// As [`snap`](super::view::snap) does.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "the integer lies in the last 32 bits"
)]
pub(super) fn snap<S: Simd>(simd: S, subpixels: f64x8<S>, snapped: &mut [i32; TOGETHER]) {
    let (least, greatest) = (f64x8::splat(simd, -FURTHEST), f64x8::splat(simd, FURTHEST));
    let kept = subpixels.max(least).min(greatest);
    let rounded: u64x8<S> = (kept + f64x8::splat(simd, ROUND)).bitcast();
    let mut bits = [0_u64; TOGETHER];
    rounded.store_slice(&mut bits);
    for lane in 0..TOGETHER {
        snapped[lane] = bits[lane] as u32 as i32;
    }
}

#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "depths are f32, rounded once"
)]
fn depth(depth: f64) -> f32 {
    clamp_depth(depth as f32)
}
