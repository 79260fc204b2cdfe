//! Draws what lines left in targets of their own over the frame: one quad over all of it.

use crate::gpu::{
    Bindings, Blend, ColourMap, Fragment, Geometry, Kernel, Layout, Pixel, Program, Topology,
    VertexCall,
};
use crate::math::{Vec4, det, index_u32};

/// What the targets hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CompositeKind {
    /// A colour and its opacity.
    Layer,
    /// Sums of weighted colours and of their weights; what shines through.
    Weighted,
    /// The same sums; the sum of absorbances.
    Moments,
}

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Composite {
    pub(super) kind: CompositeKind,
}

impl Program for Composite {
    fn layout(&self) -> Layout {
        Layout {
            name: match self.kind {
                CompositeKind::Layer => "grove layer",
                CompositeKind::Weighted => "grove sums",
                CompositeKind::Moments => "grove sums by moments",
            },
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Alpha,
            vertex_stride: 0,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: 0,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        const CORNERS: [[f32; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for (corner, &id) in call.corners.iter().enumerate() {
            let [x, y] = CORNERS[corner % 4];
            geometry.corners.push(index_u32(geometry.clip.len()));
            // Before all else: what is hidden was left out already.
            geometry.clip.push(Vec4::new(x, y, 0.0, 1.0));
            geometry.vertex_ids.push(id);
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(CompositeFragment {
            kind: self.kind,
            targets: [bindings.colour(0), bindings.colour(1)],
        })
    }
}

#[derive(Debug)]
struct CompositeFragment<'a> {
    kind: CompositeKind,
    targets: [Option<ColourMap<'a>>; 2],
}

impl Fragment for CompositeFragment<'_> {
    const VARYINGS: usize = 0;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        match self.kind {
            CompositeKind::Layer => 1,
            CompositeKind::Weighted | CompositeKind::Moments => 2,
        }
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let [sums, rest] = self
            .targets
            .map(|target| target.map_or(Vec4::ZERO, |target| target.colour(pixel.position)));
        let alpha = match self.kind {
            CompositeKind::Layer => return sums,
            CompositeKind::Weighted => 1.0 - rest.x,
            CompositeKind::Moments => 1.0 - det::exp(-rest.w),
        };
        if sums.w > 0.0 {
            (sums.truncate() / sums.w).extend(alpha)
        } else {
            Vec4::ZERO
        }
    }
}
