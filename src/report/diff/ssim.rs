//! Structural similarity ([SSIM](crate::references)).

use std::ops::Range;

use super::colour::{are_equal, seen_rows};
use super::difference::{SizeMismatch, size};
use super::filter::{Kernel, by_bands};
use crate::math::det;
use crate::report::Picture;

/// The window reaches so far: 11 × 11 pixels.
const RADIUS: usize = 5;

/// The standard deviation of its weights, in pixels.
const DEVIATION: f64 = 1.5;

/// `(K₁ L)²` with `K₁ = 0.01`, `L = 255`.
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);

/// `(K₂ L)²` with `K₂ = 0.03`, `L = 255`.
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// The mean structural similarity of two pictures: 1 for equal ones, less the less alike they are;
/// none for pictures that are smaller than the window.
///
/// [SSIM](crate::references), eq. 13 to 17: the window of 11 × 11 pixels weighted by a Gaussian of
/// 1.5 pixels whose weights sum to 1, `K₁ = 0.01`, `K₂ = 0.03`, `L = 255`. Local variances are those
/// of a population, `Σ w x² − μ²`. The window stays inside: the mean is that of the places at least
/// five pixels from every border. Compared is luma, `0.299 R + 0.587 G + 0.114 B` of the encoded
/// bytes, not rounded; pictures that are not opaque are laid over byte 128.
///
/// # Errors
///
/// When the pictures are not of one size.
pub fn ssim(expected: &Picture, actual: &Picture) -> Result<Option<f64>, SizeMismatch> {
    let [wanted, found] = [expected, actual].map(size);
    if wanted != found {
        return Err(SizeMismatch {
            expected: wanted,
            actual: found,
        });
    }
    let [width, height] = found.map(|side| side as usize);
    if width.min(height) <= 2 * RADIUS {
        return Ok(None);
    }
    let kernel = Kernel::new(RADIUS, |place| {
        det::exp_f64(-place * place / (2.0 * DEVIATION * DEVIATION))
    })
    .normalized();
    let columns = width - 2 * RADIUS;
    let rows = by_bands(RADIUS..height - RADIUS, |band| {
        band_sums(expected, actual, &kernel, band)
    });
    let count = columns as f64 * rows.len() as f64;
    Ok(Some(rows.iter().sum::<f64>() / count))
}

/// The sum over each row of a band.
fn band_sums(
    expected: &Picture,
    actual: &Picture,
    kernel: &Kernel,
    band: Range<usize>,
) -> Vec<f64> {
    let width = expected.width() as usize;
    let inside = RADIUS..width - RADIUS;
    let wanted = band.start.cast_signed() - RADIUS.cast_signed()
        ..band.end.cast_signed() + RADIUS.cast_signed();
    if are_equal(expected, actual, wanted.start, wanted.end) {
        // What the sum below comes to: equal numerators and denominators.
        return vec![inside.len() as f64; band.len()];
    }
    let [one, other] = [expected, actual].map(|picture| -> Vec<f64> {
        let pixels = seen_rows(picture, wanted.clone());
        let luma = |[red, green, blue]: [u8; 3]| {
            0.299 * f64::from(red) + 0.587 * f64::from(green) + 0.114 * f64::from(blue)
        };
        pixels.into_iter().map(luma).collect()
    });
    let mean =
        |plane: &[f64]| kernel.along_columns(&kernel.along_rows(plane, width), width, RADIUS);
    let product = |one: &[f64], other: &[f64]| {
        let products: Vec<f64> = one.iter().zip(other).map(|(a, b)| a * b).collect();
        mean(&products)
    };
    let (mean_one, mean_other) = (mean(&one), mean(&other));
    let (one_one, other_other) = (product(&one, &one), product(&other, &other));
    let one_other = product(&one, &other);
    let similarity = |at: usize| {
        let (x, y) = (mean_one[at], mean_other[at]);
        let (xx, yy) = (one_one[at] - x * x, other_other[at] - y * y);
        let xy = one_other[at] - x * y;
        let numerator = (2.0 * (x * y) + C1) * (2.0 * xy + C2);
        numerator / ((x * x + y * y + C1) * (xx + yy + C2))
    };
    let row = |y: usize| inside.clone().map(|x| similarity(y * width + x)).sum();
    (0..band.len()).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, variant};
    use super::*;

    fn even(side: u32, grey: u8) -> Picture {
        let rgba = [grey, grey, grey, 255].repeat((side * side) as usize);
        Picture::new(side, side, rgba).expect("filled")
    }

    #[test]
    fn equal_pictures_are_exactly_alike() {
        assert_eq!(ssim(&example(), &example()), Ok(Some(1.0)));
        // One pixel differs far from the first rows: what is skipped there comes to the same.
        let [one, other] = [example(), variant("one")];
        let kernel = Kernel::new(RADIUS, |_| 1.0).normalized();
        let skipped = band_sums(&one, &one, &kernel, 5..9);
        assert_eq!(band_sums(&one, &other, &kernel, 5..9), skipped);
        // The same rows in a band that sees the pixel.
        assert_eq!(band_sums(&one, &other, &kernel, 5..30)[..4], skipped);
    }

    #[test]
    fn even_pictures_differ_by_their_means_alone() {
        let found = ssim(&even(12, 90), &even(12, 100)).unwrap().unwrap();
        let wanted = (2.0 * 90.0 * 100.0 + C1) / (90.0 * 90.0 + 100.0 * 100.0 + C1);
        assert!((found - wanted).abs() < 1e-12, "{found}");
        assert_eq!(ssim(&even(10, 90), &even(10, 90)), Ok(None));
        assert_eq!(ssim(&even(11, 90), &even(11, 90)), Ok(Some(1.0)));
        assert!(ssim(&even(11, 90), &even(12, 90)).is_err());
    }

    /// scikit-image 0.26.0, `structural_similarity(…, gaussian_weights=True, sigma=1.5,
    /// use_sample_covariance=False, data_range=255)` of the same luma in `float64`.
    #[test]
    fn values_are_those_of_another_program() {
        for (name, wanted) in [
            ("offset", 0.996_001_846_939),
            ("noise", 0.756_410_360_260),
            ("shift", 0.840_868_915_932),
            ("spots", 0.896_159_494_011),
            ("one", 0.991_685_641_392),
            ("inverse", -0.019_312_390_435),
        ] {
            let found = ssim(&example(), &variant(name)).unwrap().unwrap();
            assert!((found - wanted).abs() < 1e-10, "{name}: {found}");
        }
    }
}
