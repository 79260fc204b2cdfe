//! What is painted on: canvas or paper, a texture that the screen is tiled with.

use super::brushes::Painted;
use super::pixels::{Plane, byte};
use super::{oil, watercolour};
use crate::math::{Stream, index_u32};
use crate::scene::PaintLook;

/// Texels a side, each a pixel of the screen.
pub(super) const GROUND_SIDE: u32 = 512;

/// Where the numbers come from with which it is made.
const STREAM: u64 = 0x7061_7065;

/// The ground of a look: R how high it lies, G how it is lit, B how light it is, A 1.
///
/// It lies still on the screen, as paper does; strokes move over it.
pub(super) fn ground(look: PaintLook) -> Painted {
    let mut draws = Stream::new(look as u64, STREAM).draws();
    let side = GROUND_SIDE as usize;
    let planes = match look {
        PaintLook::Oil => oil::canvas(side, &mut draws),
        PaintLook::Watercolour => watercolour::paper(side, &mut draws),
    };
    let texel = |at: usize| {
        let value = |plane: &Plane| byte(plane.values[at]);
        let [height, lit, tone] = planes.each_ref().map(value);
        [height, lit, tone, u8::MAX]
    };
    let bytes = (0..side * side).flat_map(texel).collect();
    Painted {
        size: [index_u32(side); 2],
        levels: vec![bytes],
    }
}
