//! What a target holds, as the bytes that are read back.

use rayon::prelude::*;

use super::Target;
use super::colour::unit_byte;

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
        match layer {
            TargetLayer::Colour => self.resolve().rgba,
            TargetLayer::Linear => self.pixel_bytes(|x, y| {
                let colour = self.colour(x, y);
                colour.to_array().map(unit_byte)
            }),
            TargetLayer::Float => self.pixel_bytes(|x, y| {
                let mut bytes = [0; 16];
                let channels = bytes.as_chunks_mut().0.iter_mut();
                for (bytes, channel) in channels.zip(self.colour(x, y).to_array()) {
                    *bytes = channel.to_le_bytes();
                }
                bytes
            }),
            TargetLayer::Depth => self.pixel_bytes(|x, y| self.depth(x, y).to_le_bytes()),
        }
    }

    fn pixel_bytes<const BYTES: usize>(
        &self,
        pixel_of: impl Fn(u32, u32) -> [u8; BYTES] + Sync,
    ) -> Vec<u8> {
        let mut bytes = vec![0; BYTES * self.width() as usize * self.height() as usize];
        let rows = bytes.par_chunks_mut(BYTES * self.width().max(1) as usize);
        rows.zip(0..self.height()).for_each(|(row, y)| {
            for (pixel, x) in row.as_chunks_mut().0.iter_mut().zip(0..) {
                *pixel = pixel_of(x, y);
            }
        });
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::super::Samples;
    use super::*;
    use crate::math::Vec4;

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
