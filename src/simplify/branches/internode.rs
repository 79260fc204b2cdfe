//! The surface between two nodes: a ruled surface between two circles.

use super::skeletal::SkeletalVector;
use crate::math::{Vec3, det};

/// The wood between two nodes of a branch, next to each other or merged.
///
/// ```text
///    ╭──────────╮  u = 1
///   ╱     G'   ╱      every point of a circle is joined with the one at the same angle θ
///   ╰──────────╯
///     ╲      ╲
///     ╭──────────╮  u = 0
///    ╱     G    ╱
///    ╰──────────╯
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Internode {
    /// The end towards the base.
    pub start: SkeletalVector,
    /// The end towards the tip.
    pub end: SkeletalVector,
}

impl Internode {
    /// The branch equation ([ZBMJLDC17](crate::references), eq. 1), with `u` from 0 to 1 and `theta`
    /// in radians.
    #[must_use]
    pub fn point(&self, u: f32, theta: f32) -> Vec3 {
        let (sine, cosine) = det::sin_cos(theta);
        self.axis(u)
            + ((1.0 - u) * self.start.spoke(cosine, sine) + u * self.end.spoke(cosine, sine))
    }

    /// The point of the axis at `u`.
    #[must_use]
    pub fn axis(&self, u: f32) -> Vec3 {
        (1.0 - u) * self.start.position + u * self.end.position
    }

    /// The normal there (eq. A3, made a unit vector): the circles' own, blended. It is that of a
    /// cylinder: how the radius changes along the axis is not in it.
    #[must_use]
    pub fn normal(&self, u: f32, theta: f32) -> Vec3 {
        let (sine, cosine) = det::sin_cos(theta);
        let [start, end] = [self.start, self.end].map(|end| radial(&end, cosine, sine));
        ((1.0 - u) * start + u * end).normalize_or(start)
    }
}

/// The normal at a point of a node's circle (eq. A5), given cosine and sine of its angle.
#[must_use]
pub fn radial(node: &SkeletalVector, cosine: f32, sine: f32) -> Vec3 {
    (cosine * node.frame.normal + sine * node.frame.binormal).normalize_or(node.frame.normal)
}

#[cfg(test)]
mod tests {
    use super::super::frame::Frame;
    use super::*;

    #[test]
    fn a_cone_is_a_cone() {
        let node = |height: f32, radius: f32| SkeletalVector {
            position: Vec3::Y * height,
            radius,
            frame: Frame {
                tangent: Vec3::Y,
                normal: Vec3::Z,
                binormal: Vec3::X,
            },
        };
        let cone = Internode {
            start: node(1.0, 2.0),
            end: node(3.0, 1.0),
        };
        for (u, theta, wanted) in [
            (0.0, 0.0, Vec3::new(0.0, 1.0, 2.0)),
            (1.0, 0.0, Vec3::new(0.0, 3.0, 1.0)),
            (0.5, std::f32::consts::FRAC_PI_2, Vec3::new(1.5, 2.0, 0.0)),
        ] {
            assert!((cone.point(u, theta) - wanted).length() < 1e-6);
            let outwards = (wanted - cone.axis(u)).normalize_or_zero();
            assert!((cone.normal(u, theta) - outwards).length() < 1e-6);
        }
    }
}
