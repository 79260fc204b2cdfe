//! LoDF with slots: of a changed cluster only the records that differ are sent.
//!
//! A block holds one slot an original leaf; the first `m − c` are visible. A collapse puts the new
//! leaf into old1's slot and the last visible slot's leaf into old2's; the slot that falls dead
//! keeps what it held. Where old1 or old2 stands in the last slot, one write is enough. So the whole
//! block, dead slots included, is a pure function of the collapses done: nothing remembers the way.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::surface::Uploaded;
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::blocks::{BlockBuffers, draw_arguments, draw_count_cause};
use super::groups::Groups;
use super::{Gather, block_starts, host_bytes, host_size, instance_host_size, price_by_cluster};
use crate::gpu::{Cause, Device, GpuError, Queue, Region, Residency, Step};
use crate::math::index_u32;
use crate::simplify::Cluster;

/// LoDF with slots.
///
/// Host memory: the structures of [`host_bytes`], then for each cluster the slots of old1 and old2
/// of every collapse (8 bytes). Device memory: as with blocks.
#[derive(Debug, Clone)]
pub(in super::super) struct Slots {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    plan: Arc<Vec<ClusterSlots>>,
    /// Where each cluster's block begins.
    starts: Arc<[u32]>,
    options: ModelOptions,
}

impl Slots {
    pub(in super::super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let clusters = &crown.clusters().clusters;
        let originals = crown.sequence().original_count();
        let plan = clusters
            .iter()
            .map(|cluster| ClusterSlots::of(cluster, originals))
            .collect();
        Self {
            plan: Arc::new(plan),
            leaves: LeafBytes::new(&crown, options.format),
            starts: block_starts(&crown).into(),
            options,
            crown,
        }
    }
}

impl Model for Slots {
    fn kind(&self) -> Kind {
        Kind::LodfSlots
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        let counts = state.counts(self.crown.clusters());
        let clusters = self
            .crown
            .clusters()
            .clusters
            .iter()
            .zip(counts)
            .zip(&*self.plan);
        clusters
            .flat_map(|((cluster, count), plan)| {
                let mut slots = plan.at(cluster, count);
                slots.truncate((cluster.original_count() - count) as usize);
                slots
            })
            .collect()
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let parts = (&*self.crown, &self.leaves);
        Uploaded::send(device, environment, self.clone(), parts, Residency::Device)
    }

    fn host_bytes(&self) -> Vec<u8> {
        let mut bytes = host_bytes(&self.crown);
        let slots = self
            .plan
            .iter()
            .flat_map(|plan| plan.slots.iter().flatten());
        bytes.extend(slots.flat_map(|slot| slot.to_le_bytes()));
        bytes
    }

    fn storage(&self) -> Storage {
        let collapses = u64::from(self.crown.sequence().collapse_count());
        Storage {
            host_bytes: host_size(&self.crown) + 8 * collapses,
            shared_bytes: self.leaves.vertex_size() + self.leaves.key_size(),
            instance_bytes: BlockBuffers::instance_bytes(&self.crown, &self.leaves),
            instance_host_bytes: instance_host_size(&self.crown),
        }
    }
}

/// How the slots of one cluster change.
#[derive(Debug, Clone, PartialEq, Eq)]
struct ClusterSlots {
    /// The new leaf of each local collapse follows from the cluster's own list of operations.
    new_leaves: Vec<u32>,
    /// The slots in which each local collapse finds old1 and old2.
    slots: Vec<[u32; 2]>,
}

impl ClusterSlots {
    fn of(cluster: &Cluster, originals: u32) -> Self {
        let new_leaves = cluster.ops.iter().map(|op| originals + op).collect();
        let mut plan = Self {
            new_leaves,
            slots: Vec::with_capacity(cluster.ops.len()),
        };
        let mut content = Self::finest(cluster);
        for collapse in 0..cluster.ops.len() {
            let [first, second] = operands(cluster, collapse);
            let active = content.len() - collapse;
            let slot = |leaf| {
                let found = content[..active].iter().position(|&held| held == leaf);
                index_u32(found.expect("an operand is visible until it is consumed"))
            };
            plan.slots.push([slot(first), slot(second)]);
            plan.collapse(&mut content, collapse);
        }
        plan
    }

    /// The slots at full detail: the originals in ascending order.
    fn finest(cluster: &Cluster) -> Vec<u32> {
        let mut leaves: Vec<u32> = cluster
            .records
            .iter()
            .filter(|record| record.birth == 0)
            .map(|r| r.leaf)
            .collect();
        leaves.sort_unstable();
        leaves
    }

    /// The slots after `collapses` local collapses.
    fn at(&self, cluster: &Cluster, collapses: u32) -> Vec<u32> {
        let mut content = Self::finest(cluster);
        for collapse in 0..collapses as usize {
            self.collapse(&mut content, collapse);
        }
        content
    }

    /// Does one collapse.
    fn collapse(&self, content: &mut [u32], collapse: usize) {
        let last = content.len() - collapse - 1;
        let [first, second] = self.slots[collapse].map(|slot| slot as usize);
        // Where old1 stands last, the new leaf is what moves into old2's slot.
        let new = self.new_leaves[collapse];
        let moved = if first == last { new } else { content[last] };
        if first != last {
            content[first] = new;
        }
        if second != last {
            content[second] = moved;
        }
    }
}

fn operands(cluster: &Cluster, collapse: usize) -> [u32; 2] {
    [0, 1].map(|operand| cluster.records[2 * collapse + operand].leaf)
}

impl Shared for Uploaded<Slots> {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let Slots { crown, leaves, .. } = &self.model;
        let groups = Groups::at(crown.clusters(), state);
        let clusters = crown.clusters().clusters.iter().zip(&*self.model.plan);
        let content = clusters.zip(groups.collapses());
        let content = content.flat_map(|((cluster, plan), &count)| plan.at(cluster, count));
        let bytes = leaves.records(content);
        let (surface, starts) = (&self.surface, &*self.model.starts);
        let arguments = draw_arguments((crown, leaves), starts, groups.collapses(), number);
        let clusters = crown.sequence().root_count();
        Ok(Box::new(SlotsResident {
            buffers: BlockBuffers::create(device, surface, &bytes, &arguments, clusters)?,
            model: self.model.clone(),
            groups,
        }))
    }
}

/// What the slots hold follows from the collapses done, so an instance does not keep it.
#[derive(Debug)]
struct SlotsResident {
    model: Slots,
    buffers: BlockBuffers,
    groups: Groups,
}

impl Slots {
    /// The slots of a cluster that hold another leaf after `to` collapses than after `from`, ascending,
    /// each with its new leaf.
    fn changed_slots(&self, number: usize, from: u32, to: u32) -> Vec<(usize, u32)> {
        let cluster = &self.crown.clusters().clusters[number];
        let plan = &self.plan[number];
        let [before, after] = [from, to].map(|count| plan.at(cluster, count));
        let slots = before.iter().zip(after).enumerate();
        slots
            .filter(|(_, (before, after))| *before != after)
            .map(|(slot, (_, after))| (slot, after))
            .collect()
    }
}

impl SlotsResident {
    /// The slots that differ and the draw count, if anything changes.
    fn price_of(&self, cluster: u32, to: u32) -> u64 {
        let number = cluster as usize;
        let from = self.groups.collapses()[number];
        if from == to {
            return 0;
        }
        let slots = self.model.changed_slots(number, from, to);
        self.model.leaves.stride() * slots.len() as u64 + 4
    }
}

impl Resident for SlotsResident {
    fn state(&self) -> &State {
        self.groups.state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let crown = Arc::clone(&self.model.crown);
        let ModelOptions {
            extraction, gather, ..
        } = self.model.options;
        let (mut change, touched) = self.groups.extract(crown.clusters(), to, extraction);
        let mut slot_writes: Vec<(u64, Vec<u8>, u32)> = Vec::new();
        let mut count_writes: Vec<(u64, [u8; 4], u32)> = Vec::new();
        for (cluster, from) in touched {
            let count = self.groups.collapses()[cluster as usize];
            let (number, leaves) = (cluster as usize, &self.model.leaves);
            for (slot, leaf) in self.model.changed_slots(number, from, count) {
                let place = u64::from(self.model.starts[number]) + slot as u64;
                slot_writes.push((leaves.stride() * place, leaves.record(leaf), cluster));
            }
            let (offset, count) = BlockBuffers::draw_count((&crown, leaves), cluster, count);
            count_writes.push((offset, count, cluster));
        }
        change.host_records += slot_writes.len() as u64;
        let records = slot_writes.iter().map(|(offset, bytes, cluster)| Region {
            buffer: self.buffers.records,
            offset: *offset,
            bytes,
            cause: Cause::numbered("slot", *cluster),
        });
        let counts = count_writes.iter().map(|(offset, bytes, cluster)| Region {
            buffer: self.buffers.arguments,
            offset: *offset,
            bytes,
            cause: draw_count_cause(*cluster),
        });
        let regions: Vec<Region<'_>> = records.chain(counts).collect();
        send(queue, gather, &regions)?;
        Ok(change)
    }

    fn price(&self, to: &State) -> u64 {
        price_by_cluster(&self.model.crown, to, |cluster, count| {
            self.price_of(cluster, count)
        })
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        let price = || self.price_of(cluster, collapses);
        matches!(self.state(), State::Variable { .. }).then(price)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.buffers.steps);
    }

    fn host_bytes(&self) -> u64 {
        self.groups.host_bytes()
    }
}

/// Sends several regions, each by itself or all in one.
pub(in super::super) fn send(
    queue: &mut Queue<'_>,
    gather: Gather,
    regions: &[Region<'_>],
) -> Result<(), GpuError> {
    match gather {
        Gather::Regions => queue.write_regions(regions),
        Gather::Single => regions.iter().try_for_each(|region| {
            queue.write(region.buffer, region.offset, region.bytes, region.cause)
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify::{Clusters, examples};

    #[test]
    fn slots_hold_the_visible_leaves_and_little_changes() {
        for ops in [examples::WSCG, examples::FRAMEWORK] {
            let clusters = Clusters::of(&examples::sequence(9, &ops));
            for cluster in &clusters.clusters {
                let plan = ClusterSlots::of(cluster, 9);
                for count in 0..cluster.original_count() {
                    let content = plan.at(cluster, count);
                    let active = (cluster.original_count() - count) as usize;
                    let mut shown = content[..active].to_vec();
                    shown.sort_unstable();
                    let mut truth: Vec<u32> = cluster.visible(count).collect();
                    truth.sort_unstable();
                    assert_eq!(shown, truth, "after {count} collapses");
                    let before = plan.at(cluster, count.saturating_sub(1));
                    let differ = before.iter().zip(&content).filter(|(a, b)| a != b);
                    let most = if count > 0 { 1..=2 } else { 0..=0 };
                    assert!(most.contains(&differ.count()), "after {count} collapses");
                }
            }
        }
    }

    #[test]
    fn an_operand_in_the_last_slot_costs_one_write() {
        // Slots 0 1 2; old2 = leaf 2 stands last: slot 0 is written. Old1 = leaf 2 stands last: the
        // new leaf goes straight to old2's slot.
        for first in [[0, 2], [2, 0]] {
            let clusters = Clusters::of(&examples::sequence(3, &[first, [3, 1]]));
            let plan = ClusterSlots::of(&clusters.clusters[0], 3);
            assert_eq!(plan.at(&clusters.clusters[0], 1), [3, 1, 2]);
        }
    }
}
