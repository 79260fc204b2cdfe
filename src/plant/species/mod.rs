//! Species: what a kind of tree is, read from TOML files (`schema = "spinney.species/1"`).
//!
//! The parameters are those of Weber and Penn ([WP95](crate::references), appendix) in a readable
//! spelling, and what the foliage systems need besides: exact leaf counts, how far simplification
//! goes, silhouettes and colours. What a file does not say is the paper's quaking aspen.

mod arbaro;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use arbaro::ArbaroSpecies;

use super::Silhouette;

/// The schema that a species file names.
pub const SPECIES_SCHEMA: &str = "spinney.species/1";

/// A kind of tree; every number lies in the range that the table of keys states.
///
#[doc = include_str!("keys.md")]
#[derive(Debug, Clone, PartialEq)]
pub struct Species {
    /// What people call it.
    pub name: String,
    /// The botanical name; may be empty.
    pub latin: String,
    /// How many leaves a plant has, exactly; without it the generator's density decides.
    pub leaf_count: Option<u32>,
    /// How many leaves remain after all collapses, at least 1.
    pub stop_leaves: Option<u32>,
    /// How many triangles the trunk mesh has, within 5 %; without it [`Wood::tube_edges`] decides.
    pub trunk_polygons: Option<u32>,
    /// Size and outline.
    pub crown: Crown,
    /// Several trunks from one root.
    pub clump: Clump,
    /// Thickness and surface of stems.
    pub wood: Wood,
    /// The stems of each level, 0 the trunk.
    pub stems: [StemLevel; 4],
    /// How leaves sit on the stems of the last level.
    pub leaves: LeafHabit,
    /// Numbers of leaves that are left out of the grown plant, ascending; ours.
    ///
    /// Numbers are those that the leaves have without this: through all kinds in order, those of the
    /// first kind first. All that stays is what it was, to the bit; only numbers close up. So a plant
    /// can be had that differs from another in one leaf.
    pub omitted_leaves: Vec<u32>,
    /// What leaves look like; at least one kind.
    pub foliage: Vec<FoliageKind>,
}

impl Species {
    /// The most leaves that a species may leave out.
    pub const MAX_OMITTED: usize = crate::limits::OMITTED_LEAVES;

    /// What every key of a species file means: a table in Markdown.
    pub const HELP: &'static str = include_str!("keys.md");
}

/// The outline of a crown: how long level-1 stems are along the trunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Longest at the bottom.
    Conical,
    /// Longest in the middle.
    Spherical,
    /// Longest at the bottom, rounded.
    Hemispherical,
    /// All alike.
    Cylindrical,
    /// Half as long at the top.
    TaperedCylindrical,
    /// Longest at 30 % of the height, pointed.
    Flame,
    /// Longest at the top.
    InverseConical,
    /// Like a flame, never below half.
    TendFlame,
    /// The pruning envelope.
    Envelope,
}

/// Size and outline of the crown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crown {
    /// Paper: `Shape`.
    pub shape: Shape,
    /// Paper: `Levels`, how many levels of stems there are.
    pub levels: u32,
    /// Paper: `BaseSize`, the share of the height without branches.
    pub base_size: f32,
    /// Paper: `Scale`, the height in metres.
    pub scale: f32,
    /// Paper: `ScaleV`, in metres.
    pub scale_v: f32,
    /// Paper: `ZScale`; here a stretch of all heights.
    pub vertical_scale: f32,
    /// Paper: `ZScaleV`.
    pub vertical_scale_v: f32,
    /// Paper: `AttractionUp`, by level; the paper has one number, for levels 2 and 3.
    pub attraction_up: [f32; 4],
    /// The envelope that stems are pruned to.
    pub pruning: Pruning,
}

/// The pruning envelope, in shares of the tree's height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pruning {
    /// Paper: `PruneRatio`; 0 prunes nothing, 1 all that is outside.
    pub ratio: f32,
    /// Paper: `PruneWidth`, the greatest radius as a share of the height.
    pub width: f32,
    /// Paper: `PruneWidthPeak`, where it is greatest, as a share of the crown's height.
    pub width_peak: f32,
    /// Paper: `PrunePowerLow`, the curve below the peak.
    pub power_low: f32,
    /// Paper: `PrunePowerHigh`, the curve above it.
    pub power_high: f32,
}

/// Several trunks from one root; ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clump {
    /// How many trunks.
    pub count: u32,
    /// The radius of the disc on which they stand, in metres.
    pub radius: f32,
    /// How far the outermost lean outwards, in degrees.
    pub lean: f32,
}

/// Thickness and surface of stems.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wood {
    /// Paper: `Ratio`, the trunk's radius as a share of its length.
    pub ratio: f32,
    /// Paper: `RatioPower`, how fast stems thin with their level.
    pub ratio_power: f32,
    /// Paper: `Lobes`, bulges around the trunk.
    pub lobes: u32,
    /// Paper: `LobeDepth`, as a share of the radius.
    pub lobe_depth: f32,
    /// Paper: `Flare`, widening at the trunk's base.
    pub flare: f32,
    /// Paper: `0Scale`, a factor on the trunk's radius.
    pub trunk_scale: f32,
    /// Paper: `0ScaleV`.
    pub trunk_scale_v: f32,
    /// Paper: `0BaseSplits`, clones made at the end of the trunk's first segment.
    pub base_splits: u32,
    /// The bark's colour, sRGB.
    pub bark_color: [u8; 3],
    /// Edges of the tubes of each level; 0 for none.
    pub tube_edges: [u32; 4],
}

/// One level of stems; angles in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StemLevel {
    /// Paper: `nLength`, as a share of the parent's length (of the height, for the trunk).
    pub length: f32,
    /// Paper: `nLengthV`.
    pub length_v: f32,
    /// Paper: `nTaper`: 0 cylinder, 1 cone, 2 rounded end, 3 periodic bulges.
    pub taper: f32,
    /// Paper: `nSegSplits`, clones made a segment.
    pub segment_splits: f32,
    /// Paper: `nSplitAngle`.
    pub split_angle: f32,
    /// Paper: `nSplitAngleV`.
    pub split_angle_v: f32,
    /// Paper: `nCurveRes`, segments a stem.
    pub curve_res: u32,
    /// Paper: `nCurve`, the bend from base to tip.
    pub curve: f32,
    /// Paper: `nCurveBack`, the bend of the upper half, when not 0.
    pub curve_back: f32,
    /// Paper: `nCurveV`; below 0 the stem is a helix with this declination.
    pub curve_v: f32,
    /// Paper: `nDownAngle`, between parent and stem.
    pub down_angle: f32,
    /// Paper: `nDownAngleV`; below 0 the angle varies along the parent instead of at random.
    pub down_angle_v: f32,
    /// Paper: `nRotate`, from one stem to the next; below 0 stems alternate sides.
    pub rotate: f32,
    /// Paper: `nRotateV`.
    pub rotate_v: f32,
    /// Paper: `nBranches`, stems on a parent.
    pub branches: f32,
}

/// How leaves sit on the stems of the last level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafHabit {
    /// Paper: `Leaves`, on a stem; below 0 they form a fan at its tip.
    pub per_stem: f32,
    /// How far leaves turn outwards and up to the light: 0 not, 1 wholly.
    pub bend: f32,
    /// How leaves bend up, below 0 down, as [`Crown::attraction_up`] bends stems; ours.
    pub attraction_up: f32,
    /// The share of a bearing stem, from its base, that has no leaves; ours.
    pub bare: f32,
}

/// One kind of leaf: a group of the plant's foliage.
#[derive(Debug, Clone, PartialEq)]
pub struct FoliageKind {
    /// What its image shows; needles have none.
    pub silhouette: Silhouette,
    /// Its share of all leaves, relative to the other kinds'.
    pub share: f32,
    /// Paper: `LeafScale`, in metres.
    pub length: f32,
    /// A length's random part, as a share of the length.
    pub length_v: f32,
    /// Paper: `LeafScaleX`, width as a share of the length.
    pub width: f32,
    /// The blade's colour, sRGB.
    pub color: [u8; 3],
    /// How the blade is made.
    pub blade: Blade,
}

/// What a leaf's blade is made of; ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blade {
    /// Two faces in one plane: a quad.
    Flat,
    /// A mesh that bends along the midrib and folds across it.
    Bent {
        /// How many faces: even, at least 4. Every four are a piece of the blade's length over its whole
        /// width, two on each side of the midrib; two that are left narrow to a point at the tip.
        faces: u32,
        /// How far the tip's direction turns down from the base's, in degrees; below 0 up.
        droop: f32,
        /// How far each half rises from the plane across the midrib, in degrees; below 0 falls.
        fold: f32,
    },
    /// A needle: a line from base to tip, without an image.
    Needle {
        /// How thick it is, in metres.
        diameter: f32,
    },
}
