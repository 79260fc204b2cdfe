//! No level of detail: every triangle of the mesh, always. The yardstick.

use std::sync::Arc;

use super::surface::{Surface, trunk_buffer, upload_vertices, vertex_bytes};
use super::{TRUNK_GROUP, Trunk, TrunkKind, TrunkLevel, TrunkMode, TrunkModel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Corners, Device, Draw, GpuError, Queue, Residency, Step, Usage,
};
use crate::math::index_u32;
use crate::models::{Change, Environment, Resident, Shared, Storage};
use crate::plant::Mesh;

/// The model without levels.
///
/// 32 bytes a vertex and 12 bytes a triangle, once: in device memory, or for `Host` in host memory.
#[derive(Debug, Clone)]
pub(super) struct Full {
    trunk: Arc<Trunk>,
    mode: TrunkMode,
}

impl Full {
    pub(super) fn new(trunk: Arc<Trunk>, mode: TrunkMode) -> Self {
        Self { trunk, mode }
    }
}

impl TrunkModel for Full {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::Full,
            mode: self.mode,
        }
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
        let residency = self.mode.residency();
        let vertices = upload_vertices(device, &mesh_vertices(mesh), residency)?;
        let bytes = mesh_indices(mesh);
        let descriptor = BufferDescriptor {
            label: "trunk indices",
            size: bytes.len() as u64,
            usage: Usage::INDEX,
            residency,
        };
        let indices = trunk_buffer(device, &descriptor, &bytes)?;
        Ok(Box::new(FullShared {
            vertices,
            indices,
            surface: Surface::of(device, environment, &mesh.material)?,
            corner_count: index_u32(mesh.indices.len()),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        match self.mode.residency() {
            Residency::Host => {
                let mesh = self.trunk.mesh();
                [mesh_vertices(mesh), mesh_indices(mesh)].concat()
            }
            Residency::Device => Vec::new(),
        }
    }

    fn storage(&self) -> Storage {
        let mesh = self.trunk.mesh();
        let bytes = 32 * mesh.positions.len() as u64 + 4 * mesh.indices.len() as u64;
        let (host_bytes, shared_bytes) = match self.mode.residency() {
            Residency::Host => (bytes, 0),
            Residency::Device => (0, bytes),
        };
        Storage {
            host_bytes,
            shared_bytes,
            instance_bytes: 0,
            instance_host_bytes: 0,
        }
    }
}

/// The vertices in the mesh's own order.
fn mesh_vertices(mesh: &Mesh) -> Vec<u8> {
    let order: Vec<u32> = (0..index_u32(mesh.positions.len())).collect();
    vertex_bytes(mesh, &order)
}

fn mesh_indices(mesh: &Mesh) -> Vec<u8> {
    let indices = mesh.indices.iter();
    indices.flat_map(|index| index.to_le_bytes()).collect()
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
