//! The program that draws all triangles that are no quads: with a normal and texture coordinates a vertex.

use spinney::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, Program, Topology,
    Transform, VertexCall, Wrap,
};
use spinney::math::{Mat3, Mat4, Vec2, Vec3, Vec4};

use crate::hulls;
use crate::leaves::{INSTANCE_SLOT, SURFACE_SLOT, VIEW_SLOT};
use crate::light::{AMBIENT, DIFFUSE, towards_light};

/// Draws triangles of vertices of 32 bytes: position, normal (3 × `f32` each), texture coordinate
/// (2 × `f32`). The surface has 6 words: colour (4 × `f32`), cutoff (`f32`), and 1 (`u32`) where the
/// texture repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct MeshTriangles {
    pub(crate) textured: bool,
    pub(crate) blend: Blend,
}

impl Program for MeshTriangles {
    fn layout(&self) -> Layout {
        Layout {
            name: "peer-mesh",
            version: 1,
            topology: Topology::TriangleList,
            blend: self.blend,
            vertex_stride: 32,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 3,
            texture_slots: u32::from(self.textured),
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let clip_from_world = Mat4::from_cols_array(&storage(VIEW_SLOT).f32s(0));
        let placements = storage(INSTANCE_SLOT);
        let place = Mat4::from_cols_array(&placements.f32s(16 * call.instance as usize));
        let turn = Mat3::from_mat4(place);
        let vertices = call.bindings.vertices();
        for (number, &corner) in (0..).zip(call.corners) {
            let [x, y, z, nx, ny, nz, u, v] = vertices.f32s(8 * corner as usize);
            let world = place.transform_point3(Vec3::new(x, y, z));
            let normal = turn * Vec3::new(nx, ny, nz);
            geometry.clip.push(clip_from_world * world.extend(1.0));
            let varyings = [u, v, normal.x, normal.y, normal.z];
            geometry.varyings.extend(varyings);
            geometry.vertex_ids.push(corner);
            geometry.corners.push(number);
        }
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let surface = bindings.storage(SURFACE_SLOT as usize);
        Box::new(MeshFragment {
            // The slot may still hold the texture of another batch.
            texture: bindings.texture(0).filter(|_| self.textured),
            color: Vec4::from_array(surface.f32s(0)),
            cutoff: surface.f32(4),
            wrap: match surface.u32(5) {
                0 => Wrap::Clamp,
                _ => Wrap::Repeat,
            },
            blended: self.blend == Blend::Alpha,
        })
    }
}

impl Hulls for MeshTriangles {
    fn slots(&self) -> Vec<u32> {
        Vec::new()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        hulls::bounds(corners, bindings.vertices(), 8)
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        hulls::transform(bindings, instance)
    }
}

#[derive(Debug)]
struct MeshFragment<'a> {
    texture: Option<&'a MipMap>,
    color: Vec4,
    /// 0 where alpha is not tested.
    cutoff: f32,
    wrap: Wrap,
    blended: bool,
}

impl MeshFragment<'_> {
    #[inline(always)]
    fn place(&self, texture: &MipMap, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
        (Vec2::new(pixel.varyings[0], pixel.varyings[1]), level)
    }
}

impl Fragment for MeshFragment<'_> {
    const VARYINGS: usize = 5;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let alpha = self.texture.map_or(1.0, |texture| {
            let (uv, level) = self.place(texture, pixel);
            texture.alpha(uv, level, self.wrap)
        });
        alpha * self.color.w >= self.cutoff
    }

    fn keeps_all(&self) -> bool {
        self.cutoff <= 0.0
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let color = self.texture.map_or(self.color, |texture| {
            let (uv, level) = self.place(texture, pixel);
            self.color * texture.sample(uv, level, self.wrap)
        });
        let [_, _, x, y, z, ..] = *pixel.varyings;
        let normal = Vec3::new(x, y, z).normalize_or_zero();
        let normal = if pixel.front { normal } else { -normal };
        let light = AMBIENT + DIFFUSE * normal.dot(towards_light()).max(0.0);
        (color.truncate() * light).extend(if self.blended { color.w } else { 1.0 })
    }
}
