//! The compute program that expands collapses: from operands and masks to the windows' records.
//!
//! What is sent, little-endian, in place of a record of 16 bytes for every leaf, old or new:
//!
//! | buffer | bytes a collapse | |
//! |---|---:|---|
//! | operands | 8 | the two leaves that disappear, `u32` each |
//! | masks | ½ | bit `4 k + role`: the corner of that role comes from the second |
//!
//! Only collapses that take all corners from their operands can be sent so; others are not, and their
//! records are sent as they are.
//!
//! The corners of an original leaf are its own four vertices, so it needs nothing. A new leaf's corner is
//! found by going down from leaf to operand, as the masks say, until an original is reached. Each record
//! is found by itself, so groups depend on nothing that others write. This runs once, at upload; the two
//! buffers stay.

use super::Crown;
use super::select_pass::{CLUSTER_WORDS, CROWN_WORDS};
use crate::gpu::{Access, ComputeLayout, ComputeProgram, GpuError, Group};

/// The slot of the [crown](super::select_pass).
pub(super) const EXPANDED_CROWN_SLOT: u32 = 0;
/// The slot of the operands.
pub(super) const OPERAND_SLOT: u32 = 1;
/// The slot of the masks.
pub(super) const MASK_SLOT: u32 = 2;
/// The slot of the original leaves' numbers, cluster by cluster, within one ascending.
pub(super) const LEAF_NUMBER_SLOT: u32 = 3;
/// The slot of the records: written.
pub(super) const EXPANDED_RECORD_SLOT: u32 = 4;

/// Records a group.
const GROUP_RECORDS: u32 = 64;
/// Words of a compact record with birth and cluster.
const RECORD_WORDS: u32 = 4;

/// How many groups expand so many records.
pub(super) fn expand_groups(records: u32) -> u32 {
    records.div_ceil(GROUP_RECORDS)
}

/// Whether operands and masks say all of a crown's collapses: no new leaf has vertices of its own.
pub(super) fn expands(crown: &Crown) -> bool {
    crown.sequence().added_vertices().is_empty()
}

/// How many bytes operands and masks have.
pub(super) fn collapse_sizes(crown: &Crown) -> [u64; 2] {
    let collapses = u64::from(crown.sequence().collapse_count());
    [8 * collapses, 4 * collapses.div_ceil(8)]
}

/// The bytes of operands and of masks.
///
/// # Errors
///
/// [`GpuError::Unsupported`] when an original leaf has other corners than its own vertices.
pub(super) fn collapse_bytes(crown: &Crown) -> Result<[Vec<u8>; 2], GpuError> {
    let sequence = crown.sequence();
    let originals = sequence.original_count();
    let own = |leaf: u32| [0, 1, 2, 3].map(|role| 4 * leaf + role);
    let numbered = (0..originals).zip(sequence.corners());
    if let Some((leaf, _)) = numbered.into_iter().find(|(leaf, at)| **at != own(*leaf)) {
        return Err(GpuError::Unsupported {
            what: format!(
                "expanding original leaf {leaf}, whose corners are not its own vertices,"
            ),
        });
    }
    let (mut operands, mut masks) = (Vec::new(), Vec::new());
    for together in sequence.collapses().chunks(8) {
        let mut word = 0_u32;
        for (place, collapse) in together.iter().enumerate() {
            let number = operands.len() / 8;
            operands.extend(collapse.old.iter().flat_map(|leaf| leaf.to_le_bytes()));
            let [first, new] = [collapse.old[0] as usize, originals as usize + number];
            let corners = sequence.corners();
            for (role, (new, first)) in corners[new].iter().zip(corners[first]).enumerate() {
                word |= u32::from(*new != first) << (4 * place + role);
            }
        }
        masks.extend(word.to_le_bytes());
    }
    Ok([operands, masks])
}

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExpandPass;

impl ComputeProgram for ExpandPass {
    fn layout(&self) -> ComputeLayout {
        const SLOTS: [Access; 5] = [
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Own {
                group_bytes: 4 * RECORD_WORDS * GROUP_RECORDS,
            },
        ];
        ComputeLayout {
            name: "expand",
            version: 1,
            slots: &SLOTS,
            // A record: some searches of 24 steps, and four ways down of 32 leaves, as trees have that
            // are not chains.
            group_operations: GROUP_RECORDS * 512,
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let crown = Expansion::read(group);
        let first = GROUP_RECORDS * group.number();
        let owned = group.len(EXPANDED_RECORD_SLOT as usize) / RECORD_WORDS as usize;
        for (place, number) in (0..owned).zip(first..) {
            let (cluster, position) = crown.cluster_of_record(group, number);
            let leaf = crown.leaf(group, cluster, position);
            let corners = crown.corners(group, cluster, leaf);
            let birth = match leaf.checked_sub(crown.originals) {
                None => 0,
                Some(op) => 1 + crown.local_collapse(group, cluster, op),
            };
            let [a, b, c, d] = corners;
            let words = [a | b << 16, c | d << 16, birth, cluster.number];
            for (word, value) in words.into_iter().enumerate() {
                let at = RECORD_WORDS as usize * place + word;
                group.set(EXPANDED_RECORD_SLOT as usize, at, value);
            }
        }
    }
}

/// What a group knows of the crown.
#[derive(Clone, Copy)]
struct Expansion {
    originals: u32,
    clusters: u32,
}

/// A cluster of it.
#[derive(Clone, Copy)]
struct Cluster {
    number: u32,
    /// Collapses of the clusters before it.
    before: u32,
    originals: u32,
}

impl Expansion {
    fn read(group: &mut Group<'_>) -> Self {
        let [originals, clusters] = group.u32s(EXPANDED_CROWN_SLOT as usize, 3);
        Self {
            originals,
            clusters,
        }
    }

    fn cluster(self, group: &mut Group<'_>, number: u32) -> Cluster {
        let first = CROWN_WORDS + CLUSTER_WORDS * number as usize;
        let [before, originals] = group.u32s(EXPANDED_CROWN_SLOT as usize, first);
        Cluster {
            number,
            before,
            originals,
        }
    }

    /// The cluster of a record, and the record's place in the order of consumption there.
    fn cluster_of_record(self, group: &mut Group<'_>, record: u32) -> (Cluster, u32) {
        // The last cluster that begins at the record or before it.
        let start = |cluster: Cluster| 2 * cluster.before + cluster.number;
        let after = least(self.clusters, |number| {
            start(self.cluster(group, number)) > record
        });
        let cluster = self.cluster(group, after.saturating_sub(1));
        (cluster, record - start(cluster))
    }

    /// The leaf at a place of a cluster: an operand of one of its collapses, or its root.
    fn leaf(self, group: &mut Group<'_>, cluster: Cluster, position: u32) -> u32 {
        let collapses = cluster.originals - 1;
        if position < 2 * collapses {
            let op = self.op(group, cluster, position / 2);
            let at = 2 * op as usize + position as usize % 2;
            return group.u32(OPERAND_SLOT as usize, at);
        }
        match collapses.checked_sub(1) {
            Some(last) => self.originals + self.op(group, cluster, last),
            // Its only leaf.
            None => group.u32(LEAF_NUMBER_SLOT as usize, cluster.first_place()),
        }
    }

    /// The number in the sequence of a cluster's collapse.
    fn op(self, group: &mut Group<'_>, cluster: Cluster, local: u32) -> u32 {
        let ops = CROWN_WORDS + CLUSTER_WORDS * self.clusters as usize;
        let at = ops + (cluster.before + local) as usize;
        group.u32(EXPANDED_CROWN_SLOT as usize, at)
    }

    /// Which collapse of its cluster a collapse of the sequence is.
    fn local_collapse(self, group: &mut Group<'_>, cluster: Cluster, op: u32) -> u32 {
        least(cluster.originals - 1, |local| {
            self.op(group, cluster, local) >= op
        })
    }

    /// The corners of a leaf, counted from the cluster's first vertex.
    fn corners(self, group: &mut Group<'_>, cluster: Cluster, leaf: u32) -> [u32; 4] {
        [0, 1, 2, 3].map(|role| {
            let mut leaf = leaf;
            // Operands are older than what is made of them, so this ends.
            while let Some(op) = leaf.checked_sub(self.originals) {
                let mask = group.u32(MASK_SLOT as usize, op as usize / 8);
                let second = mask >> (4 * (op % 8) + role) & 1;
                leaf = group.u32(OPERAND_SLOT as usize, 2 * op as usize + second as usize);
            }
            let first = cluster.first_place();
            let place = least(cluster.originals, |place| {
                group.u32(LEAF_NUMBER_SLOT as usize, first + place as usize) >= leaf
            });
            4 * place + role
        })
    }
}

impl Cluster {
    /// How many original leaves the clusters before it have: one more than collapses, each.
    fn first_place(self) -> usize {
        (self.before + self.number) as usize
    }
}

/// The least number below `count` for which something holds that holds for all after it; `count` if
/// there is none.
fn least(count: u32, mut holds: impl FnMut(u32) -> bool) -> u32 {
    let (mut from, mut to) = (0, count);
    while from < to {
        let middle = from + (to - from) / 2;
        if holds(middle) {
            to = middle;
        } else {
            from = middle + 1;
        }
    }
    from
}
