//! One picture of leaves against another, and many together.

use rayon::prelude::*;

use crate::report::diff::{flip, ssim};
use crate::report::{Picture, ReportError};
use crate::run::Shot;

/// A picture and where leaves are in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureView {
    /// The picture.
    pub picture: Picture,
    /// Whether a pixel shows a leaf; row by row from the top.
    pub leaves: Vec<bool>,
}

impl PictureView {
    /// A picture as it was taken.
    ///
    /// # Errors
    ///
    /// When it is larger than a picture may be.
    pub fn of(shot: Shot) -> Result<Self, ReportError> {
        let Shot { image, leaves } = shot;
        let picture = Picture::new(image.width, image.height, image.rgba)?;
        Ok(Self { picture, leaves })
    }

    /// Pictures as they were taken, in their order.
    ///
    /// # Errors
    ///
    /// Of the first one that is larger than a picture may be.
    pub fn all(shots: Vec<Shot>) -> Result<Vec<Self>, ReportError> {
        let views: Vec<_> = shots.into_par_iter().map(Self::of).collect();
        views.into_iter().collect()
    }

    /// Pixels that show a leaf.
    #[must_use]
    pub fn covered(&self) -> u64 {
        self.leaves.iter().filter(|leaf| **leaf).count() as u64
    }
}

/// What is found of a picture when it is held against another of the same view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewQuality {
    /// Pixels that show a leaf, as a share of the other's.
    pub covered: f64,
    /// Pixels that show a leaf in one of the two alone, as a share of the other's that show one:
    /// where leaves came and where they went, which covered pixels set off against each other.
    pub silhouette: f64,
    /// The difference that is seen ([FLIP](crate::references)), the mean over all pixels of the
    /// picture, the empty ones too.
    pub flip: f64,
    /// Structural similarity ([SSIM](crate::references)); none for pictures smaller than its window.
    pub ssim: Option<f64>,
}

impl ViewQuality {
    /// Holds each picture of a level against that of full detail from there, in their order.
    ///
    /// # Errors
    ///
    /// Of the first pair whose pictures are not of one size.
    pub fn all(full: &[PictureView], level: &[PictureView]) -> Result<Vec<Self>, ReportError> {
        let pairs = full.par_iter().zip(level);
        let found: Vec<_> = pairs
            .map(|(full, level)| Self::between(full, level))
            .collect();
        found.into_iter().collect()
    }

    /// Holds a level against full detail. Where full detail shows no leaf, shares are those of one
    /// pixel.
    ///
    /// # Errors
    ///
    /// When the pictures are not of one size.
    pub fn between(full: &PictureView, level: &PictureView) -> Result<Self, ReportError> {
        let different = |_| ReportError::Samples {
            what: "a picture to compare".to_owned(),
            found: level.leaves.len(),
            width: full.picture.width(),
            height: full.picture.height(),
            wanted: "a picture of the same size".to_owned(),
        };
        let pairs = full.leaves.iter().zip(&level.leaves);
        let apart = pairs.filter(|(one, other)| one != other).count();
        let all = full.covered().max(1) as f64;
        let covered = match (full.covered(), level.covered()) {
            (0, 0) => 1.0,
            (_, shown) => shown as f64 / all,
        };
        Ok(Self {
            covered,
            silhouette: apart as f64 / all,
            flip: flip(&full.picture, &level.picture).map_err(different)?.mean,
            ssim: ssim(&full.picture, &level.picture).map_err(different)?,
        })
    }
}

/// A measure over many views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The mean.
    pub mean: f64,
    /// The view that is worst.
    pub worst: f64,
}

impl Spread {
    /// Over some values, the worst being that which is furthest from `best`; `best` over none.
    fn of(best: f64, values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count();
        let sum: f64 = values.clone().sum();
        let further = |worst: f64, value: f64| match (value - best).abs() > (worst - best).abs() {
            true => value,
            false => worst,
        };
        Self {
            mean: if count == 0 { best } else { sum / count as f64 },
            worst: values.fold(best, further),
        }
    }
}

/// Many views together; the measures are those of [`ViewQuality`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QualitySummary {
    /// Covered pixels; the worst is furthest from 1.
    pub covered: Spread,
    /// Silhouette.
    pub silhouette: Spread,
    /// FLIP.
    pub flip: Spread,
    /// SSIM over the views that are large enough.
    pub ssim: Spread,
}

impl QualitySummary {
    /// Over some views.
    #[must_use]
    pub fn of(views: &[ViewQuality]) -> Self {
        Self {
            covered: Spread::of(1.0, views.iter().map(|view| view.covered)),
            silhouette: Spread::of(0.0, views.iter().map(|view| view.silhouette)),
            flip: Spread::of(0.0, views.iter().map(|view| view.flip)),
            ssim: Spread::of(1.0, views.iter().filter_map(|view| view.ssim)),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::gpu::Image;

    /// 16 × 16 white pixels, the first of them leaves, black.
    pub(in super::super) fn shot(leaves: usize) -> Shot {
        let leaves: Vec<bool> = (0..256).map(|pixel| pixel < leaves).collect();
        let colour = |leaf: &bool| if *leaf { [0, 0, 0, 255] } else { [255; 4] };
        let rgba = leaves.iter().flat_map(colour).collect();
        let (width, height) = (16, 16);
        let image = Image {
            width,
            height,
            rgba,
        };
        Shot { image, leaves }
    }

    fn view(leaves: impl Fn(usize) -> bool) -> PictureView {
        let mut view = PictureView::of(shot(0)).unwrap();
        view.leaves = (0..256).map(leaves).collect();
        view
    }

    #[test]
    fn an_equal_picture_is_perfect() {
        for leaves in [0, 100] {
            let view = PictureView::of(shot(leaves)).unwrap();
            let found = ViewQuality::between(&view, &view).unwrap();
            let perfect = ViewQuality {
                covered: 1.0,
                silhouette: 0.0,
                flip: 0.0,
                ssim: Some(1.0),
            };
            assert_eq!(found, perfect);
        }
    }

    #[test]
    fn silhouettes_see_what_covered_pixels_do_not() {
        let found = |full: PictureView, level: PictureView| {
            let found = ViewQuality::between(&full, &level).unwrap();
            (found.covered, found.silhouette)
        };
        // 40 pixels of leaves, of which 10 move aside; then grow by 10; then there are none.
        let full = || view(|pixel| pixel < 40);
        let moved = view(|pixel| (10..50).contains(&pixel));
        assert_eq!(found(full(), moved), (1.0, 0.5));
        assert_eq!(found(full(), view(|pixel| pixel < 50)), (1.25, 0.25));
        assert_eq!(found(full(), view(|_| false)), (0.0, 1.0));
        assert_eq!(found(view(|_| false), view(|pixel| pixel < 3)), (3.0, 3.0));
        let small = Shot {
            leaves: Vec::new(),
            image: Image {
                width: 1,
                height: 1,
                rgba: vec![0; 4],
            },
        };
        let small = PictureView::of(small).unwrap();
        assert!(ViewQuality::between(&full(), &small).is_err());
    }

    #[test]
    fn the_worst_view_is_the_furthest_from_the_best() {
        let spread = |values: &[f64]| Spread::of(1.0, values.iter().copied());
        let of = |mean, worst| Spread { mean, worst };
        assert_eq!(spread(&[1.5, 0.75, 0.75]), of(1.0, 1.5));
        assert_eq!(spread(&[1.25, 0.25]), of(0.75, 0.25));
        assert_eq!(spread(&[]), of(1.0, 1.0));
    }
}
