//! The program that draws lines, and what all programs of lines share.

use super::light::Viewer;
use super::parameters::{PARAMETER_SLOT, Parameters};
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, MipMap, Pixel, Program, Topology,
    VertexCall, Words, Wrap,
};
use crate::math::{Vec2, Vec3, Vec4, index_u32};
use crate::models::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View};
use crate::models::shadow::Lighting;
use crate::models::trunk::SURFACE_SLOT;
use crate::scene::BranchLines;
use crate::simplify::{BranchVertex, LineAlpha};

/// Bytes of an end of a line: position, normal (3 × `f32` each), texture coordinate (2 × `f32`), opacity.
pub(super) const LINE_BYTES: u32 = 36;

/// The bytes of an end of a line.
pub(super) fn line_bytes(vertex: &BranchVertex) -> impl Iterator<Item = u8> {
    let [x, y, z] = vertex.position.to_array();
    let [nx, ny, nz] = vertex.normal.to_array();
    let [u, v] = vertex.texture.to_array();
    let floats = [x, y, z, nx, ny, nz, u, v, vertex.alpha];
    floats.into_iter().flat_map(f32::to_le_bytes)
}

/// How an instance is seen and lit.
pub(super) struct Seen {
    pub(super) view: View,
    pub(super) placement: Placement,
    viewer: Viewer,
}

impl Seen {
    pub(super) fn of(call: &VertexCall<'_>) -> Self {
        let view = View::read(call.bindings.storage(VIEW_SLOT as usize));
        let placements = call.bindings.storage(INSTANCE_SLOT as usize);
        Self {
            viewer: Viewer::of(&view.clip_from_world),
            placement: Placement::from_words(placements.f32s(8 * call.instance as usize)),
            view,
        }
    }

    /// Emits a line, as opaque as it covers pixels where that is asked for, with what light falls on its ends: of
    /// a cylinder what its side has, else the cosine to
    /// the normal, also below 0, so that what lies between is that of a normal between.
    ///
    /// `ids` are the numbers of its ends.
    pub(super) fn line(
        &self,
        ends: &[BranchVertex; 2],
        ids: [u32; 2],
        parameters: &Parameters,
        geometry: &mut Geometry,
    ) {
        let world = [0, 1].map(|end: usize| self.placement.to_world(ends[end].position));
        let axis = world[1] - world[0];
        let first = index_u32(geometry.clip.len());
        for end in 0..2 {
            let vertex = &ends[end];
            let toward = match parameters.lines {
                BranchLines::Round => {
                    let to_light = self.view.to_light;
                    self.viewer.light_on_cylinder(world[end], axis, to_light)
                }
                BranchLines::One | BranchLines::Three => {
                    let normal = self.placement.rotation * vertex.normal;
                    normal.dot(self.view.to_light)
                }
            };
            let clip = self.view.clip_from_world * world[end].extend(1.0);
            geometry.clip.push(clip);
            let [u, v] = vertex.texture.to_array();
            let alpha = match parameters.alpha {
                LineAlpha::Paper | LineAlpha::Coverage { .. } => vertex.alpha,
                // A width, of which a pixel at this depth has so much.
                LineAlpha::Width => {
                    let width = vertex.alpha * self.placement.scale * parameters.pixels;
                    let covered = (width / clip.w.max(f32::MIN_POSITIVE)).min(1.0);
                    parameters.normals().share(covered)
                }
            };
            geometry.varyings.extend([u, v, alpha, toward]);
            geometry.vertex_ids.push(ids[end]);
        }
        geometry.corners.extend([first, first + 1]);
    }
}

/// The program that draws lines from buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::models) struct LineProgram;

impl Program for LineProgram {
    fn layout(&self) -> Layout {
        Layout {
            name: "branch lines",
            version: 1,
            topology: Topology::LineList,
            blend: Blend::Alpha,
            vertex_stride: LINE_BYTES,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 4,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let seen = Seen::of(call);
        let parameters = Parameters::read(call.bindings.storage(PARAMETER_SLOT as usize));
        let vertices = call.bindings.vertices();
        for &ids in call.corners.as_chunks::<2>().0 {
            let ends = ids.map(|vertex| read(vertices, vertex));
            seen.line(&ends, ids, &parameters, geometry);
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        line_fragments(bindings)
    }
}

fn read(vertices: Words<'_>, vertex: u32) -> BranchVertex {
    let [x, y, z, nx, ny, nz, u, v, alpha] =
        vertices.f32s(LINE_BYTES as usize / 4 * vertex as usize);
    BranchVertex {
        position: Vec3::new(x, y, z),
        normal: Vec3::new(nx, ny, nz),
        texture: Vec2::new(u, v),
        alpha,
    }
}

/// The fragment stage of all programs of lines.
pub(super) fn line_fragments<'a>(bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
    let [r, g, b, _] = bindings.storage(SURFACE_SLOT as usize).f32s(0);
    Box::new(LineFragment {
        texture: bindings.texture(0),
        base_color: Vec3::new(r, g, b),
        lighting: Lighting::of(bindings),
    })
}

/// As wood is shaded, with the light that the vertex stage found and the line's opacity.
#[derive(Debug)]
struct LineFragment<'a> {
    texture: Option<&'a MipMap>,
    base_color: Vec3,
    lighting: Lighting<'a>,
}

impl Fragment for LineFragment<'_> {
    const VARYINGS: usize = 4;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        let texels = if self.texture.is_some() { 4 } else { 0 };
        texels + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [u, v, alpha, toward, ..] = *pixel.varyings;
        let texel = self.texture.map_or(Vec3::ONE, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            let texel = texture.sample(Vec2::new(u, v), level, Wrap::Repeat);
            texel.truncate()
        });
        let light = self.lighting.at(toward.max(0.0), pixel);
        (self.base_color * texel * light).extend(alpha)
    }
}
