//! Branch strokes in an order in which what shows at a distance is a few runs.

use std::ops::Range;

use crate::math::{index_u32, whole_u32};
use crate::plant::{Skeleton, Stroke};
use crate::scene::PaintOptions;
use crate::simplify::strokes::{BranchStrokeOptions, BranchStrokes};

/// The branches of a plant by level and length.
///
/// ```text
///   level 0            level 1                     …
///   first  second …    first     second    third
///   ■      ■           ■■■■■■    ■■■■■■    ■■■■■■    the strokes of one rank, those of long branches first
/// ```
///
/// Every branch of a level has as many strokes, from coarse to fine ([CQHCVL06](crate::references),
/// section 3.1), so what a level reads of all its branches is a run of each rank; and since the longest
/// come first, so it is once short ones are pruned.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BranchRanks {
    /// By level: how many strokes each of its branches has.
    pub(super) ranks: Vec<u32>,
    /// By level: how many branches it has.
    counts: Vec<u32>,
    /// By level: where its strokes begin.
    firsts: Vec<u32>,
    /// All branches, the longest first: the length, and the level.
    by_length: Vec<(f32, u32)>,
    options: BranchStrokeOptions,
}

impl BranchRanks {
    /// The strokes of a skeleton in this order.
    pub(super) fn of(skeleton: &Skeleton, paint: &PaintOptions) -> (Self, Vec<Stroke>) {
        let options = BranchStrokeOptions {
            least: paint.branch_least,
            step: paint.branch_step,
        };
        let strokes = BranchStrokes::new(skeleton, options);
        let length = |branch: usize| {
            let nodes = skeleton.nodes_of(&skeleton.branches[branch]);
            let ends = nodes.windows(2);
            ends.fold(0.0, |sum, ends| {
                sum + ends[0].position.distance(ends[1].position)
            })
        };
        let level = |branch: usize| skeleton.branches[branch].level;
        let lengths: Vec<f32> = (0..skeleton.branches.len()).map(length).collect();
        let mut order: Vec<usize> = (0..lengths.len()).collect();
        order.sort_by(|a, b| lengths[*b].total_cmp(&lengths[*a]).then(a.cmp(b)));
        let levels = skeleton.branches.iter().map(|branch| branch.level + 1);
        let levels = levels.max().unwrap_or(0);
        let mut found = Self {
            ranks: Vec::new(),
            counts: Vec::new(),
            firsts: Vec::new(),
            by_length: order.iter().map(|at| (lengths[*at], level(*at))).collect(),
            options,
        };
        let mut sorted: Vec<Stroke> = Vec::with_capacity(strokes.strokes().len());
        for wanted in 0..levels {
            let mut branches = order.iter().filter(|at| level(**at) == wanted).peekable();
            let ranks = branches.peek().map_or(0, |at| {
                let run = strokes.of_branch(**at);
                run.end - run.start
            });
            let branches: Vec<usize> = branches.copied().collect();
            found.firsts.push(index_u32(sorted.len()));
            found.ranks.push(ranks);
            found.counts.push(index_u32(branches.len()));
            for rank in 0..ranks {
                let of_rank = branches
                    .iter()
                    .map(|at| strokes.of_branch(*at).start + rank);
                sorted.extend(of_rank.map(|stroke| strokes.strokes()[stroke as usize]));
            }
        }
        (found, sorted)
    }

    /// How many branches there are.
    pub(super) fn branches(&self) -> u32 {
        index_u32(self.by_length.len())
    }

    /// How many strokes the branches of each level have where this share of those beyond the least is
    /// wanted, rounded down.
    pub(super) fn limits(&self, share: f32) -> Vec<u32> {
        let least = self.options.least.max(1);
        let limit = |ranks: &u32| {
            let finer = ranks.saturating_sub(least);
            let read = whole_u32(f64::from(share.clamp(0.0, 1.0)) * f64::from(finer));
            ranks - finer + read.min(finer)
        };
        self.ranks.iter().map(limit).collect()
    }

    /// How many branches are at least so long, in metres.
    pub(super) fn longer_than(&self, length: f32) -> u32 {
        index_u32(self.by_length.partition_point(|(own, _)| *own >= length))
    }

    /// The runs of strokes that show with these limits of so many branches.
    pub(super) fn runs(&self, limits: &[u32], branches: u32) -> Vec<Range<u32>> {
        let kept = &self.by_length[..branches.min(self.branches()) as usize];
        let mut runs = Vec::new();
        for (level, (&count, &first)) in (0_u32..).zip(self.counts.iter().zip(&self.firsts)) {
            let of_level = kept.iter().filter(|(_, own)| *own == level).count();
            let of_level = index_u32(of_level);
            let limit = limits.get(level as usize).copied().unwrap_or(0);
            let ranks = 0..limit.min(self.ranks[level as usize]);
            runs.extend(
                ranks
                    .map(|rank| first + rank * count)
                    .map(|at| at..at + of_level),
            );
        }
        runs
    }

    /// The most runs that there may be.
    pub(super) fn most_runs(&self) -> u32 {
        self.ranks.iter().sum()
    }

    /// The tables as words: 3 a level, 2 a branch.
    pub(super) fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let levels = self.ranks.iter().zip(&self.counts).zip(&self.firsts);
        let levels = levels.flat_map(|((ranks, count), first)| [*ranks, *count, *first]);
        let branches = self.by_length.iter();
        levels.chain(branches.flat_map(|(length, level)| [length.to_bits(), *level]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::plant::{Branch, Node};

    /// A trunk of 4 m, on which stand branches of 1, 3 and 2 m.
    fn skeleton() -> Skeleton {
        let node = |position: Vec3| Node {
            position,
            radius: 0.1,
        };
        let mut nodes = vec![node(Vec3::ZERO), node(4.0 * Vec3::Y)];
        let mut branches = vec![Branch {
            bearer: None,
            level: 0,
            first_node: 0,
            node_count: 2,
        }];
        for length in [1.0, 3.0, 2.0] {
            branches.push(Branch {
                bearer: Some(1),
                level: 1,
                first_node: index_u32(nodes.len()),
                node_count: 2,
            });
            nodes.extend([node(4.0 * Vec3::Y), node(4.0 * Vec3::Y + length * Vec3::X)]);
        }
        Skeleton { nodes, branches }
    }

    #[test]
    fn ranks_are_runs_and_short_branches_go_first() {
        let paint = PaintOptions {
            branch_least: 2,
            ..PaintOptions::USUAL
        };
        let (ranks, strokes) = BranchRanks::of(&skeleton(), &paint);
        // Two and one more of the trunk, two of each branch.
        assert_eq!((strokes.len(), ranks.ranks.clone()), (9, vec![3, 2]));
        let halves: Vec<f32> = strokes.iter().map(|stroke| stroke.along.length()).collect();
        assert_eq!(halves[..2], [1.0, 1.0]);
        assert_eq!(halves[3..], [0.75, 0.5, 0.25, 0.75, 0.5, 0.25]);
        assert_eq!(
            (ranks.limits(1.0), ranks.limits(0.9)),
            (vec![3, 2], vec![2, 2])
        );
        let longer = [0.0, 1.0, 1.5, 3.5, 5.0].map(|length| ranks.longer_than(length));
        assert_eq!(longer, [4, 4, 3, 1, 0]);
        assert_eq!(ranks.runs(&[3, 2], 3), [0..1, 1..2, 2..3, 3..5, 6..8]);
        assert_eq!(ranks.runs(&[2, 1], 9), [0..1, 1..2, 3..6]);
        assert_eq!(ranks.runs(&[2], 0), [0..0, 1..1]);
    }
}
