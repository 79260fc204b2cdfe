//! Every scheme of level of detail on one tree that walks away, each as coarse as nobody sees: what it
//! sends, holds and takes.
//!
//! ```text
//! distance 0, 1, …: the tree takes half as many pixels each time
//!   leaves ─full detail─▶ pictures ─┬─▶ judged: the coarsest level within the tolerance
//!   scheme ─levels──────▶ pictures ─┘        │
//!                                            └─▶ change sent, frames drawn: ledgers
//! ```
//!
//! So schemes are held against each other at the same visible error, which is the only fair way to ask
//! what one costs more than another. A scheme whose finest level is not within the tolerance shows that one.
//! All of it is of the foliage alone.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::stand_ins::sphere_of;
use super::studio::{Studio, StudioOptions};
use super::sweep::Variant;
use super::views::{Shot, look_along};
use super::world::World;
use crate::gpu::Ledger;
use crate::math::{Sphere, Vec3, index_u32, index_usize};
use crate::models::{CardLevel, Crown, Kind, Model, ModelOptions, State};
use crate::raster::Counters;
use crate::scene::Simplifier;

/// What is compared, and how closely.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareOptions {
    /// The schemes.
    pub variants: Vec<Variant>,
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

/// What is found of a scheme.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeFound {
    /// The scheme.
    pub variant: Variant,
    /// The upload of the model and one instance.
    pub initial: Ledger,
    /// What they hold on the device, in bytes.
    pub resident_bytes: u64,
    /// Distance by distance, the nearest first.
    pub steps: Vec<SchemeStep>,
}

/// A scheme at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct SchemeStep {
    /// The pictures' side in pixels, of which the sphere around the leaves takes 90 %.
    pub side: u32,
    /// How far along its own levels it is: 0 the finest, 1 the coarsest.
    pub level: f64,
    /// Leaves that show; none where cards stand for them.
    pub leaves: u64,
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

/// Walks every scheme away, one after another, full detail first. Everything is of the world's first plant;
/// without one, nothing is found.
///
/// # Errors
///
/// What the device refuses, and what `judge` and `take` answer.
pub fn compare<E: From<RunError>>(
    world: &World,
    options: &CompareOptions,
    progress: &dyn Progress,
    judge: &mut Judge<'_, E>,
    mut take: impl FnMut(SchemeFound) -> Result<(), E>,
) -> Result<(), E> {
    let Some(crown) = world.crowns.first() else {
        return Ok(());
    };
    progress.begin("schemes", options.variants.len() as u64 + 1);
    let mut walk = Walk::new(crown, options);
    walk.look_at_full_detail()?;
    progress.step();
    // Once a way of simplifying, however many modes have it.
    let mut chosen: BTreeMap<bool, Vec<Chosen>> = BTreeMap::new();
    let mut pruned: Option<Arc<Crown>> = None;
    for &variant in &options.variants {
        let crown = match variant.pruned {
            false => Arc::clone(crown),
            true => Arc::clone(pruned.get_or_insert_with(|| {
                Arc::clone(&world.simplified_by(Simplifier::Pruning).crowns[0])
            })),
        };
        let model = variant
            .kind
            .model(&crown, variant.session(&options.session).model);
        let levels = if variant.kind.shows_leaves() {
            let known = match chosen.entry(variant.pruned) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(room) => room.insert(walk.choose_leaves(&crown, judge)?),
            };
            match variant.kind.has_levels() {
                true => known.clone(),
                false => walk.full_detail(),
            }
        } else {
            walk.choose_cards(model.as_ref(), variant.kind, judge)?
        };
        take(walk.measure(variant, model.as_ref(), levels)?)?;
        progress.step();
    }
    Ok(())
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
    options: &CompareOptions,
    judge: &mut Judge<'_, E>,
) -> Result<Vec<(u32, u32)>, E> {
    let mut walk = Walk::new(crown, options);
    walk.look_at_full_detail()?;
    let last = index_u32(collapses.len().saturating_sub(1));
    let state = |step: u32| State::Uniform {
        collapses: collapses.get(step as usize).copied().unwrap_or(0),
    };
    let chosen = walk.choose(walk.leaf_model(crown).as_ref(), last, &state, judge)?;
    let steps = chosen.iter().map(|chosen| chosen.step);
    Ok(walk.sides.iter().copied().zip(steps).collect())
}

/// What a scheme shows at a distance.
#[derive(Debug, Clone)]
struct Chosen {
    state: State,
    step: u32,
    level: f64,
    error: f64,
    shot: Shot,
}

/// The distances, and how the tree looks from them.
struct Walk<'o> {
    crown: &'o Arc<Crown>,
    options: &'o CompareOptions,
    sphere: Sphere,
    sides: Vec<u32>,
    /// By distance.
    full: Vec<Vec<Shot>>,
}

impl<'o> Walk<'o> {
    fn new(crown: &'o Arc<Crown>, options: &'o CompareOptions) -> Self {
        let found = sphere_of(crown);
        let sides = (0..options.distances.clamp(1, 16)).map(|far| options.side.max(8) >> far);
        Self {
            crown,
            options,
            // What has no size is looked at all the same.
            sphere: Sphere {
                radius: found.radius.max(1e-3),
                ..found
            },
            sides: sides.take_while(|&side| side >= 8).collect(),
            full: Vec::new(),
        }
    }

    fn studio(&self, model: &dyn Model, side: u32, counters: Counters) -> Result<Studio, RunError> {
        let options = StudioOptions {
            side,
            link: self.options.session.link,
            card: self.options.session.card,
            counters,
        };
        Studio::new(model, &State::FINEST, &options)
    }

    fn shots(&self, studio: &mut Studio) -> Result<Vec<Shot>, RunError> {
        let shot = |direction| Ok(Shot::of(studio.draw(look_along(direction, self.sphere))?.0));
        sides_of_the_tree().into_iter().map(shot).collect()
    }

    fn look_at_full_detail(&mut self) -> Result<(), RunError> {
        let model = self.leaf_model(self.crown);
        for &side in &self.sides {
            let mut studio = self.studio(model.as_ref(), side, Counters::Visible)?;
            let shots = self.shots(&mut studio)?;
            self.full.push(shots);
        }
        Ok(())
    }

    /// The model by which leaves are looked at: all that show leaves look alike.
    fn leaf_model(&self, crown: &Arc<Crown>) -> Box<dyn Model> {
        let usual = Variant::usual(Kind::LodfStamps).session(&self.options.session);
        Kind::LodfStamps.model(crown, ModelOptions { ..usual.model })
    }

    fn full_detail(&self) -> Vec<Chosen> {
        let all = self.full.iter().map(|shots| Chosen {
            state: State::FINEST,
            step: 0,
            level: 0.0,
            error: 0.0,
            shot: shots[0].clone(),
        });
        all.collect()
    }

    fn choose_leaves<E: From<RunError>>(
        &self,
        crown: &Arc<Crown>,
        judge: &mut Judge<'_, E>,
    ) -> Result<Vec<Chosen>, E> {
        let all = u64::from(crown.sequence().collapse_count());
        let state = |step: u32| State::Uniform {
            collapses: index_u32(index_usize(all * u64::from(step) / u64::from(STEPS))),
        };
        self.choose(self.leaf_model(crown).as_ref(), STEPS, &state, judge)
    }

    fn choose_cards<E: From<RunError>>(
        &self,
        model: &dyn Model,
        kind: Kind,
        judge: &mut Judge<'_, E>,
    ) -> Result<Vec<Chosen>, E> {
        let levels = self.options.session.model.cards.levels.as_slice().len();
        let last = match kind.has_levels() {
            true => index_u32(levels) - 1,
            false => 0,
        };
        let state = |step: u32| State::Cards(CardLevel(step * CardLevel::STEPS));
        self.choose(model, last, &state, judge)
    }

    /// The coarsest of the states `0..=last` at each distance whose error is within the tolerance, if it
    /// grows from state to state; state 0 where none is.
    fn choose<E: From<RunError>>(
        &self,
        model: &dyn Model,
        last: u32,
        state: &dyn Fn(u32) -> State,
        judge: &mut Judge<'_, E>,
    ) -> Result<Vec<Chosen>, E> {
        let mut all = Vec::new();
        // What is unseen from near is unseen from afar.
        let mut least = 0;
        for (&side, full) in self.sides.iter().zip(&self.full) {
            let mut studio = self.studio(model, side, Counters::Visible)?;
            let mut look = |step: u32| -> Result<Chosen, E> {
                let state = state(step);
                studio.show(&state)?;
                let mut shots = self.shots(&mut studio)?;
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
    fn measure(
        &self,
        variant: Variant,
        model: &dyn Model,
        levels: Vec<Chosen>,
    ) -> Result<SchemeFound, RunError> {
        let mut studio = self.studio(model, self.sides[0], Counters::Exact)?;
        let mut found = SchemeFound {
            variant,
            initial: studio.initial.clone(),
            resident_bytes: studio.resident_bytes,
            steps: Vec::new(),
        };
        for (&side, chosen) in self.sides.iter().zip(levels) {
            studio.resize(side)?;
            let change = studio.change_to(&chosen.state)?;
            let mut frames = Ledger::default();
            for direction in sides_of_the_tree() {
                frames.add(&studio.draw(look_along(direction, self.sphere))?.1);
            }
            found.steps.push(SchemeStep {
                side,
                level: chosen.level,
                leaves: model.crown().shown_leaves(&chosen.state),
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
