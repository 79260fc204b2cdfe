//! LoDF in host memory, "not hardware-oriented": every draw pulls what it shows.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::leaf_list::LeafList;
use super::super::surface::Uploaded;
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::groups::Groups;
use super::{Extraction, host_bytes, host_size, instance_host_size};
use crate::gpu::{Device, GpuError, Queue, Residency, Step};

/// LoDF with everything in host memory.
///
/// Host memory: the vertices, then the structures of [`host_bytes`]. Device memory: none, but for
/// what small formats need.
#[derive(Debug, Clone)]
pub(in super::super) struct Host {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    extraction: Extraction,
}

impl Host {
    pub(in super::super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        Self {
            leaves: LeafBytes::new(&crown, options.format),
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
        let parts = (&*self.crown, &self.leaves);
        Uploaded::send(device, environment, self.clone(), parts, Residency::Host)
    }

    fn host_bytes(&self) -> Vec<u8> {
        [self.leaves.vertices(), host_bytes(&self.crown)].concat()
    }

    fn storage(&self) -> Storage {
        Storage {
            host_bytes: self.leaves.vertex_size() + host_size(&self.crown),
            shared_bytes: self.leaves.key_size(),
            instance_bytes: 0,
            instance_host_bytes: instance_host_size(&self.crown)
                + LeafList::size(&self.crown, &self.leaves),
        }
    }
}

impl Shared for Uploaded<Host> {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let Host { crown, leaves, .. } = &self.model;
        let visible = state.visible(crown.clusters());
        let (surface, residency) = (&self.surface, Residency::Host);
        Ok(Box::new(HostResident {
            list: LeafList::create(
                device,
                (crown, leaves),
                surface,
                residency,
                number,
                &visible,
            )?,
            groups: Groups::at(crown.clusters(), state),
            model: self.model.clone(),
        }))
    }
}

#[derive(Debug)]
struct HostResident {
    model: Host,
    list: LeafList,
    groups: Groups,
}

impl Resident for HostResident {
    fn state(&self) -> &State {
        self.groups.state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let Host {
            crown,
            leaves,
            extraction,
        } = &self.model;
        let clusters = crown.clusters();
        let (mut change, touched) = self.groups.extract(clusters, to, *extraction);
        if !touched.is_empty() {
            let visible = to.visible(clusters);
            self.list.write(queue, (crown, leaves), &visible)?;
            change.host_records += visible.len() as u64;
        }
        Ok(change)
    }

    fn price(&self, _to: &State) -> u64 {
        0
    }

    fn cluster_price(&self, _cluster: u32, _collapses: u32) -> Option<u64> {
        Some(0)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.list.steps);
    }

    fn host_bytes(&self) -> u64 {
        self.groups.host_bytes() + self.list.host_bytes
    }
}
