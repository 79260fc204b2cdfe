//! The vertices, materials and textures of leaves of several faces on the device: the same for every model.

use super::super::Crown;
use super::super::environment::Environment;
use super::super::leaf::MATERIAL_SLOT;
use super::super::surface::{filled, upload_texture};
use super::program::COORDINATE_SLOT;
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, Residency, Step, TextureId, Usage,
};
use crate::math::index_u32;
use crate::plant::Texture;

/// What all foliage models of a crown keep of its faces.
#[derive(Debug)]
pub(super) struct FaceSurface {
    environment: Environment,
    vertices: BufferId,
    materials: BufferId,
    coordinates: BufferId,
    textures: Vec<TextureId>,
}

impl FaceSurface {
    /// Sends vertices (to where `residency` says), materials, texture coordinates and textures.
    pub(super) fn upload(
        device: &mut Device,
        environment: &Environment,
        crown: &Crown,
        textures: &[(&Texture, f32)],
        residency: Residency,
    ) -> Result<Self, GpuError> {
        let (faces, plant) = (crown.faces(), crown.plant());
        let bytes = faces.vertex_bytes(plant);
        let vertices = device.create_buffer(&BufferDescriptor {
            label: "leaf faces",
            size: bytes.len() as u64,
            usage: Usage::VERTEX,
            residency,
        })?;
        let cause = Cause::of("vertices");
        device.queue().write(vertices, 0, &bytes, cause)?;
        let (materials, coordinates) = faces.materials(plant, textures);
        let materials: Vec<u8> = materials
            .iter()
            .flat_map(|material| material.to_bytes())
            .collect();
        let cause = Cause::of("materials");
        let mut make = |label, bytes: &[u8]| filled(device, label, Usage::STORAGE, bytes, cause);
        let materials = make("leaf face materials", &materials)?;
        let coordinates = make("leaf face coordinates", &coordinates)?;
        let cause = Cause::of("texture");
        let textures = textures.iter().map(|&(texture, cutoff)| {
            upload_texture(device, "leaf texture", texture, cutoff, cause)
        });
        Ok(Self {
            environment: *environment,
            vertices,
            materials,
            coordinates,
            textures: textures.collect::<Result<_, _>>()?,
        })
    }

    /// Binds what faces are drawn with.
    pub(super) fn bind(&self) -> Vec<Step> {
        let mut steps: Vec<Step> = self.environment.bind(self.environment.face).collect();
        steps.push(Step::Vertices(self.vertices));
        for (slot, buffer) in [
            (MATERIAL_SLOT, self.materials),
            (COORDINATE_SLOT, self.coordinates),
        ] {
            steps.push(Step::Storage { slot, buffer });
        }
        for (slot, &texture) in self.textures.iter().enumerate() {
            let slot = index_u32(slot);
            steps.push(Step::Texture { slot, texture });
        }
        steps
    }
}
