//! How a line catches light: as the cylinder that it stands for.

use crate::math::{Mat4, Vec3, Vec4, det};

/// Where the viewer is, up to a factor: the point that a projection maps to no place, at infinity for a
/// parallel one.
///
/// It solves `x = y = w = 0` for the rows of the matrix, by Cramer's rule without the division.
#[derive(Debug, Clone, Copy)]
pub(in crate::models) struct Viewer {
    point: Vec3,
    weight: f32,
    /// Away from the viewer.
    depth: Vec3,
}

impl Viewer {
    pub(in crate::models) fn of(clip: &Mat4) -> Self {
        let row = |row: usize| clip.row(row);
        let [x, y, z, w] = [0, 1, 2, 3].map(row);
        let [nx, ny, nw] = [x, y, w].map(Vec4::truncate);
        let across = nx.cross(ny);
        Self {
            point: -(x.w * ny.cross(nw) + y.w * nw.cross(nx) + w.w * across),
            weight: across.dot(nw),
            depth: z.truncate(),
        }
    }

    /// From a point towards the viewer; not a unit vector.
    fn toward(self, point: Vec3) -> Vec3 {
        let way = self.point - self.weight * point;
        if way.dot(self.depth) > 0.0 { -way } else { way }
    }

    /// The mean over the side of a cylinder that is seen of the cosine to the light, 0 where it faces away, a
    /// normal weighed by how wide its strip looks: what a prism of many edges shows.
    ///
    /// With `m` the sine between axis and light, and `γ` the angle about the axis between the ways to the
    /// viewer and to the light: `½ ∫ cos φ · m max(0, cos(φ − γ)) dφ = m/4 ((π − γ) cos γ + sin γ)`.
    pub(in crate::models) fn light_on_cylinder(
        self,
        point: Vec3,
        axis: Vec3,
        to_light: Vec3,
    ) -> f32 {
        let axis = axis.normalize_or_zero();
        let across = |way: Vec3| way - way.dot(axis) * axis;
        let seen = across(self.toward(point)).normalize_or_zero();
        let lit = across(to_light);
        let sine = lit.length();
        if sine < 1e-6 {
            return 0.0;
        }
        let cosine = (seen.dot(lit) / sine).clamp(-1.0, 1.0);
        let angle = det::acos(cosine);
        let opposite = (1.0 - cosine * cosine).max(0.0).sqrt();
        0.25 * sine * ((std::f32::consts::PI - angle) * cosine + opposite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cylinder_is_as_bright_as_its_strips() {
        let eye = Vec3::new(1.0, 2.0, 9.0);
        // Looks along −z, and turned about y.
        let perspective = Mat4::from_cols_array_2d(&[
            [1.5, 0.0, 0.0, 0.0],
            [0.0, 2.0, 0.0, 0.0],
            [0.0, 0.0, -1.001, -1.0],
            [0.0, 0.0, -0.1, 0.0],
        ]);
        let view = Mat4::from_rotation_y(0.2) * Mat4::from_translation(-eye);
        let viewer = Viewer::of(&(perspective * view));
        let point = Vec3::new(0.3, -0.2, 0.5);
        let axis = Vec3::new(0.2, 1.0, -0.3).normalize();
        for light in [
            Vec3::new(0.6, 0.8, 0.0),
            Vec3::new(0.0, 0.6, -0.8),
            Vec3::new(-1.0, 0.0, 0.0),
            axis,
        ] {
            let found = viewer.light_on_cylinder(point, axis, light);
            let to_eye = (eye - point) - (eye - point).dot(axis) * axis;
            let to_eye = to_eye.normalize();
            let side = axis.cross(to_eye);
            let (mut sum, mut width) = (0.0, 0.0);
            for strip in -999_i16..=999 {
                let (sine, cosine) = det::sin_cos(f32::from(strip) * 0.001 * 1.570_796_4);
                let normal = cosine * to_eye + sine * side;
                sum += cosine * normal.dot(light).max(0.0);
                width += cosine;
            }
            assert!(
                (found - sum / width).abs() < 1e-3,
                "{found} {}",
                sum / width
            );
        }
    }

    #[test]
    fn parallel_views_look_along_their_depth() {
        let clip = Mat4::from_scale(Vec3::new(0.7, 0.7, 0.3));
        let viewer = Viewer::of(&clip);
        let toward = viewer.toward(Vec3::new(3.0, 4.0, 5.0)).normalize();
        assert!((toward + Vec3::Z).length() < 1e-6, "{toward}");
    }
}
