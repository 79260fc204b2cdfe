//! From the pixels of a sheet to texels.

use std::sync::LazyLock;

use super::bake_program::{unpacked_albedo, unpacked_normal};
use crate::math::{Vec4, det};

/// A view as texels, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BakedView {
    /// Texels a row, and rows.
    pub(super) size: [u32; 2],
    /// The offsets towards the viewer, in metres from the frame's origin, between which all lies that
    /// is seen; the farthest first.
    pub(super) depths: [f32; 2],
    /// R, G, B, A a texel: the albedo in sRGB, straight; alpha is the share of the texel's pixels that
    /// show a leaf. Where that is none, all are 0.
    pub(super) colour: Vec<u8>,
    /// R, G, B, A a texel: the mean normal on the side that is seen, in the plant's space, each
    /// coordinate as `127.5 n + 127.5`; and the mean depth, 0 at the farthest offset, 255 at the
    /// nearest.
    ///
    /// A mean of normals is shorter than 1, and stays so: where all that it stands for is lit, the light
    /// on it is the mean of their light.
    pub(super) normals: Vec<u8>,
}

/// Makes a view of pixels, `factor` along each side of a texel.
pub(super) fn resolve(
    size: [u32; 2],
    factor: u32,
    depths: [f32; 2],
    pixel: impl Fn(u32, u32) -> Vec4,
) -> BakedView {
    let bytes = 4 * size[0] as usize * size[1] as usize;
    let (mut colour, mut normals) = (Vec::with_capacity(bytes), Vec::with_capacity(bytes));
    for row in 0..size[1] {
        for column in 0..size[0] {
            let mut texel = Mean::default();
            for y in factor * row..factor * (row + 1) {
                for x in factor * column..factor * (column + 1) {
                    texel.add(pixel(x, y));
                }
            }
            let [of_colour, of_normal] = texel.bytes(factor * factor);
            colour.extend(of_colour);
            normals.extend(of_normal);
        }
    }
    BakedView {
        size,
        depths,
        colour,
        normals,
    }
}

/// Sums over the pixels that show something.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    count: u32,
    albedo: [f32; 3],
    normal: [u32; 3],
    depth: f32,
}

impl Mean {
    fn add(&mut self, pixel: Vec4) {
        if pixel.w == 0.0 {
            return;
        }
        self.count += 1;
        for (sum, channel) in self.albedo.iter_mut().zip(unpacked_albedo(pixel)) {
            *sum += channel;
        }
        for (sum, coordinate) in self.normal.iter_mut().zip(unpacked_normal(pixel.w)) {
            *sum += coordinate;
        }
        self.depth += pixel.z;
    }

    /// Colour, then normal.
    fn bytes(&self, pixels: u32) -> [[u8; 4]; 2] {
        if self.count == 0 {
            return [[0; 4]; 2];
        }
        let count = self.count as f32;
        let [red, green, blue] = self.albedo.map(|sum| srgb(sum / count));
        let [x, y, z] = self.normal.map(|sum| byte(sum as f32 / count));
        let alpha = byte(255.0 * count / pixels as f32);
        let nearness = byte(255.0 - 255.0 * (self.depth / count));
        [[red, green, blue, alpha], [x, y, z, nearness]]
    }
}

/// The nearest byte.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
pub(super) fn byte(value: f32) -> u8 {
    (value + 0.5) as u8
}

/// The sRGB byte of a linear value within [0, 1], by the nearest of 4096 square roots.
fn srgb(linear: f32) -> u8 {
    let root = linear.clamp(0.0, 1.0).sqrt() * 4095.0 + 0.5;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within [0.5, 4095.5]"
    )]
    let root = root as usize;
    SRGB_OF_ROOT[root.min(4095)]
}

/// The sRGB byte of the square of each number of 4095ths ([SRGB](crate::references)).
static SRGB_OF_ROOT: LazyLock<[u8; 4096]> = LazyLock::new(|| {
    std::array::from_fn(|root| {
        let root = root as f32 / 4095.0;
        let linear = root * root;
        byte(
            255.0
                * if linear <= 0.003_130_8 {
                    12.92 * linear
                } else {
                    1.055 * det::pow(linear, 1.0 / 2.4) - 0.055
                },
        )
    })
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_is_the_mean_of_what_is_there() {
        // Two pixels of four: white facing +X at depth 0, black facing +Y at depth ½.
        let white = Vec4::new(16_777_215.0, 4095.0, 0.0, 1.0 + 16_744_448.0 + 128.0);
        let black = Vec4::new(
            0.0,
            0.0,
            0.5,
            1.0 + f32::from(0x80_u8) * 65_536.0 + 65_408.0,
        );
        let pixel = |x, y| match (x, y) {
            (0, 0) => white,
            (1, 1) => black,
            _ => Vec4::ZERO,
        };
        let view = resolve([1, 1], 2, [0.0, 1.0], pixel);
        assert_eq!(view.colour, [188, 188, 188, 128]);
        assert_eq!(view.normals, [192, 192, 128, 191]);
        let none = resolve([1, 1], 2, [0.0, 1.0], |_, _| Vec4::ZERO);
        assert_eq!((none.colour, none.normals), (vec![0; 4], vec![0; 4]));
    }

    #[test]
    fn srgb_ends_and_middle() {
        assert_eq!([0.0, 0.5, 1.0, 2.0].map(srgb), [0, 188, 255, 255]);
    }
}
