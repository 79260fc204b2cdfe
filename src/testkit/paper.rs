//! The papers' algorithms as they stand, once sound and once with each of their faults.

use super::{History, Structure};
use crate::math::{index_u32, index_usize};

/// What can be wrong in [`PaperLodf`]; faults that are printed in the papers, or that are easily
/// made when they are followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaperFault {
    /// Visible leaves are those that the static `next` list leads to, as printed
    /// ([RRCGR](crate::references), Figures 5 and 8).
    LiteralList,
    /// `n_split = n_leaves + Active_leaves`, as printed in Algorithm 4; it must be minus.
    SplitWithPlus,
    /// The split loop of Algorithm 2 uses the entry at `index` and then steps back, as printed: that
    /// of the next operation, not of the last one done.
    SplitReadsNextEntry,
    /// `while (gr <= NUMBER_GROUPS)`, as printed in Algorithm 3: one group too many, which is the
    /// first one of the instance that lies behind.
    GroupLoopRunsOn,
    /// After clusters stood apart, the cursor into `Changed_groups` is used as if nothing were.
    CursorNotResynchronised,
    /// `n_actual_leaves` is never updated, as printed in Algorithm 2.
    LeafCountNeverUpdated,
    /// A new leaf's birth is that of the collapse after the one that makes it.
    BirthStampLate,
    /// The arrays are "stored by levels of depth of the binary tree", as both papers say; `Init += 2`
    /// is right for the order of consumption only.
    StoredByDepth,
    /// Where a collapse consumes `old1`, the arrays name `old2` a second time.
    SecondOperandTwice,
    /// A collapse moves `Init_group` by one leaf, not by two.
    InitMovesByOne,
}

/// LoDF as the papers have it ([RRCGR](crate::references), Algorithms 2 to 4), with the repairs that
/// it needs: visible leaves are found by their birth, splits read the entry of the last collapse
/// done, and a step after clusters stood apart first brings every cluster back in step.
///
/// With a fault it has one of them less, or one mistake more; `spinney selftest` shows that each is
/// found.
#[derive(Debug, Clone)]
pub struct PaperLodf {
    fault: Option<PaperFault>,
    /// The papers' `List`, a cluster each.
    lists: Vec<Vec<Entry>>,
    /// The papers' `Group`s, of this instance and then of the one that lies behind it.
    groups: Vec<Group>,
    changed_groups: Vec<u32>,
    /// The cursor into `changed_groups`: how many collapses are done.
    index: usize,
    /// Whether the cursor describes the groups.
    is_in_step: bool,
    n_actual_leaves: u32,
    leaf_count: u32,
}

#[derive(Debug, Clone, Copy)]
struct Entry {
    leaf: u32,
    /// 0 for an original, `k` for what the cluster's `k`-th collapse makes.
    birth: u32,
    /// The papers' link; the list's own end for none.
    next: usize,
}

#[derive(Debug, Clone, Copy)]
struct Group {
    init_group: i64,
    active_leaves: i64,
    list: usize,
}

impl Group {
    fn collapse(&mut self, count: i64, step: i64) {
        self.init_group += step * count;
        self.active_leaves -= count;
    }
}

impl PaperLodf {
    /// The structure at full detail; without a fault it is sound.
    #[must_use]
    pub fn new(history: &History, fault: Option<PaperFault>) -> Self {
        let clusters = &history.clusters().clusters;
        let lists: Vec<Vec<Entry>> = (0..clusters.len())
            .map(|cluster| list(history, cluster, fault))
            .collect();
        let group = |(list, cluster): (usize, &crate::simplify::Cluster)| Group {
            init_group: 0,
            active_leaves: i64::from(cluster.original_count()),
            list,
        };
        let own = clusters.iter().enumerate().map(group);
        let behind = clusters.iter().enumerate().map(group);
        Self {
            fault,
            lists,
            groups: own.chain(behind).collect(),
            changed_groups: history.clusters().changed_groups.clone(),
            index: 0,
            is_in_step: true,
            n_actual_leaves: history.leaf_count(),
            leaf_count: history.leaf_count(),
        }
    }

    fn has(&self, fault: PaperFault) -> bool {
        self.fault == Some(fault)
    }

    fn number_groups(&self) -> usize {
        self.lists.len()
    }

    /// How far a collapse moves `Init_group`.
    fn step(&self) -> i64 {
        if self.has(PaperFault::InitMovesByOne) {
            1
        } else {
            2
        }
    }

    /// Algorithm 2: to a number of leaves, one operation after another.
    fn uniform(&mut self, n_leaves: u32) {
        if !self.is_in_step && !self.has(PaperFault::CursorNotResynchronised) {
            self.resynchronise(self.leaf_count.saturating_sub(n_leaves));
        }
        self.is_in_step = true;
        let step = self.step();
        for _ in n_leaves..self.n_actual_leaves {
            let Some(&group) = self.changed_groups.get(self.index) else {
                break;
            };
            self.groups[group as usize].collapse(1, step);
            self.index += 1;
        }
        for _ in self.n_actual_leaves..n_leaves {
            let entry = if self.has(PaperFault::SplitReadsNextEntry) {
                Some(self.index)
            } else {
                self.index.checked_sub(1)
            };
            if let Some(&group) = entry.and_then(|entry| self.changed_groups.get(entry)) {
                self.groups[group as usize].collapse(-1, step);
            }
            self.index = self.index.saturating_sub(1);
        }
        if !self.has(PaperFault::LeafCountNeverUpdated) {
            self.n_actual_leaves = n_leaves;
        }
    }

    /// Brings every cluster to what the first `collapses` of the sequence leave of it.
    fn resynchronise(&mut self, collapses: u32) {
        self.index = (collapses as usize).min(self.changed_groups.len());
        self.n_actual_leaves = self.leaf_count - index_u32(self.index);
        let done = &self.changed_groups[..self.index];
        for (number, group) in (0..).zip(&mut self.groups[..self.lists.len()]) {
            let own = done.iter().filter(|&&changed| changed == number).count();
            let own = i64::from(index_u32(own));
            let standing = group.init_group / 2;
            group.collapse(own - standing, 2);
        }
    }

    /// The leaves of one group, from `Init_group` on.
    fn visualise(&self, group: &Group, shown: &mut Vec<u32>) {
        let list = &self.lists[group.list];
        let mut place = usize::try_from(group.init_group).unwrap_or(usize::MAX);
        let done = group.init_group / 2;
        let mut left = group.active_leaves;
        while let Some(entry) = list.get(place).filter(|_| left > 0) {
            if self.has(PaperFault::LiteralList) {
                shown.push(entry.leaf);
                (place, left) = (entry.next, left - 1);
            } else {
                if i64::from(entry.birth) <= done {
                    shown.push(entry.leaf);
                    left -= 1;
                }
                place += 1;
            }
        }
    }
}

/// The array of one cluster: its leaves in the order in which they are consumed.
fn list(history: &History, cluster: usize, fault: Option<PaperFault>) -> Vec<Entry> {
    let cluster = &history.clusters().clusters[cluster];
    let late = u32::from(fault == Some(PaperFault::BirthStampLate));
    let mut entries: Vec<Entry> = cluster
        .records
        .iter()
        .map(|record| Entry {
            leaf: record.leaf,
            birth: record.birth + if record.birth > 0 { late } else { 0 },
            next: usize::MAX,
        })
        .collect();
    if fault == Some(PaperFault::SecondOperandTwice) {
        for pair in entries.chunks_exact_mut(2) {
            pair[0].leaf = pair[1].leaf;
        }
    }
    if fault == Some(PaperFault::StoredByDepth) {
        let mut depth = vec![0_u32; index_usize(u64::from(history.sequence().record_count()))];
        for (op, [first, second]) in history.collapses().into_iter().enumerate() {
            let below = depth[first as usize].max(depth[second as usize]);
            depth[history.leaf_count() as usize + op] = below + 1;
        }
        entries.sort_by_key(|entry| depth[entry.leaf as usize]);
    }
    // `next`: the originals in array order, then the new leaves in the order of their creation.
    let mut chain: Vec<usize> = (0..entries.len()).collect();
    chain.sort_by_key(|&place| entries[place].birth);
    for pair in chain.windows(2) {
        entries[pair[0]].next = pair[1];
    }
    entries
}

impl Structure for PaperLodf {
    /// Algorithm 3.
    fn visible(&self) -> Vec<u32> {
        let more = usize::from(self.has(PaperFault::GroupLoopRunsOn));
        let mut shown = Vec::new();
        for group in self.groups.iter().take(self.number_groups() + more) {
            self.visualise(group, &mut shown);
        }
        shown
    }

    fn collapse(&mut self) {
        self.uniform(self.n_actual_leaves.saturating_sub(1));
    }

    fn split(&mut self) {
        self.uniform(self.n_actual_leaves.saturating_add(1));
    }

    fn go_to(&mut self, collapses: u32) -> bool {
        self.uniform(self.leaf_count.saturating_sub(collapses));
        true
    }

    /// Algorithm 4.
    fn set_clusters(&mut self, counts: &[u32]) -> bool {
        let (step, plus) = (self.step(), self.has(PaperFault::SplitWithPlus));
        for (group, (&count, list)) in self.groups.iter_mut().zip(counts.iter().zip(&self.lists)) {
            let originals = i64::from(index_u32(list.len().div_ceil(2)));
            let n_leaves = originals - i64::from(count);
            if n_leaves < group.active_leaves {
                let n_collapse = group.active_leaves - n_leaves;
                group.collapse(n_collapse, step);
            } else if n_leaves > group.active_leaves {
                let sign = if plus { 1 } else { -1 };
                let n_split = n_leaves + sign * group.active_leaves;
                group.collapse(-n_split, step);
            }
        }
        self.is_in_step = false;
        true
    }
}

/// The number of leaves for a distance: `most` up to `nearest`, `least` from `farthest` on, linear
/// between ([RRCGR](crate::references), Algorithm 1), by a given way to round the leaves that are
/// gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeafCount {
    /// Whole leaves only are gone: sound.
    WholeLeavesGo,
    /// The number of leaves is rounded to the nearest.
    RoundedToNearest,
    /// A share of all leaves is taken, rounded down, and not kept within the ends.
    ShareOfAll,
}

impl LeafCount {
    /// The number of leaves at a distance, in metres.
    #[must_use]
    pub fn at(self, asked: &super::laws::Asked, distance: f64) -> u32 {
        let share = (distance - asked.nearest) / (asked.farthest - asked.nearest);
        let share = share.clamp(0.0, 1.0);
        let range = f64::from(asked.most - asked.least);
        match self {
            Self::WholeLeavesGo => asked.most - crate::math::whole_u32(share * range),
            Self::RoundedToNearest => asked.most - crate::math::whole_u32(share * range + 0.5),
            Self::ShareOfAll => crate::math::whole_u32((1.0 - share) * f64::from(asked.most)),
        }
    }
}
