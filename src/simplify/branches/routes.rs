//! Which internodes a level has, for all levels at once: what a device looks up instead of a way through the
//! graph of merges.

use super::sequence::BranchSequence;
use super::shares::Shares;
use super::step::ErrorStep;
use crate::math::index_u32;

/// From which step on a node has another node before it, or is gone.
///
/// In 4 bytes: see [`to_word`](Self::to_word).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RouteChange {
    /// The first step that this holds for.
    pub step: ErrorStep,
    /// How many nodes before the internode's last is its first; 0 where no internode ends here.
    pub back: u32,
}

/// For every node of a skeleton and every step of error the internode that ends there.
///
/// The cheapest ways from base to tip change a few times along the whole scale of errors. A node keeps these
/// changes, so that a level takes looking at each node once and no node needs another: what the graph of
/// merges answers by a search along the branch.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BranchRoutes {
    first: Vec<u32>,
    changes: Vec<RouteChange>,
}

impl RouteChange {
    /// As it lies in memory: the step in the upper 9 bits, how many nodes back in the lower 23.
    #[must_use]
    pub fn to_word(self) -> u32 {
        u32::from(self.step.number()) << BACK_BITS | self.back
    }

    /// Back from a word.
    #[must_use]
    pub fn of_word(word: u32) -> Self {
        let number = u16::try_from(word >> BACK_BITS).unwrap_or(u16::MAX);
        Self {
            step: ErrorStep::new(number),
            back: word & MOST_BACK,
        }
    }
}

const BACK_BITS: u32 = 23;
const MOST_BACK: u32 = (1 << BACK_BITS) - 1;

impl BranchRoutes {
    /// The routes of a sequence whose levels divide their errors as `shares` says.
    #[must_use]
    pub fn of(sequence: &BranchSequence, shares: Shares) -> Self {
        let skeleton = sequence.skeleton();
        let mut all: Vec<Vec<RouteChange>> = vec![Vec::new(); skeleton.vectors.len()];
        let thickest = skeleton.vectors.iter().map(|vector| vector.radius);
        let thickest = thickest.fold(0.0, f32::max);
        let roots = skeleton.branches.iter();
        let roots = roots.filter(|branch| branch.attachment.is_none()).count();
        for number in 0..=ErrorStep::COARSEST.number() {
            let step = ErrorStep::new(number);
            let errors = sequence.errors(step.error(), shares);
            let mut internodes = 0;
            for (changes, back) in all.iter_mut().zip(sequence.internodes(&errors)) {
                internodes += usize::from(back > 0);
                let known = changes.last().map_or(0, |change| change.back);
                if known != back {
                    changes.push(RouteChange { step, back });
                }
            }
            // One line a root, which a greater error leaves as it is.
            if internodes <= roots && errors.polygon >= 2.0 * thickest {
                break;
            }
        }
        let mut routes = Self::default();
        for changes in all {
            routes.first.push(index_u32(routes.changes.len()));
            routes.changes.extend(changes);
        }
        routes.first.push(index_u32(routes.changes.len()));
        routes
    }

    /// Where the changes of each node begin; one more than there are nodes.
    #[must_use]
    pub fn first(&self) -> &[u32] {
        &self.first
    }

    /// The changes of all nodes, of each by step.
    #[must_use]
    pub fn changes(&self) -> &[RouteChange] {
        &self.changes
    }

    /// How many nodes back the internode begins that ends at a node, 0 where none does.
    #[must_use]
    pub fn back(&self, node: usize, step: ErrorStep) -> u32 {
        let range = self.first[node] as usize..self.first[node + 1] as usize;
        let changes = &self.changes[range];
        let known = changes.partition_point(|change| change.step <= step);
        known.checked_sub(1).map_or(0, |place| changes[place].back)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BranchOptions, BranchSequence};
    use super::*;
    use crate::math::{Stream, Vec3};
    use crate::plant::{Branch, Node, Skeleton};

    #[test]
    fn words_hold_changes() {
        for (number, back) in [(0, 1), (256, 0), (7, 8_388_607)] {
            let change = RouteChange {
                step: ErrorStep::new(number),
                back,
            };
            assert_eq!(RouteChange::of_word(change.to_word()), change);
        }
    }

    #[test]
    fn every_level_has_the_internodes_of_its_routes() {
        let mut draws = Stream::new(5, 0).draws();
        let mut skeleton = Skeleton::default();
        for (branch, count) in [12_u32, 6, 2, 9].into_iter().enumerate() {
            let first = index_u32(skeleton.nodes.len());
            skeleton.branches.push(Branch {
                bearer: (branch > 0).then_some(2),
                level: u32::from(branch > 0),
                first_node: first,
                node_count: count,
            });
            let mut at = skeleton
                .nodes
                .get(2)
                .map_or(Vec3::ZERO, |node| node.position);
            for node in 0..count {
                let radius = 0.05 * (1.0 - node as f32 / count as f32);
                let position = at;
                skeleton.nodes.push(Node { position, radius });
                at += Vec3::new(draws.signed(), 1.0, draws.signed()) * 0.1;
            }
        }
        let sequence = BranchSequence::of_parts(&skeleton, &[], &BranchOptions::SOUND);
        for shares in [Shares::Equal, Shares::Honest] {
            let routes = BranchRoutes::of(&sequence, shares);
            for number in 0..=ErrorStep::COARSEST.number() {
                let step = ErrorStep::new(number);
                let level = sequence.at(step.error(), shares);
                let mut wanted = vec![0; skeleton.nodes.len()];
                for run in level.nodes.first.windows(2) {
                    let nodes = &level.nodes.nodes[run[0] as usize..run[1] as usize];
                    for pair in nodes.windows(2) {
                        wanted[pair[1] as usize] = pair[1] - pair[0];
                    }
                }
                let found: Vec<u32> = (0..wanted.len()).map(|n| routes.back(n, step)).collect();
                assert_eq!(found, wanted, "step {number}");
            }
            assert!(routes.changes().len() < 8 * skeleton.nodes.len());
        }
    }
}
