//! The program that draws impostors, and what it reads.
//!
//! One draw shows a crown: its corners count through the quads of all levels, and the vertex stage
//! leaves out those of other levels than the instance stands at. Between two levels it moves the
//! corners of the finer onto the plane between their own and that of the level to come
//! ([GSS05](crate::references), § 2.4). What it hands on to the fragment stages is
//! [`impostors_fragment`](super::impostors_fragment)'s.

use super::atlas::AtlasCell;
use super::impostors_fragment::impostor_fragment;
use super::impostors_outline::{MOST_CORNERS, Outline, OutlineCorner};
use super::impostors_set::Impostor;
use super::indirect_fragment::{IndirectFragment, LEAF_SLOT, SPRITE_SLOT};
use crate::gpu::{
    Bindings, Blend, Geometry, Hulls, Kernel, Layout, Program, Topology, Transform, VertexCall,
    Words,
};
use crate::math::{Vec2, Vec3, index_u32};
use crate::models::CardLevel;
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use crate::scene::{CardDepth, CardOutline, CardSides, Transparency};
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
    pub(super) depth: CardDepth,
    pub(super) transparency: Transparency,
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
/// | 16–19 | `depths`   | 4 × `f32` | m from the plane to the viewer: farthest and nearest, front and back |
/// | 20–59 | –          | 8 × 5 × `f32` | the corners: position, m, plant; coordinate in the cell |
///
/// Little-endian, 240 bytes an impostor.
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
    /// How far what each shows lies from the plane towards its viewer: the farthest, the nearest.
    pub(super) depths: [[f32; 2]; 2],
}

const CORNER_WORD: usize = 20;
const CORNER_WORDS: usize = 5;

impl ImpostorRecord {
    /// Words of a record.
    pub(super) const WORDS: usize = CORNER_WORD + CORNER_WORDS * MOST_CORNERS;

    /// Of an impostor that shows all of its textures, each as deep as the plane.
    pub(super) fn of(impostor: &Impostor, outline: &Outline) -> Self {
        Self {
            plane: impostor.plane,
            next: impostor.next,
            level: impostor.level,
            corners: outline.corners.clone(),
            least: [Vec2::ZERO; 2],
            sides: Vec2::ONE,
            depths: [[0.0; 2]; 2],
        }
    }

    /// The same with cells of an atlas for front and back, which may be one.
    pub(super) fn in_cells(self, cells: [&AtlasCell; 2]) -> Self {
        Self {
            least: cells.map(|cell| cell.least),
            sides: cells[0].sides,
            depths: cells.map(|cell| cell.depths),
            ..self
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
        floats(&mut words, self.depths.as_flattened());
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
pub(super) struct RecordReader<'a> {
    words: Words<'a>,
    first: usize,
}

/// All records of a buffer.
pub(super) fn records(words: Words<'_>) -> impl Iterator<Item = RecordReader<'_>> {
    (0..words.len() / ImpostorRecord::WORDS).map(move |number| RecordReader {
        words,
        first: number * ImpostorRecord::WORDS,
    })
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

    /// Front and back: the farthest and the nearest offset.
    pub(super) fn depths(&self) -> [[f32; 2]; 2] {
        let [front_far, front_near, back_far, back_near] = self.words.f32s(self.first + 16);
        [[front_far, front_near], [back_far, back_near]]
    }

    /// The least corners of both cells, and their sides.
    pub(super) fn cells(&self) -> ([Vec2; 2], Vec2) {
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
        let [storage_slots, texture_slots] = match self.textures {
            ImpostorTextures::Direct => [LEVEL_SLOT + 1, NORMAL_SLOT + 1],
            ImpostorTextures::Indirect => [SPRITE_SLOT + 1, LEAF_SLOT + 1],
        };
        Layout {
            name: match self.textures {
                ImpostorTextures::Direct => "impostor",
                ImpostorTextures::Indirect => "indirect-impostor",
            },
            version: 1,
            topology: Topology::QuadList,
            blend: match self.transparency {
                Transparency::Blend => Blend::Alpha,
                Transparency::Test | Transparency::Coverage => Blend::Opaque,
            },
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
            let normal = moved.unwrap_or(record.plane(0)).normal;
            // What a metre off the plane adds to z and w in clip space.
            let off = placement.rotation * normal * placement.scale;
            let off = view.clip_from_world * off.extend(0.0);
            let first = index_u32(geometry.clip.len());
            for corner in quad {
                let (position, coordinate) = record.corner(corner);
                let position = moved.map_or(position, |plane| plane.project(position));
                let world = placement.to_world(position);
                let clip = view.clip_from_world * world.extend(1.0);
                geometry.clip.push(clip);
                let coordinate = cells[0] + coordinate * sides;
                geometry.varyings.extend(coordinate.to_array());
                if self.depth == CardDepth::Relief {
                    geometry.varyings.push(clip.w);
                }
            }
            geometry.vertex_ids.extend(corners);
            geometry
                .corners
                .extend([first, first + 1, first + 2, first + 3]);
            geometry.flats.extend(to_light.to_array());
            geometry.flats.push(f32::from_bits(number));
            if self.depth == CardDepth::Relief {
                geometry.flats.extend([off.z, off.w]);
            }
        }
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        match self.textures {
            ImpostorTextures::Direct => impostor_fragment(*self, bindings),
            ImpostorTextures::Indirect => Box::new(IndirectFragment::new(bindings, self.sides)),
        }
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
