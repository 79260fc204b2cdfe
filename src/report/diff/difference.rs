//! How many pixels differ, by how much, and where.

use crate::math::{det, index_u32};
use crate::report::{Picture, grouped};

/// What a comparison of two pictures of one size found, channel by channel, alpha included.
///
/// The difference of two pixels is the largest of their four channels, as bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// Width and height of both.
    pub size: [u32; 2],
    /// The largest difference of a pixel that counts as none.
    pub tolerance: u8,
    /// Pixels that differ by more than the tolerance.
    pub pixels: u64,
    /// Pixels that differ at all.
    pub unequal: u64,
    /// The largest difference of all pixels, tolerated or not.
    pub largest: u8,
    /// The first pixel that differs so much, row by row; (0, 0) if none differs.
    pub largest_at: [u32; 2],
    /// Left, top, right, bottom, inclusive, of the pixels that differ by more than the tolerance.
    pub bounds: Option<[u32; 4]>,
    /// The mean absolute difference of a channel, in 1/255: of R, G, B if both pictures are opaque,
    /// else of R, G, B, A.
    pub mean: f64,
    /// The mean squared difference of a channel, in 1/255², of the same channels.
    pub mean_square: f64,
}

/// Two pictures that cannot be compared pixel by pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{} × {} pixels, expected {} × {}", actual[0], actual[1], expected[0], expected[1])]
pub struct SizeMismatch {
    /// Width and height of the one.
    pub expected: [u32; 2],
    /// Width and height of the other.
    pub actual: [u32; 2],
}

impl Difference {
    /// Compares two pictures.
    ///
    /// # Errors
    ///
    /// When they are not of one size.
    pub fn between(
        expected: &Picture,
        actual: &Picture,
        tolerance: u8,
    ) -> Result<Self, SizeMismatch> {
        let [wanted, size] = [expected, actual].map(size);
        if wanted != size {
            return Err(SizeMismatch {
                expected: wanted,
                actual: size,
            });
        }
        let mut found = Self {
            size,
            tolerance,
            pixels: 0,
            unequal: 0,
            largest: 0,
            largest_at: [0; 2],
            bounds: None,
            mean: 0.0,
            mean_square: 0.0,
        };
        // Exact: 2²⁶ pixels of 4 · 255² fit by far.
        let (mut sum, mut squares) = (0_u64, 0_u64);
        let mut opaque = true;
        let rows = rows(expected).zip(rows(actual));
        for (y, (one, other)) in rows.enumerate() {
            opaque = opaque && one.iter().chain(other).all(|pixel| pixel[3] == 255);
            // Most rows of most comparisons.
            if one == other {
                continue;
            }
            for (x, (one, other)) in one.iter().zip(other).enumerate() {
                let channels = apart(*one, *other);
                let difference = channels.into_iter().max().unwrap_or(0);
                if difference == 0 {
                    continue;
                }
                let at = [index_u32(x), index_u32(y)];
                found.add(difference, at);
                for channel in channels {
                    sum += u64::from(channel);
                    squares += u64::from(channel) * u64::from(channel);
                }
            }
        }
        let channels = if opaque { 3.0 } else { 4.0 };
        let samples = found.total() as f64 * channels;
        found.mean = sum as f64 / samples;
        found.mean_square = squares as f64 / samples;
        Ok(found)
    }

    fn add(&mut self, difference: u8, at: [u32; 2]) {
        self.unequal += 1;
        if difference > self.largest {
            self.largest = difference;
            self.largest_at = at;
        }
        if difference <= self.tolerance {
            return;
        }
        self.pixels += 1;
        let [x, y] = at;
        let [left, top, right, bottom] = self.bounds.unwrap_or([x, y, x, y]);
        self.bounds = Some([left.min(x), top.min(y), right.max(x), bottom.max(y)]);
    }

    /// Whether no pixel differs by more than the tolerance.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.pixels == 0
    }

    /// Pixels of each picture.
    #[must_use]
    pub fn total(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// `10 log₁₀(255² / mean square)` in decibels, infinite for equal pictures.
    #[must_use]
    pub fn psnr(&self) -> f64 {
        if self.mean_square == 0.0 {
            return f64::INFINITY;
        }
        10.0 * det::log10_f64(255.0 * 255.0 / self.mean_square)
    }
}

/// `12 of 12,544 pixels differ, by up to 30 of 255 at (3, 4), x 2..=9, y 1..=7`.
impl std::fmt::Display for Difference {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            tolerance, largest, ..
        } = self;
        let [x, y] = self.largest_at;
        let total = grouped(self.total(), ",");
        let Some([left, top, right, bottom]) = self.bounds else {
            return match largest {
                0 => write!(out, "all {total} pixels are equal"),
                _ => write!(
                    out,
                    "{} of {total} pixels differ, by up to {largest} of 255 at ({x}, {y}), within \
                     the tolerance of {tolerance}",
                    grouped(self.unequal, ",")
                ),
            };
        };
        let beyond = match tolerance {
            0 => String::new(),
            _ => format!(" by more than {tolerance}"),
        };
        write!(
            out,
            "{} of {total} pixels differ{beyond}, by up to {largest} of 255 at ({x}, {y}), \
             x {left}..={right}, y {top}..={bottom}",
            grouped(self.pixels, ",")
        )
    }
}

/// Width and height.
pub(super) fn size(picture: &Picture) -> [u32; 2] {
    [picture.width(), picture.height()]
}

/// The pixels, row by row.
pub(super) fn rows(picture: &Picture) -> impl Iterator<Item = &[[u8; 4]]> + '_ {
    let pixels = picture.rgba().as_chunks::<4>().0;
    pixels.chunks_exact(picture.width() as usize)
}

/// The difference of each channel.
pub(super) fn apart(one: [u8; 4], other: [u8; 4]) -> [u8; 4] {
    let mut channels = one;
    for (channel, other) in channels.iter_mut().zip(other) {
        *channel = channel.abs_diff(other);
    }
    channels
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, grey, variant};
    use super::*;

    #[test]
    fn differences_are_told_with_number_size_and_place() {
        let (one, other) = (grey(0, 100), grey(5, 130));
        let words = |tolerance| {
            let difference = Difference::between(&one, &other, tolerance).unwrap();
            (difference.is_within(), difference.to_string())
        };
        let beyond = "1 of 6 pixels differ, by up to 30 of 255 at (2, 1), x 2..=2, y 1..=1";
        assert_eq!(words(0), (false, beyond.to_owned()));
        assert_eq!(
            words(29),
            (false, beyond.replace("differ", "differ by more than 29"))
        );
        let within = "1 of 6 pixels differ, by up to 30 of 255 at (2, 1), within the tolerance \
                      of 30";
        assert_eq!(words(30), (true, within.to_owned()));
        let same = Difference::between(&one, &one, 0).unwrap();
        assert_eq!(same.to_string(), "all 6 pixels are equal");
        assert!(same.is_within() && same.psnr().is_infinite());
    }

    #[test]
    fn means_are_those_of_the_channels_that_there_are() {
        let (one, other) = (grey(0, 100), grey(5, 130));
        let found = Difference::between(&one, &other, 0).unwrap();
        assert_eq!((found.mean, found.mean_square), (30.0 / 18.0, 900.0 / 18.0));
        // One pixel is clear: then alpha is a channel too.
        let mut rgba = one.rgba().to_vec();
        rgba[3] = 0;
        let clear = Picture::new(3, 2, rgba).unwrap();
        let found = Difference::between(&clear, &one, 254).unwrap();
        assert_eq!((found.pixels, found.largest), (1, 255));
        assert_eq!(
            (found.mean, found.mean_square),
            (255.0 / 24.0, 255.0 * 255.0 / 24.0)
        );
        // 10 lg 24 dB.
        assert!((found.psnr() - 13.802_112_417_116_06).abs() < 1e-12);
    }

    #[test]
    fn the_first_of_the_largest_and_the_box_of_all_are_named() {
        let black = Picture::new(4, 3, [0, 0, 0, 255].repeat(12)).unwrap();
        let mut rgba = black.rgba().to_vec();
        //  . 2 . .
        //  . . . 9
        //  9 . . .
        for (pixel, value) in [(1, 2), (7, 9), (8, 9)] {
            rgba[4 * pixel + 2] = value;
        }
        let other = Picture::new(4, 3, rgba).unwrap();
        let found = Difference::between(&black, &other, 1).unwrap();
        assert_eq!((found.largest, found.largest_at), (9, [3, 1]));
        assert_eq!((found.pixels, found.unequal), (3, 3));
        assert_eq!(found.bounds, Some([0, 0, 3, 2]));
        let found = Difference::between(&black, &other, 2).unwrap();
        assert_eq!((found.pixels, found.unequal), (2, 3));
        assert_eq!(found.bounds, Some([0, 1, 3, 2]));
    }

    #[test]
    fn sizes_must_agree() {
        let wide = Picture::new(6, 1, grey(0, 100).rgba().to_vec()).unwrap();
        let error = Difference::between(&grey(0, 100), &wide, 255).unwrap_err();
        assert_eq!(error.to_string(), "6 × 1 pixels, expected 3 × 2");
    }

    /// scikit-image 0.26.0, `peak_signal_noise_ratio(…, data_range=255)` of R, G, B.
    #[test]
    fn psnr_is_that_of_another_program() {
        for (name, wanted) in [
            ("offset", 28.130_803_608_7),
            ("noise", 28.525_132_815_0),
            ("shift", 20.339_650_823_8),
            ("spots", 25.085_679_546_6),
            ("one", 43.050_857_736_8),
            ("inverse", 7.962_280_153_1),
        ] {
            let found = Difference::between(&example(), &variant(name), 0).unwrap();
            assert!(
                (found.psnr() - wanted).abs() < 1e-9,
                "{name}: {}",
                found.psnr()
            );
        }
    }
}
