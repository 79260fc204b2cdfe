//! What a texel of a texture means.

/// What the bytes of a texel are; every read decodes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TextureFormat {
    /// Bytes R, G, B, A: colour in sRGB, alpha straight and linear.
    Srgb8,
    /// Four bytes as they are, each over 255: normals, offsets.
    Linear8,
    /// Four little-endian `f32` as they are, for tables. Only the nearest texel is ever read, never a
    /// blend: cards of the time filter no such texels.
    Float32,
}

impl TextureFormat {
    /// Bytes of a texel.
    #[must_use]
    pub fn texel_bytes(self) -> u32 {
        match self {
            Self::Srgb8 | Self::Linear8 => 4,
            Self::Float32 => 16,
        }
    }
}
