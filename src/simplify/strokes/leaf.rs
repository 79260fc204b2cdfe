//! One stroke for every leaf, of whatever kind.

use crate::math::{Vec3, index_u32};
use crate::plant::{Foliage, LeafGroup, Prototype, Stroke};

/// A stroke that stands for leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafStroke {
    /// Where it lies.
    pub stroke: Stroke,
    /// The foliage group whose leaves it stands for.
    pub group: u32,
    /// How many leaves it stands for.
    pub leaves: u32,
}

impl LeafStroke {
    /// Bytes of a leaf's stroke: the stroke, its group and its count, 4 bytes each.
    pub const STRIDE: u32 = Stroke::STRIDE + 8;
}

/// The strokes of all leaves, group by group: one each ([CQHCVL06](crate::references), section 3.2).
///
/// A quad leaf's stroke joins the middles of its base and tip and is as wide as the two on average; its
/// centre is the mean of its corners. A needle's is the needle. A leaf of several faces has one in the
/// direction of their areas together, from the lower part of its image to the upper, as long and wide as
/// its vertices reach.
#[must_use]
pub fn leaf_strokes(foliage: &Foliage) -> Vec<LeafStroke> {
    let mut strokes = Vec::with_capacity(foliage.leaf_count());
    for (number, group) in foliage.groups.iter().enumerate() {
        let leaves = (0..group.leaf_count()).map(|leaf| LeafStroke {
            stroke: stroke(group, group.leaf(leaf)),
            group: index_u32(number),
            leaves: 1,
        });
        strokes.extend(leaves);
    }
    strokes
}

fn stroke(group: &LeafGroup, vertices: &[Vec3]) -> Stroke {
    match (&group.prototype, vertices) {
        (Prototype::Quad { .. }, &[a, b, c, d]) => Stroke {
            center: 0.25 * ((a + b) + (c + d)),
            along: 0.25 * ((c - b) + (d - a)),
            across: 0.25 * ((b - a) + (c - d)),
        },
        (Prototype::Needle { diameter }, &[base, tip]) => {
            let along = 0.5 * (tip - base);
            Stroke {
                center: 0.5 * (base + tip),
                along,
                across: 0.5 * *diameter * along.normalize_or(Vec3::Y).any_orthonormal_vector(),
            }
        }
        (
            Prototype::Faces {
                texture_coordinates,
                triangles,
            },
            _,
        ) => {
            let downs = texture_coordinates.iter().map(|at| at.y);
            around(vertices, downs, triangles)
        }
        _ => Stroke {
            center: Vec3::ZERO,
            along: Vec3::ZERO,
            across: Vec3::ZERO,
        },
    }
}

/// The stroke around the vertices of a mesh; `downs` says how far down its image each vertex is.
fn around(
    vertices: &[Vec3],
    downs: impl Iterator<Item = f32> + Clone,
    triangles: &[[u32; 3]],
) -> Stroke {
    let count = vertices.len().max(1) as f32;
    let middle = vertices
        .iter()
        .fold(Vec3::ZERO, |sum, vertex| sum + *vertex)
        / count;
    let half_down = downs.clone().fold(0.0, |sum, down| sum + down) / count;
    let mut normal = Vec3::ZERO;
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
        normal += (b - a).cross(c - a);
    }
    let up = vertices
        .iter()
        .zip(downs)
        .fold(Vec3::ZERO, |sum, (vertex, down)| {
            sum + (half_down - down) * (*vertex - middle)
        });
    let normal = normal.normalize_or(Vec3::Z);
    let up = up - up.dot(normal) * normal;
    let up = up.normalize_or(normal.any_orthonormal_vector());
    let right = up.cross(normal);
    let reach = |axis: Vec3| {
        let along = vertices.iter().map(|vertex| (*vertex - middle).dot(axis));
        let low = along.clone().fold(f32::INFINITY, f32::min);
        let high = along.fold(f32::NEG_INFINITY, f32::max);
        if low <= high { [low, high] } else { [0.0; 2] }
    };
    let ([low, high], [left, beyond]) = (reach(up), reach(right));
    Stroke {
        center: middle + 0.5 * (low + high) * up + 0.5 * (left + beyond) * right,
        along: 0.5 * (high - low) * up,
        across: 0.5 * (beyond - left) * right,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::plant::Material;

    fn group(prototype: Prototype, positions: Vec<Vec3>) -> Foliage {
        Foliage {
            groups: vec![LeafGroup {
                name: "leaf".to_owned(),
                owners: vec![crate::plant::NO_BRANCH],
                prototype,
                material: Material::plain("leaf", [0.2; 3]),
                positions,
            }],
        }
    }

    /// Two by four, upright in the plane z = 1.
    const UPRIGHT: [Vec3; 4] = [
        Vec3::new(-1.0, 0.0, 1.0),
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::new(1.0, 4.0, 1.0),
        Vec3::new(-1.0, 4.0, 1.0),
    ];

    #[test]
    fn quads_and_meshes_of_the_same_form_have_the_same_stroke() {
        let wanted = Stroke {
            center: Vec3::new(0.0, 2.0, 1.0),
            along: Vec3::new(0.0, 2.0, 0.0),
            across: Vec3::new(1.0, 0.0, 0.0),
        };
        let quad = Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        };
        let faces = Prototype::Faces {
            texture_coordinates: Prototype::WHOLE_IMAGE.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        for prototype in [quad, faces] {
            let strokes = leaf_strokes(&group(prototype, UPRIGHT.to_vec()));
            assert_eq!(strokes.len(), 1);
            assert_eq!(strokes[0].stroke, wanted);
            assert_eq!(wanted.corners(), UPRIGHT);
            assert_eq!(
                wanted.normal(),
                Vec3::Z,
                "faces the side from which corners turn left"
            );
            assert!((wanted.area() - 8.0).abs() < 1e-6);
        }
    }

    #[test]
    fn needles_are_as_wide_as_they_are_thick_and_points_have_no_size() {
        let needle = Prototype::Needle { diameter: 0.5 };
        let found = leaf_strokes(&group(needle, vec![Vec3::ZERO, Vec3::X]))[0].stroke;
        assert_eq!((found.center, found.along), (0.5 * Vec3::X, 0.5 * Vec3::X));
        assert!((found.across.length() - 0.25).abs() < 1e-6 && found.across.dot(Vec3::X) == 0.0);
        let point = Prototype::Faces {
            texture_coordinates: vec![Vec2::ZERO; 3],
            triangles: vec![[0, 1, 2]],
        };
        let found = leaf_strokes(&group(point, vec![Vec3::ONE; 3]))[0].stroke;
        assert_eq!((found.center, found.area()), (Vec3::ONE, 0.0));
    }
}
