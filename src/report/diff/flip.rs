//! The difference that somebody sees who flips between two pictures ([FLIP](crate::references)).
//!
//! ```text
//!  bytes ─▶ linear ─▶ Y Cx Cz ─┬─ contrast sensitivity ─▶ L*a*b* ─ Hunt ─▶ HyAB ─▶ ΔE colour ┐
//!                              └─ Y ─▶ edges, points ────────────────────▶ ΔE feature ──────┤
//!                                                      ΔE = ΔE colour ^ (1 − ΔE feature) ◀──┘
//! ```
//!
//! Constants are those of the paper, section 4, and of the authors' program where the paper leaves
//! them open: the viewer sits 0.7 m before a screen that is 0.7 m and 3840 pixels wide, and colours
//! at the borders go on. In `f64`; the authors' program computes in `f32`, and differs by that.

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::LazyLock;

use super::colour::{are_equal, linear, seen_rows};
use super::difference::{SizeMismatch, size};
use super::filter::{BAND_ROWS, Kernel, by_bands};
use crate::math::{DMat3, DVec3, det, index_u32, whole_u32};
use crate::report::Picture;

/// Pixels to a degree of what is seen: 67.02.
const PIXELS_PER_DEGREE: f64 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// Compresses large differences of colour.
const COLOUR_EXPONENT: f64 = 0.7;

/// Differences up to this share of the largest …
const COMMON_SHARE: f64 = 0.4;

/// … take up this share of the scale.
const COMMON_SCALE: f64 = 0.95;

/// The width of features, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// What a comparison found, from 0, not to be told apart, to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Flip {
    /// The mean over all pixels.
    pub mean: f64,
    /// The largest of all pixels.
    pub largest: f64,
    /// The first pixel that has it, row by row; (0, 0) if none differs.
    pub largest_at: [u32; 2],
    /// `255 ΔE` of each pixel, rounded, row by row from the top.
    pub map: Vec<u8>,
}

/// Compares how two pictures look; pictures that are not opaque are laid over byte 128.
///
/// # Errors
///
/// When the pictures are not of one size.
pub fn flip(expected: &Picture, actual: &Picture) -> Result<Flip, SizeMismatch> {
    compared(expected, actual, None)
}

/// A picture that many are held against: what is seen of it is kept, 40 bytes a pixel.
#[derive(Debug)]
pub struct FlipReference {
    expected: Picture,
    bands: Vec<Seen>,
}

impl FlipReference {
    /// Looks at a picture.
    #[must_use]
    pub fn new(expected: Picture) -> Self {
        let height = expected.height() as usize;
        let bands = by_bands(0..height, |band| {
            vec![FILTERS.seen_of(&expected, with_margins(&band))]
        });
        Self { expected, bands }
    }

    /// The picture.
    #[must_use]
    pub fn picture(&self) -> &Picture {
        &self.expected
    }

    /// What [`flip`] finds of it and another.
    ///
    /// # Errors
    ///
    /// When the pictures are not of one size.
    pub fn flip(&self, actual: &Picture) -> Result<Flip, SizeMismatch> {
        compared(&self.expected, actual, Some(&self.bands))
    }
}

/// Compares pictures, band by band what is seen of the first being known or not.
fn compared(
    expected: &Picture,
    actual: &Picture,
    known: Option<&[Seen]>,
) -> Result<Flip, SizeMismatch> {
    let [wanted, found] = [expected, actual].map(size);
    if wanted != found {
        return Err(SizeMismatch {
            expected: wanted,
            actual: found,
        });
    }
    let [width, height] = found.map(|side| side as usize);
    let rows = by_bands(0..height, |band| {
        let known = known.and_then(|bands| bands.get(band.start / BAND_ROWS));
        band_errors(expected, actual, known, band)
    });
    let mut flip = Flip {
        mean: 0.0,
        largest: 0.0,
        largest_at: [0; 2],
        map: Vec::with_capacity(width * height),
    };
    for (y, row) in (0..).zip(rows) {
        flip.mean += row.sum;
        if row.largest > flip.largest {
            flip.largest = row.largest;
            flip.largest_at = [row.largest_at, y];
        }
        flip.map.extend(row.map);
    }
    flip.mean /= width as f64 * height as f64;
    Ok(flip)
}

/// A row of errors.
struct Row {
    sum: f64,
    largest: f64,
    largest_at: u32,
    map: Vec<u8>,
}

fn band_errors(
    expected: &Picture,
    actual: &Picture,
    known: Option<&Seen>,
    band: Range<usize>,
) -> Vec<Row> {
    let width = expected.width() as usize;
    let filters = &*FILTERS;
    let wanted = with_margins(&band);
    if are_equal(expected, actual, wanted.start, wanted.end) {
        let row = || row_of(&vec![0.0; width]);
        return band.map(|_| row()).collect();
    }
    let seen;
    let one = match known {
        Some(known) => known,
        None => {
            seen = filters.seen_of(expected, wanted.clone());
            &seen
        }
    };
    let other = filters.seen_of(actual, wanted);
    let errors: Vec<f64> = one
        .colours
        .iter()
        .zip(&other.colours)
        .zip(one.features.iter().zip(&other.features))
        .map(|((one, other), (this, that))| {
            let colour = filters.colour_error(*one, *other);
            if colour == 0.0 {
                return 0.0;
            }
            det::pow_f64(colour, 1.0 - feature_error(*this, *that))
        })
        .collect();
    errors.chunks_exact(width).map(row_of).collect()
}

fn row_of(errors: &[f64]) -> Row {
    let mut row = Row {
        sum: 0.0,
        largest: 0.0,
        largest_at: 0,
        map: Vec::with_capacity(errors.len()),
    };
    for (x, &error) in errors.iter().enumerate() {
        row.sum += error;
        if error > row.largest {
            (row.largest, row.largest_at) = (error, index_u32(x));
        }
        let byte = whole_u32(error * 255.0 + 0.5);
        row.map.push(u8::try_from(byte).unwrap_or(u8::MAX));
    }
    row
}

/// The rows that decide how those of a band are seen.
fn with_margins(band: &Range<usize>) -> Range<isize> {
    let margin = FILTERS.margin().cast_signed();
    band.start.cast_signed() - margin..band.end.cast_signed() + margin
}

/// A band of a picture as it is seen.
#[derive(Debug)]
struct Seen {
    /// L*, a*, b*, the latter two adjusted for Hunt's effect.
    colours: Vec<DVec3>,
    /// The strengths of edges and points.
    features: Vec<[f64; 2]>,
}

/// Everything that does not depend on pictures.
#[derive(Debug)]
struct Filters {
    /// Contrast sensitivity of each of Y, Cx, Cz: sums of Gaussians with their shares.
    contrast: [Vec<(f64, Kernel)>; 3],
    /// A Gaussian of half a feature's width, and its first and second derivatives.
    blur: Kernel,
    edge: Kernel,
    point: Kernel,
    from_xyz: DMat3,
    /// The largest compressed difference: from pure green to pure blue.
    largest: f64,
}

static FILTERS: LazyLock<Filters> = LazyLock::new(Filters::new);

/// Linear sRGB to XYZ, as the authors' program has it: for the primaries of
/// [SRGB](crate::references) and a white of X 0.950428, Z 1.088900.
const TO_XYZ: DMat3 = DMat3::from_cols_array(&[
    10_135_552.0 / 24_577_794.0,
    2_613_072.0 / 12_288_897.0,
    1_425_312.0 / 73_733_382.0,
    8_788_810.0 / 24_577_794.0,
    8_788_810.0 / 12_288_897.0,
    8_788_810.0 / 73_733_382.0,
    4_435_075.0 / 24_577_794.0,
    887_015.0 / 12_288_897.0,
    70_074_185.0 / 73_733_382.0,
]);

impl Filters {
    fn new() -> Self {
        // Of Y, Cx, Cz: pairs (a, b) of a √(π/b) exp(−π² x²/b), x in degrees; table 1.
        let terms: [&[[f64; 2]]; 3] = [
            &[[1.0, 0.0047]],
            &[[1.0, 0.0053]],
            &[[34.1, 0.04], [13.5, 0.025]],
        ];
        // Three standard deviations of the widest, b = 0.04, for all.
        let deviation = (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE;
        let radius = whole_u32((3.0 * deviation).ceil()) as usize;
        let contrast = terms.map(|terms| contrast_filter(terms, radius));

        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let variance = deviation * deviation;
        let radius = whole_u32((3.0 * deviation).ceil()) as usize;
        let gaussian = |x: f64| det::exp_f64(-x * x / (2.0 * variance));
        let mut filters = Self {
            contrast,
            blur: Kernel::new(radius, gaussian).normalized(),
            edge: Kernel::new(radius, |x| -x * gaussian(x)).normalized(),
            point: Kernel::new(radius, |x| (x * x / variance - 1.0) * gaussian(x)).normalized(),
            from_xyz: TO_XYZ.inverse(),
            largest: 1.0,
        };
        let [green, blue] = [DVec3::Y, DVec3::Z].map(|rgb| hunt(lab(TO_XYZ * rgb)));
        filters.largest = det::pow_f64(hyab(green, blue), COLOUR_EXPONENT);
        filters
    }

    /// How far the widest filter reaches.
    fn margin(&self) -> usize {
        let kernels = self.contrast.iter().flatten().map(|(_, kernel)| kernel);
        let radii = kernels.chain([&self.blur]).map(Kernel::radius);
        radii.max().unwrap_or(0)
    }

    /// What is seen of a band of a picture, given with its margins.
    fn seen_of(&self, picture: &Picture, rows: Range<isize>) -> Seen {
        self.seen(&seen_rows(picture, rows), picture.width() as usize)
    }

    /// What is seen of the pixels of a band and its margins.
    fn seen(&self, pixels: &[[u8; 3]], width: usize) -> Seen {
        let margin = self.margin();
        let mut planes = [const { Vec::new() }; 3];
        for plane in &mut planes {
            plane.reserve_exact(pixels.len());
        }
        for &bytes in pixels {
            let rgb = DVec3::from_array(bytes.map(linear));
            let opponent = to_opponent(TO_XYZ * rgb).to_array();
            for (plane, value) in planes.iter_mut().zip(opponent) {
                plane.push(value);
            }
        }
        let mut filtered = planes.iter().zip(&self.contrast).map(|(plane, filter)| {
            let mut sum = Vec::new();
            for (share, kernel) in filter {
                let rows = kernel.along_rows(plane, width);
                let part = kernel.along_columns(&rows, width, margin);
                if sum.is_empty() {
                    sum = vec![0.0; part.len()];
                }
                for (sum, part) in sum.iter_mut().zip(part) {
                    *sum += share * part;
                }
            }
            sum
        });
        let [y, cx, cz] = std::array::from_fn(|_| filtered.next().unwrap_or_default());
        // What is even, as skies are, is worked out once.
        let mut last = (DVec3::NAN, DVec3::NAN);
        let colour = |((&y, &cx), &cz): ((&f64, &f64), &f64)| {
            let opponent = DVec3::new(y, cx, cz);
            if opponent != last.0 {
                let rgb = self.from_xyz * from_opponent(opponent);
                let lab = lab(TO_XYZ * rgb.clamp(DVec3::ZERO, DVec3::ONE));
                last = (opponent, hunt(lab));
            }
            last.1
        };
        Seen {
            colours: y.iter().zip(&cx).zip(&cz).map(colour).collect(),
            features: self.features(&planes[0], width),
        }
    }

    /// Edges and points of the achromatic channel.
    fn features(&self, achromatic: &[f64], width: usize) -> Vec<[f64; 2]> {
        let margin = self.margin();
        let light: Vec<f64> = achromatic.iter().map(|y| (y + 16.0) / 116.0).collect();
        let blurred = self.blur.along_rows(&light, width);
        let strength = |derivative: &Kernel| -> Vec<f64> {
            let along = derivative.along_rows(&light, width);
            let across = self.blur.along_columns(&along, width, margin);
            let down = derivative.along_columns(&blurred, width, margin);
            let pairs = across.into_iter().zip(down);
            pairs.map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        let (edges, points) = (strength(&self.edge), strength(&self.point));
        let pairs = edges.into_iter().zip(points);
        pairs.map(|(edge, point)| [edge, point]).collect()
    }

    /// The difference of two colours on a scale of 0 to 1.
    fn colour_error(&self, one: DVec3, other: DVec3) -> f64 {
        let distance = hyab(one, other);
        if distance == 0.0 {
            return 0.0;
        }
        let compressed = det::pow_f64(distance, COLOUR_EXPONENT);
        let common = COMMON_SHARE * self.largest;
        if compressed < common {
            return COMMON_SCALE / common * compressed;
        }
        let rest = (compressed - common) / (self.largest - common);
        COMMON_SCALE + rest * (1.0 - COMMON_SCALE)
    }
}

/// The filter of one channel, normalized: along rows, then along columns, term by term.
fn contrast_filter(terms: &[[f64; 2]], radius: usize) -> Vec<(f64, Kernel)> {
    let parts: Vec<(f64, Kernel)> = terms
        .iter()
        .map(|&[a, b]| {
            let kernel = Kernel::new(radius, |place| {
                let degrees = place / PIXELS_PER_DEGREE;
                det::exp_f64(-PI * PI * degrees * degrees / b)
            });
            let sum = kernel.sum();
            (a * (PI / b).sqrt() * sum * sum, kernel.normalized())
        })
        .collect();
    let whole: f64 = parts.iter().map(|(weight, _)| weight).sum();
    let share = |(weight, kernel)| (weight / whole, kernel);
    parts.into_iter().map(share).collect()
}

/// The difference of features, on a scale of 0 to 1: `(ΔF / √2)^½`.
fn feature_error(one: [f64; 2], other: [f64; 2]) -> f64 {
    let edge = (one[0] - other[0]).abs();
    let point = (one[1] - other[1]).abs();
    (edge.max(point) / std::f64::consts::SQRT_2).sqrt()
}

/// White, relative to which colours are seen.
fn white() -> DVec3 {
    TO_XYZ * DVec3::ONE
}

/// XYZ to the linear opponent space Y, Cx, Cz.
fn to_opponent(xyz: DVec3) -> DVec3 {
    let DVec3 { x, y, z } = xyz / white();
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// And back.
fn from_opponent(opponent: DVec3) -> DVec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let xyz = DVec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0);
    xyz * white()
}

/// XYZ to L*a*b* (CIE 1976).
fn lab(xyz: DVec3) -> DVec3 {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |value: f64| {
        if value > DELTA * DELTA * DELTA {
            det::cbrt_f64(value)
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = (xyz / white()).to_array().map(root);
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Differences of hue show the less the darker it is.
fn hunt(lab: DVec3) -> DVec3 {
    let factor = 0.01 * lab.x;
    DVec3::new(lab.x, factor * lab.y, factor * lab.z)
}

/// A distance for large differences of colour: lightness, and hue and chroma, each for itself.
fn hyab(one: DVec3, other: DVec3) -> f64 {
    let DVec3 { x, y, z } = one - other;
    x.abs() + (y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, variant};
    use super::*;

    fn even(grey: u8) -> Picture {
        let rgba = [grey, grey, grey, 255].repeat(30);
        Picture::new(6, 5, rgba).expect("filled")
    }

    #[test]
    fn equal_pictures_cannot_be_told_apart() {
        let found = flip(&example(), &example()).unwrap();
        assert_eq!((found.mean, found.largest), (0.0, 0.0));
        assert_eq!(found.map, [0; 64 * 80]);
        assert!(flip(&example(), &even(0)).is_err());
    }

    #[test]
    fn even_greys_differ_by_their_lightness_alone() {
        // Black and white: HyAB is 100. The largest distance is 0.01 L* times a*, b*, as CIE 1976
        // has them for pure green and blue in sRGB.
        let lightness = [87.734_7_f64, 32.297_0];
        let [[a0, b0], [a1, b1]] = [[-86.182_7, 83.179_3], [79.187_5, -107.860_2]];
        let (a, b) = (
            0.01 * (lightness[0] * a0 - lightness[1] * a1),
            0.01 * (lightness[0] * b0 - lightness[1] * b1),
        );
        let largest = lightness[0] - lightness[1] + (a * a + b * b).sqrt();
        let [compressed, largest] = [100.0, largest].map(|distance| det::pow_f64(distance, 0.7));
        let wanted = 0.95 + 0.05 * (compressed - 0.4 * largest) / (0.6 * largest);
        let found = flip(&even(0), &even(255)).unwrap();
        assert!(
            (found.mean - wanted).abs() < 1e-5,
            "{} {wanted}",
            found.mean
        );
        let byte = whole_u32(wanted * 255.0 + 0.5);
        assert_eq!(found.map, [u8::try_from(byte).unwrap(); 30]);
    }

    #[test]
    fn a_reference_finds_what_two_pictures_do() {
        let reference = FlipReference::new(example());
        for name in ["offset", "noise", "one"] {
            let actual = variant(name);
            assert_eq!(reference.flip(&actual), flip(&example(), &actual), "{name}");
        }
        assert!(reference.flip(&even(0)).is_err());
    }

    #[test]
    fn either_may_be_the_one_expected() {
        let (one, other) = (example(), variant("noise"));
        assert_eq!(flip(&one, &other), flip(&other, &one));
    }

    /// flip-evaluator 1.7, `evaluate(…, "LDR", applyMagma=False)` in `f32`: mean, largest, where.
    #[test]
    fn values_are_those_of_the_authors_program() {
        for (name, mean, largest, largest_at) in [
            ("offset", 0.193_135_16, 0.237_007_26, [5, 4]),
            ("noise", 0.082_660_58, 0.273_810_21, [0, 0]),
            ("shift", 0.116_521_77, 0.573_287_84, [63, 79]),
            ("spots", 0.043_435_05, 0.964_381_64, [0, 0]),
            ("one", 0.001_237_68, 0.388_027_70, [20, 30]),
            ("inverse", 0.836_978_38, 0.981_178_58, [0, 79]),
        ] {
            let found = flip(&example(), &variant(name)).unwrap();
            assert!((found.mean - mean).abs() < 2e-6, "{name}: {}", found.mean);
            assert!(
                (found.largest - largest).abs() < 2e-6,
                "{name}: {}",
                found.largest
            );
            assert_eq!(found.largest_at, largest_at, "{name}");
        }
    }
}
