//! The forest cut into independent clusters, each an array in the order of consumption.

use super::CollapseSequence;
use crate::math::index_u32;

/// One leaf of a cluster, at its place in the order of consumption.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// The leaf's number in the sequence.
    pub leaf: u32,
    /// 0 for an original, `k` for the leaf made by the cluster's `k`-th collapse (from 1): the
    /// repair R1 of the papers' static `next`.
    pub birth: u32,
}

/// One binary tree of the forest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cluster {
    /// All leaves, old and new: the operands of local collapse `k` (from 0) at `2 k` and `2 k + 1`,
    /// the root last; `2 m − 1` of them for `m` originals.
    pub records: Vec<Record>,
    /// The global number of each local collapse, ascending.
    pub ops: Vec<u32>,
}

impl Cluster {
    /// How many original leaves there are (`m`).
    #[must_use]
    pub fn original_count(&self) -> u32 {
        index_u32(self.ops.len()) + 1
    }

    /// The visible leaves after `collapses` local collapses, in array order.
    ///
    /// Visible are the records at `p ≥ 2 c` with `birth ≤ c`: not consumed, and made already. The
    /// scan reads at most `2 m − 1` records.
    pub fn visible(&self, collapses: u32) -> impl Iterator<Item = u32> + '_ {
        let first = 2 * collapses as usize;
        self.records[first.min(self.records.len())..]
            .iter()
            .filter(move |record| record.birth <= collapses)
            .map(|record| record.leaf)
    }

    /// How many of the first `global` collapses of the whole sequence fall into this cluster.
    #[must_use]
    pub fn collapses_after(&self, global: u32) -> u32 {
        index_u32(self.ops.partition_point(|&op| op < global))
    }
}

/// All clusters of a sequence, and the cluster of every collapse in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Clusters {
    /// The clusters, by their least original leaf.
    pub clusters: Vec<Cluster>,
    /// The papers' `Changed_groups`: the cluster of each collapse, in the simplifier's order.
    pub changed_groups: Vec<u32>,
    /// The cluster of every leaf, old and new.
    pub cluster_of_leaf: Vec<u32>,
}

impl Clusters {
    /// Cuts the forest of a sequence.
    #[must_use]
    pub fn of(sequence: &CollapseSequence) -> Self {
        let originals = sequence.original_count() as usize;
        let mut parent = vec![u32::MAX; sequence.record_count() as usize];
        for (op, collapse) in sequence.collapses().iter().enumerate() {
            for old in collapse.old {
                parent[old as usize] = index_u32(originals + op);
            }
        }
        // Parents come after children, so one pass from the end finds every leaf's root.
        let mut root: Vec<u32> = (0..sequence.record_count()).collect();
        for leaf in (0..parent.len()).rev() {
            if parent[leaf] != u32::MAX {
                root[leaf] = root[parent[leaf] as usize];
            }
        }
        let mut number_of_root = vec![u32::MAX; parent.len()];
        let mut clusters: Vec<Cluster> = Vec::with_capacity(sequence.root_count() as usize);
        let mut roots = Vec::with_capacity(clusters.capacity());
        for original in 0..originals {
            let number = &mut number_of_root[root[original] as usize];
            if *number == u32::MAX {
                *number = index_u32(clusters.len());
                clusters.push(Cluster {
                    records: Vec::new(),
                    ops: Vec::new(),
                });
                roots.push(root[original]);
            }
        }
        let cluster_of_leaf: Vec<u32> = root
            .iter()
            .map(|&root| number_of_root[root as usize])
            .collect();
        let mut birth = vec![0_u32; parent.len()];
        let mut changed_groups = Vec::with_capacity(sequence.collapses().len());
        for (op, collapse) in sequence.collapses().iter().enumerate() {
            let number = cluster_of_leaf[originals + op];
            let cluster = &mut clusters[number as usize];
            for leaf in collapse.old {
                cluster.records.push(Record {
                    leaf,
                    birth: birth[leaf as usize],
                });
            }
            cluster.ops.push(index_u32(op));
            birth[originals + op] = index_u32(cluster.ops.len());
            changed_groups.push(number);
        }
        for (cluster, &leaf) in clusters.iter_mut().zip(&roots) {
            cluster.records.push(Record {
                leaf,
                birth: birth[leaf as usize],
            });
        }
        Self {
            clusters,
            changed_groups,
            cluster_of_leaf,
        }
    }

    /// The local collapses of every cluster after the first `global` collapses of the sequence.
    #[must_use]
    pub fn uniform(&self, global: u32) -> Vec<u32> {
        self.clusters
            .iter()
            .map(|cluster| cluster.collapses_after(global))
            .collect()
    }
}

/// What the papers' static list shows after `collapses` local collapses, as printed: from position
/// `2 c` on, `next` is followed until `m − c` leaves are named ([RRCGR](crate::references), Figure 8;
/// [RCRG06](crate::references), Figure 9).
///
/// `next` chains the originals in array order, then the new leaves in the order of their creation.
/// That is right for every count only if leaves are consumed in the order in which they are born;
/// else the list shows leaves that are gone and misses some that are there.
/// [`Cluster::visible`] is right always. Kept to show what goes wrong.
#[must_use]
pub fn literal_visible(cluster: &Cluster, collapses: u32) -> Vec<u32> {
    let mut chain: Vec<usize> = (0..cluster.records.len()).collect();
    // Stable: originals stay in array order.
    chain.sort_by_key(|&position| cluster.records[position].birth);
    let first = 2 * collapses as usize;
    let active = cluster.original_count().saturating_sub(collapses);
    chain
        .iter()
        .skip_while(|&&position| position != first)
        .take(active as usize)
        .map(|&position| cluster.records[position].leaf)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::sequence::examples;
    use super::*;

    #[test]
    fn arrays_are_those_of_the_papers() {
        let clusters = Clusters::of(&examples::sequence(9, &examples::WSCG));
        let leaves = |number: usize| -> Vec<u32> {
            clusters.clusters[number]
                .records
                .iter()
                .map(|record| record.leaf)
                .collect()
        };
        assert_eq!(leaves(0), [1, 2, 0, 9, 11]);
        assert_eq!(leaves(1), [5, 6, 4, 10, 3, 12, 14]);
        assert_eq!(leaves(2), [7, 8, 13]);
        assert_eq!(clusters.changed_groups, [0, 1, 0, 1, 2, 1]);

        let clusters = Clusters::of(&examples::sequence(9, &examples::FRAMEWORK));
        assert_eq!(clusters.changed_groups, [0, 0, 1, 2, 0, 1]);
        let leaves: Vec<u32> = clusters.clusters[0]
            .records
            .iter()
            .map(|r| r.leaf)
            .collect();
        assert_eq!(leaves, [0, 1, 2, 9, 3, 10, 13]);
    }

    #[test]
    fn birth_test_shows_the_truth_at_every_level() {
        for ops in [examples::WSCG, examples::FRAMEWORK] {
            let sequence = examples::sequence(9, &ops);
            let clusters = Clusters::of(&sequence);
            for level in 0..=6 {
                let counts = clusters.uniform(level);
                let mut shown: Vec<u32> = clusters
                    .clusters
                    .iter()
                    .zip(&counts)
                    .flat_map(|(cluster, &count)| cluster.visible(count))
                    .collect();
                shown.sort_unstable();
                assert_eq!(shown, sequence.visible_after(level), "level {level}");
            }
        }
    }
    #[test]
    fn the_literal_list_fails_where_the_papers_draw_it() {
        // Both states that are wrong in the worked examples, the second drawn in Figure 8 of 000.
        let shown = |ops: &[[u32; 2]], number: usize, collapses: u32| {
            let clusters = Clusters::of(&examples::sequence(9, ops));
            let cluster = &clusters.clusters[number];
            let literal = literal_visible(cluster, collapses);
            (literal, cluster.visible(collapses).collect::<Vec<_>>())
        };
        let (literal, truth) = shown(&examples::WSCG, 1, 2);
        assert_eq!((literal, truth), (vec![3, 10], vec![3, 12]));
        let (literal, truth) = shown(&examples::FRAMEWORK, 0, 2);
        assert_eq!((literal, truth), (vec![3, 9], vec![3, 10]));
    }

    /// Calls `visit` with every history of collapses that leaves one of `originals` leaves.
    fn all_histories(originals: u32, visit: &mut impl FnMut(&[[u32; 2]])) {
        fn go(
            left: &[u32],
            born: u32,
            ops: &mut Vec<[u32; 2]>,
            visit: &mut impl FnMut(&[[u32; 2]]),
        ) {
            if left.len() == 1 {
                visit(ops);
            }
            for (place, &first) in left.iter().enumerate() {
                for &second in &left[place + 1..] {
                    let rest = left.iter().filter(|&&leaf| leaf != first && leaf != second);
                    let rest: Vec<u32> = rest.copied().chain([born]).collect();
                    ops.push([first, second]);
                    go(&rest, born + 1, ops, visit);
                    ops.pop();
                }
            }
        }
        let left: Vec<u32> = (0..originals).collect();
        go(&left, originals, &mut Vec::new(), visit);
    }

    #[test]
    fn the_literal_list_is_right_only_first_in_first_out() {
        // Originals, histories, histories that are right at every count, wrong counts over all.
        let table = [
            (2, 1, 1, 0),
            (3, 3, 3, 0),
            (4, 18, 6, 12),
            (5, 180, 30, 240),
        ];
        for (originals, histories, right, wrong) in table.into_iter().chain([(6, 2700, 90, 5670)]) {
            let mut found = (0, 0, 0);
            all_histories(originals, &mut |ops| {
                let clusters = Clusters::of(&examples::sequence(originals, ops));
                let cluster = &clusters.clusters[0];
                let is_wrong = |&collapses: &u32| {
                    let mut literal = literal_visible(cluster, collapses);
                    let mut truth: Vec<u32> = cluster.visible(collapses).collect();
                    literal.sort_unstable();
                    truth.sort_unstable();
                    literal != truth
                };
                let wrong = (0..originals).filter(is_wrong).count();
                let births: Vec<u32> = cluster.records.iter().map(|record| record.birth).collect();
                assert_eq!(wrong == 0, births.is_sorted(), "{ops:?}");
                found = (
                    found.0 + 1,
                    found.1 + u32::from(wrong == 0),
                    found.2 + wrong,
                );
            });
            assert_eq!(found, (histories, right, wrong), "{originals} originals");
        }
    }
}
