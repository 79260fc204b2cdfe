//! Textures as the peers have them: 8 bits a channel that mean themselves, without sRGB.
//!
//! A device of spinney's decodes the bytes of a texture from sRGB. So each byte is written as the one
//! whose decoded value is nearest to `byte / 255`; the greatest error is half a step of sRGB, about one
//! step of the 255 among bright colours.

use spinney::raster::decode_srgb;

/// A texture with its smaller versions, the largest first, as a device takes them.
#[derive(Debug)]
pub(crate) struct Texels {
    /// Texels a row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// The bytes of each level.
    pub(crate) levels: Vec<Vec<u8>>,
    /// Columns and rows of tiles, a layer each: powers of 2.
    pub(crate) tiles: [u32; 2],
}

impl Texels {
    /// Layers of `width × height` texels, side by side in as square a grid as powers of 2 allow. Each
    /// has levels of its own: the means of four texels, as raw bytes, down to one texel a layer.
    ///
    /// # Panics
    ///
    /// Unless sides are powers of 2 where there are several layers.
    pub(crate) fn of([layers, height, width]: [usize; 3], rgba: &[u8]) -> Self {
        let columns = 1_usize << (layers.next_power_of_two().ilog2().div_ceil(2));
        let columns = columns.min(layers);
        let rows = layers.div_ceil(columns).next_power_of_two();
        let is_even = width.is_power_of_two() && height.is_power_of_two();
        assert!(layers == 1 || is_even, "sides of layers are powers of 2");
        let table = Encoding::new();
        let mut levels = Vec::new();
        let mut images: Vec<Vec<u8>> = rgba
            .chunks_exact(4 * width * height)
            .map(<[u8]>::to_vec)
            .collect();
        let mut sides = [width, height];
        loop {
            levels.push(table.encoded(&grid(&images, sides, [columns, rows])));
            if sides == [1, 1] {
                break;
            }
            images = images.iter().map(|image| halved(image, sides)).collect();
            sides = sides.map(|side| (side / 2).max(1));
        }
        let side = |texels: usize| u32::try_from(texels).expect("sides of textures are small");
        Self {
            width: side(columns * width),
            height: side(rows * height),
            levels,
            tiles: [side(columns), side(rows)],
        }
    }
}

/// Images of one size, side by side.
fn grid(images: &[Vec<u8>], [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> Vec<u8> {
    let mut all = vec![0; 4 * width * height * columns * rows];
    for (number, image) in images.iter().enumerate() {
        let (column, row) = (number % columns, number / columns);
        for (y, texels) in image.chunks_exact(4 * width).enumerate() {
            let first = 4 * width * (columns * (row * height + y) + column);
            all[first..first + texels.len()].copy_from_slice(texels);
        }
    }
    all
}

/// The mean of every four texels, rounded.
fn halved(image: &[u8], [width, height]: [usize; 2]) -> Vec<u8> {
    let [columns, rows] = [width, height].map(|side| (side / 2).max(1));
    let texel = |x: usize, y: usize, channel: usize| {
        let (x, y) = (x.min(width - 1), y.min(height - 1));
        u32::from(image[4 * (y * width + x) + channel])
    };
    let mut half = Vec::with_capacity(4 * columns * rows);
    for y in 0..rows {
        for x in 0..columns {
            for channel in 0..4 {
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let sum: u32 = four
                    .iter()
                    .map(|(right, down)| texel(2 * x + right, 2 * y + down, channel))
                    .sum();
                half.push(u8::try_from((sum + 2) / 4).expect("a mean of bytes"));
            }
        }
    }
    half
}

/// The sRGB byte for each byte that means itself.
struct Encoding([u8; 256]);

impl Encoding {
    fn new() -> Self {
        let linear = |byte: u8| decode_srgb([byte; 3]).x;
        let mut table = [0; 256];
        for (byte, place) in (0..=u8::MAX).zip(&mut table) {
            let wanted = f32::from(byte) / 255.0;
            let away = |byte: &u8| (linear(*byte) - wanted).abs();
            let nearest = (0..=u8::MAX).min_by(|a, b| away(a).total_cmp(&away(b)));
            *place = nearest.expect("there are bytes");
        }
        Self(table)
    }

    /// Colours encoded, alpha as it is.
    fn encoded(&self, rgba: &[u8]) -> Vec<u8> {
        let texels = rgba.as_chunks::<4>().0.iter();
        let encoded = texels.flat_map(|&[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|channel| self.0[usize::from(channel)]);
            [r, g, b, a]
        });
        encoded.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_keep_their_levels_apart() {
        // Two layers of 2 × 2 texels, one white, one black and transparent.
        let mut rgba = vec![255; 16];
        rgba.extend([0; 16]);
        let texels = Texels::of([2, 2, 2], &rgba);
        assert_eq!((texels.width, texels.height, texels.tiles), (4, 2, [2, 1]));
        assert_eq!(texels.levels.len(), 2);
        assert_eq!(
            texels.levels[0][..12],
            [255, 255, 255, 255, 255, 255, 255, 255, 0, 0, 0, 0]
        );
        assert_eq!(texels.levels[1], [255, 255, 255, 255, 0, 0, 0, 0]);
    }
}
