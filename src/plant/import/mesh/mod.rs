//! Triangles that are leaves or wood: what all importers of meshes share.
//!
//! ```text
//!  parts of a file ─cards─▶ pieces ─sort─▶ leaves ─foliage─▶ groups of equal prototypes
//!                                     └──▶ wood ───trunk───▶ one mesh ─rings─▶ skeleton
//! ```
//!
//! A part is what a file keeps together: a primitive, or what has one name and material. Its pieces are
//! what hangs together by positions.

mod cards;
mod foliage;
mod image;
mod names;
mod part;
mod sort;
mod stand;
mod trunk;

pub(in crate::plant) use self::image::decode_png;
pub(in crate::plant) use cards::{components, place_classes};
pub(in crate::plant) use foliage::prototype_of;
pub(in crate::plant) use names::{Names, listed, says_leaves};
pub(in crate::plant) use part::{Part, compact};
pub(in crate::plant) use sort::{Evidence, sort};
pub(in crate::plant) use stand::{Visit, base, guess_frame};

use super::ImportReport;
use crate::plant::Material;

/// The materials of a file.
pub(in crate::plant) trait Materials {
    /// Why one cannot be read.
    type Fault;

    /// The material of an index that was checked, or the format's default one.
    fn read(
        &mut self,
        index: Option<usize>,
        report: &mut ImportReport,
    ) -> Result<Material, Self::Fault>;

    /// How messages call it.
    fn title(&self, index: usize) -> String;

    /// Its name and where it stands.
    fn name_and_place(&self, index: usize) -> (String, String);
}
