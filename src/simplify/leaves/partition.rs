//! Leaves cut into blocks by where they lie.

use super::block::BLOCK_LEAVES;
use super::shape::Shape;
use crate::math::Vec3;

/// The share of the leaves that lies below a cut, from one partition to the next: as different as
/// they can be, so that borders do not stay where they are, and near enough to the middle that
/// blocks do not get narrow.
const SHARES: [f32; 5] = [0.5, 0.4, 0.55, 0.45, 0.6];

/// How many leaves long a cell is at least: where leaves stand closer, a block takes every second or
/// third leaf of a larger cell.
///
/// A new leaf needs corners as far apart as a larger leaf's, which leaves in one place do not have.
/// Without this a yew of 500,000 leaves of common size keeps 88 % of its area at a twentieth of its
/// leaves, with it 91 %.
const SPREAD: f64 = 2.0;

/// From how many leaves on the two sides of a cut are worth a thread each.
const PARALLEL: usize = 4096;

/// The leaves of each block, by index, ascending; blocks in order of their place.
///
/// Leaves are cut across the longest side of the box of their middles until no cell has more than
/// [`BLOCK_LEAVES`] or it gets too short; a cell that has more makes several blocks, which lie among
/// each other. A function of the leaves and `round` alone.
pub(super) fn partition(shapes: &[Shape], round: usize) -> Vec<Vec<u32>> {
    let mut places: Vec<Place> = (0..)
        .zip(shapes)
        .map(|(leaf, shape)| Place {
            at: shape.points.middle(),
            leaf,
        })
        .collect();
    let lengths = shapes.iter().map(|shape| f64::from(shape.points.extent()));
    let length = lengths.fold(0.0, |sum, length| sum + length) / shapes.len().max(1) as f64;
    let cuts = Cuts {
        share: SHARES[round % SHARES.len()],
        shortest: SPREAD * length,
    };
    let counts = cuts.cut(&mut places);
    let mut rest = &places[..];
    let mut blocks = Vec::new();
    for count in counts {
        let (cell, after) = rest.split_at(count);
        let mut leaves: Vec<u32> = cell.iter().map(|place| place.leaf).collect();
        leaves.sort_unstable();
        let step = count.div_ceil(BLOCK_LEAVES);
        blocks.extend((0..step).map(|first| {
            let every = leaves[first..].iter().step_by(step);
            every.copied().collect::<Vec<u32>>()
        }));
        rest = after;
    }
    blocks
}

#[derive(Debug, Clone, Copy)]
struct Place {
    at: Vec3,
    leaf: u32,
}

/// How leaves are cut into cells.
#[derive(Debug, Clone, Copy)]
struct Cuts {
    share: f32,
    shortest: f64,
}

impl Cuts {
    /// Brings the places into an order of cells; returns how many leaves each has.
    fn cut(self, places: &mut [Place]) -> Vec<usize> {
        if places.len() <= BLOCK_LEAVES {
            return vec![places.len()];
        }
        let mut low = Vec3::INFINITY;
        let mut high = Vec3::NEG_INFINITY;
        for place in &*places {
            low = low.min(place.at);
            high = high.max(place.at);
        }
        let axis = (high - low).max_position();
        if f64::from((high - low)[axis]) <= self.shortest {
            return vec![places.len()];
        }
        let below = below(places.len(), self.share);
        places.select_nth_unstable_by(below, |one, other| {
            let order = one.at[axis].total_cmp(&other.at[axis]);
            order.then(one.leaf.cmp(&other.leaf))
        });
        let (first, second) = places.split_at_mut(below);
        let (mut counts, more) = if first.len().min(second.len()) < PARALLEL {
            (self.cut(first), self.cut(second))
        } else {
            rayon::join(|| self.cut(first), || self.cut(second))
        };
        counts.extend(more);
        counts
    }
}

/// How many of more than one place lie below the cut: at least one, and not all.
fn below(count: usize, share: f32) -> usize {
    let below = f64::from(share) * count as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a count"
    )]
    let below = below as usize;
    below.clamp(1, count - 1)
}

#[cfg(test)]
mod tests {
    use super::super::shape::{Four, Originals};
    use super::*;

    #[test]
    fn every_leaf_is_in_one_block_and_borders_move() {
        let under = Originals {
            count: 1,
            area: 1.0,
            seen: 1.0,
        };
        for spread in [0.001, 1.0, 1000.0] {
            let shapes: Vec<Shape> = (0..1000_u16)
                .map(|leaf| {
                    let x = spread * f32::from(leaf % 100);
                    let y = spread * f32::from(leaf / 100);
                    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
                    let points = corners.map(|(u, v)| Vec3::new(x + u, y + v, 0.0));
                    Shape::new([0, 1, 2, 3], Four::new(points), under)
                })
                .collect();
            for round in 0..5 {
                let blocks = partition(&shapes, round);
                assert!(blocks.iter().all(|block| block.len() <= BLOCK_LEAVES));
                assert!(blocks.iter().all(|block| block.is_sorted()));
                let mut leaves = blocks.concat();
                leaves.sort_unstable();
                assert_eq!(leaves, (0..1000).collect::<Vec<u32>>(), "spread {spread}");
            }
            if spread > 1.0 {
                assert_ne!(partition(&shapes, 0), partition(&shapes, 1));
            }
        }
    }
}
