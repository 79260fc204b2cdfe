//! Colour: of what won, once a pixel and primitive; and of what is blended, in order.

use std::ops::Range;

use super::by_sample::moved;
use super::frame::NOTHING;
use super::items::{Item, NOBODY};
use super::layers::Layer;
use super::pixels::{Along, SpanRows, gains};
use super::plane::{Attributes, Edges, coordinates, depth_at};
use super::setup::{Chunk, Triangle, key};
use super::tile::{Choice, Tile, Winners};
use super::{Blend, Counters, Fragment};
use crate::math::{Vec4, index_u32};

/// Shades what triangles of a chunk won, as the tile's items list it.
pub(super) fn shade<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    winners: &Winners<'_>,
    places: Range<usize>,
) {
    let exact = tile.scene.counters == Counters::Exact;
    let number = chunk.batch;
    let batch = &tile.scene.batches[number as usize];
    for (triangle, winner) in winners.triangles().zip(places) {
        let range = tile.scratch.items.of(winner);
        if range.is_empty() {
            continue;
        }
        let triangle = &chunk.triangles[triangle];
        let edges = Edges::of(triangle);
        let attributes = Attributes::of::<F>(triangle, &edges, chunk);
        tile.keys.push(key(batch, triangle));
        let (mut visible, mut shaded) = (0, 0);
        for place in range {
            let item = tile.scratch.items.list[place];
            visible += shade_pixel::<F, SAMPLES>(kernel, tile, triangle, &edges, &attributes, item);
            shaded += 1;
        }
        let work = tile.work(number);
        work.visible += visible;
        if exact {
            work.texels += shaded * kernel.texels_shaded();
        }
    }
}

/// Shades one pixel of a triangle whose key is the last one; answers how many of its samples are visible
/// that were not before.
#[inline(always)]
pub(super) fn shade_pixel<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    triangle: &Triangle,
    edges: &Edges,
    attributes: &Attributes<'_>,
    item: Item,
) -> u64 {
    let [x, y] = tile.pixel_at(item.index());
    let [_, second, third] = edges.at_pixel(x, y);
    let centre = coordinates([second, third]);
    let position = [x, y].map(i32::unsigned_abs);
    let depth = depth_at(triangle, centre);
    let colour = attributes.pixel::<F, _>(centre, position, depth, |pixel| {
        kernel.shade(&moved(kernel, pixel))
    });
    let shown = index_u32(tile.keys.len());
    let mut visible = 0;
    for sample in 0..SAMPLES {
        if item.mask() >> sample & 1 == 1 {
            let index = item.index() * SAMPLES + sample;
            tile.colour[index] = colour;
            tile.shown[index] = shown;
            tile.scratch.owner[index] = NOBODY;
            visible += u64::from(!tile.scratch.drawn[index]);
            tile.scratch.drawn[index] = true;
        }
    }
    visible
}

/// Blends triangles of a chunk over what is there.
pub(super) fn blend<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    let exact = tile.scene.counters == Counters::Exact;
    let number = chunk.batch;
    let blend = tile.scene.batches[number as usize].blend;
    for place in 0..choice.count(chunk) {
        let triangle = &chunk.triangles[choice.triangle(place)];
        let edges = Edges::of(triangle);
        let gains = gains::<SAMPLES>(tile.scene.samples, &edges);
        let mut attributes = None;
        let Some(pixels) = tile.pixels.meet(triangle.pixels) else {
            continue;
        };
        let mut blend_pixel = |along: &Along, [x, y]: [i32; 2], covered: u32| {
            let first = tile.index(x, y) * SAMPLES;
            let mut nearer = 0_u32;
            let depths = gains.map(|gain| depth_at(triangle, along.sample(gain)).to_bits());
            for (sample, depth) in depths.iter().enumerate() {
                let passes = *depth < tile.depth[first + sample];
                nearer |= u32::from(passes) << sample;
            }
            nearer &= covered;
            if exact {
                tile.work(number).covered += u64::from(covered.count_ones());
            } else if nearer == 0 {
                return;
            }
            let attributes =
                attributes.get_or_insert_with(|| Attributes::of::<F>(triangle, &edges, chunk));
            let centre = along.centre();
            let position = [x, y].map(i32::unsigned_abs);
            let depth = depth_at(triangle, centre);
            let mut killed = false;
            let colour = attributes.pixel::<F, _>(centre, position, depth, |pixel| {
                killed = F::TESTS_ALPHA && !kernel.keeps(pixel);
                (!killed && nearer != 0).then(|| kernel.shade(pixel))
            });
            if exact {
                if F::TESTS_ALPHA {
                    tile.work(number).texels += kernel.texels_tested();
                }
                if killed {
                    tile.work(number).alpha_killed += u64::from(covered.count_ones());
                }
                if colour.is_some() {
                    tile.work(number).texels += kernel.texels_shaded();
                }
            }
            let Some(colour) = colour else {
                return;
            };
            tile.work(number).visible += u64::from(nearer.count_ones());
            for (index, depth) in (first..).zip(depths) {
                if nearer >> (index - first) & 1 == 1 {
                    put(tile, blend, index, depth, colour);
                }
            }
        };
        for spans in SpanRows::of(&edges, &gains, pixels) {
            let [first, last] = spans.columns();
            let mut along = Along::new(&edges, first, spans.y);
            for x in first..=last {
                let covered = spans.mask(x);
                if covered != 0 {
                    blend_pixel(&along, [x, spans.y], covered);
                }
                along.step();
            }
        }
    }
}

/// Lets a fragment that is nearer meet what is there at a sample.
#[inline]
fn put(tile: &mut Tile<'_, '_>, blend: Blend, index: usize, depth: u32, colour: Vec4) {
    let there = &mut tile.colour[index];
    match blend {
        Blend::Opaque | Blend::Alpha => *there = over(colour, *there),
        Blend::AlphaAndDepth => {
            *there = over(colour, *there);
            tile.depth[index] = depth;
            tile.shown[index] = NOTHING;
        }
        Blend::Sorted => tile.scratch.layers.push(Layer {
            index: index_u32(index),
            depth,
            colour,
        }),
        Blend::Add => *there += colour,
    }
}

/// `source · alpha + destination · (1 − alpha)`; alpha itself is `alpha + destination · (1 − alpha)`.
#[inline]
pub(super) fn over(source: Vec4, destination: Vec4) -> Vec4 {
    let factor = Vec4::new(source.w, source.w, source.w, 1.0);
    source * factor + destination * (1.0 - source.w)
}
