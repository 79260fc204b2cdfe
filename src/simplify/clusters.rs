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

/// The leaves that the papers' static list leads to, as printed: from `Init_group = 2 c` follow
/// `next` `Active_leaves = m − c` times ([RRCGR](crate::references), Algorithm 3 and Figure 5).
///
/// The list links the originals in array order, then the new leaves in the order of their making.
/// Since the array is in the order of consumption, the way from `2 c` skips leaves that are visible
/// and meets some that are gone; it is right in every state only if leaves are consumed in the order
/// in which they were born.
#[must_use]
pub fn literal_visible(cluster: &Cluster, collapses: u32) -> Vec<u32> {
    let mut chain: Vec<usize> = (0..cluster.records.len()).collect();
    chain.sort_by_key(|&position| cluster.records[position].birth);
    let active = cluster.original_count().saturating_sub(collapses) as usize;
    chain
        .iter()
        .skip_while(|&&position| position != 2 * collapses as usize)
        .take(active)
        .map(|&position| cluster.records[position].leaf)
        .collect()
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
    fn the_papers_list_is_wrong_where_the_errata_say() {
        // Cluster 1 of 001 after two collapses: l3, l10 for l3, l12. Cluster 0 of 000 after two, the
        // state of its own Figure 8: l3, l9 for l3, l10. Every other state is right.
        for (ops, wrong, shown) in [
            (examples::WSCG, (1, 2), [3, 10]),
            (examples::FRAMEWORK, (0, 2), [3, 9]),
        ] {
            let clusters = Clusters::of(&examples::sequence(9, &ops));
            for (number, cluster) in clusters.clusters.iter().enumerate() {
                for count in 0..cluster.original_count() {
                    let mut literal = literal_visible(cluster, count);
                    let mut truth: Vec<u32> = cluster.visible(count).collect();
                    literal.sort_unstable();
                    truth.sort_unstable();
                    if (number, count) == wrong {
                        assert_eq!(literal, shown);
                        assert_ne!(literal, truth);
                    } else {
                        assert_eq!(literal, truth, "cluster {number} after {count}");
                    }
                }
            }
        }
    }
}
