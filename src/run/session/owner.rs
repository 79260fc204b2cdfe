//! Which buffers and textures of a session belong to what.

use crate::gpu::{Device, ResourceId};

/// What a buffer or texture of a session belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// The whole scene: the view, where trees stand.
    Scene,
    /// All trees of a plant, by its number in [`World::crowns`](crate::run::World::crowns).
    Plant(usize),
    /// One tree, by its number in [`World::trees`](crate::run::World::trees).
    Tree(u32),
}

/// Owners in the order of creation; handles count in the same order.
#[derive(Debug, Default)]
pub(super) struct Owners {
    buffers: Vec<Owner>,
    textures: Vec<Owner>,
}

impl Owners {
    /// What was created since the last call belongs to `owner`.
    pub(super) fn claim(&mut self, device: &Device, owner: Owner) {
        self.buffers.resize(device.buffers().count(), owner);
        self.textures.resize(device.textures().count(), owner);
    }

    /// What a resource belongs to; those that nobody claimed, to the scene.
    pub(super) fn of(&self, resource: ResourceId) -> Owner {
        let (owners, index) = match resource {
            ResourceId::Buffer(buffer) => (&self.buffers, buffer.index()),
            ResourceId::Texture(texture, _) => (&self.textures, texture.index()),
        };
        owners.get(index as usize).copied().unwrap_or(Owner::Scene)
    }
}
