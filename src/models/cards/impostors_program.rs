//! The program that draws impostors, and what it reads.
//!
//! One draw shows a crown: its corners count through the quads of all levels, and the vertex stage
//! leaves out those of other levels than the instance stands at. Between two levels it moves the
//! corners of the finer onto the plane between their own and that of the level to come
//! ([GSS05](crate::references), § 2.4).

use super::impostors_outline::{MOST_CORNERS, Outline, OutlineCorner};
use super::impostors_set::{CARD_ALPHA_CUTOFF, Impostor};
use super::indirect_fragment::{IndirectFragment, MAP_SLOT, SPRITE_SLOT};
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, Program, Topology,
    Transform, VertexCall, Words, Wrap,
};
use crate::math::{Vec2, Vec3, Vec4, index_u32};
use crate::models::CardLevel;
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use crate::scene::{CardOutline, CardSides};
use crate::simplify::Plane;

/// The slot of the impostors.
pub(super) const IMPOSTOR_SLOT: u32 = 2;
/// The slot of the level at which an instance stands: a [`CardLevel`] as `u32`.
pub(super) const LEVEL_SLOT: u32 = 3;

/// The slot of the colours' texture.
pub(super) const COLOUR_SLOT: u32 = 0;
/// The slot of the normals' texture.
pub(super) const NORMAL_SLOT: u32 = 1;

/// Draws impostors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ImpostorProgram {
    pub(super) outline: CardOutline,
    pub(super) sides: CardSides,
    pub(super) textures: ImpostorTextures,
}

/// What the fragment stage reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ImpostorTextures {
    /// Each impostor's own picture.
    Direct,
    /// A map of leaves, and pictures of one.
    Indirect,
}

impl ImpostorProgram {
    /// Quads that an impostor is drawn as: a fan around its first corner.
    pub(super) fn quads(self) -> u32 {
        match self.outline {
            CardOutline::Quad => 1,
            CardOutline::Trimmed => index_u32(MOST_CORNERS).div_ceil(2) - 1,
        }
    }
}

/// An impostor as the program reads it.
///
/// | words | field      | type      | unit, space |
/// |------:|------------|-----------|-------------|
/// | 0–3   | `plane`    | 4 × `f32` | normal and distance, m, plant |
/// | 4–7   | `next`     | 4 × `f32` | the plane of the next level |
/// | 8     | `level`    | `u32`     | |
/// | 9     | `corners`  | `u32`     | how many, 3 to 8 |
/// | 10–13 | `front`    | 4 × `f32` | upper left corner and sides of its cell, texture |
/// | 14–15 | `back`     | 2 × `f32` | upper left corner of the cell seen from behind |
/// | 16–55 | –          | 8 × 5 × `f32` | the corners: position, m, plant; coordinate in the cell |
///
/// Little-endian, 224 bytes an impostor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImpostorRecord {
    pub(super) plane: Plane,
    pub(super) next: Plane,
    pub(super) level: u32,
    pub(super) corners: Vec<OutlineCorner>,
    /// The upper left corners of the cells of front and back, which may be the same.
    pub(super) least: [Vec2; 2],
    /// The sides of both.
    pub(super) sides: Vec2,
}

const CORNER_WORD: usize = 16;
const CORNER_WORDS: usize = 5;

impl ImpostorRecord {
    /// Words of a record.
    pub(super) const WORDS: usize = CORNER_WORD + CORNER_WORDS * MOST_CORNERS;

    /// Of an impostor with the corners of its cells, and their sides.
    pub(super) fn of(
        impostor: &Impostor,
        outline: &Outline,
        least: [Vec2; 2],
        sides: Vec2,
    ) -> Self {
        Self {
            plane: impostor.plane,
            next: impostor.next,
            level: impostor.level,
            corners: outline.corners.clone(),
            least,
            sides,
        }
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let plane = |plane: &Plane| plane.normal.extend(plane.distance).to_array();
        let [front, back] = &self.least;
        let mut words: Vec<u32> = Vec::with_capacity(Self::WORDS);
        let floats = |words: &mut Vec<u32>, values: &[f32]| {
            words.extend(values.iter().map(|value| value.to_bits()));
        };
        floats(&mut words, &plane(&self.plane));
        floats(&mut words, &plane(&self.next));
        words.extend([self.level, index_u32(self.corners.len())]);
        floats(&mut words, &front.to_array());
        floats(&mut words, &self.sides.to_array());
        floats(&mut words, &back.to_array());
        for corner in &self.corners {
            floats(&mut words, &corner.position.to_array());
            floats(&mut words, &corner.coordinate.to_array());
        }
        words.resize(Self::WORDS, 0);
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }
}

/// A record where it lies.
#[derive(Debug, Clone, Copy)]
struct RecordReader<'a> {
    words: Words<'a>,
    first: usize,
}

impl RecordReader<'_> {
    fn plane(&self, word: usize) -> Plane {
        let [x, y, z, distance] = self.words.f32s(self.first + word);
        Plane {
            normal: Vec3::new(x, y, z),
            distance,
        }
    }

    fn level(&self) -> u32 {
        self.words.u32(self.first + 8)
    }

    fn corner_count(&self) -> usize {
        (self.words.u32(self.first + 9) as usize).min(MOST_CORNERS)
    }

    /// The least corners of both cells, and their sides.
    fn cells(&self) -> ([Vec2; 2], Vec2) {
        let [x, y, wide, high, back_x, back_y] = self.words.f32s(self.first + 10);
        let least = [Vec2::new(x, y), Vec2::new(back_x, back_y)];
        (least, Vec2::new(wide, high))
    }

    /// Position and coordinate.
    fn corner(&self, corner: usize) -> (Vec3, Vec2) {
        let first = self.first + CORNER_WORD + CORNER_WORDS * corner;
        let [x, y, z, u, v] = self.words.f32s(first);
        (Vec3::new(x, y, z), Vec2::new(u, v))
    }
}

/// The record of a quad, and which corners of the outline are the quad's: a fan around the first.
fn quad_of(
    words: Words<'_>,
    corner: u32,
    quads: u32,
) -> (RecordReader<'_>, u32, Option<[usize; 4]>) {
    let (number, quad) = (corner / 4 / quads, (corner / 4 % quads) as usize);
    let first = ImpostorRecord::WORDS * number as usize;
    let record = RecordReader { words, first };
    let last = record.corner_count().saturating_sub(1);
    let is_there = 2 * quad + 2 <= last;
    let corners = [0, 2 * quad + 1, 2 * quad + 2, (2 * quad + 3).min(last)];
    (record, number, is_there.then_some(corners))
}

impl Program for ImpostorProgram {
    fn layout(&self) -> Layout {
        let names = match (self.textures, self.outline) {
            (ImpostorTextures::Direct, CardOutline::Quad) => ["impostor", "one-sided-impostor"],
            (ImpostorTextures::Direct, CardOutline::Trimmed) => {
                ["trimmed-impostor", "one-sided-trimmed-impostor"]
            }
            (ImpostorTextures::Indirect, _) => ["indirect-impostor", "one-sided-indirect-impostor"],
        };
        let [storage_slots, texture_slots] = match self.textures {
            ImpostorTextures::Direct => [LEVEL_SLOT + 1, NORMAL_SLOT + 1],
            ImpostorTextures::Indirect => [SPRITE_SLOT + 1, MAP_SLOT + 1],
        };
        Layout {
            name: names[usize::from(self.sides == CardSides::Front)],
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Opaque,
            vertex_stride: 0,
            pulled_primitive_bytes: 4 * index_u32(CORNER_WORD),
            pulled_vertex_bytes: 4 * index_u32(CORNER_WORDS),
            storage_slots,
            texture_slots,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let view = View::read(storage(VIEW_SLOT));
        let placement =
            Placement::from_words(storage(INSTANCE_SLOT).f32s(8 * call.instance as usize));
        let [level, step] = CardLevel(storage(LEVEL_SLOT).u32(0)).parts();
        let share = step as f32 / CardLevel::STEPS as f32;
        // Normals are the plant's own, so light is turned to them.
        let to_light = placement.rotation.inverse() * view.to_light;
        for corners in call.corners.as_chunks::<4>().0 {
            let (record, number, quad) = quad_of(storage(IMPOSTOR_SLOT), corners[0], self.quads());
            let Some(quad) = quad.filter(|_| record.level() == level) else {
                continue;
            };
            let moved = (step > 0).then(|| record.plane(0).between(&record.plane(4), share));
            let (cells, sides) = record.cells();
            let first = index_u32(geometry.clip.len());
            for corner in quad {
                let (position, coordinate) = record.corner(corner);
                let position = moved.map_or(position, |plane| plane.project(position));
                let world = placement.to_world(position);
                geometry.clip.push(view.clip_from_world * world.extend(1.0));
                let coordinate = cells[0] + coordinate * sides;
                geometry.varyings.extend(coordinate.to_array());
            }
            geometry.vertex_ids.extend(corners);
            geometry
                .corners
                .extend([first, first + 1, first + 2, first + 3]);
            geometry.flats.extend(to_light.to_array());
            geometry.flats.push(f32::from_bits(number));
        }
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        if self.textures == ImpostorTextures::Indirect {
            return Box::new(IndirectFragment::new(bindings, self.sides));
        }
        let view = View::read(bindings.storage(VIEW_SLOT as usize));
        let words = bindings.storage(IMPOSTOR_SLOT as usize);
        let records = (0..words.len() / ImpostorRecord::WORDS).map(|number| RecordReader {
            words,
            first: number * ImpostorRecord::WORDS,
        });
        Box::new(ImpostorFragment {
            cells: records.map(|record| record.cells()).collect(),
            colour: bindings.texture(COLOUR_SLOT as usize),
            normal: bindings.texture(NORMAL_SLOT as usize),
            back_normal: match self.sides {
                CardSides::Both => 1.0,
                CardSides::Front => -1.0,
            },
            light: view.light,
            ambient: view.ambient,
        })
    }
}

/// Of all levels and everything between them: where impostors lie does not change with what is shown.
impl Hulls for ImpostorProgram {
    fn slots(&self) -> Vec<u32> {
        vec![IMPOSTOR_SLOT]
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let words = bindings.storage(IMPOSTOR_SLOT as usize);
        let mut bounds = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        for corners in corners.as_chunks::<4>().0 {
            let (record, _, quad) = quad_of(words, corners[0], self.quads());
            let next = record.plane(4);
            for (position, _) in quad
                .into_iter()
                .flatten()
                .map(|corner| record.corner(corner))
            {
                // On the way a corner never lies further from the plane between than √2 times from
                // where it ends; a little more for what is rounded.
                let distance = next.signed_distance(position).abs();
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "rounds by less than the room"
                )]
                let room = (1.42 * distance) as f32 + 1e-5 * position.abs().max_element();
                let room = Vec3::splat(if next == record.plane(0) { 0.0 } else { room });
                bounds = [
                    bounds[0].min(position - room),
                    bounds[1].max(position + room),
                ];
            }
        }
        bounds
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

/// Textured, alpha-tested, lit by the normal of each texel.
#[derive(Debug)]
struct ImpostorFragment<'a> {
    /// The least corners of both cells of each impostor, and their sides.
    cells: Vec<([Vec2; 2], Vec2)>,
    colour: Option<&'a MipMap>,
    normal: Option<&'a MipMap>,
    /// The sign of normals that are seen from behind.
    back_normal: f32,
    light: Vec3,
    ambient: Vec3,
}

impl ImpostorFragment<'_> {
    /// Where to read, and at which level: within the cell of the side that is seen.
    #[inline(always)]
    fn place(&self, texture: &MipMap, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
        let (width, height) = texture.level_size(level);
        let half = Vec2::new(0.5 / width as f32, 0.5 / height as f32);
        // Constant over the quad, so the bits arrive as the vertex stage wrote them.
        let (cells, sides) = &self.cells[pixel.flats[3].to_bits() as usize];
        let least = cells[usize::from(!pixel.front)];
        let at = Vec2::new(pixel.varyings[0], pixel.varyings[1]) + (least - cells[0]);
        (at.max(least + half).min(least + *sides - half), level)
    }
}

impl Fragment for ImpostorFragment<'_> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 4;
    const TESTS_ALPHA: bool = true;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        self.colour.is_some_and(|texture| {
            let (at, level) = self.place(texture, pixel);
            texture.alpha(at, level, Wrap::Clamp) >= CARD_ALPHA_CUTOFF
        })
    }

    fn texels_tested(&self) -> u64 {
        4
    }

    fn texels_shaded(&self) -> u64 {
        8
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some((colour, normal)) = self.colour.zip(self.normal) else {
            return Vec4::ZERO;
        };
        let (at, level) = self.place(colour, pixel);
        let albedo = colour.sample(at, level, Wrap::Clamp).truncate();
        let normal = 2.0 * normal.sample(at, level, Wrap::Clamp).truncate() - Vec3::ONE;
        let normal = if pixel.front {
            normal
        } else {
            self.back_normal * normal
        };
        let to_light = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        let toward = normal.dot(to_light).max(0.0);
        (albedo * (self.ambient + self.light * toward)).extend(1.0)
    }
}
