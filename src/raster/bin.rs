//! What each tile must look at, in the order of submission.

use std::ops::Range;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::piece::Piece;
use super::setup::MOST_TRIANGLES;
use super::view::PixelBox;
use crate::math::index_u32;

/// A piece, whole, one of its triangles, or one run of its lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    pub(super) piece: u32,
    /// The triangle, the [code](super::lines::Run::code) of a run, or [`WHOLE`](Self::WHOLE).
    pub(super) triangle: u32,
}

impl Entry {
    /// All triangles of the piece.
    pub(super) const WHOLE: u32 = u32::MAX;
}

const _: () = assert!(
    MOST_TRIANGLES < Entry::WHOLE as usize,
    "triangles are told from pieces"
);

/// The grid of tiles over a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// Pixels a side, as a power of two.
    pub(super) shift: u32,
}

impl Grid {
    /// How many tiles some pixels lie on.
    pub(super) fn tiles_of(self, pixels: PixelBox) -> usize {
        let [columns, rows] = self.tiles(pixels);
        columns.len() * rows.len()
    }

    /// The columns and rows of tiles that some pixels lie on.
    #[inline(always)]
    #[expect(
        clippy::cast_sign_loss,
        reason = "boxes lie within the target, so nothing is negative"
    )]
    pub(super) fn tiles(self, pixels: PixelBox) -> [Range<usize>; 2] {
        let tile = |pixel: i32| (pixel >> self.shift) as usize;
        let range = |axis: usize| tile(pixels.first[axis])..tile(pixels.last[axis]) + 1;
        [range(0), range(1)]
    }

    /// Whether no edge of a convex polygon of positive area has the whole tile outside.
    pub(super) fn touches<const CORNERS: usize>(
        self,
        x: [i32; CORNERS],
        y: [i32; CORNERS],
        column: usize,
        row: usize,
    ) -> bool {
        let side = i64::from(super::view::SUBPIXELS) << self.shift;
        let [left, top] = [column, row].map(|tile| i64::from(index_u32(tile)) * side);
        (0..CORNERS).all(|from| {
            let to = (from + 1) % CORNERS;
            let [x, y] = [x, y].map(|c| [i64::from(c[from]), i64::from(c[to])]);
            let (dx, dy) = (x[1] - x[0], y[1] - y[0]);
            // The corner of the tile that is furthest inside.
            let px = if dy < 0 { left + side } else { left };
            let py = if dx > 0 { top + side } else { top };
            dx * (py - y[0]) - dy * (px - x[0]) >= 0
        })
    }
}

/// What each tile must look at, in parts that were sorted side by side.
#[derive(Debug)]
pub(super) struct Bins {
    grid: Grid,
    parts: Vec<Part>,
}

/// What each tile must look at of some pieces in a row.
#[derive(Debug)]
struct Part {
    /// Where each tile's entries start; one more than there are tiles.
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

/// How many parts there are at the most: a constant, so that threads cannot be seen.
const PARTS: usize = 8;

impl Bins {
    /// Sorts pieces into tiles by counting, in their order, and tells each on how many it may show.
    pub(super) fn new(grid: Grid, pieces: &[Piece<'_>]) -> Self {
        let pieces_a_part = pieces.len().div_ceil(PARTS).max(1);
        let parts = pieces
            .par_chunks(pieces_a_part)
            .enumerate()
            .map(|(number, some)| Part::new(grid, number * pieces_a_part, some))
            .collect();
        Self { grid, parts }
    }

    /// Replaces `entries` by those of the tile at a column and row of the grid; by none beyond the grid.
    pub(super) fn of_tile(&self, column: usize, row: usize, entries: &mut Vec<Entry>) {
        entries.clear();
        if column >= self.grid.columns || row >= self.grid.rows {
            return;
        }
        let tile = row * self.grid.columns + column;
        for part in &self.parts {
            entries.extend_from_slice(&part.entries[part.starts[tile]..part.starts[tile + 1]]);
        }
    }
}

impl Part {
    /// Sorts `pieces`, of which the first has this number.
    fn new(grid: Grid, first: usize, pieces: &[Piece<'_>]) -> Self {
        let mut starts = vec![0; grid.columns * grid.rows + 1];
        visit(grid, first, pieces, |tile, _| starts[tile + 1] += 1);
        for tile in 1..starts.len() {
            starts[tile] += starts[tile - 1];
        }
        let mut next = starts.clone();
        let nothing = Entry {
            piece: 0,
            triangle: 0,
        };
        let mut entries = vec![nothing; starts[starts.len() - 1]];
        visit(grid, first, pieces, |tile, entry| {
            entries[next[tile]] = entry;
            next[tile] += 1;
        });
        Self { starts, entries }
    }
}

fn visit(grid: Grid, first: usize, pieces: &[Piece<'_>], mut each: impl FnMut(usize, Entry)) {
    for (number, piece) in (index_u32(first)..).zip(pieces) {
        let Some(chunk) = &piece.sorted else {
            let [columns, rows] = grid.tiles(piece.reach.pixels);
            let count = index_u32(columns.len() * rows.len());
            piece.tiles.store(count, Ordering::Relaxed);
            for row in rows {
                for column in columns.clone() {
                    let entry = Entry {
                        piece: number,
                        triangle: Entry::WHOLE,
                    };
                    each(row * grid.columns + column, entry);
                }
            }
            continue;
        };
        for run in &piece.runs {
            let entry = Entry {
                piece: number,
                triangle: run.code(),
            };
            each(run.tile as usize, entry);
        }
        for (triangle, local) in chunk.triangles.iter().zip(0..) {
            let entry = Entry {
                piece: number,
                triangle: local,
            };
            let [columns, rows] = grid.tiles(triangle.pixels);
            if columns.len() == 1 && rows.len() == 1 {
                each(rows.start * grid.columns + columns.start, entry);
                continue;
            }
            let apart = columns.len() > 1 && rows.len() > 1;
            for row in rows {
                for column in columns.clone() {
                    if !apart || grid.touches(triangle.x, triangle.y, column, row) {
                        each(row * grid.columns + column, entry);
                    }
                }
            }
        }
    }
}
