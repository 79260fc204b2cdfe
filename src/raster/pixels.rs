//! Which pixels a triangle covers, by its edge functions.
//!
//! A triangle is convex, so a row of samples has one span of covered ones. Where it begins and ends
//! is a quotient of integers for each edge; quotient and remainder are carried from row to row by
//! additions. That costs nothing for the pixels beside the span, of which thin leaves that lie
//! across have the more. Boxes of a few pixels are not worth the divisions.

use std::ops::RangeInclusive;

use super::Samples;
use super::plane::{Edges, coordinates};
use super::view::{PixelBox, SUBPIXELS};

/// The covered pixels of a row, for each sample: columns from the first to the last.
#[derive(Debug)]
pub(super) struct Spans<const SAMPLES: usize> {
    pub(super) y: i32,
    spans: [[i32; 2]; SAMPLES],
}

impl<const SAMPLES: usize> Spans<SAMPLES> {
    /// The columns of which some sample is covered lie within these; none when the last is less.
    #[inline(always)]
    pub(super) fn columns(&self) -> [i32; 2] {
        let [mut first, mut last] = self.spans[0];
        for [begin, end] in &self.spans[1..] {
            if begin <= end {
                let empty = first > last;
                first = if empty { *begin } else { first.min(*begin) };
                last = if empty { *end } else { last.max(*end) };
            }
        }
        [first, last]
    }

    /// A bit a covered sample.
    #[inline]
    pub(super) fn mask(&self, x: i32) -> u32 {
        if SAMPLES == 1 {
            return 1;
        }
        let mut mask = 0;
        for (sample, [first, last]) in self.spans.iter().enumerate() {
            mask |= u32::from((first..=last).contains(&&x)) << sample;
        }
        mask
    }
}

/// What the edge functions gain from a pixel's centre to each sample.
pub(super) type Gains<const SAMPLES: usize> = [[i64; 3]; SAMPLES];

#[inline]
pub(super) fn gains<const SAMPLES: usize>(samples: Samples, edges: &Edges) -> Gains<SAMPLES> {
    let mut gains = [[0; 3]; SAMPLES];
    if SAMPLES > 1 {
        for (gain, offset) in gains.iter_mut().zip(samples.offsets()) {
            let [dx, dy] = offset.map(|offset| i64::from(offset - SUBPIXELS / 2));
            for (k, gain) in gain.iter_mut().enumerate() {
                *gain = edges.right[k] * dx + edges.down[k] * dy;
            }
        }
    }
    gains
}

/// Boxes of no more pixels are decided pixel by pixel.
const FEW: i32 = 8;

/// The spans of some pixels, row by row.
///
/// An iterator and no closure for each row: that would be compiled with the instructions that every machine
/// has, whatever its caller has.
#[derive(Debug)]
pub(super) struct SpanRows<'e, const SAMPLES: usize> {
    edges: &'e Edges,
    gains: &'e Gains<SAMPLES>,
    columns: [i32; 2],
    rows: RangeInclusive<i32>,
    /// None where there are few pixels.
    walks: Option<[Walk; SAMPLES]>,
}

impl<'e, const SAMPLES: usize> SpanRows<'e, SAMPLES> {
    #[inline(always)]
    pub(super) fn of(edges: &'e Edges, gains: &'e Gains<SAMPLES>, pixels: PixelBox) -> Self {
        let [first, last] = [pixels.first, pixels.last];
        let few = (last[0] - first[0] + 1) * (last[1] - first[1] + 1) <= FEW;
        Self {
            edges,
            gains,
            columns: [first[0], last[0]],
            rows: first[1]..=last[1],
            walks: (!few).then(|| gains.map(|gain| Walk::new(edges, gain, first[1]))),
        }
    }
}

impl<const SAMPLES: usize> Iterator for SpanRows<'_, SAMPLES> {
    type Item = Spans<SAMPLES>;

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let y = self.rows.next()?;
        let Some(walks) = &mut self.walks else {
            let spans = each_pixel(self.edges, self.gains, self.columns, y);
            return Some(Spans { y, spans });
        };
        let mut spans = [NONE; SAMPLES];
        for (span, walk) in spans.iter_mut().zip(walks) {
            *span = walk.span(self.columns);
            walk.step();
        }
        Some(Spans { y, spans })
    }
}

/// The spans of a row by the rule itself.
#[inline(always)]
fn each_pixel<const SAMPLES: usize>(
    edges: &Edges,
    gains: &Gains<SAMPLES>,
    columns: [i32; 2],
    y: i32,
) -> [[i32; 2]; SAMPLES] {
    let mut spans = [NONE; SAMPLES];
    for x in columns[0]..=columns[1] {
        let at = edges.at_pixel(x, y);
        for (span, gain) in spans.iter_mut().zip(gains) {
            let value = |k: usize| at[k] + gain[k] + edges.bias[k];
            if value(0) | value(1) | value(2) >= 0 {
                *span = [if *span == NONE { x } else { span[0] }, x];
            }
        }
    }
    spans
}

/// No pixels.
const NONE: [i32; 2] = [0, -1];

/// Where the edges cut a row of samples.
#[derive(Debug)]
struct Walk {
    /// An edge with the covered samples to its right, any edge, one with the samples to its left.
    cuts: [Cut; 3],
    /// Whether the second one has the samples to its right.
    left: bool,
}

impl Walk {
    #[inline(always)]
    fn new(edges: &Edges, gain: [i64; 3], y: i32) -> Self {
        let at = edges.at_pixel(0, y);
        // Steps to the right add up to 0, but are not all 0, since there is an area.
        let rising = if edges.right[0] > 0 {
            0
        } else if edges.right[1] > 0 {
            1
        } else {
            2
        };
        let (one, other) = ((rising + 1) % 3, (rising + 2) % 3);
        let falls = edges.right[other] < 0;
        let (any, falling) = if falls { (one, other) } else { (other, one) };
        let cut = |k: usize| {
            Cut::new(
                at[k] + gain[k] + edges.bias[k],
                edges.right[k],
                edges.down[k],
            )
        };
        Self {
            cuts: [cut(rising), cut(any), cut(falling)],
            left: edges.right[any] > 0,
        }
    }

    /// The covered columns of some.
    #[inline(always)]
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a span lies within the columns, or is none"
    )]
    fn span(&self, [first, last]: [i32; 2]) -> [i32; 2] {
        let [rising, any, falling] = self.cuts.each_ref().map(|cut| cut.quotient);
        let first = i64::from(first).max(-rising);
        let last = i64::from(last).min(falling);
        let (first, last) = if self.left {
            (first.max(-any), last)
        } else {
            (first, last.min(any))
        };
        if first <= last {
            [first as i32, last as i32]
        } else {
            NONE
        }
    }

    /// To the row below.
    #[inline(always)]
    fn step(&mut self) {
        for cut in &mut self.cuts {
            cut.step();
        }
    }
}

/// `⌊e / |right|⌋` for an edge function with its bias at the first column of a row: the number of
/// the last column within, or minus that of the first where `e` grows to the right.
#[derive(Debug, Clone, Copy)]
struct Cut {
    quotient: i64,
    remainder: i64,
    /// What a row adds to both.
    step: [i64; 2],
    divisor: i64,
}

impl Cut {
    #[inline(always)]
    fn new(at: i64, right: i64, down: i64) -> Self {
        let pixel = i64::from(SUBPIXELS);
        let divisor = (right * pixel).abs();
        if divisor == 0 {
            // Along the row: all columns are within, or none. Any of them is less than 2¹⁴.
            return Self {
                quotient: (2 * at + 1) << 14,
                remainder: 0,
                step: [(2 * down * pixel) << 14, 0],
                divisor: 1,
            };
        }
        let divide = |value: i64| [value.div_euclid(divisor), value.rem_euclid(divisor)];
        let [quotient, remainder] = divide(at);
        Self {
            quotient,
            remainder,
            step: divide(down * pixel),
            divisor,
        }
    }

    #[inline(always)]
    fn step(&mut self) {
        let remainder = self.remainder + self.step[1] - self.divisor;
        let carry = remainder >= 0;
        self.quotient += self.step[0] + i64::from(carry);
        self.remainder = if carry {
            remainder
        } else {
            remainder + self.divisor
        };
    }
}

/// The second and third edge functions along a row of pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    at: [i64; 2],
    right: [i64; 2],
}

impl Along {
    #[inline]
    pub(super) fn new(edges: &Edges, x: i32, y: i32) -> Self {
        let [_, second, third] = edges.at_pixel(x, y);
        let pixel = i64::from(SUBPIXELS);
        Self {
            at: [second, third],
            right: [edges.right[1] * pixel, edges.right[2] * pixel],
        }
    }

    /// At the pixel's centre.
    #[inline]
    pub(super) fn centre(&self) -> [f32; 2] {
        coordinates(self.at)
    }

    /// At a sample, to which the edge functions gain this.
    #[inline]
    pub(super) fn sample(&self, gain: [i64; 3]) -> [f32; 2] {
        coordinates([self.at[0] + gain[1], self.at[1] + gain[2]])
    }

    /// To the next pixel.
    #[inline]
    pub(super) fn step(&mut self) {
        self.at[0] += self.right[0];
        self.at[1] += self.right[1];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::setup::Triangle;

    fn triangle(x: [i32; 3], y: [i32; 3]) -> Triangle {
        Triangle {
            x,
            y,
            depth: 0.0,
            depth_slopes: [0.0; 2],
            nearest: 0.0,
            vertex: 0,
            corners: [0; 3],
            pixels: PixelBox {
                first: [0; 2],
                last: [0; 2],
            },
            primitive: 0,
            part: 0,
            front: false,
            cut: false,
        }
    }

    /// The mask of each pixel of a box, by its spans.
    fn by_spans<const SAMPLES: usize>(edges: &Edges, samples: Samples, side: i32) -> Vec<u32> {
        let mut masks = vec![0; (side * side).unsigned_abs() as usize];
        let pixels = PixelBox {
            first: [0, 0],
            last: [side - 1, side - 1],
        };
        let gains = gains::<SAMPLES>(samples, edges);
        for spans in SpanRows::of(edges, &gains, pixels) {
            let [first, last] = spans.columns();
            for x in first..=last {
                masks[(spans.y * side + x).unsigned_abs() as usize] |= spans.mask(x);
            }
        }
        masks
    }

    /// The same by the rule itself, sample by sample.
    fn by_rule<const SAMPLES: usize>(edges: &Edges, samples: Samples, side: i32) -> Vec<u32> {
        let gains = gains::<SAMPLES>(samples, edges);
        let pixels = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
        let mask = |[x, y]: [i32; 2]| {
            let at = edges.at_pixel(x, y);
            let covers = |gain: &[i64; 3]| (0..3).all(|k| at[k] + gain[k] + edges.bias[k] >= 0);
            let bits = gains.iter().zip(0..);
            bits.fold(0, |mask, (gain, bit)| mask | u32::from(covers(gain)) << bit)
        };
        pixels.map(mask).collect()
    }

    #[test]
    fn spans_are_what_edge_functions_say() {
        let mut state = 1_u64;
        let mut next = |range: i32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            let sides = 2 * range.unsigned_abs() + 1;
            i32::try_from((state >> 33) % u64::from(sides)).unwrap() - range
        };
        for round in 0..4000 {
            // Corners on pixel centres, on sub-pixels, and far out.
            let range = [8, 1500, 4000, 1 << 23][round % 4];
            let grid = [128, 1, 128, 1][round / 4 % 4].min(range / 8);
            let mut corner = || (next(range) / grid * grid).clamp(-(1 << 23), 1 << 23) + 1024;
            let (x, y) = (
                [corner(), corner(), corner()],
                [corner(), corner(), corner()],
            );
            let area = i64::from(x[1] - x[0]) * i64::from(y[2] - y[0])
                - i64::from(x[2] - x[0]) * i64::from(y[1] - y[0]);
            let edges = match area {
                0 => continue,
                1.. => Edges::of(&triangle(x, y)),
                ..0 => Edges::of(&triangle([x[0], x[2], x[1]], [y[0], y[2], y[1]])),
            };
            for side in [2, 9] {
                let one = Samples::One;
                assert_eq!(
                    by_spans::<1>(&edges, one, side),
                    by_rule::<1>(&edges, one, side),
                    "{x:?} {y:?}"
                );
                let four = Samples::Four;
                assert_eq!(
                    by_spans::<4>(&edges, four, side),
                    by_rule::<4>(&edges, four, side),
                    "{x:?} {y:?}"
                );
            }
        }
    }
}
