//! Branches at a list of errors: how they look, what they take in each mode, and how smoothly they change.
//!
//! ```text
//! scene without leaves ─┬─ levels ───▶ a picture an error, and as many primitives by pruning
//!                       ├─ modes ────▶ bytes and modelled times of a walk through the errors and back
//!                       └─ steps ────▶ picture against picture along the camera's path
//! ```

use std::sync::Arc;

use super::RunError;
use super::methods::difference;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::{Layers, Session};
use super::world::{StandingTree, World, with_foliage};
use crate::gpu::Ledger;
use crate::math::{Mat4, Vec3, det};
use crate::models::{Crown, Placement, State, Storage, TreeState, TrunkKind, TrunkLevel};
use crate::plant::{Branch, Foliage, Node, Plant, Skeleton};
use crate::raster::Image;
use crate::scene::{BranchChoice, BranchRemoval, Scene, TrunkMode, TrunkName};
use crate::simplify::{
    BranchLevel, EdgeTable, ErrorStep, LevelBound, PrimitiveCounts, fractional_edges,
};

/// What is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchStudy {
    /// The errors, in metres, ascending.
    pub errors: Vec<f32>,
    /// The picture's size, link and card.
    pub session: SessionOptions,
}

/// A level that is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StudyLevel {
    /// The error that is asked for, in metres.
    pub asked: f32,
    /// The step of the scale that is drawn: the greatest within it.
    pub step: ErrorStep,
    /// How it came to have so few primitives.
    pub way: StudyWay,
}

/// A way to few primitives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StudyWay {
    /// Merging, polygons and lines, and branches that go by how far they reach.
    Error,
    /// Branches that go by volume, and nothing else, until there are as few primitives.
    Pruning,
}

/// How a level looks.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchLook {
    /// Which.
    pub level: StudyLevel,
    /// Of what the branches of the first plant are.
    pub wood: PrimitiveCounts,
    /// Of what its needles are.
    pub needles: PrimitiveCounts,
    /// How many internodes are left.
    pub internodes: u64,
    /// How far it may be off.
    pub bound: LevelBound,
    /// The frame: all, polygons alone, lines alone.
    pub images: [Image; 3],
    /// What the frame took.
    pub frame: Ledger,
    /// The internodes that are left as the frame shows them, in pixels, with the branch's level.
    pub skeleton: Vec<SkeletonLine>,
}

/// An internode on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkeletonLine {
    /// Its ends, in pixels from the upper left corner.
    pub ends: [[f32; 2]; 2],
    /// The branching level: 0 for a trunk.
    pub level: u32,
}

/// What a mode takes on a walk from the finest level to the coarsest and back.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchModeCost {
    /// Which.
    pub kind: TrunkKind,
    /// What it keeps.
    pub storage: Storage,
    /// The upload before the first frame.
    pub initial: Ledger,
    /// Each change, and the frame after it.
    pub changes: Vec<(ErrorStep, Ledger)>,
}

/// How much a picture differs from the one before it on the path: mean over pixels and channels, of 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchStep {
    /// The later frame.
    pub frame: u32,
    /// With errors by distance.
    pub by_distance: f64,
    /// At the finest error.
    pub finest: f64,
    /// The step of the error of the first tree.
    pub step: ErrorStep,
}

/// What a scene says about branches, with errors as small as the study's.
fn choice(scene: &Scene, errors: &[f32], removal: BranchRemoval) -> BranchChoice {
    let least = errors.iter().copied().fold(scene.branches.finest, f32::min);
    BranchChoice {
        finest: least.max(ErrorStep::FINEST.error()),
        removal,
        ..scene.branches
    }
}

/// Looks at every error, and at pruning to as many primitives as each has.
///
/// # Errors
///
/// What the device refuses, and what `take` answers.
pub fn branch_looks<E: From<RunError>>(
    scene: &Scene,
    world: &World,
    study: &BranchStudy,
    progress: &dyn Progress,
    mut take: impl FnMut(BranchLook) -> Result<(), E>,
) -> Result<(), E> {
    progress.begin("levels", 2 * study.errors.len() as u64);
    let ways = [
        (StudyWay::Error, BranchRemoval::Distance),
        (StudyWay::Pruning, BranchRemoval::Volume),
    ];
    for (way, removal) in ways {
        let choice = choice(scene, &study.errors, removal);
        let world = world.branched(&choice);
        let Some(trunk) = world.trunks.first().and_then(Option::as_ref) else {
            return Ok(());
        };
        // A single branch cannot be pruned.
        let branches = trunk.branches().skeleton().branches.len();
        if way == StudyWay::Pruning && branches < 2 {
            break;
        }
        let kind = TrunkKind {
            name: TrunkName::Branches,
            mode: TrunkMode::Mesh,
        };
        for &asked in &study.errors {
            let scene = Scene {
                branches: BranchChoice {
                    error: Some(asked),
                    ..choice
                },
                ..scene.clone()
            };
            let options = SessionOptions {
                trunk: kind,
                ..study.session
            };
            let mut session = Session::new(&scene, &world, &options)?;
            let frame = session.frame(0)?;
            let level = StudyLevel {
                asked,
                step: choice.step(asked),
                way,
            };
            let made = trunk.branch_level(level.step);
            let all = frame.image;
            take(BranchLook {
                level,
                wood: made.branches.counts(),
                needles: made.needles.counts(),
                internodes: made.nodes.internode_count() as u64,
                bound: made.bound,
                images: [
                    all,
                    session.layers(0, Layers::Polygons)?,
                    session.layers(0, Layers::Lines)?,
                ],
                frame: frame.ledger,
                skeleton: skeleton(&scene, &world, &options, &made),
            })?;
            progress.step();
        }
    }
    Ok(())
}

/// The internodes of the first tree's level.
fn skeleton(
    scene: &Scene,
    world: &World,
    options: &SessionOptions,
    level: &BranchLevel,
) -> Vec<SkeletonLine> {
    let view = scene.camera.at(0, options.size);
    let tree = world.trees.iter().find(|tree| tree.crown == 0);
    let (Some(tree), Some(trunk)) = (tree, world.trunks[0].as_ref()) else {
        return Vec::new();
    };
    let [width, height] = [options.size.width(), options.size.height()].map(|side| side as f32);
    let clip: Mat4 = view.clip_from_world;
    let skeleton = trunk.branches().skeleton();
    let at = |node: u32| {
        let world = tree
            .placement
            .to_world(skeleton.vectors[node as usize].position);
        let clip = clip * world.extend(1.0);
        let [x, y] = [clip.x, clip.y].map(|at| at / clip.w);
        [0.5 * (1.0 + x) * width, 0.5 * (1.0 - y) * height]
    };
    let runs = level.nodes.first.windows(2).zip(&level.nodes.branches);
    let lines = runs.flat_map(|(run, &branch)| {
        let nodes = &level.nodes.nodes[run[0] as usize..run[1] as usize];
        let level = skeleton.branches[branch as usize].level;
        nodes.windows(2).map(move |pair| (pair[0], pair[1], level))
    });
    let lines = lines.map(|(from, to, level)| SkeletonLine {
        ends: [at(from), at(to)],
        level,
    });
    lines.collect()
}

/// Walks through the errors and back in every mode.
///
/// # Errors
///
/// What the device refuses.
pub fn branch_modes(
    scene: &Scene,
    world: &World,
    study: &BranchStudy,
    progress: &dyn Progress,
) -> Result<Vec<BranchModeCost>, RunError> {
    let modes = TrunkName::Branches.modes();
    progress.begin("modes", modes.len() as u64);
    let choice = choice(scene, &study.errors, BranchRemoval::Distance);
    let world = world.branched(&choice);
    let scene = Scene {
        branches: choice,
        ..scene.clone()
    };
    let steps: Vec<ErrorStep> = study
        .errors
        .iter()
        .map(|&error| choice.step(error))
        .collect();
    let back = steps.iter().rev().skip(1);
    let walk: Vec<ErrorStep> = steps.iter().skip(1).chain(back).copied().collect();
    let mut found = Vec::new();
    for &mode in modes {
        let kind = TrunkKind {
            name: TrunkName::Branches,
            mode,
        };
        let options = SessionOptions {
            trunk: kind,
            ..study.session
        };
        let state = |step: ErrorStep| TreeState {
            foliage: State::FINEST,
            trunk: TrunkLevel::Error(step),
        };
        let all = |step: ErrorStep| vec![state(step); world.trees.len()];
        let start = all(steps.first().copied().unwrap_or_default());
        let mut session = Session::standing(&scene, &world, &options, &start)?;
        let initial = session.initial().clone();
        session.frame_of(0, &start)?;
        let mut changes = Vec::new();
        for &step in &walk {
            changes.push((step, session.frame_of(0, &all(step))?.ledger));
        }
        let trunk = world.trunks.first().and_then(Option::as_ref);
        found.push(BranchModeCost {
            kind,
            storage: trunk.map_or_else(Storage::default, |trunk| {
                kind.model(trunk, options.model).storage()
            }),
            initial,
            changes,
        });
        progress.step();
    }
    Ok(found)
}

/// Compares each frame of the path with the one before, with errors by distance and without.
///
/// # Errors
///
/// What the device refuses.
pub fn branch_steps(
    scene: &Scene,
    world: &World,
    study: &BranchStudy,
    progress: &dyn Progress,
) -> Result<Vec<BranchStep>, RunError> {
    let choice = BranchChoice {
        error: None,
        ..choice(scene, &study.errors, BranchRemoval::Distance)
    };
    let world = world.branched(&choice);
    let options = SessionOptions {
        trunk: TrunkKind {
            name: TrunkName::Branches,
            mode: TrunkMode::Skeleton,
        },
        ..study.session
    };
    let scenes = [None, Some(choice.finest)].map(|error| Scene {
        branches: BranchChoice { error, ..choice },
        ..scene.clone()
    });
    let [by_distance, finest] = &scenes;
    let mut sessions = [
        Session::new(by_distance, &world, &options)?,
        Session::new(finest, &world, &options)?,
    ];
    progress.begin("frames", u64::from(scene.frames));
    let mut before: Option<[Image; 2]> = None;
    let mut found = Vec::new();
    for frame in 0..scene.frames {
        let [one, other] = &mut sessions;
        let shown = [one.frame(frame)?, other.frame(frame)?];
        let step = shown[0].states.first().map(|state| state.trunk.step());
        let images = shown.map(|frame| frame.image);
        if let Some(before) = &before {
            let [by_distance, finest] =
                [0, 1].map(|run: usize| difference(&before[run], &images[run]));
            found.push(BranchStep {
                frame,
                by_distance,
                finest,
                step: step.unwrap_or_default(),
            });
        }
        before = Some(images);
        progress.step();
    }
    Ok(found)
}

/// A world of one winding branch of even thickness, in the bark of another's first plant: Figure 7 of
/// [ZBMJLDC17](crate::references), which does not say how it winds.
///
/// Two turns of half a metre's radius, two metres high, a decimetre thick to each side.
#[must_use]
pub fn helix(world: &World) -> World {
    const NODES: u32 = 97;
    const TURNS: f32 = 2.0;
    let node = |number: u32| {
        let share = number as f32 / (NODES - 1) as f32;
        let (sine, cosine) = det::sin_cos(std::f32::consts::TAU * TURNS * share);
        Node {
            position: Vec3::new(0.5 * cosine, 2.0 * share, 0.5 * sine),
            radius: 0.1,
        }
    };
    let skeleton = Skeleton {
        nodes: (0..NODES).map(node).collect(),
        branches: vec![Branch {
            bearer: None,
            level: 0,
            first_node: 0,
            node_count: NODES,
        }],
    };
    let bark = world.plants.iter().find_map(|plant| plant.trunk());
    let plant = Plant::new("helix", Some(skeleton), bark.cloned(), Foliage::default());
    // Without bark there is no trunk, and nothing to draw.
    let plants = plant.into_iter().map(Arc::new);
    let crowns: Vec<Arc<Crown>> = plants
        .map(|plant| Arc::new(with_foliage(&plant, Foliage::default())))
        .collect();
    let trees = (0..crowns.len()).map(|crown| StandingTree {
        crown,
        placement: Placement::IDENTITY,
    });
    let trees = trees.collect();
    World::of(crowns, trees)
}

/// Figure 5 of [ZBMJLDC17](crate::references): by the error as a share of the radius, how many edges a circle
/// has, at most 16, and the curve above which these steps stay.
#[must_use]
pub fn edge_curves() -> [Vec<[f64; 2]>; 2] {
    const PARTS: u16 = 1000;
    const MOST: u32 = 16;
    let table = EdgeTable::up_to(MOST);
    let shares = || (10..=PARTS).map(|part| 0.6 * f64::from(part) / f64::from(PARTS));
    #[expect(clippy::cast_possible_truncation, reason = "a share, rounded once")]
    let steps = shares().map(|share| {
        let edges = table.edges(1.0, share as f32).count;
        [share, f64::from(edges)]
    });
    let curve = shares().map(|share| [share, fractional_edges(share).min(f64::from(MOST))]);
    [steps.collect(), curve.collect()]
}
