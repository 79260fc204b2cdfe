//! How much a small step of the camera changes, beside other ways to draw the same tree.

use super::{PaintStudy, world_of};
use crate::math::Quat;
use crate::models::Kind;
use crate::raster::Image;
use crate::run::{Progress, RunError, Session, SessionOptions};

/// What is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShimmerSubject {
    /// The painting, whose strokes stay put.
    Painted,
    /// The same with brushes and hues drawn anew for every frame, as where they are no function of the
    /// stroke.
    DrawnAnew,
    /// Plain leaves and trunk.
    Leaves,
}

impl ShimmerSubject {
    /// All.
    pub const ALL: [Self; 3] = [Self::Painted, Self::DrawnAnew, Self::Leaves];

    /// A name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Painted => "painted, strokes stay put",
            Self::DrawnAnew => "painted, brushes drawn anew",
            Self::Leaves => "plain leaves",
        }
    }
}

/// What steps of the camera change: the mean over all pixels of the largest difference of a channel, of
/// 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shimmer {
    /// Of what.
    pub subject: ShimmerSubject,
    /// How far the camera goes around the tree in a step, in degrees; 0 where it stands.
    pub degrees: f32,
    /// The mean over all steps.
    pub mean: f64,
    /// The step that changes most.
    pub worst: f64,
    /// The share of pixels that change by more than an eighth of the range, over all steps.
    pub changed: f64,
}

/// Goes around a tree in `steps` steps of each angle, and looks at all subjects.
///
/// # Errors
///
/// What the device refuses.
pub fn shimmer(
    study: &PaintStudy,
    angles: &[f32],
    steps: u32,
    progress: &dyn Progress,
) -> Result<Vec<Shimmer>, RunError> {
    let world = world_of(&study.plant);
    let total = angles.len() * ShimmerSubject::ALL.len() * (steps as usize + 1);
    progress.begin("steps", total as u64);
    let mut found = Vec::new();
    for &degrees in angles {
        for subject in ShimmerSubject::ALL {
            let (mut sum, mut worst, mut changed) = (0.0, 0.0_f64, 0.0);
            let mut before: Option<Image> = None;
            for step in 0..=steps {
                let picture = picture(study, &world, subject, degrees, step)?;
                progress.step();
                if let Some(before) = before {
                    let (mean, share) = difference(&before, &picture);
                    sum += mean;
                    worst = worst.max(mean);
                    changed += share;
                }
                before = Some(picture);
            }
            let count = f64::from(steps.max(1));
            found.push(Shimmer {
                subject,
                degrees,
                mean: sum / count,
                worst,
                changed: changed / count,
            });
        }
    }
    Ok(found)
}

fn picture(
    study: &PaintStudy,
    world: &crate::run::World,
    subject: ShimmerSubject,
    degrees: f32,
    step: u32,
) -> Result<Image, RunError> {
    let center = study.painting.center();
    let eye = study.scene.camera.at(0, study.options.size).eye - center;
    let turn = Quat::from_rotation_y((degrees * step as f32).to_radians());
    let scene = study.looking(center + turn * eye);
    let mut options = study.options;
    match subject {
        ShimmerSubject::Painted => {}
        ShimmerSubject::DrawnAnew => {
            options.model.painting.seed = options.model.painting.seed.wrapping_add(step.into());
        }
        ShimmerSubject::Leaves => options.kind = Kind::Full,
    }
    let mut session = Session::new(&scene, world, &SessionOptions { ..options })?;
    Ok(session.frame(0)?.image)
}

/// The mean over all pixels of the largest difference of a channel, and the share of those where it is
/// above 32.
fn difference(one: &Image, other: &Image) -> (f64, f64) {
    let pixels = one.rgba.as_chunks::<4>().0.iter();
    let pixels = pixels.zip(other.rgba.as_chunks::<4>().0);
    let (mut sum, mut many) = (0_u64, 0_u64);
    for (one, other) in pixels {
        let channels = (0..3).map(|channel| one[channel].abs_diff(other[channel]));
        let largest = channels.max().unwrap_or(0);
        sum += u64::from(largest);
        many += u64::from(largest > 32);
    }
    let count = (one.rgba.len() / 4).max(1) as f64;
    (sum as f64 / count, many as f64 / count)
}
