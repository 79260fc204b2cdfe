//! The leaves' vertices, materials and textures on the device: the same for every model and mode.

use super::crown::Crown;
use super::environment::Environment;
use super::leaf::{LeafMaterial, MATERIAL_SLOT};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, MAX_SLOTS, ProgramId, Residency, Step,
    TextureDescriptor, TextureId, Usage,
};
use crate::math::{Vec4, index_u32};
use crate::plant::Texture;

/// First part of the key of everything that shows a leaf.
pub const LEAF_GROUP: u32 = 1;

/// What all foliage models of a crown keep on the device.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    environment: Environment,
    pub(super) vertices: BufferId,
    materials: BufferId,
    textures: Vec<TextureId>,
}

impl Surface {
    /// Sends vertices (to where `residency` says), materials and textures.
    pub(super) fn upload(
        device: &mut Device,
        environment: &Environment,
        crown: &Crown,
        residency: Residency,
    ) -> Result<Self, GpuError> {
        let vertices = crown.vertex_bytes();
        let buffer = BufferDescriptor {
            label: "leaf vertices",
            size: vertices.len() as u64,
            usage: Usage::VERTEX | Usage::STORAGE,
            residency,
        };
        let vertex_buffer = device.create_buffer(&buffer)?;
        device
            .queue()
            .write(vertex_buffer, 0, &vertices, Cause::of("vertices"))?;

        let mut distinct: Vec<(&Texture, f32)> = Vec::new();
        let mut bytes = Vec::new();
        let mut first_vertex = 0;
        for (group, corners) in crown.plant().foliage().quad_groups() {
            let material = &group.material;
            let slot = material.texture.as_ref().map(|texture| {
                let key = (texture, material.alpha_cutoff);
                distinct
                    .iter()
                    .position(|known| *known == key)
                    .unwrap_or_else(|| {
                        distinct.push(key);
                        distinct.len() - 1
                    })
            });
            let entry = LeafMaterial {
                first_vertex,
                texture: slot.map_or(0, |slot| index_u32(slot) + 1),
                alpha_cutoff: material.alpha_cutoff,
                base_color: Vec4::from_array(material.base_color),
                texture_corners: *corners,
            };
            bytes.extend(entry.to_bytes());
            first_vertex += index_u32(group.positions.len());
        }
        if distinct.len() > MAX_SLOTS {
            let what = format!(
                "foliage with {} textures (at most {MAX_SLOTS} fit; join them into an atlas)",
                distinct.len()
            );
            return Err(GpuError::Unsupported { what });
        }
        let materials = device.create_buffer(&BufferDescriptor {
            label: "leaf materials",
            size: bytes.len() as u64,
            usage: Usage::STORAGE,
            residency: Residency::Device,
        })?;
        device
            .queue()
            .write(materials, 0, &bytes, Cause::of("materials"))?;
        let textures = distinct
            .into_iter()
            .map(|(texture, cutoff)| {
                upload_texture(
                    device,
                    "leaf texture",
                    texture,
                    cutoff,
                    Cause::of("texture"),
                )
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            environment: *environment,
            vertices: vertex_buffer,
            materials,
            textures,
        })
    }

    /// Binds what leaves are drawn with.
    pub(super) fn bind(&self, program: LeafDraw, steps: &mut Vec<Step>) {
        steps.extend(self.environment.bind(program.id(&self.environment)));
        steps.push(Step::Storage {
            slot: MATERIAL_SLOT,
            buffer: self.materials,
        });
        for (slot, &texture) in self.textures.iter().enumerate() {
            steps.push(Step::Texture {
                slot: index_u32(slot),
                texture,
            });
        }
    }
}

/// Which of the leaf programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LeafDraw {
    Indexed,
    Stamped,
}

impl LeafDraw {
    fn id(self, environment: &Environment) -> ProgramId {
        match self {
            Self::Indexed => environment.leaf,
            Self::Stamped => environment.stamped_leaf,
        }
    }
}

/// Sends a texture with all its mip levels, each of which covers what the largest covers.
pub(super) fn upload_texture(
    device: &mut Device,
    label: &str,
    texture: &Texture,
    cutoff: f32,
    cause: Cause,
) -> Result<TextureId, GpuError> {
    let mips = texture.mips(cutoff);
    let id = device.create_texture(&TextureDescriptor {
        label,
        width: texture.width(),
        height: texture.height(),
        levels: index_u32(mips.len()),
    })?;
    for (level, bytes) in mips.iter().enumerate() {
        device
            .queue()
            .write_texture(id, index_u32(level), bytes, cause)?;
    }
    Ok(id)
}
