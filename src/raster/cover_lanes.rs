//! Triangles of one sample a pixel against what is there, sixteen pixels at a time: two rows of eight.

use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdCombine, SimdInt, SimdMask, SimdSplit, f32x16, i32x16,
    mask32x16, u32x8, u32x16,
};

use super::Fragment;
use super::candidates::{Joining, TOGETHER};
use super::cover::Contest;
use super::frame::BLOCK_SIDE;
use super::plane::{narrow, step};
use super::setup::Triangle;
use super::tile::Tile;
use super::view::PixelBox;

/// Pixels of a row that are decided together.
const COLUMNS: i32 = 8;
const ROW: usize = COLUMNS.unsigned_abs() as usize;
const _: () = assert!(TOGETHER == 2 * ROW, "two rows join at once");

/// The columns and rows of the lanes.
const COLUMN_OF: [i32; TOGETHER] = [0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7];
const ROW_OF: [i32; TOGETHER] = [0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1];
/// The bits of the first and of the second row.
const UPPER: u64 = 0x00FF;
const LOWER: u64 = 0xFF00;

impl<F: Fragment, const SAMPLES: usize> Contest<'_, '_, '_, F, SAMPLES> {
    /// Decides the pixels of a triangle that [fits lanes](super::plane::fits_lanes).
    #[inline(always)]
    pub(super) fn fight_in_lanes<S: Simd>(&mut self, simd: S, pixels: PixelBox) {
        let [x0, y0] = pixels.first;
        let [x1, y1] = pixels.last;
        let (right, down, bias) = (self.edges.right, self.edges.down, self.edges.bias);
        let right = [step(right[0]), step(right[1]), step(right[2])];
        let down = [step(down[0]), step(down[1]), step(down[2])];
        let column = i32x16::from_slice(simd, &COLUMN_OF);
        let row = i32x16::from_slice(simd, &ROW_OF);
        let mut gains = [column; 3];
        for ((gain, right), down) in gains.iter_mut().zip(right).zip(down) {
            *gain = column * i32x16::splat(simd, right) + row * i32x16::splat(simd, down);
        }
        let below = [
            i32x16::splat(simd, down[0].wrapping_mul(2)),
            i32x16::splat(simd, down[1].wrapping_mul(2)),
            i32x16::splat(simd, down[2].wrapping_mul(2)),
        ];
        let biases = [
            i32x16::splat(simd, narrow(bias[1])),
            i32x16::splat(simd, narrow(bias[2])),
        ];
        let zero = i32x16::splat(simd, 0);
        let depths = Depths::of(simd, self.triangle);
        let last_start = self.tile.origin[0] + BLOCK_SIDE.cast_signed() - COLUMNS;
        let mut start = x0;
        while start <= x1 {
            // Lanes stay within the block: those beside the pixels are left out. There edge functions may
            // leave 32 bits.
            let x = start.min(last_start);
            let columns = columns(x, start, x1);
            let [top, bottom] = self.rows(x, [y0, y1], right, down);
            let first_row = top - ((top - self.tile.origin[1]) & 1);
            let at = self.edges.at_pixel(x, first_row);
            let mut first = gains[0] + i32x16::splat(simd, narrow(at[0] + bias[0]));
            let mut second = gains[1] + i32x16::splat(simd, narrow(at[1]));
            let mut third = gains[2] + i32x16::splat(simd, narrow(at[2]));
            let mut index = self.tile.index(x, first_row);
            let mut wanted = columns | columns << ROW;
            if first_row < top {
                wanted &= LOWER;
            }
            let mut y = first_row;
            while y <= bottom {
                if y == bottom {
                    wanted &= UPPER;
                }
                let outside = first | (second + biases[0]) | (third + biases[1]);
                let covered = outside.simd_ge(zero).to_bitmask() & wanted;
                if covered != 0 {
                    self.decide_lanes(simd, &depths, [second, third], covered, index);
                }
                first += below[0];
                second += below[1];
                third += below[2];
                index += 2 * BLOCK_SIDE as usize;
                y += 2;
                wanted = columns | columns << ROW;
            }
            start = x + COLUMNS;
        }
        if F::TESTS_ALPHA {
            self.decide(simd);
        }
    }

    /// The rows, of some, outside of which no edge function is positive in all lanes from a column on.
    #[inline(always)]
    fn rows(&self, x: i32, [y0, y1]: [i32; 2], right: [i32; 3], down: [i32; 3]) -> [i32; 2] {
        /// Of fewer it costs less to look at each.
        const MANY_ROWS: i32 = 6;
        let [mut top, mut bottom] = [y0, y1];
        if y1 - y0 < MANY_ROWS {
            return [top, bottom];
        }
        let at = self.edges.at_pixel(x, y0);
        for edge in 0..3 {
            let first = narrow(at[edge] + self.edges.bias[edge]);
            let most = first + (right[edge] * (COLUMNS - 1)).max(0);
            let down = down[edge];
            if most < 0 && down > 0 {
                top = top.max(y0 + (-1 - most) / down + 1);
            } else if most < 0 {
                return [y0, y0 - 1];
            } else if down < 0 {
                bottom = bottom.min(y0 + most / -down);
            }
        }
        // An empty range begins within the block, too.
        if top <= bottom {
            [top, bottom]
        } else {
            [y0, y0 - 1]
        }
    }

    /// Decides covered pixels of two rows.
    #[inline(always)]
    fn decide_lanes<S: Simd>(
        &mut self,
        simd: S,
        depths: &Depths<S>,
        edges: [i32x16<S>; 2],
        covered: u64,
        index: usize,
    ) {
        let centre: [f32x16<S>; 2] = [edges[0].to_float(), edges[1].to_float()];
        let depth = depths.at(simd, centre);
        let bits: u32x16<S> = depth.bitcast();
        let there = two_rows(simd, self.tile.depth, index);
        let mut winning = bits.simd_lt(there).to_bitmask() & covered;
        let mut equal = bits.simd_eq(there).to_bitmask() & covered;
        while equal != 0 {
            let lane = equal.trailing_zeros() as usize;
            equal &= equal - 1;
            let sample = index + lane % ROW + lane / ROW * BLOCK_SIDE as usize;
            let wins = self.tile.wins_tie(self.chunk, self.number, sample);
            winning |= u64::from(wins) << lane;
        }
        if self.exact {
            let count = u64::from(covered.count_ones());
            self.tile.work(self.chunk.batch).covered += count;
        } else if winning == 0 {
            return;
        }
        if F::TESTS_ALPHA {
            let place = u32x16::from_slice(simd, &PLACE_OF);
            let joining = Joining {
                index: place + u32x16::splat(simd, crate::math::index_u32(index)),
                centre,
                depth: bits,
                covered: if self.exact { covered } else { winning },
                winning,
            };
            self.candidates.join(simd, &joining);
        } else if winning != 0 {
            let mark = self.mark();
            let mask = mask32x16::from_bitmask(simd, winning);
            store(mask.select(bits, there), self.tile.depth, index);
            let owners = &mut self.tile.scratch.owner;
            let held = two_rows(simd, owners, index);
            store(mask.select(u32x16::splat(simd, mark), held), owners, index);
        }
    }
}

impl Tile<'_, '_> {
    /// Whether all that is there in some pixels of one sample each is nearer than a depth, of which the bits
    /// are told.
    #[inline(always)]
    pub(super) fn hides_lanes<S: Simd>(&self, simd: S, pixels: PixelBox, nearest: u32) -> bool {
        let nearest = u32x16::splat(simd, nearest);
        let [x0, y0] = pixels.first;
        let [x1, y1] = pixels.last;
        let last_start = self.origin[0] + BLOCK_SIDE.cast_signed() - COLUMNS;
        let mut start = x0;
        while start <= x1 {
            let x = start.min(last_start);
            let columns = columns(x, start, x1);
            let first_row = y0 - ((y0 - self.origin[1]) & 1);
            let mut index = self.index(x, first_row);
            let mut wanted = columns | columns << ROW;
            if first_row < y0 {
                wanted &= LOWER;
            }
            let mut y = first_row;
            while y <= y1 {
                if y == y1 {
                    wanted &= UPPER;
                }
                let there = two_rows(simd, self.depth, index);
                if there.simd_ge(nearest).to_bitmask() & wanted != 0 {
                    return false;
                }
                wanted = columns | columns << ROW;
                index += 2 * BLOCK_SIDE as usize;
                y += 2;
            }
            start = x + COLUMNS;
        }
        true
    }
}

/// The places of the lanes from the first one's on.
const PLACE_OF: [u32; TOGETHER] = {
    let mut places = [0; TOGETHER];
    let mut lane = 0;
    while lane < TOGETHER {
        places[lane] = COLUMN_OF[lane].unsigned_abs() + ROW_OF[lane].unsigned_abs() * BLOCK_SIDE;
        lane += 1;
    }
    places
};

/// The bits of the lanes from column `x` on that lie within some columns.
#[inline(always)]
fn columns(x: i32, first: i32, last: i32) -> u64 {
    let before = (1_u64 << (first - x)) - 1;
    let until = (2_u64 << (last - x).min(COLUMNS - 1)) - 1;
    until & !before
}

#[inline(always)]
fn two_rows<S: Simd>(simd: S, block: &[u32], index: usize) -> u32x16<S> {
    let upper = u32x8::from_slice(simd, &block[index..][..ROW]);
    let lower = u32x8::from_slice(simd, &block[index + BLOCK_SIDE as usize..][..ROW]);
    upper.combine(lower)
}

#[inline(always)]
fn store<S: Simd>(values: u32x16<S>, block: &mut [u32], index: usize) {
    let (upper, lower) = values.split();
    upper.store_slice(&mut block[index..][..ROW]);
    lower.store_slice(&mut block[index + BLOCK_SIDE as usize..][..ROW]);
}

/// The plane of a triangle's depth.
struct Depths<S: Simd> {
    base: f32x16<S>,
    slopes: [f32x16<S>; 2],
}

impl<S: Simd> Depths<S> {
    #[inline(always)]
    fn of(simd: S, triangle: &Triangle) -> Self {
        Self {
            base: f32x16::splat(simd, triangle.depth),
            slopes: [
                f32x16::splat(simd, triangle.depth_slopes[0]),
                f32x16::splat(simd, triangle.depth_slopes[1]),
            ],
        }
    }

    /// As [`depth_at`](super::plane::depth_at).
    #[inline(always)]
    fn at(&self, simd: S, edges: [f32x16<S>; 2]) -> f32x16<S> {
        let depth = self.base + (edges[0] * self.slopes[0] + edges[1] * self.slopes[1]);
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let depth = depth.simd_gt(zero).select(depth, zero);
        depth.simd_lt(one).select(depth, one)
    }
}
