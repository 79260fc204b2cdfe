//! The compute program that makes the depth pyramid: from the depth of a target to how far each part
//! of it is seen.
//!
//! A pyramid on the device: for each block of 64 × 64 pixels of the target, row by row, the cells of
//! levels 1 to 6, each the greatest depth of its pixels:
//!
//! | words of a block | level | cells | pixels a cell |
//! |------:|------:|------:|------:|
//! | 0–1023 | 1 | 32 × 32 | 2 × 2 |
//! | 1024–1279 | 2 | 16 × 16 | 4 × 4 |
//! | 1280–1343 | 3 | 8 × 8 | 8 × 8 |
//! | 1344–1359 | 4 | 4 × 4 | 16 × 16 |
//! | 1360–1363 | 5 | 2 × 2 | 32 × 32 |
//! | 1364 | 6 | 1 | 64 × 64 |
//!
//! Little-endian `f32`, cells row by row from the top; level 0 is the target's own depth. Blocks in
//! place of whole levels: a group owns one block, so that one dispatch makes all levels.

use super::clip_box::Reach;
use crate::gpu::{Access, ComputeLayout, ComputeProgram, Group};

/// The slot of the target's depth.
pub(super) const TARGET_SLOT: u32 = 0;
/// The slot of the pyramid: written.
pub(super) const CELL_SLOT: u32 = 1;

/// Pixels a side of a block.
const BLOCK_SIDE: u32 = 64;
/// The level whose cells are blocks.
const TOP: u32 = BLOCK_SIDE.ilog2();
/// Words a block.
const BLOCK_WORDS: u32 = first_word(TOP + 1);
/// How many cells a side are looked at: more cells fit what is looked for better, and are read each.
const CELLS: u32 = 4;

/// Where the cells of a level from 1 on begin in their block.
const fn first_word(level: u32) -> u32 {
    let (mut before, mut word) = (1, 0);
    while before < level {
        word += (BLOCK_SIDE >> before) * (BLOCK_SIDE >> before);
        before += 1;
    }
    word
}

/// How many groups make the pyramid of a target of this size.
pub(super) fn block_count([width, height]: [u32; 2]) -> u32 {
    width.div_ceil(BLOCK_SIDE) * height.div_ceil(BLOCK_SIDE)
}

/// Bytes of the pyramid of a target of this size.
pub(super) fn pyramid_size(size: [u32; 2]) -> u64 {
    4 * u64::from(BLOCK_WORDS) * u64::from(block_count(size))
}

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct PyramidPass;

impl ComputeProgram for PyramidPass {
    fn layout(&self) -> ComputeLayout {
        const SLOTS: [Access; 2] = [
            Access::Depth,
            Access::Own {
                group_bytes: 4 * BLOCK_WORDS,
            },
        ];
        ComputeLayout {
            name: "pyramid",
            version: 1,
            slots: &SLOTS,
            // A comparison a pixel and a cell, and where they lie.
            group_operations: 4 * (BLOCK_SIDE * BLOCK_SIDE + BLOCK_WORDS),
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let [width, _] = group.size(TARGET_SLOT as usize);
        let columns = width.div_ceil(BLOCK_SIDE).max(1);
        let (column, row) = (group.number() % columns, group.number() / columns);
        let pyramid = CELL_SLOT as usize;
        for level in 1..=TOP {
            let side = BLOCK_SIDE >> level;
            for cell in 0..side * side {
                let (x, y) = (2 * (cell % side), 2 * (cell / side));
                let below = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
                let farthest = below.map(|[x, y]| match level {
                    1 => {
                        let pixel = [BLOCK_SIDE * column + x, BLOCK_SIDE * row + y];
                        group.farthest_depth(TARGET_SLOT as usize, pixel)
                    }
                    _ => {
                        let word = first_word(level - 1) + 2 * side * y + x;
                        group.f32s::<1>(pyramid, word as usize)[0]
                    }
                });
                let farthest = farthest.into_iter().fold(0.0, f32::max);
                let word = first_word(level) + cell;
                group.set(pyramid, word as usize, farthest.to_bits());
            }
        }
    }
}

/// Whether all that is drawn already where something may show is nearer than it, at every sample:
/// then nothing of it would show. At equal depth it might. Depth and pyramid are in these slots.
pub(super) fn hides(group: &mut Group<'_>, [depth, pyramid]: [u32; 2], reach: &Reach) -> bool {
    let [width, _] = group.size(depth as usize);
    let columns = width.div_ceil(BLOCK_SIDE);
    let Reach {
        first,
        last,
        nearest,
    } = *reach;
    if first[0] > last[0] || first[1] > last[1] {
        return true;
    }
    let across = |level: u32, axis: usize| (last[axis] >> level) - (first[axis] >> level) + 1;
    let fits = |level: &u32| across(*level, 0).max(across(*level, 1)) <= CELLS;
    // What is larger than the coarsest cells is looked at cell by cell all the same.
    let level = (0..TOP).find(fits).unwrap_or(TOP);
    let side = BLOCK_SIDE >> level;
    for y in first[1] >> level..=last[1] >> level {
        for x in first[0] >> level..=last[0] >> level {
            let farthest = if level == 0 {
                group.farthest_depth(depth as usize, [x, y])
            } else {
                let block = (y / side) * columns + x / side;
                let cell = (y % side) * side + x % side;
                let word = BLOCK_WORDS * block + first_word(level) + cell;
                group.f32s::<1>(pyramid as usize, word as usize)[0]
            };
            // What is no number hides nothing.
            let hidden = farthest < nearest;
            if !hidden {
                return false;
            }
        }
    }
    true
}
