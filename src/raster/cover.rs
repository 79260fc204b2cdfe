//! Which samples a triangle covers and which of them it wins: the visibility buffer.

use std::ops::Range;

use super::plane::{Attributes, Edges, coordinates, depth_at};
use super::setup::key;
use super::tile::Tile;
use super::{Counters, Fragment};

/// Decides the opaque triangles `entries` of a tile against what is there.
pub(super) fn cover<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entries: Range<usize>,
) {
    for entry in entries {
        cover_triangle::<F, SAMPLES>(kernel, tile, entry);
    }
}

#[inline]
fn cover_triangle<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entry: usize,
) {
    let (triangle, chunk, batch) = tile.triangle(entry);
    let exact = tile.scene.counters == Counters::Exact;
    let edges = Edges::of(triangle);
    let mut attributes = None;
    visit_pixels::<SAMPLES>(tile, entry, &edges, |tile, covered| {
        let mut winning = 0_u32;
        let mut depths = [0_u32; SAMPLES];
        for (sample, slot) in depths.iter_mut().enumerate() {
            if covered.mask >> sample & 1 == 0 {
                continue;
            }
            let depth = depth_at(triangle, coordinates(covered.samples[sample])).to_bits();
            *slot = depth;
            let index = covered.index * SAMPLES + sample;
            let there = tile.depth[index];
            let wins = depth < there
                || (depth == there
                    && tile
                        .key_at(index)
                        .is_some_and(|shown| key(batch, triangle) < shown));
            winning |= u32::from(wins) << sample;
        }
        if exact {
            tile.work.covered += u64::from(covered.mask.count_ones());
        } else if winning == 0 {
            return;
        }
        if F::TESTS_ALPHA {
            let attributes = attributes
                .get_or_insert_with(|| Attributes::of::<F>(triangle, &edges, chunk, batch));
            let centre = coordinates(covered.centre);
            let depth = depth_at(triangle, centre);
            let keeps = attributes
                .pixel::<F, _>(centre, covered.position, depth, |pixel| kernel.keeps(pixel));
            if exact {
                tile.work.texels += kernel.texels_tested();
            }
            if !keeps {
                if exact {
                    tile.work.alpha_killed += u64::from(covered.mask.count_ones());
                }
                return;
            }
        }
        for (sample, &depth) in depths.iter().enumerate() {
            if winning >> sample & 1 == 1 {
                let index = covered.index * SAMPLES + sample;
                tile.depth[index] = depth;
                tile.scratch.owner[index] = crate::math::index_u32(entry + 1);
            }
        }
    });
}

/// A pixel of which a triangle covers some sample.
pub(super) struct Covered<const SAMPLES: usize> {
    /// Column and row.
    pub(super) position: [u32; 2],
    /// The pixel's place in its block.
    pub(super) index: usize,
    /// A bit a covered sample.
    pub(super) mask: u32,
    /// The edge functions at the pixel's centre.
    pub(super) centre: [i64; 3],
    /// The edge functions at each sample.
    pub(super) samples: [[i64; 3]; SAMPLES],
}

/// Visits the pixels of the tile of which the triangle covers some sample.
#[inline]
#[expect(clippy::cast_sign_loss, reason = "pixels of a tile lie on the target")]
pub(super) fn visit_pixels<'a, const SAMPLES: usize>(
    tile: &mut Tile<'a>,
    entry: usize,
    edges: &Edges,
    mut each: impl FnMut(&mut Tile<'a>, &Covered<SAMPLES>),
) {
    let Some(pixels) = tile.pixels_of(entry) else {
        return;
    };
    let offsets = tile.scene.samples.offsets();
    let to_sample: [[i64; 3]; SAMPLES] = std::array::from_fn(|sample| {
        let [dx, dy] = offsets[sample].map(|offset| i64::from(offset - 128));
        std::array::from_fn(|k| edges.right[k] * dx + edges.down[k] * dy)
    });
    let mut row = edges.at_pixel(pixels.first[0], pixels.first[1]);
    for y in pixels.first[1]..=pixels.last[1] {
        let mut centre = row;
        let mut entered = false;
        for x in pixels.first[0]..=pixels.last[0] {
            let mut covered = Covered {
                position: [x as u32, y as u32],
                index: 0,
                mask: 0,
                centre,
                samples: [[0; 3]; SAMPLES],
            };
            for (sample, offset) in to_sample.iter().enumerate() {
                let at: [i64; 3] = std::array::from_fn(|k| centre[k] + offset[k]);
                covered.samples[sample] = at;
                let inside =
                    (at[0] + edges.bias[0]) | (at[1] + edges.bias[1]) | (at[2] + edges.bias[2]);
                covered.mask |= u32::from(inside >= 0) << sample;
            }
            if covered.mask != 0 {
                entered = true;
                covered.index = tile.index(x, y);
                each(tile, &covered);
            } else if entered && SAMPLES == 1 {
                // Triangles are convex: a row has one span.
                break;
            }
            for (value, right) in centre.iter_mut().zip(edges.right) {
                *value += right * 256;
            }
        }
        for (value, down) in row.iter_mut().zip(edges.down) {
            *value += down * 256;
        }
    }
}
