//! Grows plants from species: the generator of Weber and Penn ([WP95](crate::references)).
//!
//! ```text
//!            level by level                   density, evenly thinned
//! Species ─────────────▶ wood: skeleton, frames ─────────▶ leaves
//!    seed                         │                           │
//!                                 └──── tubes ────▶ trunk ────┴─▶ Plant
//! ```
//!
//! Every stem has its own stream of random numbers, named by its path from the root, and separate
//! streams for its shape, its children and its leaves: adding a level, a clone or a leaf shifts no
//! other. The paper is Z-up; here the world is Y-up, in metres.
//!
//! Ours, beyond the paper: clumps of several trunks, attraction by level, exact leaf counts, and a
//! given size of the trunk mesh. The paper's quality factor is left out: detail is other stages'
//! concern.

mod blade;
mod branching;
mod formulas;
pub(super) mod frame;
mod leaves;
mod stem;

use super::species::Species;
use super::texture::linear_of_srgb;
use super::tube::{Tubes, trunk_mesh};
use super::{Material, Plant, PlantError};
use crate::document::DocumentError;
use crate::math::Stream;

/// Grows the plant of a species that a seed names; the same on every machine.
///
/// Has exactly [`Species::leaf_count`] leaves where that is given: the number of leaves on each
/// stem is scaled until the crown has as many, or up to 3 % more, and what is too much is taken
/// evenly from the whole crown; [`Species::omitted_leaves`] then go. The trunk has [`Species::trunk_polygons`] triangles within 5 %.
///
/// # Errors
///
/// When a count cannot be met, or the plant would be too large.
pub fn grow(species: &Species, seed: u64) -> Result<Plant, GrowError> {
    let wood = branching::grow_wood(species, Stream::new(seed, 0))?;
    let foliage = leaves::foliage(species, &wood)?;
    let bark = Material::plain("bark", linear(species.wood.bark_color));
    let tubes = Tubes {
        edges: species.wood.tube_edges,
        polygons: species.trunk_polygons,
        lobes: species.wood.lobes,
        lobe_depth: species.wood.lobe_depth,
    };
    let trunk = trunk_mesh(&wood.skeleton, &tubes, bark)?;
    let trunk = (!trunk.indices.is_empty()).then_some(trunk);
    Ok(Plant::new(
        species.name.clone(),
        Some(wood.skeleton),
        trunk,
        foliage,
    )?)
}

/// An sRGB colour as linear light.
fn linear(srgb: [u8; 3]) -> [f32; 3] {
    srgb.map(linear_of_srgb)
}

/// Why a species does not grow.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GrowError {
    /// The stems cannot bear as many leaves as wanted.
    #[error("leaves: {wanted} wanted, but the stems bear {found}")]
    Leaves {
        /// How many the species asks for.
        wanted: usize,
        /// How many grow at the nearest density that is not below, or at the highest.
        found: usize,
    },
    /// A leaf that is to be left out does not grow.
    #[error("leaves.omit: leaf {leaf}, but {found} leaves grow, numbered from 0")]
    Omitted {
        /// The greatest number that the species leaves out.
        leaf: u32,
        /// How many leaves grow.
        found: usize,
    },
    /// The trunk mesh cannot have as many triangles as wanted.
    #[error("trunk: {wanted} triangles wanted, nearest is {found}")]
    TrunkPolygons {
        /// How many the species asks for.
        wanted: usize,
        /// The nearest number that the stems allow.
        found: usize,
    },
    /// The plant would be too large.
    #[error("{found} {what} exceed the limit of {limit}")]
    TooMany {
        /// What was counted.
        what: &'static str,
        /// How many there were when growth stopped.
        found: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A rule of a grammar grows too much, or asks for what there is not; with its place.
    #[error(transparent)]
    Rule(DocumentError),
    /// The parts do not make a plant.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

#[cfg(test)]
mod tests;
