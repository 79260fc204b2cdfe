//! Colour of what won at one sample a pixel, eight pixels of a triangle at a time.
//!
//! Lanes compute what [`shade`](super::shade) does pixel by pixel, operation by operation.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, SimdInt, f32x8, i32x8};

use super::frame::BLOCK_SIDE;
use super::items::NOBODY;
use super::plane::{Attributes, DepthLanes, Edges, LANES, coordinates, fits_lanes, narrow, step};
use super::setup::{Chunk, Triangle, key};
use super::shade::shade_pixel;
use super::tile::{Tile, Winners};
use super::{Counters, Fragment};
use crate::math::{Vec4, index_u32};

/// Shades what triangles of a chunk won, as the tile's items list it.
#[inline(always)]
pub(super) fn shade<S: Simd, F: Fragment>(
    simd: S,
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    winners: &Winners<'_>,
    places: Range<usize>,
) {
    let batch = &tile.scene.batches[chunk.batch as usize];
    let (mut visible, mut shaded) = (0, 0);
    for (triangle, winner) in winners.triangles().zip(places) {
        let range = tile.scratch.items.of(winner);
        if range.is_empty() {
            continue;
        }
        let triangle = &chunk.triangles[triangle];
        let edges = Edges::of(triangle);
        let attributes = Attributes::of::<F>(triangle, &edges, chunk);
        tile.keys.push(key(batch, triangle));
        shaded += range.len() as u64;
        if range.len() <= FEW {
            for place in range {
                let item = tile.scratch.items.list[place];
                visible += shade_pixel::<F, 1>(kernel, tile, triangle, &edges, &attributes, item);
            }
            continue;
        }
        let depths = DepthLanes::of(simd, triangle);
        let shown = index_u32(tile.keys.len());
        for first in range.clone().step_by(LANES) {
            let count = (range.end - first).min(LANES);
            let mut pixels = [0; LANES];
            let items = &tile.scratch.items.list[first..first + count];
            for (pixel, item) in pixels.iter_mut().zip(items) {
                *pixel = item.index();
            }
            let mut positions = [[0; 2]; LANES];
            for (position, &pixel) in positions.iter_mut().zip(&pixels) {
                *position = tile.pixel_at(pixel).map(i32::unsigned_abs);
            }
            let centres = centres(simd, triangle, &edges, tile.origin, &pixels);
            let mut depth = [0.0; LANES];
            depths.at(simd, centres).store_slice(&mut depth);
            let lanes = attributes.lanes::<S, F>(simd, centres, positions, depth);
            let colours = kernel.shade_lanes(simd, &lanes, (1 << count) - 1);
            let mut channels = [[0.0; LANES]; 4];
            for (channel, lanes) in channels.iter_mut().zip(colours) {
                lanes.store_slice(channel);
            }
            for lane in 0..count {
                let index = pixels[lane];
                let [r, g, b, a] = [0, 1, 2, 3].map(|channel: usize| channels[channel][lane]);
                tile.colour[index] = Vec4::new(r, g, b, a);
                tile.shown[index] = shown;
                tile.scratch.owner[index] = NOBODY;
                visible += u64::from(!tile.scratch.drawn[index]);
                tile.scratch.drawn[index] = true;
            }
        }
    }
    let exact = tile.scene.counters == Counters::Exact;
    if visible + shaded > 0 {
        let work = tile.work(chunk.batch);
        work.visible += visible;
        if exact {
            work.texels += shaded * kernel.texels_shaded();
        }
    }
}

/// Of no more pixels each costs less alone.
const FEW: usize = 2;

/// The second and third edge functions at the centres of some pixels that a triangle covers, told by their
/// places in the block.
#[inline(always)]
fn centres<S: Simd>(
    simd: S,
    triangle: &Triangle,
    edges: &Edges,
    origin: [i32; 2],
    pixels: &[usize; LANES],
) -> [f32x8<S>; 2] {
    let place = pixels.map(|pixel| index_u32(pixel).cast_signed());
    let place = i32x8::from_slice(simd, &place);
    let side = BLOCK_SIDE.cast_signed();
    let (column, row) = (place & i32x8::splat(simd, side - 1), place >> side.ilog2());
    if fits_lanes(triangle) {
        // Beside the triangle sums may leave 32 bits; they come back where it covers pixels.
        let at = edges.at_pixel(origin[0], origin[1]);
        let mut centres = [f32x8::splat(simd, 0.0); 2];
        for (centre, edge) in centres.iter_mut().zip(1..) {
            let sum = i32x8::splat(simd, narrow(at[edge]))
                + column * i32x8::splat(simd, step(edges.right[edge]))
                + row * i32x8::splat(simd, step(edges.down[edge]));
            *centre = sum.to_float();
        }
        return centres;
    }
    let mut at = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let [_, second, third] = edges.at_pixel(origin[0] + column[lane], origin[1] + row[lane]);
        [at[0][lane], at[1][lane]] = coordinates([second, third]);
    }
    [
        f32x8::from_slice(simd, &at[0]),
        f32x8::from_slice(simd, &at[1]),
    ]
}
