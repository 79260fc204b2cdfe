//! Which level-of-detail system is asked for, and with which options.

use crate::document::choices;

choices! {
    /// The level-of-detail systems.
    ModelName {
        /// Level of Detail Foliage ([RCRG06, RRCGR](crate::references)).
        Lodf = "lodf",
        /// No level of detail: the yardstick.
        Full = "full",
        /// View-dependent foliage ([RC03](crate::references)).
        Vdf = "vdf",
        /// Leaf cluster impostors ([GSS05](crate::references)).
        Impostors = "impostors",
        /// One picture of the crown, turned to the viewer ([GSS05](crate::references), § 1).
        Billboard = "billboard",
        /// Pictures from eight sides, of which the nearest shows ([GSS05](crate::references), § 1).
        Sprites = "sprites",
        /// Two upright pictures at a right angle ([GSS05](crate::references), § 1).
        Crossed = "crossed",
        /// Pictures from 8 × 8 directions, of which three are blended ([B18](crate::references)).
        Octahedral = "octahedral",
        /// Brush strokes with variable multiresolution, of leaves and branches ([CQHCVL06](crate::references)).
        Strokes = "strokes",
        /// No level of detail, and every leaf moved into the plane of its cluster: what impostors are
        /// equivalent to ([GSS05](crate::references), § 4).
        Flattened = "flattened",
        /// No leaf that has a surface: trees in winter. Needles are no such leaves.
        Bare = "bare",
    }
}

choices! {
    /// What is resident on the device, and so what a change of detail sends.
    Mode {
        /// Nothing is resident: each draw fetches from host memory.
        Host = "host",
        /// Vertices and a block of leaf records a cluster: a changed cluster is sent whole.
        Cluster = "cluster",
        /// The same blocks: only the slots that differ are sent.
        Slots = "slots",
        /// Every leaf record once, with birth and death stamps: a counter is sent.
        Stamps = "stamps",
        /// The papers' static list as printed, which does not work; a demonstration.
        Literal = "literal",
        /// VDF only: vertices and one list of the visible leaves, sent whole when it changes.
        Indices = "indices",
        /// Without levels only: the vertices, and nothing ever changes.
        Resident = "resident",
        /// Every leaf record once; the device selects by itself, and the camera is sent.
        Device = "device",
        /// Impostors only: a texture each.
        Direct = "direct",
        /// Impostors only: a map of leaves each, and pictures of one leaf.
        Indirect = "indirect",
        /// Billboards only: turned about the vertical axis, as is usual for trees.
        Axial = "axial",
        /// Billboards only: turned about its centre.
        Facing = "facing",
        /// Billboards only: axial, each texel at its own depth.
        Depth = "depth",
        /// Sprites only: the nearest of all.
        Nearest = "nearest",
        /// Crossed cards only: they never turn.
        Fixed = "fixed",
        /// Octahedral pictures only: from above.
        Hemisphere = "hemisphere",
        /// Octahedral pictures only: from all around.
        Sphere = "sphere",
        /// Strokes only: all of them on the device; the runs that show are sent.
        Ranges = "ranges",
    }
}

choices! {
    /// The level-of-detail systems for trunks.
    TrunkName {
        /// No level of detail: the yardstick.
        Full = "full",
        /// Multiresolution triangle strips ([RC04](crate::references)).
        LodStrips = "lodstrips",
        /// The same, with places that make no triangle cut out.
        LodStripsCut = "lodstrips-cut",
        /// Multiresolution ordered meshes ([RLBRC01](crate::references)).
        Mom = "mom",
        /// Branches as polygons and lines, and needles ([ZBMJLDC17](crate::references)).
        Branches = "branches",
    }
}

choices! {
    /// Where the triangles of trunks lie.
    TrunkMode {
        /// On the device: a change of detail sends what differs.
        Device = "device",
        /// In host memory: each draw fetches them.
        Host = "host",
        /// Branches only: the level that shows is resident, and sent whole when it changes.
        Mesh = "mesh",
        /// Branches only: a few levels are resident, and nothing is sent.
        Levels = "levels",
        /// Branches only: skeletal vectors are resident; the device makes levels of them.
        Skeleton = "skeleton",
    }
}

choices! {
    /// What makes few leaves of many.
    Simplifier {
        /// Two leaves become one with corners of both.
        LeafCollapse = "leaf-collapse",
        /// One of two leaves goes, and the other grows by its area ([CHPR07](crate::references)).
        Pruning = "pruning",
    }
}

choices! {
    /// How detail is spread over a plant.
    DetailKind {
        /// One level for the whole foliage.
        Uniform = "uniform",
        /// A level for each cluster, by its own distance.
        Variable = "variable",
    }
}

choices! {
    /// Which clusters deserve the leaves of a variable level.
    CriterionName {
        /// Near ones, by the distances between which detail falls; each for itself, or by a budget.
        Paper = "paper",
        /// Near ones, linearly from the nearest to the farthest of the crown.
        Distance = "distance",
        /// Those whose collapse shows most.
        ScreenError = "screen-error",
        /// Those on the crown's outline.
        Silhouette = "silhouette",
    }
}

choices! {
    /// How the leaves of a level are extracted.
    Extraction {
        /// One collapse or split after another.
        Single = "single",
        /// All steps between two levels at once.
        Batched = "batched",
    }
}

choices! {
    /// How scattered slots are sent.
    Gather {
        /// Each as a write of its own.
        Single = "single",
        /// All in one write of many regions.
        Regions = "regions",
    }
}

choices! {
    /// How wide a leaf record is.
    RecordWidth {
        /// Four vertex numbers of 4 bytes.
        Wide = "wide",
        /// Four of 2 bytes, counted within the cluster.
        Compact = "compact",
    }
}

choices! {
    /// How exact vertices are.
    VertexFormat {
        /// Three floats: 12 bytes.
        Float = "float",
        /// Three steps of the crown's box in 65,535: 8 bytes.
        Quantised = "quantised",
    }
}

choices! {
    /// What a device that selects by itself leaves out beside what lies out of sight.
    Occlusion {
        /// Nothing.
        None = "none",
        /// What is hidden by what was seen in the frame before.
        TwoPhase = "two-phase",
    }
}

impl TrunkName {
    /// The modes that the system has, the usual one first.
    #[must_use]
    pub fn modes(self) -> &'static [TrunkMode] {
        match self {
            Self::Full | Self::LodStrips | Self::LodStripsCut | Self::Mom => {
                &[TrunkMode::Device, TrunkMode::Host]
            }
            Self::Branches => &[TrunkMode::Skeleton, TrunkMode::Mesh, TrunkMode::Levels],
        }
    }
}

impl ModelName {
    /// The modes that the system has, the usual one first.
    #[must_use]
    pub fn modes(self) -> &'static [Mode] {
        match self {
            Self::Lodf => &[
                Mode::Cluster,
                Mode::Host,
                Mode::Slots,
                Mode::Stamps,
                Mode::Device,
                Mode::Literal,
            ],
            Self::Full | Self::Flattened | Self::Bare => &[Mode::Resident],
            Self::Vdf => &[Mode::Host, Mode::Indices],
            Self::Impostors => &[Mode::Direct, Mode::Indirect],
            Self::Billboard => &[Mode::Axial, Mode::Facing, Mode::Depth],
            Self::Sprites => &[Mode::Nearest],
            Self::Crossed => &[Mode::Fixed],
            Self::Octahedral => &[Mode::Hemisphere, Mode::Sphere],
            Self::Strokes => &[Mode::Ranges, Mode::Host],
        }
    }

    /// Whether what it draws are leaves, and not cards in their place.
    #[must_use]
    pub fn shows_leaves(self) -> bool {
        match self {
            Self::Lodf | Self::Full | Self::Vdf | Self::Flattened | Self::Bare => true,
            Self::Impostors
            | Self::Billboard
            | Self::Sprites
            | Self::Crossed
            | Self::Octahedral
            | Self::Strokes => false,
        }
    }
}

/// The system that renders the trees, with all its options.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelChoice {
    /// Which system.
    pub name: ModelName,
    /// What is resident: one of the system's [modes](ModelName::modes).
    pub mode: Mode,
    /// How detail is spread.
    pub detail: DetailKind,
    /// Between which distances detail falls from all to least.
    pub range: DetailRange,
    /// How leaves are extracted.
    pub extraction: Extraction,
    /// How scattered slots are sent.
    pub gather: Gather,
    /// How wide leaf records are.
    pub records: RecordWidth,
    /// How exact vertices are.
    pub vertices: VertexFormat,
    /// What the device leaves out: something in mode `device` only.
    pub occlusion: Occlusion,
    /// What makes few leaves of many.
    pub simplifier: Simplifier,
    /// The leaf count at which simplification stops, in place of the species'.
    pub stop_leaves: Option<u32>,
    /// A fixed level from 0 (all leaves) to 1 (fewest), in place of distance.
    pub level: Option<f32>,
    /// Which clusters deserve the leaves, with variable detail.
    pub criterion: CriterionName,
    /// How many leaves a tree shows, in place of distance and level.
    pub amount: Option<LeafAmount>,
    /// How far the wanted detail moves before it is gone over to: a share of the range, 0 to ½.
    pub hysteresis: f32,
    /// The most payload bytes that changes of detail send in a frame.
    pub budget_bytes: Option<u64>,
    /// Which system the trunk has.
    pub trunk: TrunkName,
    /// Where its triangles lie.
    pub trunk_mode: TrunkMode,
    /// A fixed level from 0 (all triangles) to 1 (fewest), in place of the foliage's.
    pub trunk_level: Option<f32>,
    /// The number of triangles at which its simplification stops, in place of the usual.
    pub trunk_triangles: Option<u32>,
}

/// How many leaves a tree shows, when distance does not say it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeafAmount {
    /// So many; at least one a cluster and at most all.
    Budget(u32),
    /// This share of all, from 0 to 1; at least one a cluster.
    Share(f32),
    /// As few as keep every leaf's error below so many pixels.
    PixelError(f32),
}

/// The distances between which detail falls, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetailRange {
    d_min: f32,
    d_max: f32,
}

impl DetailRange {
    /// Full detail up to `d_min`, least detail from `d_max` on; `None` unless both are finite and
    /// `0 ≤ d_min < d_max`.
    #[must_use]
    pub fn new(d_min: f32, d_max: f32) -> Option<Self> {
        let fits = d_min >= 0.0 && d_min < d_max && d_max.is_finite();
        fits.then_some(Self { d_min, d_max })
    }

    /// Up to here all leaves are drawn, in metres.
    #[must_use]
    pub fn d_min(self) -> f32 {
        self.d_min
    }

    /// From here on the fewest leaves are drawn, in metres.
    #[must_use]
    pub fn d_max(self) -> f32 {
        self.d_max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_are_the_same_list() {
        for (&mode, &name) in Mode::ALL.iter().zip(Mode::NAMES) {
            assert_eq!(mode.name(), name);
            assert_eq!(Mode::from_name(name), Some(mode));
        }
        assert_eq!(Mode::from_name("Host"), None);
    }

    #[test]
    fn ranges_have_an_inside() {
        assert!(DetailRange::new(0.0, 1.0).is_some());
        assert!(DetailRange::new(1.0, 1.0).is_none());
        assert!(DetailRange::new(-1.0, 1.0).is_none());
        assert!(DetailRange::new(f32::NAN, 1.0).is_none());
        assert!(DetailRange::new(0.0, f32::INFINITY).is_none());
    }
}
