//! What clustering sees of a leaf: where it is, and which way it lies.

use crate::math::{DVec3, Vec3};
use crate::plant::{Foliage, LeafGroup, Prototype};

/// A leaf as clustering sees it: the pair `(nᵢ, pᵢ)` of [GSS05](crate::references), § 2.1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafSite {
    /// The centroid of its faces, in the plant's space, in metres; of its vertices where no face has
    /// an area.
    pub centre: Vec3,
    /// The average of its faces' normals, weighted by area, of unit length; zero where they cancel or
    /// no face has an area. A leaf without a normal is equally far from being parallel to all planes.
    pub normal: Vec3,
}

/// The sites of all leaves that have triangles, group by group in the foliage's order; needles have
/// none and are left out.
///
/// A leaf's *site number* is its place here: what planes, baking and flattening know it by.
#[must_use]
pub fn leaf_sites(foliage: &Foliage) -> Vec<LeafSite> {
    foliage.groups.iter().flat_map(sites_of_group).collect()
}

/// The two triangles of a quad leaf.
const QUAD_TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn sites_of_group(group: &LeafGroup) -> impl Iterator<Item = LeafSite> + '_ {
    let triangles: &[[u32; 3]] = match &group.prototype {
        Prototype::Quad { .. } => &QUAD_TRIANGLES,
        Prototype::Faces { triangles, .. } => triangles,
        Prototype::Needle { .. } => &[],
    };
    let count = if triangles.is_empty() {
        0
    } else {
        group.leaf_count()
    };
    (0..count).map(move |leaf| site(group.leaf(leaf), triangles))
}

fn site(vertices: &[Vec3], triangles: &[[u32; 3]]) -> LeafSite {
    // Around the first vertex, so that small leaves far from the origin keep their digits.
    let origin = vertices
        .first()
        .map_or(DVec3::ZERO, |first| first.as_dvec3());
    let at = |vertex: u32| vertices[vertex as usize].as_dvec3() - origin;
    let (mut area, mut moment, mut normal) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for &[a, b, c] in triangles {
        let [a, b, c] = [at(a), at(b), at(c)];
        let cross = (b - a).cross(c - a);
        let doubled = cross.length();
        area += doubled;
        moment += doubled * (a + b + c);
        normal += cross;
    }
    let mean = vertices.iter().fold(DVec3::ZERO, |sum, vertex| {
        sum + (vertex.as_dvec3() - origin)
    }) / vertices.len().max(1) as f64;
    let centre = if area > 0.0 {
        moment / (3.0 * area)
    } else {
        mean
    };
    LeafSite {
        centre: (origin + centre).as_vec3(),
        normal: unit_or_zero(normal, area).as_vec3(),
    }
}

/// A sum of vectors of `length` all together as a unit vector, or zero when hardly anything is left
/// of them: what remains of faces that cancel is rounding, not a direction.
fn unit_or_zero(sum: DVec3, length: f64) -> DVec3 {
    const LEAST_SHARE: f64 = 1e-6;
    let left = sum.length();
    if left > LEAST_SHARE * length {
        sum / left
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec2;
    use crate::plant::{Material, NO_BRANCH};

    fn group(prototype: Prototype, positions: Vec<Vec3>) -> LeafGroup {
        LeafGroup {
            name: "leaves".to_owned(),
            owners: vec![NO_BRANCH; positions.len() / prototype.vertices_per_leaf()],
            prototype,
            material: Material::plain("leaf", [0.1, 0.4, 0.1]),
            positions,
        }
    }

    fn quad() -> Prototype {
        Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        }
    }

    #[test]
    fn sites_are_numbered_through_groups_without_needles() {
        let square = |z: f32| {
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                .map(|(x, y)| Vec3::new(x, y, z))
                .to_vec()
        };
        // Two faces at a right angle, the second of twice the area:
        //      2
        //      │╲
        //  3───0──1      0-1-2 in the plane z = 0, 0-3-4 in y = 0, 4 at z = 2
        let faces = Prototype::Faces {
            texture_coordinates: vec![Vec2::ZERO; 5],
            triangles: vec![[0, 1, 2], [0, 3, 4]],
        };
        let [o, x, y] = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let foliage = Foliage {
            groups: vec![
                group(quad(), [square(0.0), square(3.0)].concat()),
                group(Prototype::Needle { diameter: 0.1 }, vec![o, x, o, y]),
                group(faces, vec![o, x, y, -x, 2.0 * Vec3::Z]),
            ],
        };
        let sites = leaf_sites(&foliage);
        assert_eq!(sites.len(), 3);
        assert_eq!(sites[1].centre, Vec3::new(0.5, 0.5, 3.0));
        assert_eq!(sites[1].normal, Vec3::Z);
        // Areas 1/2 and 1; normals +z and (−x) × 2z = 2y.
        let normal = Vec3::new(0.0, 2.0, 1.0).normalize();
        assert!((sites[2].normal - normal).length() < 1e-6, "{:?}", sites[2]);
        let centre = (Vec3::new(1.0, 1.0, 0.0) + 2.0 * Vec3::new(-1.0, 0.0, 2.0)) / 9.0;
        assert!((sites[2].centre - centre).length() < 1e-6, "{:?}", sites[2]);
    }

    #[test]
    fn leaves_without_area_have_a_centre_but_no_normal() {
        let line = [0.0, 1.0, 2.0, 5.0].map(|x| Vec3::new(x, 0.0, 0.0));
        let folded = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::X];
        let foliage = Foliage {
            groups: vec![group(quad(), [line, folded].concat())],
        };
        let sites = leaf_sites(&foliage);
        assert_eq!(sites[0].centre, Vec3::new(2.0, 0.0, 0.0));
        assert_eq!(sites[0].normal, Vec3::ZERO);
        // Folded flat: both faces have an area, and their normals cancel.
        let centre = Vec3::new(2.0 / 3.0, 1.0 / 3.0, 0.0);
        assert!((sites[1].centre - centre).length() < 1e-6, "{:?}", sites[1]);
        assert_eq!(sites[1].normal, Vec3::ZERO);
    }
}
