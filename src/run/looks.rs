//! How every level looks: the pictures by which a walk along the axis of detail is judged.
//!
//! The pictures of a level are the same for all models of an [appearance](Appearance), so they are taken
//! once a level of each. They come one level after another, full detail first, so that nobody need
//! hold more than two.

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::Session;
use super::shard::Shard;
use super::sweep::{Variant, finest, states_at};
use super::views::{Shot, Views};
use super::world::World;
use crate::math::{index_u32, index_usize};
use crate::models::{Kind, LeafFormat, ModelOptions, Records, State, TrunkKind, Vertices, level};
use crate::scene::{Scene, Simplifier, TrunkMode, TrunkName};
use crate::simplify::measure_leaves;

/// What beside the level decides how a scene looks: by law, models that agree in it show the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Appearance {
    /// Whether foliage goes along the axis of detail, or stays at full detail.
    pub foliage_has_levels: bool,
    /// Whether trunks do; `None` for the scene's own.
    pub trunk_has_levels: Option<bool>,
    /// How exactly leaves are placed.
    pub vertices: Vertices,
    /// Whether leaves are pruned, whatever the scene says.
    pub pruned: bool,
}

impl Appearance {
    /// Foliage with levels and exact vertices, simplified as the scene says, the scene's own trunks.
    pub const USUAL: Self = Self {
        foliage_has_levels: true,
        trunk_has_levels: None,
        vertices: Vertices::Float,
        pruned: false,
    };

    /// Of a variant; of what has [no levels](Variant::has_levels), that which begins as it always is.
    #[must_use]
    pub fn of(variant: Variant) -> Self {
        Self {
            foliage_has_levels: variant.kind.has_levels() || !variant.has_levels(),
            trunk_has_levels: variant.trunk.map(TrunkKind::has_levels),
            vertices: variant.format.vertices,
            pruned: variant.pruned,
        }
    }

    /// The usual one, then what else there is among variants, each once.
    #[must_use]
    pub fn all_of(variants: impl IntoIterator<Item = Variant>) -> Vec<Self> {
        let mut all = vec![Self::USUAL];
        for variant in variants {
            let found = Self::of(variant);
            if !all.contains(&found) {
                all.push(found);
            }
        }
        all
    }

    /// How a session shows it. Any kind that looks so would do; these send least.
    fn session(self, usual: &SessionOptions) -> SessionOptions {
        SessionOptions {
            kind: match self.foliage_has_levels {
                true => Kind::LodfStamps,
                false => Kind::Full,
            },
            trunk: match self.trunk_has_levels {
                None => usual.trunk,
                Some(false) => TrunkKind::FULL,
                Some(true) => TrunkKind {
                    name: TrunkName::LodStrips,
                    mode: TrunkMode::Device,
                },
            },
            model: ModelOptions {
                format: LeafFormat {
                    records: Records::Wide,
                    vertices: self.vertices,
                },
                ..usual.model
            },
            ..*usual
        }
    }

    /// What of it is seen of foliage alone.
    fn foliage(self) -> Self {
        Self {
            trunk_has_levels: None,
            ..self
        }
    }
}

/// Which levels to look at.
#[derive(Debug, Clone, PartialEq)]
pub struct LookOptions {
    /// The models whose levels are looked at, in each [appearance](Appearance) that one of them has; all
    /// are held against full detail of the usual one, which is looked at whoever has it.
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
    /// The step.
    pub step: u32,
    /// What looks so: one appearance of a scene; of foliage alone several may look the same.
    pub appearances: Vec<Appearance>,
    /// What the pictures are of.
    pub subject: Subject,
    /// The pictures.
    pub shots: Vec<Shot>,
    /// The summed area of a plant's leaves, in square metres; 0 for the scene.
    pub leaf_area: f64,
}

/// Hands out how the scene and then each of its plants look, in each appearance from full detail to the
/// coarsest.
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
    let appearances = Appearance::all_of(options.variants.iter().copied());
    let mut foliages: Vec<Appearance> = Vec::new();
    for appearance in &appearances {
        if !foliages.contains(&appearance.foliage()) {
            foliages.push(appearance.foliage());
        }
    }
    let walks = appearances.len() + world.crowns.len() * foliages.len();
    progress.begin("pictures of levels", (walks * steps.len()) as u64);
    let any_pruned = appearances.iter().any(|appearance| appearance.pruned);
    let pruned = any_pruned.then(|| world.simplified_by(Simplifier::Pruning));
    let world_of = |appearance: Appearance| {
        let pruned = pruned.as_ref().filter(|_| appearance.pruned);
        pruned.unwrap_or(world)
    };
    let finest = finest(scene);
    for &appearance in &appearances {
        let world = world_of(appearance);
        let session = appearance.session(&options.session);
        let (size, kinds) = (session.size, (session.kind, session.trunk));
        let mut session = Session::new(&finest, world, &session)?;
        for &step in &steps {
            let at = [step, options.steps];
            session.commit_states(&states_at(scene, world, size, kinds, at))?;
            take(Look {
                step,
                appearances: vec![appearance],
                subject: Subject::Scene,
                shots: vec![session.shot(0)?],
                leaf_area: 0.0,
            })?;
            progress.step();
        }
    }
    for number in 0..world.crowns.len() {
        for &foliage in &foliages {
            let crown = &world_of(foliage).crowns[number];
            let like = appearances.iter().copied();
            let like = like.filter(|other| other.foliage() == foliage);
            let like: Vec<Appearance> = like.collect();
            let mut views = Views::with_vertices(crown, foliage.vertices)?;
            for &step in &steps {
                let state = match foliage.foliage_has_levels {
                    true => level(crown, step, options.steps),
                    false => State::FINEST,
                };
                views.show(&state)?;
                let visible = state.visible(crown.clusters());
                let measure = measure_leaves(crown.vertices(), crown.sequence(), visible);
                take(Look {
                    step,
                    appearances: like.clone(),
                    subject: Subject::Plant(number),
                    shots: views.shots()?,
                    leaf_area: measure.area + crown.faces().area(crown.plant()),
                })?;
                progress.step();
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_looks_the_same_is_looked_at_once() {
        let variants = [
            "full",
            "lodf-slots-u16",
            "lodf-stamps-quantised",
            "vdf-host+mom-host",
            "lodf-cluster-u16-quantised",
            "lodf-slots+lodstrips-device",
            "full+lodstrips-cut-host",
            "full+full",
            "lodf-stamps-pruned-u16",
        ];
        let variants = variants.map(|label| Variant::labelled(label).unwrap());
        let appearance = |foliage_has_levels, trunk_has_levels, vertices| Appearance {
            foliage_has_levels,
            trunk_has_levels,
            vertices,
            pruned: false,
        };
        let wanted = [
            Appearance::USUAL,
            appearance(true, None, Vertices::Quantised),
            appearance(true, Some(true), Vertices::Float),
            appearance(false, Some(true), Vertices::Float),
            // As it always is, it is at the begin.
            appearance(true, Some(false), Vertices::Float),
            Appearance {
                pruned: true,
                ..Appearance::USUAL
            },
        ];
        assert_eq!(Appearance::all_of(variants), wanted);
    }

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
