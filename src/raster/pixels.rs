//! Which pixels a triangle covers, by its edge functions.
//!
//! Small triangles, of which foliage is made, are decided 8 × 8 pixels at a time in 32-bit lanes and
//! without a branch; others pixel by pixel in 64 bits. Both are exact, so both say the same.

use super::Samples;
use super::plane::{Edges, coordinates};
use super::view::{PixelBox, SUBPIXELS};

/// A pixel of which a triangle covers some sample.
pub(super) struct Covered<'a, const SAMPLES: usize> {
    pub(super) x: i32,
    pub(super) y: i32,
    /// A bit a covered sample.
    pub(super) mask: u32,
    /// The second and third edge function at the pixel's centre.
    centre: [i64; 2],
    to_samples: &'a Gains<SAMPLES>,
}

/// What the edge functions gain from a pixel's centre to each sample.
type Gains<const SAMPLES: usize> = [[i64; 3]; SAMPLES];

impl<const SAMPLES: usize> Covered<'_, SAMPLES> {
    /// The second and third edge functions at a sample.
    #[inline]
    pub(super) fn at(&self, sample: usize) -> [f32; 2] {
        if SAMPLES == 1 {
            return self.centre();
        }
        let [_, second, third] = self.to_samples[sample];
        coordinates([self.centre[0] + second, self.centre[1] + third])
    }

    /// The second and third edge functions at the pixel's centre.
    #[inline]
    pub(super) fn centre(&self) -> [f32; 2] {
        coordinates(self.centre)
    }

    /// Column and row.
    #[inline]
    pub(super) fn position(&self) -> [u32; 2] {
        [self.x.unsigned_abs(), self.y.unsigned_abs()]
    }
}

/// Visits those of some pixels of which the triangle covers some sample.
#[inline]
pub(super) fn visit_pixels<const SAMPLES: usize>(
    samples: Samples,
    edges: &Edges,
    pixels: PixelBox,
    each: impl FnMut(&Covered<'_, SAMPLES>),
) {
    let mut to_samples = [[0; 3]; SAMPLES];
    if SAMPLES > 1 {
        for (gain, offset) in to_samples.iter_mut().zip(samples.offsets()) {
            let [dx, dy] = offset.map(|offset| i64::from(offset - SUBPIXELS / 2));
            for (k, gain) in gain.iter_mut().enumerate() {
                *gain = edges.right[k] * dx + edges.down[k] * dy;
            }
        }
    }
    if is_small(edges) {
        visit_small(edges, pixels, &to_samples, each);
    } else {
        visit_large(edges, pixels, &to_samples, each);
    }
}

/// Whether all edges are shorter than 64 pixels along each axis. Then an edge function is below 2³⁰
/// in the triangle's box and 8 pixels around it: the product of 2¹⁴ and 72 · 2⁸, twice.
#[inline]
fn is_small(edges: &Edges) -> bool {
    let mut longest = 0;
    for gain in edges.right.iter().chain(&edges.down) {
        longest |= gain.unsigned_abs();
    }
    longest < 1 << 14
}

/// Pixels a side of what is decided at once.
const LANES: i32 = 8;

#[inline]
fn visit_small<const SAMPLES: usize>(
    edges: &Edges,
    pixels: PixelBox,
    to_samples: &Gains<SAMPLES>,
    mut each: impl FnMut(&Covered<'_, SAMPLES>),
) {
    let step = |gain: [i64; 3]| narrow(gain).map(|gain| gain * SUBPIXELS);
    let (right, down) = (step(edges.right), step(edges.down));
    let bias = narrow(edges.bias);
    let mut lanes = Lanes::default();
    for (lanes, right) in lanes.iter_mut().zip(right) {
        for (lane, column) in lanes.iter_mut().zip(0..) {
            *lane = column * right;
        }
    }
    for top in (pixels.first[1]..=pixels.last[1]).step_by(LANES as usize) {
        for left in (pixels.first[0]..=pixels.last[0]).step_by(LANES as usize) {
            let corner = narrow(edges.at_pixel(left, top));
            let rows = (pixels.last[1] - top + 1).min(LANES);
            let columns = (pixels.last[0] - left + 1).min(LANES);
            let mut masks = [0_u64; SAMPLES];
            for (mask, gain) in masks.iter_mut().zip(to_samples) {
                let gain = narrow(*gain);
                let mut at = [0, 1, 2].map(|k| corner[k] + gain[k] + bias[k]);
                for row in 0..rows {
                    *mask |= (inside(at, &lanes) & (0xff >> (LANES - columns))) << (row * LANES);
                    for (value, down) in at.iter_mut().zip(down) {
                        *value += down;
                    }
                }
            }
            let mut rest = masks.iter().fold(0, |any, mask| any | mask);
            while rest != 0 {
                let bit = rest.trailing_zeros();
                rest &= rest - 1;
                let (column, row) = ((bit & 7).cast_signed(), (bit >> 3).cast_signed());
                let mut mask = 0;
                for (sample, covered) in masks.iter().enumerate() {
                    mask |= u32::from(covered >> bit & 1 == 1) << sample;
                }
                let at = |k: usize| i64::from(corner[k] + column * right[k] + row * down[k]);
                each(&Covered {
                    x: left + column,
                    y: top + row,
                    mask,
                    centre: [at(1), at(2)],
                    to_samples,
                });
            }
        }
    }
}

/// What each edge function gains to each of 8 columns.
type Lanes = [[i32; LANES as usize]; 3];

/// A bit a column in which no edge function is negative.
#[inline]
fn inside(at: [i32; 3], lanes: &Lanes) -> u64 {
    let mut columns = [0_u8; LANES as usize];
    for (lane, column) in columns.iter_mut().enumerate() {
        let signs = (at[0] + lanes[0][lane]) | (at[1] + lanes[1][lane]) | (at[2] + lanes[2][lane]);
        *column = if signs >= 0 { 1 << lane } else { 0 };
    }
    // Every byte has a bit of its own, so that they are gathered by folding.
    let folded = u64::from_le_bytes(columns);
    let folded = folded | folded >> 32;
    let folded = folded | folded >> 16;
    (folded | folded >> 8) & 0xff
}

#[inline]
#[expect(
    clippy::cast_possible_truncation,
    reason = "only of small triangles, whose edge functions fit"
)]
fn narrow(values: [i64; 3]) -> [i32; 3] {
    [values[0] as i32, values[1] as i32, values[2] as i32]
}

#[inline]
fn visit_large<const SAMPLES: usize>(
    edges: &Edges,
    pixels: PixelBox,
    to_samples: &Gains<SAMPLES>,
    mut each: impl FnMut(&Covered<'_, SAMPLES>),
) {
    let step = |gain: [i64; 3]| gain.map(|gain| gain * i64::from(SUBPIXELS));
    let ([r0, r1, r2], [d0, d1, d2]) = (step(edges.right), step(edges.down));
    let [b0, b1, b2] = edges.bias;
    let [mut row0, mut row1, mut row2] = edges.at_pixel(pixels.first[0], pixels.first[1]);
    for y in pixels.first[1]..=pixels.last[1] {
        let [mut e0, mut e1, mut e2] = [row0, row1, row2];
        let mut entered = false;
        for x in pixels.first[0]..=pixels.last[0] {
            let mut mask = 0;
            for (sample, gain) in to_samples.iter().enumerate() {
                let inside = (e0 + gain[0] + b0) | (e1 + gain[1] + b1) | (e2 + gain[2] + b2);
                mask |= u32::from(inside >= 0) << sample;
            }
            if mask != 0 {
                entered = true;
                each(&Covered {
                    x,
                    y,
                    mask,
                    centre: [e1, e2],
                    to_samples,
                });
            } else if SAMPLES == 1 && entered {
                // Triangles are convex: a row has one span.
                break;
            }
            e0 += r0;
            e1 += r1;
            e2 += r2;
        }
        row0 += d0;
        row1 += d1;
        row2 += d2;
    }
}
