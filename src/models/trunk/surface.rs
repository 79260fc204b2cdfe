//! A trunk's vertices and material: the same for every model of trunks.

use super::Trunk;
use super::program::SURFACE_SLOT;
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, ProgramId, Residency, Step, TextureId,
    Usage,
};
use crate::models::Environment;
use crate::models::surface::{filled, upload_texture};
use crate::plant::{Material, Mesh};
use crate::scene::TrunkMode;

/// Why what a trunk begins with is sent.
const TRUNK: Cause = Cause::of("trunk");

/// The vertices of a mesh, in the order of `order`, as they lie on the device.
///
/// Position, normal (3 × `f32` each), texture coordinate (2 × `f32`): 32 bytes a vertex.
pub(super) fn vertex_bytes<'a>(
    mesh: &'a Mesh,
    order: impl IntoIterator<Item = &'a u32>,
) -> Vec<u8> {
    let floats = order.into_iter().flat_map(|&vertex| {
        let vertex = vertex as usize;
        let (position, normal) = (mesh.positions[vertex], mesh.normals[vertex]);
        let [x, y, z] = position.to_array();
        let [nx, ny, nz] = normal.to_array();
        let [u, v] = mesh.texture_coordinates[vertex].to_array();
        [x, y, z, nx, ny, nz, u, v]
    });
    floats.flat_map(f32::to_le_bytes).collect()
}

/// Makes a buffer and sends what it begins with, under the cause `trunk`.
pub(super) fn trunk_buffer(
    device: &mut Device,
    descriptor: &BufferDescriptor<'_>,
    bytes: &[u8],
) -> Result<BufferId, GpuError> {
    let buffer = device.create_buffer(descriptor)?;
    device.queue().write(buffer, 0, bytes, TRUNK)?;
    Ok(buffer)
}

/// Makes the buffer of vertices, where `residency` says, and sends them.
pub(super) fn upload_vertices(
    device: &mut Device,
    bytes: &[u8],
    residency: Residency,
) -> Result<BufferId, GpuError> {
    let descriptor = BufferDescriptor {
        label: "trunk vertices",
        size: bytes.len() as u64,
        usage: Usage::VERTEX,
        residency,
    };
    trunk_buffer(device, &descriptor, bytes)
}

/// What instances of a model of a trunk share on a device.
#[derive(Debug)]
pub(super) struct TrunkShared<M> {
    pub(super) model: M,
    pub(super) vertices: BufferId,
    pub(super) surface: Surface,
}

/// Sends a trunk's vertices, in the order of their collapses, and its material.
pub(super) fn upload_trunk<M>(
    device: &mut Device,
    environment: &Environment,
    model: M,
    trunk: &Trunk,
    mode: TrunkMode,
) -> Result<TrunkShared<M>, GpuError> {
    let bytes = vertex_bytes(trunk.mesh(), trunk.collapses().order());
    Ok(TrunkShared {
        model,
        vertices: upload_vertices(device, &bytes, mode.residency())?,
        surface: Surface::of(device, environment, &trunk.mesh().material)?,
    })
}

/// What a trunk looks like, on the device.
#[derive(Debug, Clone)]
pub(in crate::models) struct Surface {
    environment: Environment,
    constants: BufferId,
    texture: Option<TextureId>,
}

impl Surface {
    pub(in crate::models) fn of(
        device: &mut Device,
        environment: &Environment,
        material: &Material,
    ) -> Result<Self, GpuError> {
        let [red, green, blue, _] = material.base_color;
        let words = [red, green, blue, material.alpha_cutoff];
        let bytes: Vec<u8> = words.into_iter().flat_map(f32::to_le_bytes).collect();
        let constants = filled(device, "trunk surface", Usage::STORAGE, &bytes, TRUNK)?;
        let cutoff = material.alpha_cutoff;
        let texture = material.texture.as_ref();
        let texture = texture
            .map(|texture| upload_texture(device, "trunk texture", texture, cutoff, TRUNK))
            .transpose()?;
        Ok(Self {
            environment: *environment,
            constants,
            texture,
        })
    }

    /// Binds what a trunk is drawn with.
    pub(super) fn bind(&self, vertices: BufferId, indices: BufferId) -> Vec<Step> {
        let mut steps = self.bind_program(self.environment.mesh);
        steps.push(Step::Vertices(vertices));
        steps.push(Step::Indices(indices));
        steps
    }

    /// Binds a program with what a trunk looks like.
    pub(in crate::models) fn bind_program(&self, program: ProgramId) -> Vec<Step> {
        let mut steps: Vec<Step> = self.environment.bind(program).collect();
        steps.push(Step::Storage {
            slot: SURFACE_SLOT,
            buffer: self.constants,
        });
        steps.push(match self.texture {
            Some(texture) => Step::Texture { slot: 0, texture },
            None => Step::NoTexture { slot: 0 },
        });
        steps
    }
}
