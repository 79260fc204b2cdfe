//! Which triangles each tile must look at, in the order of submission.

use rayon::prelude::*;

use super::setup::{Chunk, TRIANGLES_A_CHUNK, Triangle};
use super::view::PixelBox;
use crate::math::index_u32;

/// A triangle of some chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TriangleId(u32);

const LOCAL_BITS: u32 = TRIANGLES_A_CHUNK.trailing_zeros();
const _: () = assert!(TRIANGLES_A_CHUNK == 1 << LOCAL_BITS, "a power of two");

impl TriangleId {
    fn new(chunk: usize, local: usize) -> Self {
        let chunk = index_u32(chunk);
        assert!(
            chunk < 1 << (u32::BITS - LOCAL_BITS),
            "a call draws at most 2^28 primitives; draw them by several calls"
        );
        Self(chunk << LOCAL_BITS | index_u32(local))
    }

    pub(super) fn chunk(self) -> usize {
        (self.0 >> LOCAL_BITS) as usize
    }

    #[inline]
    pub(super) fn of(self, chunks: &[Chunk]) -> &Triangle {
        &chunks[self.chunk()].triangles[(self.0 & ((1 << LOCAL_BITS) - 1)) as usize]
    }
}

/// The grid of tiles over a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Pixels a side, as a power of two.
    pub(super) shift: u32,
}

/// The triangles of every tile, in parts that were sorted side by side.
#[derive(Debug)]
pub(super) struct Bins {
    grid: Grid,
    parts: Vec<Part>,
}

/// The triangles of every tile, from some chunks in a row.
#[derive(Debug)]
struct Part {
    /// Where each tile's triangles start in `ids`; one more than there are tiles.
    starts: Vec<usize>,
    ids: Vec<TriangleId>,
}

/// How many parts there are at the most: a constant, so that threads cannot be seen.
const PARTS: usize = 8;

impl Bins {
    /// Sorts triangles into tiles by counting, in the order of chunks.
    pub(super) fn new(grid: Grid, chunks: &[Chunk]) -> Self {
        let chunks_a_part = chunks.len().div_ceil(PARTS).max(1);
        let parts = chunks
            .par_chunks(chunks_a_part)
            .enumerate()
            .map(|(number, some)| Part::new(grid, number * chunks_a_part, some))
            .collect();
        Self { grid, parts }
    }

    /// Replaces `ids` by the triangles of the tile at a column and row of the grid; by none beyond
    /// the grid.
    pub(super) fn of_tile(&self, column: usize, row: usize, ids: &mut Vec<TriangleId>) {
        ids.clear();
        if column >= self.grid.columns || row >= self.grid.rows {
            return;
        }
        let tile = row * self.grid.columns + column;
        for part in &self.parts {
            ids.extend_from_slice(&part.ids[part.starts[tile]..part.starts[tile + 1]]);
        }
    }
}

impl Part {
    /// Sorts the triangles of `chunks`, of which the first has this number.
    fn new(grid: Grid, first: usize, chunks: &[Chunk]) -> Self {
        let mut starts = vec![0; grid.columns * grid.rows + 1];
        visit(grid, first, chunks, |tile, _| starts[tile + 1] += 1);
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let mut ids = vec![TriangleId(0); starts[starts.len() - 1]];
        visit(grid, first, chunks, |tile, id| {
            ids[next[tile]] = id;
            next[tile] += 1;
        });
        Self { starts, ids }
    }
}

fn visit(grid: Grid, first: usize, chunks: &[Chunk], mut each: impl FnMut(usize, TriangleId)) {
    for (number, chunk) in (first..).zip(chunks) {
        for (local, pixels) in chunk.boxes.iter().enumerate() {
            let id = TriangleId::new(number, local);
            let [columns, rows] = tiles(grid, *pixels);
            if columns.len() == 1 && rows.len() == 1 {
                each(rows.start * grid.columns + columns.start, id);
                continue;
            }
            let triangle = &chunk.triangles[local];
            let apart = columns.len() > 1 && rows.len() > 1;
            for row in rows {
                for column in columns.clone() {
                    if !apart || touches(grid, triangle, column, row) {
                        each(row * grid.columns + column, id);
                    }
                }
            }
        }
    }
}

#[expect(
    clippy::cast_sign_loss,
    reason = "boxes lie within the target, so nothing is negative"
)]
fn tiles(grid: Grid, pixels: PixelBox) -> [std::ops::Range<usize>; 2] {
    [0, 1].map(|axis| {
        let tile = |pixel: i32| (pixel >> grid.shift) as usize;
        tile(pixels.first[axis])..tile(pixels.last[axis]) + 1
    })
}

/// Whether no edge has the whole tile outside.
fn touches(grid: Grid, triangle: &Triangle, column: usize, row: usize) -> bool {
    let side = i64::from(super::view::SUBPIXELS) << grid.shift;
    let [left, top] = [column, row].map(|tile| i64::from(index_u32(tile)) * side);
    (0..3).all(|from| {
        let to = (from + 1) % 3;
        let [x, y] = [triangle.x, triangle.y].map(|c| [i64::from(c[from]), i64::from(c[to])]);
        let (dx, dy) = (x[1] - x[0], y[1] - y[0]);
        // The corner of the tile that is furthest inside.
        let px = if dy < 0 { left + side } else { left };
        let py = if dx > 0 { top + side } else { top };
        dx * (py - y[0]) - dy * (px - x[0]) >= 0
    })
}
