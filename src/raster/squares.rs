//! The alphas of a texture level once more, all four that a bilinear read takes together: alpha is mostly
//! read alone, and eight pixels at a time.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, i32x8};
use rayon::prelude::*;

/// The alphas of squares of texels.
///
/// Square (i, j), of one more a row and a column than there are texels, is that of texels (i − 1, j − 1) to
/// (i, j), kept within the level. Its bytes, the lowest first, are top-left, top-right, bottom-left,
/// bottom-right.
#[derive(Debug, Clone)]
pub(super) struct Squares {
    /// Width and height of the level in texels.
    size: [u32; 2],
    squares: Vec<u32>,
    /// No alpha is less, and none is greater.
    range: [u8; 2],
}

impl Squares {
    /// Of a level all of whose bytes are 0.
    pub(super) fn blank(size: [u32; 2]) -> Self {
        let [columns, rows] = size.map(|side| side as usize);
        Self {
            size,
            squares: vec![0; (columns + 1) * (rows + 1)],
            range: [0, 0],
        }
    }

    /// Of a level of four bytes a texel, rows from the top, alpha last.
    pub(super) fn new(size: [u32; 2], bytes: &[u8]) -> Self {
        let mut squares = Self::blank(size);
        squares.renew(bytes, 0..size[1] as usize);
        squares
    }

    /// Follows the bytes of the level, of which some rows of texels may have changed.
    pub(super) fn renew(&mut self, bytes: &[u8], rows: Range<usize>) {
        if rows.is_empty() {
            return;
        }
        self.find_range(bytes, &rows);
        let width = self.size[0] as usize;
        let columns = width + 1;
        let last = self.size[1] as usize - 1;
        let texels = |row: usize| &bytes.as_chunks::<4>().0[row * width..(row + 1) * width];
        let renewed = &mut self.squares[rows.start * columns..(rows.end + 1) * columns];
        renewed
            .par_chunks_exact_mut(columns)
            .with_min_len((PARALLEL / columns).max(1))
            .zip(rows.start..rows.end + 1)
            .for_each(|(squares, row)| {
                // Beyond the rim the nearest texel.
                between(
                    squares,
                    texels(row.saturating_sub(1)),
                    texels(row.min(last)),
                );
            });
    }

    /// Looks at no more texels than are new: those that they replace may have been the last ones at an end.
    fn find_range(&mut self, bytes: &[u8], rows: &Range<usize>) {
        let texels = bytes.as_chunks::<4>().0;
        let row = self.size[0] as usize;
        let whole = rows.len() == self.size[1] as usize;
        let start = if whole { [u8::MAX, 0] } else { self.range };
        let both = |a: [u8; 2], b: [u8; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let new = texels[rows.start * row..rows.end * row].par_chunks(PARALLEL);
        let ranges = new.map(|texels| {
            let alphas = texels.iter().map(|texel| [texel[3]; 2]);
            alphas.fold([u8::MAX, 0], both)
        });
        let ranges: Vec<[u8; 2]> = ranges.collect();
        self.range = ranges.into_iter().fold(start, both);
    }

    /// No alpha is less than the first, and none is greater than the second.
    #[inline(always)]
    pub(super) fn range(&self) -> [u8; 2] {
        self.range
    }

    /// Squares by column and row.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, simd: S, column: i32x8<S>, row: i32x8<S>) -> i32x8<S> {
        let columns = i32x8::splat(simd, self.size[0].cast_signed() + 1);
        let mut places = [0; 8];
        (row * columns + column).store_slice(&mut places);
        let mut squares = [0; 8];
        for lane in 0..8 {
            let square = self.squares.get(places[lane].cast_unsigned() as usize);
            squares[lane] = square.copied().unwrap_or(0).cast_signed();
        }
        i32x8::from_slice(simd, &squares)
    }
}

/// About how many squares are worth a thread's while.
const PARALLEL: usize = 1 << 15;

/// The squares between two rows of texels.
fn between(squares: &mut [u32], upper: &[[u8; 4]], lower: &[[u8; 4]]) {
    let pairs = upper.iter().zip(lower).map(|(up, low)| [up[3], low[3]]);
    let mut before = [upper[0][3], lower[0][3]];
    let behind = pairs.clone().skip(upper.len() - 1);
    for (to, at) in squares.iter_mut().zip(pairs.chain(behind)) {
        *to = u32::from_le_bytes([before[0], at[0], before[1], at[1]]);
        before = at;
    }
}
