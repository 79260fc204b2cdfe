//! The program that draws a grove's lines, in each of the ways in which they meet what is behind them.

use super::hashed::HashedFragment;
use super::program::{MATERIAL_SLOT, color_of, seen};
use super::veil::VeilFragment;
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, Pixel, Program, Topology, VertexCall,
};
use crate::math::{Vec3, Vec4, index_u32};
use crate::models::branches::Viewer;
use crate::models::shadow::Lighting;

/// The slot of what some stages know of the view: how many pixels a metre spans a metre away, the nearest and
/// the farthest depth of a patch in metres, nothing (4 × `f32`).
pub(super) const RANGE_SLOT: u32 = 3;

/// Words of an end of a line.
const LINE_WORDS: usize = 8;

/// What becomes of a line's fragments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LineStage {
    /// Blended in the order of drawing; depth is written.
    WritesDepth,
    /// Blended in the order of drawing.
    KeepsDepth,
    /// Blended by depth.
    Sorted,
    /// There or not, as a hash says.
    Hashed,
    /// There in as many samples as the opacity says.
    Coverage,
    /// The nearest behind what was peeled before.
    Peel,
    /// Colours added up, weighted by depth and opacity.
    Weigh,
    /// What shines through, multiplied.
    Reveal,
    /// Absorbances added up.
    Absorb,
    /// Moments of absorbances added up.
    Gather,
    /// Colours added up, weighted by what moments say of the light that reaches them.
    Reconstruct,
}

impl LineStage {
    fn name(self) -> &'static str {
        match self {
            Self::WritesDepth => "grove lines, writing depth",
            Self::KeepsDepth => "grove lines",
            Self::Sorted => "grove lines, sorted",
            Self::Hashed => "grove lines, hashed",
            Self::Coverage => "grove lines, as coverage",
            Self::Peel => "grove lines, peeled",
            Self::Weigh => "grove lines, weighted",
            Self::Reveal => "grove lines, revealing",
            Self::Absorb => "grove lines, absorbing",
            Self::Gather => "grove lines, as moments",
            Self::Reconstruct => "grove lines, by moments",
        }
    }

    fn blend(self) -> Blend {
        match self {
            Self::WritesDepth => Blend::AlphaAndDepth,
            Self::KeepsDepth | Self::Reveal => Blend::Alpha,
            Self::Sorted => Blend::Sorted,
            Self::Hashed | Self::Coverage | Self::Peel => Blend::Opaque,
            Self::Weigh | Self::Absorb | Self::Gather | Self::Reconstruct => Blend::Add,
        }
    }
}

/// The program of lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct GroveLines {
    pub(super) stage: LineStage,
}

impl Program for GroveLines {
    fn layout(&self) -> Layout {
        let reads_range = matches!(
            self.stage,
            LineStage::Hashed | LineStage::Gather | LineStage::Reconstruct
        );
        Layout {
            name: self.stage.name(),
            version: 1,
            topology: Topology::LineList,
            blend: self.stage.blend(),
            vertex_stride: index_u32(4 * LINE_WORDS),
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: if reads_range {
                RANGE_SLOT + 1
            } else {
                RANGE_SLOT
            },
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let (view, placement) = seen(call);
        let viewer = Viewer::of(&view.clip_from_world);
        let materials = call.bindings.storage(MATERIAL_SLOT as usize);
        let focal_pixels = call.bindings.storage(RANGE_SLOT as usize).f32(0);
        let places = call.places.as_chunks::<2>().0;
        for (ids, places) in call.corners.as_chunks::<2>().0.iter().zip(places) {
            let words = places.map(|place| LINE_WORDS * place as usize);
            let own = words.map(|word| Vec3::from_array(call.vertices.f32s(word)));
            let world = own.map(|point| placement.to_world(point));
            let clip = world.map(|point| view.clip_from_world * point.extend(1.0));
            let axis = world[1] - world[0];
            let first = index_u32(geometry.clip.len());
            for (end, (&id, word)) in ids.iter().zip(words).enumerate() {
                let alpha = call.vertices.f32(word + 6);
                let toward = viewer.light_on_cylinder(world[end], axis, view.to_light);
                let color = color_of(materials, call.vertices.u32(word + 7));
                geometry.clip.push(clip[end]);
                geometry.varyings.extend(color.to_array());
                geometry.varyings.extend([alpha, toward]);
                match self.stage {
                    LineStage::WritesDepth
                    | LineStage::KeepsDepth
                    | LineStage::Sorted
                    | LineStage::Coverage => {}
                    LineStage::Hashed => geometry.varyings.extend(own[end].to_array()),
                    LineStage::Peel
                    | LineStage::Weigh
                    | LineStage::Reveal
                    | LineStage::Absorb
                    | LineStage::Gather
                    | LineStage::Reconstruct => geometry.varyings.push(clip[end].w),
                }
                geometry.vertex_ids.push(id);
            }
            geometry.corners.extend([first, first + 1]);
            if self.stage == LineStage::Hashed {
                // Metres of the patch a pixel, in the middle of the line.
                let away = 0.5 * (clip[0].w + clip[1].w);
                let metres = away.max(NEAREST) / (focal_pixels * placement.scale);
                geometry.flats.push(metres);
            }
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        match self.stage {
            LineStage::WritesDepth | LineStage::KeepsDepth | LineStage::Sorted => {
                Box::new(LineFragment {
                    lighting: Lighting::of(bindings),
                })
            }
            LineStage::Coverage => Box::new(CoverageFragment {
                lighting: Lighting::of(bindings),
            }),
            LineStage::Hashed => Box::new(HashedFragment {
                lighting: Lighting::of(bindings),
            }),
            stage => Box::new(VeilFragment::new(stage, bindings)),
        }
    }
}

/// No line is nearer than this, in metres, where sizes of pixels are concerned.
const NEAREST: f32 = 0.01;

/// What a line shows at a pixel: its colour, lit, and its opacity.
pub(super) fn line_colour(lighting: &Lighting<'_>, pixel: &Pixel<'_>) -> Vec4 {
    let [r, g, b, alpha, toward, ..] = *pixel.varyings;
    let light = lighting.at(toward.max(0.0), pixel);
    (Vec3::new(r, g, b) * light).extend(alpha)
}

/// As polygons are shaded, with the light that the vertex stage found and the line's opacity.
#[derive(Debug)]
struct LineFragment<'a> {
    lighting: Lighting<'a>,
}

impl Fragment for LineFragment<'_> {
    const VARYINGS: usize = 5;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn texels_shaded(&self) -> u64 {
        self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        line_colour(&self.lighting, pixel)
    }
}

/// Opaque in as many samples of a pixel as the opacity says, and the same ones for every line of that opacity.
#[derive(Debug)]
struct CoverageFragment<'a> {
    lighting: Lighting<'a>,
}

impl Fragment for CoverageFragment<'_> {
    const VARYINGS: usize = 5;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;
    const COVERAGE: bool = true;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        self.alpha(pixel) >= 0.5
    }

    fn alpha(&self, pixel: &Pixel<'_>) -> f32 {
        pixel.varyings[3]
    }

    fn texels_shaded(&self) -> u64 {
        self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        line_colour(&self.lighting, pixel)
    }
}
