//! The ground behind everything: one quad over the whole target.

use super::fragment::ground_at;
use super::program::{GROUND_SLOT, PAINTING_SLOT};
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, MipMap, Pixel, Program, Topology,
    VertexCall,
};
use crate::math::{Vec3, Vec4, index_u32};
use crate::scene::PaintLook;

/// Lightens and darkens what the target was cleared to, as canvas or paper would.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BackdropProgram {
    pub(super) look: PaintLook,
}

/// Behind all else, and before what a cleared target has.
const DEPTH: f32 = 1.0 - 1.0 / 1_048_576.0;

impl Program for BackdropProgram {
    fn layout(&self) -> Layout {
        Layout {
            name: match self.look {
                PaintLook::Oil => "canvas",
                PaintLook::Watercolour => "paper",
            },
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Alpha,
            vertex_stride: 0,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: PAINTING_SLOT + 1,
            texture_slots: GROUND_SLOT + 1,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        const CORNERS: [[f32; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for (corner, &id) in call.corners.iter().enumerate() {
            let [x, y] = CORNERS[corner % 4];
            geometry.corners.push(index_u32(geometry.clip.len()));
            geometry.clip.push(Vec4::new(x, y, DEPTH, 1.0));
            geometry.vertex_ids.push(id);
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(Backdrop {
            look: self.look,
            grain: bindings.storage(PAINTING_SLOT as usize).f32(5),
            ground: bindings.texture(GROUND_SLOT as usize),
        })
    }
}

#[derive(Debug)]
struct Backdrop<'a> {
    look: PaintLook,
    grain: f32,
    ground: Option<&'a MipMap>,
}

impl Fragment for Backdrop<'_> {
    const VARYINGS: usize = 0;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        1
    }

    /// White or a dark, as much as the ground there is lighter or darker than the background.
    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some(ground) = self.ground else {
            return Vec4::ZERO;
        };
        let Vec3 {
            y: lit, z: tone, ..
        } = ground_at(ground, pixel.position);
        let (brushed, relief) = match self.look {
            PaintLook::Oil => (0.62, 0.8),
            PaintLook::Watercolour => (0.08, 0.42),
        };
        let change = brushed * (tone - 0.5) + relief * self.grain * (lit - 0.5);
        if change > 0.0 {
            Vec4::new(1.0, 0.96, 0.86, change.min(1.0))
        } else {
            Vec4::new(0.16, 0.15, 0.22, (-change).min(1.0))
        }
    }
}
