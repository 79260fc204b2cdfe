//! What there is to tell of a face of a leaf that has several.

use serde::Serialize;

use super::leaf::MaterialStory;
use crate::math::index_u32;
use crate::models::{Crown, Placement};

/// A face of a leaf of several faces. No collapse changes such leaves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaceStory {
    /// The leaf's site: its number among all leaves with triangles, quads too, group by group.
    pub site: u32,
    /// The leaf's place in its group.
    pub leaf: u32,
    /// The face, by its place in the leaf.
    pub face: u32,
    /// Faces of the leaf.
    pub faces: u32,
    /// The branch that bears the leaf, where it is known.
    pub branch: Option<u32>,
    /// Its corners' numbers, as keys have them.
    pub vertices: [u32; 3],
    /// Where they are in the plant's space, in metres.
    pub plant: [[f32; 3]; 3],
    /// Where they are in the world, in metres.
    pub world: [[f32; 3]; 3],
    /// What the leaf looks like; the group is counted among all groups.
    pub material: MaterialStory,
}

/// The story of the face with these corners, if there is one.
pub(super) fn face_story(
    crown: &Crown,
    vertices: [u32; 3],
    placement: &Placement,
) -> Option<FaceStory> {
    let (plant, faces) = (crown.plant(), crown.faces());
    let face = faces.of_vertex(vertices[0])?;
    let corners = faces.corners(plant, &face)?;
    let group = plant.foliage().groups.get(face.group)?;
    let branches = plant
        .skeleton()
        .map_or(0, |skeleton| skeleton.branches.len());
    let owner = group.owners.get(face.leaf as usize).copied();
    Some(FaceStory {
        site: face.site,
        leaf: face.leaf,
        face: face.face,
        faces: index_u32(group.prototype.triangles_per_leaf()),
        branch: owner.filter(|&owner| (owner as usize) < branches),
        vertices,
        plant: corners.map(|corner| corner.to_array()),
        world: corners.map(|corner| placement.to_world(corner).to_array()),
        material: MaterialStory::of(crown, face.group, index_u32(face.group))?,
    })
}
