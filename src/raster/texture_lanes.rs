//! Textures read at eight pixels at a time: the bits of each read alone.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdInt, SimdMask, f32x8, i32x8, u32x8};

use super::texture::{Level, MipMap};
use super::wrap::clamped_lanes;
use super::{TextureFormat, Wrap};
use crate::math::Vec2;

impl MipMap {
    /// [`level_for`](Self::level_for) of eight pixels.
    #[must_use]
    #[inline(always)]
    pub fn level_for_lanes<S: Simd>(
        &self,
        simd: S,
        derivative_x: [f32x8<S>; 2],
        derivative_y: [f32x8<S>; 2],
    ) -> u32x8<S> {
        let Level { width, height, .. } = *self.level(0);
        let width = f32x8::splat(simd, width as f32);
        let height = f32x8::splat(simd, height as f32);
        let (x, y) = (derivative_x[0] * width, derivative_x[1] * height);
        let across = x * x + y * y;
        let (x, y) = (derivative_y[0] * width, derivative_y[1] * height);
        let down = x * x + y * y;
        let longest = across.simd_gt(down).select(across, down);
        let bits: u32x8<S> = longest.bitcast();
        let least = u32x8::splat(simd, 127);
        let exponent = (bits >> 23).max(least) - least;
        let level = (exponent + u32x8::splat(simd, 1)) >> 1;
        level.min(u32x8::splat(simd, self.level_count() - 1))
    }

    /// The level of all pixels with a bit in `wanted`, if it is one.
    #[must_use]
    #[inline(always)]
    pub fn one_level<S: Simd>(simd: S, levels: u32x8<S>, wanted: u64) -> Option<u32> {
        let first = levels[wanted.trailing_zeros() as usize % 8];
        let same = levels.simd_eq(u32x8::splat(simd, first)).to_bitmask();
        (same & wanted == wanted).then_some(first)
    }

    /// [`alpha`](Self::alpha) of eight pixels; of those without a bit in `wanted` it does not matter.
    #[must_use]
    #[inline(always)]
    pub fn alpha_lanes<S: Simd>(
        &self,
        simd: S,
        [u, v]: [f32x8<S>; 2],
        levels: u32x8<S>,
        wrap: Wrap,
        wanted: u64,
    ) -> f32x8<S> {
        let one = Self::one_level(simd, levels, wanted).filter(|_| wrap == Wrap::Clamp);
        let level = one.map(|one| self.level(one));
        let squares = level.and_then(|level| Some((level, level.squares.as_ref()?)));
        let Some((level, squares)) = squares else {
            let mut alphas = [0.0; 8];
            let mut rest = wanted;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % 8;
                rest &= rest - 1;
                alphas[lane] = self.alpha(Vec2::new(u[lane], v[lane]), levels[lane], wrap);
            }
            return f32x8::from_slice(simd, &alphas);
        };
        let (column, across) = clamped_lanes(simd, u, level.width);
        let (row, down) = clamped_lanes(simd, v, level.height);
        let squares = squares.at(simd, column, row);
        let byte = i32x8::splat(simd, 255);
        let a: f32x8<S> = (squares & byte).to_float();
        let b: f32x8<S> = ((squares >> 8) & byte).to_float();
        let c: f32x8<S> = ((squares >> 16) & byte).to_float();
        let d: f32x8<S> = ((squares >> 24) & byte).to_float();
        let above = a + (b - a) * across;
        let below = c + (d - c) * across;
        (above + (below - above) * down) / f32x8::splat(simd, 255.0)
    }

    /// Whether [`alpha`](Self::alpha) times a factor that is not negative is at least so much, of eight
    /// pixels, a bit each; of those without a bit in `wanted` it does not matter.
    ///
    /// No blend of alphas lies beyond them, since rounding keeps order: so a level whose least alpha is
    /// enough need not be read, nor one whose greatest is too little.
    #[must_use]
    #[inline(always)]
    pub fn alpha_reaches_lanes<S: Simd>(
        &self,
        simd: S,
        at: [f32x8<S>; 2],
        levels: u32x8<S>,
        wrap: Wrap,
        wanted: u64,
        [factor, least]: [f32; 2],
    ) -> u64 {
        if let Some(one) = Self::one_level(simd, levels, wanted)
            && let Some(squares) = &self.level(one).squares
        {
            let [low, high] = squares.range();
            let reaches = |alpha: u8| f32::from(alpha) / 255.0 * factor >= least;
            if reaches(low) == reaches(high) {
                return if reaches(low) { wanted } else { 0 };
            }
        }
        let alpha = self.alpha_lanes(simd, at, levels, wrap, wanted);
        let reaches = alpha * f32x8::splat(simd, factor);
        reaches.simd_ge(f32x8::splat(simd, least)).to_bitmask()
    }

    /// [`sample`](Self::sample) of eight pixels, channel by channel; of those without a bit in `wanted` it
    /// does not matter.
    #[must_use]
    #[inline(always)]
    pub fn sample_lanes<S: Simd>(
        &self,
        simd: S,
        [u, v]: [f32x8<S>; 2],
        levels: u32x8<S>,
        wrap: Wrap,
        wanted: u64,
    ) -> [f32x8<S>; 4] {
        let bytes = self.format() != TextureFormat::Float32;
        let one = Self::one_level(simd, levels, wanted).filter(|_| bytes && wrap == Wrap::Clamp);
        let Some(one) = one else {
            let mut colours = [[0.0; 8]; 4];
            let mut rest = wanted;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize % 8;
                rest &= rest - 1;
                let colour = self.sample(Vec2::new(u[lane], v[lane]), levels[lane], wrap);
                for (channel, value) in colours.iter_mut().zip(colour.to_array()) {
                    channel[lane] = value;
                }
            }
            return colours.map(|channel| f32x8::from_slice(simd, &channel));
        };
        let level = self.level(one);
        let (column, across) = clamped_lanes(simd, u, level.width);
        let (row, down) = clamped_lanes(simd, v, level.height);
        let (zero, one) = (i32x8::splat(simd, 0), i32x8::splat(simd, 1));
        let width = i32x8::splat(simd, level.width.cast_signed());
        let height = i32x8::splat(simd, level.height.cast_signed());
        let left = (column - one).max(zero);
        let right = column.min(width - one);
        let above = (row - one).max(zero) * width;
        let below = row.min(height - one) * width;
        let a = self.raw_lanes(simd, level, above + left);
        let b = self.raw_lanes(simd, level, above + right);
        let c = self.raw_lanes(simd, level, below + left);
        let d = self.raw_lanes(simd, level, below + right);
        let divisor = self.divisor.to_array();
        let mut colours = [f32x8::splat(simd, 0.0); 4];
        for (channel, colour) in colours.iter_mut().enumerate() {
            let above = a[channel] + (b[channel] - a[channel]) * across;
            let below = c[channel] + (d[channel] - c[channel]) * across;
            let blended = above + (below - above) * down;
            *colour = blended / f32x8::splat(simd, divisor[channel]);
        }
        colours
    }

    /// Eight texels of four bytes, told by their numbers, yet to be divided; some texel for a number that
    /// none has.
    #[inline(always)]
    fn raw_lanes<S: Simd>(&self, simd: S, level: &Level, texels: i32x8<S>) -> [f32x8<S>; 4] {
        let mut numbers = [0; 8];
        texels.store_slice(&mut numbers);
        let texels = level.bytes.as_chunks::<4>().0;
        let mut colours = [[0.0; 8]; 4];
        for (lane, number) in numbers.into_iter().enumerate() {
            let [r, g, b, a] = texels
                .get(number.unsigned_abs() as usize)
                .copied()
                .unwrap_or([0; 4]);
            colours[0][lane] = self.decoding[usize::from(r)];
            colours[1][lane] = self.decoding[usize::from(g)];
            colours[2][lane] = self.decoding[usize::from(b)];
            colours[3][lane] = f32::from(a);
        }
        [
            f32x8::from_slice(simd, &colours[0]),
            f32x8::from_slice(simd, &colours[1]),
            f32x8::from_slice(simd, &colours[2]),
            f32x8::from_slice(simd, &colours[3]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Fallback, Level as Instructions, dispatch};

    use super::TextureFormat::Float32;
    use super::*;
    use crate::raster::texture::tests::image;

    #[test]
    fn eight_pixels_have_the_bits_of_each_alone() {
        let mut image = image();
        assert!(image.write_level(0, 19, &[77, 1, 2, 3, 200]));
        assert!(image.write_level(1, 0, &[9; 8]));
        let at: [f32; 8] = [-3.0, -0.001, 0.1, 0.37, 0.5, 0.93, 1.001, f32::NAN];
        for (v, level) in at.into_iter().flat_map(|v| [(v, 0), (v, 1), (v, 2)]) {
            for target in [Instructions::new(), Instructions::fallback()] {
                let mut found = [[0.0; 8]; 5];
                let reached = dispatch!(target, simd => {
                    let places = [f32x8::from_slice(simd, &at), f32x8::splat(simd, v)];
                    let levels = u32x8::splat(simd, level);
                    let alphas = image.alpha_lanes(simd, places, levels, Wrap::Clamp, 255);
                    alphas.store_slice(&mut found[4]);
                    let colours = image.sample_lanes(simd, places, levels, Wrap::Clamp, 255);
                    for (found, channel) in found.iter_mut().zip(colours) {
                        channel.store_slice(found);
                    }
                    [0.0, 0.01, 0.08, 0.2, 1.1].map(|least| {
                        let reach = [1.25, least];
                        image.alpha_reaches_lanes(simd, places, levels, Wrap::Clamp, 255, reach)
                    })
                });
                for (lane, u) in at.into_iter().enumerate() {
                    let uv = Vec2::new(u, v);
                    let alpha = image.alpha(uv, level, Wrap::Clamp);
                    assert_eq!(found[4][lane].to_bits(), alpha.to_bits());
                    let colour = image.sample(uv, level, Wrap::Clamp).to_array();
                    let lanes = [0, 1, 2, 3].map(|channel: usize| found[channel][lane]);
                    assert_eq!(lanes.map(f32::to_bits), colour.map(f32::to_bits));
                    for (reached, least) in reached.into_iter().zip([0.0, 0.01, 0.08, 0.2, 1.1]) {
                        let alone = alpha * 1.25 >= least;
                        assert_eq!(reached >> lane & 1 == 1, alone, "{uv} {level} {least}");
                    }
                }
            }
        }
    }

    #[test]
    fn eight_floats_are_read_as_they_are() {
        let texels = [[1.5_f32, -2.0, 1e30, 0.25], [3.0, 4.0, 5.0, 1.0]];
        let bytes = texels.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let image = MipMap::new(Float32, 2, 1, vec![bytes.collect()]).expect("sizes fit");
        let simd = Fallback::new();
        let lanes = [0.25, 0.75, 0.25, 0.75, -1.0, 9.0, 0.0, 0.5];
        let lanes = f32x8::from_slice(simd, &lanes);
        let levels = u32x8::splat(simd, 0);
        let alphas = image.alpha_lanes(simd, [lanes; 2], levels, Wrap::Clamp, 0xff);
        let alphas: Vec<f32> = (0..8).map(|lane| alphas[lane]).collect();
        assert_eq!(alphas, [0.25, 1.0, 0.25, 1.0, 0.25, 1.0, 0.25, 1.0]);
    }
}
