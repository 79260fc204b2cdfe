//! Hashed alpha ([WM17](crate::references)): a fragment is there or not, as a hash of its place says.

use super::lines::line_colour;
use crate::gpu::{Fragment, Pixel};
use crate::math::rng::Stream;
use crate::math::{Vec3, Vec4, det};
use crate::models::shadow::Lighting;

/// Opaque where the opacity is no less than a number that is drawn for the place in the patch.
#[derive(Debug)]
pub(super) struct HashedFragment<'a> {
    pub(super) lighting: Lighting<'a>,
}

impl Fragment for HashedFragment<'_> {
    /// Colour, opacity, light, place in the patch.
    const VARYINGS: usize = 8;
    /// Metres of the patch a pixel.
    const FLATS: usize = 1;
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let [_, _, _, alpha, _, x, y, z] = *pixel.varyings;
        let metres = pixel.flats.first().copied().unwrap_or(1.0);
        alpha >= threshold(Vec3::new(x, y, z), metres)
    }

    fn texels_shaded(&self) -> u64 {
        self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        line_colour(&self.lighting, pixel).truncate().extend(1.0)
    }
}

/// A number of (0, 1], evenly spread over places, that stays with the place as the viewer moves: drawn for
/// cells of about a pixel, between the two sizes that are powers of two
/// ([WM17](crate::references), listing 3).
///
/// Integers are hashed where the paper takes the sine of large numbers; the size of a pixel is that in the
/// middle of the line where the paper takes derivatives, which along a line a pixel wide say the same.
fn threshold(place: Vec3, metres_a_pixel: f32) -> f32 {
    let scale = (1.0 / metres_a_pixel).clamp(1e-6, 1e6);
    // The power of two that is no greater: the number without its fraction.
    let coarse = f32::from_bits(scale.to_bits() & 0xFF80_0000);
    let share = det::log2(scale / coarse).clamp(0.0, 1.0);
    let [one, other] = [coarse, 2.0 * coarse].map(|scale| drawn(place * scale));
    let mixed = (1.0 - share) * one + share * other;
    // What is mixed of two even numbers is not even: by its distribution it becomes so.
    let least = share.min(1.0 - share);
    let even = if mixed < least {
        mixed * mixed / (2.0 * least * (1.0 - least))
    } else if mixed < 1.0 - least {
        (mixed - 0.5 * least) / (1.0 - least)
    } else {
        let rest = 1.0 - mixed;
        1.0 - rest * rest / (2.0 * least * (1.0 - least)).max(f32::MIN_POSITIVE)
    };
    even.clamp(1e-6, 1.0)
}

/// A number of [0, 1) for the cell of a place.
fn drawn(place: Vec3) -> f32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "saturates, far beyond any patch"
    )]
    let cell = place
        .floor()
        .to_array()
        .map(|at| u64::from((at as i32).cast_unsigned()));
    let [x, y, z] = cell;
    Stream::new(x, y).unit(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of many places as many are below each share as it says, whatever the size of a pixel.
    #[test]
    fn thresholds_are_evenly_spread() {
        for metres in [0.01, 0.013, 0.02, 0.029] {
            let count = 20_000_u16;
            let mut below = [0_u32; 10];
            for number in 0..count {
                let at = f32::from(number);
                let found = threshold(Vec3::new(0.37 * at, -0.11 * at, 0.05 * at), metres);
                assert!(found > 0.0 && found <= 1.0, "{found}");
                for (tenth, below) in (1_u8..).zip(&mut below) {
                    *below += u32::from(found <= 0.1 * f32::from(tenth));
                }
            }
            for (tenth, below) in (1_u8..).zip(below) {
                let share = f64::from(below) / f64::from(count);
                let wanted = 0.1 * f64::from(tenth);
                assert!(
                    (share - wanted).abs() < 0.015,
                    "{metres} m: {share} of {wanted}"
                );
            }
        }
    }

    #[test]
    fn a_place_keeps_its_threshold_where_pixels_hardly_change() {
        let place = Vec3::new(1.23, 4.56, -7.89);
        let found = [0.0200, 0.0201].map(|metres| threshold(place, metres));
        assert!((found[0] - found[1]).abs() < 0.05, "{found:?}");
        assert_eq!(threshold(place, 0.02).to_bits(), found[0].to_bits());
    }
}
