//! How paint lies on the ground, pixel by pixel.

use super::brushes::CELL_SIDES;
use super::ground::GROUND_SIDE;
use super::program::{BRUSH_SLOT, GROUND_SLOT};
use crate::gpu::{Bindings, Fragment, Kernel, MipMap, Pixel, Wrap};
use crate::math::{Vec2, Vec3, Vec4};
use crate::scene::PaintLook;

/// The fragment stage of a look.
pub(super) fn paint_kernel<'a>(
    look: PaintLook,
    grain: f32,
    bindings: &Bindings<'a>,
) -> Box<dyn Kernel + 'a> {
    Box::new(Paint {
        look,
        grain,
        brushes: bindings.texture(BRUSH_SLOT as usize),
        ground: bindings.texture(GROUND_SLOT as usize),
    })
}

#[derive(Debug)]
struct Paint<'a> {
    look: PaintLook,
    grain: f32,
    brushes: Option<&'a MipMap>,
    ground: Option<&'a MipMap>,
}

/// The ground at a pixel: how high, how lit, how light.
pub(super) fn ground_at(ground: &MipMap, [x, y]: [u32; 2]) -> Vec3 {
    ground.texel(0, x % GROUND_SIDE, y % GROUND_SIDE).truncate()
}

impl Fragment for Paint<'_> {
    const VARYINGS: usize = 2;
    /// Colour, thickness, and the first corner of the dab's cell.
    const FLATS: usize = 6;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        5
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some((brushes, ground)) = self.brushes.zip(self.ground) else {
            return Vec4::ZERO;
        };
        let level = brushes.level_for(pixel.derivative_x, pixel.derivative_y);
        let (width, height) = brushes.level_size(level);
        // Half a texel within the cell, so that no dab shows its neighbour.
        let half = Vec2::new(0.5 / width as f32, 0.5 / height as f32);
        let first = Vec2::new(pixel.flats[4], pixel.flats[5]);
        let at = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        let at = at.max(first + half).min(first + CELL_SIDES - half);
        let dab = brushes.sample(at, level, Wrap::Clamp);
        let under = ground_at(ground, pixel.position);
        let colour = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        match self.look {
            PaintLook::Oil => self.oil(dab, under, colour, pixel.flats[3]),
            PaintLook::Watercolour => self.wash(dab, under, colour, pixel.flats[3]),
        }
    }
}

impl Paint<'_> {
    /// Thick paint covers; where it is thin it catches on the threads alone. Ridges take the light.
    fn oil(&self, dab: Vec4, under: Vec3, colour: Vec3, thickness: f32) -> Vec4 {
        let [tone, ridge, _, cover] = dab.to_array();
        let valley = 1.0 - under.x;
        let held = 1.45 * cover * thickness - self.grain * valley * (1.25 - cover);
        let weave = 1.0 + 0.55 * self.grain * (under.y - 0.5);
        let shaded = colour * (0.62 + 0.76 * tone) * weave * (0.40 + 1.2 * ridge);
        let glint = (ridge - 0.58).max(0.0) * 0.22;
        (shaded + glint).extend(held.clamp(0.0, 1.0))
    }

    /// Pigment tints what is below it, most at its rims, and settles in the paper's hollows.
    fn wash(&self, dab: Vec4, under: Vec3, colour: Vec3, thickness: f32) -> Vec4 {
        let [pigment, settled, _, cover] = dab.to_array();
        let hollow = self.grain * (0.5 - under.x) * (0.5 + settled);
        let amount = thickness * (0.35 + 1.65 * pigment) * (1.0 + 0.9 * hollow);
        // Where there is much, colours deepen.
        let deep = (0.85 + 0.5 * pigment).min(1.3);
        let tint = colour
            * colour
                .max(Vec3::splat(0.02))
                .map(|c| (deep - 1.0) * c + 1.0)
            / deep;
        let weave = 1.0 + 0.30 * self.grain * (under.y - 0.5);
        (tint * weave).extend((cover * amount).clamp(0.0, 1.0))
    }
}
