//! Plants: what a tree is, wherever it comes from; validated once, immutable after.
//!
//! ```text
//! species.toml ─▶ Species ─grow──▶ ┐
//! species.rls ─▶ RlSystem ─grow──▶ ┤
//!                                  ├─▶ Plant = skeleton? + trunk? + foliage groups
//! tree.glb, .obj, … ───import─────▶ ┘
//! ```
//!
//! World space, metres, +Y up, the trunk's base at or near the origin.
//!
//! **Invariant.** A [`Plant`] that exists is sound: every index is in range, every coordinate is
//! finite, parents come before children, and every group's leaves have as many vertices as its
//! prototype says. No stage after this one checks again.

mod foliage;
pub mod gltf;
pub mod import;
mod mesh;
pub mod rl_system;
mod silhouette;
mod skeleton;
mod species;
mod species_file;
mod stroke;
mod texture;
mod tube;
mod weber_penn;

pub use foliage::{FaceGroup, Foliage, LeafGroup, NO_BRANCH, Prototype};
pub use mesh::{Material, Mesh};
pub use silhouette::Silhouette;
pub use skeleton::{Branch, Node, Skeleton};
pub use species::{
    ArbaroSpecies, Blade, Clump, Crown, FoliageKind, LeafHabit, Pruning, SPECIES_SCHEMA, Shape,
    Species, StemLevel, Wood,
};
pub use species_file::SpeciesFile;
pub use stroke::Stroke;
pub use texture::Texture;
pub(crate) use texture::keep_coverage;
pub use tube::{Tubes, trunk_mesh};
pub use weber_penn::{GrowError, grow};

use crate::math::{Aabb, Digest, Digester};

/// A tree: an optional skeleton, an optional trunk mesh, and foliage in groups.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    name: String,
    skeleton: Option<Skeleton>,
    trunk: Option<Mesh>,
    foliage: Foliage,
}

impl Plant {
    /// A plant of checked parts.
    ///
    /// # Errors
    ///
    /// When an index is out of range, a coordinate is not finite, a count does not fit the limits
    /// ([`PLANT_LEAVES`](crate::limits::PLANT_LEAVES),
    /// [`PLANT_VERTICES`](crate::limits::PLANT_VERTICES),
    /// [`PLANT_FACES`](crate::limits::PLANT_FACES)), or a leaf names a branch that the skeleton lacks.
    pub fn new(
        name: impl Into<String>,
        skeleton: Option<Skeleton>,
        trunk: Option<Mesh>,
        foliage: Foliage,
    ) -> Result<Self, PlantError> {
        if let Some(skeleton) = &skeleton {
            skeleton.check()?;
        }
        if let Some(trunk) = &trunk {
            trunk.check()?;
        }
        let branches = skeleton
            .as_ref()
            .map_or(0, |skeleton| skeleton.branches.len());
        foliage.check(branches)?;
        Ok(Self {
            name: name.into(),
            skeleton,
            trunk,
            foliage,
        })
    }

    /// The name, for reports.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The branch graph, where one is known.
    #[must_use]
    pub fn skeleton(&self) -> Option<&Skeleton> {
        self.skeleton.as_ref()
    }

    /// The mesh of trunk and branches, where there is one.
    #[must_use]
    pub fn trunk(&self) -> Option<&Mesh> {
        self.trunk.as_ref()
    }

    /// The leaves.
    #[must_use]
    pub fn foliage(&self) -> &Foliage {
        &self.foliage
    }

    /// The box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let mesh = self
            .trunk
            .iter()
            .flat_map(|trunk| trunk.positions.iter().copied());
        Aabb::of(mesh).union(self.foliage.bounds())
    }

    /// The digest of everything but the name.
    ///
    /// BLAKE3 over the domain `spinney.plant/1`, then skeleton, trunk and foliage in this order: an
    /// absent part is the byte string `0u32`, a present one `1u32` and its fields in the order in
    /// which the types declare them, lists with their length as `u64` before them, all
    /// little-endian, textures as size and bytes.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut digester = Digester::new("spinney.plant/1");
        match &self.skeleton {
            None => _ = digester.u32(0),
            Some(skeleton) => skeleton.digest_into(digester.u32(1)),
        }
        match &self.trunk {
            None => _ = digester.u32(0),
            Some(trunk) => trunk.digest_into(digester.u32(1)),
        }
        self.foliage.digest_into(&mut digester);
        digester.finish()
    }
}

/// Why parts do not make a plant.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// An index points past the end of what it names.
    #[error("{part}: entry {place} names {what} {index}, but there are {count}")]
    Index {
        /// Which part of the plant.
        part: String,
        /// Where in the part.
        place: usize,
        /// What the index names.
        what: &'static str,
        /// The index found.
        index: u64,
        /// How many there are.
        count: usize,
    },
    /// A number that must be finite (and, where stated, not negative) is not.
    #[error("{part}: entry {place} holds {value}, wanted a {wanted} number")]
    Number {
        /// Which part of the plant.
        part: String,
        /// Where in the part.
        place: usize,
        /// The number found, as text.
        value: String,
        /// What would be right.
        wanted: &'static str,
    },
    /// Two lists that go together have different lengths.
    #[error("{part}: {found} {what}, wanted {wanted}")]
    Length {
        /// Which part of the plant.
        part: String,
        /// What was counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// More than the limits allow.
    #[error("{part}: {found} {what} exceed the limit of {limit}")]
    TooMany {
        /// Which part of the plant.
        part: String,
        /// What was counted.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
}
