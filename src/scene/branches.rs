//! How wood and needles are drawn as polygons and lines: what a scene's `[branches]` says.

use crate::document::choices;

choices! {
    /// How an error becomes the errors of its parts.
    BranchShares {
        /// Equal shares that add up to it.
        Sound = "sound",
        /// Each part may have all of it, as in the paper.
        Paper = "paper",
    }
}

choices! {
    /// How frames go from node to node.
    BranchFrames {
        /// Two reflections a step ([WJZL08](crate::references)): they do not twist.
        DoubleReflection = "double-reflection",
        /// The last normal projected ([ZBMJLDC17](crate::references), eq. A1).
        Projection = "projection",
    }
}

choices! {
    /// How needles merge.
    NeedleMerging {
        /// What is near merges first, and the crown keeps its area.
        Sound = "sound",
        /// Across the crown, and needles stay as thin as they were.
        Paper = "paper",
    }
}

choices! {
    /// How opaque lines are.
    BranchAlpha {
        /// As much as they cover of the pixels where they are seen.
        Coverage = "coverage",
        /// As much as they would cover of a pixel where the error spans `pixel_error`.
        Error = "error",
        /// `2 R / E3` ([ZBMJLDC17](crate::references), eq. 12).
        Paper = "paper",
    }
}

choices! {
    /// How lines catch light.
    BranchLines {
        /// As the side of a cylinder that is seen.
        Round = "round",
        /// By the frame's normal.
        One = "one",
        /// Three lines with normals a third of a turn apart, together as opaque as one.
        Three = "three",
    }
}

choices! {
    /// Which branches go first.
    BranchRemoval {
        /// Those that are nearest to their bearer with all that they bear.
        Distance = "distance",
        /// Those with the least volume, and nothing else is simplified: a reconstruction of
        /// [LCV03](crate::references), with as many primitives as the other way would leave.
        Volume = "volume",
    }
}

/// What a scene says about branches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchChoice {
    /// A fixed error, in metres of the plant, in place of `pixel_error`.
    pub error: Option<f32>,
    /// The error in pixels at the tree's nearest point (`δ`).
    pub pixel_error: f32,
    /// No error is less, in metres.
    pub finest: f32,
    /// The coarsest of a few discrete levels, and what level 1 stands for, in metres.
    pub coarsest: f32,
    /// How the error is divided.
    pub shares: BranchShares,
    /// How frames go.
    pub frames: BranchFrames,
    /// How far the ends of a merge may lean from it together, in degrees (`Γ`).
    pub torsion: f32,
    /// How needles merge.
    pub needles: NeedleMerging,
    /// The most edges of a circle (`H`).
    pub most_edges: u32,
    /// How opaque lines are.
    pub line_alpha: BranchAlpha,
    /// How they catch light.
    pub line_normals: BranchLines,
    /// Which branches go first.
    pub removal: BranchRemoval,
}

impl BranchChoice {
    /// What is chosen where a scene says nothing.
    pub const USUAL: Self = Self {
        error: None,
        pixel_error: 0.5,
        finest: 0.0005,
        coarsest: 0.22,
        shares: BranchShares::Sound,
        frames: BranchFrames::DoubleReflection,
        torsion: 60.0,
        needles: NeedleMerging::Sound,
        most_edges: 64,
        line_alpha: BranchAlpha::Coverage,
        line_normals: BranchLines::Round,
        removal: BranchRemoval::Distance,
    };
}
