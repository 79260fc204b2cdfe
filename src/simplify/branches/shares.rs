//! How one error is divided among the parts of the simplification.

/// The errors that control the parts, in metres ([ZBMJLDC17](crate::references), section 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchErrors {
    /// `ε`: the whole.
    pub epsilon: f32,
    /// `E1`: how far merging may move the axis.
    pub skeleton: f32,
    /// `E2`: how far merging may move what lies around the axis.
    pub radius: f32,
    /// `E3`: how far edges of a polygon may lie from their circle.
    pub polygon: f32,
    /// `E4`: how far a branch that is removed may reach from its bearer.
    pub topology: f32,
    /// `E5`: how far a needle may lie from those it stands for.
    pub needle: f32,
}

/// How `ε` becomes `E1` to `E5`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shares {
    /// All are `ε`, as in the paper: they add up to three times that, and more.
    Equal,
    /// A quarter each, a fifth where there are needles.
    ///
    /// What is left of a branch deviates by `E1 + E2 + E3` and what polygons add between their circles,
    /// what is removed by `E1 + E4`, needles by `E3 + E5`: so polygons may add a whole share before a
    /// level is farther off than `ε`.
    Honest,
}

impl Shares {
    /// The errors of a level.
    #[must_use]
    pub fn errors(self, epsilon: f32, has_needles: bool) -> BranchErrors {
        let epsilon = epsilon.max(0.0);
        let each = match (self, has_needles) {
            (Self::Equal, _) => epsilon,
            (Self::Honest, false) => epsilon / 4.0,
            (Self::Honest, true) => epsilon / 5.0,
        };
        BranchErrors {
            epsilon,
            skeleton: each,
            radius: each,
            polygon: each,
            topology: each,
            needle: each,
        }
    }
}

/// The error in metres that projects to `pixel_error` pixels (`δ`) at a distance, in metres, where a
/// metre one metre away is `focal_pixels` wide: `ε = δ d / f`.
///
/// The distance must be that to the *nearest* point of the tree, or less, or what is near is off by
/// more.
#[must_use]
pub fn permitted_error(pixel_error: f32, focal_pixels: f32, distance: f32) -> f32 {
    if focal_pixels > 0.0 {
        (pixel_error * distance / focal_pixels).max(0.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up() {
        let honest = Shares::Honest.errors(1.0, false);
        assert_eq!(
            honest.skeleton + honest.radius + honest.polygon + honest.topology,
            1.0
        );
        let needles = Shares::Honest.errors(1.0, true);
        assert_eq!((needles.needle, needles.epsilon), (0.2, 1.0));
        assert_eq!(Shares::Equal.errors(0.5, true).needle, 0.5);
        assert_eq!(Shares::Equal.errors(f32::NAN, true).needle, 0.0);
    }

    #[test]
    fn half_a_pixel_at_36_metres() {
        // 945 rows at 60°: 818.4 pixels; the paper's 0.092 cm would need 19,565.
        let error = permitted_error(0.5, 818.4, 36.0);
        assert!((error - 0.022).abs() < 1e-4, "{error}");
        assert_eq!(permitted_error(0.5, 0.0, 36.0), 0.0);
    }
}
