//! Programs: the stages of a draw, and what they may read.

use super::reads::ReadSet;
use super::resource::Buffer;
use super::{BufferId, ColourMap, DepthMap};
use crate::math::{Mat4, Vec3};
use crate::raster::{Blend, Geometry, Instructions, Kernel, MipMap, Topology};

/// The most storage buffers or textures of a program.
pub const MAX_SLOTS: usize = 16;

/// A vertex stage and a fragment stage, with a stable identity. Parameters are bytes in buffers.
pub trait Program: Send + Sync + std::fmt::Debug {
    /// What the program needs and how it draws.
    fn layout(&self) -> Layout;

    /// The vertex stage: turns `call.corners` into clip-space vertices and primitives. It may leave
    /// primitives out; they then cost their vertices and no more.
    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry);

    /// The fragment stage with what it reads.
    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a>;

    /// Where primitives may lie, told without the vertex stage; a program that cannot tell is drawn in
    /// full, seen or not.
    fn hulls(&self) -> Option<&dyn Hulls> {
        None
    }
}

/// Tells where the primitives of a program may lie.
pub trait Hulls: Sync {
    /// The storage slots, beside the vertices and indices, on which [`bounds`](Self::bounds) depends.
    fn slots(&self) -> Vec<u32>;

    /// The least and the greatest corner of a box around all vertices that these corners may emit,
    /// whatever the view and the instance.
    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2];

    /// What takes that box to clip space for an instance.
    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform;
}

/// From the space of a box to clip space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Columns of the matrix.
    pub columns: [[f64; 4]; 4],
    /// How far the vertex stage may round away from it: so much, and so much a unit of the sum of a
    /// point's absolute coordinates.
    pub slack: [[f64; 4]; 2],
}

/// What a program needs and how it draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// A stable name.
    pub name: &'static str,
    /// Counts up when the program computes anything else.
    pub version: u32,
    /// How corners connect.
    pub topology: Topology,
    /// How fragments meet what is there.
    pub blend: Blend,
    /// Bytes of one vertex in the bound vertex buffer; 0 when the program pulls vertices from
    /// storage.
    pub vertex_stride: u32,
    /// Bytes that the vertex stage pulls from storage for each primitive that it looks at; only the
    /// modelled time on the card depends on it.
    pub pulled_primitive_bytes: u32,
    /// The same for each vertex that it emits.
    pub pulled_vertex_bytes: u32,
    /// How many storage slots must be bound, from 0.
    pub storage_slots: u32,
    /// How many texture slots must be bound, from 0.
    pub texture_slots: u32,
}

impl Transform {
    /// Of a vertex stage that computes `clip · (place · (p, 1))` in `f32`, each product and sum rounded.
    #[must_use]
    pub fn of_product(clip: Mat4, place: Mat4) -> Self {
        let wide = |matrix: Mat4| {
            let columns = matrix.to_cols_array_2d();
            columns.map(|column| column.map(f64::from))
        };
        Self::of_columns(wide(clip), wide(place))
    }

    /// The same of columns that are as exact as the vertex stage means them.
    #[must_use]
    pub fn of_columns(clip: [[f64; 4]; 4], place: [[f64; 4]; 4]) -> Self {
        // Some forty operations, each rounded by 2⁻²⁴ of at most a few times the sum of absolutes.
        const ROUNDING: f64 = 1.0 / (1 << 17) as f64;
        let product = |column: [f64; 4]| {
            std::array::from_fn(|row| (0..4).map(|k| clip[k][row] * column[k]).sum::<f64>())
        };
        let largest = (0..9)
            .map(|at| place[at / 3][at % 3].abs())
            .fold(0.0, f64::max);
        let moved: f64 = place[3][..3].iter().map(|at| at.abs()).sum();
        let size = |row: usize| -> f64 { clip[..3].iter().map(|column| column[row].abs()).sum() };
        Self {
            columns: place.map(product),
            slack: [
                std::array::from_fn(|row| ROUNDING * (size(row) * moved + clip[3][row].abs())),
                std::array::from_fn(|row| ROUNDING * size(row) * largest),
            ],
        }
    }
}

/// A run of primitives for the vertex stage.
#[derive(Debug, Clone, Copy)]
pub struct VertexCall<'a> {
    /// The vertex index of each corner: whole primitives.
    pub corners: &'a [u32],
    /// Where each corner's vertex lies among [`vertices`](Self::vertices).
    pub places: &'a [u32],
    /// The bound vertices, or copies of those that are drawn, in the order in which they are drawn: nearer
    /// to one another than in their buffer, to the same bits.
    pub vertices: Words<'a>,
    /// The instance.
    pub instance: u32,
    /// What is bound.
    pub bindings: &'a Bindings<'a>,
    /// Which instructions the stage may use; what it emits must not depend on them.
    pub instructions: Instructions,
}

/// What a draw has bound.
#[derive(Debug, Clone, Copy, Default)]
pub struct Bindings<'a> {
    pub(super) vertices: Words<'a>,
    pub(super) storage: [Option<Words<'a>>; MAX_SLOTS],
    pub(super) textures: [Option<&'a MipMap>; MAX_SLOTS],
    pub(super) depths: [Option<DepthMap<'a>>; MAX_SLOTS],
    pub(super) colours: [Option<ColourMap<'a>>; MAX_SLOTS],
}

impl<'a> Bindings<'a> {
    /// The bound vertex buffer.
    #[must_use]
    pub fn vertices(&self) -> Words<'a> {
        self.vertices
    }

    /// A storage buffer; reads as zeros where nothing is bound.
    #[must_use]
    pub fn storage(&self, slot: usize) -> Words<'a> {
        self.storage
            .get(slot)
            .copied()
            .flatten()
            .unwrap_or_default()
    }

    /// A texture, where one is bound; the program's [`Layout::texture_slots`] always are.
    #[must_use]
    pub fn texture(&self, slot: usize) -> Option<&'a MipMap> {
        self.textures.get(slot).copied().flatten()
    }

    /// The depth of a target, where one is bound.
    #[must_use]
    pub fn depth(&self, slot: usize) -> Option<DepthMap<'a>> {
        self.depths.get(slot).copied().flatten()
    }

    /// The colour of a target, where one is bound.
    #[must_use]
    pub fn colour(&self, slot: usize) -> Option<ColourMap<'a>> {
        self.colours.get(slot).copied().flatten()
    }
}

/// A buffer as little-endian words; reading past the end gives 0.
#[derive(Debug, Clone, Copy, Default)]
pub struct Words<'a> {
    bytes: &'a [u8],
    tracked: Option<(BufferId, &'a ReadSet)>,
}

impl<'a> Words<'a> {
    pub(super) fn of(id: BufferId, buffer: &'a Buffer, reads: Option<&'a ReadSet>) -> Self {
        Self {
            bytes: &buffer.bytes,
            tracked: reads.map(|reads| (id, reads)),
        }
    }

    /// Bytes that are in no buffer.
    pub(super) fn of_bytes(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            tracked: None,
        }
    }

    /// How many whole words there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bytes.len() / 4
    }

    /// Whether there is no word.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The word at `index` as an integer.
    #[must_use]
    #[inline]
    pub fn u32(&self, index: usize) -> u32 {
        u32::from_le_bytes(self.read::<1>(index)[0])
    }

    /// The word at `index` as a float.
    #[must_use]
    #[inline]
    pub fn f32(&self, index: usize) -> f32 {
        f32::from_le_bytes(self.read::<1>(index)[0])
    }

    /// `N` words from `index` on as integers.
    #[must_use]
    #[inline]
    pub fn u32s<const N: usize>(&self, index: usize) -> [u32; N] {
        self.read(index).map(u32::from_le_bytes)
    }

    /// `N` words from `index` on as floats.
    #[must_use]
    #[inline]
    pub fn f32s<const N: usize>(&self, index: usize) -> [f32; N] {
        self.read(index).map(f32::from_le_bytes)
    }

    #[inline]
    fn read<const N: usize>(&self, index: usize) -> [[u8; 4]; N] {
        if let Some((buffer, reads)) = self.tracked {
            reads.mark(buffer, 4 * index..4 * (index + N));
        }
        let within = self.bytes.get(4 * index..4 * (index + N));
        if let Some(words) = within.and_then(|bytes| bytes.as_chunks().0.first_chunk()) {
            return *words;
        }
        let from = self.bytes.get(4 * index..).unwrap_or_default();
        std::array::from_fn(|word| from.as_chunks().0.get(word).copied().unwrap_or_default())
    }
}
