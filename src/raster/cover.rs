//! Which samples a triangle covers and which of them it wins: the visibility buffer.

use super::pixels::visit_pixels;
use super::plane::{Attributes, Edges, depth_at};
use super::tile::Tile;
use super::{Counters, Fragment};
use crate::math::index_u32;

/// Decides the opaque triangles `entries` of a tile against what is there.
pub(super) fn cover<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entries: &[u32],
) {
    for &entry in entries {
        cover_triangle::<F, SAMPLES>(kernel, tile, entry as usize);
    }
}

#[inline]
fn cover_triangle<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entry: usize,
) {
    let (triangle, chunk, batch) = tile.triangle(entry);
    let number = triangle.batch;
    let Some(pixels) = tile.pixels_of(triangle) else {
        return;
    };
    let exact = tile.scene.counters == Counters::Exact;
    let edges = Edges::of(triangle);
    let mut attributes = None;
    visit_pixels::<SAMPLES>(tile.scene.samples, &edges, pixels, |covered| {
        let first = tile.index(covered.x, covered.y) * SAMPLES;
        let mut winning = 0_u32;
        let mut depths = [0_u32; SAMPLES];
        for (sample, place) in depths.iter_mut().enumerate() {
            if SAMPLES > 1 && covered.mask >> sample & 1 == 0 {
                continue;
            }
            let depth = depth_at(triangle, covered.at(sample)).to_bits();
            let there = tile.depth[first + sample];
            let wins = depth < there || (depth == there && tile.wins_tie(entry, first + sample));
            winning |= u32::from(wins) << sample;
            *place = depth;
        }
        if exact {
            tile.work(number).covered += u64::from(covered.mask.count_ones());
        } else if winning == 0 {
            return;
        }
        if F::TESTS_ALPHA {
            let attributes = attributes
                .get_or_insert_with(|| Attributes::of::<F>(triangle, &edges, chunk, batch));
            let centre = covered.centre();
            let depth = depth_at(triangle, centre);
            let keeps = attributes.pixel::<F, _>(centre, covered.position(), depth, |pixel| {
                kernel.keeps(pixel)
            });
            if exact {
                tile.work(number).texels += kernel.texels_tested();
            }
            if !keeps {
                if exact {
                    tile.work(number).alpha_killed += u64::from(covered.mask.count_ones());
                }
                return;
            }
        }
        for (sample, &depth) in depths.iter().enumerate() {
            if winning >> sample & 1 == 1 {
                tile.depth[first + sample] = depth;
                tile.scratch.owner[first + sample] = index_u32(entry) + 1;
            }
        }
    });
}
