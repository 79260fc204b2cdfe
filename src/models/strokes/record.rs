//! A stroke as it lies in a buffer.

use crate::gpu::Words;
use crate::math::Vec3;
use crate::plant::Stroke;

/// A stroke as the vertex stage reads it.
///
/// | bytes | field      | type      | unit, space                                     |
/// |------:|------------|-----------|-------------------------------------------------|
/// |  0–11 | `center`   | 3 × `f32` | metres, plant                                   |
/// | 12–23 | `along`    | 3 × `f32` | half the length, in the direction of the stroke |
/// | 24–35 | `across`   | 3 × `f32` | half the width, at a right angle                |
/// | 36–39 | `material` | `u32`     | whose colour it has; the last one is the bark   |
/// | 40–43 | `outside`  | `f32`     | from 0 in the core to 1 in the outermost shell  |
///
/// Little-endian and unpadded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StrokeRecord {
    pub(super) stroke: Stroke,
    pub(super) material: u32,
    pub(super) outside: f32,
}

impl StrokeRecord {
    pub(super) const WORDS: usize = 11;
    pub(super) const STRIDE: u32 = 44;

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let Stroke {
            center,
            along,
            across,
        } = self.stroke;
        let floats = [center, along, across].map(|vector| vector.to_array());
        let floats = floats.as_flattened().iter().map(|float| float.to_bits());
        let words = floats.chain([self.material, self.outside.to_bits()]);
        words.flat_map(u32::to_le_bytes).collect()
    }

    #[inline]
    pub(super) fn read(words: Words<'_>, number: usize) -> Self {
        let first = number * Self::WORDS;
        let at: [f32; 9] = words.f32s(first);
        let [material, outside] = words.u32s(first + 9);
        Self {
            stroke: Stroke {
                center: Vec3::new(at[0], at[1], at[2]),
                along: Vec3::new(at[3], at[4], at[5]),
                across: Vec3::new(at[6], at[7], at[8]),
            },
            material,
            outside: f32::from_bits(outside),
        }
    }
}
