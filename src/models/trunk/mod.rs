//! Trunks: triangle meshes, and what of them lies on the device.
//!
//! ```text
//!  offline                            once a species      once an instance         every frame
//! Trunk ─TrunkKind::model─▶ TrunkModel ──upload──▶ Shared ──instance(level)──▶ Resident ─┬─ commit(level)
//!  (mesh, collapses)                                                                    └─ draw ─▶ steps
//! ```
//!
//! The same traits as for foliage, with a [`TrunkLevel`] for a state. Every name but the last has two
//! modes: on the device, or in host memory, from where every draw pulls indices and vertices of 32 bytes.
//!
//! | name | on the device | what one change sends |
//! |---|---|---|
//! | full | vertices and triangles, once a species | nothing: always full detail |
//! | lodstrips | vertices once, strips of fixed length | 4 B a place that differs |
//! | lodstrips-cut | vertices once, blocks of short strips | of each changed block the places from the first to the last that differ, and their number (4 B) |
//! | mom | vertices once, a list of triangles | 12 B a slot that differs, and their number (4 B) |
//! | branches | a level, some levels, or 52 B a node and tables: three modes of its own | a level, nothing, or 4 B |
//!
//! # One level
//!
//! A trunk has one level over all of it, also in a tree whose foliage has variable detail; it follows how
//! many of the leaves' collapses are done. LodStrips has nothing else: [RRCGR](crate::references),
//! section III, describes one sequence of collapses and how the strips change along it, and claims
//! variable resolution for foliage alone (sections IV and VII). MOM does have a variable form, which
//! [RLBRC01](crate::references) is about by its title; but none of its text was at hand beyond what
//! [RRCGR](crate::references) says of it, and of the variable test behind Figure 15 that only says that
//! changes are variable, not where in the trunk. A form of our own would be compared with nothing, so
//! there is none: in variable tests both rivals' trunks change as a whole.
//!
//! **Invariant.** At equal levels all kinds of meshes but full show the same triangles of the same vertices, the
//! lowest corner first: their pictures are equal bit for bit. The full one keeps the mesh's own order
//! of vertices, which decides ties of depth and the last bits of what is interpolated.

mod cut;
#[cfg(test)]
mod examples;
mod full;
mod level;
mod mode;
mod mom;
mod planned;
mod program;
mod shape;
mod strips;
mod surface;
mod writes;

use std::sync::Arc;

pub use level::TrunkLevel;
pub(super) use program::{MeshProgram, SURFACE_SLOT};
pub use shape::{Trunk, TrunkSimplifier};
pub(super) use surface::Surface;

use super::{Environment, Gather, ModelOptions, Shared, Storage, branches};
use crate::gpu::{Device, GpuError, Residency};
use crate::math::{index_u32, index_usize};
use crate::scene::{TrunkMode, TrunkName};
use crate::simplify::ErrorStep;

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

/// A model of trunks and its mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TrunkKind {
    /// Which model.
    pub name: TrunkName,
    /// Where what it draws lies.
    pub mode: TrunkMode,
}

impl TrunkKind {
    /// Without levels, on the device: what trunks are unless something else is asked for.
    pub const FULL: Self = Self {
        name: TrunkName::Full,
        mode: TrunkMode::Device,
    };

    /// Every kind.
    pub fn all() -> impl Iterator<Item = Self> {
        let modes = |&name: &TrunkName| {
            let modes = name.modes().iter();
            modes.map(move |&mode| Self { name, mode })
        };
        TrunkName::ALL.iter().flat_map(modes)
    }

    /// Name and mode in one word, such as `lodstrips-device`; `full` alone is on the device.
    #[must_use]
    pub fn label(self) -> String {
        if self == Self::FULL {
            self.name.name().to_owned()
        } else {
            format!("{}-{}", self.name.name(), self.mode.name())
        }
    }

    /// The kind with this label.
    #[must_use]
    pub fn labelled(label: &str) -> Option<Self> {
        Self::all().find(|kind| kind.label() == label)
    }

    /// Whether it can show anything but full detail.
    #[must_use]
    pub fn has_levels(self) -> bool {
        self.name != TrunkName::Full
    }

    /// The model of this kind for a trunk; of the options it takes how what differs is sent.
    #[must_use]
    pub fn model(self, trunk: &Arc<Trunk>, options: ModelOptions) -> Box<dyn TrunkModel> {
        let (trunk, mode) = (Arc::clone(trunk), self.mode);
        // Writing to host memory moves nothing that could be gathered.
        let gather = match mode.residency() {
            Residency::Host => Gather::Single,
            Residency::Device => options.gather,
        };
        match self.name {
            TrunkName::Full => Box::new(full::Full::new(trunk, mode)),
            TrunkName::LodStrips => Box::new(strips::LodStrips::new(trunk, mode, gather)),
            TrunkName::LodStripsCut => Box::new(cut::Cut::new(trunk, mode, gather)),
            TrunkName::Mom => Box::new(mom::Mom::new(trunk, mode, gather)),
            TrunkName::Branches if trunk.plant().skeleton().is_none() => {
                Box::new(full::Full::new(trunk, TrunkMode::Device))
            }
            TrunkName::Branches => branches::model(trunk, mode),
        }
    }

    /// Whether what it shows are branches with an error, and not a mesh with so many collapses.
    #[must_use]
    pub fn has_errors(self) -> bool {
        self.name == TrunkName::Branches
    }

    /// The level at `done` of `all` even parts of the way from full detail to the least: of a mesh's collapses,
    /// or from the finest error to the coarsest, by one factor a part.
    #[must_use]
    pub fn level(self, trunk: &Trunk, done: u32, all: u32) -> TrunkLevel {
        if self.has_errors() {
            let [finest, coarsest] = trunk.branch_choice().steps();
            TrunkLevel::Error(finest.towards(coarsest, done, all))
        } else if self.has_levels() {
            trunk.level(done, all)
        } else {
            TrunkLevel::FINEST
        }
    }

    /// The error of the branches that it draws at a level; `None` where it draws a mesh, as it does without a
    /// skeleton.
    #[must_use]
    pub fn shown_step(self, trunk: &Trunk, level: TrunkLevel) -> Option<ErrorStep> {
        let draws_branches = self.has_errors() && trunk.plant().skeleton().is_some();
        draws_branches.then(|| branches::shown_step(trunk, self.mode, level))
    }

    /// The triangles that it draws at a level; of branches without those of lines.
    #[must_use]
    pub fn triangle_count(self, trunk: &Trunk, level: TrunkLevel) -> u32 {
        if let Some(step) = self.shown_step(trunk, level) {
            let counts = trunk.branch_counts(step);
            index_u32(index_usize(2 * counts.quads + counts.triangles))
        } else if self.has_levels() && !self.has_errors() {
            trunk.triangle_count(level)
        } else {
            trunk.mesh().triangle_count()
        }
    }
}
