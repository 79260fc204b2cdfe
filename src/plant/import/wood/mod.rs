//! Wood as files keep it, segment by segment, and the skeleton that it makes.
//!
//! ```text
//!  file ─reader─▶ Wood ─grow──▶ Skeleton ─trunk──▶ Mesh
//!                  │     └────▶ Place of every segment: what leaves are hung on
//!                  └─stand──▶ Frame with its base at the lowest root
//! ```
//!
//! A segment is a piece of an axis: a fitted cylinder, or the way from one node to the next. Its parent may
//! stand anywhere in the file. Points are in the file's space and unit, in 64 bits, until they are nodes.
//!
//! **Invariant.** Whatever parents a file names, the skeleton is sound: cycles are cut, and every segment
//! lies on exactly one branch.

mod axes;
mod nodes;
mod tubes;

pub(in crate::plant) use tubes::trunk;

use super::frame::Frame;
use super::{ImportError, ImportReport, Source};
use crate::limits::WOOD_SEGMENTS;
use crate::math::{DVec3, index_u32};
use crate::plant::{Foliage, Mesh, Plant, Skeleton};

/// A piece of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plant) struct Segment {
    /// The segment that bears it, by its number in the wood; `None` for a root.
    pub(in crate::plant) parent: Option<u32>,
    /// Whether it is the next on its parent's axis, or branches off; `None` where the file does not say.
    pub(in crate::plant) follows: Option<bool>,
    /// Where it starts; `None` where its parent ends. A root without a start is but a point.
    pub(in crate::plant) start: Option<DVec3>,
    /// Where it ends.
    pub(in crate::plant) end: DVec3,
    /// The radius at its start, at least 0; `None` where the file does not say.
    pub(in crate::plant) start_radius: Option<f64>,
    /// The radius at its end, at least 0; `None` where the file does not say. Of a cylinder of constant
    /// radius only the start's is set: at a joint the next one's counts.
    pub(in crate::plant) end_radius: Option<f64>,
    /// The line of the file that holds it.
    pub(in crate::plant) line: usize,
}

/// All segments of a file, in its order.
#[derive(Debug)]
pub(in crate::plant) struct Wood {
    /// What the file calls them, in the plural.
    what: &'static str,
    segments: Vec<Segment>,
}

/// Where a segment lies in the skeleton.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::plant) struct Place {
    /// Its branch.
    pub(in crate::plant) branch: u32,
    /// The node at its start.
    pub(in crate::plant) first: u32,
    /// The node at its end, on the same branch: the first itself where it has no length.
    pub(in crate::plant) last: u32,
}

/// What wood becomes.
#[derive(Debug)]
pub(in crate::plant) struct Grown {
    /// The branches.
    pub(in crate::plant) skeleton: Skeleton,
    /// Where each segment lies, by its number.
    pub(in crate::plant) places: Vec<Place>,
}

impl Wood {
    /// No wood; `what` is what the file calls its segments, in the plural.
    pub(in crate::plant) fn new(what: &'static str) -> Self {
        Self {
            what,
            segments: Vec::new(),
        }
    }

    /// Adds a segment; returns its number.
    ///
    /// # Errors
    ///
    /// When there are [`WOOD_SEGMENTS`] already.
    pub(in crate::plant) fn push(
        &mut self,
        segment: Segment,
        source: &Source<'_>,
    ) -> Result<u32, ImportError> {
        let number = self.segments.len();
        source.limit(self.what, number as u64 + 1, WOOD_SEGMENTS as u64)?;
        self.segments.push(segment);
        Ok(index_u32(number))
    }

    /// The segments, by number.
    pub(in crate::plant) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The frame with its base where the lowest root starts, or where the first segment does when no
    /// segment is a root.
    pub(in crate::plant) fn stand(&self, frame: Frame, report: &mut ImportReport) -> Frame {
        let start = |segment: &Segment| segment.start.unwrap_or(segment.end);
        let mut roots = self.segments.iter().filter(|root| root.parent.is_none());
        let Some(first) = roots.next().or(self.segments.first()) else {
            return frame;
        };
        let lowest = roots.fold(first, |lowest, root| {
            let is_lower = frame.height(start(root)) < frame.height(start(lowest));
            if is_lower { root } else { lowest }
        });
        frame.with_base(start(lowest), place_of(lowest.line), report)
    }

    /// The skeleton of it all.
    ///
    /// Of a segment's children at most one is next on its axis: the one that the file names, or else the
    /// thickest, and of those within a tenth of its radius the straightest. All others begin branches,
    /// borne by the nearest node of the segment; where that is further away than the segment is thick, the
    /// segment gets a node there.
    ///
    /// Two that follow one another share a node where the second starts, if that is within a radius of
    /// where the first ends; else each has its own. A branch that starts outside of its bearer's wood gets a
    /// node on the bearer's axis.
    pub(in crate::plant) fn grow(&self, frame: &Frame, report: &mut ImportReport) -> Grown {
        report.find(self.what, self.segments.len() as u64);
        let axes = axes::Axes::of(self, report);
        nodes::lay(self, &axes, frame, report)
    }
}

/// The plant of a skeleton, which is called as its file.
///
/// # Errors
///
/// When the parts do not fit: a coordinate is beyond 32 bits.
pub(in crate::plant) fn plant(
    source: &Source<'_>,
    skeleton: Skeleton,
    trunk: Option<Mesh>,
    foliage: Foliage,
) -> Result<Plant, ImportError> {
    Plant::new(source.stem(), Some(skeleton), trunk, foliage).map_err(|error| ImportError::Plant {
        file: source.file().to_owned(),
        source: error,
    })
}

/// A line as the place of a report's entry.
pub(in crate::plant) fn place_of(line: usize) -> String {
    format!("line {line}")
}

#[cfg(test)]
mod tests;
