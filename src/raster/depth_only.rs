//! What is left of shading where a target has no colour: who owns which sample.

use std::ops::Range;

use super::items::NOBODY;
use super::setup::{Chunk, key};
use super::tile::{Tile, Winners};
use crate::math::index_u32;

/// Enters what triangles of a chunk won, as the tile's items list it.
pub(super) fn own(
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    winners: &Winners<'_>,
    places: Range<usize>,
) {
    let samples = tile.scene.samples.count();
    let batch = &tile.scene.batches[chunk.batch as usize];
    for (triangle, winner) in winners.triangles().zip(places) {
        let range = tile.scratch.items.of(winner);
        if range.is_empty() {
            continue;
        }
        tile.keys.push(key(batch, &chunk.triangles[triangle]));
        let shown = index_u32(tile.keys.len());
        for place in range {
            let item = tile.scratch.items.list[place];
            for sample in 0..samples {
                if item.mask() >> sample & 1 == 1 {
                    let index = item.index() * samples + sample;
                    tile.shown[index] = shown;
                    tile.scratch.owner[index] = NOBODY;
                    let first_time = !tile.scratch.drawn[index];
                    tile.work(chunk.batch).visible += u64::from(first_time);
                    tile.scratch.drawn[index] = true;
                }
            }
        }
    }
}
