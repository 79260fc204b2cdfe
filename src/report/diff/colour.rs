//! Bytes to light, for what asks how things look.

use std::sync::LazyLock;

use super::difference::rows;
use crate::math::{det, whole_u32};
use crate::report::Picture;

/// What clear pictures are laid over to be looked at: the grey in the middle of the bytes.
const GROUND: u32 = 128;

/// The colours of some rows as they are seen, rows beyond the picture being its first or last.
///
/// Colours of pixels that are not opaque are laid over byte 128 in each channel: the mean of bytes
/// weighted by alpha, rounded, halves up. So what can only be seen before some other ground is
/// still a difference of bytes, if none of looks.
pub(super) fn seen_rows(
    picture: &Picture,
    rows_wanted: impl Iterator<Item = isize>,
) -> Vec<[u8; 3]> {
    let width = picture.width() as usize;
    let last = picture.height() as usize - 1;
    let pixels = picture.rgba().as_chunks::<4>().0;
    rows_wanted
        .flat_map(|row| {
            let row = usize::try_from(row).unwrap_or(0).min(last);
            &pixels[row * width..][..width]
        })
        .map(|pixel| seen(*pixel))
        .collect()
}

fn seen([red, green, blue, alpha]: [u8; 4]) -> [u8; 3] {
    let alpha = u32::from(alpha);
    [red, green, blue].map(|byte| {
        let sum = u32::from(byte) * alpha + GROUND * (255 - alpha);
        u8::try_from((2 * sum + 255) / 510).unwrap_or(u8::MAX)
    })
}

/// The linear value of an sRGB byte, 1 for white ([SRGB](crate::references)).
pub(super) fn linear(byte: u8) -> f64 {
    static VALUES: LazyLock<[f64; 256]> = LazyLock::new(|| {
        std::array::from_fn(|byte| {
            let encoded = byte as f64 / 255.0;
            match encoded <= 0.04045 {
                true => encoded / 12.92,
                false => det::pow_f64((encoded + 0.055) / 1.055, 2.4),
            }
        })
    });
    VALUES[usize::from(byte)]
}

/// The sRGB byte of linear light: `255 f(value)`, rounded, halves up, where `f` encodes
/// ([SRGB](crate::references)); below 0 and no number become 0, above 1 becomes 255.
pub(super) fn srgb_byte(value: f64) -> u8 {
    let value = value.clamp(0.0, 1.0);
    let encoded = if value <= 0.003_130_8 {
        12.92 * value
    } else {
        1.055 * det::pow_f64(value, 1.0 / 2.4) - 0.055
    };
    u8::try_from(whole_u32(encoded * 255.0 + 0.5)).unwrap_or(u8::MAX)
}

/// Whether both pictures, of one size, say the same from row `first` up to row `end`, which may lie
/// beyond the picture.
pub(super) fn are_equal(one: &Picture, other: &Picture, first: isize, end: isize) -> bool {
    let first = usize::try_from(first).unwrap_or(0);
    let count = usize::try_from(end).unwrap_or(0).saturating_sub(first);
    rows(one)
        .zip(rows(other))
        .skip(first)
        .take(count)
        .all(|(one, other)| one == other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_the_way_to_light_and_back() {
        for byte in 0..=255 {
            assert_eq!(srgb_byte(linear(byte)), byte);
        }
        let saturated = [f64::NAN, -1.0, f64::NEG_INFINITY, 1.5, f64::INFINITY].map(srgb_byte);
        assert_eq!(saturated, [0, 0, 0, 255, 255]);
    }

    #[test]
    fn what_is_clear_shows_the_ground() {
        assert_eq!(seen([1, 2, 3, 255]), [1, 2, 3]);
        assert_eq!(seen([1, 2, 3, 0]), [128; 3]);
        // (255 · 127 + 128 · 128) / 255 = 191.25…
        assert_eq!(seen([255, 0, 128, 127]), [191, 64, 128]);
    }

    #[test]
    fn rows_beyond_are_the_nearest() {
        let rgba = [[1, 1, 1, 255], [2, 2, 2, 255]].concat();
        let picture = Picture::new(1, 2, rgba).unwrap();
        let rows = seen_rows(&picture, -2..4);
        assert_eq!(rows, [1, 1, 1, 2, 2, 2].map(|byte| [byte; 3]));
        assert!(are_equal(&picture, &picture, -3, 9));
    }
}
