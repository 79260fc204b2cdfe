//! What level of detail does to the picture: levels against full detail.
//!
//! ```text
//! run::looks ─▶ Look, Look, …  ─add─▶ QualityMeter ─finish─▶ SweepQuality: a line a level
//!               (full detail first)      └─ ViewQuality: one picture against another
//! ```
//!
//! `run` takes the pictures and knows no measure of them, this stage measures and draws nothing; so
//! neither has to name the other's. All measures are of two pictures of one size, and are sums in
//! the order of pixels, then of views, then of plants, whatever the number of threads.
//!
//! **Invariant.** Equal pictures have covered pixels 1, silhouette 0, FLIP 0 and SSIM 1, exactly.

mod view;

pub use view::{PictureView, QualitySummary, Spread, ViewQuality};

use std::collections::BTreeMap;

use super::ReportError;
use crate::math::Digest;
use crate::run::{Appearance, Look, Subject, SweepModel, SweepStep};

/// What every level that was looked at does to the picture.
///
/// Levels and [appearances](Appearance) alone decide it: by law all models of one show the same at a
/// level, so it is found once a level of each. Whether they do is seen from the digest of the scene's
/// picture, by [`of`](Self::of).
#[derive(Debug, Clone, PartialEq)]
pub struct SweepQuality {
    /// Plants that were looked at, each alone and once however many of it stand.
    pub plants: usize,
    /// The levels, appearance by appearance, the usual one first; of each ascending, full detail first.
    pub steps: Vec<StepQuality>,
}

/// What a level does to the picture.
#[derive(Debug, Clone, PartialEq)]
pub struct StepQuality {
    /// The step of the walk.
    pub step: u32,
    /// What looks so.
    pub appearance: Appearance,
    /// The digest of the scene's own picture at this step.
    pub image_digest: Digest,
    /// The scene's own picture against that at full detail.
    pub frame: ViewQuality,
    /// The leaves' area as a share of full detail's; the mean over the plants.
    pub leaf_area: f64,
    /// Foliage alone, from the 26 fixed directions, over all plants.
    pub foliage: QualitySummary,
}

impl SweepQuality {
    /// What a model's step does to the picture, if the step was looked at and shows what was looked
    /// at then. A model without levels shows full detail at every step.
    #[must_use]
    pub fn of(&self, model: &SweepModel, step: &SweepStep) -> Option<&StepQuality> {
        self.at(model, step)
            .filter(|found| found.image_digest == step.image_digest)
    }

    /// Whether a model shows at a step what was looked at then, or `None` if nothing was.
    #[must_use]
    pub fn agrees(&self, model: &SweepModel, step: &SweepStep) -> Option<bool> {
        let found = self.at(model, step)?;
        Some(found.image_digest == step.image_digest)
    }

    fn at(&self, model: &SweepModel, step: &SweepStep) -> Option<&StepQuality> {
        let mut steps = self
            .of_appearance(Appearance::of(model.variant))
            .into_iter();
        let first = *steps.as_slice().first()?;
        let found = steps.find(|found| found.step == step.step)?;
        Some(match model.variant.has_levels() {
            true => found,
            false => first,
        })
    }

    /// The appearances that were looked at, the usual one first; pruned or not, they are one.
    #[must_use]
    pub fn looks(&self) -> Vec<Appearance> {
        let mut all = Vec::new();
        for step in &self.steps {
            let look = unpruned(step.appearance);
            if !all.contains(&look) {
                all.push(look);
            }
        }
        all
    }

    /// The levels of one of these [looks](Self::looks): first as the scene simplifies foliage, then pruned.
    #[must_use]
    pub fn of_look(&self, look: Appearance) -> Vec<&StepQuality> {
        let steps = self.steps.iter();
        let found = steps.filter(|step| unpruned(step.appearance) == look);
        let (pruned, usual): (Vec<_>, Vec<_>) = found.partition(|step| step.appearance.pruned);
        [usual, pruned].concat()
    }

    /// The levels of an appearance, ascending.
    #[must_use]
    pub fn of_appearance(&self, appearance: Appearance) -> Vec<&StepQuality> {
        let steps = self.steps.iter();
        steps.filter(|step| step.appearance == appearance).collect()
    }
}

/// The same with leaves as the scene simplifies them.
fn unpruned(appearance: Appearance) -> Appearance {
    Appearance {
        pruned: false,
        ..appearance
    }
}

/// Takes looks one after another and holds each against full detail.
#[derive(Debug, Default)]
pub struct QualityMeter {
    /// The subject that is looked at, and how it looks at full detail.
    reference: Option<Reference>,
    /// As they came.
    appearances: Vec<Appearance>,
    /// By the appearance's place and the step.
    steps: BTreeMap<(usize, u32), Sums>,
    plants: usize,
}

#[derive(Debug)]
struct Reference {
    subject: Subject,
    views: Vec<PictureView>,
    leaf_area: f64,
}

#[derive(Debug, Default)]
struct Sums {
    frame: Option<(Digest, ViewQuality)>,
    leaf_areas: Vec<f64>,
    foliage: Vec<ViewQuality>,
}

impl QualityMeter {
    /// Takes how a subject looks at a step; the first look of a subject is its full detail.
    ///
    /// # Errors
    ///
    /// When a picture is larger than a picture may be, or not of the size of the first.
    pub fn add(&mut self, look: Look) -> Result<(), ReportError> {
        let digest = look.shots.first().map(|shot| shot.image.digest());
        let views = PictureView::all(look.shots)?;
        let is_known = |reference: &Reference| reference.subject == look.subject;
        if !self.reference.as_ref().is_some_and(is_known) {
            self.plants += usize::from(look.subject != Subject::Scene);
            self.reference = Some(Reference {
                subject: look.subject,
                views: views.clone(),
                leaf_area: look.leaf_area,
            });
        }
        let Some(reference) = &self.reference else {
            return Ok(());
        };
        let found = ViewQuality::all(&reference.views, &views)?;
        for appearance in look.appearances {
            let known = self.appearances.iter();
            let place = match known.into_iter().position(|known| *known == appearance) {
                Some(place) => place,
                None => {
                    self.appearances.push(appearance);
                    self.appearances.len() - 1
                }
            };
            let sums = self.steps.entry((place, look.step)).or_default();
            match look.subject {
                Subject::Scene => sums.frame = digest.zip(found.first().copied()),
                Subject::Plant(_) => {
                    sums.leaf_areas
                        .push(share(look.leaf_area, reference.leaf_area));
                    sums.foliage.extend(&found);
                }
            }
        }
        Ok(())
    }

    /// What was found; levels of which the scene's own picture was not taken are left out.
    #[must_use]
    pub fn finish(self) -> SweepQuality {
        let step = |((place, step), sums): ((usize, u32), Sums)| {
            let (image_digest, frame) = sums.frame?;
            Some(StepQuality {
                step,
                appearance: self.appearances[place],
                image_digest,
                frame,
                leaf_area: mean(&sums.leaf_areas).unwrap_or(1.0),
                foliage: QualitySummary::of(&sums.foliage),
            })
        };
        SweepQuality {
            plants: self.plants,
            steps: self.steps.into_iter().filter_map(step).collect(),
        }
    }
}

/// A part of a whole; of nothing, nothing is all.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 1.0 }
}

fn mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().sum();
    (!values.is_empty()).then(|| sum / values.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Shot;

    /// A picture of the test's own with leaves in its first `leaves` pixels.
    fn look(step: u32, subject: Subject, leaves: usize, leaf_area: f64) -> Look {
        Look {
            step,
            appearances: vec![Appearance::USUAL],
            subject,
            shots: vec![view::tests::shot(leaves), view::tests::shot(2 * leaves)],
            leaf_area,
        }
    }

    fn digest(leaves: usize) -> Digest {
        let Shot { image, .. } = view::tests::shot(leaves);
        image.digest()
    }

    #[test]
    fn every_level_is_held_against_its_own_subject() {
        let mut meter = QualityMeter::default();
        for (step, leaves) in [(0, 40), (5, 30)] {
            meter.add(look(step, Subject::Scene, leaves, 0.0)).unwrap();
        }
        for (plant, area) in [(0, 8.0), (1, 2.0)] {
            let subject = Subject::Plant(plant);
            meter.add(look(0, subject, 20, area)).unwrap();
            meter.add(look(5, subject, 10, 1.0)).unwrap();
        }
        let quality = meter.finish();
        assert_eq!((quality.plants, quality.steps.len()), (2, 2));
        let [full, coarse] = &quality.steps[..] else {
            panic!("two steps");
        };
        assert_eq!((full.image_digest, full.leaf_area), (digest(40), 1.0));
        assert_eq!(
            full.foliage.covered,
            Spread {
                mean: 1.0,
                worst: 1.0
            }
        );
        assert_eq!(
            full.foliage.flip,
            Spread {
                mean: 0.0,
                worst: 0.0
            }
        );
        assert_eq!(coarse.image_digest, digest(30));
        assert_eq!(coarse.frame.covered, 0.75);
        // An eighth of the one, half of the other.
        assert_eq!(coarse.leaf_area, 0.3125);
        assert_eq!(
            coarse.foliage.covered,
            Spread {
                mean: 0.5,
                worst: 0.5
            }
        );
        assert_eq!(
            coarse.foliage.silhouette,
            Spread {
                mean: 0.5,
                worst: 0.5
            }
        );
    }
}
