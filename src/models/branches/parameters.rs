//! What programs must know of a species to light its lines, and to make levels of its skeleton.

use crate::gpu::Words;
use crate::models::{Environment, Trunk};
use crate::scene::BranchLines;
use crate::simplify::{BranchErrors, ErrorStep, LineAlpha, LineNormals, Shares};

/// The slot of the parameters in all programs of branches.
pub(super) const PARAMETER_SLOT: u32 = 3;

/// What is the same for all levels of a species.
///
/// | bytes | field         | type  | meaning |
/// |------:|---------------|-------|---------|
/// | 0–3   | `lines`       | `u32` | 0 round, 1 one normal, 2 three |
/// | 4–7   | `most_edges`  | `u32` | of a circle |
/// | 8–11  | `pixel_error` | `f32` | `δ`; 0 where lines are as opaque as the paper has them, less where they are as they are seen |
/// | 12–15 | `shares`      | `u32` | 0 equal, 1 that add up |
/// | 16–19 | `has_needles` | `u32` | 0 or 1 |
/// | 20–23 | `pixels`      | `f32` | how many a metre spans at `w` = 1 |
///
/// Little-endian and unpadded, 24 bytes once a species.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Parameters {
    pub(super) lines: BranchLines,
    pub(super) most_edges: u32,
    pub(super) alpha: LineAlpha,
    pub(super) shares: Shares,
    pub(super) has_needles: bool,
    pub(super) pixels: f32,
}

impl Parameters {
    pub(super) const BYTES: u64 = 24;

    pub(super) fn of(trunk: &Trunk, environment: &Environment) -> Self {
        let sequence = trunk.branches();
        let options = sequence.polygon_options();
        Self {
            lines: trunk.branch_choice().line_normals,
            most_edges: options.most_edges,
            alpha: options.line_alpha,
            shares: trunk.branch_choice().error_shares(),
            has_needles: sequence.needles().original_count() > 0,
            pixels: environment.pixels_per_metre,
        }
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let lines = match self.lines {
            BranchLines::Round => 0,
            BranchLines::One => 1,
            BranchLines::Three => 2,
        };
        let pixel_error = match self.alpha {
            LineAlpha::Paper => 0.0,
            LineAlpha::Coverage { pixel_error } => pixel_error,
            LineAlpha::Width => -1.0,
        };
        let words = [
            lines,
            self.most_edges,
            f32::to_bits(pixel_error),
            u32::from(self.shares == Shares::Honest),
            u32::from(self.has_needles),
            self.pixels.to_bits(),
        ];
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    pub(super) fn read(words: Words<'_>) -> Self {
        let [lines, most_edges, pixel_error, shares, has_needles, pixels] = words.u32s(0);
        let pixel_error = f32::from_bits(pixel_error);
        Self {
            lines: match lines {
                0 => BranchLines::Round,
                1 => BranchLines::One,
                _ => BranchLines::Three,
            },
            most_edges,
            alpha: if pixel_error > 0.0 {
                LineAlpha::Coverage { pixel_error }
            } else if pixel_error < 0.0 {
                LineAlpha::Width
            } else {
                LineAlpha::Paper
            },
            shares: if shares == 0 {
                Shares::Equal
            } else {
                Shares::Honest
            },
            has_needles: has_needles != 0,
            pixels: f32::from_bits(pixels),
        }
    }

    /// How many lines an internode has, and with which normals.
    pub(super) fn normals(self) -> LineNormals {
        match self.lines {
            BranchLines::Round | BranchLines::One => LineNormals::One,
            BranchLines::Three => LineNormals::Three,
        }
    }

    /// The errors of a level.
    pub(super) fn errors(self, step: ErrorStep) -> BranchErrors {
        self.shares.errors(step.error(), self.has_needles)
    }
}
