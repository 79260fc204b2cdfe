//! One part of a tree from farther and farther away, at full detail and by any scheme.

use super::{COMPARE_VIEWS, Judge, Outcome, Scheme, SchemeFound, SchemeStep, Verdict, WalkAway};
use crate::gpu::{Device, GpuError, Ledger};
use crate::math::{Mat4, Sphere, Vec3};
use crate::models::{Environment, Model, Shared, State, TrunkLevel, TrunkModel};
use crate::raster::Counters;
use crate::run::RunError;
use crate::run::studio::{Studio, StudioOptions};
use crate::run::views::{SPHERE_SHARE, Shot, look_along};

/// What a model sends.
type Upload<S> =
    dyn Fn(&mut Device, &Environment) -> Result<Box<dyn Shared<S>>, GpuError> + Send + Sync;

/// A model of leaves or of wood.
pub(super) struct Subject<S> {
    /// Full detail.
    pub(super) finest: S,
    upload: Box<Upload<S>>,
}

impl Subject<State> {
    pub(super) fn leaves(model: Box<dyn Model>) -> Self {
        Self {
            finest: State::FINEST,
            upload: Box::new(move |device, environment| model.upload(device, environment)),
        }
    }
}

impl Subject<TrunkLevel> {
    pub(super) fn wood(model: Box<dyn TrunkModel>) -> Self {
        Self {
            finest: TrunkLevel::FINEST,
            upload: Box::new(move |device, environment| model.upload(device, environment)),
        }
    }
}

/// What a scheme shows at a distance.
#[derive(Debug, Clone)]
pub(super) struct Chosen<S> {
    state: S,
    pub(super) step: u32,
    level: f64,
    error: f64,
    shot: Shot,
}

/// What is seen at a distance at full detail.
struct FullDetail<E> {
    side: u32,
    shot: Shot,
    verdict: Box<Verdict<E>>,
}

/// The distances, and how the part of the tree looks from them.
pub(super) struct Walk<'o, E> {
    pub(super) options: &'o WalkAway,
    sphere: Sphere,
    /// By distance.
    full: Vec<FullDetail<E>>,
}

impl<'o, E: From<RunError>> Walk<'o, E> {
    /// Looks at a part at full detail.
    pub(super) fn new<S>(
        full: &Subject<S>,
        sphere: Sphere,
        options: &'o WalkAway,
        judge: &Judge<'_, E>,
    ) -> Result<Self, E> {
        let mut walk = Self {
            options,
            // What has no size is looked at all the same.
            sphere: Sphere {
                radius: sphere.radius.max(1e-3),
                ..sphere
            },
            full: Vec::new(),
        };
        let mut studio = walk.studio(full)?;
        let sides = (0..options.distances.clamp(1, 16)).map(|far| options.side.max(8) >> far);
        for (far, side) in sides.take_while(|&side| side >= 8).enumerate() {
            studio.resize(side)?;
            let mut shots = walk.shots(&mut studio, far)?;
            walk.full.push(FullDetail {
                side,
                verdict: judge(&shots)?,
                shot: shots.swap_remove(0),
            });
        }
        Ok(walk)
    }

    /// The pictures' sides in pixels, by distance.
    pub(super) fn sides(&self) -> impl Iterator<Item = u32> {
        self.full.iter().map(|full| full.side)
    }

    /// Where a model is looked at: pictures of no certain size yet.
    pub(super) fn studio<S>(&self, subject: &Subject<S>) -> Result<Studio<S>, RunError> {
        self.counting(subject, Counters::Visible)
    }

    /// As [`studio`](Self::studio), or why the device cannot do what the model wants.
    pub(super) fn studio_if_able<S>(
        &self,
        subject: &Subject<S>,
    ) -> Result<Outcome<Studio<S>>, RunError> {
        if_able(self.studio(subject))
    }

    fn counting<S>(&self, subject: &Subject<S>, counters: Counters) -> Result<Studio<S>, RunError> {
        let side = self.options.side.max(8);
        let options = StudioOptions {
            side,
            link: self.options.session.link,
            card: self.options.session.card,
            counters,
        };
        let pixels_per_metre = 0.5 * SPHERE_SHARE * side as f32 / self.sphere.radius;
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

    /// Full detail at every distance, in a scheme's own words for it.
    pub(super) fn full_detail<S: Clone>(&self, finest: &S) -> Vec<Chosen<S>> {
        let all = self.full.iter().map(|full| Chosen {
            state: finest.clone(),
            step: 0,
            level: 0.0,
            error: 0.0,
            shot: full.shot.clone(),
        });
        all.collect()
    }

    /// The coarsest of the states `0..=last` at each distance whose error is within the tolerance, if it
    /// grows from state to state; state 0 where none is.
    pub(super) fn choose<S>(
        &self,
        mut studio: Studio<S>,
        last: u32,
        state: &dyn Fn(u32) -> S,
    ) -> Result<Vec<Chosen<S>>, E> {
        let mut all = Vec::new();
        // What is unseen from near is unseen from afar.
        let mut least = 0;
        for (far, full) in self.full.iter().enumerate() {
            studio.resize(full.side)?;
            let mut look = |step: u32| -> Result<Chosen<S>, E> {
                let state = state(step);
                studio.show(&state)?;
                let mut shots = self.shots(&mut studio, far)?;
                Ok(Chosen {
                    state,
                    step,
                    level: f64::from(step) / f64::from(last.max(1)),
                    error: (full.verdict)(&shots)?,
                    shot: shots.swap_remove(0),
                })
            };
            let mut coarsest = |least: u32, last: u32| -> Result<(u32, Chosen<S>), E> {
                let (mut low, mut high, mut best) = (least, last, None);
                while low < high {
                    let middle = (low + high).div_ceil(2);
                    let found = look(middle)?;
                    if found.error <= self.options.tolerance {
                        (low, best) = (middle, Some(found));
                    } else {
                        high = middle - 1;
                    }
                }
                match best {
                    Some(best) => Ok((low, best)),
                    None => Ok((low, look(low)?)),
                }
            };
            let (mut low, mut best) = coarsest(least, last)?;
            if best.error > self.options.tolerance && least > 0 {
                (low, best) = coarsest(0, least - 1)?;
            }
            least = low;
            all.push(best);
        }
        Ok(all)
    }

    /// Goes through the states, and counts.
    pub(super) fn measure<S>(
        &self,
        scheme: Scheme,
        subject: &Subject<S>,
        levels: Vec<Chosen<S>>,
        shown: &dyn Fn(&S) -> u64,
    ) -> Result<Outcome<SchemeFound>, RunError> {
        let mut studio = match if_able(self.counting(subject, Counters::Exact))? {
            Ok(studio) => studio,
            Err(reason) => return Ok(Err(reason)),
        };
        let mut found = SchemeFound {
            scheme,
            initial: studio.initial.clone(),
            resident_bytes: studio.resident_bytes,
            steps: Vec::new(),
        };
        for ((far, chosen), side) in levels.into_iter().enumerate().zip(self.sides()) {
            studio.resize(side)?;
            let change = studio.change_to(&chosen.state)?;
            let mut frames = Ledger::default();
            for view in self.views(far) {
                frames.add(&studio.draw(view)?.1);
            }
            found.steps.push(SchemeStep {
                side,
                level: chosen.level,
                shown: shown(&chosen.state),
                error: chosen.error,
                change,
                frames,
                shot: chosen.shot,
            });
        }
        Ok(Ok(found))
    }
}

/// What was tried, or why the device cannot do it.
fn if_able<T>(tried: Result<T, RunError>) -> Result<Outcome<T>, RunError> {
    match tried {
        Err(RunError::Gpu(error @ GpuError::Unsupported { .. })) => Ok(Err(error.to_string())),
        tried => tried.map(Ok),
    }
}

/// A third of the way round from each other, 20 degrees above the horizon.
fn sides_of_the_tree() -> [Vec3; COMPARE_VIEWS as usize] {
    // sin and cos of 20°, √3/2.
    let (rise, run, half_root) = (0.342_020_15, 0.939_692_6, 0.866_025_4);
    [(1.0, 0.0), (-0.5, half_root), (-0.5, -half_root)]
        .map(|(x, z): (f32, f32)| Vec3::new(run * x, rise, run * z).normalize())
}
