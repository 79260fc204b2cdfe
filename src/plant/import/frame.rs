//! From a file's coordinates to a plant's: which way is up, how long a unit is, where the base stands.

use super::{ImportReport, Reading, ReportKind};
use crate::document::choices;
use crate::math::{DVec3, Vec3};

choices! {
    /// The axis of a file that points up; both kinds are right-handed.
    UpAxis {
        /// +Y, as plants have it.
        Y = "y",
        /// +Z; a plant's x, y, z are the file's x, z, −y.
        Z = "z",
    }
}

choices! {
    /// The unit of a file's lengths.
    Unit {
        /// 1 m.
        M = "m",
        /// 0.01 m.
        Cm = "cm",
        /// 0.001 m.
        Mm = "mm",
    }
}

impl Unit {
    /// How many units a metre has.
    fn per_metre(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 100.0,
            Self::Mm => 1000.0,
        }
    }
}

/// The map from a file's space to the plant's: `plant = turn((file − base) / units per metre)`, rounded once.
///
/// Scanned trees stand hundreds of metres from the origin of their survey, where 32 bits hold no tenth of
/// a millimetre; their base is subtracted in 64 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plant) struct Frame {
    up: UpAxis,
    unit: Unit,
    base: DVec3,
}

impl Frame {
    /// A frame with its base at the file's own origin. `up` and `unit` are what the format has where
    /// the options do not say.
    pub(in crate::plant) fn new(reading: Reading, up: UpAxis, unit: Unit) -> Self {
        Self {
            up: reading.up.unwrap_or(up),
            unit: reading.unit.unwrap_or(unit),
            base: DVec3::ZERO,
        }
    }

    /// The same with another base, in the file's coordinates, which the report tells.
    pub(in crate::plant) fn with_base(
        self,
        base: DVec3,
        place: impl Into<String>,
        report: &mut ImportReport,
    ) -> Self {
        if base != DVec3::ZERO {
            let [x, y, z] = base.to_array();
            let unit = self.unit.name();
            let message = format!("the tree is moved to the origin from {x}, {y}, {z} {unit}");
            report.add(ReportKind::Moved, 1, place, message);
        }
        Self { base, ..self }
    }

    /// A point in the plant's space.
    pub(in crate::plant) fn point(&self, point: DVec3) -> Vec3 {
        self.rounded((point - self.base) / self.unit.per_metre())
    }

    /// A direction in the plant's space, as long as it was.
    pub(in crate::plant) fn direction(&self, direction: DVec3) -> Vec3 {
        self.rounded(direction)
    }

    /// How many of the file's units a metre has.
    pub(in crate::plant) fn per_metre(&self) -> f64 {
        self.unit.per_metre()
    }

    /// A length in metres.
    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    pub(in crate::plant) fn length(&self, length: f64) -> f32 {
        (length / self.unit.per_metre()) as f32
    }

    /// Which of a point's coordinates is its height.
    pub(in crate::plant) fn height(&self, point: DVec3) -> f64 {
        match self.up {
            UpAxis::Y => point.y,
            UpAxis::Z => point.z,
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    fn rounded(&self, v: DVec3) -> Vec3 {
        match self.up {
            UpAxis::Y => Vec3::new(v.x as f32, v.y as f32, v.z as f32),
            // Plus 0, so that no zero is negative.
            UpAxis::Z => Vec3::new(v.x as f32, v.z as f32, (0.0 - v.y) as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_far_away_keeps_its_tenths_of_millimetres() {
        let mut report = ImportReport::default();
        let frame = Frame::new(Reading::default(), UpAxis::Z, Unit::M);
        let base = DVec3::new(431_882.123, 5_412_345.25, 312.5);
        let frame = frame.with_base(base, "line 2", &mut report);
        let tip = frame.point(base + DVec3::new(0.0001, -0.0002, 20.0003));
        assert!(
            (tip - Vec3::new(0.0001, 20.0003, 0.0002)).length() < 2e-6,
            "{tip}"
        );
        assert_eq!(
            report.entries[0].to_string(),
            "moved: the tree is moved to the origin from 431882.123, 5412345.25, 312.5 m (at line 2)"
        );
    }

    #[test]
    fn what_the_user_says_beats_the_format() {
        let reading = Reading {
            format: None,
            up: Some(UpAxis::Y),
            unit: Some(Unit::Mm),
        };
        let frame = Frame::new(reading, UpAxis::Z, Unit::M);
        assert_eq!(
            frame.point(DVec3::new(1000.0, 2000.0, 500.0)),
            Vec3::new(1.0, 2.0, 0.5)
        );
        assert_eq!(frame.length(250.0), 0.25);
        assert_eq!(frame.height(DVec3::new(1.0, 2.0, 3.0)), 2.0);
    }
}
