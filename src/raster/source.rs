//! Where primitives come from: ready, or made part by part when a tile needs them.

use std::borrow::Cow;
use std::ops::Range;

use super::{Geometry, Topology};

/// The most primitives of a part: few enough that what hides one is likely to hide all, enough that
/// asking pays.
pub const PART: usize = 64;

/// The primitives of a batch, in parts.
///
/// What a part is must not depend on when, how often and on which thread it is asked for.
pub trait Source: Sync + std::fmt::Debug {
    /// How many parts there are.
    fn parts(&self, topology: Topology) -> usize;

    /// Where the primitives of a part may show, as far as that is known without making them.
    fn hull(&self, _part: usize) -> Option<Hull> {
        None
    }

    /// Where each primitive of a part lies within its hull, where that is known too.
    fn boxes(&self, _part: usize) -> Option<&Boxes> {
        None
    }

    /// Makes those of the at most [`PART`] primitives of a part that have a bit in `wanted`; others may be
    /// left out. May take over the memory of a geometry that nobody needs any more.
    fn part(&self, part: usize, topology: Topology, wanted: u64, spare: Geometry) -> Part<'_>;

    /// The place in the order of submission of a primitive of the geometry that was made of a part for
    /// these `wanted`.
    fn place(&self, part: usize, wanted: u64, primitive: usize) -> usize {
        PART * part + nth(wanted, primitive)
    }
}

/// All primitives of a part.
pub const ALL: u64 = u64::MAX;
const _: () = assert!(PART == 64, "primitives of a part are told by bits");

/// The number of the bit that has so many others below it.
#[must_use]
pub fn nth(wanted: u64, number: usize) -> usize {
    let mut rest = wanted;
    for _ in 0..number {
        rest &= rest.wrapping_sub(1);
    }
    rest.trailing_zeros() as usize
}

/// Boxes around the primitives of a part, axis by axis: points of a primitive lie no further from the
/// middle of its box than the halves of the box's sides. Primitives that are not there have any.
#[derive(Debug, Clone, PartialEq)]
pub struct Boxes {
    /// The middles.
    pub middle: [[f32; PART]; 3],
    /// Halves of the sides.
    pub half: [[f32; PART]; 3],
}

/// Some primitives of a geometry.
#[derive(Debug, Clone)]
pub struct Part<'a> {
    /// The vertices and corners.
    pub geometry: Cow<'a, Geometry>,
    /// The numbers of the primitives.
    pub primitives: Range<usize>,
}

impl Source for Geometry {
    fn parts(&self, topology: Topology) -> usize {
        self.primitive_count(topology).div_ceil(PART)
    }

    fn part(&self, part: usize, topology: Topology, _: u64, _: Geometry) -> Part<'_> {
        let end = (PART * (part + 1)).min(self.primitive_count(topology));
        Part {
            geometry: Cow::Borrowed(self),
            primitives: PART * part..end,
        }
    }

    fn place(&self, _: usize, _: u64, primitive: usize) -> usize {
        primitive
    }
}

impl Geometry {
    /// How many whole primitives there are.
    #[must_use]
    pub fn primitive_count(&self, topology: Topology) -> usize {
        self.corners.len() / topology.corners()
    }

    /// Empties all lists.
    pub(crate) fn clear(&mut self) {
        let Self {
            clip,
            varyings,
            vertex_ids,
            corners,
            flats,
        } = self;
        clip.clear();
        varyings.clear();
        vertex_ids.clear();
        corners.clear();
        flats.clear();
    }

    /// Bytes of all lists.
    pub(super) fn bytes(&self) -> u64 {
        let words = 4 * self.clip.len()
            + self.varyings.len()
            + self.vertex_ids.len()
            + self.corners.len()
            + self.flats.len();
        4 * words as u64
    }
}

impl Topology {
    /// Corners a primitive.
    #[must_use]
    pub fn corners(self) -> usize {
        match self {
            Self::TriangleList => 3,
            Self::QuadList => 4,
            Self::LineList => 2,
        }
    }
}

/// A box that holds points, and what takes them to clip space.
///
/// Every vertex of which this is the hull lies, before rounding, at `clip · (p, 1)` for a point `p` of
/// the box, and no further from there than `slack` in any coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hull {
    /// The least and the greatest corner.
    pub corners: [[f64; 3]; 2],
    /// Columns of the matrix to clip space.
    pub clip: [[f64; 4]; 4],
    /// How far computed coordinates may lie from the exact ones.
    pub slack: [f64; 4],
}
