//! LoDF: leaf collapse and split in independent clusters ([RRCGR](crate::references),
//! [RCRG06](crate::references)).
//!
//! ```text
//!  State ──extract──▶ Groups (Init_group, Active_leaves a cluster) ──▶ which clusters changed
//!                                                                      │
//!      Host: a list in host memory ◀───────────┬──────────┬────────────┤
//!      Blocks: changed clusters sent whole ◀───┘          │            │
//!      Slots: changed records sent ◀──────────────────────┘            │
//!      Stamps: a counter, or thresholds of changed clusters ◀──────────┤
//!      Refined: the same, or the camera alone ◀────────────────────────┘
//! ```

mod blocks;
mod device;
mod groups;
mod host;
mod rooms;
mod slots;
mod stamps;

pub(super) use blocks::{Blocks, Order};
pub(super) use device::Refined;
pub use groups::Extraction;
pub(super) use host::Host;
pub(super) use slots::{Slots, send};
pub(super) use stamps::Stamps;

use super::format::LeafBytes;
use super::{Crown, Records, State};

/// How several changed ranges are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gather {
    /// Each as a transfer of its own.
    Single,
    /// All of a change in one transfer, then one copy region each.
    Regions,
}

/// The papers' host structures as bytes, little-endian: `Leaf` (4 vertex indices) for every leaf;
/// the clusters' arrays (leaf number and birth, 8 bytes an entry); `Init_group` and
/// `Active_leaves` a cluster; `Changed_groups`.
fn host_bytes(crown: &Crown) -> Vec<u8> {
    let clusters = crown.clusters();
    let mut bytes = crown.records_bytes(0..crown.sequence().record_count());
    let mut word = |word: u32| bytes.extend(word.to_le_bytes());
    for record in clusters
        .clusters
        .iter()
        .flat_map(|cluster| &cluster.records)
    {
        word(record.leaf);
        word(record.birth);
    }
    for cluster in &clusters.clusters {
        word(0);
        word(cluster.original_count());
    }
    clusters.changed_groups.iter().copied().for_each(word);
    bytes
}

/// The length of [`host_bytes`]: 24 bytes a leaf, old or new, 8 a cluster, 4 a collapse.
fn host_size(crown: &Crown) -> u64 {
    let sequence = crown.sequence();
    24 * u64::from(sequence.record_count())
        + 8 * u64::from(sequence.root_count())
        + 4 * u64::from(sequence.collapse_count())
}

/// What every instance keeps on the host: the cursor, and how far each cluster is, 4 bytes each.
fn instance_host_size(crown: &Crown) -> u64 {
    4 + 4 * u64::from(crown.sequence().root_count())
}

/// The vertices to which compact records count, 4 bytes a cluster; nothing for wide ones.
fn first_vertex_bytes(crown: &Crown, leaves: &LeafBytes) -> Option<Vec<u8>> {
    let clusters = 0..crown.sequence().root_count();
    (leaves.format.records == Records::Compact).then(|| {
        clusters
            .flat_map(|cluster| leaves.first_vertex(cluster).to_le_bytes())
            .collect()
    })
}

/// The payload of a change to a state, where that of each cluster stands for itself.
fn price_by_cluster(crown: &Crown, to: &State, price_of: impl Fn(u32, u32) -> u64) -> u64 {
    let counts = (0..).zip(to.counts(crown.clusters()));
    counts
        .map(|(cluster, count)| price_of(cluster, count))
        .sum()
}

/// Where each cluster's block of records begins, in records: `m` a cluster.
fn block_starts(crown: &Crown) -> Vec<u32> {
    let sizes = crown
        .clusters()
        .clusters
        .iter()
        .map(|cluster| cluster.original_count());
    sizes
        .scan(0, |next, size| {
            let start = *next;
            *next += size;
            Some(start)
        })
        .collect()
}
