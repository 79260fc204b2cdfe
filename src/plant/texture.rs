//! Small images that leaves and bark carry.

use std::sync::Arc;

use crate::limits;
use crate::math::{Digester, Vec3, det, index_u32, index_usize};

/// An image: sRGB colour with straight linear alpha, 8 bits a channel, rows top-down. Copies share their bytes.
#[derive(Clone, PartialEq, Eq)]
pub struct Texture {
    width: u32,
    height: u32,
    rgba: Arc<Vec<u8>>,
}

impl Texture {
    /// An image of `width × height` texels, four bytes each.
    ///
    /// Returns `None` when a side is 0 or above [`Texture::MAX_SIDE`], or the bytes do not fit.
    #[must_use]
    pub fn new(width: u32, height: u32, rgba: Vec<u8>) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let fits = sides.contains(&width) && sides.contains(&height);
        (fits && rgba.len() == 4 * width as usize * height as usize).then_some(Self {
            width,
            height,
            rgba: Arc::new(rgba),
        })
    }

    /// The largest width or height.
    pub const MAX_SIDE: u32 = limits::TEXTURE_SIDE;

    /// Texels a row.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The bytes R, G, B, A of each texel, row by row from the top.
    #[must_use]
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// The mean linear colour, weighed by alpha; black where all is clear.
    #[must_use]
    pub fn mean_color(&self) -> Vec3 {
        let table = srgb_table();
        let (mut sum, mut weight) = (Vec3::ZERO, 0.0);
        for &[red, green, blue, alpha] in self.rgba.as_chunks::<4>().0 {
            let linear = [red, green, blue].map(|byte| table[usize::from(byte)]);
            sum += f32::from(alpha) * Vec3::from_array(linear);
            weight += f32::from(alpha);
        }
        if weight > 0.0 { sum / weight } else { sum }
    }

    /// The image and all smaller versions of it, level 0 first, down to 1 × 1; each side of a level
    /// is half the one before, rounded down.
    ///
    /// Colour is averaged in linear light and weighed by alpha, so that what is not there lends no
    /// colour. Plain averaging would thin foliage out: of a leaf that covers a third of its image,
    /// the averaged alpha falls below a cutoff of one half, and far trees vanish. So each level's
    /// alpha is scaled until as large a share of its texels reaches `cutoff` as of level 0, rounded
    /// to whole texels. Where that share is at least an eighth, one texel reaches it even if
    /// rounding says none: a leaf drawn too large is better than a crown with holes. A `cutoff` of
    /// 0 tests nothing, and alpha stays the average.
    #[must_use]
    pub fn mips(&self, cutoff: f32) -> Vec<Vec<u8>> {
        let decode = srgb_table();
        let mut level = Linear {
            width: self.width as usize,
            height: self.height as usize,
            texels: linear_texels(&self.rgba, &decode),
        };
        let threshold = threshold(cutoff);
        let passing = covered(&self.rgba, threshold);
        let mut levels = vec![self.rgba.to_vec()];
        while level.width > 1 || level.height > 1 {
            level = level.halved();
            let mut bytes = level.encoded(&decode);
            if threshold > 0 {
                keep_coverage(&mut bytes, threshold, passing, self.rgba.len() / 4);
            }
            levels.push(bytes);
        }
        levels
    }

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        digester.u32(self.width).u32(self.height).bytes(&self.rgba);
    }
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Texture({} × {})", self.width, self.height)
    }
}

/// The linear value of an sRGB byte (IEC 61966-2-1).
pub(super) fn linear_of_srgb(byte: u8) -> f32 {
    let encoded = f32::from(byte) / 255.0;
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        det::pow((encoded + 0.055) / 1.055, 2.4)
    }
}

fn srgb_table() -> [f32; 256] {
    let mut table = [0.0; 256];
    for (byte, linear) in (0..=u8::MAX).zip(&mut table) {
        *linear = linear_of_srgb(byte);
    }
    table
}

/// The byte whose linear value is nearest.
fn srgb_of_linear(linear: f32, decode: &[f32; 256]) -> u8 {
    // What is not there is 0, and of much nothing is there.
    if linear <= 0.0 {
        return 0;
    }
    let above = decode
        .partition_point(|&value| value < linear)
        .clamp(1, 255);
    let lower = linear - decode[above - 1] <= decode[above] - linear;
    byte(if lower { above - 1 } else { above })
}

fn byte(value: usize) -> u8 {
    u8::try_from(value.min(255)).expect("just limited to a byte's range")
}

/// A level in linear light: colour times alpha, and alpha, from 0 to 1.
struct Linear {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

fn linear_texels(rgba: &[u8], decode: &[f32; 256]) -> Vec<[f32; 4]> {
    // Texels without alpha keep a trace of weight: their colour counts where nothing else does.
    rgba.chunks_exact(4)
        .map(|texel| {
            let alpha = (f32::from(texel[3]) / 255.0).max(TRACE);
            let [red, green, blue] =
                [0, 1, 2].map(|c: usize| alpha * decode[usize::from(texel[c])]);
            [red, green, blue, alpha]
        })
        .collect()
}

/// The weight of a texel that is not there; 255 of them are still below half a step of alpha.
const TRACE: f32 = 1e-6;

impl Linear {
    /// Half the size; an odd side's texels are shared between the new ones by area.
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns: Vec<_> = (0..width).map(|x| shares(x, width, self.width)).collect();
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            let rows = shares(y, height, self.height);
            for columns in &columns {
                let mut sum = [0.0_f32; 4];
                for &(row, tall) in &rows {
                    for &(column, wide) in columns {
                        let texel = self.texels[row * self.width + column];
                        for (sum, channel) in sum.iter_mut().zip(texel) {
                            *sum += tall * wide * channel;
                        }
                    }
                }
                texels.push(sum);
            }
        }
        Self {
            width,
            height,
            texels,
        }
    }

    fn encoded(&self, decode: &[f32; 256]) -> Vec<u8> {
        let texel = |&[red, green, blue, alpha]: &[f32; 4]| {
            let [red, green, blue] =
                [red, green, blue].map(|c| srgb_of_linear(c / alpha.max(TRACE * TRACE), decode));
            [red, green, blue, rounded(alpha * 255.0)]
        };
        self.texels.iter().flat_map(texel).collect()
    }
}

/// Which texels of `from` a texel of `to` covers along one side, and by what share each.
fn shares(texel: usize, to: usize, from: usize) -> Vec<(usize, f32)> {
    // In units of 1 / (from · to) of the side: old texels are `to` long, new ones `from`.
    let (start, end) = (texel * from, (texel + 1) * from);
    (start / to..end.div_ceil(to))
        .map(|old| {
            let overlap = end.min((old + 1) * to) - start.max(old * to);
            (old, overlap as f32 / from as f32)
        })
        .collect()
}

fn rounded(value: f32) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a byte's range first"
    )]
    let byte = (value + 0.5).clamp(0.0, 255.0) as u8;
    byte
}

/// The least alpha byte that passes a cutoff; 0 when all pass.
fn threshold(cutoff: f32) -> u8 {
    rounded((cutoff.clamp(0.0, 1.0) * 255.0).ceil())
}

fn covered(rgba: &[u8], threshold: u8) -> usize {
    rgba.chunks_exact(4)
        .filter(|texel| texel[3] >= threshold)
        .count()
}

/// Scales alpha until as many of the texels pass `threshold` as `passing` of `all` are.
///
/// Texels of equal alpha, of which only some may pass, are told apart by a scattered order.
pub(crate) fn keep_coverage(bytes: &mut [u8], threshold: u8, passing: usize, all: usize) {
    let count = bytes.len() / 4;
    // In 64 bits, also where addresses have fewer.
    let [passing_64, count_64, all_64] = [passing, count, all].map(|number| number as u64);
    let mut wanted = index_usize((2 * passing_64 * count_64 + all_64) / (2 * all_64));
    if wanted == 0 && 8 * passing >= all {
        wanted = 1;
    }
    if covered(bytes, threshold) == wanted {
        return;
    }
    // The last that passes gets just the threshold, and all others the same factor.
    let mut counts = [0; 256];
    bytes
        .iter()
        .skip(3)
        .step_by(4)
        .for_each(|alpha| counts[usize::from(*alpha)] += 1);
    let (last, before) = last_of(&counts, wanted.max(1));
    // Texels of its alpha pass in a scattered order until there are enough.
    let mut alike: Vec<usize> = (0..count)
        .filter(|texel| bytes[4 * texel + 3] == last)
        .collect();
    alike.sort_unstable_by_key(|&texel| index_u32(texel).wrapping_mul(0x9e37_79b1));
    alike.truncate(wanted.saturating_sub(before));
    let from = u32::from(last.max(1));
    for alpha in bytes.iter_mut().skip(3).step_by(4) {
        let passes = *alpha > last && wanted > 0;
        let scaled = (u32::from(*alpha) * u32::from(threshold) / from).min(255);
        let scaled = u8::try_from(scaled).expect("just limited to a byte's range");
        *alpha = if passes {
            scaled.max(threshold)
        } else {
            scaled.min(threshold - 1)
        };
    }
    for texel in alike {
        let scaled = u32::from(last) * u32::from(threshold) / from;
        let scaled = u8::try_from(scaled.min(255)).expect("just limited to a byte's range");
        bytes[4 * texel + 3] = scaled.max(threshold);
    }
}

/// Of texels from the greatest alpha down, of which there are so many each, the alpha of the texel of a
/// rank from 1, and how many have more.
fn last_of(counts: &[usize; 256], rank: usize) -> (u8, usize) {
    let mut before = 0;
    for (alpha, count) in (0..=u8::MAX).zip(counts).rev() {
        if before + count >= rank {
            return (alpha, before);
        }
        before += count;
    }
    (0, before)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An image of one grey whose texel at (x, y) has the alpha that `alpha` says.
    fn grey(side: u32, alpha: impl Fn(u32, u32) -> u8) -> Texture {
        let texels = (0..side * side).flat_map(|at| [90, 90, 90, alpha(at % side, at / side)]);
        Texture::new(side, side, texels.collect()).expect("the bytes fit")
    }

    #[test]
    fn levels_halve_down_to_one_texel() {
        let texture = Texture::new(5, 2, vec![200; 40]).unwrap();
        let sizes: Vec<usize> = texture.mips(0.0).iter().map(Vec::len).collect();
        assert_eq!(sizes, [40, 8, 4]);
        // A constant stays what it is: in sRGB there and back, and over odd sides.
        assert!(texture.mips(0.0).iter().flatten().all(|&byte| byte == 200));
    }

    #[test]
    fn colour_averages_in_linear_light_and_ignores_what_is_not_there() {
        // Black and white: half the light is 188 in sRGB, not 128.
        let ends = Texture::new(2, 1, vec![0, 0, 0, 255, 255, 255, 255, 255]).unwrap();
        assert_eq!(ends.mips(0.0)[1], [188, 188, 188, 255]);
        let half = Texture::new(2, 1, vec![10, 20, 30, 255, 255, 255, 255, 0]).unwrap();
        assert_eq!(half.mips(0.0)[1], [10, 20, 30, 128]);
        let none = Texture::new(2, 1, vec![10, 20, 30, 0, 10, 20, 30, 0]).unwrap();
        assert_eq!(none.mips(0.0)[1], [10, 20, 30, 0]);
    }

    #[test]
    fn a_third_stays_a_third() {
        // Scattered texels, which plain averaging would lose at the second level.
        let texture = grey(64, |x, y| {
            if (x * 7 + y * 11).is_multiple_of(3) {
                255
            } else {
                0
            }
        });
        let levels = texture.mips(0.5);
        for (level, bytes) in levels[..6].iter().enumerate() {
            let texels = bytes.len() / 4;
            let share = covered(bytes, 128) as f32 / texels as f32;
            let step = 0.5 / texels as f32;
            assert!(
                (share - 1.0 / 3.0).abs() < 0.12 + step,
                "level {level}: {share}"
            );
        }
    }

    #[test]
    fn the_last_texel_stays_when_an_eighth_is_covered() {
        let stripe = |width| grey(16, move |x, _| if x < width { 255 } else { 0 });
        let last = |texture: &Texture| texture.mips(0.5).pop().expect("there is a level 0")[3];
        assert!(last(&stripe(2)) >= 128 && last(&stripe(16)) == 255);
        assert!(last(&stripe(1)) < 128);
    }
}
