//! Simpler cases of the same kind: how a counter-example shrinks.

use std::sync::Arc;

use super::{History, Operation, Walk};
use crate::math::{Vec3, index_u32};
use crate::models::{Crown, State};
use crate::plant::{Foliage, LeafGroup, Plant, Prototype};
use crate::simplify::hand_on_areas;

/// A case that can be made simpler.
///
/// Shrinking tries the simpler cases in order, takes the first that still fails, and begins anew,
/// until none fails: so put large steps first, and what people care about most.
pub trait Simpler: Sized {
    /// Cases that are simpler by one step each, best first; none that is not.
    fn simpler(&self) -> Vec<Self>;
}

impl History {
    /// The history without one of its original leaves: what would have been made with it is what it
    /// would have been made with, and the leaves behind move down by one.
    pub(super) fn without_leaf(&self, leaf: u32) -> Self {
        let leaves = self.leaf_count() - u32::from(leaf < self.leaf_count());
        let mut names: Vec<Option<u32>> = (0..self.leaf_count())
            .map(|old| match old.cmp(&leaf) {
                std::cmp::Ordering::Less => Some(old),
                std::cmp::Ordering::Equal => None,
                std::cmp::Ordering::Greater => Some(old - 1),
            })
            .collect();
        let mut collapses = Vec::new();
        for [first, second] in self.collapses() {
            let name = match (names[first as usize], names[second as usize]) {
                (Some(first), Some(second)) => {
                    collapses.push([first, second]);
                    Some(leaves + index_u32(collapses.len()) - 1)
                }
                (left, right) => left.or(right),
            };
            names.push(name);
        }
        Self::new(leaves, &collapses).expect("each leaf is still consumed at most once")
    }

    /// The history up to a collapse.
    pub(super) fn until(&self, collapses: u32) -> Self {
        let mut kept = self.collapses();
        kept.truncate(collapses as usize);
        Self::new(self.leaf_count(), &kept).expect("the beginning of a history is one")
    }

    /// The history with the operands of one collapse the other way round.
    fn swapped(&self, op: usize) -> Self {
        let mut collapses = self.collapses();
        collapses[op].reverse();
        Self::new(self.leaf_count(), &collapses).expect("the same leaves are consumed")
    }
}

/// Fewer collapses first, then operands in ascending order. (Fewer leaves are a matter of what
/// hangs on them: see [`Walk`] and [`TreeWalk`].)
impl Simpler for History {
    fn simpler(&self) -> Vec<Self> {
        let count = self.collapse_count();
        let mut simpler = Vec::new();
        if count > 1 {
            simpler.push(self.until(count / 2));
        }
        if count > 0 {
            simpler.push(self.until(count - 1));
        }
        let descending = |(_, [first, second]): &(usize, [u32; 2])| first > second;
        let swaps = self.collapses().into_iter().enumerate().filter(descending);
        simpler.extend(swaps.map(|(op, _)| self.swapped(op)));
        simpler
    }
}

/// Leaves that may go together: half of them, a quarter, …, each alone; from the end.
fn leaf_chunks(leaves: u32) -> Vec<Vec<u32>> {
    let mut chunks = Vec::new();
    let mut size = leaves / 2;
    while size > 0 {
        let mut end = leaves;
        while end >= size && end > 0 {
            chunks.push((end - size..end).rev().collect());
            end -= size;
        }
        size /= 2;
    }
    if leaves == 1 {
        chunks.push(vec![0]);
    }
    chunks
}

impl Walk {
    /// The same steps through another history, brought within it.
    #[must_use]
    pub fn through(&self, history: History) -> Self {
        let operations = self.operations.iter().map(|operation| match operation {
            Operation::To(state) => Operation::To(fitted(state, &history)),
            step => step.clone(),
        });
        Self {
            operations: operations.collect(),
            history,
        }
    }

    fn with(&self, operations: Vec<Operation>) -> Self {
        Self {
            history: self.history.clone(),
            operations,
        }
    }
}

fn fitted(state: &State, history: &History) -> State {
    match state {
        State::Uniform { collapses } => State::Uniform {
            collapses: (*collapses).min(history.collapse_count()),
        },
        State::Cards(_) | State::Strokes(_) => state.clone(),
        State::Variable { counts } => {
            let counts = counts.iter().copied().chain(std::iter::repeat(0));
            let counts = counts.zip(history.most_counts());
            State::Variable {
                counts: counts.map(|(count, most)| count.min(most)).collect(),
            }
        }
    }
}

/// The most leaves for which every walk of two steps is tried at the end of shrinking.
const FEW_LEAVES: u32 = 4;

/// Fewer leaves first, then a simpler history, then fewer steps, then simpler steps. Where few leaves
/// are left and many steps, at last every walk of up to two: a short one may lie aside of the way.
impl Simpler for Walk {
    fn simpler(&self) -> Vec<Self> {
        let leaves = leaf_chunks(self.history.leaf_count()).into_iter();
        let mut simpler: Vec<Self> = leaves
            .map(|chunk| {
                let less = |history: History, leaf| history.without_leaf(leaf);
                self.through(chunk.into_iter().fold(self.history.clone(), less))
            })
            .collect();
        simpler.extend(self.history.simpler().into_iter().map(|h| self.through(h)));
        let count = self.operations.len();
        let mut size = count.div_ceil(2);
        while size > 0 {
            for start in (0..count).step_by(size) {
                let mut operations = self.operations.clone();
                operations.drain(start..(start + size).min(count));
                simpler.push(self.with(operations));
            }
            size = if size == 1 { 0 } else { size.div_ceil(2) };
        }
        for (place, operation) in self.operations.iter().enumerate() {
            for step in operation.simpler() {
                let mut operations = self.operations.clone();
                operations[place] = step;
                simpler.push(self.with(operations));
            }
        }
        if count > 2 && self.history.leaf_count() <= FEW_LEAVES {
            let every = Operation::every(&self.history);
            simpler.extend(every.iter().map(|step| self.with(vec![step.clone()])));
            for first in &every {
                let walks = every
                    .iter()
                    .map(|second| vec![first.clone(), second.clone()]);
                simpler.extend(walks.map(|walk| self.with(walk)));
            }
        }
        simpler
    }
}

/// A single step before a state, a level before clusters, smaller numbers before greater ones.
impl Simpler for Operation {
    fn simpler(&self) -> Vec<Self> {
        let level = |collapses| Self::To(State::Uniform { collapses });
        let smaller = |count: u32| {
            let mut counts = vec![0, count / 2, count.saturating_sub(1)];
            counts.dedup();
            counts.retain(|&less| less < count);
            counts
        };
        match self {
            Self::Collapse => Vec::new(),
            Self::Split => vec![Self::Collapse],
            Self::To(State::Uniform { collapses }) => {
                let steps = [Self::Collapse, Self::Split].into_iter();
                steps
                    .chain(smaller(*collapses).into_iter().map(level))
                    .collect()
            }
            Self::To(State::Cards(_) | State::Strokes(_)) => Vec::new(),
            Self::To(State::Variable { counts }) => {
                let mut simpler = vec![Self::Collapse, level(counts.iter().sum())];
                for (cluster, &count) in counts.iter().enumerate() {
                    simpler.extend(smaller(count).into_iter().map(|less| {
                        let mut counts = counts.clone();
                        counts[cluster] = less;
                        Self::To(State::Variable { counts })
                    }));
                }
                simpler
            }
        }
    }
}

/// A walk of a model through a tree: leaves to draw, and what they do.
#[derive(Clone, PartialEq)]
pub struct TreeWalk {
    /// The leaves, as many as the history has; collapses stay within a group.
    pub foliage: Foliage,
    /// Their collapses, and the steps.
    pub walk: Walk,
}

impl TreeWalk {
    /// What models are built from.
    ///
    /// # Panics
    ///
    /// When the foliage has other than as many quad leaves as the history, or numbers that are not
    /// finite.
    #[must_use]
    pub fn crown(&self) -> Arc<Crown> {
        let plant = Plant::new("case", None, None, self.foliage.clone());
        let plant = Arc::new(plant.expect("foliage of a case is sound"));
        Arc::new(Crown::new(plant, self.walk.history.sequence().clone()))
    }

    /// The same walk where leaves do not take corners of both that they are made of, but are the first
    /// of them, grown by the other's area, with [vertices of their own](hand_on_areas).
    ///
    /// # Panics
    ///
    /// As [`crown`](Self::crown).
    #[must_use]
    pub fn pruned(&self) -> Self {
        let history = &self.walk.history;
        let pruned = hand_on_areas(&self.foliage, &history.collapses(), None);
        let pruned = pruned.expect("collapses of a history are sound");
        let mut walk = self.clone();
        walk.walk.history = History::of(&pruned);
        walk
    }

    fn without_leaves(&self, leaves: &[u32]) -> Self {
        let mut less = self.clone();
        for &leaf in leaves {
            less.walk.history = less.walk.history.without_leaf(leaf);
            let mut number = leaf as usize;
            for group in less
                .foliage
                .groups
                .iter_mut()
                .filter(|group| is_quads(group))
            {
                let count = group.leaf_count();
                if number < count {
                    group.owners.remove(number);
                    group.positions.drain(4 * number..4 * number + 4);
                    break;
                }
                number -= count;
            }
        }
        less.walk = less.walk.through(less.walk.history.clone());
        less
    }
}

/// As the walk; positions are left out.
impl std::fmt::Debug for TreeWalk {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{:?}", self.walk)
    }
}

/// Whether the leaves of a group are those that histories are over.
fn is_quads(group: &LeafGroup) -> bool {
    matches!(group.prototype, Prototype::Quad { .. })
}

/// As for its walk, the foliage losing all leaves that are no quads first, then the same leaves; at last positions on a coarse lattice.
impl Simpler for TreeWalk {
    fn simpler(&self) -> Vec<Self> {
        let leaves = self.walk.history.leaf_count();
        let chunks = leaf_chunks(leaves).into_iter();
        let mut simpler = Vec::new();
        if !self.foliage.groups.iter().all(is_quads) {
            let mut quads = self.clone();
            quads.foliage.groups.retain(is_quads);
            simpler.push(quads);
        }
        simpler.extend(chunks.map(|chunk| self.without_leaves(&chunk)));
        let walks = self.walk.simpler().into_iter();
        let walks = walks.filter(|walk| walk.history.leaf_count() == leaves);
        simpler.extend(walks.map(|walk| Self {
            foliage: self.foliage.clone(),
            walk,
        }));
        let mut rounded = self.clone();
        for position in rounded
            .foliage
            .groups
            .iter_mut()
            .flat_map(|g| &mut g.positions)
        {
            *position = (*position * 4.0).round() / 4.0 + Vec3::ZERO;
        }
        if rounded.foliage != self.foliage {
            simpler.push(rounded);
        }
        simpler
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_history_loses_a_leaf_and_stays_one() {
        let history = History::new(5, &[[0, 1], [5, 2], [6, 3]]).expect("a sound history");
        assert_eq!(
            history.without_leaf(1).to_string(),
            "4 leaves, collapses (0 1) (4 2)"
        );
        assert_eq!(
            history.without_leaf(4).to_string(),
            "4 leaves, collapses (0 1) (4 2) (5 3)"
        );
        let none = (0..5).fold(history, |history, _| history.without_leaf(0));
        assert_eq!(none.to_string(), "0 leaves");
    }

    #[test]
    fn what_is_simpler_is_smaller_and_ends() {
        let history = History::new(6, &[[1, 0], [6, 2], [4, 3]]).expect("a sound history");
        let variable = State::Variable {
            counts: vec![2, 1, 0],
        };
        let mut walk = Walk {
            history,
            operations: vec![Operation::To(variable), Operation::Split],
        };
        // Taking the last of the simpler cases each time, the longest way down, ends.
        for _ in 0..1000 {
            let mut simpler = walk.simpler();
            assert!(!simpler.contains(&walk));
            for case in &simpler {
                let states = case.states();
                assert!(states.iter().all(|state| case.history.fits(state)));
            }
            let Some(next) = simpler.pop() else { return };
            walk = next;
        }
        unreachable!("never simple enough: {walk}");
    }
}
