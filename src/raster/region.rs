//! Regions: a target drawn part by part, where its geometry is too much to hold at once.
//!
//! What a sample ends up with depends on the triangles over it alone, so parts that are drawn one after
//! another are the picture, and their work adds up to its work.

use super::Geometry;
use super::frame::BLOCK_SIDE;
use super::view::PixelBox;

/// A rectangle of whole blocks of 64 × 64 pixels of a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// The first column and row of blocks.
    first: [u32; 2],
    /// One more than the last.
    end: [u32; 2],
}

impl Region {
    /// All blocks of a target of this size.
    #[must_use]
    pub fn whole(size: [u32; 2]) -> Self {
        Self {
            first: [0; 2],
            end: size.map(|side| side.div_ceil(BLOCK_SIDE)),
        }
    }

    /// The block of a pixel.
    #[must_use]
    pub fn around(pixel: [u32; 2]) -> Self {
        let first = pixel.map(|at| at / BLOCK_SIDE);
        Self {
            first,
            end: first.map(|block| block + 1),
        }
    }

    /// Both halves, cut across the longer side; `None` of a single block.
    #[must_use]
    pub fn halves(self) -> Option<[Self; 2]> {
        let sides = [0, 1].map(|axis| self.end[axis] - self.first[axis]);
        let axis = usize::from(sides[1] > sides[0]);
        if sides[axis] < 2 {
            return None;
        }
        let middle = self.first[axis] + sides[axis] / 2;
        let (mut one, mut other) = (self, self);
        one.end[axis] = middle;
        other.first[axis] = middle;
        Some([one, other])
    }

    /// Whether a block belongs to both.
    #[must_use]
    pub fn meets(self, other: Self) -> bool {
        (0..2).all(|axis| self.first[axis] < other.end[axis] && other.first[axis] < self.end[axis])
    }

    /// The blocks of a target of this size that primitives of these vertices may cover; `None` when
    /// there are none.
    ///
    /// Two pixels are added on each side: for snapping, and for the width of lines.
    #[must_use]
    pub fn of(size: [u32; 2], geometry: &Geometry) -> Option<Self> {
        if geometry.clip.is_empty() {
            return None;
        }
        let whole = Self::whole(size);
        let (mut least, mut greatest) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
        for clip in &geometry.clip {
            // In front of the eye a primitive lies between its corners; else anywhere.
            if !clip.is_finite() || clip.w <= f32::MIN_POSITIVE {
                return (whole.first != whole.end).then_some(whole);
            }
            for (axis, at) in [clip.x / clip.w, -clip.y / clip.w].into_iter().enumerate() {
                least[axis] = least[axis].min(at);
                greatest[axis] = greatest[axis].max(at);
            }
        }
        let mut found = whole;
        for axis in 0..2 {
            let half = 0.5 * size[axis] as f32;
            let [from, to] = [least[axis], greatest[axis]].map(|at| half + at * half);
            found.first[axis] = block(from - 2.0).min(whole.end[axis]);
            found.end[axis] = match to + 2.0 {
                to if to < 0.0 => 0,
                to => block(to).saturating_add(1).min(whole.end[axis]),
            };
            if found.first[axis] >= found.end[axis] {
                return None;
            }
        }
        Some(found)
    }

    /// Columns and rows of blocks.
    pub(super) fn contains(self, [column, row]: [usize; 2]) -> bool {
        let within = |axis: usize, at: usize| {
            (self.first[axis] as usize..self.end[axis] as usize).contains(&at)
        };
        within(0, column) && within(1, row)
    }

    /// The pixels, beyond the target where its last blocks are.
    pub(super) fn pixels(self) -> PixelBox {
        PixelBox {
            first: self.first.map(|block| (BLOCK_SIDE * block).cast_signed()),
            last: self.end.map(|end| (BLOCK_SIDE * end).cast_signed() - 1),
        }
    }
}

/// The block of a place along an axis, the first where it lies before.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float becomes a block by the language's saturating cast"
)]
fn block(pixel: f32) -> u32 {
    pixel as u32 / BLOCK_SIDE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec4;

    fn region(first: [u32; 2], end: [u32; 2]) -> Region {
        Region { first, end }
    }

    #[test]
    fn halves_are_cut_across_the_longer_side_down_to_a_block() {
        let whole = Region::whole([300, 129]);
        assert_eq!(whole, region([0, 0], [5, 3]));
        let [left, right] = whole.halves().unwrap();
        assert_eq!(
            (left, right),
            (region([0, 0], [2, 3]), region([2, 0], [5, 3]))
        );
        assert!(!left.meets(right) && left.meets(whole));
        assert_eq!(region([3, 4], [4, 5]).halves(), None);
        assert_eq!(Region::whole([0, 9]).halves(), None);
    }

    #[test]
    fn footprints_hold_all_that_may_be_covered() {
        // A target of 256 × 128 pixels; clip coordinates with w = 2.
        let of = |corners: &[[f32; 3]]| {
            let clip = corners.iter().map(|[x, y, w]| Vec4::new(*x, *y, 0.0, *w));
            let geometry = Geometry {
                clip: clip.collect(),
                ..Geometry::default()
            };
            Region::of([256, 128], &geometry)
        };
        // Pixels 32 to 96 across, 16 to 48 down: the blocks 0 and 1 of the first row.
        assert_eq!(
            of(&[[-1.5, 1.5, 2.0], [-0.5, 0.5, 2.0]]),
            Some(region([0, 0], [2, 1]))
        );
        // At pixel 129 of 128 and 62 of 64: two pixels of room make it four blocks.
        assert_eq!(
            of(&[[2.0 / 256.0, 4.0 / 128.0, 1.0]]),
            Some(region([1, 0], [3, 2]))
        );
        assert_eq!(of(&[[9.0, 0.0, 1.0]]), None);
        assert_eq!(of(&[[-9.0, 0.0, 1.0]]), None);
        assert_eq!(of(&[]), None);
        let all = Some(region([0, 0], [4, 2]));
        assert_eq!(of(&[[9.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), all);
        assert_eq!(of(&[[f32::NAN, 0.0, 1.0]]), all);
    }
}
