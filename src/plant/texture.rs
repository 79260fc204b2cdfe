//! Small images that leaves and bark carry.

use crate::math::Digester;

/// An image: sRGB colour with straight linear alpha, 8 bits a channel, rows top-down.
#[derive(Clone, PartialEq, Eq)]
pub struct Texture {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
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
            rgba,
        })
    }

    /// The largest width or height.
    pub const MAX_SIDE: u32 = 8192;

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

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        digester.u32(self.width).u32(self.height).bytes(&self.rgba);
    }
}

impl std::fmt::Debug for Texture {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Texture({} × {})", self.width, self.height)
    }
}
