//! The leaves of a plant as triangles: what cards are baked from.

use std::ops::Range;

use crate::math::{Vec2, Vec3, index_u32};
use crate::plant::{Foliage, LeafGroup, Material, Prototype};

/// The triangles of all leaves that have some, by *leaf site*: quads and leaves of several faces are
/// numbered group by group in the order of [`Foliage::groups`]; needles are lines and have no number.
#[derive(Debug, Clone)]
pub(super) struct LeafTriangles {
    triangles: Vec<LeafTriangle>,
    /// The first triangle of each site, and one past the last of all.
    first_of_site: Vec<u32>,
    groups: Vec<TriangleGroup>,
}

/// A triangle of a leaf.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeafTriangle {
    /// The corners, in the plant's space.
    pub(super) positions: [Vec3; 3],
    /// Their texture coordinates.
    pub(super) coordinates: [Vec2; 3],
    /// The unit normal by which it is lit, on the side that is seen counter-clockwise: of a quad the
    /// normalised cross product of its diagonals, the same for both triangles; of a face its own. Zero
    /// where there is no area.
    pub(super) normal: Vec3,
    /// Its group among [`LeafTriangles::groups`].
    pub(super) group: u32,
}

/// The leaf sites of one foliage group.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TriangleGroup {
    /// What they look like.
    pub(super) material: Material,
    /// Their numbers.
    pub(super) sites: Range<u32>,
}

impl LeafTriangles {
    /// Of all leaves of a plant.
    pub(super) fn of(foliage: &Foliage) -> Self {
        let mut all = Self {
            triangles: Vec::new(),
            first_of_site: vec![0],
            groups: Vec::new(),
        };
        for group in &foliage.groups {
            let first = all.site_count();
            match &group.prototype {
                Prototype::Quad { texture_corners } => all.add_quads(group, texture_corners),
                Prototype::Faces {
                    texture_coordinates,
                    triangles,
                } => all.add_faces(group, texture_coordinates, triangles),
                Prototype::Needle { .. } => continue,
            }
            all.groups.push(TriangleGroup {
                material: group.material.clone(),
                sites: first..all.site_count(),
            });
        }
        all
    }

    /// How many sites there are.
    pub(super) fn site_count(&self) -> u32 {
        index_u32(self.first_of_site.len() - 1)
    }

    /// The groups, in order, their sites one after another.
    pub(super) fn groups(&self) -> &[TriangleGroup] {
        &self.groups
    }

    /// The triangles of all sites, in order.
    pub(super) fn all(&self) -> &[LeafTriangle] {
        &self.triangles
    }

    /// The numbers of the triangles of consecutive sites.
    pub(super) fn range(&self, sites: Range<u32>) -> Range<u32> {
        self.first_of_site[sites.start as usize]..self.first_of_site[sites.end as usize]
    }

    /// The triangles of one site.
    pub(super) fn of_site(&self, site: u32) -> &[LeafTriangle] {
        let Range { start, end } = self.range(site..site + 1);
        &self.triangles[start as usize..end as usize]
    }

    /// The corners of all triangles of some sites, once a triangle.
    pub(super) fn corners<'a>(
        &'a self,
        sites: impl IntoIterator<Item = u32> + 'a,
    ) -> impl Iterator<Item = Vec3> + 'a {
        let triangles = sites.into_iter().flat_map(|site| self.of_site(site));
        triangles.flat_map(|triangle| triangle.positions)
    }

    fn add_quads(&mut self, group: &LeafGroup, coordinates: &[Vec2; 4]) {
        let number = index_u32(self.groups.len());
        for corners in group.positions.as_chunks::<4>().0 {
            let normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
            let normal = normal.normalize_or_zero();
            for roles in [[0, 1, 2], [0, 2, 3]] {
                self.triangles.push(LeafTriangle {
                    positions: roles.map(|role| corners[role]),
                    coordinates: roles.map(|role| coordinates[role]),
                    normal,
                    group: number,
                });
            }
            self.end_site();
        }
    }

    fn add_faces(&mut self, group: &LeafGroup, coordinates: &[Vec2], faces: &[[u32; 3]]) {
        let number = index_u32(self.groups.len());
        for leaf in 0..group.leaf_count() {
            let vertices = group.leaf(leaf);
            for face in faces {
                let positions = face.map(|vertex| vertices[vertex as usize]);
                let [a, b, c] = positions;
                self.triangles.push(LeafTriangle {
                    positions,
                    coordinates: face.map(|vertex| coordinates[vertex as usize]),
                    normal: (b - a).cross(c - a).normalize_or_zero(),
                    group: number,
                });
            }
            self.end_site();
        }
    }

    fn end_site(&mut self) {
        self.first_of_site.push(index_u32(self.triangles.len()));
    }
}

#[cfg(test)]
pub(super) mod examples {
    //! Foliage of a few leaves.

    use super::*;
    use crate::plant::NO_BRANCH;

    /// A group of leaves of one colour, without a texture.
    pub(in crate::models::cards) fn group(
        prototype: Prototype,
        color: [f32; 3],
        positions: Vec<Vec3>,
    ) -> LeafGroup {
        let leaves = positions.len() / prototype.vertices_per_leaf();
        LeafGroup {
            name: "leaves".to_owned(),
            prototype,
            material: Material::plain("leaf", color),
            positions,
            owners: vec![NO_BRANCH; leaves],
        }
    }

    /// An upright square around a point that faces +Z.
    pub(in crate::models::cards) fn square(centre: Vec3, side: f32) -> [Vec3; 4] {
        let at = |x: f32, y: f32| centre + 0.5 * side * Vec3::new(x, y, 0.0);
        [at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]
    }

    /// Squares of one colour.
    pub(in crate::models::cards) fn squares(color: [f32; 3], places: &[(Vec3, f32)]) -> LeafGroup {
        let positions = places
            .iter()
            .flat_map(|(centre, side)| square(*centre, *side));
        let prototype = Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        };
        group(prototype, color, positions.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::examples::{group, squares};
    use super::*;

    #[test]
    fn sites_count_through_all_groups_but_needles() {
        let needles = Prototype::Needle { diameter: 0.001 };
        // A tent: two faces that share an edge, each with a normal of its own.
        let tent = Prototype::Faces {
            texture_coordinates: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
            triangles: vec![[0, 1, 2], [1, 3, 2]],
        };
        let [o, x, y, corner] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(1.0, 1.0, -1.0)];
        let foliage = Foliage {
            groups: vec![
                squares([1.0; 3], &[(Vec3::ZERO, 1.0), (Vec3::Z, 2.0)]),
                group(needles, [1.0; 3], vec![o, x]),
                group(tent, [0.5; 3], vec![o, x, y, corner]),
            ],
        };
        let all = LeafTriangles::of(&foliage);
        assert_eq!((all.site_count(), all.all().len()), (3, 6));
        let sites: Vec<_> = all
            .groups()
            .iter()
            .map(|group| group.sites.clone())
            .collect();
        assert_eq!(sites, [0..2, 2..3]);
        assert_eq!(all.range(1..3), 2..6);
        assert!(all.of_site(1).iter().all(|leaf| leaf.normal == Vec3::Z));
        let [front, back] = all.of_site(2) else {
            panic!("a tent has two faces");
        };
        assert_eq!((front.normal, front.group), (Vec3::Z, 1));
        assert_eq!(back.normal, Vec3::new(1.0, 1.0, 1.0).normalize());
        assert_eq!(back.coordinates, [Vec2::X, Vec2::ONE, Vec2::Y]);
        assert_eq!(all.corners([1]).map(|at| at.z).sum::<f32>(), 6.0);
    }
}
