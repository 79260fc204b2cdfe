//! Edge functions and what is interpolated by them: exact integers, then `f32` in a stated order.

use fearless_simd::{Select, Simd, SimdBase, f32x8};

use super::setup::{Chunk, Triangle};
use super::view::{SUBPIXELS, inverse_w};
use super::{Fragment, MAX_VARYINGS, Pixel, PixelLanes};
use crate::math::Vec2;

/// The three edge functions of a triangle; the one numbered `k` is 0 on the edge that faces corner
/// `k` and positive within.
///
/// In units of half a square sub-pixel; their sum is twice the area everywhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edges {
    /// At the origin: sub-pixel (0, 0) of the target.
    origin: [i64; 3],
    /// Gained a sub-pixel to the right.
    pub(super) right: [i64; 3],
    /// Gained a sub-pixel downwards.
    pub(super) down: [i64; 3],
    /// Added before the comparison with 0: nothing on top and left edges, −1 on others.
    pub(super) bias: [i64; 3],
}

impl Edges {
    #[inline(always)]
    pub(super) fn of(triangle: &Triangle) -> Self {
        let mut edges = Self {
            origin: [0; 3],
            right: [0; 3],
            down: [0; 3],
            bias: [0; 3],
        };
        for facing in 0..3 {
            let (from, to) = ((facing + 1) % 3, (facing + 2) % 3);
            let (x, y) = (i64::from(triangle.x[from]), i64::from(triangle.y[from]));
            let dx = i64::from(triangle.x[to]) - x;
            let dy = i64::from(triangle.y[to]) - y;
            edges.origin[facing] = dy * x - dx * y;
            edges.right[facing] = -dy;
            edges.down[facing] = dx;
            // Left edges run upwards, top edges rightwards, since the area is positive.
            edges.bias[facing] = if dy < 0 || (dy == 0 && dx > 0) { 0 } else { -1 };
        }
        edges
    }

    /// The sum of all three, which is the same everywhere.
    #[inline(always)]
    fn twice_area(&self) -> i64 {
        self.origin[0] + self.origin[1] + self.origin[2]
    }

    /// At the centre of a pixel.
    #[inline(always)]
    pub(super) fn at_pixel(&self, x: i32, y: i32) -> [i64; 3] {
        let centre = |pixel: i32| i64::from(pixel * SUBPIXELS + SUBPIXELS / 2);
        let (x, y) = (centre(x), centre(y));
        let at = |k: usize| self.origin[k] + self.right[k] * x + self.down[k] * y;
        [at(0), at(1), at(2)]
    }
}

/// The depth of a triangle at a point given by its second and third edge functions.
#[inline(always)]
pub(super) fn depth_at(triangle: &Triangle, edges: [f32; 2]) -> f32 {
    let [second, third] = triangle.depth_slopes;
    super::view::clamp_depth(triangle.depth + (edges[0] * second + edges[1] * third))
}

/// The second and third edge functions as floats, each rounded once.
#[inline(always)]
pub(super) fn coordinates(edges: [i64; 2]) -> [f32; 2] {
    [edges[0] as f32, edges[1] as f32]
}

/// A quantity that is affine on the target: `base + (e₁ · slope₁ + e₂ · slope₂)`.
#[derive(Debug, Clone, Copy, Default)]
struct Plane {
    base: f32,
    slopes: [f32; 2],
}

impl Plane {
    #[inline(always)]
    fn new(at: [f32; 3], inverse_area: f32) -> Self {
        Self {
            base: at[0],
            slopes: [
                (at[1] - at[0]) * inverse_area,
                (at[2] - at[0]) * inverse_area,
            ],
        }
    }

    #[inline(always)]
    fn at(self, edges: [f32; 2]) -> f32 {
        self.base + self.change(edges)
    }

    #[inline(always)]
    fn lanes<S: Simd>(self, simd: S, edges: [f32x8<S>; 2]) -> f32x8<S> {
        let [second, third] = self.slopes;
        let change = edges[0] * f32x8::splat(simd, second) + edges[1] * f32x8::splat(simd, third);
        f32x8::splat(simd, self.base) + change
    }

    #[inline(always)]
    fn change(self, edges: [f32; 2]) -> f32 {
        edges[0] * self.slopes[0] + edges[1] * self.slopes[1]
    }
}

/// All that a fragment stage is told of the pixels of a triangle.
#[derive(Debug)]
pub(super) struct Attributes<'a> {
    inverse_w: Plane,
    /// The varyings over `w`.
    varyings: [Plane; MAX_VARYINGS],
    /// The second and third edge functions gained a pixel to the right, and downwards.
    steps: [[f32; 2]; 2],
    flats: &'a [f32],
    front: bool,
}

impl<'a> Attributes<'a> {
    #[inline(always)]
    pub(super) fn of<F: Fragment>(
        triangle: &Triangle,
        edges: &Edges,
        chunk: &'a Chunk<'_>,
    ) -> Self {
        let geometry = &*chunk.geometry;
        let inverse_area = 1.0 / edges.twice_area() as f32;
        let corners = triangle.corners.map(|corner| corner as usize);
        let over_w = if triangle.cut {
            corners.map(|corner| chunk.cut.inverse_w[corner])
        } else {
            let over = |corner: usize| inverse_w(f64::from(geometry.clip[corner].w));
            [over(corners[0]), over(corners[1]), over(corners[2])]
        };
        let mut varyings = [Plane::default(); MAX_VARYINGS];
        if triangle.cut {
            let at = corners.map(|corner| &chunk.cut.varyings[corner]);
            for (k, plane) in varyings[..F::VARYINGS].iter_mut().enumerate() {
                let values = std::array::from_fn(|c| at[c][k] * over_w[c]);
                *plane = Plane::new(values, inverse_area);
            }
        } else {
            let of = |corner: usize| &geometry.varyings[corner * F::VARYINGS..][..F::VARYINGS];
            let at = [of(corners[0]), of(corners[1]), of(corners[2])];
            for (k, plane) in varyings[..F::VARYINGS].iter_mut().enumerate() {
                let values = std::array::from_fn(|c| at[c][k] * over_w[c]);
                *plane = Plane::new(values, inverse_area);
            }
        }
        let pixel = i64::from(SUBPIXELS);
        let step = |gain: [i64; 3]| coordinates([gain[1] * pixel, gain[2] * pixel]);
        Self {
            inverse_w: Plane::new(over_w, inverse_area),
            varyings,
            steps: [step(edges.right), step(edges.down)],
            flats: &geometry.flats[triangle.primitive as usize * F::FLATS..][..F::FLATS],
            front: triangle.front,
        }
    }

    /// Hands `use_pixel` the pixel whose centre has these second and third edge functions.
    #[inline(always)]
    pub(super) fn pixel<F: Fragment, R>(
        &self,
        edges: [f32; 2],
        position: [u32; 2],
        depth: f32,
        use_pixel: impl FnOnce(&Pixel<'_>) -> R,
    ) -> R {
        let w = 1.0 / self.inverse_w.at(edges);
        let mut varyings = [0.0; MAX_VARYINGS];
        for (value, plane) in varyings[..F::VARYINGS].iter_mut().zip(&self.varyings) {
            *value = plane.at(edges) * w;
        }
        // (U / q)' = (U' − (U / q) q') / q, with U and q affine.
        let derivative = |step: [f32; 2]| {
            let change_of_inverse = self.inverse_w.change(step);
            let change =
                |k: usize| (self.varyings[k].change(step) - varyings[k] * change_of_inverse) * w;
            Vec2::new(
                if F::VARYINGS > 0 { change(0) } else { 0.0 },
                if F::VARYINGS > 1 { change(1) } else { 0.0 },
            )
        };
        use_pixel(&Pixel {
            varyings: &varyings,
            derivative_x: derivative(self.steps[0]),
            derivative_y: derivative(self.steps[1]),
            flats: self.flats,
            front: self.front,
            position,
            depth,
        })
    }

    /// The 8 pixels at these places whose centres have these second and third edge functions.
    #[inline(always)]
    pub(super) fn lanes<S: Simd, F: Fragment>(
        &self,
        simd: S,
        edges: [f32x8<S>; 2],
        positions: [[u32; 2]; LANES],
        depths: [f32; LANES],
    ) -> PixelLanes<'_, S> {
        let one = f32x8::splat(simd, 1.0);
        let w = one / self.inverse_w.lanes(simd, edges);
        let mut varyings = [f32x8::splat(simd, 0.0); MAX_VARYINGS];
        let planes = &self.varyings[..F::VARYINGS];
        for (varying, plane) in varyings.iter_mut().zip(planes) {
            *varying = plane.lanes(simd, edges) * w;
        }
        let mut derivatives = [[f32x8::splat(simd, 0.0); 2]; 2];
        for (derivatives, step) in derivatives.iter_mut().zip(self.steps) {
            let change_of_inverse = f32x8::splat(simd, self.inverse_w.change(step));
            for ((derivative, varying), plane) in derivatives.iter_mut().zip(varyings).zip(planes) {
                let change = f32x8::splat(simd, plane.change(step));
                *derivative = (change - varying * change_of_inverse) * w;
            }
        }
        PixelLanes {
            varyings,
            derivative_x: derivatives[0],
            derivative_y: derivatives[1],
            flats: self.flats,
            front: self.front,
            positions,
            depths,
        }
    }
}

/// Pixels whose attributes are computed together.
pub(super) const LANES: usize = 8;

/// The plane of a triangle's depth.
pub(super) struct DepthLanes<S: Simd> {
    base: f32x8<S>,
    slopes: [f32x8<S>; 2],
}

impl<S: Simd> DepthLanes<S> {
    #[inline(always)]
    pub(super) fn of(simd: S, triangle: &Triangle) -> Self {
        Self {
            base: f32x8::splat(simd, triangle.depth),
            slopes: [
                f32x8::splat(simd, triangle.depth_slopes[0]),
                f32x8::splat(simd, triangle.depth_slopes[1]),
            ],
        }
    }

    /// As [`depth_at`].
    #[inline(always)]
    pub(super) fn at(&self, simd: S, edges: [f32x8<S>; 2]) -> f32x8<S> {
        let depth = self.base + (edges[0] * self.slopes[0] + edges[1] * self.slopes[1]);
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let depth = depth.simd_gt(zero).select(depth, zero);
        depth.simd_lt(one).select(depth, one)
    }
}

/// Whether the edge functions of a triangle stay within 32 bits at all pixels of its box and up to a row
/// of lanes beside it.
///
/// With sides up to `s` sub-pixels a value is at most `2 s (s + 8 · 256)`, which is less than 2³¹.
#[inline(always)]
pub(super) fn fits_lanes(triangle: &Triangle) -> bool {
    const SIDE: i32 = 30_000;
    let side = |values: [i32; 3]| {
        let [least, greatest] = super::view::range_of(values);
        greatest - least
    };
    side(triangle.x) <= SIDE && side(triangle.y) <= SIDE
}

/// What an edge function of a triangle that [fits lanes](fits_lanes) gains a pixel.
#[inline(always)]
pub(super) fn step(subpixel: i64) -> i32 {
    narrow(subpixel * i64::from(SUBPIXELS))
}

/// An edge function, or a step of one, of a triangle that [fits lanes](fits_lanes).
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "sides are limited so that nothing is cut off"
)]
pub(super) fn narrow(value: i64) -> i32 {
    value as i32
}
