//! All leaves of a foliage while it is simplified: rounds of blocks, and one order over them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::super::Collapse;
use super::super::measure::quad_area;
use super::LeafCollapseOptions;
use super::block::{Block, Join};
use super::cost::Weights;
use super::exposure::exposures;
use super::partition::partition;
use super::shape::{Four, Originals, Scale, Shape};
use crate::math::{DVec3, index_u32};
use crate::plant::Foliage;

/// How many rounds in a row may find nothing before the search ends.
const IDLE_ROUNDS: usize = 5;

/// The share of the leaves whose offers may be taken in a round, in per cent.
///
/// Less makes more rounds, each of which looks at all leaves anew; more lets leaves at borders pay
/// for a worse partner of their own block.
const ROUND_PERCENT: usize = 75;

/// What is seen of a leaf at least, as a share of what is seen of a mean leaf.
///
/// Less lets what is hidden lose area and fall into fewer, larger clusters (a prickly juniper keeps 91 %
/// of its area at a quarter of its leaves with 0.02, and 98 % with 0.2); more raises FLIP, by more
/// than a third with 0.2.
const LEAST_SEEN: f32 = 0.1;

/// One block of so many tells what a round may cost.
const SAMPLE: usize = 8;

/// The leaves that are left by group, and what was done to the others.
#[derive(Debug)]
pub(super) struct Crown {
    weights: Weights,
    groups: Vec<Leaves>,
    corners: Vec<[u32; 4]>,
    collapses: Vec<Collapse>,
}

/// Leaves that are left, ascending by their numbers in the sequence.
#[derive(Debug, Default)]
struct Leaves {
    numbers: Vec<u32>,
    shapes: Vec<Shape>,
}

impl Crown {
    pub(super) fn new(foliage: &Foliage, options: &LeafCollapseOptions) -> Self {
        let leaves: Vec<[DVec3; 4]> = foliage
            .quad_vertices()
            .chunks_exact(4)
            .map(|leaf| [0, 1, 2, 3].map(|role| leaf[role].as_dvec3()))
            .collect();
        let scale = Scale::of(&leaves);
        let seen = shares_seen(&leaves);
        let mut groups = Vec::new();
        let mut corners = Vec::with_capacity(2 * leaves.len());
        for (group, _) in foliage.quad_groups() {
            let mut left = Leaves::default();
            for quad in &leaves[corners.len()..][..group.leaf_count()] {
                let leaf = index_u32(corners.len());
                corners.push([0, 1, 2, 3].map(|role| 4 * leaf + role));
                let quad = quad.map(|point| scale.unit * point);
                left.numbers.push(leaf);
                left.shapes.push(Shape::new(
                    corners[leaf as usize],
                    Four::new(quad.map(DVec3::as_vec3)),
                    Originals {
                        count: 1,
                        area: quad_area(quad),
                        seen: seen[leaf as usize],
                    },
                ));
            }
            groups.push(left);
        }
        Self {
            weights: Weights::new(options, &scale),
            groups,
            corners,
            collapses: Vec::new(),
        }
    }

    /// The corners of every leaf, old and new, and the collapses.
    pub(super) fn finish(self) -> (Vec<[u32; 4]>, Vec<Collapse>) {
        (self.corners, self.collapses)
    }

    /// Collapses until `wanted` collapses are made or no block has a pair left.
    pub(super) fn collapse(&mut self, wanted: usize) {
        let mut idle = 0;
        let mut round = 0;
        while self.collapses.len() < wanted && idle < IDLE_ROUNDS {
            let before = self.collapses.len();
            let last = self.round(round, wanted);
            if last {
                break;
            }
            idle = if self.collapses.len() == before {
                idle + 1
            } else {
                0
            };
            round += 1;
        }
    }

    /// One partition: joins in every block what is cheap, and puts the joins in order. `true` when no
    /// other partition could find more.
    fn round(&mut self, round: usize, wanted: usize) -> bool {
        let mut members: Vec<Members> = Vec::new();
        for (group, leaves) in self.groups.iter().enumerate() {
            let blocks = partition(&leaves.shapes, round);
            members.extend(blocks.into_iter().map(|leaves| Members { group, leaves }));
        }
        // With a block a group nothing lies beyond a border: all that is left is in the blocks.
        let last = members.len() <= self.groups.len();
        let most = if last {
            f32::INFINITY
        } else {
            self.usual_cost(&members)
        };
        let done: Vec<(Run, Vec<(u32, Shape)>)> = members
            .par_iter()
            .map(|members| {
                let mut block = self.block(members, most);
                block.join_all();
                let (joins, left) = block.finish();
                let numbers = &self.groups[members.group].numbers;
                let numbers = members.leaves.iter().map(|&leaf| numbers[leaf as usize]);
                (Run::new(numbers.collect(), joins), left)
            })
            .collect();
        let (mut runs, left): (Vec<Run>, Vec<_>) = done.into_iter().unzip();
        self.merge(&mut runs, wanted);
        if self.collapses.len() == wanted {
            return true;
        }
        for group in &mut self.groups {
            *group = Leaves::default();
        }
        for ((run, left), members) in runs.iter().zip(left).zip(&members) {
            let group = &mut self.groups[members.group];
            for (number, shape) in left {
                group.numbers.push(run.numbers[number as usize]);
                group.shapes.push(shape);
            }
        }
        self.groups.par_iter_mut().for_each(Leaves::sort);
        last
    }

    fn block(&self, members: &Members, most: f32) -> Block<'_> {
        let shapes = &self.groups[members.group].shapes;
        let own = members.leaves.iter().map(|&leaf| shapes[leaf as usize]);
        Block::new(own.collect(), &self.weights, most)
    }

    /// What [`ROUND_PERCENT`] of the leaves of some blocks offer at most; the largest offer where
    /// fewer have any.
    fn usual_cost(&self, members: &[Members]) -> f32 {
        let samples: Vec<&Members> = members.iter().step_by(SAMPLE).collect();
        let costs: Vec<Vec<f32>> = samples
            .into_par_iter()
            .map(|members| self.block(members, f32::INFINITY).costs().collect())
            .collect();
        let mut costs: Vec<f32> = costs.into_iter().flatten().collect();
        costs.sort_unstable_by(f32::total_cmp);
        let usual = costs.len().saturating_sub(1) * ROUND_PERCENT / 100;
        let offers = costs[..=usual].iter().rev().copied();
        offers
            .into_iter()
            .find(|cost| cost.is_finite())
            .unwrap_or(f32::MAX)
    }

    /// Takes the joins of all blocks in the order of a search through all of them: of the next join
    /// of each block always the cheapest, by (cost, lower leaf, higher leaf).
    fn merge(&mut self, runs: &mut [Run], wanted: usize) {
        let heads = runs.iter().enumerate();
        let mut queue: BinaryHeap<Reverse<Head>> = heads
            .filter_map(|(run, joins)| joins.head(run).map(Reverse))
            .collect();
        while self.collapses.len() < wanted {
            let Some(Reverse(head)) = queue.pop() else {
                return;
            };
            let run = &mut runs[head.run];
            let join = &run.joins[run.done];
            run.done += 1;
            run.numbers.push(index_u32(self.corners.len()));
            self.corners.push(join.corners);
            self.collapses.push(Collapse {
                old: head.pair,
                cost: join.cost,
            });
            queue.extend(run.head(head.run).map(Reverse));
        }
    }
}

/// What is seen of each leaf, as a share of what is seen of a mean leaf.
///
/// At least [`LEAST_SEEN`]: nothing is for nothing.
fn shares_seen(leaves: &[[DVec3; 4]]) -> Vec<f32> {
    let seen = exposures(leaves).into_iter().zip(leaves);
    let seen: Vec<f64> = seen
        .map(|(exposure, &leaf)| f64::from(exposure) * quad_area(leaf))
        .collect();
    let mean = seen.iter().fold(0.0, |sum, seen| sum + seen) / seen.len().max(1) as f64;
    let share = |seen: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounds; at most the number of leaves"
        )]
        let share = (seen / mean) as f32;
        // No leaf has an area: all are alike.
        if mean > 0.0 {
            share.max(LEAST_SEEN)
        } else {
            1.0
        }
    };
    seen.into_iter().map(share).collect()
}

/// The leaves of a block: their group, and their places among the group's leaves.
#[derive(Debug)]
struct Members {
    group: usize,
    leaves: Vec<u32>,
}

impl Leaves {
    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.numbers.len()).collect();
        order.sort_unstable_by_key(|&place| self.numbers[place]);
        self.numbers = order.iter().map(|&place| self.numbers[place]).collect();
        self.shapes = order.iter().map(|&place| self.shapes[place]).collect();
    }
}

/// The joins of a block, on their way into the order of all.
#[derive(Debug)]
struct Run {
    /// The number in the sequence of every leaf of the block, as far as it has one.
    numbers: Vec<u32>,
    joins: Vec<Join>,
    /// How many joins are in the sequence.
    done: usize,
}

/// The next join of a block; the order is that of collapses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Head {
    /// The bits of the cost, which order as costs do: none is negative.
    cost: u32,
    pair: [u32; 2],
    run: usize,
}

impl Run {
    fn new(numbers: Vec<u32>, joins: Vec<Join>) -> Self {
        Self {
            numbers,
            joins,
            done: 0,
        }
    }

    fn head(&self, run: usize) -> Option<Head> {
        let join = self.joins.get(self.done)?;
        let mut pair = join.old.map(|leaf| self.numbers[leaf as usize]);
        pair.sort_unstable();
        Some(Head {
            cost: join.cost.to_bits(),
            pair,
            run,
        })
    }
}

#[cfg(test)]
impl Crown {
    /// What [`collapse`](Self::collapse) must do where every group is one block: each time the
    /// cheapest pair of all.
    pub(super) fn collapse_by_looking_at_all_pairs(&mut self) {
        let mut left: Vec<(usize, u32, Shape)> = Vec::new();
        for (group, leaves) in self.groups.iter().enumerate() {
            let leaves = leaves.numbers.iter().zip(&leaves.shapes);
            left.extend(leaves.map(|(&number, &shape)| (group, number, shape)));
        }
        loop {
            let mut best: Option<(u32, u32, u32)> = None;
            for (group, first, one) in &left {
                for (other_group, second, other) in &left {
                    if group != other_group || first >= second {
                        continue;
                    }
                    if let Some((cost, _)) = self.weights.cost([one, other], f32::INFINITY) {
                        let found = (cost.to_bits(), *first, *second);
                        best = Some(best.map_or(found, |best| best.min(found)));
                    }
                }
            }
            let Some((cost, first, second)) = best else {
                return;
            };
            let mut take = |number| {
                let at = left.iter().position(|leaf| leaf.1 == number);
                left.remove(at.expect("it was found among those that are left"))
            };
            let (one, other) = (take(first), take(second));
            let pair = [&one.2, &other.2];
            let found = self.weights.cost(pair, f32::INFINITY);
            let shape = found.expect("it has a cost").1.shape(pair);
            left.push((one.0, index_u32(self.corners.len()), shape));
            self.corners.push(shape.corners);
            self.collapses.push(Collapse {
                old: [first, second],
                cost: f32::from_bits(cost),
            });
        }
    }
}
