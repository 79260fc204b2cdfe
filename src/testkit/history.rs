//! Collapse histories: what a structure under test is built from, and the truth that it is held
//! against.

use std::fmt;

use crate::limits::PLANT_LEAVES;
use crate::math::index_u32;
use crate::models::State;
use crate::simplify::{Clusters, Collapse, CollapseSequence, SequenceError};

/// Collapses over `L` leaves, in order: collapse `k` (from 0) consumes two leaves and makes leaf
/// `L + k`.
///
/// ```text
///  leaves 0 1 2 3,  collapses (0 1) (4 2)          5
///                                                 ╱ ╲
///  4 = L + 0 is made of 0 and 1,                 4   2        3
///  5 = L + 1 is made of 4 and 2                 ╱ ╲
///  3 is never touched                          0   1
/// ```
///
/// The trees of the forest are its *clusters*, numbered by their least original leaf: here cluster
/// 0 holds leaves 0, 1, 2, 4 and 5, cluster 1 holds leaf 3.
///
/// What is visible in a [`State`] is found here by replaying the collapses and nothing else, so that
/// no structure is held against itself.
#[derive(Clone, PartialEq)]
pub struct History {
    sequence: CollapseSequence,
    clusters: Clusters,
    /// The collapse that consumes each leaf, [`NEVER`] for none.
    deaths: Vec<u32>,
    /// The number of each collapse within its cluster.
    local: Vec<u32>,
}

const NEVER: u32 = u32::MAX;

impl History {
    /// A checked history.
    ///
    /// # Errors
    ///
    /// When there are more than [`PLANT_LEAVES`] leaves, or a collapse names a leaf that does not exist
    /// yet or is gone already.
    pub fn new(leaf_count: u32, collapses: &[[u32; 2]]) -> Result<Self, HistoryError> {
        if leaf_count as usize > PLANT_LEAVES {
            return Err(HistoryError::Leaves { found: leaf_count });
        }
        let originals = (0..leaf_count).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
        let mut corners: Vec<[u32; 4]> = originals.collect();
        for (op, old) in collapses.iter().enumerate() {
            // What is not there is refused below; the corners only have to be of the right number.
            let [first, second] =
                old.map(|leaf| corners.get(leaf as usize).copied().unwrap_or([0; 4]));
            let mix = mixture(op, *old);
            corners.push([0, 1, 2, 3].map(|role| {
                let from = if mix >> role & 1 == 0 { first } else { second };
                from[role]
            }));
        }
        let collapses = collapses.iter().map(|&old| Collapse { old, cost: 0.0 });
        let sequence = CollapseSequence::new(leaf_count, corners, collapses.collect())?;
        Ok(Self::of(&sequence))
    }

    /// The history of a simplifier's sequence.
    #[must_use]
    pub fn of(sequence: &CollapseSequence) -> Self {
        let clusters = Clusters::of(sequence);
        let mut deaths = vec![NEVER; sequence.record_count() as usize];
        let mut done = vec![0; clusters.clusters.len()];
        let mut local = Vec::with_capacity(sequence.collapses().len());
        for (op, collapse) in sequence.collapses().iter().enumerate() {
            for old in collapse.old {
                deaths[old as usize] = index_u32(op);
            }
            let count = &mut done[clusters.changed_groups[op] as usize];
            local.push(*count);
            *count += 1;
        }
        Self {
            sequence: sequence.clone(),
            clusters,
            deaths,
            local,
        }
    }

    /// How many leaves there are at full detail (`L`).
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        self.sequence.original_count()
    }

    /// How many collapses there are (`C`).
    #[must_use]
    pub fn collapse_count(&self) -> u32 {
        self.sequence.collapse_count()
    }

    /// The two leaves that each collapse consumes, in order.
    #[must_use]
    pub fn collapses(&self) -> Vec<[u32; 2]> {
        let collapses = self.sequence.collapses().iter();
        collapses.map(|collapse| collapse.old).collect()
    }

    /// The same as a sequence whose leaves have four vertices each: leaf `l` of the originals
    /// `4 l .. 4 l + 4`, a new leaf some of both that it is made of.
    #[must_use]
    pub fn sequence(&self) -> &CollapseSequence {
        &self.sequence
    }

    /// The trees of the forest.
    #[must_use]
    pub fn clusters(&self) -> &Clusters {
        &self.clusters
    }

    /// How many collapses fall into each cluster.
    #[must_use]
    pub fn most_counts(&self) -> Vec<u32> {
        let clusters = self.clusters.clusters.iter();
        clusters
            .map(|cluster| index_u32(cluster.ops.len()))
            .collect()
    }

    /// The collapse that makes a leaf; `None` for an original.
    #[must_use]
    pub fn birth(&self, leaf: u32) -> Option<u32> {
        leaf.checked_sub(self.leaf_count())
    }

    /// The collapse that consumes a leaf; `None` for a root.
    #[must_use]
    pub fn death(&self, leaf: u32) -> Option<u32> {
        let death = self.deaths.get(leaf as usize).copied();
        death.filter(|&death| death != NEVER)
    }

    /// Whether a collapse is done in a state that [`fits`](Self::fits).
    #[must_use]
    pub fn is_done(&self, op: u32, state: &State) -> bool {
        match state {
            State::Uniform { collapses } => op < *collapses,
            State::Cards(_) | State::Strokes(_) => false,
            State::Variable { counts } => {
                let cluster = self.clusters.changed_groups.get(op as usize);
                let count = cluster.and_then(|&cluster| counts.get(cluster as usize));
                let local = self.local.get(op as usize);
                count.zip(local).is_some_and(|(count, local)| local < count)
            }
        }
    }

    /// Whether a state is one of this history: no more collapses than there are, and in a variable
    /// state a number for each cluster.
    #[must_use]
    pub fn fits(&self, state: &State) -> bool {
        match state {
            State::Uniform { collapses } => *collapses <= self.collapse_count(),
            State::Cards(_) | State::Strokes(_) => false,
            State::Variable { counts } => {
                let most = self.most_counts();
                counts.len() == most.len()
                    && counts.iter().zip(&most).all(|(count, most)| count <= most)
            }
        }
    }

    /// The leaves that are visible in a state, ascending: made already, and not consumed.
    #[must_use]
    pub fn visible(&self, state: &State) -> Vec<u32> {
        let done = |op: u32| self.is_done(op, state);
        let leaves = 0..self.sequence.record_count();
        leaves
            .filter(|&leaf| self.birth(leaf).is_none_or(done))
            .filter(|&leaf| !self.death(leaf).is_some_and(done))
            .collect()
    }
}

/// Which corners a new leaf takes from its second operand: neither none nor all of them.
fn mixture(op: usize, [first, second]: [u32; 2]) -> u32 {
    let seed = index_u32(op) ^ first.wrapping_mul(5) ^ second.wrapping_mul(11);
    1 + seed.wrapping_mul(0x9e37_79b1) % 14
}

/// As in "4 leaves, collapses (0 1) (4 2)".
impl fmt::Display for History {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let leaves = self.leaf_count();
        write!(
            out,
            "{leaves} {}",
            if leaves == 1 { "leaf" } else { "leaves" }
        )?;
        let shown = 24;
        for (op, [first, second]) in self.collapses().iter().take(shown).enumerate() {
            let word = if op == 0 { ", collapses" } else { "" };
            write!(out, "{word} ({first} {second})")?;
        }
        let rest = (self.collapse_count() as usize).saturating_sub(shown);
        if rest > 0 {
            write!(out, " and {rest} more")?;
        }
        Ok(())
    }
}

/// As it is displayed, for counter-examples.
impl fmt::Debug for History {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "History({self})")
    }
}

/// Why collapses are no history.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HistoryError {
    /// Too many leaves.
    #[error("{found} leaves, at most {PLANT_LEAVES} can be")]
    Leaves {
        /// How many were given.
        found: u32,
    },
    /// A collapse that cannot be.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replay_agrees_with_sequence_and_clusters() {
        let history = History::new(9, &crate::simplify::examples::WSCG).expect("a sound history");
        for collapses in 0..=6 {
            let state = State::Uniform { collapses };
            assert_eq!(
                history.visible(&state),
                history.sequence().visible_after(collapses)
            );
            let counts = state.counts(history.clusters());
            assert!(history.fits(&state));
            let variable = State::Variable { counts };
            assert_eq!(history.visible(&variable), history.visible(&state));
        }
        let variable = State::Variable {
            counts: vec![0, 3, 1],
        };
        assert_eq!(history.visible(&variable), [0, 1, 2, 13, 14]);
        assert!(!history.fits(&State::Uniform { collapses: 7 }));
        assert_eq!(
            History::new(4, &[[0, 1], [4, 2]])
                .expect("sound")
                .to_string(),
            "4 leaves, collapses (0 1) (4 2)"
        );
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(matches!(
            History::new(2, &[[0, 3]]),
            Err(HistoryError::Sequence(SequenceError::NotYet {
                leaf: 3,
                ..
            }))
        ));
        assert!(matches!(
            History::new(2, &[[0, u32::MAX]]),
            Err(HistoryError::Sequence(SequenceError::NotYet { .. }))
        ));
        assert!(matches!(
            History::new(u32::MAX, &[]),
            Err(HistoryError::Leaves { .. })
        ));
    }
}
