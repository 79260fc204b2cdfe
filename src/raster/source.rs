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

    /// Makes a part of at most [`PART`] primitives.
    fn part(&self, part: usize, topology: Topology) -> Part<'_>;

    /// The place in the order of submission of a primitive of a part's geometry.
    fn place(&self, part: usize, primitive: usize) -> usize {
        PART * part + primitive
    }
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

    fn part(&self, part: usize, topology: Topology) -> Part<'_> {
        let end = (PART * (part + 1)).min(self.primitive_count(topology));
        Part {
            geometry: Cow::Borrowed(self),
            primitives: PART * part..end,
        }
    }

    fn place(&self, _: usize, primitive: usize) -> usize {
        primitive
    }
}

impl Geometry {
    /// How many whole primitives there are.
    #[must_use]
    pub fn primitive_count(&self, topology: Topology) -> usize {
        self.corners.len() / topology.corners()
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
