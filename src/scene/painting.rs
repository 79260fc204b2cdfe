//! How trees are painted where the model draws strokes, with all options.

use crate::document::choices;
use crate::limits;

choices! {
    /// What is painted with, and on what.
    PaintLook {
        /// Opaque dabs that bristles have drawn, on canvas.
        Oil = "oil",
        /// Translucent washes with rims of pigment, on rough paper.
        Watercolour = "watercolour",
    }
}

choices! {
    /// What is shown in a colour that says something about strokes, and nothing about the tree.
    PaintMark {
        /// Nothing.
        None = "none",
        /// Strokes that stand for more than one leaf, in red ([CQHCVL06](crate::references), figure 4).
        Simplified = "simplified",
    }
}

/// How trees are painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaintOptions {
    /// What is painted with.
    pub look: PaintLook,
    /// The rows of leaf strokes after the first.
    pub rows: PaintRows,
    /// How many hulls leaves are parted by.
    pub hulls: u32,
    /// The innermost hull is the smallest that holds at least so many percent of the leaves.
    pub core_percent: u32,
    /// The most strokes that become one in one row, at least 2.
    pub at_once: u32,
    /// How much larger thresholds are in the innermost shell, as a share of their own.
    pub inward: f32,
    /// How many strokes the coarsest level of a branch has.
    pub branch_least: u32,
    /// How many each finer level has more.
    pub branch_step: u32,
    /// Up to this distance, in metres, all strokes are wanted.
    pub full_distance: f32,
    /// Branches that are seen shorter than this, in pixels, are left out.
    pub least_pixels: f32,
    /// How much larger a leaf's dab is than the stroke that stands for the leaf.
    pub leaf_scale: f32,
    /// How much wider a branch's dab is than the branch.
    pub branch_scale: f32,
    /// How much of the ground shows through the paint, from 0 to 1.
    pub grain: f32,
    /// What brushes and hues are drawn from.
    pub seed: u64,
    /// Which strokes are marked.
    pub mark: PaintMark,
}

impl PaintOptions {
    /// What holds where a scene says nothing: four rows and 35 shells, as
    /// [CQHCVL06](crate::references), sections 3.2 and 6, has them.
    pub const USUAL: Self = Self {
        look: PaintLook::Oil,
        rows: PaintRows::USUAL,
        hulls: 35,
        core_percent: 10,
        at_once: 4,
        inward: 1.0,
        branch_least: 3,
        branch_step: 1,
        full_distance: 12.0,
        least_pixels: 1.5,
        leaf_scale: 1.9,
        branch_scale: 1.6,
        grain: 0.6,
        seed: 1,
        mark: PaintMark::None,
    };
}

/// The rows of leaf strokes after the first, finest first: how far leaves may lie apart that become one
/// stroke, and how far they may be turned; or, in place of distances, how many strokes a row has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PaintRows {
    /// Zeros behind the last row.
    reach: [u32; limits::PAINT_ROWS],
    angles: [u32; limits::PAINT_ROWS],
    rows: usize,
    counts: bool,
}

/// What the rows are told by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaintReach<'a> {
    /// Distances in percent of a leaf's mean length.
    Distances(&'a [u32]),
    /// Numbers of strokes, for which the distances are searched.
    Strokes(&'a [u32]),
}

impl PaintRows {
    /// Distances of 100, 250 and 600 percent, and angles of 45, 60 and 90 degrees.
    pub const USUAL: Self = Self {
        reach: [100, 250, 600, 0, 0, 0, 0, 0],
        angles: [45, 60, 90, 0, 0, 0, 0, 0],
        rows: 3,
        counts: false,
    };

    /// The distances of [`USUAL`](Self::USUAL).
    pub const USUAL_REACH: PaintReach<'static> = PaintReach::Distances(&[100, 250, 600]);

    /// One to [`PAINT_ROWS`](limits::PAINT_ROWS) rows; as many angles as the reach has numbers, of at most
    /// 90 degrees, and neither ever finer than in the row before. Else `None`.
    #[must_use]
    pub fn new(reach: PaintReach<'_>, angles: &[u32]) -> Option<Self> {
        let (given, counts) = match reach {
            PaintReach::Distances(given) => (given, false),
            PaintReach::Strokes(given) => (given, true),
        };
        let coarsens = if counts {
            given.is_sorted_by(|before, after| before > after) && given.last() > Some(&0)
        } else {
            given.is_sorted()
        };
        let fits = coarsens
            && !given.is_empty()
            && given.len() == angles.len()
            && angles.is_sorted()
            && angles.last() <= Some(&90);
        let mut rows = Self {
            reach: [0; limits::PAINT_ROWS],
            angles: [0; limits::PAINT_ROWS],
            rows: given.len(),
            counts,
        };
        let room = rows.reach.get_mut(..given.len()).filter(|_| fits)?;
        room.copy_from_slice(given);
        rows.angles[..given.len()].copy_from_slice(angles);
        Some(rows)
    }

    /// What tells how far each row goes.
    #[must_use]
    pub fn reach(&self) -> PaintReach<'_> {
        let given = &self.reach[..self.rows];
        if self.counts {
            PaintReach::Strokes(given)
        } else {
            PaintReach::Distances(given)
        }
    }

    /// How far leaves may be turned that become one stroke, in degrees, row by row.
    #[must_use]
    pub fn angles(&self) -> &[u32] {
        &self.angles[..self.rows]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_coarsen() {
        let usual = PaintRows::new(PaintReach::Distances(&[100, 250, 600]), &[45, 60, 90]);
        assert_eq!(usual, Some(PaintRows::USUAL));
        let strokes = PaintRows::new(PaintReach::Strokes(&[40, 7]), &[45, 45]).unwrap();
        assert_eq!(strokes.reach(), PaintReach::Strokes(&[40, 7]));
        assert_eq!(strokes.angles(), [45, 45]);
        for (reach, angles) in [
            (PaintReach::Distances(&[]), &[][..]),
            (PaintReach::Distances(&[3, 2]), &[4, 5]),
            (PaintReach::Distances(&[3]), &[4, 5]),
            (PaintReach::Distances(&[3]), &[91]),
            (PaintReach::Strokes(&[3, 3]), &[4, 5]),
            (PaintReach::Strokes(&[3, 0]), &[4, 5]),
            (PaintReach::Distances(&[1; 9]), &[1; 9]),
        ] {
            assert_eq!(PaintRows::new(reach, angles), None, "{reach:?}");
        }
    }
}
