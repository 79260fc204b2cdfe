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

    /// The mean over the pixels of all pictures that show anything before the sky, at full detail or at the
    /// level: it does not fall with how much of a picture is empty, as a mean over all pixels would.
    ///
    /// # Errors
    ///
    /// When pictures are too large, or not of the size of those at full detail.
    pub fn of(&self, level: &[Shot]) -> Result<f64, ReportError> {
        let pairs = self.full.par_iter().zip(level);
        let found: Vec<_> = pairs.map(|(full, level)| shown_flip(full, level)).collect();
        let (mut sum, mut count) = (0.0, 0);
        for pair in found {
            let (flips, shown) = pair?;
            sum += flips;
            count += shown;
        }
        Ok(sum / count.max(1) as f64)
    }
}

fn picture(shot: &Shot) -> Result<Picture, ReportError> {
    let image = &shot.image;
    Picture::new(image.width, image.height, image.rgba.clone())
}

/// FLIP, the sum over a picture, and how many of its pixels show anything.
fn shown_flip(full: &FlipReference, level: &Shot) -> Result<(f64, usize), ReportError> {
    let level = picture(level)?;
    let is_sky = |pixel: &[u8; 4]| pixel[..3] == STUDIO_SKY;
    let pixels = [full.picture(), &level].map(|picture| picture.rgba().as_chunks::<4>().0);
    let pairs = pixels[0].iter().zip(pixels[1]);
    let shown = pairs.filter(|(one, other)| !is_sky(one) || !is_sky(other));
    let shown = shown.count();
    let flip = full
        .flip(&level)
        .map_err(|_mismatch| ReportError::Samples {
            what: "a picture to compare".to_owned(),
            found: pixels[1].len(),
            width: full.picture().width(),
            height: full.picture().height(),
            wanted: "a picture of the same size".to_owned(),
        })?;
    Ok((flip.mean * pixels[0].len() as f64, shown))
}
