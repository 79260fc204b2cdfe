//! Leaves of more than two faces: strips along the midrib, bent and folded.

use super::frame::Frame;
use crate::math::{Vec2, Vec3, det, index_u32};
use crate::plant::Prototype;

/// How a blade leaves its plane, in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// How far the tip's direction turns down from the base's.
    pub(super) droop: f32,
    /// How far each half rises across the midrib.
    pub(super) fold: f32,
}

/// How many pieces of four faces a blade has, and whether two faces more narrow to a point.
fn pieces(faces: u32) -> (u32, bool) {
    (faces / 4, faces % 4 >= 2)
}

/// What such leaves are made of: rows of three vertices (left, midrib, right) from the base on, then,
/// where it is pointed, the tip. The image lies upright on them, base at its bottom.
///
/// ```text
///      T          10 faces: two pieces of four, and the tip's two
///     /|\
///    L-M-R
///    |/|/|
///    L-M-R
///    |/|/|
///    L-M-R
/// ```
pub(super) fn bent_prototype(faces: u32) -> Prototype {
    let (pieces, pointed) = pieces(faces);
    let mut texture_coordinates = Vec::new();
    let mut triangles = Vec::new();
    for row in 0..=pieces {
        let down = 1.0 - share(row, pieces, pointed);
        texture_coordinates.extend([0.0, 0.5, 1.0].map(|across| Vec2::new(across, down)));
    }
    for row in 0..pieces {
        let [left, middle, right] = [0, 1, 2].map(|across| 3 * row + across);
        for [a, b] in [[left, middle], [middle, right]] {
            triangles.extend([[a, b, b + 3], [a, b + 3, a + 3]]);
        }
    }
    if pointed {
        let [left, middle, right] = [0, 1, 2].map(|across| 3 * pieces + across);
        let tip = index_u32(texture_coordinates.len());
        texture_coordinates.push(Vec2::new(0.5, 0.0));
        triangles.extend([[left, middle, tip], [middle, right, tip]]);
    }
    Prototype::Faces {
        texture_coordinates,
        triangles,
    }
}

/// How far along the blade a row lies, from 0 to 1.
fn share(row: u32, pieces: u32, pointed: bool) -> f32 {
    row as f32 / (pieces + u32::from(pointed)) as f32
}

/// Adds the vertices of a leaf of a length and half a width.
///
/// The midrib is a chain of straight pieces of equal length along an arc, so it is as long as the flat
/// leaf; each row is turned as the arc is there.
pub(super) fn bent_vertices(
    faces: u32,
    bend: Bend,
    base: Vec3,
    frame: Frame,
    [length, half]: [f32; 2],
    vertices: &mut Vec<Vec3>,
) {
    let (pieces, pointed) = pieces(faces);
    let steps = pieces + u32::from(pointed);
    let step = length / steps as f32;
    let normal = frame.normal();
    let (rise, across) = det::sin_cos(bend.fold.to_radians());
    let at = |along: f32| det::sin_cos((bend.droop * along).to_radians());
    let mut middle = base;
    for row in 0..=steps {
        if row == steps && pointed {
            vertices.push(middle);
            break;
        }
        let (sine, cosine) = at(share(row, pieces, pointed));
        let up = cosine * normal + sine * frame.heading;
        let beside = (half * across) * frame.side;
        let above = (half * rise) * up;
        vertices.extend([middle - beside + above, middle, middle + beside + above]);
        let (sine, cosine) = at((row as f32 + 0.5) / steps as f32);
        middle += step * (cosine * frame.heading - sine * normal);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf(faces: u32, bend: Bend) -> (Vec<Vec2>, Vec<[u32; 3]>, Vec<Vec3>) {
        let Prototype::Faces {
            texture_coordinates,
            triangles,
        } = bent_prototype(faces)
        else {
            panic!("leaves of {faces} faces are meshes");
        };
        let mut vertices = Vec::new();
        bent_vertices(
            faces,
            bend,
            Vec3::ZERO,
            Frame::UPRIGHT,
            [3.0, 0.5],
            &mut vertices,
        );
        (texture_coordinates, triangles, vertices)
    }

    #[test]
    fn a_leaf_has_the_faces_asked_for_and_lies_in_its_plane_unless_it_bends() {
        let none = Bend {
            droop: 0.0,
            fold: 0.0,
        };
        for faces in (4..=64).step_by(2) {
            let (coordinates, triangles, vertices) = leaf(faces, none);
            assert_eq!(triangles.len(), faces as usize);
            assert_eq!(coordinates.len(), vertices.len());
            let mut area = 0.0;
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
                let normal = (b - a).cross(c - a);
                assert!(normal.z > 0.0, "every face shows its front upwards");
                area += 0.5 * normal.length();
            }
            // A tip of two faces is a triangle: half of what the last piece would be.
            let pieces = (faces / 4) as f32;
            let wanted = if faces % 4 == 0 {
                3.0
            } else {
                3.0 * (pieces + 0.5) / (pieces + 1.0)
            };
            assert!(
                (area - wanted).abs() < 1e-4,
                "{faces} faces: {area}, wanted {wanted}"
            );
            // Flat, the image lies on it as on a quad.
            for (at, vertex) in coordinates.iter().zip(&vertices) {
                let wanted = Vec3::new(at.x - 0.5, 3.0 * (1.0 - at.y), 0.0);
                assert!(
                    (*vertex - wanted).length() < 1e-5,
                    "{vertex}, wanted {wanted}"
                );
            }
        }
    }

    #[test]
    fn ten_faces_bend_and_fold() {
        let bend = Bend {
            droop: 90.0,
            fold: 30.0,
        };
        let (_, _, vertices) = leaf(10, bend);
        // Left, midrib, right of the base: half a metre at 30 degrees.
        let across = 0.5 * 0.75_f32.sqrt();
        assert!((vertices[0] - Vec3::new(-across, 0.0, 0.25)).length() < 1e-6);
        assert_eq!(vertices[1], Vec3::ZERO);
        // Pieces of a metre at 15, 45 and 75 degrees down.
        let (sine, cosine): (Vec<f32>, Vec<f32>) = [15.0_f32, 45.0, 75.0]
            .map(|angle| det::sin_cos(angle.to_radians()))
            .into_iter()
            .unzip();
        let tip = Vec3::new(0.0, cosine.iter().sum(), -sine.iter().sum::<f32>());
        assert!((vertices[9] - tip).length() < 1e-5, "{}", vertices[9]);
        // At the second row the arc has turned by 30 degrees, and the halves rise from there.
        let up = vertices[3] + vertices[5] - 2.0 * vertices[4];
        let wanted = Vec3::new(0.0, 0.5, 0.75_f32.sqrt());
        assert!((up.normalize() - wanted).length() < 1e-5, "{up}");
    }
}
