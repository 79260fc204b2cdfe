//! Where a stem points: a local frame that rolls, pitches and turns.

use crate::math::{Vec3, det};

/// A right-handed orthonormal frame: `side × heading = normal`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plant) struct Frame {
    /// The axis about which the frame pitches; a leaf's right.
    pub(in crate::plant) side: Vec3,
    /// The direction of growth.
    pub(in crate::plant) heading: Vec3,
}

impl Frame {
    /// Straight up.
    pub(in crate::plant) const UPRIGHT: Self = Self {
        side: Vec3::X,
        heading: Vec3::Y,
    };

    /// The third axis; a leaf's upper face.
    pub(in crate::plant) fn normal(self) -> Vec3 {
        self.side.cross(self.heading)
    }

    /// Turned about its heading, in degrees.
    pub(in crate::plant) fn roll(self, degrees: f32) -> Self {
        let (sine, cosine) = det::sin_cos(degrees.to_radians());
        Self {
            side: cosine * self.side - sine * self.normal(),
            heading: self.heading,
        }
        .orthonormal()
    }

    /// Tipped towards its normal, in degrees.
    pub(in crate::plant) fn pitch(self, degrees: f32) -> Self {
        let (sine, cosine) = det::sin_cos(degrees.to_radians());
        Self {
            side: self.side,
            heading: cosine * self.heading + sine * self.normal(),
        }
        .orthonormal()
    }

    /// Turned about its normal, in degrees, its heading towards its side.
    pub(in crate::plant) fn yaw(self, degrees: f32) -> Self {
        let (sine, cosine) = det::sin_cos(degrees.to_radians());
        Self {
            side: cosine * self.side - sine * self.heading,
            heading: cosine * self.heading + sine * self.side,
        }
        .orthonormal()
    }

    /// Turned about an axis of length 1 of the world, in degrees, counter-clockwise seen against
    /// the axis.
    pub(in crate::plant) fn about(self, axis: Vec3, degrees: f32) -> Self {
        let (sine, cosine) = det::sin_cos(degrees.to_radians());
        let turn =
            |v: Vec3| cosine * v + sine * axis.cross(v) + (1.0 - cosine) * axis.dot(v) * axis;
        Self {
            side: turn(self.side),
            heading: turn(self.heading),
        }
        .orthonormal()
    }

    /// Bent towards the vertical: up by the given angle in degrees, below 0 down; a vertical
    /// heading stays.
    pub(in crate::plant) fn lift(self, degrees: f32) -> Self {
        let axis = self.heading.cross(Vec3::Y);
        let length = axis.length();
        if length > 1e-4 {
            self.about(axis / length, degrees)
        } else {
            self
        }
    }

    /// The angle between heading and +Y in degrees, 0 to 180.
    pub(in crate::plant) fn declination(self) -> f32 {
        det::acos(self.heading.y.clamp(-1.0, 1.0)).to_degrees()
    }

    /// Takes rounding out. The axes are never near parallel here, since every turn is a rotation.
    fn orthonormal(self) -> Self {
        let heading = self.heading.normalize_or(Vec3::Y);
        let side = (self.side - self.side.dot(heading) * heading).normalize_or(Vec3::X);
        Self { side, heading }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Vec3, b: Vec3) -> bool {
        a.distance(b) < 1e-6
    }

    #[test]
    fn quarter_turns_land_on_the_axes() {
        let up = Frame::UPRIGHT;
        assert!(near(up.normal(), Vec3::Z));
        assert!(near(up.pitch(90.0).heading, Vec3::Z));
        assert!(near(up.roll(90.0).side, -Vec3::Z));
        assert!(near(up.yaw(90.0).heading, Vec3::X));
        assert!(near(up.about(Vec3::X, 90.0).heading, Vec3::Z));
        assert!((up.pitch(30.0).declination() - 30.0).abs() < 1e-3);
    }

    #[test]
    fn lifting_goes_up_and_leaves_the_vertical_alone() {
        let flat = Frame::UPRIGHT.pitch(90.0);
        assert!((flat.lift(20.0).declination() - 70.0).abs() < 1e-3);
        assert!((flat.lift(-20.0).declination() - 110.0).abs() < 1e-3);
        assert_eq!(Frame::UPRIGHT.lift(20.0), Frame::UPRIGHT);
    }
}
