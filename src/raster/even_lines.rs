//! Blended lines that are the same from end to end: one colour each, so that all there is to find out is
//! which pixels they cover, sixteen at a time.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x4, i32x16};

use super::frame::BLOCK_SIDE;
use super::line_blend::{Counts, EDGES, Edge, PR, PS, QP, RQ, SR, edges_of};
use super::line_records::Line;
use super::setup::Chunk;
use super::tile::Tile;
use super::view::PixelBox;
use super::{Fragment, MAX_VARYINGS, Pixel};
use crate::math::{Vec2, Vec4};

/// Pixels that are decided together.
const TOGETHER: i32 = 16;
const LANES: [i32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// The binary logarithm of how many columns wide the sixteen are, by the columns and rows of a box less one:
/// the one that covers the box with the fewest.
const SHAPES: [[u8; 16]; 16] = {
    let mut shapes = [[0; 16]; 16];
    let mut place = 0;
    while place < 256 {
        let (columns, rows): (usize, usize) = (place / 16 + 1, place % 16 + 1);
        // The most compact of equals.
        let tried = [2, 3, 1, 4, 0];
        let mut least = usize::MAX;
        let mut number = 0;
        while number < tried.len() {
            let (width, height) = (1_usize << tried[number], 16 >> tried[number]);
            let count = columns.div_ceil(width) * rows.div_ceil(height);
            if count < least {
                least = count;
                shapes[place / 16][place % 16] = tried[number];
            }
            number += 1;
        }
        place += 1;
    }
    shapes
};

/// The bits of the first column, by the logarithm of how many columns there are.
const FIRST_COLUMN: [u64; 5] = [0xFFFF, 0x5555, 0x1111, 0x0101, 0x0001];

/// Draws a line of which the edge functions stay within 32 bits.
#[inline(always)]
pub(super) fn draw<S: Simd, F: Fragment>(
    simd: S,
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    (chunk, place): (&Chunk<'_>, usize),
    line: &Line,
    pixels: PixelBox,
    counts: &mut Counts,
) {
    let colour = colour(kernel, chunk, line, place);
    let depth = line.depth[0].to_bits();
    let edges = edges_of(line);
    let side = |axis: usize| pixels.last[axis] - pixels.first[axis];
    let most = |side: i32| side.unsigned_abs().min(15) as usize;
    let shape = u32::from(SHAPES[most(side(0))][most(side(1))]);
    let (width, height) = (1 << shape, TOGETHER >> shape);
    let lanes = i32x16::from_slice(simd, &LANES);
    let (column, row) = (lanes & i32x16::splat(simd, width - 1), lanes >> shape);
    let mut gains = [lanes; EDGES];
    for (gain, edge) in gains.iter_mut().zip(edges) {
        *gain = column * i32x16::splat(simd, edge.right()) + row * i32x16::splat(simd, edge.down());
    }
    let biases = edges.map(|edge| edge.bias(1));
    let [r, g, b, alpha] = colour.to_array();
    let source = f32x4::from_slice(simd, &[r, g, b, alpha]);
    let source = source * f32x4::from_slice(simd, &[alpha, alpha, alpha, 1.0]);
    let kept = f32x4::splat(simd, 1.0 - alpha);
    let mut y = pixels.first[1];
    while y <= pixels.last[1] {
        let rows = (pixels.last[1] - y + 1).min(height);
        let within = (1_u64 << (rows << shape)) - 1;
        let mut x = pixels.first[0];
        while x <= pixels.last[0] {
            let columns = (1_u64 << (pixels.last[0] - x + 1).min(width)) - 1;
            let wanted = (columns * FIRST_COLUMN[shape as usize % 5]) & within;
            let covered = covered(simd, &edges, &gains, biases, [x, y]) & wanted;
            counts.covered += u64::from(covered.count_ones());
            let first = tile.index(x, y);
            let mut rest = covered;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % 16;
                rest &= rest - 1;
                let row = lane >> shape;
                let index = first + row * BLOCK_SIDE as usize + (lane - (row << shape));
                if depth < tile.depth[index] {
                    counts.visible += 1;
                    let there = &mut tile.colour[index];
                    let mut sum = [0.0; 4];
                    let rest = f32x4::from_slice(simd, &there.to_array()) * kept;
                    (source + rest).store_slice(&mut sum);
                    *there = Vec4::from_array(sum);
                }
            }
            x += width;
        }
        y += height;
    }
}

/// A bit for each of sixteen pixels, from one on, that one of the two triangles covers.
///
/// Every point lies on one side of the edge between them, and only there in one of them.
#[inline(always)]
fn covered<S: Simd>(
    simd: S,
    edges: &[Edge; EDGES],
    gains: &[i32x16<S>; EDGES],
    biases: [i32; EDGES],
    [x, y]: [i32; 2],
) -> u64 {
    let zero = i32x16::splat(simd, 0);
    let at = |edge: usize| gains[edge] + i32x16::splat(simd, edges[edge].at(x, y) + biases[edge]);
    let on_first_side = at(PR).simd_ge(zero).to_bitmask();
    let first = (at(RQ) | at(QP)).simd_ge(zero).to_bitmask();
    let second = (at(SR) | at(PS)).simd_ge(zero).to_bitmask();
    first & on_first_side | second & !on_first_side
}

/// What the kernel says of any pixel of the line.
#[inline(always)]
fn colour<F: Fragment>(kernel: &F, chunk: &Chunk<'_>, line: &Line, place: usize) -> Vec4 {
    let inverse_w = line.inverse_w[0];
    let w = 1.0 / inverse_w;
    let [end, _] = chunk.lines.varyings(place, F::VARYINGS);
    let mut varyings = [0.0; MAX_VARYINGS];
    for (varying, &bits) in varyings.iter_mut().zip(end).take(F::VARYINGS) {
        *varying = f32::from_bits(bits) * inverse_w * w;
    }
    kernel.shade(&Pixel {
        varyings: &varyings,
        derivative_x: Vec2::ZERO,
        derivative_y: Vec2::ZERO,
        flats: &[],
        front: true,
        position: [0; 2],
        depth: line.depth[0],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_covered_by_the_fewest_sixteens() {
        let shape = |columns: usize, rows: usize| SHAPES[columns - 1][rows - 1];
        assert_eq!([shape(4, 4), shape(8, 2), shape(2, 8)], [2, 3, 1]);
        assert_eq!([shape(16, 1), shape(1, 16), shape(1, 1)], [4, 0, 2]);
        assert_eq!(shape(5, 2), 3, "one instead of two");
    }
}
