//! Triangles to tiles to pixels, with the same bits on any machine and any number of threads.
//!
//! ```text
//! Batch (parts of primitives, kernel) ─reach─▶ pieces ─bin─▶ tiles ─set up what is not hidden─▶ triangles
//!   ─cover─▶ visibility (depth, primitive) ─shade─▶ colour ─resolve─▶ Image
//! ```
//!
//! This stage knows neither buffers nor buses nor trees: it is handed vertices after the vertex
//! stage, and a [`Kernel`] that tests alpha and computes colour.
//!
//! **Invariant.** What a sample ends up with is a function of the triangles over it, their keys and,
//! for blended ones, their order: never of tiles, threads, or how draws are cut into batches.
//!
//! # The rule book
//!
//! The rules are those of Direct3D 11 and Vulkan ([D3D11](crate::references),
//! [VK](crate::references)); where these leave room, the text below fills it. A change of any rule
//! changes pictures.
//!
//! *Corners.* A triangle is first turned, its winding kept, so that its lowest vertex id comes
//! first. So lists, strips and quads of the same triangles give the same bits.
//!
//! *Clipping.* A primitive with a coordinate that is infinite or no number is dropped. Others are cut,
//! in `f64`, at `w ≥ 2⁻⁴⁰`, `z ≥ 0`, `z ≤ w` and a guard band of 2¹⁴ pixels around the middle of the
//! target, in this order; what is left of a triangle is a fan around its first corner. Nothing is
//! culled: triangles have two sides, and the *front* is the one seen counter-clockwise with y
//! upwards.
//!
//! *Snapping.* With `h` half the target in sub-pixels, of which 256 make a pixel, x becomes
//! `h + (x · (1 / w)) · h` and y `h − (y · (1 / w)) · h`, computed in `f64` and rounded to the nearest
//! sub-pixel, halves to the even one. All that follows knows only snapped corners.
//!
//! *Coverage.* A sample is covered when all three edge functions, exact integers, are positive there,
//! or 0 on a top or a left edge. So every sample within a mesh is covered once. One sample lies in
//! the middle of its pixel; four lie on the rotated grid of [`Samples::offsets`].
//!
//! *Lines* are the rectangles of width 1 around them, ends cut square, snapped and covered like two
//! triangles; attributes are those of the nearest point along the line.
//!
//! *Depth* is `z · (1 / w)` at a corner, rounded to `f32`, kept within [0, 1]. At a sample it is
//! `d₀ + (e₁ s₁ + e₂ s₂)` in `f32`, kept within [0, 1], with the edge functions that face the second
//! and third corner, each rounded once, and `sᵢ = (dᵢ − d₀) · (1 / (2 area))`. Depths compare as
//! their bits.
//!
//! *Attributes* `a` are interpolated as `a · (1 / w)` by a plane of the same form, at the pixel's
//! centre, never step by step, and multiplied by one over the plane of `1 / w`. The first two have
//! derivatives by the quotient rule. With four samples the centre may lie outside of the triangle:
//! then attributes are extrapolated.
//!
//! *Alpha* is tested once a pixel and triangle, at the centre, for all of the pixel's samples. A
//! fragment stage may make it coverage instead: of four samples the first is there from an alpha of
//! 0.125 on, the fourth, which lies opposite, from 0.375, the third from 0.625, the second from 0.875;
//! of one sample from 0.5. Blended fragments are always tested.
//!
//! *Moved depth.* A fragment stage may add an offset to the depth of opaque fragments: asked once a
//! pixel and triangle, at the centre, cut at the bound that the stage gives towards the eye, 0 where it
//! is no number, added in `f32` to the triangle's depth at each sample, and the sum kept within [0, 1].
//! Clipping knows only triangles.
//!
//! *Opaque* fragments win where they are nearer; where depths are equal, the least [`Key`] wins, also
//! against what earlier calls left. A cleared sample has no key, and is not beaten by its own depth.
//! Equal depth and equal key, which only primitives that begin with the same vertex have: within a
//! call the one whose further vertices are the least, in their order, else the one that was submitted
//! first. So batches commute. Consecutive opaque batches are a run: it is decided
//! as a whole, then each pixel is shaded once for each triangle that shows in it.
//!
//! *Blended* fragments keep their order, are tested against the depth that is there, and must be nearer;
//! [some](Blend::AlphaAndDepth) then write theirs, which then nothing shows at, as after a clear: no key
//! belongs to it. [Sorted](Blend::Sorted) ones are tested as they come and blended by descending depth when
//! their run ends, equally deep ones in their order.
//!
//! *Colour* is linear `f32` at every sample. Four samples resolve to `((a + b) + (c + d)) / 4`; a byte
//! is the one whose linear value is nearest as seen in sRGB.

mod bin;
mod boxes;
mod by_sample;
mod candidates;
mod clip;
mod colour;
mod cover;
mod cover_lanes;
mod depth_only;
mod even_lines;
mod frame;
mod items;
mod kernel;
mod lanes;
mod layer;
mod layers;
mod line_blend;
mod line_records;
mod lines;
mod pass;
mod passes;
mod piece;
mod pixels;
mod plane;
mod probe;
mod project;
mod reach;
mod setup;
mod shade;
mod shade_lanes;
mod source;
mod squares;
mod texel;
mod texture;
mod texture_lanes;
mod tile;
mod view;
mod works;
mod wrap;

pub use colour::decode_srgb;
pub use frame::{Image, Target};
pub use kernel::{Fragment, Kernel, MAX_FLATS, MAX_VARYINGS, Pixel, PixelLanes};
pub use lanes::Instructions;
pub use layer::TargetLayer;
pub use pass::{Machine, Options, Rendered, Skips, render, render_on};
pub use probe::{ProbedFragment, probe};
pub use source::{ALL, Boxes, Hull, PART, Part, Source, nth};
pub use texel::TextureFormat;
pub use texture::MipMap;
pub use wrap::Wrap;

use crate::math::Vec4;

/// How corners become primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topology {
    /// Three corners a triangle.
    TriangleList,
    /// Four corners a leaf: triangles 0-1-2 and 0-2-3.
    QuadList,
    /// Two corners a line of width 1.
    LineList,
}

/// What the vertex stage hands over: vertices in clip space and how they connect.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Geometry {
    /// Clip-space positions.
    pub clip: Vec<Vec4>,
    /// [`Fragment::VARYINGS`] floats a vertex, interpolated perspective-correctly.
    pub varyings: Vec<f32>,
    /// The index that each vertex has in its vertex buffer: decides ties and the order of corners,
    /// never where something is drawn.
    pub vertex_ids: Vec<u32>,
    /// Indices into `clip`, as many a primitive as the topology says.
    pub corners: Vec<u32>,
    /// [`Fragment::FLATS`] floats a primitive, constant over it.
    pub flats: Vec<f32>,
}

/// How fragments meet the colour that is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Blend {
    /// The nearest fragment wins, whatever the order of drawing; writes depth.
    Opaque,
    /// `source · alpha + destination · (1 − alpha)` in linear colour, in submission order, where
    /// the fragment is nearer than the depth that is there; writes no depth.
    Alpha,
    /// The same, and writes depth: of what comes later, what lies behind is lost.
    AlphaAndDepth,
    /// As `Alpha`, but of consecutive batches that blend so all fragments together, at every sample the
    /// farthest first: what blending in order is an approximation of. Equally far ones keep their order.
    Sorted,
    /// `source + destination` in linear colour and alpha, as they come, where the fragment is nearer than
    /// the depth that is there; writes no depth.
    Add,
}

/// A part of a draw, ready to be rasterized.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// The vertices and corners.
    pub geometry: &'a dyn Source,
    /// How corners connect.
    pub topology: Topology,
    /// The fragment stage with its textures and constants.
    pub kernel: &'a dyn Kernel,
    /// How it meets what is there.
    pub blend: Blend,
    /// First part of the key that breaks ties of depth.
    pub group: u32,
    /// Second part of the key.
    pub instance: u32,
}

/// What shows at a sample: the key by which ties of depth are broken, least first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// The batch's group.
    pub group: u32,
    /// The batch's instance.
    pub instance: u32,
    /// The vertex id of the primitive's first corner.
    pub vertex: u32,
    /// The triangle within the primitive: 0 or 1 in a quad, else 0.
    pub triangle: u32,
}

/// Samples a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Samples {
    /// One, at the centre.
    One,
    /// Four, in the standard rotated grid.
    Four,
}

impl Samples {
    /// How many there are.
    #[must_use]
    pub fn count(self) -> usize {
        self.offsets().len()
    }

    /// Where they are in their pixel, in sub-pixels from its top-left corner: x, then y.
    #[must_use]
    pub fn offsets(self) -> &'static [[i32; 2]] {
        match self {
            Self::One => &[[128, 128]],
            Self::Four => &[[96, 32], [224, 96], [32, 160], [160, 224]],
        }
    }
}

/// How much of a target is decided at a time; no picture depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TileSize {
    /// 32 × 32 pixels.
    Side32,
    /// 64 × 64 pixels.
    Side64,
}

impl TileSize {
    fn side(self) -> u32 {
        match self {
            Self::Side32 => 32,
            Self::Side64 => 64,
        }
    }
}

/// Which counters of [`Work`] are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counters {
    /// `visible` alone; the others stay 0, and work that changes no picture is left out.
    Visible,
    /// All: every sample is rasterized, whatever hides it.
    Exact,
}

/// What was done, in samples; the same for any number of threads and tile size when `exact`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Samples of opaque batches that are visible when the pass ends, and samples of blended
    /// batches that passed the depth test. Architectural: no optimisation may change it.
    pub visible: u64,
    /// Samples inside a triangle, before any test.
    pub covered: u64,
    /// Of those, the ones whose pixel failed the alpha test.
    pub alpha_killed: u64,
    /// Texels read by alpha tests and shading.
    pub texels: u64,
}
