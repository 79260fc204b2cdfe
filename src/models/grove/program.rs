//! The program that draws a grove's polygons, and what it shares with that of lines.

use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, Pixel, Program, Topology,
    Transform, VertexCall, Words,
};
use crate::math::{Vec3, Vec4, index_u32};
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use crate::models::shadow::Lighting;

/// The slot of the materials.
pub(super) const MATERIAL_SLOT: u32 = 2;

/// Words of a polygon's vertex.
const VERTEX_WORDS: usize = 7;

/// The program of polygons.
#[derive(Debug, Clone, Copy)]
pub(super) struct GrovePolygons;

impl Program for GrovePolygons {
    fn layout(&self) -> Layout {
        Layout {
            name: "grove polygons",
            version: 1,
            topology: Topology::TriangleList,
            blend: Blend::Opaque,
            vertex_stride: index_u32(4 * VERTEX_WORDS),
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 3,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let (view, placement) = seen(call);
        let materials = call.bindings.storage(MATERIAL_SLOT as usize);
        for (&id, &place) in call.corners.iter().zip(call.places) {
            let [x, y, z, nx, ny, nz, _] = call.vertices.f32s(VERTEX_WORDS * place as usize);
            let world = placement.to_world(Vec3::new(x, y, z));
            let normal = placement.rotation * Vec3::new(nx, ny, nz);
            geometry.corners.push(index_u32(geometry.clip.len()));
            geometry.clip.push(view.clip_from_world * world.extend(1.0));
            geometry.varyings.extend(normal.to_array());
            geometry.vertex_ids.push(id);
        }
        for triangle in call.places.as_chunks::<3>().0 {
            let word = VERTEX_WORDS * triangle[0] as usize + VERTEX_WORDS - 1;
            let color = color_of(materials, call.vertices.u32(word));
            geometry.flats.extend(color.to_array());
        }
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(PolygonFragment {
            to_light: View::read(bindings.storage(VIEW_SLOT as usize)).to_light,
            lighting: Lighting::of(bindings),
        })
    }
}

impl Hulls for GrovePolygons {
    fn slots(&self) -> Vec<u32> {
        Vec::new()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let vertices = bindings.vertices();
        let at = |&corner: &u32| Vec3::from_array(vertices.f32s(VERTEX_WORDS * corner as usize));
        let around = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let points = corners.iter().map(at);
        points.fold(around, |[least, greatest], point| {
            [least.min(point), greatest.max(point)]
        })
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

/// Lit by an interpolated normal on the side that is seen.
#[derive(Debug)]
struct PolygonFragment<'a> {
    to_light: Vec3,
    lighting: Lighting<'a>,
}

impl Fragment for PolygonFragment<'_> {
    const VARYINGS: usize = 3;
    const FLATS: usize = 3;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [nx, ny, nz, ..] = *pixel.varyings;
        let normal = Vec3::new(nx, ny, nz).normalize_or_zero();
        let normal = if pixel.front { normal } else { -normal };
        let light = self.lighting.at(normal.dot(self.to_light).max(0.0), pixel);
        (Vec3::from_slice(pixel.flats) * light).extend(1.0)
    }
}

/// The view and where the instance stands.
pub(super) fn seen(call: &VertexCall<'_>) -> (View, Placement) {
    let view = View::read(call.bindings.storage(VIEW_SLOT as usize));
    let places = call.bindings.storage(INSTANCE_SLOT as usize);
    let placement = Placement::from_words(places.f32s(8 * call.instance as usize));
    (view, placement)
}

/// The colour of a material.
pub(super) fn color_of(materials: Words<'_>, number: u32) -> Vec3 {
    Vec3::from_array(materials.f32s(4 * number as usize))
}
