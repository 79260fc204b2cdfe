//! The brush set: pictures of dabs, some of leaves and some of branches, in one texture.

use super::pixels::{Plane, byte};
use super::{oil, watercolour};
use crate::math::{Stream, Vec2, index_u32};
use crate::scene::PaintLook;

/// What a dab stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// A leaf: about twice as long as wide.
    Leaf,
    /// A piece of a branch: long, with blunt ends.
    Branch,
}

/// Texels along and across a dab: both powers of two, so that no level mixes two dabs.
pub(super) const CELL: [usize; 2] = [128, 64];

/// Dabs of each form; the first row of cells is of leaves, and so on in turn.
pub(super) const DABS: u32 = 8;

/// Cells a row, and rows of cells.
const CELLS: [usize; 2] = [4, 4];

/// Levels down to 4 × 2 texels a dab.
const LEVELS: usize = 6;

/// Where the numbers come from with which dabs are drawn.
const STREAM: u64 = 0x6272_7573;

/// A texture of four plain bytes a texel, level by level.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Painted {
    pub(super) size: [u32; 2],
    pub(super) levels: Vec<Vec<u8>>,
}

impl Painted {
    pub(super) fn bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.len() as u64).sum()
    }
}

/// The brush set of a look: R and G as the look has them, B 0, A how far a dab covers.
pub(super) fn brush_set(look: PaintLook) -> Painted {
    let stream = Stream::new(look as u64, STREAM);
    let size = [CELL[0] * CELLS[0], CELL[1] * CELLS[1]];
    let mut texels = vec![[0.0_f32; 4]; size[0] * size[1]];
    for number in 0..2 * DABS {
        let form = if number < DABS {
            Form::Leaf
        } else {
            Form::Branch
        };
        let mut draws = stream.child(number.into()).draws();
        let planes = match look {
            PaintLook::Oil => oil::dab(form, &mut draws),
            PaintLook::Watercolour => watercolour::dab(form, &mut draws),
        };
        let [column, row] = cell_of(number);
        for y in 0..CELL[1] {
            for x in 0..CELL[0] {
                let at = (row * CELL[1] + y) * size[0] + column * CELL[0] + x;
                let value = |plane: &Plane| plane.values[y * CELL[0] + x];
                let [first, second, cover] = planes.each_ref().map(value);
                // Whatever reaches the rim would show at the next dab's.
                let inside = (1..CELL[0] - 1).contains(&x) && (1..CELL[1] - 1).contains(&y);
                texels[at] = [first, second, 0.0, if inside { cover } else { 0.0 }];
            }
        }
    }
    let mut levels = Vec::new();
    let [mut width, mut height] = size;
    for _ in 0..LEVELS {
        levels.push(texels.iter().flat_map(|texel| texel.map(byte)).collect());
        texels = halved(&texels, [width, height]);
        (width, height) = (width / 2, height / 2);
    }
    Painted {
        size: size.map(index_u32),
        levels,
    }
}

/// Half the size: coverage is averaged, all else too, weighed by it.
fn halved(texels: &[[f32; 4]], [width, height]: [usize; 2]) -> Vec<[f32; 4]> {
    let half = |x: usize, y: usize| {
        let at = |right: usize, below: usize| texels[(2 * y + below) * width + 2 * x + right];
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        let cover = four.iter().fold(0.0, |sum, texel| sum + texel[3]);
        let mut mean = [0.0; 4];
        for texel in four {
            let weight = if cover > 0.0 { texel[3] / cover } else { 0.25 };
            for channel in 0..3 {
                mean[channel] += weight * texel[channel];
            }
        }
        mean[3] = 0.25 * cover;
        mean
    };
    let rows = 0..height / 2;
    rows.flat_map(|y| (0..width / 2).map(move |x| (x, y)))
        .map(|(x, y)| half(x, y))
        .collect()
}

fn cell_of(number: u32) -> [usize; 2] {
    let number = number as usize % (CELLS[0] * CELLS[1]);
    [number % CELLS[0], number / CELLS[0]]
}

/// The texture coordinates of a dab: those of its first texel, and how far it reaches.
pub(super) fn cell(number: u32) -> [Vec2; 2] {
    let [column, row] = cell_of(number);
    let place = Vec2::new(column as f32, row as f32);
    [CELL_SIDES * place, CELL_SIDES]
}

/// How far a dab reaches in texture coordinates.
pub(super) const CELL_SIDES: Vec2 = Vec2::new(1.0 / CELLS[0] as f32, 1.0 / CELLS[1] as f32);

#[cfg(test)]
mod tests {
    use super::*;

    /// Both looks: dabs that cover their middles, leave the rims of their cells clear, and differ.
    #[test]
    fn dabs_cover_their_middles_and_end_before_their_rims() {
        for look in PaintLook::ALL {
            let painted = brush_set(*look);
            assert_eq!(painted.size, [512, 256]);
            let alpha = |x: usize, y: usize| painted.levels[0][4 * (y * 512 + x) + 3];
            for number in 0..2 * DABS {
                let [column, row] = cell_of(number);
                let (left, top) = (column * CELL[0], row * CELL[1]);
                assert!(alpha(left + 64, top + 32) > 150, "{look:?} {number}");
                for x in 0..CELL[0] {
                    assert_eq!(alpha(left + x, top), 0, "{look:?} {number}, column {x}");
                }
                for y in 0..CELL[1] {
                    assert_eq!(alpha(left, top + y), 0, "{look:?} {number}, row {y}");
                }
            }
            let last = painted.levels.last().unwrap();
            assert_eq!(last.len(), 4 * 16 * 8);
            let first: Vec<u8> = (0..64).map(|y| alpha(30, y)).collect();
            let second: Vec<u8> = (0..64).map(|y| alpha(158, y)).collect();
            assert_ne!(first, second, "{look:?}");
        }
    }
}
