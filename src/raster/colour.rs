//! sRGB bytes to linear light and back, by tables that are the same on every machine.
//!
//! The transfer function is that of IEC 61966-2-1 ([SRGB](crate::references)), computed in `f64` by
//! [`det`](crate::math::det) and rounded to `f32` once.

use std::sync::LazyLock;

use crate::math::{Vec4, det, index_u32};

/// The linear value of each sRGB byte.
pub(super) fn decoding() -> &'static [f32; 256] {
    &TABLES.decoding
}

/// Quantizes linear light: the byte whose linear value is nearest as seen in sRGB.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encoder(&'static Tables);

impl Encoder {
    pub(super) fn new() -> Self {
        Self(&TABLES)
    }

    /// The sRGB byte of a linear value; below 0 and no number become 0, above 1 becomes 255.
    pub(super) fn srgb(self, linear: f32) -> u8 {
        if linear >= 1.0 {
            return 255;
        }
        let bits = linear.to_bits();
        if linear.is_nan() || linear < FIRST_BUCKET {
            return 0;
        }
        let bucket = (bits >> BUCKET_SHIFT) - (FIRST_BUCKET.to_bits() >> BUCKET_SHIFT);
        let mut code = self.0.buckets[bucket as usize];
        // A bucket spans 0.4 %, a code at least 0.9 %: this goes round at most once.
        while code < 255 && linear >= self.0.thresholds[usize::from(code) + 1] {
            code += 1;
        }
        code
    }
}

/// A value of [0, 1] as a byte, nearest, halves up; below 0 and no number become 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float becomes the nearest byte in range, by the language's saturating cast"
)]
pub(super) fn unit_byte(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// Below this every value is nearer to byte 0: the first threshold is 0.5 / 255 / 12.92 ≈ 2⁻¹²·⁷.
const FIRST_BUCKET: f32 = 1.0 / 8192.0;
/// Keeps the exponent and 8 bits of the fraction.
const BUCKET_SHIFT: u32 = 15;
const BUCKETS: usize = 13 << 8;

#[derive(Debug)]
struct Tables {
    decoding: [f32; 256],
    /// The least linear value of each byte.
    thresholds: [f32; 256],
    /// The byte of the least value of each bucket of floats.
    buckets: [u8; BUCKETS],
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let thresholds: [f32; 256] = std::array::from_fn(|code| match code {
        0 => f32::NEG_INFINITY,
        _ => decode((code as f64 - 0.5) / 255.0),
    });
    let first = FIRST_BUCKET.to_bits() >> BUCKET_SHIFT;
    let mut code = 0_u8;
    let buckets = std::array::from_fn(|bucket| {
        let least = f32::from_bits((first + index_u32(bucket)) << BUCKET_SHIFT);
        while code < 255 && least >= thresholds[usize::from(code) + 1] {
            code += 1;
        }
        code
    });
    Tables {
        decoding: std::array::from_fn(|code| decode(code as f64 / 255.0)),
        thresholds,
        buckets,
    }
});

#[expect(
    clippy::cast_possible_truncation,
    reason = "the one rounding to f32 that the module states"
)]
fn decode(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        det::pow_f64((encoded + 0.055) / 1.055, 2.4)
    };
    linear as f32
}

/// A colour of 8 bits a channel in sRGB as a linear one, opaque.
#[must_use]
pub fn decode_srgb(colour: [u8; 3]) -> Vec4 {
    let [r, g, b] = colour.map(|channel| decoding()[usize::from(channel)]);
    Vec4::new(r, g, b, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for byte in 0..=255_u8 {
            let linear = decoding()[usize::from(byte)];
            assert_eq!(Encoder::new().srgb(linear), byte);
            assert_eq!(unit_byte(f32::from(byte) / 255.0), byte);
        }
    }

    #[test]
    fn encoding_switches_exactly_at_the_thresholds() {
        for code in 1..=255_u8 {
            let threshold = TABLES.thresholds[usize::from(code)];
            assert_eq!(Encoder::new().srgb(threshold), code);
            assert_eq!(Encoder::new().srgb(threshold.next_down()), code - 1);
        }
    }

    #[test]
    fn values_out_of_range_saturate() {
        for (value, byte) in [
            (f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
            (-0.0, 0),
            (f32::INFINITY, 255),
            (1.5, 255),
        ] {
            assert_eq!(Encoder::new().srgb(value), byte, "{value}");
            assert_eq!(unit_byte(value), byte, "{value}");
        }
    }
}
