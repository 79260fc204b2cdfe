//! The program that draws lines of width 1, blended in their order.

use spinney::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, Pixel, Program, Topology, VertexCall,
};
use spinney::math::Vec4;

/// Draws lines whose ends have 12 bytes: x and y in normalised device coordinates (2 × `f32`), and
/// R, G, B, A (4 × `u8`), interpolated along the line as the peers do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BlendedLines;

impl Program for BlendedLines {
    fn layout(&self) -> Layout {
        Layout {
            name: "peer-lines",
            version: 1,
            topology: Topology::LineList,
            blend: Blend::Alpha,
            vertex_stride: 12,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 0,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let vertices = call.bindings.vertices();
        let ends = call.corners.len();
        geometry.clip.reserve(ends);
        geometry.vertex_ids.reserve(ends);
        geometry.corners.reserve(ends);
        geometry.varyings.reserve(4 * ends);
        for (number, &corner) in (0..).zip(call.corners) {
            let [x, y, rgba] = vertices.u32s(3 * corner as usize);
            let (x, y) = (f32::from_bits(x), f32::from_bits(y));
            geometry.clip.push(Vec4::new(x, y, 0.5, 1.0));
            let channels = rgba.to_le_bytes().map(|channel| f32::from(channel) / 255.0);
            geometry.varyings.extend(channels);
            geometry.vertex_ids.push(corner);
            geometry.corners.push(number);
        }
    }

    fn fragment_stage<'a>(&self, _bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(LineFragment)
    }
}

#[derive(Debug)]
struct LineFragment;

impl Fragment for LineFragment {
    const VARYINGS: usize = 4;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const FROM_VARYINGS: bool = true;

    fn keeps(&self, _pixel: &Pixel<'_>) -> bool {
        true
    }

    #[inline]
    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [r, g, b, a, ..] = *pixel.varyings;
        Vec4::new(r, g, b, a)
    }
}
