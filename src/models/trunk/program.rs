//! The program that draws trunks: textured triangles, lit by interpolated normals.

use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, Program, Topology,
    Transform, VertexCall, Wrap,
};
use crate::math::{Vec2, Vec3, Vec4, index_u32};
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use crate::models::shadow::Lighting;

/// Bytes of one vertex: position, normal (3 × `f32` each), texture coordinate (2 × `f32`).
const VERTEX_BYTES: u32 = 32;

/// The slot of colour (3 × `f32`) and alpha cutoff (`f32`).
pub(in crate::models) const SURFACE_SLOT: u32 = 2;

/// The program that draws meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::models) struct MeshProgram;

impl Program for MeshProgram {
    fn layout(&self) -> Layout {
        Layout {
            name: "mesh",
            version: 1,
            topology: Topology::TriangleList,
            blend: Blend::Opaque,
            vertex_stride: VERTEX_BYTES,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 3,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let view = View::read(call.bindings.storage(VIEW_SLOT as usize));
        let placements = call.bindings.storage(INSTANCE_SLOT as usize);
        let placement = Placement::from_words(placements.f32s(8 * call.instance as usize));
        let vertices = call.bindings.vertices();
        let mut unique = call.corners.to_vec();
        unique.sort_unstable();
        unique.dedup();
        for &vertex in &unique {
            let [x, y, z, nx, ny, nz, u, v] = vertices.f32s((VERTEX_BYTES / 4 * vertex) as usize);
            let world = placement.to_world(Vec3::new(x, y, z));
            let normal = placement.rotation * Vec3::new(nx, ny, nz);
            geometry.clip.push(view.clip_from_world * world.extend(1.0));
            geometry
                .varyings
                .extend([u, v, normal.x, normal.y, normal.z]);
        }
        geometry.corners.extend(call.corners.iter().map(|corner| {
            index_u32(
                unique
                    .binary_search(corner)
                    .expect("every corner is among the unique ones"),
            )
        }));
        geometry.vertex_ids = unique;
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let view = View::read(bindings.storage(VIEW_SLOT as usize));
        let [r, g, b, alpha_cutoff] = bindings.storage(SURFACE_SLOT as usize).f32s(0);
        Box::new(MeshFragment {
            texture: bindings.texture(0),
            base_color: Vec3::new(r, g, b),
            alpha_cutoff,
            lighting: Lighting::of(bindings),
            view,
        })
    }
}

impl Hulls for MeshProgram {
    fn slots(&self) -> Vec<u32> {
        Vec::new()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let vertices = bindings.vertices();
        let at =
            |&corner: &u32| Vec3::from_array(vertices.f32s((VERTEX_BYTES / 4 * corner) as usize));
        let around = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        corners
            .iter()
            .map(at)
            .fold(around, |[least, greatest], point| {
                [least.min(point), greatest.max(point)]
            })
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

/// Textured, lit by an interpolated normal on the side that is seen.
#[derive(Debug)]
struct MeshFragment<'a> {
    texture: Option<&'a MipMap>,
    base_color: Vec3,
    alpha_cutoff: f32,
    lighting: Lighting<'a>,
    view: View,
}

impl MeshFragment<'_> {
    /// A bilinear read takes four texels.
    fn texels_read(&self) -> u64 {
        if self.texture.is_some() { 4 } else { 0 }
    }
}

impl Fragment for MeshFragment<'_> {
    const VARYINGS: usize = 5;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let Some(texture) = self.texture.filter(|_| self.alpha_cutoff > 0.0) else {
            return true;
        };
        let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
        let coordinate = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        texture.alpha(coordinate, level, Wrap::Repeat) >= self.alpha_cutoff
    }

    fn keeps_all(&self) -> bool {
        self.texture.filter(|_| self.alpha_cutoff > 0.0).is_none()
    }

    fn texels_tested(&self) -> u64 {
        if self.alpha_cutoff > 0.0 {
            self.texels_read()
        } else {
            0
        }
    }

    fn texels_shaded(&self) -> u64 {
        self.texels_read() + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [u, v, nx, ny, nz, ..] = *pixel.varyings;
        let texel = self.texture.map_or(Vec3::ONE, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            texture
                .sample(Vec2::new(u, v), level, Wrap::Repeat)
                .truncate()
        });
        let normal = Vec3::new(nx, ny, nz).normalize_or_zero();
        let normal = if pixel.front { normal } else { -normal };
        let toward = normal.dot(self.view.to_light).max(0.0);
        let light = self.lighting.at(toward, pixel);
        (self.base_color * texel * light).extend(1.0)
    }
}
