//! The alphas of a texture level once more, all four that a bilinear read takes together: alpha is mostly
//! read alone, and eight pixels at a time.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, i32x8};

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
    /// Of a level of four bytes a texel, rows from the top, alpha last.
    pub(super) fn new(size: [u32; 2], bytes: &[u8]) -> Self {
        let [columns, rows] = size.map(|side| side as usize);
        let mut squares = Self {
            size,
            squares: vec![0; (columns + 1) * (rows + 1)],
            range: [u8::MAX, 0],
        };
        squares.renew(bytes, 0..rows);
        squares
    }

    /// Follows the bytes of the level, of which some rows of texels may have changed.
    pub(super) fn renew(&mut self, bytes: &[u8], rows: Range<usize>) {
        if rows.is_empty() {
            return;
        }
        self.find_range(bytes, &rows);
        let columns = self.size[0] as usize + 1;
        for row in rows.start..=rows.end {
            let first = row * columns;
            let squares = &mut self.squares[first..first + columns];
            for (column, to) in squares.iter_mut().enumerate() {
                *to = square(self.size, bytes, [column, row]);
            }
        }
    }

    /// Looks at no more texels than are new: those that they replace may have been the last ones at an end.
    fn find_range(&mut self, bytes: &[u8], rows: &Range<usize>) {
        let texels = bytes.as_chunks::<4>().0;
        let row = self.size[0] as usize;
        let whole = rows.len() == self.size[1] as usize;
        let start = if whole { [u8::MAX, 0] } else { self.range };
        let new = texels[rows.start * row..rows.end * row].iter();
        self.range = new.fold(start, |[least, greatest], texel| {
            [least.min(texel[3]), greatest.max(texel[3])]
        });
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

fn square(size: [u32; 2], bytes: &[u8], place: [usize; 2]) -> u32 {
    let [width, height] = size.map(|side| side as usize);
    let before = place.map(|at| at.saturating_sub(1));
    let behind = [place[0].min(width - 1), place[1].min(height - 1)];
    let alpha = |x: usize, y: usize| bytes[4 * (y * width + x) + 3];
    u32::from_le_bytes([
        alpha(before[0], before[1]),
        alpha(behind[0], before[1]),
        alpha(before[0], behind[1]),
        alpha(behind[0], behind[1]),
    ])
}
