//! The ground: a mesh that is there once, whatever stands on it.

use super::environment::Environment;
use super::surface::{filled, upload_texture};
use crate::gpu::{BufferId, Cause, Corners, Device, Draw, GpuError, Step, TextureId, Usage};
use crate::math::index_u32;
use crate::plant::Mesh;

/// First part of the key of everything that shows the ground.
pub const TERRAIN_GROUP: u32 = 2;

/// Where the program that draws meshes reads colour and cutoff.
const SURFACE_SLOT: u32 = 2;

const CAUSE: Cause = Cause::of("terrain");

/// The ground on the device: positions, normals and texture coordinates as of a trunk, 32 bytes a
/// vertex, 4 bytes a corner, a colour of 16 bytes and the texture.
///
/// Its placement is one of the device's, for which [`Environment::new`] must have made room.
#[derive(Debug, Clone)]
pub struct Ground {
    environment: Environment,
    vertices: BufferId,
    indices: BufferId,
    surface: BufferId,
    texture: Option<TextureId>,
    corner_count: u32,
    placement: u32,
}

impl Ground {
    /// Sends the ground to the device under the cause `terrain`; `placement` is the number by which
    /// it is placed, which no tree has.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    pub fn upload(
        device: &mut Device,
        environment: &Environment,
        mesh: &Mesh,
        placement: u32,
    ) -> Result<Self, GpuError> {
        let vertex = |vertex: usize| {
            let (position, normal) = (mesh.positions[vertex], mesh.normals[vertex]);
            let [x, y, z] = position.to_array();
            let [nx, ny, nz] = normal.to_array();
            let [u, v] = mesh.texture_coordinates[vertex].to_array();
            [x, y, z, nx, ny, nz, u, v]
        };
        let vertices: Vec<u8> = (0..mesh.positions.len())
            .flat_map(vertex)
            .flat_map(f32::to_le_bytes)
            .collect();
        let indices = mesh.indices.iter().flat_map(|index| index.to_le_bytes());
        let indices: Vec<u8> = indices.collect();
        let [red, green, blue, _] = mesh.material.base_color;
        let surface = [red, green, blue, mesh.material.alpha_cutoff].map(f32::to_le_bytes);
        let surface = surface.concat();
        let mut make = |label, usage, bytes: &[u8]| filled(device, label, usage, bytes, CAUSE);
        let (vertices, indices, surface) = (
            make("terrain vertices", Usage::VERTEX, &vertices)?,
            make("terrain indices", Usage::INDEX, &indices)?,
            make("terrain surface", Usage::STORAGE, &surface)?,
        );
        let texture = match &mesh.material.texture {
            None => None,
            Some(texture) => {
                let label = "terrain texture";
                Some(upload_texture(device, label, texture, 0.0, CAUSE)?)
            }
        };
        Ok(Self {
            environment: *environment,
            vertices,
            indices,
            surface,
            texture,
            corner_count: index_u32(mesh.indices.len()),
            placement,
        })
    }

    /// Triangles of a draw.
    #[must_use]
    pub fn triangle_count(&self) -> u32 {
        self.corner_count / 3
    }

    /// Draws the ground.
    pub fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend(self.environment.bind(self.environment.mesh));
        steps.push(Step::Vertices(self.vertices));
        steps.push(Step::Indices(self.indices));
        steps.push(Step::Storage {
            slot: SURFACE_SLOT,
            buffer: self.surface,
        });
        steps.push(match self.texture {
            Some(texture) => Step::Texture { slot: 0, texture },
            None => Step::NoTexture { slot: 0 },
        });
        steps.push(Step::Draw(Draw {
            source: Corners::Indexed,
            first_corner: 0,
            corner_count: self.corner_count,
            instance: self.placement,
            group: TERRAIN_GROUP,
        }));
    }
}
