//! Where a trunk lies.

use super::Trunk;
use super::surface::vertex_bytes;
use crate::gpu::Residency;
use crate::models::Storage;
use crate::scene::TrunkMode;

impl TrunkMode {
    /// Where vertices and triangles lie.
    pub(super) fn residency(self) -> Residency {
        match self {
            Self::Host => Residency::Host,
            Self::Device | Self::Mesh | Self::Levels | Self::Skeleton => Residency::Device,
        }
    }

    /// The vertices in the order of their collapses, if they are kept in host memory.
    pub(super) fn host_vertex_bytes(self, trunk: &Trunk) -> Vec<u8> {
        match self.residency() {
            Residency::Host => vertex_bytes(trunk.mesh(), trunk.collapses().order()),
            Residency::Device => Vec::new(),
        }
    }

    /// What it takes to keep vertices of 32 bytes, a model's own structures in host memory, and for
    /// each instance what is drawn and what it keeps beside that to change it.
    pub(super) fn storage(self, trunk: &Trunk, host: u64, instance: u64, kept: u64) -> Storage {
        let vertices = 32 * trunk.mesh().positions.len() as u64;
        match self.residency() {
            Residency::Host => Storage {
                host_bytes: vertices + host,
                shared_bytes: 0,
                instance_bytes: 0,
                instance_host_bytes: instance + kept,
            },
            Residency::Device => Storage {
                host_bytes: host,
                shared_bytes: vertices,
                instance_bytes: instance,
                instance_host_bytes: kept,
            },
        }
    }
}
