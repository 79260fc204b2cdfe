//! No level of detail: every triangle of the mesh, always. The yardstick.

use std::sync::Arc;

use super::surface::{Surface, TRUNK, upload_vertices, vertex_bytes};
use super::{TRUNK_GROUP, Trunk, TrunkKind, TrunkLevel, TrunkModel};
use crate::gpu::{BufferId, Corners, Device, Draw, GpuError, Queue, Residency, Step, Usage};
use crate::math::index_u32;
use crate::models::surface::filled;
use crate::models::{Change, Environment, Resident, Shared, Storage};

/// The model without levels.
///
/// Host memory: none. Device memory: 32 bytes a vertex and 12 bytes a triangle, once.
#[derive(Debug, Clone)]
pub(super) struct Full {
    trunk: Arc<Trunk>,
}

impl Full {
    pub(super) fn new(trunk: Arc<Trunk>) -> Self {
        Self { trunk }
    }
}

impl TrunkModel for Full {
    fn kind(&self) -> TrunkKind {
        TrunkKind::Full
    }

    fn trunk(&self) -> &Arc<Trunk> {
        &self.trunk
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared<TrunkLevel>>, GpuError> {
        let mesh = self.trunk.mesh();
        let bytes = vertex_bytes(mesh, 0..mesh.positions.len());
        let vertices = upload_vertices(device, &bytes, Residency::Device)?;
        let indices = mesh.indices.iter().flat_map(|index| index.to_le_bytes());
        let bytes: Vec<u8> = indices.collect();
        Ok(Box::new(FullShared {
            vertices,
            indices: filled(device, "trunk indices", Usage::INDEX, &bytes, TRUNK)?,
            surface: Surface::upload(device, environment, mesh)?,
            corner_count: index_u32(mesh.indices.len()),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        let mesh = self.trunk.mesh();
        Storage {
            host_bytes: 0,
            shared_bytes: 32 * mesh.positions.len() as u64 + 4 * mesh.indices.len() as u64,
            instance_bytes: 0,
            instance_host_bytes: 0,
        }
    }
}

#[derive(Debug)]
struct FullShared {
    vertices: BufferId,
    indices: BufferId,
    surface: Surface,
    corner_count: u32,
}

impl Shared<TrunkLevel> for FullShared {
    fn instance(
        &self,
        _device: &mut Device,
        _level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let mut steps = self.surface.bind(self.vertices, self.indices);
        steps.push(Step::Draw(Draw {
            source: Corners::Indexed,
            first_corner: 0,
            corner_count: self.corner_count,
            instance: number,
            group: TRUNK_GROUP,
        }));
        Ok(Box::new(FullResident { steps }))
    }
}

#[derive(Debug)]
struct FullResident {
    steps: Vec<Step>,
}

impl Resident<TrunkLevel> for FullResident {
    fn state(&self) -> &TrunkLevel {
        &TrunkLevel::FINEST
    }

    fn commit(&mut self, _queue: &mut Queue<'_>, _to: &TrunkLevel) -> Result<Change, GpuError> {
        Ok(Change::default())
    }

    fn price(&self, _to: &TrunkLevel) -> u64 {
        0
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn host_bytes(&self) -> u64 {
        0
    }
}
