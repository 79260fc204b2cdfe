//! The leaves' vertices, materials and textures on the device: the same for every model and mode.

use std::ops::Range;

use super::Shared;
use super::crown::Crown;
use super::environment::Environment;
use super::format::{LeafBytes, LeafFormat, Records};
use super::leaf::{LeafMaterial, LeafProgram, LeafSource, MATERIAL_SLOT};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, DrawIndirect, GpuError, MAX_SLOTS, Residency, Step,
    TextureDescriptor, TextureFormat, TextureId, Usage,
};
use crate::math::{Vec4, index_u32};
use crate::plant::Texture;

/// First part of the key of everything that shows a leaf.
pub const LEAF_GROUP: u32 = 1;

/// First part of the key of everything that shows a card in place of leaves.
pub const CARD_GROUP: u32 = 3;

/// First part of the key of strokes. They are blended, and leave no key.
pub const STROKE_GROUP: u32 = 9;

/// Whether what has this first part of a key is foliage: a leaf, or a card in place of some.
#[must_use]
pub fn shows_foliage(group: u32) -> bool {
    matches!(group, LEAF_GROUP | CARD_GROUP)
}

/// What all foliage models of a crown keep on the device.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    environment: Environment,
    pub(super) vertices: BufferId,
    materials: BufferId,
    /// What the format needs beside the vertices, in the order of slots.
    keys: Vec<BufferId>,
    textures: Vec<TextureId>,
    pub(super) format: LeafFormat,
}

impl Surface {
    /// Sends vertices (to where `residency` says), materials and textures.
    pub(super) fn upload(
        device: &mut Device,
        environment: &Environment,
        crown: &Crown,
        leaves: &LeafBytes,
        residency: Residency,
    ) -> Result<Self, GpuError> {
        leaves.check()?;
        let bytes = leaves.vertices();
        let vertices = device.create_buffer(&BufferDescriptor {
            label: "leaf vertices",
            size: bytes.len() as u64,
            usage: Usage::VERTEX | Usage::STORAGE,
            residency,
        })?;
        let cause = Cause::of("vertices");
        device.queue().write(vertices, 0, &bytes, cause)?;
        let keys = leaves.keys().into_iter();
        let keys = keys.map(|(label, bytes)| filled(device, label, Usage::STORAGE, &bytes, cause));
        let keys = keys.collect::<Result<_, _>>()?;

        let mut distinct: Vec<(&Texture, f32)> = Vec::new();
        let mut entries: Vec<LeafMaterial> = Vec::new();
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
            entries.push(LeafMaterial {
                first_vertex,
                texture: slot.map_or(0, |slot| index_u32(slot) + 1),
                alpha_cutoff: material.alpha_cutoff,
                base_color: Vec4::from_array(material.base_color),
                texture_corners: *corners,
            });
            first_vertex += index_u32(group.positions.len());
        }
        entries.extend(added_materials(
            crown,
            first_vertex..leaves.vertex_count(),
            &entries,
        ));
        if distinct.len() > MAX_SLOTS {
            let what = format!(
                "foliage with {} textures (at most {MAX_SLOTS} fit; join them into an atlas)",
                distinct.len()
            );
            return Err(GpuError::Unsupported { what });
        }
        let bytes: Vec<u8> = entries.iter().flat_map(|entry| entry.to_bytes()).collect();
        let cause = Cause::of("materials");
        let materials = filled(device, "leaf materials", Usage::STORAGE, &bytes, cause)?;
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
            vertices,
            materials,
            keys,
            textures,
            format: leaves.format,
        })
    }

    /// The numbers of the original leaves, with compact records.
    pub(super) fn leaf_numbers(&self) -> Option<BufferId> {
        let compact = self.format.records == Records::Compact;
        compact.then(|| self.keys.first().copied()).flatten()
    }

    /// Binds what leaves are drawn with.
    pub(super) fn bind(&self, source: LeafSource, steps: &mut Vec<Step>) {
        let program = LeafProgram {
            source,
            format: self.format,
        };
        steps.extend(self.environment.bind(self.environment.leaf(program)));
        steps.push(Step::Storage {
            slot: MATERIAL_SLOT,
            buffer: self.materials,
        });
        for (slot, &buffer) in (program.key_slot()..).zip(&self.keys) {
            steps.push(Step::Storage { slot, buffer });
        }
        for (slot, &texture) in self.textures.iter().enumerate() {
            steps.push(Step::Texture {
                slot: index_u32(slot),
                texture,
            });
        }
    }
    /// The steps that draw lists of records, one for each of the first `count` draw arguments.
    pub(super) fn draw_records(
        &self,
        records: BufferId,
        arguments: BufferId,
        count: u32,
    ) -> Vec<Step> {
        let mut steps = Vec::new();
        self.bind(LeafSource::Indexed, &mut steps);
        steps.push(Step::Vertices(self.vertices));
        steps.push(Step::Indices(records));
        steps.push(Step::DrawIndirect(DrawIndirect {
            source: self.format.source(),
            arguments,
            offset: 0,
            count,
            group: LEAF_GROUP,
        }));
        steps
    }
}

/// The materials of the vertices that collapses add, once for each run of those of one group; runs are few
/// where such vertices come by group.
fn added_materials(crown: &Crown, added: Range<u32>, groups: &[LeafMaterial]) -> Vec<LeafMaterial> {
    let mut entries = Vec::new();
    let mut last = None;
    for vertex in added.step_by(4) {
        let first_of_original = 4 * crown.sequence().original_of_vertex(vertex);
        let group = groups.partition_point(|group| group.first_vertex <= first_of_original);
        if last.replace(group) != Some(group) {
            // Of empty groups, which begin where another does, the last is found, as in a draw.
            entries.extend(group.checked_sub(1).map(|group| LeafMaterial {
                first_vertex: vertex,
                ..groups[group]
            }));
        }
    }
    entries
}

/// What instances of a model share on a device: the model's own host structures, and the surface.
#[derive(Debug)]
pub(super) struct Uploaded<M> {
    pub(super) model: M,
    pub(super) surface: Surface,
}

impl<M> Uploaded<M>
where
    Self: Shared + 'static,
{
    /// Sends the surface of a model that has nothing else to share.
    pub(super) fn send(
        device: &mut Device,
        environment: &Environment,
        model: M,
        (crown, leaves): (&Crown, &LeafBytes),
        residency: Residency,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let surface = Surface::upload(device, environment, crown, leaves, residency)?;
        Ok(Box::new(Self { model, surface }))
    }
}

/// Makes a buffer on the device and sends all of its bytes.
pub(super) fn filled(
    device: &mut Device,
    label: &str,
    usage: Usage,
    bytes: &[u8],
    cause: Cause,
) -> Result<BufferId, GpuError> {
    let buffer = device.create_buffer(&BufferDescriptor {
        label,
        size: bytes.len() as u64,
        usage,
        residency: Residency::Device,
    })?;
    device.queue().write(buffer, 0, bytes, cause)?;
    Ok(buffer)
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
        format: TextureFormat::Srgb8,
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
