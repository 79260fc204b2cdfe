//! The loops over a tile, compiled for each fragment stage, and which of them are.

use std::ops::Range;

use fearless_simd::dispatch;

use super::by_sample::{self, Verdict};
use super::probe::Point;
use super::setup::Chunk;
use super::tile::{Choice, Tile, Winners};
use super::{Blend, Counters, Fragment, Pixel, Samples};
use crate::math::Vec4;

/// The three loops over a tile, compiled once a fragment stage; and a look at one pixel.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can call it")]
pub trait Passes {
    /// Opaque triangles against depth and key.
    fn cover(&self, tile: &mut Tile<'_, '_>, chunk: &Chunk<'_>, choice: Choice<'_>);
    /// Colour of what won: the triangles, and their places among the winners.
    fn shade(
        &self,
        tile: &mut Tile<'_, '_>,
        chunk: &Chunk<'_>,
        winners: &Winners<'_>,
        places: Range<usize>,
    );
    /// Blended triangles in order.
    fn blend(&self, tile: &mut Tile<'_, '_>, chunk: &Chunk<'_>, choice: Choice<'_>);
    /// What a fragment is where it meets what is there, and its colour.
    fn probe(&self, point: &Point<'_>, blend: Blend) -> (Verdict, Vec4);
}

impl<F: Fragment> Passes for F {
    fn cover(&self, tile: &mut Tile<'_, '_>, chunk: &Chunk<'_>, choice: Choice<'_>) {
        // Constants come first: what is behind them is compiled only where it is used.
        if F::MOVES_DEPTH || F::COVERAGE {
            return in_pixels(self, tile, chunk, choice);
        }
        if !F::TESTS_ALPHA {
            return in_lanes(&Untested, tile, chunk, choice);
        }
        if self.keeps_all() && tile.scene.counters != Counters::Exact {
            return in_lanes(&Untested, tile, chunk, choice);
        }
        if F::IN_LANES {
            return in_lanes(self, tile, chunk, choice);
        }
        in_pixels(self, tile, chunk, choice);
    }

    fn shade(
        &self,
        tile: &mut Tile<'_, '_>,
        chunk: &Chunk<'_>,
        winners: &Winners<'_>,
        places: Range<usize>,
    ) {
        if !tile.has_colour() {
            return super::depth_only::own(tile, chunk, winners, places);
        }
        if F::SHADES_LANES && !F::MOVES_DEPTH && tile.scene.samples == Samples::One {
            let level = tile.scene.view.level;
            return dispatch!(level, simd => {
                super::shade_lanes::shade::<_, F>(simd, self, tile, chunk, winners, places);
            });
        }
        match tile.scene.samples {
            Samples::One => super::shade::shade::<F, 1>(self, tile, chunk, winners, places),
            Samples::Four => super::shade::shade::<F, 4>(self, tile, chunk, winners, places),
        }
    }

    fn blend(&self, tile: &mut Tile<'_, '_>, chunk: &Chunk<'_>, choice: Choice<'_>) {
        // Lines whose alpha is tested come as triangles, see `are_lines`.
        if !F::TESTS_ALPHA && chunk.lines.count() > 0 {
            let level = tile.scene.view.level;
            return dispatch!(level, simd => {
                super::line_blend::blend::<_, F>(simd, self, tile, chunk, choice);
            });
        }
        match tile.scene.samples {
            Samples::One => super::shade::blend::<F, 1>(self, tile, chunk, choice),
            Samples::Four => super::shade::blend::<F, 4>(self, tile, chunk, choice),
        }
    }

    fn probe(&self, point: &Point<'_>, blend: Blend) -> (Verdict, Vec4) {
        point.look(self, blend)
    }
}

/// Opaque triangles, pixel by pixel.
fn in_pixels<F: Fragment>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    match tile.scene.samples {
        Samples::One => by_sample::cover::<F, 1>(kernel, tile, chunk, choice),
        Samples::Four => by_sample::cover::<F, 4>(kernel, tile, chunk, choice),
    }
}

/// Opaque triangles, eight pixels at a time.
fn in_lanes<F: Fragment>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    let level = tile.scene.view.level;
    match tile.scene.samples {
        Samples::One => dispatch!(level, simd => {
            super::cover::cover::<_, F, 1>(simd, kernel, tile, chunk, choice);
        }),
        Samples::Four => dispatch!(level, simd => {
            super::cover::cover::<_, F, 4>(simd, kernel, tile, chunk, choice);
        }),
    }
}

/// Stands for all fragment stages that keep every pixel, so that their loops are compiled once.
#[derive(Debug)]
struct Untested;

impl Fragment for Untested {
    const VARYINGS: usize = 0;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, _: &Pixel<'_>) -> Vec4 {
        Vec4::ZERO
    }
}
