//! LoDF with a block of records a cluster on the device, "hardware-oriented": the records of every
//! changed cluster are sent anew.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::surface::{Surface, Uploaded, filled};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::groups::{Group, Groups};
use super::{Extraction, block_starts, host_bytes, host_size};
use crate::gpu::{
    BufferId, Cause, Device, GpuError, IndirectRecord, Queue, Residency, Step, Usage,
};
use crate::math::index_u32;
use crate::simplify::literal_visible;

/// Which leaves of a cluster are taken for visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Order {
    /// Those that are not consumed and born already: the truth.
    Repaired,
    /// Those that the papers' static `next` list leads to ([RRCGR](crate::references), Figure 5).
    Literal,
}

/// LoDF with resident blocks.
///
/// Host memory: the structures of [`host_bytes`]. Device memory: the vertices once; a block of a
/// record an original leaf and draw arguments a cluster for each instance.
#[derive(Debug, Clone)]
pub(in super::super) struct Blocks {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    order: Order,
    extraction: Extraction,
}

impl Blocks {
    pub(in super::super) fn new(crown: Arc<Crown>, order: Order, options: ModelOptions) -> Self {
        Self {
            leaves: LeafBytes::new(&crown, options.format),
            crown,
            order,
            extraction: options.extraction,
        }
    }
}

impl Model for Blocks {
    fn kind(&self) -> Kind {
        match self.order {
            Order::Repaired => Kind::LodfCluster,
            Order::Literal => Kind::LodfLiteral,
        }
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        let counts = state.counts(self.crown.clusters());
        let numbered = (0..).zip(counts);
        numbered
            .flat_map(|(cluster, count)| visible(&self.crown, self.order, cluster, count))
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
        host_bytes(&self.crown)
    }

    fn storage(&self) -> Storage {
        Storage {
            host_bytes: host_size(&self.crown),
            shared_bytes: self.leaves.vertex_size() + self.leaves.key_size(),
            instance_bytes: BlockBuffers::instance_bytes(&self.crown, &self.leaves),
        }
    }
}

impl Shared for Uploaded<Blocks> {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let Blocks { crown, leaves, .. } = &self.model;
        let groups = Groups::at(crown.clusters(), state);
        let starts = block_starts(crown);
        let stride = leaves.format.record_bytes() as usize;
        let mut bytes = vec![0; stride * crown.sequence().original_count() as usize];
        for ((cluster, group), &start) in (0..).zip(groups.groups()).zip(&starts) {
            let shown = visible(crown, self.model.order, cluster, group.collapses());
            let records = leaves.records(shown);
            bytes[stride * start as usize..][..records.len()].copy_from_slice(&records);
        }
        let buffers = BlockBuffers::create(
            device,
            (crown, leaves),
            &self.surface,
            &bytes,
            groups.groups(),
            number,
        )?;
        Ok(Box::new(BlocksResident {
            model: self.model.clone(),
            starts,
            buffers,
            groups,
        }))
    }
}

#[derive(Debug)]
struct BlocksResident {
    model: Blocks,
    starts: Vec<u32>,
    buffers: BlockBuffers,
    groups: Groups,
}

impl Resident for BlocksResident {
    fn state(&self) -> &State {
        self.groups.state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let Blocks {
            crown,
            leaves,
            order,
            extraction,
        } = &self.model;
        let (mut change, touched) = self.groups.extract(crown.clusters(), to, *extraction);
        for (cluster, _) in touched {
            let group = self.groups.groups()[cluster as usize];
            let shown = visible(crown, *order, cluster, group.collapses());
            change.host_records += shown.len() as u64;
            let bytes = leaves.records(shown);
            let offset = leaves.stride() * u64::from(self.starts[cluster as usize]);
            let cause = Cause::numbered("cluster", cluster);
            queue.write(self.buffers.records, offset, &bytes, cause)?;
            let (offset, count) = BlockBuffers::draw_count(leaves, cluster, group);
            queue.write(
                self.buffers.arguments,
                offset,
                &count,
                draw_count_cause(cluster),
            )?;
        }
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

impl BlocksResident {
    /// The block's visible records and the draw count, if anything changes.
    fn price_of(&self, cluster: u32, collapses: u32) -> u64 {
        if self.groups.groups()[cluster as usize].collapses() == collapses {
            return 0;
        }
        let shown = visible(&self.model.crown, self.model.order, cluster, collapses);
        16 * shown.len() as u64 + 4
    }
}

/// Why a cluster's number of visible leaves is sent.
pub(super) fn draw_count_cause(cluster: u32) -> Cause {
    Cause::numbered("draw-count", cluster)
}

fn visible(crown: &Crown, order: Order, cluster: u32, collapses: u32) -> Vec<u32> {
    let cluster = &crown.clusters().clusters[cluster as usize];
    match order {
        Order::Repaired => cluster.visible(collapses).collect(),
        Order::Literal => literal_visible(cluster, collapses),
    }
}

/// What an instance with blocks keeps on the device.
#[derive(Debug)]
pub(super) struct BlockBuffers {
    pub(super) records: BufferId,
    pub(super) arguments: BufferId,
    pub(super) steps: Vec<Step>,
}

impl BlockBuffers {
    pub(super) fn instance_bytes(crown: &Crown, leaves: &LeafBytes) -> u64 {
        leaves.stride() * u64::from(crown.sequence().original_count())
            + leaves.argument_stride() * u64::from(crown.sequence().root_count())
    }

    pub(super) fn create(
        device: &mut Device,
        (crown, leaves): (&Crown, &LeafBytes),
        surface: &Surface,
        records: &[u8],
        groups: &[Group],
        number: u32,
    ) -> Result<Self, GpuError> {
        let arguments: Vec<u8> = (0..)
            .zip(groups)
            .zip(block_starts(crown))
            .flat_map(|((cluster, group), start)| {
                let record = IndirectRecord {
                    corner_count: 4 * group.active_leaves,
                    instances: 1,
                    first_corner: 4 * start,
                    instance: number,
                };
                leaves.argument_bytes(record, cluster)
            })
            .collect();
        let cause = Cause::of("records");
        let records = filled(device, "leaf records", Usage::INDEX, records, cause)?;
        let arguments = filled(device, "draw arguments", Usage::INDIRECT, &arguments, cause)?;
        Ok(Self {
            records,
            arguments,
            steps: surface.draw_records(records, arguments, index_u32(groups.len())),
        })
    }

    /// Where a cluster's number of corners lies in the arguments, and its bytes.
    pub(super) fn draw_count(leaves: &LeafBytes, cluster: u32, group: Group) -> (u64, [u8; 4]) {
        let offset = leaves.argument_stride() * u64::from(cluster);
        (offset, (4 * group.active_leaves).to_le_bytes())
    }
}
