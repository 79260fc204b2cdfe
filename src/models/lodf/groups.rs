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

/// What an instance keeps of its clusters on the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Groups {
    state: State,
    groups: Vec<Group>,
}

/// The papers' `Group`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Group {
    /// Position of the first leaf that may be visible: twice the collapses done.
    pub(super) init_group: u32,
    /// How many leaves are visible.
    pub(super) active_leaves: u32,
    /// Operations counted, not applied yet: collapses positive, splits negative.
    changes_number: i64,
}

impl Group {
    /// Collapses done.
    pub(super) fn collapses(self) -> u32 {
        self.init_group / 2
    }

    fn apply(&mut self, collapses: i64) {
        let moved = |value: u32, by: i64| {
            u32::try_from(i64::from(value) + by).expect("states lie within the sequence")
        };
        self.init_group = moved(self.init_group, 2 * collapses);
        self.active_leaves = moved(self.active_leaves, -collapses);
    }
}

impl Groups {
    /// The clusters in a state.
    pub(super) fn at(clusters: &Clusters, state: &State) -> Self {
        let counts = state.counts(clusters);
        let groups = clusters
            .clusters
            .iter()
            .zip(counts)
            .map(|(cluster, count)| Group {
                init_group: 2 * count,
                active_leaves: cluster.original_count() - count,
                changes_number: 0,
            });
        Self {
            state: state.clone(),
            groups: groups.collect(),
        }
    }

    pub(super) fn state(&self) -> &State {
        &self.state
    }

    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
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
                touched.extend(
                    list.iter()
                        .map(|&group| (group, self.groups[group as usize].collapses())),
                );
                touched.sort_unstable();
                touched.dedup();
                match extraction {
                    Extraction::Single => {
                        let one_by_one: Vec<u32> = if step > 0 {
                            list.to_vec()
                        } else {
                            list.iter().rev().copied().collect()
                        };
                        for group in one_by_one {
                            self.groups[group as usize].apply(step);
                        }
                        // The entry, then the group read and written.
                        change.host_records += 3 * list.len() as u64;
                    }
                    Extraction::Batched => {
                        for &group in list {
                            self.groups[group as usize].changes_number += step;
                        }
                        for &(group, _) in &touched {
                            let group = &mut self.groups[group as usize];
                            let changes = std::mem::take(&mut group.changes_number);
                            group.apply(changes);
                        }
                        change.host_records += 3 * list.len() as u64 + 2 * touched.len() as u64;
                    }
                }
            }
            // Out of sequence: every cluster gets its own number (Algorithm 4). On the way back to
            // uniform the cursor alone says nothing; the counts follow from the first operations.
            (_, to) => {
                let counts = to.counts(clusters);
                for (number, (group, &count)) in self.groups.iter_mut().zip(&counts).enumerate() {
                    let before = group.collapses();
                    if before != count {
                        group.apply(i64::from(count) - i64::from(before));
                        touched.push((index_u32(number), before));
                    }
                }
                change.host_records += self.groups.len() as u64 + touched.len() as u64;
            }
        }
        for &(group, before) in &touched {
            let after = self.groups[group as usize].collapses();
            change.collapses += after.saturating_sub(before);
            change.splits += before.saturating_sub(after);
        }
        change.clusters_touched = index_u32(touched.len());
        self.state = to.clone();
        (change, touched)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify::examples;

    /// `(Init_group, Active_leaves)` of every cluster.
    fn pairs(groups: &Groups) -> Vec<(u32, u32)> {
        groups
            .groups
            .iter()
            .map(|group| (group.init_group, group.active_leaves))
            .collect()
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
                        assert_eq!(pairs(&groups), after_three);
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
        assert_eq!(pairs(&groups), [(4, 2), (2, 2), (0, 2)]);
    }
}
