//! How forests of patches are drawn: what a scene's `[grove]` says.

use crate::document::choices;

choices! {
    /// What is drawn at once.
    GrovePacking {
        /// All samples of a patch (the first improvement of [ZBMJLDC17](crate::references), section 6.2).
        Patches = "patches",
        /// One sample of all patches after the other, as in [BLZD12](crate::references).
        Samples = "samples",
    }
}

choices! {
    /// In which order the patches of a level are drawn.
    GroveOrder {
        /// From far to near, sorted on the host (the third improvement).
        Host = "host",
        /// From far to near, sorted where they are.
        Device = "device",
        /// As they are numbered.
        None = "none",
    }
}

choices! {
    /// How lines meet what is behind them.
    GroveBlend {
        /// In the order of drawing; depth is tested and written, as the paper has it.
        WritesDepth = "writes-depth",
        /// In the order of drawing; depth is only tested.
        KeepsDepth = "keeps-depth",
        /// Every fragment by its depth: the truth.
        Sorted = "sorted",
        /// There or not, as a hash of the place says ([WM17](crate::references)).
        Hashed = "hashed",
        /// There in as many samples of a pixel as opacity says: alpha to coverage.
        Coverage = "coverage",
        /// One layer after the other, the nearest first ([E01](crate::references)).
        Peeled = "peeled",
        /// Weighted by depth and opacity, in any order ([MB13](crate::references)).
        Weighted = "weighted",
        /// Weighted by what four moments of depth say of the light there ([MKKP18](crate::references)).
        Moments = "moments",
    }
}

/// How the trees of forests that stand in patches are drawn, all of a patch at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroveChoice {
    /// How many levels, at most 8 (the paper's `N`).
    pub levels: u32,
    /// What is drawn at once.
    pub packing: GrovePacking,
    /// How many levels each pass over the lines draws: one, from far to near, or several, from near to far.
    pub levels_a_pass: u32,
    /// In which order the patches of a level are drawn.
    pub order: GroveOrder,
    /// How lines meet what is behind them.
    pub blend: GroveBlend,
    /// How many layers are peeled, at most [`MOST_LAYERS`](Self::MOST_LAYERS); of peeled ones alone.
    pub layers: u32,
}

impl GroveChoice {
    /// The most layers that are peeled: a target each.
    pub const MOST_LAYERS: u32 = 32;

    /// How many are peeled unless a scene says otherwise.
    pub const LAYERS: u32 = 8;

    /// As the paper ends up.
    pub const PAPER: Self = Self {
        levels: 8,
        packing: GrovePacking::Patches,
        levels_a_pass: 1,
        order: GroveOrder::Host,
        blend: GroveBlend::WritesDepth,
        layers: Self::LAYERS,
    };

    /// What the paper improves on: instancing as in [BLZD12](crate::references), four levels a pass.
    pub const NAIVE: Self = Self {
        packing: GrovePacking::Samples,
        levels_a_pass: 4,
        order: GroveOrder::None,
        ..Self::PAPER
    };

    /// The same primitives, every fragment in its place.
    pub const TRUTH: Self = Self {
        order: GroveOrder::None,
        blend: GroveBlend::Sorted,
        ..Self::PAPER
    };
}
