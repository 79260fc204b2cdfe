//! From clip space to sub-pixels: where things lie on the target, and which pixels are theirs.

use fearless_simd::Level;

use super::Samples;
use super::clip::Volume;

/// Sub-pixels a pixel, along each axis.
pub(super) const SUBPIXELS: i32 = 256;

/// The target as set-up sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// The pixels that are drawn.
    shown: PixelBox,
    /// Half the target in sub-pixels.
    half: [f64; 2],
    pub(super) volume: Volume,
    /// The first and last sub-pixel of a pixel that has a sample, along each axis.
    samples: [i32; 2],
    count: Samples,
    /// Which instructions may be used.
    pub(super) level: Level,
}

impl View {
    #[expect(
        clippy::cast_possible_wrap,
        reason = "sides are at most Target::MAX_SIDE"
    )]
    pub(super) fn new(width: u32, height: u32, samples: Samples) -> Self {
        let half = |side: u32| f64::from(side) * f64::from(SUBPIXELS / 2);
        let offsets = samples.offsets();
        let across = offsets.iter().map(|offset| offset[0]);
        Self {
            shown: PixelBox {
                first: [0; 2],
                last: [width as i32 - 1, height as i32 - 1],
            },
            half: [half(width), half(height)],
            volume: Volume::new(width, height),
            count: samples,
            level: Level::new(),
            samples: [across.clone().min().unwrap_or(0), across.max().unwrap_or(0)],
        }
    }

    /// The same with other instructions.
    pub(super) fn with(self, level: Level) -> Self {
        Self { level, ..self }
    }

    /// All pixels.
    #[inline(always)]
    pub(super) fn shown(&self) -> PixelBox {
        self.shown
    }

    /// The first and last sub-pixel of a pixel that has a sample.
    #[inline(always)]
    pub(super) fn samples(&self) -> [i32; 2] {
        self.samples
    }

    /// How many samples a pixel has.
    pub(super) fn count(&self) -> Samples {
        self.count
    }

    /// Half the target in sub-pixels.
    #[inline(always)]
    pub(super) fn half(&self) -> [f64; 2] {
        self.half
    }

    /// Half the target in pixels.
    #[inline(always)]
    pub(super) fn half_pixels(&self) -> [f32; 2] {
        let half = |axis: usize| (self.shown.last[axis] + 1) as f32 * 0.5;
        [half(0), half(1)]
    }

    /// The pixels with a sample within a box of sub-pixels, its right and lower rim excluded, since
    /// no triangle covers a sample there.
    #[inline(always)]
    pub(super) fn pixels(&self, x: [i32; 2], y: [i32; 2]) -> Option<PixelBox> {
        let [least, greatest] = self.samples;
        let shown = self.shown;
        let first = |from: i32, rim: i32| ((from - greatest + SUBPIXELS - 1) >> 8).max(rim);
        let last = |to: i32, rim: i32| ((to - least - 1) >> 8).min(rim);
        let pixels = PixelBox {
            first: [first(x[0], shown.first[0]), first(y[0], shown.first[1])],
            last: [last(x[1], shown.last[0]), last(y[1], shown.last[1])],
        };
        let some = pixels.first[0] <= pixels.last[0] && pixels.first[1] <= pixels.last[1];
        some.then_some(pixels)
    }

    /// Whether a triangle of positive area misses the centres of its few pixels; not looked at where there
    /// are many, or more samples.
    #[inline(always)]
    pub(super) fn is_missed(&self, x: [i32; 3], y: [i32; 3], pixels: PixelBox) -> bool {
        const FEW: i32 = 4;
        let [columns, rows] = [
            pixels.last[0] - pixels.first[0] + 1,
            pixels.last[1] - pixels.first[1] + 1,
        ];
        // With samples on either side of the centre one of them is not the only one.
        if columns * rows > FEW || self.samples[0] != self.samples[1] {
            return false;
        }
        for row in pixels.first[1]..=pixels.last[1] {
            for column in pixels.first[0]..=pixels.last[0] {
                let px = i64::from(column * SUBPIXELS + SUBPIXELS / 2);
                let py = i64::from(row * SUBPIXELS + SUBPIXELS / 2);
                let mut outside = 0;
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    let (dx, dy) = (i64::from(x[to] - x[from]), i64::from(y[to] - y[from]));
                    let right_of = i64::from(dy < 0 || (dy == 0 && dx > 0)) - 1;
                    outside |=
                        dx * (py - i64::from(y[from])) - dy * (px - i64::from(x[from])) + right_of;
                }
                if outside >= 0 {
                    return false;
                }
            }
        }
        true
    }

    #[inline(always)]
    pub(super) fn project(&self, position: [f64; 4]) -> Projected {
        let [x, y] = self.subpixels(position);
        Projected {
            x: snap(x),
            y: snap(y),
            depth: unit_depth(position[2] * (1.0 / position[3])),
        }
    }

    /// Where a position lies, in sub-pixels to the right and downwards.
    #[inline(always)]
    pub(super) fn subpixels(&self, position: [f64; 4]) -> [f64; 2] {
        let [x, y, _, w] = position;
        let inverse_w = 1.0 / w;
        [
            self.half[0] + x * inverse_w * self.half[0],
            self.half[1] - y * inverse_w * self.half[1],
        ]
    }
}

/// Columns and rows from the first to the last, both within.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PixelBox {
    pub(super) first: [i32; 2],
    pub(super) last: [i32; 2],
}

impl PixelBox {
    /// How many pixels there are.
    #[inline(always)]
    pub(super) fn count(self) -> usize {
        let side = |axis: usize| (self.last[axis] - self.first[axis] + 1).unsigned_abs() as usize;
        side(0) * side(1)
    }

    /// The pixels of both.
    #[inline(always)]
    pub(super) fn meet(self, other: Self) -> Option<Self> {
        let both = Self {
            first: [
                self.first[0].max(other.first[0]),
                self.first[1].max(other.first[1]),
            ],
            last: [
                self.last[0].min(other.last[0]),
                self.last[1].min(other.last[1]),
            ],
        };
        let some = both.first[0] <= both.last[0] && both.first[1] <= both.last[1];
        some.then_some(both)
    }
}

/// A vertex on the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) depth: f32,
}

/// The furthest sub-pixel from the first.
pub(super) const FURTHEST: f64 = 8_388_608.0;
/// 1.5 · 2⁵²: adding it leaves no bits for a fraction; the addition rounds to nearest even.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0;

/// The nearest sub-pixel, halves to the even one, at most 2²³ from the first.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "sub-pixels are kept within 2^23, and the sum has rounded already"
)]
pub(super) fn snap(subpixels: f64) -> i32 {
    // Within the guard band already, but for vertices that cutting absurd coordinates made.
    let subpixels = subpixels.clamp(-FURTHEST, FURTHEST);
    ((subpixels + ROUND) - ROUND) as i32
}

/// A depth within [0, 1]; −0 and no number become 0.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "depths are f32, rounded once"
)]
fn unit_depth(depth: f64) -> f32 {
    clamp_depth(depth as f32)
}

/// A depth within [0, 1] whose bits order as its value: −0 and no number become 0.
#[inline(always)]
pub(super) fn clamp_depth(depth: f32) -> f32 {
    let depth = if depth > 0.0 { depth } else { 0.0 };
    if depth < 1.0 { depth } else { 1.0 }
}

/// One over `w`, as attributes use it.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    reason = "attributes are f32, rounded once"
)]
pub(super) fn inverse_w(w: f64) -> f32 {
    (1.0 / w) as f32
}

#[inline(always)]
pub(super) fn range_of(values: [i32; 3]) -> [i32; 2] {
    let [a, b, c] = values;
    [a.min(b).min(c), a.max(b).max(c)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_go_to_the_even_sub_pixel() {
        let snapped = [0.5, 1.5, 2.5, -0.5, -1.5, 0.500_1, 1e9, -1e300].map(snap);
        assert_eq!(snapped, [0, 2, 2, 0, -2, 1, 1 << 23, -(1 << 23)]);
    }

    #[test]
    fn depths_order_as_their_bits() {
        assert_eq!(clamp_depth(-0.0).to_bits(), 0);
        assert_eq!(clamp_depth(f32::NAN).to_bits(), 0);
        assert_eq!(clamp_depth(-3.0), 0.0);
        assert_eq!(clamp_depth(1.5), 1.0);
        assert_eq!(clamp_depth(0.25), 0.25);
    }

    #[test]
    fn positions_lie_where_clip_space_says() {
        let view = View::new(64, 32, Samples::One);
        let at = |position| {
            let Projected { x, y, depth } = view.project(position);
            (x, y, depth)
        };
        assert_eq!(at([0.0, 0.0, 0.5, 1.0]), (32 * 256, 16 * 256, 0.5));
        assert_eq!(at([-2.0, 2.0, 0.0, 2.0]), (0, 0, 0.0));
        assert_eq!(at([4.0, -4.0, 4.0, 4.0]), (64 * 256, 32 * 256, 1.0));
    }

    #[test]
    fn boxes_hold_the_pixels_with_a_sample_within() {
        let pixels = |samples, x, y| View::new(8, 8, samples).pixels(x, y);
        let from_to = |first, last| Some(PixelBox { first, last });
        let one = Samples::One;
        assert_eq!(pixels(one, [0, 256], [0, 512]), from_to([0, 0], [0, 1]));
        assert_eq!(pixels(one, [129, 384], [0, 256]), None, "1.5 is excluded");
        assert_eq!(pixels(one, [129, 385], [0, 256]), from_to([1, 0], [1, 0]));
        assert_eq!(pixels(one, [128, 129], [0, 256]), from_to([0, 0], [0, 0]));
        assert_eq!(
            pixels(Samples::Four, [225, 300], [-900, 9000]),
            from_to([1, 0], [1, 7])
        );
        assert_eq!(pixels(Samples::Four, [225, 288], [0, 256]), None);
    }
}
