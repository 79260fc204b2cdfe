//! The closed formulas of Weber and Penn ([WP95](crate::references)): shape, taper, flare, angles.

use super::frame::Frame;
use crate::math::det;
use crate::plant::{Crown, Pruning, Shape, StemLevel};

/// `ShapeRatio`: how long a stem is, by where it sits; `ratio` is 1 at the crown's base and 0 at
/// its top ([WP95](crate::references), section 4.3).
///
/// Conical follows the ratio itself, as every known implementation does. Below its peak the paper
/// divides the envelope by `1 − PruneWidthPeak` too, which makes a step there unless the peak is at
/// one half; dividing by `PruneWidthPeak` closes it.
pub(super) fn shape_ratio(shape: Shape, ratio: f32, pruning: &Pruning) -> f32 {
    let r = ratio.clamp(0.0, 1.0);
    let flame = || if r <= 0.7 { r / 0.7 } else { (1.0 - r) / 0.3 };
    match shape {
        Shape::Conical => 0.2 + 0.8 * r,
        Shape::Spherical => 0.2 + 0.8 * det::sin(std::f32::consts::PI * r),
        Shape::Hemispherical => 0.2 + 0.8 * det::sin(0.5 * std::f32::consts::PI * r),
        Shape::Cylindrical => 1.0,
        Shape::TaperedCylindrical => 0.5 + 0.5 * r,
        Shape::Flame => flame(),
        Shape::InverseConical => 1.0 - 0.8 * r,
        Shape::TendFlame => 0.5 + 0.5 * flame(),
        Shape::Envelope => {
            let below_top = 1.0 - pruning.width_peak;
            if r < below_top {
                det::pow(r / below_top, pruning.power_high)
            } else if pruning.width_peak > 0.0 {
                det::pow((1.0 - r) / pruning.width_peak, pruning.power_low)
            } else {
                1.0
            }
        }
    }
}

/// The radius of a stem at `z` of its length (0 base, 1 tip), with `radius` at its base
/// ([WP95](crate::references), section 4.4: cone, rounded end, periodic bulges).
pub(super) fn taper_radius(taper: f32, z: f32, radius: f32, length: f32) -> f32 {
    let unit = if taper < 1.0 {
        taper
    } else if taper < 2.0 {
        2.0 - taper
    } else {
        0.0
    };
    let cone = radius * (1.0 - unit * z);
    if taper <= 1.0 || cone <= 0.0 {
        return cone.max(0.0);
    }
    let to_tip = (1.0 - z) * length;
    let depth = if taper < 2.0 || to_tip < cone {
        1.0
    } else {
        taper - 2.0
    };
    let in_bulge = if taper < 2.0 {
        to_tip
    } else {
        (to_tip - 2.0 * cone * (to_tip / (2.0 * cone) + 0.5).floor()).abs()
    };
    if taper < 2.0 && in_bulge >= cone {
        return cone;
    }
    let across = in_bulge - cone;
    let round = (cone * cone - across * across).max(0.0).sqrt();
    (1.0 - depth) * cone + depth * round
}

/// The factor by which the trunk is wider at `z` of its length ([WP95](crate::references), 4.4).
pub(super) fn flare_factor(flare: f32, z: f32) -> f32 {
    let y = (1.0 - 8.0 * z).max(0.0);
    1.0 + flare * (det::pow(100.0, y) - 1.0) / 100.0
}

/// The length of a stem at `offset` on its parent, before pruning ([WP95](crate::references), 4.3).
///
/// `level` is the new stem's; `share` its `nLength ± nLengthV`; `base` the trunk's bare part in
/// metres.
pub(super) fn stem_length(
    crown: &Crown,
    level: usize,
    share: f32,
    parent_length: f32,
    offset: f32,
    base: f32,
) -> f32 {
    if level == 1 {
        let ratio = (parent_length - offset) / (parent_length - base).max(1e-6);
        parent_length * share * shape_ratio(crown.shape, ratio, &crown.pruning)
    } else {
        share * (parent_length - 0.6 * offset).max(0.0)
    }
}

/// The radius at the base of a stem, by its share of its parent's length.
pub(super) fn stem_radius(parent_radius: f32, share: f32, power: f32) -> f32 {
    parent_radius * det::pow(share.max(0.0), power)
}

/// The angle between parent and stem in degrees; `signed` is a draw from [-1, 1), `z` the offset
/// as a share of the parent's length above its bare base.
pub(super) fn down_angle(level: &StemLevel, signed: f32, z: f32) -> f32 {
    let variation = level.down_angle_v;
    if variation >= 0.0 {
        level.down_angle + signed * variation
    } else {
        let conical = 0.2 + 0.8 * (1.0 - z).clamp(0.0, 1.0);
        level.down_angle + variation * (1.0 - 2.0 * conical)
    }
}

/// The bend between two segments in degrees, from `segment` of a stem to the next; `signed` is a
/// draw from [-1, 1). A helix (`curve_v` below 0) bends by other means.
pub(super) fn segment_curve(level: &StemLevel, segment: u32, signed: f32) -> f32 {
    let segments = level.curve_res as f32;
    let even = if level.curve_back == 0.0 {
        level.curve / segments
    } else if 2 * segment < level.curve_res {
        2.0 * level.curve / segments
    } else {
        2.0 * level.curve_back / segments
    };
    even + signed * level.curve_v.max(0.0) / segments
}

/// The angle around the parent, in degrees, of stems that alternate sides: `nRotate` below 0.
pub(super) fn alternate(even: bool, rotate: f32) -> f32 {
    if even {
        180.0 + rotate
    } else {
        -180.0 - rotate
    }
}

/// A frame bent up, below 0 down: by its declination times `pull`, never past the vertical
/// (Arbaro's form, which unlike the paper's ends there).
pub(super) fn lifted(frame: Frame, pull: f32) -> Frame {
    if pull == 0.0 {
        return frame;
    }
    let declination = frame.declination();
    let degrees = pull * declination * det::sin(declination.to_radians());
    frame.lift(degrees.clamp(declination - 180.0, declination))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRUNING: Pruning = Pruning {
        ratio: 0.0,
        width: 0.5,
        width_peak: 0.6,
        power_low: 0.5,
        power_high: 2.0,
    };

    #[test]
    fn shapes_have_the_papers_values() {
        let cases = [
            (Shape::Conical, [0.2, 0.6, 1.0]),
            (Shape::Spherical, [0.2, 1.0, 0.2]),
            (Shape::Hemispherical, [0.2, 0.765_685, 1.0]),
            (Shape::Cylindrical, [1.0, 1.0, 1.0]),
            (Shape::TaperedCylindrical, [0.5, 0.75, 1.0]),
            (Shape::Flame, [0.0, 0.714_286, 0.0]),
            (Shape::InverseConical, [1.0, 0.6, 0.2]),
            (Shape::TendFlame, [0.5, 0.857_143, 0.5]),
            // 0.5 is below the peak (seen from the base): ((1 − 0.5) / 0.6) ^ 0.5.
            (Shape::Envelope, [0.0, 0.912_871, 0.0]),
        ];
        for (shape, wanted) in cases {
            for (ratio, wanted) in [0.0, 0.5, 1.0].into_iter().zip(wanted) {
                let found = shape_ratio(shape, ratio, &PRUNING);
                assert!((found - wanted).abs() < 1e-5, "{shape:?} {ratio}: {found}");
            }
        }
        assert!((shape_ratio(Shape::Flame, 0.7, &PRUNING) - 1.0).abs() < 1e-6);
        assert!((shape_ratio(Shape::Envelope, 0.2, &PRUNING) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn tapers_are_cylinder_cone_dome_and_bulges() {
        let at = |taper, z| taper_radius(taper, z, 1.0, 10.0);
        assert_eq!([at(0.0, 0.5), at(0.0, 1.0)], [1.0, 1.0]);
        assert_eq!([at(1.0, 0.0), at(1.0, 0.5), at(1.0, 1.0)], [1.0, 0.5, 0.0]);
        // A rod with a hemisphere: full until one radius before the tip, then √(1 − x²).
        assert_eq!([at(1.999_999, 0.5), at(1.999_999, 1.0)], [1.0 - 5e-7, 0.0]);
        assert!((at(1.999_999, 0.95) - 0.75_f32.sqrt()).abs() < 1e-3);
        // Bulges one diameter apart: at a metre from the tip the first one is widest.
        assert!((at(3.0, 0.9) - 1.0).abs() < 1e-4 && at(3.0, 0.8) < 1e-2);
    }

    #[test]
    fn flare_ends_at_an_eighth() {
        assert!((flare_factor(0.6, 0.0) - 1.594).abs() < 1e-4);
        assert_eq!(flare_factor(0.6, 0.125), 1.0);
        assert_eq!(flare_factor(0.0, 0.0), 1.0);
    }
}
