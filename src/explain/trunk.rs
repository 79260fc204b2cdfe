//! What there is to tell of a triangle of a trunk: which branch's tube it is part of.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::models::{Crown, Placement};

/// A triangle of a trunk.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrunkStory {
    /// Its number in the trunk's mesh; where triangles share all corners, the first of them.
    pub triangle: u32,
    /// Its corners' numbers in the vertex buffer.
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

/// The story of the triangle with these corners, if the trunk has it.
pub(super) fn trunk_story(
    crown: &Crown,
    corners: [u32; 3],
    placement: &Placement,
) -> Option<TrunkStory> {
    let mesh = crown.plant().trunk()?;
    let mut triangles = (0..).zip(mesh.indices.chunks_exact(3));
    let (triangle, _) = triangles.find(|(_, indices)| **indices == corners)?;
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
/// Tubes follow one another in the order of branches, share no vertices, and each ends with one at
/// the branch's last node: between these ends lie a branch's rings, node by node.
fn branch_at(crown: &Crown, corners: [u32; 3]) -> Option<BranchStory> {
    let (skeleton, mesh) = (crown.plant().skeleton()?, crown.plant().trunk()?);
    let bits = |point: [f32; 3]| point.map(f32::to_bits);
    let mut places: BTreeMap<[u32; 3], Vec<u32>> = BTreeMap::new();
    for (vertex, position) in (0..).zip(&mesh.positions) {
        let at = places.entry(bits(position.to_array())).or_default();
        at.push(vertex);
    }
    let lowest = corners.into_iter().min()?;
    let mut first = 0;
    for (number, branch) in (0..).zip(&skeleton.branches) {
        let nodes = skeleton.nodes_of(branch);
        let Some(tip) = nodes.last().filter(|_| nodes.len() > 1) else {
            continue;
        };
        let ends = places.get(&bits(tip.position.to_array()));
        let Some(&end) = ends.and_then(|ends| ends.iter().find(|&&end| end >= first)) else {
            // No tube: it would be thinner than any.
            continue;
        };
        let rings = nodes.len() - usize::from(tip.radius <= 0.0);
        let edges = (end - first) as usize / rings;
        if edges * rings != (end - first) as usize || edges == 0 {
            // Not a tube of ours after all.
            return None;
        }
        if lowest <= end {
            let node = (lowest - first) as usize / edges;
            let bearer = branch.bearer.and_then(|node| {
                let mut branches = (0..).zip(&skeleton.branches);
                branches.find(|(_, other)| {
                    (other.first_node..other.first_node + other.node_count).contains(&node)
                })
            });
            return Some(BranchStory {
                branch: number,
                level: branch.level,
                node: crate::math::index_u32(node.min(nodes.len() - 1)),
                nodes: branch.node_count,
                bearer: bearer.map(|(number, _)| number),
            });
        }
        first = end + 1;
    }
    None
}
