//! Where a node puts its mesh.

use super::error::Fault;
use crate::math::{DMat3, DVec3, Vec3};
use gltf_json::Node;

/// An affine map from a mesh's space to world space, in double precision so that long chains of
/// nodes and far-away scenes do not blur the coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    linear: DMat3,
    translation: DVec3,
}

impl Placement {
    pub(super) const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        translation: DVec3::ZERO,
    };

    /// What a node says about its place relative to its parent.
    pub(super) fn of(node: &Node, index: usize) -> Result<Self, Fault> {
        let at = |field: &str| format!("/nodes/{index}/{field}");
        let finite = |field: &str, numbers: &[f32]| match numbers.iter().find(|n| !n.is_finite()) {
            Some(number) => {
                let message = format!("holds {number}, wanted finite numbers");
                Err(Fault::new(at(field), message))
            }
            None => Ok(()),
        };
        if let Some(matrix) = &node.matrix {
            finite("matrix", matrix)?;
            let m = matrix.map(f64::from);
            for (place, wanted) in [(3, 0.0), (7, 0.0), (11, 0.0), (15, 1.0)] {
                let off: f64 = m[place] - wanted;
                if off.abs() > 1e-6 {
                    return Err(Fault::new(
                        format!("{}/{place}", at("matrix")),
                        format!("{} in the last row, wanted {wanted}: not affine", m[place]),
                    ));
                }
            }
            return Ok(Self {
                linear: DMat3::from_cols(
                    DVec3::new(m[0], m[1], m[2]),
                    DVec3::new(m[4], m[5], m[6]),
                    DVec3::new(m[8], m[9], m[10]),
                ),
                translation: DVec3::new(m[12], m[13], m[14]),
            });
        }
        let scale = node.scale.unwrap_or([1.0; 3]);
        let rotation = node.rotation.unwrap_or_default().0;
        let translation = node.translation.unwrap_or([0.0; 3]);
        finite("scale", &scale)?;
        finite("rotation", &rotation)?;
        finite("translation", &translation)?;
        let Some(rotation) = rotation_matrix(rotation.map(f64::from)) else {
            return Err(Fault::new(
                at("rotation"),
                "a quaternion of length 0, wanted 1",
            ));
        };
        let [x, y, z] = scale.map(f64::from);
        Ok(Self {
            linear: DMat3::from_cols(
                rotation.x_axis * x,
                rotation.y_axis * y,
                rotation.z_axis * z,
            ),
            translation: DVec3::from_array(translation.map(f64::from)),
        })
    }

    /// The placement of a child whose place relative to this one is `local`.
    pub(super) fn child(&self, local: &Self) -> Self {
        Self {
            linear: self.linear * local.linear,
            translation: self.linear * local.translation + self.translation,
        }
    }

    /// A point in world space, in 64 bits; where nothing moves it is what it was.
    pub(super) fn point64(&self, point: Vec3) -> DVec3 {
        if *self == Self::IDENTITY {
            return point.as_dvec3();
        }
        self.linear * point.as_dvec3() + self.translation
    }

    /// Whether the map turns left hands into right hands, and so the winding of triangles.
    pub(super) fn mirrors(&self) -> bool {
        self.linear.determinant() < 0.0
    }

    /// The map for normals, up to their length: the inverse transpose times the determinant's
    /// absolute value, which exists even where the inverse does not.
    pub(super) fn normal_matrix(&self) -> DMat3 {
        let [x, y, z] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis];
        let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
        if self.mirrors() {
            -cofactors
        } else {
            cofactors
        }
    }
}

/// The rotation by a quaternion (x, y, z, w) of any length but 0.
fn rotation_matrix([x, y, z, w]: [f64; 4]) -> Option<DMat3> {
    let squared = x * x + y * y + z * z + w * w;
    if squared == 0.0 {
        return None;
    }
    let s = 2.0 / squared;
    Some(DMat3::from_cols(
        DVec3::new(
            1.0 - s * (y * y + z * z),
            s * (x * y + w * z),
            s * (x * z - w * y),
        ),
        DVec3::new(
            s * (x * y - w * z),
            1.0 - s * (x * x + z * z),
            s * (y * z + w * x),
        ),
        DVec3::new(
            s * (x * z + w * y),
            s * (y * z - w * x),
            1.0 - s * (x * x + y * y),
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use gltf_json::scene::UnitQuaternion;

    #[test]
    fn scale_then_turn_then_move() {
        let half = 0.5_f32.sqrt();
        let node = Node {
            scale: Some([2.0, 1.0, 1.0]),
            rotation: Some(UnitQuaternion([0.0, half, 0.0, half])),
            translation: Some([0.0, 10.0, 0.0]),
            ..Node::default()
        };
        let placement = Placement::of(&node, 0).unwrap();
        // A quarter turn about y takes +x to −z.
        let moved = placement.point64(Vec3::X);
        assert!(
            moved.distance(DVec3::new(0.0, 10.0, -2.0)) < 1e-6,
            "{moved}"
        );
        let twice = placement.child(&placement).point64(Vec3::ZERO);
        assert!(twice.distance(DVec3::new(0.0, 20.0, 0.0)) < 1e-6, "{twice}");
    }

    #[test]
    fn normals_stay_upright_on_what_is_squeezed_or_mirrored() {
        let node = Node {
            scale: Some([-1.0, 4.0, 1.0]),
            ..Node::default()
        };
        let placement = Placement::of(&node, 0).unwrap();
        assert!(placement.mirrors());
        // The plane x + y = 0 becomes −x + y / 4 = 0.
        let normal = (placement.normal_matrix() * DVec3::new(1.0, 1.0, 0.0)).normalize();
        let wanted = DVec3::new(-1.0, 0.25, 0.0).normalize();
        assert!(normal.distance(wanted) < 1e-12, "{normal}");
    }

    #[test]
    fn bad_numbers_are_named() {
        let node = Node {
            scale: Some([1.0, f32::INFINITY, 1.0]),
            ..Node::default()
        };
        assert_eq!(
            Placement::of(&node, 7).unwrap_err().pointer,
            "/nodes/7/scale"
        );
        let mut matrix = [0.0; 16];
        matrix[3] = 1.0;
        let node = Node {
            matrix: Some(matrix),
            ..Node::default()
        };
        assert_eq!(
            Placement::of(&node, 7).unwrap_err().pointer,
            "/nodes/7/matrix/3"
        );
    }
}
