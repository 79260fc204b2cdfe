//! LoDF in host memory, "not hardware-oriented": every draw pulls what it shows.

use std::sync::Arc;

use super::super::surface::{LEAF_GROUP, LeafDraw, Surface};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::groups::Groups;
use super::{Extraction, host_bytes, host_size};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord,
    Queue, Residency, Step, Usage,
};
use crate::math::index_u32;

/// LoDF with everything in host memory.
///
/// Host memory: 12 bytes a vertex, then the structures of [`host_bytes`]. Device memory: none.
#[derive(Debug)]
pub(in super::super) struct Host {
    crown: Arc<Crown>,
    extraction: Extraction,
}

impl Host {
    pub(in super::super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        Self {
            crown,
            extraction: options.extraction,
        }
    }
}

impl Model for Host {
    fn kind(&self) -> Kind {
        Kind::LodfHost
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        state.visible(self.crown.clusters())
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let surface = Surface::upload(device, environment, &self.crown, Residency::Host)?;
        Ok(Box::new(HostShared {
            crown: Arc::clone(&self.crown),
            extraction: self.extraction,
            surface,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        [self.crown.vertex_bytes(), host_bytes(&self.crown)].concat()
    }

    fn storage(&self) -> Storage {
        let vertices = 12 * self.crown.vertices().len() as u64;
        let host_bytes = vertices + host_size(&self.crown);
        Storage {
            host_bytes,
            shared_bytes: 0,
            instance_bytes: 0,
        }
    }
}

#[derive(Debug)]
struct HostShared {
    crown: Arc<Crown>,
    extraction: Extraction,
    surface: Surface,
}

impl Shared for HostShared {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let list = HostList::create(device, &self.crown, &self.surface, number)?;
        let groups = Groups::at(self.crown.clusters(), state);
        let visible = state.visible(self.crown.clusters());
        list.write(&mut device.queue(), &self.crown, &visible)?;
        let (crown, extraction) = (Arc::clone(&self.crown), self.extraction);
        Ok(Box::new(HostResident {
            crown,
            extraction,
            list,
            groups,
        }))
    }
}

#[derive(Debug)]
struct HostResident {
    crown: Arc<Crown>,
    extraction: Extraction,
    list: HostList,
    groups: Groups,
}

impl Resident for HostResident {
    fn state(&self) -> &State {
        self.groups.state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let clusters = self.crown.clusters();
        let (mut change, touched) = self.groups.extract(clusters, to, self.extraction);
        if !touched.is_empty() {
            let visible = to.visible(clusters);
            self.list.write(queue, &self.crown, &visible)?;
            change.host_records += visible.len() as u64;
        }
        Ok(change)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.list.steps);
    }
}

/// A list of visible leaf records in host memory, drawn as one.
#[derive(Debug)]
pub(in super::super) struct HostList {
    records: BufferId,
    arguments: BufferId,
    number: u32,
    pub(in super::super) steps: Vec<Step>,
}

impl HostList {
    pub(in super::super) fn create(
        device: &mut Device,
        crown: &Crown,
        surface: &Surface,
        number: u32,
    ) -> Result<Self, GpuError> {
        let mut buffer = |label, size, usage| {
            let residency = Residency::Host;
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency,
            })
        };
        let size = 16 * u64::from(crown.sequence().original_count());
        let records = buffer("leaf list", size, Usage::INDEX)?;
        let arguments = buffer(
            "leaf list arguments",
            IndirectRecord::STRIDE,
            Usage::INDIRECT,
        )?;
        let mut steps = Vec::new();
        surface.bind(LeafDraw::Indexed, &mut steps);
        steps.push(Step::Vertices(surface.vertices));
        steps.push(Step::Indices(records));
        steps.push(Step::DrawIndirect(DrawIndirect {
            source: Corners::Indexed,
            arguments,
            offset: 0,
            count: 1,
            group: LEAF_GROUP,
        }));
        Ok(Self {
            records,
            arguments,
            number,
            steps,
        })
    }

    /// Replaces the list; in host memory that costs no bus.
    pub(in super::super) fn write(
        &self,
        queue: &mut Queue<'_>,
        crown: &Crown,
        visible: &[u32],
    ) -> Result<(), GpuError> {
        let bytes = crown.records_bytes(visible.iter().copied());
        queue.write(self.records, 0, &bytes, Cause::of("host"))?;
        let record = IndirectRecord {
            corner_count: 4 * index_u32(visible.len()),
            instances: 1,
            first_corner: 0,
            instance: self.number,
        };
        queue.write(self.arguments, 0, &record.to_bytes(), Cause::of("host"))
    }
}
