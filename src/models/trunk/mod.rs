//! Trunks: triangle meshes, and what of them lies on the device.
//!
//! ```text
//! Trunk ─TrunkKind::model─▶ TrunkModel ──upload──▶ Shared ──instance(level)──▶ Resident
//!  (mesh)                   commit(level), draw ─▶ steps
//! ```
//!
//! The same traits as for foliage, with a [`TrunkLevel`] for a state.
//!
//! **Invariant.** At equal levels all kinds show the same triangles.

mod full;
mod level;
mod program;
mod shape;
mod surface;

use std::sync::Arc;

pub use level::TrunkLevel;
pub(super) use program::MeshProgram;
pub use shape::Trunk;

use super::{Environment, Shared, Storage};
use crate::gpu::{Device, GpuError};

/// First part of the key of everything that shows a trunk.
pub const TRUNK_GROUP: u32 = 0;

/// A level-of-detail model of one trunk: immutable, made offline.
pub trait TrunkModel: Send + Sync + std::fmt::Debug {
    /// Which model this is.
    fn kind(&self) -> TrunkKind;

    /// What it is a model of.
    fn trunk(&self) -> &Arc<Trunk>;

    /// Sends what all instances share, under the cause `trunk`.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared<TrunkLevel>>, GpuError>;

    /// The structures that it keeps in host memory, as bytes in the order in which they are listed
    /// in the type's documentation; their length is [`Storage::host_bytes`].
    fn host_bytes(&self) -> Vec<u8>;

    /// What it takes to keep it.
    fn storage(&self) -> Storage;
}

/// All models of trunks and their modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrunkKind {
    /// No level of detail: all triangles, always.
    Full,
}

impl TrunkKind {
    /// Every kind.
    pub const ALL: [Self; 1] = [Self::Full];

    /// The model of this kind for a trunk.
    #[must_use]
    pub fn model(self, trunk: &Arc<Trunk>) -> Box<dyn TrunkModel> {
        let trunk = Arc::clone(trunk);
        match self {
            Self::Full => Box::new(full::Full::new(trunk)),
        }
    }
}
