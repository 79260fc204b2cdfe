//! No level of detail: every original leaf, always. The yardstick.

use std::sync::Arc;

use super::leaf::LeafProgram;
use super::surface::{LEAF_GROUP, Surface, Uploaded};
use super::{Change, Crown, Environment, Kind, Model, Resident, Shared, State, Storage};
use crate::gpu::{Corners, Device, Draw, GpuError, Queue, Residency, Step};

/// The model without levels.
///
/// Host memory: none. Device memory: the vertices, 12 bytes each.
#[derive(Debug, Clone)]
pub(super) struct Full {
    crown: Arc<Crown>,
}

impl Full {
    pub(super) fn new(crown: Arc<Crown>) -> Self {
        Self { crown }
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
        let surface = Surface::upload(device, environment, &self.crown, Residency::Device)?;
        let model = self.clone();
        Ok(Box::new(Uploaded { model, surface }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        let shared_bytes = 12 * self.crown.vertices().len() as u64;
        Storage {
            host_bytes: 0,
            shared_bytes,
            instance_bytes: 0,
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
        self.surface.bind(LeafProgram::Indexed, &mut steps);
        steps.push(Step::Vertices(self.surface.vertices));
        steps.push(Step::Draw(Draw {
            source: Corners::Counted,
            first_corner: 0,
            corner_count: 4 * self.model.crown.sequence().original_count(),
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

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }
}
