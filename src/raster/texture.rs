//! Textures: the bytes of a mip chain, and reading them.
//!
//! Texture coordinates run from (0, 0), the top-left corner of the first texel, to (1, 1), the
//! bottom-right corner of the last; texel `i` of `n` has its centre at `(i + 0.5) / n`.

use super::squares::Squares;
use super::wrap::{clamped, neighbours, repeated};
use super::{TextureFormat, Wrap, colour};
use crate::math::{Vec2, Vec4};

/// An image and its smaller versions.
///
/// Texels of a [`TextureFormat`], rows from the top. Level `k` has `max(1, side >> k)` texels a side.
/// The bytes are the truth: every read decodes them.
#[derive(Clone)]
pub struct MipMap {
    levels: Vec<Level>,
    format: TextureFormat,
    /// What the first three bytes of a texel of four mean, before they are divided.
    pub(super) decoding: &'static [f32; 256],
    /// What texels of four bytes are divided by, once they are blended.
    pub(super) divisor: Vec4,
}

impl MipMap {
    /// The largest width or height.
    pub const MAX_SIDE: u32 = 16384;

    /// A texture from the bytes of its levels, the largest first.
    ///
    /// Returns `None` when a side is 0 or above [`MipMap::MAX_SIDE`], when there is no level or one
    /// after 1 × 1, or when a level has other than its texels' bytes.
    #[must_use]
    pub fn new(
        format: TextureFormat,
        width: u32,
        height: u32,
        levels: Vec<Vec<u8>>,
    ) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let most = Self::full_chain(width, height) as usize;
        let fits = sides.contains(&width)
            && sides.contains(&height)
            && (1..=most).contains(&levels.len())
            && levels.iter().zip(0..).all(|(bytes, level)| {
                let (width, height) = size_of_level(width, height, level);
                bytes.len() == format.texel_bytes() as usize * width as usize * height as usize
            });
        fits.then(|| Self::of_levels(format, [width, height], levels, Squares::new))
    }

    /// A texture of so many levels, all of whose bytes are 0.
    ///
    /// Returns `None` as [`new`](Self::new).
    #[must_use]
    pub fn blank(format: TextureFormat, width: u32, height: u32, levels: u32) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let fits = sides.contains(&width)
            && sides.contains(&height)
            && (1..=Self::full_chain(width, height)).contains(&levels);
        let bytes = |level| {
            let (width, height) = size_of_level(width, height, level);
            vec![0; format.texel_bytes() as usize * width as usize * height as usize]
        };
        fits.then(|| {
            let levels = (0..levels).map(bytes).collect();
            Self::of_levels(format, [width, height], levels, |size, _| {
                Squares::blank(size)
            })
        })
    }

    /// Of levels whose sizes are right; `squares_of` makes what is kept of alphas.
    fn of_levels(
        format: TextureFormat,
        [width, height]: [u32; 2],
        levels: Vec<Vec<u8>>,
        squares_of: impl Fn([u32; 2], &[u8]) -> Squares,
    ) -> Self {
        let level = |(bytes, level): (Vec<u8>, u32)| {
            let (width, height) = size_of_level(width, height, level);
            let squares = match format {
                TextureFormat::Srgb8 | TextureFormat::Linear8 => {
                    Some(squares_of([width, height], &bytes))
                }
                TextureFormat::Float32 => None,
            };
            Level {
                width,
                height,
                bytes,
                squares,
            }
        };
        let (decoding, divisor) = match format {
            TextureFormat::Srgb8 => (colour::decoding(), Vec4::new(1.0, 1.0, 1.0, 255.0)),
            TextureFormat::Linear8 | TextureFormat::Float32 => (&PLAIN, Vec4::splat(255.0)),
        };
        Self {
            levels: levels.into_iter().zip(0..).map(level).collect(),
            format,
            decoding,
            divisor,
        }
    }

    /// What its texels are.
    #[must_use]
    #[inline]
    pub fn format(&self) -> TextureFormat {
        self.format
    }

    /// How many levels lead down to 1 × 1.
    #[must_use]
    pub fn full_chain(width: u32, height: u32) -> u32 {
        32 - width.max(height).leading_zeros()
    }

    /// How many levels there are, at least 1.
    #[must_use]
    #[inline]
    pub fn level_count(&self) -> u32 {
        crate::math::index_u32(self.levels.len())
    }

    /// Width and height of a level in texels; the last level's for levels after it.
    #[must_use]
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        let level = self.level(level);
        (level.width, level.height)
    }

    /// The bytes of a level; the last level's for levels after it.
    #[must_use]
    pub fn level_bytes(&self, level: u32) -> &[u8] {
        &self.level(level).bytes
    }

    /// Replaces bytes of a level from byte `offset` on, and says whether they fit; where they do
    /// not, or there is no such level, nothing changes.
    #[must_use]
    pub fn write_level(&mut self, level: u32, offset: usize, bytes: &[u8]) -> bool {
        let range = offset..offset.saturating_add(bytes.len());
        let Some(level) = self.levels.get_mut(level as usize) else {
            return false;
        };
        let Some(place) = level.bytes.get_mut(range.clone()) else {
            return false;
        };
        place.copy_from_slice(bytes);
        let row = 4 * level.width as usize;
        if let Some(squares) = &mut level.squares {
            squares.renew(&level.bytes, range.start / row..range.end.div_ceil(row));
        }
        true
    }

    /// One texel; of sRGB in linear light with straight alpha. Beyond the rim the nearest texel.
    #[must_use]
    pub fn texel(&self, level: u32, x: u32, y: u32) -> Vec4 {
        let level = self.level(level);
        let (x, y) = (x.min(level.width - 1), y.min(level.height - 1));
        self.read(level, y as usize * level.width as usize + x as usize)
    }

    /// The texel in which a point lies: one texel read.
    ///
    /// On the border of two it is the second. Coordinates that are no numbers or beyond ±2³¹ texels
    /// give some texel.
    #[must_use]
    pub fn nearest(&self, uv: Vec2, level: u32, wrap: Wrap) -> Vec4 {
        let level = self.level(level);
        let texel = |coordinate: f32, size: u32| match wrap {
            Wrap::Clamp => clamped(coordinate * size as f32, size).0,
            Wrap::Repeat => repeated(coordinate * size as f32, size).0,
        };
        let (x, y) = (texel(uv.x, level.width), texel(uv.y, level.height));
        self.read(level, y as usize * level.width as usize + x as usize)
    }

    /// The texels around a point, blended bilinearly, sRGB in linear light: four texels read. Of floats
    /// the [`nearest`](Self::nearest).
    ///
    /// First along x, then along y, each as `a + (b − a) · t`. Coordinates that are no numbers or
    /// beyond ±2³¹ texels give some texel.
    #[must_use]
    pub fn sample(&self, uv: Vec2, level: u32, wrap: Wrap) -> Vec4 {
        if self.format == TextureFormat::Float32 {
            return self.nearest(uv, level, wrap);
        }
        let level = self.level(level);
        let square = level.square(uv, wrap);
        let read = |at| self.raw(&level.bytes, 4 * at);
        let [a, b, c, d] = square.at;
        let (a, b, c, d) = (read(a), read(b), read(c), read(d));
        let above = a + (b - a) * square.right;
        let below = c + (d - c) * square.right;
        (above + (below - above) * square.down) / self.divisor
    }

    /// The alpha of [`sample`](Self::sample), to the same bits.
    #[must_use]
    #[inline(always)]
    pub fn alpha(&self, uv: Vec2, level: u32, wrap: Wrap) -> f32 {
        if self.format == TextureFormat::Float32 {
            return self.nearest(uv, level, wrap).w;
        }
        let level = self.level(level);
        let square = level.square(uv, wrap);
        let read = |at: usize| f32::from(level.bytes[4 * at + 3]);
        let [a, b, c, d] = square.at;
        let (a, b, c, d) = (read(a), read(b), read(c), read(d));
        let above = a + (b - a) * square.right;
        let below = c + (d - c) * square.right;
        (above + (below - above) * square.down) / 255.0
    }

    /// The level whose texels are nearest to a pixel in size, from how texture coordinates change
    /// to the next pixel on the right and below.
    ///
    /// With `ρ` the longer of the two changes in texels, this is `log₂ ρ` rounded to the nearest,
    /// read off the exponent of `ρ²`: `⌊(⌊log₂ ρ²⌋ + 1) / 2⌋`.
    #[must_use]
    #[inline(always)]
    pub fn level_for(&self, derivative_x: Vec2, derivative_y: Vec2) -> u32 {
        let Level { width, height, .. } = self.levels[0];
        let length_squared = |change: Vec2| {
            let (x, y) = (change.x * width as f32, change.y * height as f32);
            x * x + y * y
        };
        let (across, down) = (length_squared(derivative_x), length_squared(derivative_y));
        let longest = if across > down { across } else { down };
        // Below 2 texels squared the exponent is less than 1, and the first level is the nearest.
        let exponent = (longest.to_bits() >> 23).saturating_sub(127);
        exponent.div_ceil(2).min(self.level_count() - 1)
    }

    #[inline(always)]
    pub(super) fn level(&self, level: u32) -> &Level {
        &self.levels[(level as usize).min(self.levels.len() - 1)]
    }

    /// A texel by its number.
    #[inline]
    fn read(&self, level: &Level, texel: usize) -> Vec4 {
        match self.format {
            TextureFormat::Srgb8 | TextureFormat::Linear8 => {
                self.raw(&level.bytes, 4 * texel) / self.divisor
            }
            TextureFormat::Float32 => {
                let words = level.bytes[16 * texel..].as_chunks().0;
                let at = |word: usize| f32::from_le_bytes(words[word]);
                Vec4::new(at(0), at(1), at(2), at(3))
            }
        }
    }

    /// A texel of four bytes, yet to be divided.
    #[inline]
    fn raw(&self, bytes: &[u8], at: usize) -> Vec4 {
        let texel = &bytes[at..at + 4];
        Vec4::new(
            self.decoding[usize::from(texel[0])],
            self.decoding[usize::from(texel[1])],
            self.decoding[usize::from(texel[2])],
            f32::from(texel[3]),
        )
    }
}

impl std::fmt::Debug for MipMap {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let ((width, height), levels) = (self.level_size(0), self.levels.len());
        let format = self.format;
        write!(
            out,
            "MipMap({format:?}, {width} × {height}, {levels} levels)"
        )
    }
}

/// Bytes as they are.
static PLAIN: [f32; 256] = {
    let mut values = [0.0; 256];
    let mut byte = 0;
    while byte < values.len() {
        values[byte] = byte as f32;
        byte += 1;
    }
    values
};

/// One size of the image.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) bytes: Vec<u8>,
    /// The alphas among four bytes a texel once more.
    pub(super) squares: Option<Squares>,
}

impl Level {
    #[inline(always)]
    fn square(&self, uv: Vec2, wrap: Wrap) -> Square {
        let (left, right, across) = neighbours(uv.x, self.width, wrap);
        let (above, below, down) = neighbours(uv.y, self.height, wrap);
        let at = |x: u32, y: u32| y as usize * self.width as usize + x as usize;
        Square {
            at: [
                at(left, above),
                at(right, above),
                at(left, below),
                at(right, below),
            ],
            right: across,
            down,
        }
    }
}

/// Four texels and where between them a point lies.
struct Square {
    /// Numbers of texels: top-left, top-right, bottom-left, bottom-right.
    at: [usize; 4],
    right: f32,
    down: f32,
}

fn size_of_level(width: u32, height: u32, level: u32) -> (u32, u32) {
    let side = |side: u32| side.checked_shr(level).unwrap_or(0).max(1);
    (side(width), side(height))
}

#[cfg(test)]
pub(super) mod tests {
    use super::TextureFormat::{Float32, Linear8, Srgb8};
    use super::*;

    /// 4 × 2 texels with alpha 0, 10, 20 … 70, and two smaller levels.
    pub(in crate::raster) fn image() -> MipMap {
        let bytes = |count: u8| (0..count).flat_map(|i| [i, 2 * i, 255, 10 * i]).collect();
        MipMap::new(Srgb8, 4, 2, vec![bytes(8), bytes(2), bytes(1)]).expect("sizes fit")
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(MipMap::new(Srgb8, 4, 2, vec![]).is_none());
        assert!(MipMap::new(Srgb8, 0, 2, vec![vec![]]).is_none());
        assert!(MipMap::new(Srgb8, 4, 2, vec![vec![0; 31]]).is_none());
        assert!(MipMap::new(Srgb8, 4, 2, vec![vec![0; 32], vec![0; 16]]).is_none());
        assert!(MipMap::new(Srgb8, 1, 1, vec![vec![0; 4], vec![0; 4]]).is_none());
        assert_eq!(MipMap::full_chain(4, 2), 3);
        assert_eq!(MipMap::full_chain(1, 1), 1);
        assert_eq!(MipMap::full_chain(5, 3), 3);
    }

    #[test]
    fn centres_of_texels_give_the_texels() {
        let image = image();
        for y in 0..2 {
            for x in 0..4 {
                let uv = Vec2::new((x as f32 + 0.5) / 4.0, (y as f32 + 0.5) / 2.0);
                for wrap in [Wrap::Repeat, Wrap::Clamp] {
                    assert_eq!(image.sample(uv, 0, wrap), image.texel(0, x, y));
                }
            }
        }
    }

    #[test]
    fn between_texels_alpha_is_bilinear_and_wraps() {
        let image = image();
        let alpha = |u: f32, v: f32, wrap| image.alpha(Vec2::new(u, v), 0, wrap) * 255.0;
        assert_eq!(alpha(0.25, 0.25, Wrap::Clamp), 5.0);
        assert_eq!(alpha(0.25, 0.5, Wrap::Clamp), 25.0);
        assert_eq!(alpha(0.0, 0.25, Wrap::Clamp), 0.0);
        assert_eq!(alpha(0.0, 0.25, Wrap::Repeat), 15.0, "between 30 and 0");
        assert_eq!(alpha(-0.75, 0.25, Wrap::Repeat), 5.0);
        assert_eq!(alpha(7.0, 0.25, Wrap::Clamp), 30.0);
    }

    #[test]
    fn alpha_alone_has_the_bits_of_the_sample() {
        let image = image();
        for step in -40_i16..40 {
            let uv = Vec2::new(f32::from(step) * 0.093, f32::from(step) * 0.171);
            for level in 0..4 {
                let whole = image.sample(uv, level, Wrap::Repeat).w;
                let alone = image.alpha(uv, level, Wrap::Repeat);
                assert_eq!(whole.to_bits(), alone.to_bits());
            }
        }
    }

    #[test]
    fn absurd_coordinates_give_some_texel() {
        let image = image();
        for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                let colour = image.sample(Vec2::splat(value), 0, wrap);
                assert!(colour.is_finite(), "{value}: {colour}");
            }
        }
    }

    #[test]
    fn levels_switch_at_the_geometric_mean_of_their_sizes() {
        let image = MipMap::new(
            Srgb8,
            8,
            8,
            (0..4).map(|k| vec![0; 4 * (8 >> k) * (8 >> k)]).collect(),
        )
        .expect("sizes fit");
        let level = |texels: f32| image.level_for(Vec2::new(texels / 8.0, 0.0), Vec2::ZERO);
        assert_eq!(level(0.0), 0);
        assert_eq!(level(1.0), 0);
        assert_eq!(level(1.41), 0);
        assert_eq!(level(1.42), 1);
        assert_eq!(level(2.82), 1);
        assert_eq!(level(2.83), 2);
        assert_eq!(level(4.0), 2);
        assert_eq!(level(1e30), 3);
        assert_eq!(image.level_for(Vec2::ZERO, Vec2::new(0.0, 0.25)), 1);
    }

    #[test]
    fn bytes_are_replaced_where_they_fit() {
        let mut image = image();
        assert!(image.write_level(1, 4, &[9, 9, 9, 9]));
        assert_eq!(image.level_bytes(1), [0, 0, 255, 0, 9, 9, 9, 9]);
        assert!(!image.write_level(1, 5, &[1, 1, 1, 1]));
        assert!(!image.write_level(3, 0, &[1]));
        assert_eq!(image.level_bytes(1), [0, 0, 255, 0, 9, 9, 9, 9]);
        assert_eq!(
            image.alpha(Vec2::new(0.75, 0.5), 1, Wrap::Clamp),
            9.0 / 255.0
        );
        assert_eq!(image.level_size(0), (4, 2));
        assert_eq!(image.level_size(1), (2, 1));
    }

    #[test]
    fn linear_bytes_are_themselves_over_255() {
        let bytes = vec![0, 51, 255, 100, 51, 51, 0, 200];
        let image = MipMap::new(Linear8, 2, 1, vec![bytes]).expect("sizes fit");
        let (first, second) = (image.texel(0, 0, 0), image.texel(0, 1, 0));
        assert_eq!(first, Vec4::new(0.0, 0.2, 1.0, 100.0 / 255.0));
        assert_eq!(second, Vec4::new(0.2, 0.2, 0.0, 200.0 / 255.0));
        let middle = image.sample(Vec2::new(0.5, 0.5), 0, Wrap::Clamp);
        assert_eq!(middle, Vec4::new(0.1, 0.2, 0.5, 150.0 / 255.0));
        let alone = image.alpha(Vec2::new(0.5, 0.5), 0, Wrap::Clamp);
        assert_eq!(alone.to_bits(), middle.w.to_bits());
    }

    #[test]
    fn floats_are_read_as_they_are_and_never_blended() {
        let texels = [[1.5_f32, -2.0, 1e30, 0.25], [3.0, 4.0, f32::INFINITY, -0.5]];
        let bytes: Vec<u8> = texels
            .as_flattened()
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        assert!(MipMap::new(Float32, 2, 1, vec![bytes[..8].to_vec()]).is_none());
        let mut image = MipMap::new(Float32, 2, 1, vec![bytes]).expect("sizes fit");
        for (u, texel) in [
            (0.0, 0),
            (0.49, 0),
            (0.5, 1),
            (0.99, 1),
            (1.0, 1),
            (-3.0, 0),
        ] {
            let uv = Vec2::new(u, 0.7);
            let expected = Vec4::from_array(texels[texel]);
            assert_eq!(image.sample(uv, 0, Wrap::Clamp), expected, "{u}");
            assert_eq!(image.alpha(uv, 0, Wrap::Clamp), expected.w, "{u}");
        }
        let at = |u: f32| image.nearest(Vec2::new(u, 0.0), 0, Wrap::Repeat).x;
        assert_eq!([-0.25, 0.0, 1.0, 1.5].map(at), [3.0, 1.5, 1.5, 3.0]);
        assert!(image.write_level(0, 28, &1.0_f32.to_le_bytes()));
        assert_eq!(image.texel(0, 1, 0).w, 1.0);
        assert!(!image.write_level(0, 29, &[0; 4]));
    }

    #[test]
    fn the_nearest_texel_is_the_one_around_a_point() {
        let image = image();
        for (u, x) in [(0.0, 0), (0.24, 0), (0.25, 1), (0.6, 2), (0.99, 3)] {
            for (v, y) in [(0.1, 0), (0.5, 1)] {
                let found = image.nearest(Vec2::new(u, v), 0, Wrap::Repeat);
                assert_eq!(found, image.texel(0, x, y));
            }
        }
    }
}
