//! Pictures made smaller, for pages, and larger, for details.

use super::{Picture, ReportError};
use crate::math::{det, whole_u32};

/// The longer side of a picture on a page, in pixels, at most.
pub(super) const SIDE: u32 = 640;

/// A picture as it stands on a page: smaller by a whole factor, if it is too large.
///
/// # Errors
///
/// None for a picture.
pub(super) fn small(picture: &Picture) -> Result<Picture, ReportError> {
    let side = picture.width().max(picture.height());
    shrink(picture, side.div_ceil(SIDE))
}

/// A picture with both sides divided by `factor`, rounded up: each pixel is the mean, in linear light,
/// of the up to `factor × factor` pixels that it stands for, weighted by their alpha.
///
/// # Errors
///
/// None for a picture.
pub(super) fn shrink(picture: &Picture, factor: u32) -> Result<Picture, ReportError> {
    let factor = factor.max(1);
    if factor == 1 {
        return Ok(picture.clone());
    }
    let linear = linear_values();
    let (width, height) = (picture.width(), picture.height());
    let (columns, rows) = (width.div_ceil(factor), height.div_ceil(factor));
    let mut rgba = Vec::with_capacity(4 * columns as usize * rows as usize);
    for row in 0..rows {
        for column in 0..columns {
            let (mut sums, mut alpha, mut count) = ([0_u64; 3], 0_u64, 0_u64);
            for y in row * factor..((row + 1) * factor).min(height) {
                for x in column * factor..((column + 1) * factor).min(width) {
                    let first = 4 * (y as usize * width as usize + x as usize);
                    let pixel = &picture.rgba()[first..first + 4];
                    let weight = u64::from(pixel[3]);
                    for (sum, &byte) in sums.iter_mut().zip(pixel) {
                        *sum += weight * u64::from(linear[usize::from(byte)]);
                    }
                    alpha += weight;
                    count += 1;
                }
            }
            let colour = sums.map(|sum| nearest(&linear, (sum + alpha / 2) / alpha.max(1)));
            rgba.extend(colour);
            let mean = (alpha + count / 2) / count;
            rgba.push(u8::try_from(mean).unwrap_or(u8::MAX));
        }
    }
    Picture::new(columns, rows, rgba)
}

/// Every pixel as a square of so many.
///
/// # Errors
///
/// When it would be larger than a picture can be.
pub(super) fn enlarged(picture: &Picture, factor: u32) -> Result<Picture, ReportError> {
    let factor = factor.max(1);
    let (width, height) = (picture.width() * factor, picture.height() * factor);
    let mut rgba = Vec::with_capacity(4 * width as usize * height as usize);
    for y in 0..height {
        for x in 0..width {
            let pixel = (y / factor) as usize * picture.width() as usize + (x / factor) as usize;
            rgba.extend_from_slice(&picture.rgba()[4 * pixel..4 * pixel + 4]);
        }
    }
    Picture::new(width, height, rgba)
}

/// The linear value of every sRGB byte ([SRGB](crate::references)), with 2²⁴ for white.
fn linear_values() -> [u32; 256] {
    let mut values = [0; 256];
    for (value, byte) in values.iter_mut().zip(0_u8..=255) {
        let encoded = f64::from(byte) / 255.0;
        let linear = match encoded <= 0.04045 {
            true => encoded / 12.92,
            false => det::pow_f64((encoded + 0.055) / 1.055, 2.4),
        };
        *value = whole_u32(linear * f64::from(1 << 24) + 0.5);
    }
    values
}

/// The byte whose linear value is nearest.
fn nearest(linear: &[u32; 256], value: u64) -> u8 {
    let above = linear
        .partition_point(|&known| u64::from(known) < value)
        .min(255);
    let below = above.saturating_sub(1);
    let distance = |index: usize| u64::from(linear[index]).abs_diff(value);
    let index = if distance(below) <= distance(above) {
        below
    } else {
        above
    };
    u8::try_from(index).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, pixels: &[[u8; 4]]) -> Picture {
        let height = u32::try_from(pixels.len()).unwrap() / width;
        Picture::new(width, height, pixels.concat()).unwrap()
    }

    #[test]
    fn bytes_survive_the_way_to_linear_light_and_back() {
        let linear = linear_values();
        for byte in 0..=255_u8 {
            assert_eq!(nearest(&linear, u64::from(linear[usize::from(byte)])), byte);
        }
        assert_eq!(nearest(&linear, u64::MAX), 255);
    }

    #[test]
    fn means_are_those_of_light() {
        let (black, white) = ([0, 0, 0, 255], [255; 4]);
        // Half the light of white is byte 188.
        let small = shrink(&picture(2, &[black, white, white, black]), 2).unwrap();
        assert_eq!(small.rgba(), [188, 188, 188, 255]);
        // What is clear has no colour to give.
        let small = shrink(&picture(2, &[[255, 0, 0, 255], [0, 255, 0, 0]]), 2).unwrap();
        assert_eq!((small.width(), small.height()), (1, 1));
        assert_eq!(small.rgba(), [255, 0, 0, 128]);
    }

    #[test]
    fn the_last_column_may_stand_for_fewer() {
        let grey = |value| [value, value, value, 255];
        let small = shrink(&picture(3, &[grey(9), grey(9), grey(77)]), 2).unwrap();
        assert_eq!(small.rgba(), [grey(9), grey(77)].concat());
    }
}
