//! LoDF with slots: of a changed cluster only the records that differ are sent.
//!
//! A block holds one slot an original leaf; the first `m − c` are visible. A collapse puts the new
//! leaf into old1's slot and the last visible slot's leaf into old2's; the slot that falls dead
//! keeps what it held. Where old1 or old2 stands in the last slot, one write is enough. So the whole
//! block, dead slots included, is a pure function of the collapses done: nothing remembers the way.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::surface::{Surface, Uploaded};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::blocks::{BlockBuffers, draw_count_cause};
use super::groups::Groups;
use super::{Gather, block_starts, host_bytes, host_size};
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
        let (crown, leaves) = (&self.crown, &self.leaves);
        let surface = Surface::upload(device, environment, crown, leaves, Residency::Device)?;
        let model = self.clone();
        Ok(Box::new(Uploaded { model, surface }))
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

    /// Goes from one number of collapses to another; returns the slots whose leaf differs, ascending.
    fn go(&self, cluster: &Cluster, content: &mut [u32], from: u32, to: u32) -> Vec<usize> {
        let mut before: Vec<(usize, u32)> = Vec::new();
        let mut note = |content: &[u32], slots: [u32; 2]| {
            for slot in slots.map(|slot| slot as usize) {
                if !before.iter().any(|(known, _)| *known == slot) {
                    before.push((slot, content[slot]));
                }
            }
        };
        for collapse in from as usize..to as usize {
            note(content, self.slots[collapse]);
            self.collapse(content, collapse);
        }
        for collapse in (to as usize..from as usize).rev() {
            note(content, self.slots[collapse]);
            self.split(cluster, content, collapse);
        }
        let differs = before
            .into_iter()
            .filter(|&(slot, leaf)| content[slot] != leaf);
        let mut slots: Vec<usize> = differs.map(|(slot, _)| slot).collect();
        slots.sort_unstable();
        slots
    }

    /// Does one collapse; returns the slots that it wrote.
    fn collapse(&self, content: &mut [u32], collapse: usize) -> [Option<usize>; 2] {
        let last = content.len() - collapse - 1;
        let [first, second] = self.slots[collapse].map(|slot| slot as usize);
        let new = self.new_leaves[collapse];
        if first == last {
            content[second] = new;
            return [None, Some(second)];
        }
        content[first] = new;
        if second == last {
            return [Some(first), None];
        }
        content[second] = content[last];
        [Some(first), Some(second)]
    }

    /// Undoes one collapse; returns the slots that it wrote.
    fn split(&self, cluster: &Cluster, content: &mut [u32], collapse: usize) -> [Option<usize>; 2] {
        let last = content.len() - collapse - 1;
        // The dead last slot kept what it held.
        self.slots[collapse].map(|slot| slot as usize).map({
            let mut operands = operands(cluster, collapse).into_iter();
            move |slot| {
                let old = operands.next().expect("two slots, two operands");
                (slot != last).then(|| {
                    content[slot] = old;
                    slot
                })
            }
        })
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
        let content: Vec<Vec<u32>> = crown
            .clusters()
            .clusters
            .iter()
            .zip(&*self.model.plan)
            .zip(groups.groups())
            .map(|((cluster, plan), group)| plan.at(cluster, group.collapses()))
            .collect();
        let bytes = leaves.records(content.iter().flatten().copied());
        let buffers = BlockBuffers::create(
            device,
            (crown, leaves),
            &self.surface,
            &bytes,
            groups.groups(),
            number,
        )?;
        Ok(Box::new(SlotsResident {
            model: self.model.clone(),
            starts: block_starts(crown),
            buffers,
            groups,
            content,
        }))
    }
}

#[derive(Debug)]
struct SlotsResident {
    model: Slots,
    starts: Vec<u32>,
    buffers: BlockBuffers,
    groups: Groups,
    /// The leaf in every slot: the same as on the device.
    content: Vec<Vec<u32>>,
}

impl SlotsResident {
    /// Moves one cluster to its new number of collapses; returns the slots whose leaf differs.
    fn move_cluster(&mut self, number: usize, from: u32, to: u32) -> Vec<usize> {
        let cluster = &self.model.crown.clusters().clusters[number];
        self.model.plan[number].go(cluster, &mut self.content[number], from, to)
    }

    /// The slots that differ and the draw count, if anything changes.
    fn price_of(&self, cluster: u32, to: u32) -> u64 {
        let number = cluster as usize;
        let from = self.groups.groups()[number].collapses();
        if from == to {
            return 0;
        }
        let cluster = &self.model.crown.clusters().clusters[number];
        let mut content = self.content[number].clone();
        let slots = self.model.plan[number].go(cluster, &mut content, from, to);
        16 * slots.len() as u64 + 4
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
            let group = self.groups.groups()[cluster as usize];
            let number = cluster as usize;
            for slot in self.move_cluster(number, from, group.collapses()) {
                let leaves = &self.model.leaves;
                let place = u64::from(self.starts[number]) + slot as u64;
                let offset = leaves.stride() * place;
                let record = leaves.record(self.content[number][slot]);
                slot_writes.push((offset, record, cluster));
            }
            let (offset, count) = BlockBuffers::draw_count(&self.model.leaves, cluster, group);
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
        let counts = (0..).zip(to.counts(self.model.crown.clusters()));
        counts
            .map(|(cluster, count)| self.price_of(cluster, count))
            .sum()
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        let price = || self.price_of(cluster, collapses);
        matches!(self.state(), State::Variable { .. }).then(price)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.buffers.steps);
    }
}

/// Sends several regions, each by itself or all in one.
pub(super) fn send(
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
    fn slots_hold_the_visible_leaves_and_splits_undo_collapses() {
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
                    if count > 0 {
                        let mut back = content.clone();
                        let written = plan.split(cluster, &mut back, count as usize - 1);
                        assert_eq!(back, plan.at(cluster, count - 1));
                        assert!(written.iter().flatten().count() >= 1, "something changes");
                    }
                }
            }
        }
    }

    #[test]
    fn an_operand_in_the_last_slot_costs_one_write() {
        // Slots 0 1 2; old2 = leaf 2 stands last, then old1 = leaf 3 in slot 0, old2 = 1 last.
        let last_second = Clusters::of(&examples::sequence(3, &[[0, 2], [3, 1]]));
        let cluster = &last_second.clusters[0];
        let plan = ClusterSlots::of(cluster, 3);
        let mut content = ClusterSlots::finest(cluster);
        assert_eq!(plan.collapse(&mut content, 0), [Some(0), None]);
        assert_eq!(content, [3, 1, 2]);
        // Slots 0 1 2; old1 = leaf 2 stands last: the new leaf goes straight to old2's slot.
        let last_first = Clusters::of(&examples::sequence(3, &[[2, 0], [3, 1]]));
        let cluster = &last_first.clusters[0];
        let plan = ClusterSlots::of(cluster, 3);
        let mut content = ClusterSlots::finest(cluster);
        assert_eq!(plan.collapse(&mut content, 0), [None, Some(0)]);
        assert_eq!(content, [3, 1, 2]);
    }
}
