//! The program that draws leaves of several faces: as the one that draws quads, face by face.

use fearless_simd::{Simd, SimdBase, dispatch, f32x16};

use super::super::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use super::super::leaf::{Look, MATERIAL_SLOT, leaf_kernel};
use crate::gpu::{
    Bindings, Blend, Geometry, Hulls, Kernel, Layout, Program, Topology, Transform, VertexCall,
    Words,
};
use crate::math::lanes::{LANES, Vec3Lanes};
use crate::math::{Mat4, Vec3, Vec4, index_u32};

/// The program that draws leaves of several faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) struct FaceProgram;

/// The slot of the texture coordinates of each group's leaf: 2 × `f32` a corner, three corners a face.
pub(super) const COORDINATE_SLOT: u32 = MATERIAL_SLOT + 1;

const VERTEX_BYTES: u32 = 12;

impl Program for FaceProgram {
    fn layout(&self) -> Layout {
        Layout {
            name: "face-leaf",
            version: 1,
            topology: Topology::TriangleList,
            blend: Blend::Opaque,
            vertex_stride: VERTEX_BYTES,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: COORDINATE_SLOT + 1,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let faces = call.corners.as_chunks::<3>().0;
        let count = faces.len();
        geometry.clip.reserve_exact(3 * count);
        geometry.varyings.reserve_exact(6 * count);
        geometry.vertex_ids.reserve_exact(3 * count);
        geometry.flats.reserve_exact(3 * count);
        geometry.corners.reserve_exact(3 * count);
        let stage = FaceStage::new(call);
        dispatch!(call.instructions.level(), simd => {
            for faces in faces.chunks(LANES) {
                stage.emit(simd, faces, geometry);
            }
        });
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let materials = read_materials(bindings.storage(MATERIAL_SLOT as usize));
        leaf_kernel(bindings, materials.iter().map(|material| material.look))
    }
}

impl Hulls for FaceProgram {
    fn slots(&self) -> Vec<u32> {
        Vec::new()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let vertices = bindings.vertices();
        let around = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        corners.iter().fold(around, |[least, greatest], &corner| {
            let point = Vec3::from_array(vertices.f32s(3 * corner as usize));
            [least.min(point), greatest.max(point)]
        })
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

/// What the vertex stage knows before it sees a face.
struct FaceStage<'a> {
    clip_from_world: Mat4,
    to_light: Vec3,
    placement: Placement,
    vertices: Words<'a>,
    coordinates: Words<'a>,
    materials: Vec<FaceMaterial>,
}

impl<'a> FaceStage<'a> {
    fn new(call: &VertexCall<'a>) -> Self {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let view = View::read(storage(VIEW_SLOT));
        let placements = storage(INSTANCE_SLOT);
        Self {
            clip_from_world: view.clip_from_world,
            to_light: view.to_light,
            placement: Placement::from_words(placements.f32s(8 * call.instance as usize)),
            vertices: call.bindings.vertices(),
            coordinates: storage(COORDINATE_SLOT),
            materials: read_materials(storage(MATERIAL_SLOT)),
        }
    }

    /// Emits faces, each with its own normal.
    #[inline(always)]
    fn emit<S: Simd>(&self, simd: S, faces: &[[u32; 3]], geometry: &mut Geometry) {
        let mut world = [Vec3Lanes::splat(simd, Vec3::ZERO); 3];
        let mut clip = [[[0.0_f32; LANES]; 4]; 3];
        let (scale, position) = (
            f32x16::splat(simd, self.placement.scale),
            Vec3Lanes::splat(simd, self.placement.position),
        );
        for corner in 0..3 {
            let mut at = [[0.0_f32; LANES]; 3];
            for (lane, vertices) in faces.iter().enumerate().take(LANES) {
                let point: [f32; 3] = self.vertices.f32s(3 * vertices[corner] as usize);
                for (axis, value) in point.into_iter().enumerate() {
                    at[axis][lane] = value;
                }
            }
            let point = Vec3Lanes::new(simd, &at).times(scale);
            world[corner] = point.rotated(simd, self.placement.rotation).plus(position);
            let projected = world[corner].projected(simd, &self.clip_from_world);
            for (axis, values) in projected.into_iter().enumerate() {
                values.store_slice(&mut clip[corner][axis]);
            }
        }
        let normal = world[1].minus(world[0]).cross(world[2].minus(world[0]));
        let normal = normal.normalize_or_zero(simd);
        let mut toward = [0.0_f32; LANES];
        let towards = normal.dot(Vec3Lanes::splat(simd, self.to_light));
        towards.store_slice(&mut toward);
        for (lane, vertices) in faces.iter().enumerate().take(LANES) {
            let face = vertices[0] / 3;
            // Groups are few and ascending; the last one that begins at or before the face has it.
            let group = self
                .materials
                .iter()
                .rposition(|material| material.first_face <= face)
                .unwrap_or(0);
            let Some(material) = self.materials.get(group) else {
                return;
            };
            let within = face.wrapping_sub(material.first_face);
            let number = material.first_vertex.wrapping_add(within.wrapping_mul(3));
            let place = within % material.faces_per_leaf.max(1);
            let coordinate = material.first_coordinate.wrapping_add(3 * place) as usize;
            let first = index_u32(geometry.clip.len());
            for (offset, clip) in (0..).zip(&clip) {
                let [x, y, z, w] = clip;
                geometry
                    .clip
                    .push(Vec4::new(x[lane], y[lane], z[lane], w[lane]));
                geometry.vertex_ids.push(number.wrapping_add(offset));
                geometry.corners.push(first + offset);
            }
            let six: [f32; 6] = self.coordinates.f32s(2 * coordinate);
            geometry.varyings.extend(six);
            geometry.flats.extend([
                toward[lane].max(0.0),
                (-toward[lane]).max(0.0),
                f32::from_bits(index_u32(group)),
            ]);
        }
    }
}

/// One group of leaves of several faces as the program sees it.
///
/// | words | field              | type      |
/// |------:|--------------------|-----------|
/// | 0     | `first_face`       | `u32`, the group's first face |
/// | 1     | `texture`          | `u32`, texture slot + 1, or 0 |
/// | 2     | `alpha_cutoff`     | `f32` |
/// | 3     | `faces_per_leaf`   | `u32` |
/// | 4–7   | `base_color`       | 4 × `f32`, linear |
/// | 8     | `first_vertex`     | `u32`, the number that keys have for the first vertex of its first face |
/// | 9     | `first_coordinate` | `u32`, the first of its texture coordinates |
///
/// Little-endian, 40 bytes a group, groups ascending by first face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FaceMaterial {
    pub(super) first_face: u32,
    pub(super) faces_per_leaf: u32,
    pub(super) first_vertex: u32,
    pub(super) first_coordinate: u32,
    pub(super) look: Look,
}

impl FaceMaterial {
    const WORDS: usize = 10;

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let Look {
            texture,
            base_color,
            alpha_cutoff,
        } = self.look;
        let mut words = vec![
            self.first_face,
            texture,
            alpha_cutoff.to_bits(),
            self.faces_per_leaf,
        ];
        words.extend(base_color.to_array().map(f32::to_bits));
        words.extend([self.first_vertex, self.first_coordinate]);
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    fn read(words: Words<'_>, group: usize) -> Self {
        let first = group * Self::WORDS;
        let [first_face, texture, _, faces_per_leaf] = words.u32s(first);
        let [first_vertex, first_coordinate] = words.u32s(first + 8);
        Self {
            first_face,
            faces_per_leaf,
            first_vertex,
            first_coordinate,
            look: Look {
                texture,
                alpha_cutoff: words.f32(first + 2),
                base_color: Vec4::from_array(words.f32s(first + 4)),
            },
        }
    }
}

fn read_materials(words: Words<'_>) -> Vec<FaceMaterial> {
    (0..words.len() / FaceMaterial::WORDS)
        .map(|group| FaceMaterial::read(words, group))
        .collect()
}
