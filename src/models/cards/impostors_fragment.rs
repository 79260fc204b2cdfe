//! The fragment stages of impostors with a picture each: textured, lit by the normal of each texel.
//!
//! | varyings | flats | meaning |
//! |---|---|---|
//! | 0–1 | | texture coordinate, in the cell of the front |
//! | 2 | | with relief: w in clip space |
//! | | 0–2 | direction to the light, plant |
//! | | 3 | bits of the impostor's number |
//! | | 4–5 | with relief: what a metre along the plane's normal adds to z and w in clip space |

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8};

use super::impostors_program::{COLOUR_SLOT, IMPOSTOR_SLOT, ImpostorProgram, NORMAL_SLOT, records};
use super::impostors_set::CARD_ALPHA_CUTOFF;
use crate::gpu::{Bindings, Fragment, Kernel, MipMap, Pixel, PixelLanes, Wrap};
use crate::math::{Vec2, Vec3, Vec4};
use crate::models::shadow::Lighting;
use crate::scene::{CardDepth, CardSides, Transparency};

/// The stage of a program with a picture for each impostor.
pub(super) fn impostor_fragment<'a>(
    program: ImpostorProgram,
    bindings: &Bindings<'a>,
) -> Box<dyn Kernel + 'a> {
    let covers = program.transparency == Transparency::Coverage;
    match (covers, program.depth) {
        (false, CardDepth::Paper) => Box::new(stage::<false, false>(program, bindings)),
        (false, CardDepth::Relief) => Box::new(stage::<false, true>(program, bindings)),
        (true, CardDepth::Paper) => Box::new(stage::<true, false>(program, bindings)),
        (true, CardDepth::Relief) => Box::new(stage::<true, true>(program, bindings)),
    }
}

fn stage<'a, const COVERS: bool, const RELIEF: bool>(
    program: ImpostorProgram,
    bindings: &Bindings<'a>,
) -> ImpostorFragment<'a, COVERS, RELIEF> {
    let blends = program.transparency == Transparency::Blend;
    let cards = records(bindings.storage(IMPOSTOR_SLOT as usize)).map(|record| {
        let (least, sides) = record.cells();
        Card {
            least,
            sides,
            depths: record.depths(),
        }
    });
    ImpostorFragment {
        cards: cards.collect(),
        colour: bindings.texture(COLOUR_SLOT as usize),
        normal: bindings.texture(NORMAL_SLOT as usize),
        // What is blended shows from the least alpha on.
        cutoff: if blends {
            0.5 / 255.0
        } else {
            CARD_ALPHA_CUTOFF
        },
        blends,
        back_normal: match program.sides {
            CardSides::Both => 1.0,
            CardSides::Front => -1.0,
        },
        lighting: Lighting::of(bindings),
    }
}

/// Whether alpha is coverage, and whether texels have a depth of their own.
#[derive(Debug)]
struct ImpostorFragment<'a, const COVERS: bool, const RELIEF: bool> {
    cards: Vec<Card>,
    colour: Option<&'a MipMap>,
    normal: Option<&'a MipMap>,
    cutoff: f32,
    blends: bool,
    /// The sign of normals that are seen from behind.
    back_normal: f32,
    lighting: Lighting<'a>,
}

#[derive(Debug, Clone, Copy)]
struct Card {
    least: [Vec2; 2],
    sides: Vec2,
    depths: [[f32; 2]; 2],
}

impl<const COVERS: bool, const RELIEF: bool> ImpostorFragment<'_, COVERS, RELIEF> {
    #[inline(always)]
    fn card(&self, pixel: &Pixel<'_>) -> &Card {
        // Constant over the quad, so the bits arrive as the vertex stage wrote them.
        &self.cards[pixel.flats[3].to_bits() as usize]
    }

    /// Where to read, and at which level: within the cell of the side that is seen.
    #[inline(always)]
    fn place(&self, texture: &MipMap, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
        let card = self.card(pixel);
        let [moved, least, greatest] = card.reads(pixel.front, texture.level_size(level));
        let within = |at: f32, least: f32, greatest: f32| {
            let at = if at > least { at } else { least };
            if at < greatest { at } else { greatest }
        };
        let [u, v, ..] = *pixel.varyings;
        let at = Vec2::new(
            within(u + moved.x, least.x, greatest.x),
            within(v + moved.y, least.y, greatest.y),
        );
        (at, level)
    }
}

impl Card {
    /// How far the cell of the side that is seen lies from the front's, and between which corners is
    /// read at a level of a texture of this size: half a texel within the cell.
    #[inline(always)]
    fn reads(&self, front: bool, (width, height): (u32, u32)) -> [Vec2; 3] {
        let half = Vec2::new(0.5 / width as f32, 0.5 / height as f32);
        let least = self.least[usize::from(!front)];
        [
            least - self.least[0],
            least + half,
            least + self.sides - half,
        ]
    }
}

/// Coordinates moved, then kept within a least and a greatest one.
#[inline(always)]
fn within<S: Simd>(simd: S, at: f32x8<S>, [moved, least, greatest]: [f32; 3]) -> f32x8<S> {
    let (least, greatest) = (f32x8::splat(simd, least), f32x8::splat(simd, greatest));
    let at = at + f32x8::splat(simd, moved);
    let at = at.simd_gt(least).select(at, least);
    at.simd_lt(greatest).select(at, greatest)
}

impl<const COVERS: bool, const RELIEF: bool> Fragment for ImpostorFragment<'_, COVERS, RELIEF> {
    const VARYINGS: usize = if RELIEF { 3 } else { 2 };
    const FLATS: usize = if RELIEF { 6 } else { 4 };
    const TESTS_ALPHA: bool = true;
    const COVERAGE: bool = COVERS;
    const MOVES_DEPTH: bool = RELIEF;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        self.alpha(pixel) >= self.cutoff
    }

    #[inline(always)]
    fn keeps_lanes<S: Simd>(&self, simd: S, pixels: &PixelLanes<'_, S>, wanted: u64) -> u64 {
        let Some(texture) = self.colour else {
            return 0;
        };
        let levels = texture.level_for_lanes(simd, pixels.derivative_x, pixels.derivative_y);
        let Some(one) = MipMap::one_level(simd, levels, wanted) else {
            return pixels.each(wanted, |pixel| self.keeps(pixel));
        };
        let card = &self.cards[pixels.flats[3].to_bits() as usize];
        let [moved, least, greatest] = card.reads(pixels.front, texture.level_size(one));
        let at = [
            within(simd, pixels.varyings[0], [moved.x, least.x, greatest.x]),
            within(simd, pixels.varyings[1], [moved.y, least.y, greatest.y]),
        ];
        let alpha = texture.alpha_lanes(simd, at, levels, Wrap::Clamp, wanted);
        alpha.simd_ge(f32x8::splat(simd, self.cutoff)).to_bitmask()
    }

    #[inline(always)]
    fn alpha(&self, pixel: &Pixel<'_>) -> f32 {
        self.colour.map_or(0.0, |texture| {
            let (at, level) = self.place(texture, pixel);
            texture.alpha(at, level, Wrap::Clamp)
        })
    }

    /// From the depth of the plane to that of the texel: by the mean of what the texel shows.
    fn depth_offset(&self, pixel: &Pixel<'_>) -> f32 {
        let Some((colour, normal)) = self.colour.zip(self.normal) else {
            return 0.0;
        };
        let (at, level) = self.place(colour, pixel);
        let back = usize::from(!pixel.front && self.back_normal > 0.0);
        let [farthest, nearest] = self.card(pixel).depths[back];
        let share = normal.sample(at, level, Wrap::Clamp).w;
        let toward = farthest + share * (nearest - farthest);
        let along = if back == 0 { toward } else { -toward };
        let [off_z, off_w] = [pixel.flats[4], pixel.flats[5]];
        let w = pixel.varyings[2];
        let moved = w + along * off_w;
        // So near to the eye that it would lie behind it.
        if moved <= 0.0 {
            return 0.0;
        }
        (pixel.depth * w + along * off_z) / moved - pixel.depth
    }

    fn texels_tested(&self) -> u64 {
        if RELIEF { 8 } else { 4 }
    }

    fn texels_shaded(&self) -> u64 {
        8 + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some((colour, normal)) = self.colour.zip(self.normal) else {
            return Vec4::ZERO;
        };
        let (at, level) = self.place(colour, pixel);
        let texel = colour.sample(at, level, Wrap::Clamp);
        let normal = 2.0 * normal.sample(at, level, Wrap::Clamp).truncate() - Vec3::ONE;
        let normal = if pixel.front {
            normal
        } else {
            self.back_normal * normal
        };
        let to_light = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        let toward = normal.dot(to_light).max(0.0);
        let lit = texel.truncate() * self.lighting.at(toward, pixel);
        lit.extend(if self.blends { texel.w } else { 1.0 })
    }
}
