//! Wood and needles as polygons and lines at any error ([ZBMJLDC17](crate::references)).
//!
//! ```text
//!                  once a species                          once an instance     a change
//! mesh      ─▶ parameters                                  room for a level     the level's vertices, indices
//! levels    ─▶ 8 levels: vertices, indices                 –                    –
//! skeleton  ─▶ 52 B a node, 4 B along, routes, needles     the step             the step: 4 B
//!                                     │
//!              each draw: node ─▶ where its internode begins ─▶ prism, prismoid, fan, cap or line
//! ```
//!
//! Polygons are opaque, and all modes give them the same vertices in the same order of numbers. Lines are one
//! pixel wide and blended: they come after everything that is opaque, from far trees to near ones, and cast
//! no shadow. What a plant has no skeleton for is drawn as a mesh in full.
//!
//! **Invariant.** At the same error all modes show the same picture, bit for bit; `levels` shows the coarsest
//! of its levels that is not off by more than is asked for.

mod expand;
mod levels;
mod light;
mod lines;
mod mesh;
mod options;
mod parameters;
mod skeleton;
mod skeleton_program;
mod surfaces;

use std::sync::Arc;

pub(super) use light::Viewer;
pub(super) use lines::LineProgram;
pub(super) use skeleton_program::{Of, SkeletonProgram};

use super::{Trunk, TrunkLevel, TrunkModel};
use crate::scene::TrunkMode;
use crate::simplify::ErrorStep;

/// First part of the key of everything that shows wood as branches.
pub const BRANCH_GROUP: u32 = 4;

/// First part of the key of everything that shows a needle.
pub const NEEDLE_GROUP: u32 = 5;

/// The error that shows where a level is asked for: never less than the finest.
pub(super) fn shown_step(trunk: &Trunk, mode: TrunkMode, level: TrunkLevel) -> ErrorStep {
    let [finest, _] = trunk.branch_choice().steps();
    let wanted = level.step().max(finest);
    match mode {
        TrunkMode::Levels => {
            let mut steps = levels::discrete_steps(trunk);
            steps.retain(|step| *step <= wanted);
            steps.last().copied().unwrap_or(finest)
        }
        TrunkMode::Mesh | TrunkMode::Skeleton | TrunkMode::Device | TrunkMode::Host => wanted,
    }
}

/// The model of a trunk whose plant has a skeleton.
pub(super) fn model(trunk: Arc<Trunk>, mode: TrunkMode) -> Box<dyn TrunkModel> {
    match mode {
        TrunkMode::Levels => Box::new(levels::Levels::new(trunk)),
        TrunkMode::Skeleton => Box::new(skeleton::Skeleton::new(trunk)),
        TrunkMode::Mesh | TrunkMode::Device | TrunkMode::Host => Box::new(mesh::Mesh::new(trunk)),
    }
}
