//! How far a level of detail is from full detail, to somebody who looks at both.

use rayon::prelude::*;

use super::diff::FlipReference;
use super::{Picture, ReportError};
use crate::run::{STUDIO_SKY, Shot};

/// Pictures of a model alone at full detail, that others of it are held against by [FLIP](crate::references).
#[derive(Debug)]
pub struct FlipWhereShown {
    full: Vec<FlipReference>,
}

impl FlipWhereShown {
    /// Looks at full detail.
    ///
    /// # Errors
    ///
    /// When pictures are too large.
    pub fn new(full: &[Shot]) -> Result<Self, ReportError> {
        let full = full
            .par_iter()
            .map(|shot| Ok(FlipReference::new(picture(shot)?)));
        Ok(Self {
            full: full.collect::<Result<_, ReportError>>()?,
        })
    }

    /// The mean, from 0 to 1, over the pixels of all pictures that show anything before the sky, at full detail
    /// or at the level: it does not fall with how much of a picture is empty, as a mean over all pixels would.
    /// What the filters spread into the sky around is not counted. Each pixel's FLIP is that of
    /// [`Flip::map`](super::diff::Flip::map), in steps of 1/255.
    ///
    /// # Errors
    ///
    /// When pictures are too large, or not of the size of those at full detail.
    pub fn of(&self, level: &[Shot]) -> Result<f64, ReportError> {
        let pairs = self.full.par_iter().zip(level);
        let found: Vec<_> = pairs.map(|(full, level)| shown_flip(full, level)).collect();
        let (mut sum, mut count) = (0, 0);
        for pair in found {
            let (flips, shown) = pair?;
            sum += flips;
            count += shown;
        }
        Ok(sum as f64 / (255 * count.max(1)) as f64)
    }
}

fn picture(shot: &Shot) -> Result<Picture, ReportError> {
    let image = &shot.image;
    Picture::new(image.width, image.height, image.rgba.clone())
}

/// The sum of `255 FLIP` over the pixels of a picture that show anything, and how many these are.
fn shown_flip(full: &FlipReference, level: &Shot) -> Result<(u64, u64), ReportError> {
    let level = picture(level)?;
    let pixels = [full.picture(), &level].map(|picture| picture.rgba().as_chunks::<4>().0);
    let flip = full
        .flip(&level)
        .map_err(|_mismatch| ReportError::Samples {
            what: "a picture to compare".to_owned(),
            found: pixels[1].len(),
            width: full.picture().width(),
            height: full.picture().height(),
            wanted: "a picture of the same size".to_owned(),
        })?;
    let is_sky = |pixel: &[u8; 4]| pixel[..3] == STUDIO_SKY;
    let pairs = pixels[0].iter().zip(pixels[1]);
    let shown = pairs.map(|(one, other)| !is_sky(one) || !is_sky(other));
    let errors = flip.map.iter().zip(shown).filter(|(_, shown)| *shown);
    Ok(errors.fold((0, 0), |(sum, count), (&error, _)| {
        (sum + u64::from(error), count + 1)
    }))
}
