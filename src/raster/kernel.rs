//! The fragment stage: what decides whether a pixel is there and which colour it has.

use fearless_simd::{Simd, SimdBase, f32x8};

use super::by_sample;
use super::passes::Passes;
use crate::math::{Vec2, Vec4};

/// The most floats a vertex that are interpolated.
pub const MAX_VARYINGS: usize = 8;

/// The most floats a primitive that are constant over it.
pub const MAX_FLATS: usize = 8;

/// A fragment stage: pure functions of a pixel, compiled into the tile loop.
///
/// Attributes are those at the pixel's centre, also where several samples are taken.
pub trait Fragment: Send + Sync + std::fmt::Debug {
    /// Floats a vertex that are interpolated, at most [`MAX_VARYINGS`]. By convention a texture
    /// coordinate, if there is one, comes first: its derivatives choose the mip level.
    const VARYINGS: usize;
    /// Floats a primitive that are constant over it, at most [`MAX_FLATS`].
    const FLATS: usize;
    /// Whether [`keeps`](Self::keeps) may answer `false`.
    const TESTS_ALPHA: bool;

    /// The alpha test: whether the pixel is there at all.
    fn keeps(&self, pixel: &Pixel<'_>) -> bool;

    /// The same of eight pixels of one triangle, a bit each; of those without a bit in `wanted` it does
    /// not matter. Must answer for each what [`keeps`](Self::keeps) does, which it asks unless written.
    #[inline(always)]
    fn keeps_lanes<S: Simd>(&self, _: S, pixels: &PixelLanes<'_, S>, wanted: u64) -> u64 {
        pixels.each(wanted, |pixel| self.keeps(pixel))
    }

    /// Whether [`keeps`](Self::keeps) answers `true` whatever the pixel, so that it need not be asked.
    fn keeps_all(&self) -> bool {
        !Self::TESTS_ALPHA
    }

    /// Whether the loops that test the alpha of eight pixels at a time are compiled for this stage, which
    /// takes long. Where not, or where it decides by the sample, opaque triangles are decided pixel by
    /// pixel: the same picture, later.
    const IN_LANES: bool = true;

    /// Whether the samples of opaque fragments that are there follow from [`alpha`](Self::alpha), in
    /// place of [`keeps`](Self::keeps).
    const COVERAGE: bool = false;

    /// How much of the pixel is covered, from 0 to 1; asked of opaque fragments where
    /// [`COVERAGE`](Self::COVERAGE) says so, for an order in which samples drop out see the
    /// [rule book](crate::raster).
    fn alpha(&self, _: &Pixel<'_>) -> f32 {
        1.0
    }

    /// Whether opaque fragments may show at another depth than their triangle's. Such triangles cost
    /// more: none is left out early but by [`nearer_by`](Self::nearer_by).
    const MOVES_DEPTH: bool = false;

    /// What is added to the depth of the triangle at each sample of the pixel, to the eye where it is
    /// less than 0; asked where [`MOVES_DEPTH`](Self::MOVES_DEPTH) says so. [`shade`](Self::shade) is
    /// told the depth at the pixel's centre with it, all else without.
    fn depth_offset(&self, _: &Pixel<'_>) -> f32 {
        0.0
    }

    /// The most that [`depth_offset`](Self::depth_offset) takes off: it is cut there. The less, the more
    /// is known to be hidden without asking.
    fn nearer_by(&self) -> f32 {
        f32::INFINITY
    }

    /// Texels that one [`keeps`](Self::keeps) or [`alpha`](Self::alpha), with one
    /// [`depth_offset`](Self::depth_offset), reads; counted under exact counters.
    fn texels_tested(&self) -> u64 {
        0
    }

    /// Texels that one [`shade`](Self::shade) reads; counted under exact counters.
    fn texels_shaded(&self) -> u64 {
        0
    }

    /// The linear colour, with straight alpha for [`Blend::Alpha`](super::Blend::Alpha).
    fn shade(&self, pixel: &Pixel<'_>) -> Vec4;

    /// Whether [`shade`](Self::shade) looks at varyings and flats alone: where these are the same, so is the
    /// colour, and need not be asked for again.
    const FROM_VARYINGS: bool = false;

    /// Whether opaque pixels are shaded by [`shade_lanes`](Self::shade_lanes); compiled only where it is so.
    /// Those whose depth is moved never are.
    const SHADES_LANES: bool = false;

    /// The colours of eight pixels of one triangle, channel by channel; of those without a bit in `wanted`
    /// it does not matter. Must answer for each what [`shade`](Self::shade) does, to the same bits.
    #[inline(always)]
    fn shade_lanes<S: Simd>(
        &self,
        simd: S,
        pixels: &PixelLanes<'_, S>,
        wanted: u64,
    ) -> [f32x8<S>; 4] {
        let mut colours = [[0.0; 8]; 4];
        pixels.hand_over(wanted, |pixel, lane| {
            for (channel, value) in colours.iter_mut().zip(self.shade(pixel).to_array()) {
                channel[lane] = value;
            }
        });
        colours.map(|channel| f32x8::from_slice(simd, &channel))
    }
}

/// What a fragment stage may know of a pixel.
#[derive(Debug, Clone, Copy)]
pub struct Pixel<'a> {
    /// Interpolated floats; the first [`Fragment::VARYINGS`] are set.
    pub varyings: &'a [f32; MAX_VARYINGS],
    /// How the first two varyings change from this pixel to the next on the right.
    pub derivative_x: Vec2,
    /// How the first two varyings change from this pixel to the next below.
    pub derivative_y: Vec2,
    /// The primitive's [`Fragment::FLATS`] floats.
    pub flats: &'a [f32],
    /// Whether the triangle is seen from its front: counter-clockwise with y upwards.
    pub front: bool,
    /// Column and row.
    pub position: [u32; 2],
    /// Depth from 0 (near) to 1 (far).
    pub depth: f32,
}

/// What a fragment stage may know of eight pixels of one triangle, as [`Pixel`] has it.
#[derive(Debug)]
pub struct PixelLanes<'a, S: Simd> {
    /// Interpolated floats; the first [`Fragment::VARYINGS`] are set.
    pub varyings: [f32x8<S>; MAX_VARYINGS],
    /// How the first two varyings change from a pixel to the next on the right.
    pub derivative_x: [f32x8<S>; 2],
    /// How the first two varyings change from a pixel to the next below.
    pub derivative_y: [f32x8<S>; 2],
    /// The primitive's [`Fragment::FLATS`] floats.
    pub flats: &'a [f32],
    /// Whether the triangle is seen from its front.
    pub front: bool,
    /// Columns and rows.
    pub positions: [[u32; 2]; 8],
    /// Depths.
    pub depths: [f32; 8],
}

impl<S: Simd> PixelLanes<'_, S> {
    /// Asks of each pixel with a bit in `wanted`; answers a bit for each of which it holds.
    #[inline(always)]
    pub fn each(&self, wanted: u64, mut holds: impl FnMut(&Pixel<'_>) -> bool) -> u64 {
        let mut answer = 0;
        self.hand_over(wanted, |pixel, lane| {
            answer |= u64::from(holds(pixel)) << lane;
        });
        answer
    }

    /// Hands over each pixel with a bit in `wanted`, and its place among the eight.
    #[inline(always)]
    fn hand_over(&self, wanted: u64, mut hand: impl FnMut(&Pixel<'_>, usize)) {
        let mut rest = wanted;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % 8;
            rest &= rest - 1;
            let mut varyings = [0.0; MAX_VARYINGS];
            for (varying, lanes) in varyings.iter_mut().zip(&self.varyings) {
                *varying = lanes[lane];
            }
            let pixel = Pixel {
                varyings: &varyings,
                derivative_x: Vec2::new(self.derivative_x[0][lane], self.derivative_x[1][lane]),
                derivative_y: Vec2::new(self.derivative_y[0][lane], self.derivative_y[1][lane]),
                flats: self.flats,
                front: self.front,
                position: self.positions[lane],
                depth: self.depths[lane],
            };
            hand(&pixel, lane);
        }
    }
}

/// A [`Fragment`] behind a pointer; implemented for every fragment stage, and nowhere else.
pub trait Kernel: Passes + Send + Sync + std::fmt::Debug {
    /// [`Fragment::VARYINGS`].
    fn varyings(&self) -> usize;
    /// [`Fragment::FLATS`].
    fn flats(&self) -> usize;
    /// [`Fragment::TESTS_ALPHA`].
    fn tests_alpha(&self) -> bool;
    /// How much nearer than its triangle a fragment may show.
    fn moves_nearer(&self) -> f32;
}

impl<F: Fragment> Kernel for F {
    fn varyings(&self) -> usize {
        F::VARYINGS
    }

    fn flats(&self) -> usize {
        F::FLATS
    }

    fn tests_alpha(&self) -> bool {
        F::TESTS_ALPHA
    }

    fn moves_nearer(&self) -> f32 {
        by_sample::bound_of(self)
    }
}
