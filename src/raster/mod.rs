//! Triangles to tiles to pixels, with the same bits on any machine and any number of threads.
//!
//! ```text
//! Batch (clip-space vertices, corners, kernel) ─setup─▶ triangles ─bin─▶ tiles
//!   ─cover─▶ visibility (depth, primitive) ─shade─▶ colour ─resolve─▶ Image
//! ```
//!
//! This stage knows neither buffers nor buses nor trees: it is handed vertices after the vertex
//! stage, and a [`Kernel`] that tests alpha and computes colour.

mod bin;
mod clip;
mod colour;
mod cover;
mod frame;
mod kernel;
mod pass;
mod plane;
mod setup;
mod shade;
mod texture;
mod tile;

pub use frame::{Image, Target};
pub use kernel::{Fragment, Kernel, MAX_FLATS, MAX_VARYINGS, Pixel};
pub use pass::{Options, render};
pub use texture::{MipMap, Wrap};

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
    /// the fragment is nearer than what opaque batches left; writes no depth.
    Alpha,
}

/// A part of a draw, ready to be rasterized.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// The vertices and corners.
    pub geometry: &'a Geometry,
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
