//! From clip space to sub-pixels: where things lie on the target, and which pixels are theirs.

use super::Samples;
use super::clip::Volume;
use super::setup::Triangle;

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
            samples: [across.clone().min().unwrap_or(0), across.max().unwrap_or(0)],
        }
    }

    /// The same target, of which nothing is drawn but some pixels.
    pub(super) fn within(mut self, pixels: PixelBox) -> Self {
        for axis in 0..2 {
            let shown = &mut self.shown;
            shown.first[axis] = shown.first[axis].max(pixels.first[axis]);
            shown.last[axis] = shown.last[axis].min(pixels.last[axis]);
        }
        self
    }

    /// The pixels with a sample within a box of sub-pixels, its right and lower rim excluded, since
    /// no triangle covers a sample there.
    #[inline]
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

    /// The pixels that a triangle may cover.
    #[inline]
    pub(super) fn pixels_of(&self, triangle: &Triangle) -> Option<PixelBox> {
        self.pixels(range_of(triangle.x), range_of(triangle.y))
    }

    #[inline]
    pub(super) fn project(&self, position: [f64; 4]) -> Projected {
        let [x, y] = self.subpixels(position);
        Projected {
            x: snap(x),
            y: snap(y),
            depth: unit_depth(position[2] * (1.0 / position[3])),
        }
    }

    /// Where a position lies, in sub-pixels to the right and downwards.
    #[inline]
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

/// A vertex on the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projected {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) depth: f32,
}

/// The nearest sub-pixel, halves to the even one, at most 2²³ from the first.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    reason = "sub-pixels are kept within 2^23, and the sum has rounded already"
)]
pub(super) fn snap(subpixels: f64) -> i32 {
    // Adding 1.5 · 2⁵² leaves no bits for a fraction; the addition rounds to nearest even.
    const FURTHEST: f64 = 8_388_608.0;
    const ROUND: f64 = 6_755_399_441_055_744.0;
    // Within the guard band already, but for vertices that cutting absurd coordinates made.
    let subpixels = subpixels.clamp(-FURTHEST, FURTHEST);
    ((subpixels + ROUND) - ROUND) as i32
}

/// A depth within [0, 1]; −0 and no number become 0.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    reason = "depths are f32, rounded once"
)]
fn unit_depth(depth: f64) -> f32 {
    clamp_depth(depth as f32)
}

/// A depth within [0, 1] whose bits order as its value: −0 and no number become 0.
#[inline]
pub(super) fn clamp_depth(depth: f32) -> f32 {
    let depth = if depth > 0.0 { depth } else { 0.0 };
    if depth < 1.0 { depth } else { 1.0 }
}

/// One over `w`, as attributes use it.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    reason = "attributes are f32, rounded once"
)]
pub(super) fn inverse_w(w: f64) -> f32 {
    (1.0 / w) as f32
}

#[inline]
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
