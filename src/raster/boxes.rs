//! Which primitives of a part may show, told by their boxes: what is hidden or lies between samples costs
//! no vertex.
//!
//! With `q = x / w` at the middle of a box, `x − q w` is affine and 0 there; so within the box `x / w` lies
//! no further from `q` than the sum of `|m_x − q m_w|` times half a side over the axes, by the least `w`.
//! That holds for y and z too, and is sharper than a range of each coordinate: what moves away moves both.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x16, i32x16};

use super::reach::{Cover, LEAST_W, SNAP};
use super::setup::DEPTH_ERROR;
use super::source::{Boxes, Hull, PART};
use super::view::{PixelBox, SUBPIXELS, View};

/// Boxes that are looked at together.
const TOGETHER: usize = 16;

/// More than rounding in `f32` moves a sum of four products, as a share of the sum of their absolutes.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;

/// More pixels than rounding in `f32` moves what lies on a target.
const PIXEL_ERROR: f32 = 1.0 / 128.0;

/// Columns and rows further out than any that is drawn.
const OUTSIDE: f32 = 1e6;

impl View {
    /// The primitives of a part with one sample a pixel that may show on the tile of `cover`, before what is
    /// there, a bit each.
    #[inline(always)]
    pub(super) fn shown_of<S: Simd>(
        &self,
        simd: S,
        hull: &Hull,
        boxes: &Boxes,
        cover: &Cover<'_>,
    ) -> u64 {
        let rows = Rows::new(simd, hull);
        let mut shown = 0;
        let mut first = 0;
        while first < PART {
            shown |= self.sixteen(simd, &rows, boxes, first, cover) << first;
            first += TOGETHER;
        }
        shown
    }

    #[inline(always)]
    fn sixteen<S: Simd>(
        &self,
        simd: S,
        rows: &Rows<S>,
        boxes: &Boxes,
        first: usize,
        cover: &Cover<'_>,
    ) -> u64 {
        let middle = [
            f32x16::from_slice(simd, &boxes.middle[0][first..][..TOGETHER]),
            f32x16::from_slice(simd, &boxes.middle[1][first..][..TOGETHER]),
            f32x16::from_slice(simd, &boxes.middle[2][first..][..TOGETHER]),
        ];
        let half = [
            f32x16::from_slice(simd, &boxes.half[0][first..][..TOGETHER]),
            f32x16::from_slice(simd, &boxes.half[1][first..][..TOGETHER]),
            f32x16::from_slice(simd, &boxes.half[2][first..][..TOGETHER]),
        ];
        let w = rows.at(3, middle);
        let least_w = w
            - ((rows.of[3][0].abs() * half[0]
                + rows.of[3][1].abs() * half[1]
                + rows.of[3][2].abs() * half[2])
                * f32x16::splat(simd, 1.0 + 1e-6)
                + rows.slack[3]);
        let (by_w, by_least) = (
            f32x16::splat(simd, 1.0) / w,
            f32x16::splat(simd, 1.0 + 1e-6) / least_w,
        );
        let (x, x_off) = rows.quotient(0, middle, half, by_w, by_least);
        let (y, y_off) = rows.quotient(1, middle, half, by_w, by_least);
        let (z, z_off) = rows.quotient(2, middle, half, by_w, by_least);
        let [width, height] = self.half_pixels();
        let (width, height) = (f32x16::splat(simd, width), f32x16::splat(simd, height));
        let (column, columns_off) = (width + x * width, x_off * width);
        let (row, rows_off) = (height - y * height, y_off * height);
        let nearest = z - z_off - f32x16::splat(simd, 4.0 * DEPTH_ERROR);
        // Not `<=`: of what is no number nothing is known.
        let known = least_w
            .simd_gt(f32x16::splat(simd, LEAST_W_ROUNDED))
            .to_bitmask()
            & w.simd_lt(f32x16::splat(simd, f32::INFINITY)).to_bitmask()
            & (column.abs() + columns_off)
                .simd_lt(f32x16::splat(simd, OUTSIDE))
                .to_bitmask()
            & (row.abs() + rows_off)
                .simd_lt(f32x16::splat(simd, OUTSIDE))
                .to_bitmask()
            & nearest.simd_gt(f32x16::splat(simd, -OUTSIDE)).to_bitmask();
        let tile = cover.pixels;
        let (mut least, mut last) = ([[0_i32; TOGETHER]; 2], [[0_i32; TOGETHER]; 2]);
        let mut seen = u64::MAX;
        let sides = [(column, columns_off), (row, rows_off)];
        for axis in 0..2 {
            let (at, off) = sides[axis];
            // The sample lies in the middle of the pixel.
            let from = (at - off - f32x16::splat(simd, 0.5 + MARGIN)).ceil();
            let to = (at + off - f32x16::splat(simd, 0.5 - MARGIN)).floor();
            let from: i32x16<S> = from.to_int();
            let to: i32x16<S> = to.to_int();
            let from = from.max(i32x16::splat(simd, tile.first[axis]));
            let to = to.min(i32x16::splat(simd, tile.last[axis]));
            seen &= from.simd_le(to).to_bitmask();
            from.store_slice(&mut least[axis]);
            to.store_slice(&mut last[axis]);
        }
        let mut depths = [0.0_f32; TOGETHER];
        nearest.store_slice(&mut depths);
        let lanes = (1 << TOGETHER) - 1;
        let mut answer = (seen | !known) & lanes;
        let mut rest = answer & known;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % TOGETHER;
            rest &= rest - 1;
            let pixels = PixelBox {
                first: [least[0][lane], least[1][lane]],
                last: [last[0][lane], last[1][lane]],
            };
            let hidden = cover.hides_within(pixels, depths[lane]);
            answer &= !(u64::from(hidden) << lane);
        }
        answer
    }
}

/// Pixels that a box is taken to be wider on each side.
const MARGIN: f32 = PIXEL_ERROR + SNAPPED;

/// More pixels than snapping moves a vertex: [two sub-pixels](super::reach::SNAP).
const SNAPPED: f32 = 1.0 / 128.0;
const _: () = assert!(SNAP <= 2.0 && SUBPIXELS == 256, "a 128th of a pixel");

/// A little more than [`LEAST_W`].
const LEAST_W_ROUNDED: f32 = 2e-6;
const _: () = assert!(LEAST_W <= 1e-6, "half of it");

/// The matrix of a hull, row by row, in all lanes.
struct Rows<S: Simd> {
    /// The factors of x, y and z.
    of: [[f32x16<S>; 3]; 4],
    constant: [f32x16<S>; 4],
    /// How far a computed coordinate may lie from that of a point.
    slack: [f32x16<S>; 4],
}

impl<S: Simd> Rows<S> {
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the slack is more than what rounding takes away"
    )]
    fn new(simd: S, hull: &Hull) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        let mut rows = Self {
            of: [[zero; 3]; 4],
            constant: [zero; 4],
            slack: [zero; 4],
        };
        for row in 0..4 {
            let mut size = hull.clip[3][row].abs();
            for axis in 0..3 {
                let factor = hull.clip[axis][row];
                let [least, greatest] = [hull.corners[0][axis], hull.corners[1][axis]];
                size += factor.abs() * least.abs().max(greatest.abs());
                rows.of[row][axis] = f32x16::splat(simd, factor as f32);
            }
            rows.constant[row] = f32x16::splat(simd, hull.clip[3][row] as f32);
            let slack = hull.slack[row] + ROUNDING * size;
            rows.slack[row] = f32x16::splat(simd, (slack * 1.000_001) as f32);
        }
        rows
    }

    /// A coordinate of points in clip space.
    #[inline(always)]
    fn at(&self, row: usize, point: [f32x16<S>; 3]) -> f32x16<S> {
        let [x, y, z] = self.of[row];
        x * point[0] + y * point[1] + z * point[2] + self.constant[row]
    }

    /// A coordinate over `w` at the middles of boxes, and how far from it that of other points may be.
    #[inline(always)]
    fn quotient(
        &self,
        row: usize,
        middle: [f32x16<S>; 3],
        half: [f32x16<S>; 3],
        by_w: f32x16<S>,
        by_least: f32x16<S>,
    ) -> (f32x16<S>, f32x16<S>) {
        let quotient = self.at(row, middle) * by_w;
        let (of, w) = (self.of[row], self.of[3]);
        let off = (of[0] - quotient * w[0]).abs() * half[0]
            + (of[1] - quotient * w[1]).abs() * half[1]
            + (of[2] - quotient * w[2]).abs() * half[2];
        let slack = self.slack[row] + quotient.abs() * self.slack[3];
        (quotient, (off + slack) * by_least)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::raster::Samples;
    use crate::raster::frame::BLOCK_SIDE;

    /// A camera at the origin that looks along −z, near 1, far 9, with all of its columns in use.
    const CLIP: [[f64; 4]; 4] = [
        [1.5, 0.1, 0.05, 0.1],
        [-0.1, 1.5, 0.0, 0.0],
        [0.0, 0.1, -1.125, -1.0],
        [0.1, 0.0, -1.125, 0.0],
    ];

    /// The pixels around the projected corners of a box, and the least depth; `None` behind the eye.
    fn projected(view: &View, middle: [f64; 3], half: [f64; 3]) -> Option<([[f64; 2]; 2], f64)> {
        let (mut least, mut greatest) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut nearest = f64::INFINITY;
        for corner in 0..8 {
            let sign = |axis: usize| f64::from(corner >> axis & 1) * 2.0 - 1.0;
            let point = [0, 1, 2].map(|axis| middle[axis] + sign(axis) * half[axis]);
            let [x, y, z, w] = [0, 1, 2, 3].map(|row| {
                let sum: f64 = (0..3).map(|axis| CLIP[axis][row] * point[axis]).sum();
                sum + CLIP[3][row]
            });
            if w < 0.01 {
                return None;
            }
            let [width, height] = view.half_pixels().map(f64::from);
            let at = [width + x / w * width, height - y / w * height];
            for axis in 0..2 {
                least[axis] = least[axis].min(at[axis]);
                greatest[axis] = greatest[axis].max(at[axis]);
            }
            nearest = nearest.min(z / w);
        }
        Some(([least, greatest], nearest))
    }

    #[test]
    fn nothing_is_left_out_that_may_show() {
        let mut state = 5_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        let view = View::new(64, 64, Samples::One);
        let depth: Vec<u32> = (0..BLOCK_SIDE * BLOCK_SIDE)
            .map(|pixel| if pixel % 3 == 0 { 0.9_f32 } else { 0.7 }.to_bits())
            .collect();
        let cover = Cover {
            pixels: PixelBox {
                first: [0, 0],
                last: [31, 63],
            },
            origin: [0, 0],
            depth: &depth,
            alone: true,
        };
        let (mut left_out, mut kept) = (0, 0);
        for round in 0..300 {
            let size = [0.001, 0.03, 0.3][round % 3];
            let mut boxes = Boxes {
                middle: [[0.0; PART]; 3],
                half: [[0.0; PART]; 3],
            };
            for number in 0..PART {
                let depth = 3.0 + 2.5 * next();
                for (axis, reach) in [0.7 * depth, 0.7 * depth, 0.0].into_iter().enumerate() {
                    boxes.middle[axis][number] = reach * next();
                    boxes.half[axis][number] = size * next().abs();
                }
                boxes.middle[2][number] = -depth;
            }
            let hull = Hull {
                corners: [[-6.0; 3], [6.0; 3]],
                clip: CLIP,
                slack: [1e-6; 4],
            };
            let levels = [Level::new(), Level::fallback()];
            let [shown, scalar] = levels
                .map(|level| dispatch!(level, simd => view.shown_of(simd, &hull, &boxes, &cover)));
            assert_eq!(shown, scalar, "instructions do not matter");
            for number in 0..PART {
                let of = |of: &[[f32; PART]; 3]| [0, 1, 2].map(|axis| f64::from(of[axis][number]));
                let may_show = match projected(&view, of(&boxes.middle), of(&boxes.half)) {
                    None => true,
                    Some(([least, greatest], nearest)) => (0..64).any(|y| {
                        (0..32).any(|x| {
                            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                            let within =
                                |axis: usize| at[axis] >= least[axis] && at[axis] <= greatest[axis];
                            let there = depth[(y * BLOCK_SIDE + x) as usize];
                            within(0) && within(1) && f64::from(f32::from_bits(there)) >= nearest
                        })
                    }),
                };
                let is_shown = shown >> number & 1 == 1;
                assert!(is_shown || !may_show, "round {round}, primitive {number}");
                kept += usize::from(is_shown && may_show);
                left_out += usize::from(!is_shown);
            }
        }
        assert!(left_out > 5000 && kept > 3000, "{left_out} and {kept}");
    }

    #[test]
    fn what_is_no_number_may_show_anywhere() {
        let view = View::new(64, 64, Samples::One);
        let cover = Cover {
            pixels: PixelBox {
                first: [0, 0],
                last: [63, 63],
            },
            origin: [0, 0],
            depth: &[0; 64 * 64],
            alone: true,
        };
        let mut boxes = Boxes {
            middle: [[-3.0; PART]; 3],
            half: [[0.1; PART]; 3],
        };
        boxes.middle[1][7] = f32::NAN;
        boxes.half[2][20] = f32::INFINITY;
        boxes.middle[2][63] = 0.0;
        let hull = Hull {
            corners: [[-6.0; 3], [6.0; 3]],
            clip: CLIP,
            slack: [0.0; 4],
        };
        let shown = dispatch!(Level::new(), simd => view.shown_of(simd, &hull, &boxes, &cover));
        assert_eq!(shown, 1 << 7 | 1 << 20 | 1 << 63, "all else is hidden");
    }
}
