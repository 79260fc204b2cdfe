//! Where the faces of leaves stand among all: from groups to face numbers and back.

use crate::math::{Aabb, Vec3, index_u32};
use crate::plant::{Foliage, LeafGroup, Plant, Prototype, Texture};

/// The leaves of several faces of a plant, by number: faces count leaf by leaf, group by group, and
/// face `f` has vertices `3 f .. 3 f + 3`.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceLeaves {
    groups: Vec<Entry>,
    first_vertex: u32,
    leaf_count: u32,
    face_count: u32,
    bounds: Aabb,
}

/// A group, and what comes before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Entry {
    /// Its place among all groups of the plant.
    number: usize,
    first_site: u32,
    first_leaf: u32,
    first_face: u32,
    leaf_count: u32,
    faces_per_leaf: u32,
}

/// A face of a leaf of several faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceLeaf {
    /// The group, by its place among all groups of the plant.
    pub group: usize,
    /// The leaf, by its place in the group.
    pub leaf: u32,
    /// The leaf among all leaves with triangles, quads too: see
    /// [`FaceGroup::first_site`](crate::plant::FaceGroup::first_site).
    pub site: u32,
    /// The leaf among all leaves of several faces.
    pub number: u32,
    /// The face, by its place in the leaf.
    pub face: u32,
}

impl FaceLeaves {
    /// Of some foliage, vertices numbered from `first_vertex` on.
    pub(in super::super) fn of(foliage: &Foliage, first_vertex: u32) -> Self {
        let mut leaves = Self {
            groups: Vec::new(),
            first_vertex,
            leaf_count: 0,
            face_count: 0,
            bounds: Aabb::EMPTY,
        };
        // Groups without a leaf or without a face are not there.
        let groups = foliage.face_groups();
        let groups =
            groups.filter(|group| group.group.leaf_count() > 0 && !group.triangles.is_empty());
        for found in groups {
            let leaf_count = index_u32(found.group.leaf_count());
            let faces_per_leaf = index_u32(found.triangles.len());
            leaves.groups.push(Entry {
                number: found.number,
                first_site: found.first_site,
                first_leaf: leaves.leaf_count,
                first_face: leaves.face_count,
                leaf_count,
                faces_per_leaf,
            });
            leaves.leaf_count += leaf_count;
            leaves.face_count += leaf_count * faces_per_leaf;
            let positions = found.group.positions.iter().copied();
            leaves.bounds = leaves.bounds.union(Aabb::of(positions));
        }
        leaves
    }

    /// Whether there is no face.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.face_count == 0
    }

    /// How many leaves there are.
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        self.leaf_count
    }

    /// How many faces they have together.
    #[must_use]
    pub fn face_count(&self) -> u32 {
        self.face_count
    }

    /// The box around them, in the plant's space.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The number that keys have for the first vertex of the first face: those before are of quads.
    #[must_use]
    pub fn first_vertex(&self) -> u32 {
        self.first_vertex
    }

    /// The face that a vertex is of, by the number that keys have for it.
    #[must_use]
    pub fn of_vertex(&self, vertex: u32) -> Option<FaceLeaf> {
        self.of_face(vertex.checked_sub(self.first_vertex)? / 3)
    }

    /// A face, by its number among all.
    #[must_use]
    pub fn of_face(&self, face: u32) -> Option<FaceLeaf> {
        if face >= self.face_count {
            return None;
        }
        let after = self
            .groups
            .partition_point(|entry| entry.first_face <= face);
        let entry = self.groups.get(after.checked_sub(1)?)?;
        let within = face - entry.first_face;
        let leaf = within / entry.faces_per_leaf;
        Some(FaceLeaf {
            group: entry.number,
            leaf,
            site: entry.first_site + leaf,
            number: entry.first_leaf + leaf,
            face: within % entry.faces_per_leaf,
        })
    }

    /// The corners of a face, in the plant's space.
    #[must_use]
    pub fn corners(&self, plant: &Plant, face: &FaceLeaf) -> Option<[Vec3; 3]> {
        let group = plant.foliage().groups.get(face.group)?;
        let Prototype::Faces { triangles, .. } = &group.prototype else {
            return None;
        };
        let triangle = triangles.get(face.face as usize)?;
        Some(corners(group, face.leaf as usize, *triangle))
    }

    /// The corners of all faces, in the plant's space.
    pub fn all_corners<'p>(&'p self, plant: &'p Plant) -> impl Iterator<Item = [Vec3; 3]> + 'p {
        self.of_plant(plant).flat_map(|(_, group)| {
            let leaves = 0..group.leaf_count();
            leaves.flat_map(move |leaf| {
                let triangles = triangles(group).iter();
                triangles.map(move |&triangle| corners(group, leaf, triangle))
            })
        })
    }

    /// The groups with what is known of them.
    fn of_plant<'p>(&'p self, plant: &'p Plant) -> impl Iterator<Item = (Entry, &'p LeafGroup)> {
        let groups = &plant.foliage().groups;
        let known = self.groups.iter();
        known.filter_map(|entry| Some((*entry, groups.get(entry.number)?)))
    }

    /// The summed area of all faces in square metres of the plant's space.
    #[must_use]
    pub fn area(&self, plant: &Plant) -> f64 {
        let area = |[a, b, c]: [Vec3; 3]| {
            let [a, b, c] = [a, b, c].map(Vec3::as_dvec3);
            0.5 * (b - a).cross(c - a).length()
        };
        self.all_corners(plant).map(area).sum()
    }

    /// How many vertex bytes there are.
    pub(super) fn vertex_size(&self) -> u64 {
        36 * u64::from(self.face_count)
    }

    /// The vertices of all faces: three `f32` each, 12 bytes, little-endian.
    pub(super) fn vertex_bytes(&self, plant: &Plant) -> Vec<u8> {
        let corners = self.all_corners(plant).flatten();
        corners
            .flat_map(|corner| corner.to_array())
            .flat_map(f32::to_le_bytes)
            .collect()
    }

    /// The textures of all groups, each once, with the cutoff that their mips keep.
    pub(super) fn textures<'p>(&self, plant: &'p Plant) -> Vec<(&'p Texture, f32)> {
        let mut distinct: Vec<(&Texture, f32)> = Vec::new();
        for entry in &self.groups {
            let group = plant.foliage().groups.get(entry.number);
            let look = group.and_then(|group| {
                let texture = group.material.texture.as_ref()?;
                Some((texture, group.material.alpha_cutoff))
            });
            if let Some(look) = look.filter(|look| !distinct.contains(look)) {
                distinct.push(look);
            }
        }
        distinct
    }

    /// The groups as the program sees them, and the texture coordinates that they name.
    pub(super) fn materials(
        &self,
        plant: &Plant,
        textures: &[(&Texture, f32)],
    ) -> (Vec<super::program::FaceMaterial>, Vec<u8>) {
        let mut coordinates = Vec::new();
        let mut materials = Vec::new();
        for (entry, group) in self.of_plant(plant) {
            let Prototype::Faces {
                texture_coordinates,
                triangles,
            } = &group.prototype
            else {
                continue;
            };
            let material = &group.material;
            let look = material
                .texture
                .as_ref()
                .map(|texture| (texture, material.alpha_cutoff));
            let slot = look.and_then(|look| textures.iter().position(|known| *known == look));
            materials.push(super::program::FaceMaterial {
                first_face: entry.first_face,
                first_vertex: self.first_vertex + 3 * entry.first_face,
                first_coordinate: index_u32(coordinates.len()),
                faces_per_leaf: entry.faces_per_leaf,
                look: super::super::leaf::Look {
                    texture: slot.map_or(0, |slot| index_u32(slot) + 1),
                    base_color: material.base_color.into(),
                    alpha_cutoff: material.alpha_cutoff,
                },
            });
            let named = triangles.iter().flatten();
            coordinates.extend(named.map(|&vertex| texture_coordinates[vertex as usize]));
        }
        let coordinates = coordinates.iter().flat_map(|at| at.to_array());
        (materials, coordinates.flat_map(f32::to_le_bytes).collect())
    }
}

fn triangles(group: &LeafGroup) -> &[[u32; 3]] {
    match &group.prototype {
        Prototype::Faces { triangles, .. } => triangles,
        Prototype::Quad { .. } | Prototype::Needle { .. } => &[],
    }
}

fn corners(group: &LeafGroup, leaf: usize, triangle: [u32; 3]) -> [Vec3; 3] {
    let vertices = group.leaf(leaf);
    triangle.map(|vertex| vertices[vertex as usize])
}
