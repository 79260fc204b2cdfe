//! What a target holds, as the bytes that are read back.

use rayon::prelude::*;

use super::Target;
use super::colour::unit_byte;
use super::frame::{BLOCK_SIDE, Block};
use crate::math::Vec4;

/// One of the things that a target holds of each pixel, rows from the top: four bytes a pixel, but of
/// [`Float`](Self::Float) sixteen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetLayer {
    /// Bytes R, G, B, A: the mean of samples in linear light, then sRGB, alpha straight and linear, as
    /// [`Target::resolve`] has it.
    Colour,
    /// The same mean, but each channel as it is times 255, rounded to the nearest: of normals and
    /// offsets, which are no light.
    Linear,
    /// The same mean as four little-endian `f32`, unrounded: of what is more than 8 bits can hold.
    Float,
    /// The depth of the first sample, from 0 (near) to 1 (far): a little-endian `f32`.
    Depth,
}

impl Target {
    /// The bytes of a layer.
    #[must_use]
    pub fn layer_bytes(&self, layer: TargetLayer) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.layer_bytes_into(layer, &mut bytes);
        bytes
    }

    /// Makes `bytes` those of a layer, in memory that it has.
    pub(crate) fn layer_bytes_into(&self, layer: TargetLayer, bytes: &mut Vec<u8>) {
        match layer {
            TargetLayer::Colour => *bytes = self.resolve().rgba,
            TargetLayer::Linear => {
                self.colours_into(bytes, |colour| colour.to_array().map(unit_byte));
            }
            TargetLayer::Float => self.colours_into(bytes, |colour| {
                let mut bytes = [0; 16];
                let channels = bytes.as_chunks_mut().0.iter_mut();
                for (bytes, channel) in channels.zip(colour.to_array()) {
                    *bytes = channel.to_le_bytes();
                }
                bytes
            }),
            TargetLayer::Depth => {
                let clear = self.clear_depth().to_le_bytes();
                let samples = self.samples().count();
                self.pixels_into(bytes, clear, |block, pixel| {
                    block.depth[pixel * samples].to_le_bytes()
                });
            }
        }
    }

    fn colours_into<const BYTES: usize>(
        &self,
        bytes: &mut Vec<u8>,
        encode: impl Fn(Vec4) -> [u8; BYTES] + Sync,
    ) {
        let (clear, samples) = (encode(self.clear_colour()), self.samples());
        let has_colour = self.has_colour();
        self.pixels_into(bytes, clear, |block, pixel| {
            if has_colour {
                encode(block.resolve(pixel, samples))
            } else {
                clear
            }
        });
    }

    /// The bytes of each pixel, rows from the top: `clear` where nothing was drawn into a block, else those of
    /// the pixel of that place in the block.
    fn pixels_into<const BYTES: usize>(
        &self,
        bytes: &mut Vec<u8>,
        clear: [u8; BYTES],
        pixel_of: impl Fn(&Block, usize) -> [u8; BYTES] + Sync,
    ) {
        bytes.resize(BYTES * self.width() as usize * self.height() as usize, 0);
        let rows = bytes.par_chunks_mut(BYTES * self.width().max(1) as usize);
        rows.zip(0..self.height()).for_each(|(row, y)| {
            let (blocks, first) = self.blocks_of_row(y);
            let pieces = row.as_chunks_mut().0.chunks_mut(BLOCK_SIDE as usize);
            for (pixels, block) in pieces.zip(blocks) {
                if block.is_used() {
                    for (pixel, place) in pixels.iter_mut().zip(first..) {
                        *pixel = pixel_of(block, place);
                    }
                } else {
                    pixels.fill(clear);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::Samples;
    use super::*;

    #[test]
    fn a_cleared_target_reads_as_it_was_cleared() {
        let mut target = Target::new(65, 2, Samples::Four);
        target.clear(Vec4::new(1.0, 0.2, 0.5, 0.4), 0.25);
        let read = |layer| {
            let bytes = target.layer_bytes(layer);
            assert_eq!(bytes.len(), 4 * 65 * 2, "{layer:?}");
            assert!(
                bytes.chunks(4).all(|pixel| *pixel == bytes[..4]),
                "{layer:?}"
            );
            [bytes[0], bytes[1], bytes[2], bytes[3]]
        };
        assert_eq!(read(TargetLayer::Colour), [255, 124, 188, 102]);
        assert_eq!(read(TargetLayer::Linear), [255, 51, 128, 102]);
        assert_eq!(read(TargetLayer::Depth), 0.25_f32.to_le_bytes());
        let floats = target.layer_bytes(TargetLayer::Float);
        assert_eq!(floats.len(), 16 * 65 * 2);
        let channels = [1.0_f32, 0.2, 0.5, 0.4].map(f32::to_le_bytes);
        assert!(
            floats
                .chunks(16)
                .all(|pixel| pixel == channels.as_flattened())
        );
        assert!(
            Target::new(0, 3, Samples::One)
                .layer_bytes(TargetLayer::Depth)
                .is_empty()
        );
    }
}
