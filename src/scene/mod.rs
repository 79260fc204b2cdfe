//! Scenes: what is asked for, read from a TOML file and checked once.
//!
//! ```text
//! scenes/*.toml ─Document─▶ tables with places ─keys─▶ Scene ──▶ plant, models, run
//!                                                        │
//!                     scene.resolved.toml ◀──to_toml─────┘   reads back as an equal Scene
//! ```
//!
//! **Invariant.** A [`Scene`] that was read is sound: every number is finite and within the range
//! that [`KEYS`] states, there is at least one tree, single or in a forest, and one key of the
//! camera's path, and nothing in it depends on the folder, host or time of reading.
//!
//! # Keys
//!
//! One table, [`KEYS`], decides what a file may say, gives the defaults, makes the messages about
//! what is wrong, and prints as [`key_help`] and as the list here.
//!
#![doc = include_str!("keys.md")]

mod branches;
mod camera;
mod card_keys;
mod cards;
mod forest;
mod grove;
mod grove_keys;
#[cfg(test)]
mod key_tests;
mod keys;
mod model;
mod paint_keys;
mod painting;
mod parse;
mod reader;
mod shadow;
mod terrain;
mod tree;
mod value;
mod write;

pub use branches::{
    BranchAlpha, BranchChoice, BranchFrames, BranchLines, BranchRemoval, BranchShares,
    NeedleMerging,
};
pub use camera::{Camera, CameraKey, Projection, View};
pub use cards::{
    CardCounts, CardDepth, CardMode, CardOptions, CardOutline, CardSides, FarCards, SpriteScale,
    Transparency,
};
pub use forest::{Area, Forest, ForestChoice, ForestSpecies, Layout, NoRoom, PatchSample, Patches};
pub use grove::{GroveBlend, GroveChoice, GroveOrder, GrovePacking};
pub use keys::{Absent, KEYS, Key, Kind, key_help};
pub use model::{
    CriterionName, DetailKind, DetailRange, Extraction, Gather, LeafAmount, Mode, ModelChoice,
    ModelName, Occlusion, RecordWidth, Simplifier, TrunkMode, TrunkName, VertexFormat,
};
pub use painting::{PaintLook, PaintMark, PaintOptions, PaintReach, PaintRows};
pub use parse::{SceneFile, SceneSource};
pub use shadow::Shadow;
pub use terrain::Terrain;
pub use tree::{PlantSource, Tree};
pub use write::to_toml;

use std::path::Path;

use crate::document::DocumentError;
use crate::limits;
use crate::math::{Digest, Vec3};

/// The value of `schema` in a scene file.
pub const SCHEMA: &str = "spinney.scene/1";

/// All that is asked for: trees, camera, light, model and device.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The name in reports and of the output folder: letters, digits, `.`, `_` and `-`.
    pub name: String,
    /// Pixels of a frame.
    pub size: ImageSize,
    /// Samples a pixel.
    pub samples: SampleCount,
    /// Frames `0..frames` are rendered.
    pub frames: u32,
    /// The seed of everything that draws random numbers and has none of its own.
    pub seed: u64,
    /// What is behind everything: sRGB, 8 bits a channel.
    pub background: [u8; 3],
    /// The single trees.
    pub trees: Vec<Tree>,
    /// The forests, whose trees follow.
    pub forests: Vec<Forest>,
    /// The ground, if any is drawn.
    pub terrain: Option<Terrain>,
    /// Where from and how it is seen.
    pub camera: Camera,
    /// What lights it.
    pub light: Light,
    /// How what is lit casts shadows, if it does.
    pub shadow: Option<Shadow>,
    /// The level-of-detail system and its options.
    pub model: ModelChoice,
    /// What stands in for leaves where the model draws cards.
    pub cards: CardOptions,
    /// How wood and needles are drawn where trunks are branches.
    pub branches: BranchChoice,
    /// How trees are painted where the model draws strokes.
    pub painting: PaintOptions,
    /// How forests of patches are drawn, if not tree by tree.
    pub grove: Option<GroveChoice>,
    /// The simulated device.
    pub device: DeviceChoice,
    /// What is compared with a stored reference, if anything.
    pub golden: Option<Golden>,
}

impl Scene {
    /// Reads a scene file; [`SceneFile::read`] also keeps where each value stands.
    ///
    /// # Errors
    ///
    /// When the file cannot be read or says something wrong: at which line and column, what was
    /// found and what would be right.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        SceneFile::read(path).map(|file| file.scene)
    }

    /// Every tree in the order of instance numbers: the single ones, then those of the forests.
    #[must_use]
    pub fn standing_trees(&self) -> Vec<Tree> {
        let forests = self.forests.iter();
        let terrain = self.terrain.as_ref();
        let theirs = forests.flat_map(|forest| forest.trees(terrain));
        self.trees.iter().cloned().chain(theirs).collect()
    }

    /// Pins every plant to the digest that `digest` knows of a tree, by its instance number.
    pub fn pin_plants(&mut self, digest: impl Fn(usize) -> Option<Digest>) {
        for (number, tree) in self.trees.iter_mut().enumerate() {
            tree.plant_digest = digest(number);
        }
        let mut first = self.trees.len();
        for forest in &mut self.forests {
            let numbers: Vec<usize> = forest.species_of_trees().collect();
            for (species, entry) in forest.species_mut().iter_mut().enumerate() {
                let tree = numbers.iter().position(|number| *number == species);
                entry.plant_digest = tree.and_then(|tree| digest(first + tree));
            }
            first += numbers.len();
        }
    }
}

/// Why something is no scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file says something wrong.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A value given by a program, not a file, is wrong.
    #[error("`{key}`: found {found}, wanted {wanted}")]
    Value {
        /// The key that a file would use.
        key: &'static str,
        /// The value found, as text.
        found: String,
        /// What would be right.
        wanted: String,
    },
}

/// Width and height in pixels, within limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    width: u32,
    height: u32,
}

impl ImageSize {
    /// The largest width or height.
    pub const MAX_SIDE: u32 = limits::IMAGE_SIDE;

    /// The most pixels: room for 7680 × 4320.
    pub const MAX_PIXELS: u32 = limits::IMAGE_PIXELS;

    /// A size of sides from 1 to [`MAX_SIDE`](Self::MAX_SIDE) and at most
    /// [`MAX_PIXELS`](Self::MAX_PIXELS); else `None`.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Option<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let fits = sides.contains(&width)
            && sides.contains(&height)
            && u64::from(width) * u64::from(height) <= u64::from(Self::MAX_PIXELS);
        fits.then_some(Self { width, height })
    }

    /// Pixels a row.
    #[must_use]
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(self) -> u32 {
        self.height
    }
}

/// Samples a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleCount {
    /// One, at the pixel's centre.
    One,
    /// Four.
    Four,
}

impl SampleCount {
    /// The count for 1 or 4; else `None`.
    #[must_use]
    pub fn new(samples: u32) -> Option<Self> {
        match samples {
            1 => Some(Self::One),
            4 => Some(Self::Four),
            _ => None,
        }
    }

    /// 1 or 4.
    #[must_use]
    pub fn get(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
}

/// A light from very far away, and light from everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// From the scene towards the light, world space, of any length but 0.
    pub direction: Vec3,
    /// Linear RGB of the direct light.
    pub color: Vec3,
    /// Linear RGB of the light from everywhere.
    pub ambient: Vec3,
}

impl Light {
    /// The direction towards the light with length 1; up, where `direction` has no length.
    #[must_use]
    pub fn towards(&self) -> Vec3 {
        self.direction.normalize_or(Vec3::Y)
    }
}

/// The simulated device that is asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceChoice {
    /// The memory budget in bytes.
    pub memory: u64,
    /// The name of the bus; whether it exists is for the device to say.
    pub link: String,
    /// The name of the card profile; whether it exists is for the device to say.
    pub card: String,
}

/// What is compared with a stored reference.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Golden {
    /// Pixels of the reference images, at most 160 a side.
    pub size: ImageSize,
    /// The frames that are compared, ascending.
    pub frames: Vec<u32>,
    /// The largest difference of a channel (of 255) that passes; 0 is exact.
    pub tolerance: u8,
    /// Why a tolerance above 0 is right.
    pub reason: Option<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_bounded_by_side_and_area() {
        assert!(ImageSize::new(1, 1).is_some());
        assert!(ImageSize::new(7680, 4320).is_some());
        assert!(ImageSize::new(16_384, 2048).is_some());
        assert!(ImageSize::new(16_384, 2049).is_none());
        assert!(ImageSize::new(0, 5).is_none());
        assert!(ImageSize::new(16_385, 1).is_none());
    }

    #[test]
    fn light_without_length_shines_from_above() {
        let light = |direction| Light {
            direction,
            color: Vec3::ONE,
            ambient: Vec3::ZERO,
        };
        assert_eq!(light(Vec3::ZERO).towards(), Vec3::Y);
        assert_eq!(light(Vec3::new(0.0, 0.0, -4.0)).towards(), Vec3::NEG_Z);
    }
}
