//! The fragment stage of impostors with leaf distribution maps: reads in turn, each where the one before
//! says ([GSS05](crate::references), § 2.3).

use super::impostors_set::CARD_ALPHA_CUTOFF;
use super::indirect_map::{LeafPlane, MapSheet};
use crate::gpu::{Bindings, Fragment, MipMap, Pixel, Words, Wrap};
use crate::math::{Vec2, Vec3, Vec4, index_u32};
use crate::models::shadow::Lighting;
use crate::scene::CardSides;

/// The slot of the leaf planes.
pub(super) const LEAF_PLANE_SLOT: u32 = 4;
/// The slot of the sprites' places.
pub(super) const SPRITE_SLOT: u32 = 5;
/// The slot of the maps' texture, after those of the sprites' colours and normals.
pub(super) const MAP_SLOT: u32 = 2;
/// The slot of the texture of their lists.
pub(super) const LIST_SLOT: u32 = 3;
/// The slot of the texture of their leaves.
pub(super) const LEAF_SLOT: u32 = 4;

/// What the fragment stage reads beside textures.
///
/// | words | field       | type      | unit, space |
/// |------:|-------------|-----------|-------------|
/// | 0     | `side`      | `u32`     | texels of a map's side |
/// | 1     | `usual`     | `u32`     | leaves of a texel that has some, in the mean |
/// | 2     | `columns`   | `u32`     | maps a row of their texture |
/// | 3     | –           | 0         | |
/// | 4–5   | `cell`      | 2 × `f32` | sides of a sprite's cell, texture |
/// | 6–7   | –           | 0         | |
/// | 8 …   | –           | 8 words an impostor | |
///
/// Of each impostor: `right` (3 × `f32`) and `up` (3 × `f32`), unit vectors of its plane, each followed by
/// the square's side that way, in the map's coordinates (`f32`).
pub(super) fn leaf_plane_bytes(
    planes: impl IntoIterator<Item = LeafPlane>,
    (sheet, side): (&MapSheet, u32),
    cell: Vec2,
) -> Vec<u8> {
    let mut words = vec![side, sheet.usual_count, sheet.columns, 0];
    words.extend([cell.x.to_bits(), cell.y.to_bits(), 0, 0]);
    for plane in planes {
        let right = plane.frame.right.extend(plane.square.x);
        let up = plane.frame.up.extend(plane.square.y);
        let floats = [right.to_array(), up.to_array()];
        words.extend(floats.as_flattened().iter().map(|value| value.to_bits()));
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

const HEAD_WORDS: usize = 8;
const PLANE_WORDS: usize = 8;

/// Textured through a map, alpha-tested, lit by the normal of each texel.
#[derive(Debug)]
pub(super) struct IndirectFragment<'a> {
    planes: Words<'a>,
    sprites: Words<'a>,
    side: u32,
    usual_count: u32,
    columns: u32,
    cell: Vec2,
    colour: Option<&'a MipMap>,
    normal: Option<&'a MipMap>,
    map: Option<&'a MipMap>,
    list: Option<&'a MipMap>,
    leaves: Option<&'a MipMap>,
    sides: CardSides,
    lighting: Lighting<'a>,
}

/// A leaf at a pixel.
#[derive(Debug, Clone, Copy)]
struct Found {
    /// Where to read the sprites' textures, and at which level.
    at: Vec2,
    level: u32,
}

impl<'a> IndirectFragment<'a> {
    pub(super) fn new(bindings: &Bindings<'a>, sides: CardSides) -> Self {
        let storage = |slot: u32| bindings.storage(slot as usize);
        let texture = |slot: u32| bindings.texture(slot as usize);
        let planes = storage(LEAF_PLANE_SLOT);
        let [side, usual_count, columns] = planes.u32s(0);
        Self {
            planes,
            sprites: storage(SPRITE_SLOT),
            side,
            usual_count,
            columns: columns.max(1),
            cell: Vec2::from_array(planes.f32s(4)),
            colour: texture(0),
            normal: texture(1),
            map: texture(MAP_SLOT),
            list: texture(LIST_SLOT),
            leaves: texture(LEAF_SLOT),
            sides,
            lighting: Lighting::of(bindings),
        }
    }

    fn number(pixel: &Pixel<'_>) -> u32 {
        // Constant over the quad, so the bits arrive as the vertex stage wrote them.
        pixel.flats[3].to_bits()
    }

    /// The leaf that shows: the first in the list of the pixel's texel that is opaque there.
    fn found(&self, pixel: &Pixel<'_>) -> Option<Found> {
        let (map, colour) = self.map.zip(self.colour)?;
        let (list, leaves) = self.list.zip(self.leaves)?;
        let number = Self::number(pixel);
        let first = HEAD_WORDS + PLANE_WORDS * number as usize;
        let usual = Vec2::new(self.planes.f32(first + 3), self.planes.f32(first + 7));
        let coordinate = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        let side = self.side;
        let [x, y] = [coordinate.x, coordinate.y]
            .map(|at| whole(at * side as f32).min(side.saturating_sub(1)));
        let [column, row] = [number % self.columns, number / self.columns];
        let texel = map.texel(0, column * side + x, row * side + y);
        let [begin, count] = [texel.x, texel.y].map(whole);
        let backwards = !pixel.front && self.sides == CardSides::Both;
        let at = |texels: &MipMap, number: u32| {
            let (width, _) = texels.level_size(0);
            texels.texel(0, number % width, number / width)
        };
        for step in 0..count {
            let entry = begin + if backwards { count - 1 - step } else { step };
            let leaf = at(list, entry / 4)[entry as usize % 4];
            let leaf = at(leaves, whole(leaf));
            let square = usual * leaf.w;
            let within = (coordinate - Vec2::new(leaf.x, leaf.y)) / square;
            if within.cmplt(Vec2::ZERO).any() || within.cmpgt(Vec2::ONE).any() {
                continue;
            }
            let scale = self.cell / square;
            let level = colour.level_for(pixel.derivative_x * scale, pixel.derivative_y * scale);
            let (width, height) = colour.level_size(level);
            let half = Vec2::new(0.5 / width as f32, 0.5 / height as f32);
            let sprite = whole(leaf.z) as usize;
            let least = Vec2::from_array(self.sprites.f32s(2 * sprite));
            let at = least + within * self.cell;
            let at = at.max(least + half).min(least + self.cell - half);
            if colour.alpha(at, level, Wrap::Clamp) >= CARD_ALPHA_CUTOFF {
                return Some(Found { at, level });
            }
        }
        None
    }
}

impl Fragment for IndirectFragment<'_> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 4;
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        self.found(pixel).is_some()
    }

    /// As if every texel had leaves, as many as those that have some in the mean, and all were asked: of
    /// the map one, of the list one for four leaves, then of each leaf its own and four of its sprite.
    fn texels_tested(&self) -> u64 {
        let count = u64::from(self.usual_count);
        1 + count.div_ceil(4) + 5 * count
    }

    fn texels_shaded(&self) -> u64 {
        self.texels_tested() + 8 + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let found = self.found(pixel).zip(self.colour.zip(self.normal));
        let Some((Found { at, level }, (colour, normal))) = found else {
            return Vec4::ZERO;
        };
        let albedo = colour.sample(at, level, Wrap::Clamp).truncate();
        let [x, y, z] =
            (2.0 * normal.sample(at, level, Wrap::Clamp).truncate() - Vec3::ONE).to_array();
        let first = HEAD_WORDS + PLANE_WORDS * Self::number(pixel) as usize;
        let [right, up] = [first, first + 4].map(|word| Vec3::from_array(self.planes.f32s(word)));
        let normal = right * x + up * y + right.cross(up) * z;
        let normal = if pixel.front { normal } else { -normal };
        let to_light = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        let toward = normal.dot(to_light).max(0.0);
        (albedo * self.lighting.at(toward, pixel)).extend(1.0)
    }
}

/// The whole part of a number, 0 of one below.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
#[inline(always)]
fn whole(value: f32) -> u32 {
    value as u32
}

/// Where each sprite lies: the upper left corner of its cell, two floats each.
pub(super) fn sprite_bytes(least: impl IntoIterator<Item = Vec2>) -> Vec<u8> {
    let floats = least.into_iter().flat_map(|corner| corner.to_array());
    floats.flat_map(f32::to_le_bytes).collect()
}

/// Bytes of [`leaf_plane_bytes`] for so many impostors.
pub(super) fn leaf_plane_size(impostors: usize) -> u64 {
    4 * u64::from(index_u32(HEAD_WORDS + PLANE_WORDS * impostors))
}
