//! Every scheme of level of detail on one tree that walks away, each as coarse as nobody sees: what it
//! sends, holds and takes.
//!
//! ```text
//! distance 0, 1, …: the tree takes half as many pixels each time
//!   leaves or wood ─full detail─▶ pictures ─┬─▶ judged: the coarsest level within the tolerance
//!   scheme ─────────levels──────▶ pictures ─┘        │
//!                                                    └─▶ change sent, frames drawn: ledgers
//! ```
//!
//! So schemes are held against each other at the same visible error, which is the only fair way to ask
//! what one costs more than another. A scheme whose finest level is not within the tolerance shows that one.
//! Leaves and wood are looked at one without the other: a tree has a scheme for each.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::stand_ins::sphere_of;
use super::studio::{Studio, StudioOptions};
use super::sweep::Variant;
use super::views::{SPHERE_SHARE, Shot, look_along};
use super::world::World;
use crate::gpu::{Device, GpuError, Ledger};
use crate::math::{Mat4, Sphere, Vec3, index_u32, index_usize};
use crate::models::{
    CardLevel, Crown, Environment, Kind, Model, Shared, State, Trunk, TrunkKind, TrunkLevel,
    TrunkModel,
};
use crate::raster::Counters;
use crate::scene::Simplifier;

/// What is compared, and how closely.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareOptions {
    /// The schemes of foliage.
    pub leaves: Vec<Variant>,
    /// The schemes of wood.
    pub wood: Vec<TrunkKind>,
    /// How they are looked at.
    pub looks: WalkAway,
}

/// How a tree that walks away is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct WalkAway {
    /// The pictures' side at the first distance, in pixels, at least 8.
    pub side: u32,
    /// How many distances, each twice the one before: as long as pictures have 8 pixels a side.
    pub distances: u32,
    /// The greatest difference that goes unseen, in the judge's measure.
    pub tolerance: f64,
    /// Link, card and the makings of models.
    pub session: SessionOptions,
}

/// The pictures of a distance: from three sides, from slightly above.
pub const COMPARE_VIEWS: u32 = 3;

/// How finely the axis of detail is looked through.
const STEPS: u32 = 64;

/// A scheme of one part of a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scheme {
    /// Of its foliage.
    Leaves(Variant),
    /// Of its wood.
    Wood(TrunkKind),
}

impl Scheme {
    /// The label of the variant or kind.
    #[must_use]
    pub fn label(self) -> String {
        match self {
            Self::Leaves(variant) => variant.label(),
            Self::Wood(kind) => kind.label(),
        }
    }

    /// Whether it has anything but full detail.
    #[must_use]
    pub fn has_levels(self) -> bool {
        match self {
            Self::Leaves(variant) => variant.has_levels(),
            Self::Wood(kind) => kind.has_levels(),
        }
    }

    /// Whether it shows something else in place of leaves.
    #[must_use]
    pub fn stands_in(self) -> bool {
        matches!(self, Self::Leaves(variant) if !variant.kind.shows_leaves())
    }
}

/// What is found of a scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeFound {
    /// The scheme.
    pub scheme: Scheme,
    /// The upload of the model and one instance.
    pub initial: Ledger,
    /// What they hold on the device, in bytes.
    pub resident_bytes: u64,
    /// Distance by distance, the nearest first.
    pub steps: Vec<SchemeStep>,
}

/// A scheme that cannot show the tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// The scheme.
    pub scheme: Scheme,
    /// What the device has against it.
    pub reason: String,
}

/// A scheme at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeStep {
    /// The pictures' side in pixels, of which the sphere around the leaves, or around the wood, takes 90 %.
    pub side: u32,
    /// How far along its own levels it is: 0 the finest, 1 the coarsest.
    pub level: f64,
    /// Leaves that show, none where cards stand for them; of wood its triangles and lines.
    pub shown: u64,
    /// The judge's measure: the mean over the pictures.
    pub error: f64,
    /// What going over to it from the distance before sent.
    pub change: Ledger,
    /// What drawing its [`COMPARE_VIEWS`] frames took, all together.
    pub frames: Ledger,
    /// The first of its pictures.
    pub shot: Shot,
}

/// How a picture is judged: a measure of the difference between those at full detail and others.
pub type Judge<'j, E> = dyn FnMut(&[Shot], &[Shot]) -> Result<f64, E> + 'j;

/// Walks every scheme away, one after another, leaves before wood. Everything is of the world's first plant; of
/// a part that it does not have nothing is found. Answers which schemes cannot show it.
///
/// # Errors
///
/// What the device refuses, unless it is that it cannot do what a scheme wants, and what `judge` and `take`
/// answer.
pub fn compare<E: From<RunError>>(
    world: &World,
    options: &CompareOptions,
    progress: &dyn Progress,
    judge: &mut Judge<'_, E>,
    mut take: impl FnMut(SchemeFound) -> Result<(), E>,
) -> Result<Vec<LeftOut>, E> {
    let crown = world.crowns.first();
    let crown = crown.filter(|crown| crown.plant().foliage().leaf_count() > 0);
    let trunk = world.trunks.first().and_then(Option::as_ref);
    let leaf_schemes = crown.map_or(0, |_| options.leaves.len());
    let wood_schemes = trunk.map_or(0, |_| options.wood.len());
    progress.begin("schemes", (leaf_schemes + wood_schemes) as u64);
    let mut left_out = Vec::new();
    if let Some(crown) = crown {
        let mut walk = LeafWalk::new(world, crown, &options.looks)?;
        for &variant in &options.leaves {
            match walk.scheme(variant, judge)? {
                Ok(found) => take(found)?,
                Err(reason) => left_out.push(LeftOut {
                    scheme: Scheme::Leaves(variant),
                    reason,
                }),
            }
            progress.step();
        }
    }
    if let Some(trunk) = trunk {
        let mut walk = WoodWalk::new(trunk, &options.looks)?;
        for &kind in &options.wood {
            if !kind.has_errors() || trunk.plant().skeleton().is_some() {
                take(walk.scheme(kind, judge)?)?;
            }
            progress.step();
        }
    }
    Ok(left_out)
}

/// The coarsest of some uniform levels of a crown that is within the tolerance, picture side by picture side,
/// the largest first: the side, and which of them. `collapses` ascends from 0.
///
/// # Errors
///
/// What the device refuses, and what `judge` answers.
pub(super) fn coarsest_unseen<E: From<RunError>>(
    crown: &Arc<Crown>,
    collapses: &[u32],
    options: &WalkAway,
    judge: &mut Judge<'_, E>,
) -> Result<Vec<(u32, u32)>, E> {
    let model = leaf_model(crown, options);
    let subject = Subject::leaves(model.as_ref());
    let walk = Walk::new(&subject, sphere_of(crown), options)?;
    let last = index_u32(collapses.len().saturating_sub(1));
    let state = |step: u32| State::Uniform {
        collapses: collapses.get(step as usize).copied().unwrap_or(0),
    };
    let chosen = walk.choose(&subject, last, &state, judge)?;
    let steps = chosen.iter().map(|chosen| chosen.step);
    Ok(walk.sides.iter().copied().zip(steps).collect())
}

/// The schemes of foliage.
struct LeafWalk<'o> {
    world: &'o World,
    crown: &'o Arc<Crown>,
    pruned: Option<Arc<Crown>>,
    walk: Walk<'o>,
    /// Once a way of simplifying, however many modes have it.
    known: BTreeMap<bool, Vec<Chosen<State>>>,
}

impl<'o> LeafWalk<'o> {
    fn new(
        world: &'o World,
        crown: &'o Arc<Crown>,
        options: &'o WalkAway,
    ) -> Result<Self, RunError> {
        let model = leaf_model(crown, options);
        let subject = Subject::leaves(model.as_ref());
        Ok(Self {
            world,
            crown,
            pruned: None,
            walk: Walk::new(&subject, sphere_of(crown), options)?,
            known: BTreeMap::new(),
        })
    }

    /// A scheme, or why the device cannot do it.
    fn scheme<E: From<RunError>>(
        &mut self,
        variant: Variant,
        judge: &mut Judge<'_, E>,
    ) -> Result<Result<SchemeFound, String>, E> {
        let world = self.world;
        let pruned = || Arc::clone(&world.simplified_by(Simplifier::Pruning).crowns[0]);
        let crown = match variant.pruned {
            false => Arc::clone(self.crown),
            true => Arc::clone(self.pruned.get_or_insert_with(pruned)),
        };
        let options = self.walk.options;
        let model = variant
            .kind
            .model(&crown, variant.session(&options.session).model);
        let subject = Subject::leaves(model.as_ref());
        match self.walk.studio(&subject, 0, Counters::Visible) {
            Err(RunError::Gpu(error @ GpuError::Unsupported { .. })) => {
                return Ok(Err(error.to_string()));
            }
            tried => tried?,
        };
        let levels = if !variant.kind.shows_leaves() {
            let levels = options.session.model.cards.levels.as_slice().len();
            let last = match variant.kind.has_levels() {
                true => index_u32(levels) - 1,
                false => 0,
            };
            let state = |step: u32| State::Cards(CardLevel(step * CardLevel::STEPS));
            self.walk.choose(&subject, last, &state, judge)?
        } else if variant.kind.has_levels() {
            let known = match self.known.entry(variant.pruned) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(room) => {
                    let all = u64::from(crown.sequence().collapse_count());
                    let state = |step: u32| State::Uniform {
                        collapses: index_u32(index_usize(all * u64::from(step) / u64::from(STEPS))),
                    };
                    // All that show leaves look alike.
                    let model = leaf_model(&crown, options);
                    let subject = Subject::leaves(model.as_ref());
                    room.insert(self.walk.choose(&subject, STEPS, &state, judge)?)
                }
            };
            known.clone()
        } else {
            self.walk.full_detail(&State::FINEST)
        };
        let shown = |state: &State| crown.shown_leaves(state);
        let scheme = Scheme::Leaves(variant);
        Ok(Ok(self.walk.measure(scheme, &subject, levels, &shown)?))
    }
}

/// The schemes of wood.
struct WoodWalk<'o> {
    trunk: &'o Arc<Trunk>,
    walk: Walk<'o>,
    /// Meshes look alike wherever they lie; branches do not.
    known: BTreeMap<TrunkKind, Vec<Chosen<TrunkLevel>>>,
}

impl<'o> WoodWalk<'o> {
    fn new(trunk: &'o Arc<Trunk>, options: &'o WalkAway) -> Result<Self, RunError> {
        let model = TrunkKind::FULL.model(trunk, options.session.model);
        let subject = Subject::wood(model.as_ref());
        let sphere = Sphere::of(&trunk.mesh().positions);
        Ok(Self {
            trunk,
            walk: Walk::new(&subject, sphere, options)?,
            known: BTreeMap::new(),
        })
    }

    fn scheme<E: From<RunError>>(
        &mut self,
        kind: TrunkKind,
        judge: &mut Judge<'_, E>,
    ) -> Result<SchemeFound, E> {
        let trunk = self.trunk;
        let model = kind.model(trunk, self.walk.options.session.model);
        let subject = Subject::wood(model.as_ref());
        let levels = if kind.has_levels() {
            let alike = match kind.has_errors() {
                true => kind,
                false => TrunkKind {
                    mode: kind.name.modes()[0],
                    ..kind
                },
            };
            match self.known.entry(alike) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(room) => {
                    let state = |step: u32| kind.level(trunk, step, STEPS);
                    room.insert(self.walk.choose(&subject, STEPS, &state, judge)?)
                }
            }
            .clone()
        } else {
            self.walk.full_detail(&TrunkLevel::FINEST)
        };
        let shown = |level: &TrunkLevel| {
            let step = kind.shown_step(trunk, *level);
            let lines = step.map_or(0, |step| trunk.branch_counts(step).lines);
            u64::from(kind.triangle_count(trunk, *level)) + lines
        };
        let scheme = Scheme::Wood(kind);
        Ok(self.walk.measure(scheme, &subject, levels, &shown)?)
    }
}

/// The model by which leaves are looked at: all that show leaves look alike.
fn leaf_model(crown: &Arc<Crown>, options: &WalkAway) -> Box<dyn Model> {
    let usual = Variant::usual(Kind::LodfStamps).session(&options.session);
    Kind::LodfStamps.model(crown, usual.model)
}

/// What a model sends.
type Upload<'m, S> = dyn Fn(&mut Device, &Environment) -> Result<Box<dyn Shared<S>>, GpuError> + 'm;

/// A model of leaves or of wood.
struct Subject<'m, S> {
    finest: S,
    upload: Box<Upload<'m, S>>,
}

impl<'m> Subject<'m, State> {
    fn leaves(model: &'m dyn Model) -> Self {
        Self {
            finest: State::FINEST,
            upload: Box::new(|device, environment| model.upload(device, environment)),
        }
    }
}

impl<'m> Subject<'m, TrunkLevel> {
    fn wood(model: &'m dyn TrunkModel) -> Self {
        Self {
            finest: TrunkLevel::FINEST,
            upload: Box::new(|device, environment| model.upload(device, environment)),
        }
    }
}

/// What a scheme shows at a distance.
#[derive(Debug, Clone)]
struct Chosen<S> {
    state: S,
    step: u32,
    level: f64,
    error: f64,
    shot: Shot,
}

/// The distances, and how the part of the tree looks from them.
struct Walk<'o> {
    options: &'o WalkAway,
    sphere: Sphere,
    sides: Vec<u32>,
    /// By distance.
    full: Vec<Vec<Shot>>,
}

impl<'o> Walk<'o> {
    /// Looks at a part at full detail.
    fn new<S>(
        full: &Subject<'_, S>,
        sphere: Sphere,
        options: &'o WalkAway,
    ) -> Result<Self, RunError> {
        let sides = (0..options.distances.clamp(1, 16)).map(|far| options.side.max(8) >> far);
        let mut walk = Self {
            options,
            // What has no size is looked at all the same.
            sphere: Sphere {
                radius: sphere.radius.max(1e-3),
                ..sphere
            },
            sides: sides.take_while(|&side| side >= 8).collect(),
            full: Vec::new(),
        };
        for far in 0..walk.sides.len() {
            let mut studio = walk.studio(full, far, Counters::Visible)?;
            let shots = walk.shots(&mut studio, far)?;
            walk.full.push(shots);
        }
        Ok(walk)
    }

    fn studio<S>(
        &self,
        subject: &Subject<'_, S>,
        far: usize,
        counters: Counters,
    ) -> Result<Studio<S>, RunError> {
        let options = StudioOptions {
            side: self.sides[far],
            link: self.options.session.link,
            card: self.options.session.card,
            counters,
        };
        let pixels_per_metre = 0.5 * SPHERE_SHARE * self.sides[0] as f32 / self.sphere.radius;
        Studio::of(&subject.finest, &options, pixels_per_metre, &subject.upload)
    }

    /// What is seen from the sides: `w` grows with the distance, as in perspective, for whoever asks how many
    /// pixels a metre spans.
    fn views(&self, far: usize) -> [Mat4; COMPARE_VIEWS as usize] {
        let w = (1_u32 << far) as f32;
        sides_of_the_tree().map(|direction| look_along(direction, self.sphere) * w)
    }

    fn shots<S>(&self, studio: &mut Studio<S>, far: usize) -> Result<Vec<Shot>, RunError> {
        let shot = |view| Ok(Shot::of(studio.draw(view)?.0));
        self.views(far).into_iter().map(shot).collect()
    }

    fn full_detail<S: Clone>(&self, finest: &S) -> Vec<Chosen<S>> {
        let all = self.full.iter().map(|shots| Chosen {
            state: finest.clone(),
            step: 0,
            level: 0.0,
            error: 0.0,
            shot: shots[0].clone(),
        });
        all.collect()
    }

    /// The coarsest of the states `0..=last` at each distance whose error is within the tolerance, if it
    /// grows from state to state; state 0 where none is.
    fn choose<S, E: From<RunError>>(
        &self,
        subject: &Subject<'_, S>,
        last: u32,
        state: &dyn Fn(u32) -> S,
        judge: &mut Judge<'_, E>,
    ) -> Result<Vec<Chosen<S>>, E> {
        let mut all = Vec::new();
        // What is unseen from near is unseen from afar.
        let mut least = 0;
        for (far, full) in self.full.iter().enumerate() {
            let mut studio = self.studio(subject, far, Counters::Visible)?;
            let mut look = |step: u32| -> Result<Chosen<S>, E> {
                let state = state(step);
                studio.show(&state)?;
                let mut shots = self.shots(&mut studio, far)?;
                Ok(Chosen {
                    state,
                    step,
                    level: f64::from(step) / f64::from(last.max(1)),
                    error: judge(full, &shots)?,
                    shot: shots.swap_remove(0),
                })
            };
            let mut best = look(least)?;
            let (mut low, mut high) = (least, last);
            if best.error > self.options.tolerance && least > 0 {
                (low, high) = (0, least - 1);
                best = look(0)?;
            }
            while low < high {
                let middle = (low + high).div_ceil(2);
                let found = look(middle)?;
                if found.error <= self.options.tolerance {
                    (low, best) = (middle, found);
                } else {
                    high = middle - 1;
                }
            }
            least = low;
            all.push(best);
        }
        Ok(all)
    }

    /// Goes through the states, and counts.
    fn measure<S>(
        &self,
        scheme: Scheme,
        subject: &Subject<'_, S>,
        levels: Vec<Chosen<S>>,
        shown: &dyn Fn(&S) -> u64,
    ) -> Result<SchemeFound, RunError> {
        let mut studio = self.studio(subject, 0, Counters::Exact)?;
        let mut found = SchemeFound {
            scheme,
            initial: studio.initial.clone(),
            resident_bytes: studio.resident_bytes,
            steps: Vec::new(),
        };
        for (far, chosen) in levels.into_iter().enumerate() {
            studio.resize(self.sides[far])?;
            let change = studio.change_to(&chosen.state)?;
            let mut frames = Ledger::default();
            for view in self.views(far) {
                frames.add(&studio.draw(view)?.1);
            }
            found.steps.push(SchemeStep {
                side: self.sides[far],
                level: chosen.level,
                shown: shown(&chosen.state),
                error: chosen.error,
                change,
                frames,
                shot: chosen.shot,
            });
        }
        Ok(found)
    }
}

/// A third of the way round from each other, 20 degrees above the horizon.
fn sides_of_the_tree() -> [Vec3; COMPARE_VIEWS as usize] {
    // sin and cos of 20°, √3/2.
    let (rise, run, half_root) = (0.342_020_15, 0.939_692_6, 0.866_025_4);
    [(1.0, 0.0), (-0.5, half_root), (-0.5, -half_root)]
        .map(|(x, z): (f32, f32)| Vec3::new(run * x, rise, run * z).normalize())
}
