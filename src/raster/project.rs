//! Eight primitives at a time onto the target: most of a forest ends here, between two samples.
//!
//! Lanes compute what [`View::project`] does, operation by operation.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdMask, f64x8, i32x8, u64x8};

use super::Geometry;
use super::clip::LEAST_W;
use super::reach::Cover;
use super::setup::DEPTH_ERROR;
use super::view::{FURTHEST, Projected, ROUND, SUBPIXELS, View, clamp_depth};

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
    seen: u64,
    /// A bit for each of these that is so small that all its samples were looked at.
    pub(super) small: u64,
    /// The first pixel of each of them: columns, rows.
    first: [[i32; TOGETHER]; 2],
    /// By triangle and by each of four pixels, from the first to the right and downwards: a bit for each of
    /// them that covers the sample.
    covered: [[u64; 4]; 2],
}

/// A primitive with longer sides is not small, in sub-pixels.
const SMALL_SIDE: i32 = 8192;

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
            small: 0,
            first: [[0; TOGETHER]; 2],
            covered: [[0; 4]; 2],
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
        projection.look(simd, view, there & !alone);
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

    /// Finds which of the wanted have a sample in their box, and which samples small ones cover.
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, view: &View, wanted: u64) {
        let shown = view.shown();
        let [least_sample, greatest_sample] = view.samples();
        let mut seen = wanted;
        let mut small = if least_sample == greatest_sample {
            wanted
        } else {
            0
        };
        let mut firsts = [i32x8::splat(simd, 0); 2];
        let mut steps = [i32x8::splat(simd, 0); 2];
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
            let step = last - first;
            seen &= step.simd_ge(i32x8::splat(simd, 0)).to_bitmask();
            small &= step.simd_le(i32x8::splat(simd, 1)).to_bitmask()
                & (greatest - least)
                    .simd_le(i32x8::splat(simd, SMALL_SIDE))
                    .to_bitmask();
            first.store_slice(&mut self.first[axis]);
            (firsts[axis], steps[axis]) = (first, step);
        }
        self.seen = seen;
        self.small = small & seen;
        if self.small != 0 {
            self.look_closer(simd, firsts, steps);
        }
    }

    /// Finds which samples small primitives cover, by the same edge functions as
    /// [`Edges`](super::plane::Edges).
    #[inline(always)]
    fn look_closer<S: Simd>(&mut self, simd: S, firsts: [i32x8<S>; 2], steps: [i32x8<S>; 2]) {
        let zero = i32x8::splat(simd, 0);
        let centre = [
            (firsts[0] << 8) + i32x8::splat(simd, SUBPIXELS / 2),
            (firsts[1] << 8) + i32x8::splat(simd, SUBPIXELS / 2),
        ];
        let mut x = [zero; 4];
        let mut y = [zero; 4];
        for corner in 0..CORNERS {
            x[corner] = i32x8::from_slice(simd, &self.x[corner]);
            y[corner] = i32x8::from_slice(simd, &self.y[corner]);
        }
        // The second triangle has the third edge the other way round, and two more.
        let ends = [[0, 1], [1, 2], [2, 0], [2, 3], [3, 0]];
        let mut edges = [[zero; 3]; 5];
        let mut biases = [zero; 5];
        let sides = if CORNERS == 3 { 3 } else { 5 };
        for side in 0..sides {
            let [from, to] = ends[side];
            let (dx, dy) = (x[to] - x[from], y[to] - y[from]);
            let at = dx * (centre[1] - y[from]) - dy * (centre[0] - x[from]);
            edges[side] = [at, zero - (dy << 8), dx << 8];
            let top_left = dy.simd_lt(zero) | (dy.simd_eq(zero) & dx.simd_gt(zero));
            biases[side] = top_left.select(zero, i32x8::splat(simd, -1));
        }
        let there = [
            u64::MAX,
            steps[0].simd_ge(i32x8::splat(simd, 1)).to_bitmask(),
            steps[1].simd_ge(i32x8::splat(simd, 1)).to_bitmask(),
        ];
        let there = [there[0], there[1], there[2], there[1] & there[2]];
        for triangle in 0..CORNERS - 2 {
            let sides = if triangle == 0 { [0, 1, 2] } else { [3, 4, 2] };
            let (first, second, mut shared) = (edges[sides[0]], edges[sides[1]], edges[2]);
            let mut shared_bias = biases[2];
            if triangle == 1 {
                // The edge between the two, the other way round.
                shared = [zero - shared[0], zero - shared[1], zero - shared[2]];
                shared_bias = i32x8::splat(simd, -1) - shared_bias;
            }
            let area = first[0] + second[0] + shared[0];
            // Everything changes its sign with the area, and edges that were no top or left ones are.
            let turned = area >> 31;
            let beyond = [
                (biases[sides[0]] ^ turned) - turned,
                (biases[sides[1]] ^ turned) - turned,
                (shared_bias ^ turned) - turned,
            ];
            let some = !area.simd_eq(zero).to_bitmask() & self.small;
            let (mut a, mut b, mut c) = (first[0], second[0], shared[0]);
            for (pixel, there) in there.into_iter().enumerate() {
                let outside = ((a ^ turned) + beyond[0])
                    | ((b ^ turned) + beyond[1])
                    | ((c ^ turned) + beyond[2]);
                self.covered[triangle][pixel] = outside.simd_ge(zero).to_bitmask() & some & there;
                // To the right, to the left and downwards, to the right.
                if pixel == 1 {
                    a += first[2] - first[1];
                    b += second[2] - second[1];
                    c += shared[2] - shared[1];
                } else {
                    a += first[1];
                    b += second[1];
                    c += shared[1];
                }
            }
        }
    }

    /// By triangle, a bit for each primitive of which it may cover a sample and is not behind what is there
    /// already.
    #[inline(always)]
    pub(super) fn shown(&self, view: &View, cover: Option<&Cover<'_>>) -> [u64; 2] {
        let large = self.seen & !self.small;
        let mut shown = [large; 2];
        for (shown, pixels) in shown.iter_mut().zip(&self.covered) {
            *shown |= pixels[0] | pixels[1] | pixels[2] | pixels[3];
        }
        let Some(cover) = cover else {
            return shown;
        };
        let mut rest = shown[0] | shown[1];
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % TOGETHER;
            rest &= rest - 1;
            let mut nearest = self.depth[0][lane];
            for depth in &self.depth[1..] {
                nearest = nearest.min(depth[lane]);
            }
            let nearest = nearest - DEPTH_ERROR;
            if self.small >> lane & 1 == 1 {
                let [column, row] = [self.first[0][lane], self.first[1][lane]];
                for (shown, pixels) in shown.iter_mut().zip(&self.covered) {
                    let mut hidden = true;
                    let places = [[0, 0], [1, 0], [0, 1], [1, 1]];
                    for (covered, [right, down]) in pixels.iter().zip(places) {
                        let at = [column + right, row + down];
                        hidden &= covered >> lane & 1 == 0 || cover.hides_pixel(at, nearest);
                    }
                    *shown &= !(u64::from(hidden) << lane);
                }
                continue;
            }
            let (mut x, mut y) = ([self.x[0][lane]; 2], [self.y[0][lane]; 2]);
            for corner in 1..CORNERS {
                let (px, py) = (self.x[corner][lane], self.y[corner][lane]);
                x = [x[0].min(px), x[1].max(px)];
                y = [y[0].min(py), y[1].max(py)];
            }
            let hidden = view
                .pixels(x, y)
                .is_none_or(|pixels| cover.hides(pixels, nearest));
            let hidden = u64::from(hidden) << lane;
            shown = [shown[0] & !hidden, shown[1] & !hidden];
        }
        shown
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

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::math::Vec4;
    use crate::raster::Samples;

    /// Whether a triangle covers the centre of some pixel of a target of 16 by 16, by the rule itself.
    fn covers(corners: [[i32; 2]; 3]) -> bool {
        let [a, b, c] = corners;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let corners = if area < 0 { [a, c, b] } else { [a, b, c] };
        let inside = |x: i32, y: i32| {
            (0..3).all(|k| {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
                let edge = dx * (y - from[1]) - dy * (x - from[0]);
                edge > 0 || (edge == 0 && (dy < 0 || (dy == 0 && dx > 0)))
            })
        };
        area != 0 && (0..256).any(|at| inside(at % 16 * 256 + 128, at / 16 * 256 + 128))
    }

    #[test]
    fn small_quads_cover_what_edge_functions_say() {
        let mut state = 3_u32;
        let mut next = |count: i32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            i32::try_from(state >> 12).expect("20 bits") % count
        };
        let view = View::new(16, 16, Samples::One);
        let corners: Vec<u32> = (0..32).collect();
        let (mut small, mut covered) = (0, 0);
        for round in 0..2000 {
            // On sub-pixels, or on centres and rims of pixels, where ties are.
            let grid = [1, 64, 128][round % 3];
            let mut at = Vec::new();
            for _ in 0..8 {
                let base = [next(4096), next(4096)];
                for _ in 0..4 {
                    at.push(base.map(|base| (base + next(600)) / grid * grid));
                }
            }
            let clip = at.iter().map(|&[x, y]| {
                let [x, y] = [x, y].map(|at| at as f32 / 2048.0 - 1.0);
                Vec4::new(x, -y, 0.5, 1.0)
            });
            let geometry = Geometry {
                clip: clip.collect(),
                vertex_ids: corners.clone(),
                ..Geometry::default()
            };
            for level in [Level::new(), Level::fallback()] {
                let projection = dispatch!(level, simd => {
                    Projection::<4>::new(simd, &view, &geometry, &corners)
                });
                let shown = projection.shown(&view, None);
                for (lane, quad) in at.chunks_exact(4).enumerate() {
                    for (triangle, shown) in shown.into_iter().enumerate() {
                        let corners = [quad[0], quad[triangle + 1], quad[triangle + 2]];
                        let (told, truth) = (shown >> lane & 1 == 1, covers(corners));
                        let is_small = projection.small >> lane & 1 == 1;
                        assert!(told || !truth, "{corners:?}");
                        assert!(told == truth || !is_small, "{corners:?}");
                        small += usize::from(is_small);
                        covered += usize::from(is_small && truth);
                    }
                }
            }
        }
        assert!(small > 20_000 && covered > 5000, "{small} and {covered}");
    }
}
