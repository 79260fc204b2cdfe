//! Extraction: from a state to `Init_group` and `Active_leaves` of every cluster.

use super::super::{Change, State};
use crate::math::index_u32;
use crate::simplify::Clusters;

/// How operations are applied to the clusters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extraction {
    /// One operation at a time ([RRCGR](crate::references), Algorithm 2, with the split reading the
    /// entry of the last operation done, not of the next).
    Single,
    /// Operations are first counted by cluster in `Changes_number`, then applied cluster by cluster
    /// ([RCRG06](crate::references), section 4).
    Batched,
}

/// What an instance keeps on the host: the cursor, and the collapses done in each cluster.
///
/// The papers keep `Init_group` and `Active_leaves` of each cluster, 8 bytes
/// ([RRCGR](crate::references), Figure 10). After `c` collapses of a cluster of `m` leaves they are
/// `2 c` and `m − c`, so the number of collapses alone says both: 4 bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Groups {
    state: State,
    /// The collapses done in each cluster of a uniform state; a variable one holds them itself.
    uniform: Vec<u32>,
}

impl Groups {
    /// The clusters in a state.
    pub(super) fn at(clusters: &Clusters, state: &State) -> Self {
        Self {
            state: state.clone(),
            uniform: match state {
                State::Uniform { collapses } => clusters.uniform(*collapses),
                State::Cards(_) | State::Strokes(_) => clusters.uniform(0),
                State::Variable { .. } => Vec::new(),
            },
        }
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }

    /// The collapses done in each cluster.
    pub(super) fn collapses(&self) -> &[u32] {
        match &self.state {
            State::Uniform { .. } | State::Cards(_) | State::Strokes(_) => &self.uniform,
            State::Variable { counts } => counts,
        }
    }

    /// The bytes of all this.
    pub(super) fn host_bytes(&self) -> u64 {
        self.state.host_bytes() + 4 * self.uniform.len() as u64
    }

    /// Goes over to another state. Returns what it took, and the clusters whose detail changed with
    /// the collapses that each had before, ascending.
    pub(super) fn extract(
        &mut self,
        clusters: &Clusters,
        to: &State,
        extraction: Extraction,
    ) -> (Change, Vec<(u32, u32)>) {
        let mut change = Change::default();
        let mut touched: Vec<(u32, u32)> = Vec::new();
        match (&self.state, to) {
            (State::Uniform { collapses: from }, State::Uniform { collapses: to }) => {
                let entries =
                    |from: u32, to: u32| &clusters.changed_groups[from as usize..to as usize];
                // The entry of an operation is read at its own number, both ways.
                let (list, step): (&[u32], i64) = if from <= to {
                    (entries(*from, *to), 1)
                } else {
                    (entries(*to, *from), -1)
                };
                let mut by_group = list.to_vec();
                by_group.sort_unstable();
                let changes = by_group.chunk_by(|a, b| a == b);
                let changes: Vec<(u32, i64)> = changes
                    .map(|same| (same[0], step * i64::from(index_u32(same.len()))))
                    .collect();
                let before = |&(group, _): &(u32, i64)| (group, self.uniform[group as usize]);
                touched.extend(changes.iter().map(before));
                match extraction {
                    Extraction::Single => {
                        let mut one_by_one = list.to_vec();
                        if step < 0 {
                            one_by_one.reverse();
                        }
                        for group in one_by_one {
                            apply(&mut self.uniform[group as usize], step);
                        }
                        // The entry, then the group read and written.
                        change.host_records += 3 * list.len() as u64;
                    }
                    Extraction::Batched => {
                        for &(group, step) in &changes {
                            apply(&mut self.uniform[group as usize], step);
                        }
                        change.host_records += 3 * list.len() as u64 + 2 * touched.len() as u64;
                    }
                }
            }
            // Out of sequence: every cluster gets its own number (Algorithm 4). On the way back to
            // uniform the cursor alone says nothing; the counts follow from the first operations.
            (_, to) => {
                let after = Self::at(clusters, to);
                let pairs = self.collapses().iter().zip(after.collapses());
                for (number, (&before, count)) in (0..).zip(pairs) {
                    if before != *count {
                        touched.push((number, before));
                    }
                }
                change.host_records += self.collapses().len() as u64 + touched.len() as u64;
                *self = after;
            }
        }
        self.state = to.clone();
        for &(group, before) in &touched {
            let after = self.collapses()[group as usize];
            change.collapses += after.saturating_sub(before);
            change.splits += before.saturating_sub(after);
        }
        change.clusters_touched = index_u32(touched.len());
        (change, touched)
    }
}

/// Adds collapses to a count, or takes them away.
fn apply(count: &mut u32, collapses: i64) {
    *count = u32::try_from(i64::from(*count) + collapses).expect("states lie within the sequence");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify::examples;

    /// `(Init_group, Active_leaves)` of every cluster.
    fn pairs(clusters: &Clusters, groups: &Groups) -> Vec<(u32, u32)> {
        let pair = |(cluster, count): (&crate::simplify::Cluster, &u32)| {
            (2 * count, cluster.original_count() - count)
        };
        let clusters = clusters.clusters.iter();
        clusters.zip(groups.collapses()).map(pair).collect()
    }

    #[test]
    fn worked_examples_at_every_level_both_ways() {
        // After three collapses, as printed: Figure 8 of 000, and its counterpart in 001.
        let printed = [
            (examples::WSCG, [(4, 1), (2, 3), (0, 2)]),
            (examples::FRAMEWORK, [(4, 2), (2, 2), (0, 2)]),
        ];
        for (ops, after_three) in printed {
            let clusters = Clusters::of(&examples::sequence(9, &ops));
            for extraction in [Extraction::Single, Extraction::Batched] {
                let mut groups = Groups::at(&clusters, &State::FINEST);
                let levels: Vec<u32> = (0..=6).chain((0..6).rev()).chain([4, 1, 6, 0]).collect();
                for collapses in levels {
                    let state = State::Uniform { collapses };
                    groups.extract(&clusters, &state, extraction);
                    assert_eq!(groups, Groups::at(&clusters, &state), "level {collapses}");
                    if collapses == 3 {
                        assert_eq!(pairs(&clusters, &groups), after_three);
                    }
                }
            }
        }
    }

    #[test]
    fn variable_and_back_to_uniform() {
        let clusters = Clusters::of(&examples::sequence(9, &examples::FRAMEWORK));
        let mut groups = Groups::at(&clusters, &State::Uniform { collapses: 2 });
        let variable = State::Variable {
            counts: vec![0, 2, 1],
        };
        let (change, touched) = groups.extract(&clusters, &variable, Extraction::Single);
        assert_eq!((change.collapses, change.splits), (3, 2));
        assert_eq!(touched, [(0, 2), (1, 0), (2, 0)]);
        let uniform = State::Uniform { collapses: 3 };
        groups.extract(&clusters, &uniform, Extraction::Single);
        assert_eq!(pairs(&clusters, &groups), [(4, 2), (2, 2), (0, 2)]);
    }
}
