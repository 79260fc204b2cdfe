//! Where the viewer of a frame is, from the matrix that all programs have.

use crate::math::{DVec3, Mat4, Vec3};
use crate::models::Placement;

/// Where a frame is seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::models) enum Eye {
    /// From a point.
    At(Vec3),
    /// In parallel, from this direction: a unit vector towards the viewer.
    Towards(Vec3),
}

impl Eye {
    /// The eye of a projection, in the space that the matrix takes to clip space.
    ///
    /// It is what the rows of `x`, `y` and `w` all take to 0, which is found as their cross product in
    /// four dimensions: a point, or a direction where its last coordinate is 0, as it is to the bit
    /// where the row of `w` is (0, 0, 0, 1). Computed in `f64`.
    pub(in crate::models) fn of(clip: &Mat4) -> Self {
        let row = |row: usize| clip.row(row).as_dvec4();
        let (x, y, z, w) = (row(0), row(1), row(2), row(3));
        let (right, up, ahead) = (x.truncate(), y.truncate(), w.truncate());
        // The cofactors of the fourth row of a matrix with these three.
        let point = ahead.cross(up) * x.w + right.cross(ahead) * y.w + up.cross(right) * w.w;
        let scale = right.dot(up.cross(ahead));
        let eye = point / scale;
        if scale != 0.0 && eye.is_finite() {
            return Self::At(eye.as_vec3());
        }
        // Nearer is where depth is less.
        let toward = if z.truncate().dot(point) <= 0.0 {
            point
        } else {
            -point
        };
        Self::Towards(unit(toward))
    }

    /// The same in the space of a plant that stands there.
    pub(in crate::models) fn of_plant(self, placement: &Placement) -> Self {
        match self {
            Self::At(eye) => Self::At(placement.to_plant(eye)),
            Self::Towards(toward) => Self::Towards(placement.rotation.inverse() * toward),
        }
    }

    /// The unit vector from a point to the viewer; 0 where the viewer is there.
    pub(in crate::models) fn toward(self, point: Vec3) -> Vec3 {
        match self {
            Self::At(eye) => unit(eye.as_dvec3() - point.as_dvec3()),
            Self::Towards(toward) => toward,
        }
    }
}

fn unit(vector: DVec3) -> Vec3 {
    vector.normalize_or_zero().as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec4;

    /// A matrix of rows.
    fn rows(rows: [[f32; 4]; 4]) -> Mat4 {
        let [x, y, z, w] = rows.map(Vec4::from_array);
        Mat4::from_cols(x, y, z, w).transpose()
    }

    #[test]
    fn the_eye_of_a_perspective_is_a_point() {
        // Looks along −z from (3, −4, 5), twice as wide as high.
        let eye = Vec3::new(3.0, -4.0, 5.0);
        let clip = rows([
            [0.5, 0.0, 0.0, -1.5],
            [0.0, 1.0, 0.0, 4.0],
            [0.0, 0.0, -1.01, 4.9],
            [0.0, 0.0, -1.0, 5.0],
        ]);
        assert_eq!(Eye::of(&clip), Eye::At(eye));
        let turned = Placement {
            position: Vec3::new(1.0, 0.0, 0.0),
            rotation: crate::math::Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            scale: 2.0,
        };
        let Eye::At(seen) = Eye::of(&clip).of_plant(&turned) else {
            panic!("a point stays one");
        };
        assert!(seen.distance(Vec3::new(-1.0, -2.0, -2.5)) < 1e-6);
        assert_eq!(Eye::At(eye).toward(Vec3::new(3.0, -4.0, 1.0)), Vec3::Z);
        assert_eq!(Eye::At(eye).toward(eye), Vec3::ZERO);
    }

    #[test]
    fn the_eye_of_a_parallel_view_is_a_direction_to_where_depth_is_less() {
        let clip = |deep: f32| {
            rows([
                [0.5, 0.0, 0.0, 0.1],
                [0.0, 0.7, 0.0, 0.3],
                [0.0, 0.0, deep, 0.2],
                [0.0, 0.0, 0.0, 1.0],
            ])
        };
        assert_eq!(Eye::of(&clip(-0.3)), Eye::Towards(Vec3::Z));
        assert_eq!(Eye::of(&clip(0.3)), Eye::Towards(Vec3::NEG_Z));
        assert_eq!(Eye::of(&Mat4::ZERO), Eye::Towards(Vec3::ZERO));
    }
}
