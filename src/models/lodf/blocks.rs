//! LoDF with a block of records a cluster on the device, "hardware-oriented": the records of every
//! changed cluster are sent anew.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::surface::{Surface, Uploaded, filled};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::groups::Groups;
use super::{
    Extraction, block_starts, host_bytes, host_size, instance_host_size, price_by_cluster,
};
use crate::gpu::{
    BufferId, Cause, Device, GpuError, IndirectRecord, Queue, Residency, Step, Usage,
};
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
    /// Where each cluster's block begins.
    starts: Arc<[u32]>,
    order: Order,
    extraction: Extraction,
}

impl Blocks {
    pub(in super::super) fn new(crown: Arc<Crown>, order: Order, options: ModelOptions) -> Self {
        Self {
            leaves: LeafBytes::new(&crown, options.format),
            starts: block_starts(&crown).into(),
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
        let parts = (&*self.crown, &self.leaves);
        Uploaded::send(device, environment, self.clone(), parts, Residency::Device)
    }

    fn host_bytes(&self) -> Vec<u8> {
        host_bytes(&self.crown)
    }

    fn storage(&self) -> Storage {
        Storage {
            host_bytes: host_size(&self.crown),
            shared_bytes: self.leaves.vertex_size() + self.leaves.key_size(),
            instance_bytes: BlockBuffers::instance_bytes(&self.crown, &self.leaves),
            instance_host_bytes: instance_host_size(&self.crown),
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
        let starts = &*self.model.starts;
        let stride = leaves.format.record_bytes() as usize;
        let mut bytes = vec![0; stride * crown.sequence().original_count() as usize];
        for ((cluster, &count), &start) in (0..).zip(groups.collapses()).zip(starts) {
            let shown = visible(crown, self.model.order, cluster, count);
            let records = leaves.records(shown);
            bytes[stride * start as usize..][..records.len()].copy_from_slice(&records);
        }
        let arguments = draw_arguments((crown, leaves), starts, groups.collapses(), number);
        let clusters = crown.sequence().root_count();
        let surface = &self.surface;
        let buffers = BlockBuffers::create(device, surface, &bytes, &arguments, clusters)?;
        Ok(Box::new(BlocksResident {
            model: self.model.clone(),
            buffers,
            groups,
        }))
    }
}

#[derive(Debug)]
struct BlocksResident {
    model: Blocks,
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
            starts,
            order,
            extraction,
        } = &self.model;
        let (mut change, touched) = self.groups.extract(crown.clusters(), to, *extraction);
        for (cluster, _) in touched {
            let count = self.groups.collapses()[cluster as usize];
            let shown = visible(crown, *order, cluster, count);
            change.host_records += shown.len() as u64;
            let bytes = leaves.records(shown);
            let offset = leaves.stride() * u64::from(starts[cluster as usize]);
            let cause = Cause::numbered("cluster", cluster);
            queue.write(self.buffers.records, offset, &bytes, cause)?;
            let (offset, count) = BlockBuffers::draw_count((crown, leaves), cluster, count);
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

impl BlocksResident {
    /// The block's visible records and the draw count, if anything changes.
    fn price_of(&self, cluster: u32, collapses: u32) -> u64 {
        if self.groups.collapses()[cluster as usize] == collapses {
            return 0;
        }
        let shown = visible(&self.model.crown, self.model.order, cluster, collapses);
        self.model.leaves.stride() * shown.len() as u64 + 4
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
        surface: &Surface,
        records: &[u8],
        arguments: &[u8],
        clusters: u32,
    ) -> Result<Self, GpuError> {
        let cause = Cause::of("records");
        let records = filled(device, "leaf records", Usage::INDEX, records, cause)?;
        let arguments = filled(device, "draw arguments", Usage::INDIRECT, arguments, cause)?;
        Ok(Self {
            records,
            arguments,
            steps: surface.draw_records(records, arguments, clusters),
        })
    }

    /// Where a cluster's number of corners lies in the arguments, and its bytes after so many
    /// collapses.
    pub(super) fn draw_count(
        (crown, leaves): (&Crown, &LeafBytes),
        cluster: u32,
        collapses: u32,
    ) -> (u64, [u8; 4]) {
        let offset = leaves.argument_stride() * u64::from(cluster);
        let count = corner_count(crown, cluster, collapses);
        (offset, count.to_le_bytes())
    }
}

/// The draw arguments of all clusters, whose blocks begin at `starts`, after so many collapses in
/// each.
pub(super) fn draw_arguments(
    (crown, leaves): (&Crown, &LeafBytes),
    starts: &[u32],
    collapses: &[u32],
    number: u32,
) -> Vec<u8> {
    let argument = |((cluster, &start), &collapses): ((u32, &u32), &u32)| {
        let record = IndirectRecord {
            corner_count: corner_count(crown, cluster, collapses),
            instances: 1,
            first_corner: 4 * start,
            instance: number,
        };
        leaves.argument_bytes(record, cluster)
    };
    let clusters = (0..).zip(starts).zip(collapses);
    clusters.flat_map(argument).collect()
}

fn corner_count(crown: &Crown, cluster: u32, collapses: u32) -> u32 {
    let cluster = &crown.clusters().clusters[cluster as usize];
    4 * (cluster.original_count() - collapses)
}
