//! A budget of bytes a frame, spent where the picture gains most.

use super::super::Crown;
use super::Sight;
use crate::math::Aabb;

/// A change of detail that stands for itself: of a cluster, or of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Which tree.
    pub tree: u32,
    /// Which of its clusters; `None` for the whole tree.
    pub cluster: Option<u32>,
    /// The collapses done.
    pub from: u32,
    /// The collapses wanted.
    pub to: u32,
    /// What the picture gains by it: see [`gain`].
    pub gain: f64,
}

/// How far a move came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spent {
    /// The move.
    pub made: Move,
    /// The collapses that it came to: `to`, or on the way there, or `from`.
    pub reached: u32,
}

/// What the picture gains when a box of foliage goes from one number of collapses to another: the
/// pixels that the leaves cover which come or go,
///
/// ```text
/// gain = s · |to − from| · a · p²
/// ```
///
/// with the crown's mean area of an original leaf `a`, the pixels a metre `p` at the nearest point of
/// the box, and `s` = 1 for leaves that come, 1/16 for leaves that go (leaves that are missing are
/// seen; one too many only costs its drawing), and 0 for what the view does not show.
#[must_use]
pub fn gain(crown: &Crown, bounds: &Aabb, from: u32, to: u32, sight: &Sight) -> f64 {
    if !sight.may_see(bounds) {
        return 0.0;
    }
    let seen = if to < from { 1.0 } else { 1.0 / 16.0 };
    let pixels = sight.pixels_per_metre_at(bounds);
    seen * f64::from(from.abs_diff(to)) * crown.mean_leaf_area() * (pixels * pixels)
}

/// Spends at most `budget` bytes on moves, those with the greatest gain a byte first; of equal ones
/// the lower tree and cluster.
///
/// `price` tells the bytes of a move to some number of collapses, whatever else moves. What is free
/// always goes. A move that no longer fits goes half the way, or a quarter, and so on, as far as
/// that fits; then the others have their turn. Answers all moves, by tree and cluster.
pub fn spend(
    budget: u64,
    moves: Vec<Move>,
    mut price: impl FnMut(&Move, u32) -> u64,
) -> Vec<Spent> {
    let mut order: Vec<(f64, Move)> = moves
        .into_iter()
        .map(|one| {
            let rate = match price(&one, one.to) {
                0 => f64::INFINITY,
                bytes => one.gain / bytes as f64,
            };
            (rate, one)
        })
        .collect();
    let place = |one: &Move| (one.tree, one.cluster);
    order.sort_by(|(first_rate, first), (second_rate, second)| {
        let by_rate = second_rate.total_cmp(first_rate);
        by_rate.then(place(first).cmp(&place(second)))
    });
    let mut left = budget;
    let mut spent: Vec<Spent> = order
        .into_iter()
        .map(|(_, made)| {
            let reached = halves(made.from, made.to).find(|&to| price(&made, to) <= left);
            let reached = reached.unwrap_or(made.from);
            if reached != made.from {
                left -= price(&made, reached);
            }
            Spent { made, reached }
        })
        .collect();
    spent.sort_by_key(|spent| place(&spent.made));
    spent
}

/// `to`, then what lies half the way from `from`, a quarter, and so on; without `from`.
fn halves(from: u32, to: u32) -> impl Iterator<Item = u32> {
    let distances = std::iter::successors(Some(from.abs_diff(to)), |distance| Some(distance / 2));
    distances
        .take_while(|&distance| distance > 0)
        .map(move |distance| {
            if to > from {
                from + distance
            } else {
                from - distance
            }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(tree: u32, from: u32, to: u32, gain: f64) -> Move {
        Move {
            tree,
            cluster: None,
            from,
            to,
            gain,
        }
    }

    /// Ten bytes a collapse.
    fn reached(budget: u64, moves: &[Move]) -> Vec<u32> {
        let price = |one: &Move, to: u32| 10 * u64::from(one.from.abs_diff(to));
        let spent = spend(budget, moves.to_vec(), price);
        spent.iter().map(|spent| spent.reached).collect()
    }

    #[test]
    fn the_greatest_gain_a_byte_goes_first_and_the_next_as_far_as_it_can() {
        let moves = [one(0, 8, 0, 80.0), one(1, 0, 4, 400.0), one(2, 5, 4, 1.0)];
        assert_eq!(reached(u64::MAX, &moves), [0, 4, 4]);
        assert_eq!(reached(120, &moves), [0, 4, 5]);
        // 40 for the second; half of the first's 80; then nothing is left.
        assert_eq!(reached(80, &moves), [4, 4, 5]);
        assert_eq!(reached(79, &moves), [6, 4, 4]);
        assert_eq!(reached(9, &moves), [8, 0, 5]);
    }

    #[test]
    fn equal_gains_go_in_order_and_what_is_free_always() {
        let moves = [one(1, 0, 1, 5.0), one(0, 0, 1, 5.0), one(2, 0, 1, f64::NAN)];
        assert_eq!(reached(10, &moves[..2]), [1, 0]);
        let free = spend(0, moves.to_vec(), |_, _| 0);
        assert!(free.iter().all(|spent| spent.reached == 1));
    }
}
