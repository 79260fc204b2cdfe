//! From what a scene says to how a plant becomes levels.

use crate::scene::{
    BranchAlpha, BranchChoice, BranchFrames, BranchLines, BranchShares, NeedleMerging,
};
use crate::simplify::{
    BranchOptions, Caps, ErrorStep, FrameMethod, LineAlpha, LineNormals, PolygonOptions, Shares,
};

impl BranchChoice {
    /// How a plant becomes a sequence of levels.
    pub(in crate::models) fn sequence_options(&self) -> BranchOptions {
        let needles = match self.needles {
            NeedleMerging::Sound => BranchOptions::SOUND.needles,
            NeedleMerging::Paper => BranchOptions::PAPER.needles,
        };
        BranchOptions {
            frames: match self.frames {
                BranchFrames::DoubleReflection => FrameMethod::DoubleReflection,
                BranchFrames::Projection => FrameMethod::Projection,
            },
            torsion_limit: self.torsion.to_radians(),
            needles,
            polygons: PolygonOptions {
                most_edges: self.most_edges,
                line_alpha: match self.line_alpha {
                    BranchAlpha::Coverage => LineAlpha::Width,
                    BranchAlpha::Error => LineAlpha::Coverage {
                        pixel_error: self.pixel_error,
                    },
                    BranchAlpha::Paper => LineAlpha::Paper,
                },
                line_normals: match self.line_normals {
                    BranchLines::Round | BranchLines::One => LineNormals::One,
                    BranchLines::Three => LineNormals::Three,
                },
                caps: Caps::Tip,
            },
        }
    }

    /// How an error is divided.
    #[must_use]
    pub fn error_shares(&self) -> Shares {
        match self.shares {
            BranchShares::Sound => Shares::Honest,
            BranchShares::Paper => Shares::Equal,
        }
    }

    /// The finest and the coarsest step: no error is less than the first, and level 1 is the second.
    #[must_use]
    pub fn steps(&self) -> [ErrorStep; 2] {
        let [finest, coarsest] = [self.finest, self.coarsest].map(ErrorStep::within);
        [finest, coarsest.max(finest)]
    }

    /// The step of an error in metres.
    #[must_use]
    pub fn step(&self, error: f32) -> ErrorStep {
        ErrorStep::within(error).max(self.steps()[0])
    }
}
