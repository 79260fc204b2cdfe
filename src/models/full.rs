//! No level of detail: every original leaf, always. The yardstick.

use std::sync::Arc;

use super::format::LeafBytes;
use super::leaf::LeafSource;
use super::surface::{LEAF_GROUP, Uploaded};
use super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use crate::gpu::{Corners, Device, Draw, GpuError, Queue, Residency, Step};

/// The model without levels.
///
/// Host memory: none. Device memory: the vertices of the original leaves, in the order of the plant whatever the format of
/// records, since it has none.
#[derive(Debug, Clone)]
pub(super) struct Full {
    crown: Arc<Crown>,
    leaves: LeafBytes,
}

impl Full {
    pub(super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let leaves = LeafBytes::of_originals(&crown, options.format.vertices);
        Self { crown, leaves }
    }
}

impl Model for Full {
    fn kind(&self) -> Kind {
        Kind::Full
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, _state: &State) -> Vec<u32> {
        (0..self.crown.sequence().original_count()).collect()
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
        Vec::new()
    }

    fn storage(&self) -> Storage {
        Storage {
            host_bytes: 0,
            shared_bytes: self.leaves.vertex_size() + self.leaves.key_size(),
            instance_bytes: 0,
            instance_host_bytes: 0,
        }
    }
}

impl Shared for Uploaded<Full> {
    fn instance(
        &self,
        _device: &mut Device,
        _state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let mut steps = Vec::new();
        let leaves = self.model.crown.sequence().original_count();
        if leaves == 0 {
            return Ok(Box::new(FullResident { steps }));
        }
        self.surface.bind(LeafSource::Indexed, &mut steps);
        steps.push(Step::Vertices(self.surface.vertices));
        steps.push(Step::Draw(Draw {
            source: Corners::Counted,
            first_corner: 0,
            corner_count: 4 * leaves,
            instance: number,
            group: LEAF_GROUP,
        }));
        Ok(Box::new(FullResident { steps }))
    }
}

#[derive(Debug)]
struct FullResident {
    steps: Vec<Step>,
}

impl Resident for FullResident {
    fn state(&self) -> &State {
        &State::FINEST
    }

    fn commit(&mut self, _queue: &mut Queue<'_>, _to: &State) -> Result<Change, GpuError> {
        Ok(Change::default())
    }

    fn price(&self, _to: &State) -> u64 {
        0
    }

    fn cluster_price(&self, _cluster: u32, _collapses: u32) -> Option<u64> {
        Some(0)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn host_bytes(&self) -> u64 {
        0
    }
}
