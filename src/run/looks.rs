//! How every level looks: the pictures by which a walk along the axis of detail is judged.
//!
//! The pictures of a level are the same for every model, so they are taken once a level. They come
//! one level after another, full detail first, so that nobody need hold more than two.

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::Session;
use super::shard::Shard;
use super::sweep::{Variant, prunings, states_at};
use super::views::{Shot, Views};
use super::world::World;
use crate::math::{index_u32, index_usize};
use crate::models::{Kind, LeafFormat, ModelOptions, level};
use crate::scene::{Scene, Simplifier};
use crate::simplify::measure_leaves;

/// Which levels to look at.
#[derive(Debug, Clone, PartialEq)]
pub struct LookOptions {
    /// The models whose levels are looked at: by them foliage is looked at as the scene simplifies it,
    /// pruned, or both.
    pub variants: Vec<Variant>,
    /// Into how many steps the walk divides the axis of detail.
    pub steps: u32,
    /// How many of these steps to look at beyond step 0, evenly chosen, with the last; at least 1.
    pub looks: u32,
    /// Which of the steps are looked at; full detail is, whoever draws it.
    pub shard: Shard,
    /// Device, size and samples of the scene's own picture.
    pub session: SessionOptions,
}

/// The steps to look at of a walk of so many, ascending: `floor(j · steps / looks)` for `j` in
/// `0..=looks`, each once.
pub fn looked_at(steps: u32, looks: u32) -> impl Iterator<Item = u32> {
    let looks = looks.clamp(1, steps.max(1));
    let step = move |look: u32| {
        let step = u64::from(look) * u64::from(steps) / u64::from(looks);
        index_u32(index_usize(step))
    };
    (0..=looks).map(step)
}

/// What pictures are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The scene as its camera sees it at frame 0: one picture.
    Scene,
    /// The foliage of a plant, by its number in [`World::crowns`]: a picture from each of
    /// [`directions`](super::directions).
    Plant(usize),
}

/// How a subject looks at a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Whether the foliage is pruned, whatever the scene says.
    pub pruned: bool,
    /// The step.
    pub step: u32,
    /// What the pictures are of.
    pub subject: Subject,
    /// The pictures.
    pub shots: Vec<Shot>,
    /// The summed area of a plant's leaves, in square metres; 0 for the scene.
    pub leaf_area: f64,
}

/// Hands out how the scene and then each of its plants look, each from full detail to the coarsest; and
/// then again, if their foliage is wanted pruned as well.
///
/// # Errors
///
/// What the device refuses, and what `take` answers.
pub fn looks<E: From<RunError>>(
    scene: &Scene,
    world: &World,
    options: &LookOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(Look) -> Result<(), E>,
) -> Result<(), E> {
    let steps: Vec<u32> = looked_at(options.steps, options.looks)
        .filter(|step| *step == 0 || options.shard.draws(*step))
        .collect();
    let prunings: Vec<bool> = prunings(&options.variants).collect();
    let subjects = (world.crowns.len() + 1) * prunings.len();
    progress.begin("pictures of levels", (subjects * steps.len()) as u64);
    for pruned in prunings {
        let other = pruned.then(|| world.simplified_by(Simplifier::Pruning));
        let world = other.as_ref().unwrap_or(world);
        looks_of(scene, (world, pruned), options, &steps, progress, &mut take)?;
    }
    Ok(())
}

/// [`looks`] of one of the foliages at these steps.
fn looks_of<E: From<RunError>>(
    scene: &Scene,
    (world, pruned): (&World, bool),
    options: &LookOptions,
    steps: &[u32],
    progress: &dyn Progress,
    mut take: impl FnMut(Look) -> Result<(), E>,
) -> Result<(), E> {
    let mut finest = scene.clone();
    finest.model.level = Some(0.0);
    // Any model would do; this one sends least.
    let session = SessionOptions {
        kind: Kind::LodfStamps,
        model: ModelOptions {
            format: LeafFormat::WIDE,
            ..options.session.model
        },
        ..options.session
    };
    let (size, kinds) = (session.size, (session.kind, session.trunk));
    let mut session = Session::new(&finest, world, &session)?;
    for &step in steps {
        let at = [step, options.steps];
        session.commit_states(&states_at(scene, world, size, kinds, at))?;
        take(Look {
            pruned,
            step,
            subject: Subject::Scene,
            shots: vec![session.shot(0)?],
            leaf_area: 0.0,
        })?;
        progress.step();
    }
    drop(session);
    for (number, crown) in world.crowns.iter().enumerate() {
        let mut views = Views::new(crown)?;
        for &step in steps {
            let state = level(crown, step, options.steps);
            views.show(&state)?;
            let visible = state.visible(crown.clusters());
            let measure = measure_leaves(crown.vertices(), crown.sequence(), visible);
            take(Look {
                pruned,
                step,
                subject: Subject::Plant(number),
                shots: views.shots()?,
                leaf_area: measure.area,
            })?;
            progress.step();
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_spread_evenly_with_both_ends() {
        let steps = |steps, looks| looked_at(steps, looks).collect::<Vec<u32>>();
        assert_eq!(steps(100, 4), [0, 25, 50, 75, 100]);
        assert_eq!(steps(10, 4), [0, 2, 5, 7, 10]);
        assert_eq!(steps(3, 99), [0, 1, 2, 3]);
        assert_eq!(steps(3, 0), [0, 3]);
        assert_eq!(steps(u32::MAX, 2), [0, u32::MAX / 2, u32::MAX]);
    }
}
