//! A painted plant measured: figures and Table 1 of [CQHCVL06](crate::references), what levels cost, and
//! how still the paint lies.
//!
//! ```text
//!  scene ─levels─▶ PaintLevel, …    one a row: from how far, how many strokes
//!        ─figures─▶ Figure, …       branches alone, leaves alone, all; near, and from that far
//!        ─costs─▶ PaintCost, …      what a frame takes at one size, and a change of level, by mode
//!        ─shimmer─▶ Shimmer, …      what a small step of the camera changes, beside other ways to draw
//! ```
//!
//! **Invariant.** All pictures of a figure are of one camera but for its distance.

mod shimmer;

pub use shimmer::{Shimmer, ShimmerSubject, shimmer};

use std::sync::Arc;

use super::{Progress, RunError, Session, SessionOptions, StandingTree, World, crown};
use crate::gpu::Ledger;
use crate::math::{Vec3, index_u32};
use crate::models::{Kind, Painting, Placement, Sight, State, StrokeCut, TreeChange, TreeState};
use crate::plant::{Foliage, NO_BRANCH, Plant};
use crate::raster::Image;
use crate::scene::{Camera, CameraKey, ModelName, PaintMark, Scene};
use crate::simplify::strokes::{BranchStrokeOptions, BranchStrokes, BranchView};

/// A level of a painting: a row of its leaves, and the branches that are seen from a distance.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintLevel {
    /// From how far, in metres.
    pub distance: f32,
    /// Which strokes show.
    pub cut: StrokeCut,
    /// How many strokes of leaves, and of branches.
    pub strokes: [u32; 2],
    /// How many leaf strokes the model shows from that far.
    pub wanted_leaves: u32,
    /// How many strokes of branches the same distance shows where each branch is judged as it is seen from
    /// the front, foreshortened and as far as it is.
    pub seen_branches: u32,
}

/// Which strokes a picture is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PaintPart {
    /// Those of branches.
    Branches,
    /// Those of leaves; what stands for more than one leaf is red.
    Leaves,
    /// All.
    Whole,
}

impl PaintPart {
    /// All parts, in the order of the paper's figures 3, 4 and 5.
    pub const ALL: [Self; 3] = [Self::Branches, Self::Leaves, Self::Whole];
}

/// A picture of a level.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintPicture {
    /// Of what.
    pub part: PaintPart,
    /// Which level.
    pub level: usize,
    /// From near, and from as far as the level is meant for.
    pub images: [Image; 2],
    /// What the frames took, one each.
    pub frames: [Ledger; 2],
}

/// What a level takes in a mode.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintCost {
    /// The mode.
    pub kind: Kind,
    /// Which level.
    pub level: usize,
    /// Going there from the level before; from nothing to the first one.
    pub change: Ledger,
    /// A frame of it.
    pub frame: Ledger,
}

/// What it takes to keep all levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PaintStorage {
    /// Of leaves: bytes of the implicit levels, and of a copy of each.
    pub leaves: [u64; 2],
    /// The same of branches.
    pub branches: [u64; 2],
}

/// A plant to be measured, and how it is painted.
#[derive(Debug, Clone)]
pub struct PaintStudy {
    scene: Scene,
    options: SessionOptions,
    plant: Arc<Plant>,
    painting: Arc<Painting>,
}

impl PaintStudy {
    /// The first plant of a scene, alone at the origin, painted as the scene says; `None` without one.
    #[must_use]
    pub fn of(scene: &Scene, world: &World, options: &SessionOptions) -> Option<Self> {
        let plant = world.plants.first()?;
        let mut scene = scene.clone();
        scene.frames = 1;
        scene.model.name = ModelName::Strokes;
        scene.model.level = None;
        scene.model.budget_bytes = None;
        scene.terrain = None;
        scene.shadow = None;
        let options = SessionOptions {
            kind: Kind::StrokeRanges,
            ..*options
        };
        Some(Self {
            painting: Arc::new(Painting::of(plant, &options.model.painting)),
            plant: Arc::clone(plant),
            scene,
            options,
        })
    }

    /// What is painted.
    #[must_use]
    pub fn painting(&self) -> &Arc<Painting> {
        &self.painting
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The camera's distance from the plant's middle at the scene's first frame, in metres.
    #[must_use]
    pub fn near(&self) -> f32 {
        let view = self.scene.camera.at(0, self.options.size);
        view.eye.distance(self.painting.center())
    }

    /// The scene with the camera so far from the plant, in the scene's own direction, looking at its middle.
    fn seen_from(&self, distance: f32) -> Scene {
        let center = self.painting.center();
        let eye = self.scene.camera.at(0, self.options.size).eye;
        let toward = (eye - center).normalize_or(Vec3::Z);
        self.looking(center + distance * toward)
    }

    fn looking(&self, eye: Vec3) -> Scene {
        let camera = &self.scene.camera;
        let center = self.painting.center();
        let key = CameraKey {
            frame: 0,
            eye,
            target: center,
        };
        let far = camera.far().max(2.0 * eye.distance(center));
        let moved = Camera::new(camera.projection(), camera.near(), far, vec![key]);
        Scene {
            camera: moved.unwrap_or_else(|_| camera.clone()),
            ..self.scene.clone()
        }
    }

    /// The levels, one a row of leaf strokes: with the branches that are seen from where as many leaf strokes
    /// are wanted, or, where `branches` says how many of their strokes there are, from where these are
    /// nearest to that.
    #[must_use]
    pub fn levels(&self, branches: Option<&[u32]>) -> Vec<PaintLevel> {
        let totals = self.painting.levels().totals();
        let full = self.painting.options().full_distance;
        let all = f64::from(totals[0].max(1));
        let rows = totals.iter().enumerate().map(|(row, total)| {
            let wanted = branches.and_then(|branches| branches.get(row));
            #[expect(clippy::cast_possible_truncation, reason = "rounds")]
            let farther = (all / f64::from((*total).max(1))).sqrt() as f32;
            let distance = wanted.map_or(full * farther, |wanted| self.distance_for(*wanted));
            self.level(*total, distance)
        });
        rows.collect()
    }

    /// So many leaf strokes, and the branches that are seen from a distance.
    fn level(&self, leaves: u32, distance: f32) -> PaintLevel {
        let scene = self.seen_from(distance);
        let view = scene.camera.at(0, self.options.size);
        let from_there = self.cut_from(distance);
        let cut = StrokeCut {
            limits: from_there.limits,
            branches: from_there.branches,
            ..self.painting.cut(leaves, 1.0, 0.0)
        };
        let paint = self.painting.options();
        let seen_branches = self.plant.skeleton().map_or(0, |skeleton| {
            let seen = BranchView {
                eye: view.eye,
                target: self.painting.center(),
                pixels: view.pixels_per_metre_at_1m,
                full_distance: paint.full_distance,
                least_pixels: paint.least_pixels,
            };
            BranchStrokes::new(skeleton, self.branch_options()).count(skeleton, &seen)
        });
        PaintLevel {
            distance,
            strokes: self.painting.counts(&cut),
            wanted_leaves: self.painting.counts(&self.cut_from(distance))[0],
            cut,
            seen_branches,
        }
    }

    fn branch_options(&self) -> BranchStrokeOptions {
        let paint = self.painting.options();
        BranchStrokeOptions {
            least: paint.branch_least,
            step: paint.branch_step,
        }
    }

    /// What the model shows from a distance.
    fn cut_from(&self, distance: f32) -> StrokeCut {
        let view = self.seen_from(distance).camera.at(0, self.options.size);
        let sight = Sight::of(&view, &Placement::IDENTITY);
        let pixels = |distance: f32| sight.pixels_per_metre(distance);
        self.painting.at_distance(distance, pixels)
    }

    /// The distance at which the number of branch strokes is nearest to one that is wanted: that of all
    /// distances up to a hundred times the full one, which is halved in.
    fn distance_for(&self, wanted: u32) -> f32 {
        let full = self.painting.options().full_distance;
        let count = |distance: f32| self.painting.counts(&self.cut_from(distance))[1];
        let (mut low, mut high) = (0.01 * full, 100.0 * full);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if count(middle) >= wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        let [more, fewer] = [low, high].map(|distance| count(distance).abs_diff(wanted));
        if more <= fewer { low } else { high }
    }

    /// What it takes to keep all levels.
    #[must_use]
    pub fn storage(&self) -> PaintStorage {
        let levels = self.painting.levels();
        let branches = self.plant.skeleton().map_or([0; 2], |skeleton| {
            let strokes = BranchStrokes::new(skeleton, self.branch_options());
            [strokes.implicit_bytes(), strokes.copied_bytes()]
        });
        PaintStorage {
            leaves: [levels.implicit_bytes(), levels.copied_bytes()],
            branches,
        }
    }

    /// The pictures of all levels, part by part, handed over one after another.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn figures(
        &self,
        levels: &[PaintLevel],
        progress: &dyn Progress,
        mut take: impl FnMut(PaintPicture),
    ) -> Result<(), RunError> {
        progress.begin("figures", 3 * levels.len() as u64);
        for part in PaintPart::ALL {
            let world = world_of(&self.part(part));
            let mut options = self.options;
            if part == PaintPart::Leaves {
                options.model.painting.mark = PaintMark::Simplified;
            }
            for (number, level) in levels.iter().enumerate() {
                let draw = |distance: f32| -> Result<(Image, Ledger), RunError> {
                    let scene = self.seen_from(distance);
                    let states = [TreeState::from(State::Strokes(level.cut.clone()))];
                    let mut session = Session::standing(&scene, &world, &options, &states)?;
                    let frame = session.draw(0, TreeChange::default())?;
                    Ok((frame.image, frame.ledger))
                };
                let (near, near_frame) = draw(self.near())?;
                let (far, far_frame) = draw(level.distance)?;
                take(PaintPicture {
                    part,
                    level: number,
                    images: [near, far],
                    frames: [near_frame, far_frame],
                });
                progress.step();
            }
        }
        Ok(())
    }

    /// The plant with what a figure shows of it.
    fn part(&self, part: PaintPart) -> Arc<Plant> {
        let plant = &self.plant;
        let made = match part {
            PaintPart::Whole => return Arc::clone(plant),
            PaintPart::Branches => {
                let (skeleton, trunk) = (plant.skeleton().cloned(), plant.trunk().cloned());
                Plant::new(plant.name(), skeleton, trunk, Foliage::default())
            }
            PaintPart::Leaves => {
                let mut foliage = plant.foliage().clone();
                for group in &mut foliage.groups {
                    // What bore them is gone.
                    group.owners.fill(NO_BRANCH);
                }
                Plant::new(plant.name(), None, None, foliage)
            }
        };
        Arc::new(made.expect("parts of a plant are sound"))
    }

    /// What all levels take in both modes, from near.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn costs(&self, levels: &[PaintLevel]) -> Result<Vec<PaintCost>, RunError> {
        let scene = self.seen_from(self.near());
        let world = world_of(&self.plant);
        let mut costs = Vec::new();
        for kind in [Kind::StrokeRanges, Kind::StrokesHost] {
            let options = SessionOptions {
                kind,
                ..self.options
            };
            let state = |level: &PaintLevel| TreeState::from(State::Strokes(level.cut.clone()));
            let Some(first) = levels.first() else {
                continue;
            };
            let mut session = Session::standing(&scene, &world, &options, &[state(first)])?;
            let mut change = session.initial().clone();
            for (number, level) in levels.iter().enumerate() {
                if number > 0 {
                    session.commit_states(&[state(level)])?;
                    change = session.device_mut().take_ledger();
                }
                let frame = session.draw(0, TreeChange::default())?.ledger;
                costs.push(PaintCost {
                    kind,
                    level: number,
                    change: change.clone(),
                    frame,
                });
            }
        }
        Ok(costs)
    }
}

/// How often a distance is halved in: to a tenth of a millimetre of a kilometre.
const HALVINGS: usize = 24;

/// A plant alone at the origin.
fn world_of(plant: &Arc<Plant>) -> World {
    let stop = index_u32(plant.foliage().quad_count());
    let crown = crown((**plant).clone(), Some(stop));
    let tree = StandingTree {
        crown: 0,
        placement: Placement::IDENTITY,
    };
    World::of(vec![Arc::new(crown)], vec![tree])
}
