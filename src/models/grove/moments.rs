//! How much light reaches a depth, told from four power moments of what absorbs it
//! ([MKKP18](crate::references)).

use crate::math::{Vec4, det};

/// The most absorbance of a fragment: all but e⁻¹⁰ of the light.
const MOST_ABSORBED: f32 = 10.0;

/// How much moments are drawn to those of [`EVEN`], against rounding in `f32`
/// ([MKKP18](crate::references), section 3.2).
const BIAS: f32 = 5e-7;

/// The moments of something spread over all depths.
const EVEN: Vec4 = Vec4::new(0.0, 0.375, 0.0, 0.375);

/// Which of the bounds of the absorbance before a depth is taken: 0 the lower, 1 the upper.
const BETWEEN: f32 = 0.25;

/// The absorbance of a fragment, `−ln (1 − α)`.
pub(super) fn absorbance(alpha: f32) -> f32 {
    let absorbed = -det::log((1.0 - alpha).max(f32::MIN_POSITIVE));
    absorbed.clamp(0.0, MOST_ABSORBED)
}

/// A depth in metres on a logarithmic scale, −1 at the nearest and 1 at the farthest.
pub(super) fn warped(depth: f32, [nearest, farthest]: [f32; 2]) -> f32 {
    let along = det::log(depth.max(f32::MIN_POSITIVE) / nearest) / det::log(farthest / nearest);
    if along.is_nan() {
        return 0.0;
    }
    (2.0 * along - 1.0).clamp(-1.0, 1.0)
}

/// The first four powers of a depth.
pub(super) fn powers(depth: f32) -> Vec4 {
    let square = depth * depth;
    Vec4::new(depth, square, square * depth, square * square)
}

/// The share of light that reaches a depth past absorbances of the given sum and the given sums of powers
/// ([MKKP18](crate::references), algorithm 1: Hamburger's problem for four moments, by the factors of the
/// Hankel matrix `L D Lᵀ` of the moments).
pub(super) fn transmittance(absorbed: f32, sums: Vec4, depth: f32) -> f32 {
    if absorbed <= 0.0 {
        return 1.0;
    }
    let mean = sums / absorbed;
    let b = mean + (EVEN - mean) * BIAS;
    let d11 = b.y - b.x * b.x;
    let product = b.z - b.x * b.y;
    let l21 = product / d11;
    let d22 = (b.w - b.y * b.y) - product * l21;
    // The polynomial that is orthogonal: its roots and the depth bear all that absorbs.
    let mut c = [1.0, depth - b.x, depth * depth - b.y];
    c[2] -= l21 * c[1];
    c[1] /= d11;
    c[2] /= d22;
    c[1] -= l21 * c[2];
    c[0] -= c[1] * b.x + c[2] * b.y;
    let (p, q) = (c[1] / c[2], c[0] / c[2]);
    let root = (0.25 * p * p - q).max(0.0).sqrt();
    let roots = [-0.5 * p - root, -0.5 * p + root];
    // What is before the depth counts in full, what is at it in part, what is behind it not at all.
    let before = |root: f32| if root < depth { 1.0 } else { 0.0 };
    let [f0, f1, f2] = [BETWEEN, before(roots[0]), before(roots[1])];
    let f01 = (f1 - f0) / (roots[0] - depth);
    let f12 = (f2 - f1) / (roots[1] - roots[0]);
    let f012 = (f12 - f01) / (roots[1] - depth);
    // Newton's polynomial through the three, in powers of the depth; moments in place of powers.
    let linear = f01 - f012 * roots[0];
    let constant = f0 - linear * depth;
    let share = constant + (linear - f012 * depth) * b.x + f012 * b.y;
    let left = det::exp(-absorbed * share);
    if left.is_nan() {
        return 1.0;
    }
    left.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums(of: &[(f32, f32)]) -> (f32, Vec4) {
        let all = of.iter().map(|&(depth, absorbed)| powers(depth) * absorbed);
        let total = of.iter().map(|(_, absorbed)| *absorbed).sum();
        (total, all.fold(Vec4::ZERO, |sum, one| sum + one))
    }

    #[test]
    fn nothing_absorbs_nothing() {
        assert_eq!(
            transmittance(0.0, Vec4::ZERO, 0.3).to_bits(),
            1_f32.to_bits()
        );
        assert_eq!(absorbance(0.0).abs().to_bits(), 0);
        assert_eq!(absorbance(1.0).to_bits(), MOST_ABSORBED.to_bits());
    }

    /// Two layers far apart are what two roots can say: behind both almost all is absorbed, before both
    /// almost nothing, between them the first.
    #[test]
    fn two_layers_are_told_apart() {
        let (total, sums) = sums(&[(-0.5, 1.0), (0.5, 2.0)]);
        let light = |depth| transmittance(total, sums, depth);
        assert!(light(-0.9) > 0.95, "{}", light(-0.9));
        let between = light(0.0);
        assert!((between - det::exp(-1.0)).abs() < 0.03, "{between}");
        let behind = light(0.9);
        assert!((behind - det::exp(-3.0)).abs() < 0.01, "{behind}");
    }

    #[test]
    fn less_light_reaches_what_is_deeper() {
        let (total, sums) = sums(&[(-0.7, 0.4), (-0.2, 0.3), (0.1, 0.9), (0.6, 0.2)]);
        let mut last = 1.0;
        for step in -10_i8..=10 {
            let light = transmittance(total, sums, 0.1 * f32::from(step));
            assert!(
                (0.0..=last + 1e-3).contains(&light),
                "{step}: {light} after {last}"
            );
            last = light;
        }
    }

    #[test]
    fn depths_lie_between_the_nearest_and_the_farthest() {
        let range = [2.0, 32.0];
        let found = [1.0, 2.0, 8.0, 32.0, 99.0].map(|depth| warped(depth, range));
        for (found, wanted) in found.into_iter().zip([-1.0, -1.0, 0.0, 1.0, 1.0]) {
            assert!((found - wanted).abs() < 1e-6, "{found} of {wanted}");
        }
        assert!((-1.0..=1.0).contains(&warped(3.0, [1.0, 1.0])));
    }
}
