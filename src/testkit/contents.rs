//! What lies on our device, by the numbers that the laws know it by.

use super::device::{Change, Resource};
use crate::gpu::{Device, RecordingEntry, Residency, ResourceId};

/// All buffers of a device in the order of their creation, then the levels of all textures that were
/// written while it recorded.
#[derive(Debug, Clone)]
pub struct Contents {
    listed: Vec<Listed>,
}

#[derive(Debug, Clone)]
struct Listed {
    id: ResourceId,
    name: String,
    residency: Residency,
}

impl Contents {
    /// What lies there now.
    #[must_use]
    pub fn of(device: &Device) -> Self {
        let on_device = device.resident_by_label();
        let buffers = device.buffers().map(|(buffer, label)| Listed {
            id: ResourceId::Buffer(buffer),
            name: label.to_owned(),
            residency: if on_device.iter().any(|(known, _)| known == label) {
                Residency::Device
            } else {
                Residency::Host
            },
        });
        let mut listed: Vec<Listed> = buffers.collect();
        for entry in device.recording().map_or(&[][..], |log| &log.entries) {
            if let RecordingEntry::Write {
                resource: id @ ResourceId::Texture(texture, level),
                ..
            } = entry
                && !listed.iter().any(|known| known.id == *id)
            {
                listed.push(Listed {
                    id: *id,
                    name: format!("texture {} level {level}", texture.index()),
                    residency: Residency::Device,
                });
            }
        }
        Self { listed }
    }

    /// The bytes of all, as they are now.
    #[must_use]
    pub fn resources<'a>(&'a self, device: &'a Device) -> Vec<Resource<'a>> {
        let bytes = |id: ResourceId| match id {
            ResourceId::Buffer(buffer) => device.inspect_buffer(buffer),
            ResourceId::Texture(texture, level) => device.inspect_texture(texture, level),
        };
        // What was destroyed since has no bytes left.
        let resources = self.listed.iter().map(|listed| Resource {
            name: &listed.name,
            residency: listed.residency,
            bytes: bytes(listed.id).unwrap_or(&[]),
        });
        resources.collect()
    }

    /// The recorded changes, each write with the number of its transfer; `None` if the device does
    /// not record. What changed something unknown gets a number that no resource has.
    #[must_use]
    pub fn log<'a>(
        &self,
        device: &'a Device,
        mut transfers: impl Iterator<Item = u64>,
    ) -> Option<Vec<Change<'a>>> {
        let changes = device.recording()?.entries.iter().map(|entry| match entry {
            RecordingEntry::Write {
                resource,
                offset,
                bytes,
            } => Change::Write {
                transfer: transfers.next().unwrap_or(u64::MAX),
                resource: self.number(*resource),
                at: *offset,
                bytes,
            },
            RecordingEntry::Copy {
                source,
                source_offset,
                destination,
                destination_offset,
                size,
            } => Change::Copy {
                source: self.number(ResourceId::Buffer(*source)),
                source_at: *source_offset,
                resource: self.number(ResourceId::Buffer(*destination)),
                at: *destination_offset,
                size: *size,
            },
            RecordingEntry::Computed {
                buffer,
                offset,
                bytes,
            } => Change::Computed {
                resource: self.number(ResourceId::Buffer(*buffer)),
                at: *offset,
                bytes,
            },
            RecordingEntry::Clear {
                buffer,
                offset,
                size,
            } => Change::Clear {
                resource: self.number(ResourceId::Buffer(*buffer)),
                at: *offset,
                size: *size,
            },
        });
        Some(changes.collect())
    }

    pub(super) fn id(&self, number: usize) -> Option<ResourceId> {
        self.listed.get(number).map(|listed| listed.id)
    }

    pub(super) fn number(&self, id: ResourceId) -> usize {
        let place = self.listed.iter().position(|listed| listed.id == id);
        place.unwrap_or(usize::MAX)
    }
}
