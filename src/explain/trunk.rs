//! What there is to tell of a triangle of a trunk: which branch's tube it is part of.

use serde::Serialize;

use crate::math::index_u32;
use crate::models::{Crown, Placement, Trunk, TrunkLevel};

/// A triangle of a trunk.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrunkStory {
    /// Its number in the trunk's mesh; where triangles share all corners, the first of them. At a level
    /// of less detail, of the triangle that has become it.
    pub triangle: u32,
    /// Its corners' numbers in the mesh.
    pub vertices: [u32; 3],
    /// Where they are in the plant's space, in metres.
    pub plant: [[f32; 3]; 3],
    /// Where they are in the world, in metres.
    pub world: [[f32; 3]; 3],
    /// The branch whose tube it is part of; an imported trunk without a skeleton has none.
    pub branch: Option<BranchStory>,
    /// The material's name.
    pub material: String,
}

/// A place on a branch.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BranchStory {
    /// The branch.
    pub branch: u32,
    /// Its level, 0 for a trunk.
    pub level: u32,
    /// The node at the lower end of the triangle, counted along the branch from its base.
    pub node: u32,
    /// How many nodes the branch has.
    pub nodes: u32,
    /// The branch that bears it.
    pub bearer: Option<u32>,
}

/// The story of the triangle with these corners, if the trunk has it at a level; without one, corners
/// are those of the mesh.
pub(super) fn trunk_story(
    crown: &Crown,
    trunk: &Trunk,
    level: Option<TrunkLevel>,
    corners: [u32; 3],
    placement: &Placement,
) -> Option<TrunkStory> {
    let mesh = trunk.mesh();
    let (triangle, corners) = match level {
        None => {
            let mut triangles = (0..).zip(mesh.indices.chunks_exact(3));
            let (triangle, _) = triangles.find(|(_, indices)| **indices == corners)?;
            (triangle, corners)
        }
        Some(level) => trunk.in_mesh(level, corners)?,
    };
    let plant = corners.map(|vertex| mesh.positions[vertex as usize]);
    Some(TrunkStory {
        triangle,
        vertices: corners,
        plant: plant.map(|point| point.to_array()),
        world: plant.map(|point| placement.to_world(point).to_array()),
        branch: branch_at(crown, corners),
        material: mesh.material.name.clone(),
    })
}

/// Where on the skeleton a triangle is.
///
/// Tubes follow one another in the order of branches and share no vertices. Each begins with the ring
/// around its branch's first node, where the texture begins, and ends with one vertex at the last
/// node; between lie the rings, node by node. Branches that are too thin have no tube.
fn branch_at(crown: &Crown, corners: [u32; 3]) -> Option<BranchStory> {
    let (skeleton, mesh) = (crown.plant().skeleton()?, crown.plant().trunk()?);
    let lowest = corners.into_iter().min()? as usize;
    let begins = |vertex: &usize| mesh.texture_coordinates[*vertex].to_array() == [1.0, 0.0];
    let mut starts = (0..mesh.positions.len()).filter(begins).peekable();
    let mut branches = (0..).zip(&skeleton.branches);
    while let Some(first) = starts.next() {
        let end = starts.peek().copied().unwrap_or(mesh.positions.len());
        let tip = mesh.positions.get(end.checked_sub(1)?)?;
        // Branches before the one that ends there have no tube.
        let (number, branch) = branches.find(|(_, branch)| {
            let nodes = skeleton.nodes_of(branch);
            nodes.len() > 1 && nodes.last().is_some_and(|last| last.position == *tip)
        })?;
        if lowest >= end {
            continue;
        }
        let nodes = skeleton.nodes_of(branch);
        let last = nodes.last()?;
        let rings = nodes.len() - usize::from(last.radius <= 0.0);
        let edges = (end - 1 - first) / rings;
        if edges == 0 || edges * rings != end - 1 - first {
            // Not a tube of ours after all.
            return None;
        }
        let node = lowest.checked_sub(first)? / edges;
        let bearer = branch.bearer.and_then(|node| {
            let mut branches = (0..).zip(&skeleton.branches);
            branches.find(|(_, other)| {
                (other.first_node..other.first_node + other.node_count).contains(&node)
            })
        });
        return Some(BranchStory {
            branch: number,
            level: branch.level,
            node: index_u32(node.min(nodes.len() - 1)),
            nodes: branch.node_count,
            bearer: bearer.map(|(number, _)| number),
        });
    }
    None
}
