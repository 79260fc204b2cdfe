//! What there is to tell of a triangle of a trunk: which branch's tube it is part of, which collapse made
//! it, and which transfer brought it.

use serde::Serialize;

use super::uploads::UploadStory;
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
    /// The level at which the trunk shows; a model without levels has none.
    pub level: Option<TrunkLevelStory>,
    /// The collapse that gave it its corners; one that is as in the mesh has none.
    pub made_by: Option<VertexCollapseStory>,
    /// The next collapse that moves one of its corners or takes it away.
    pub changed_by: Option<VertexCollapseStory>,
    /// Where its corners lie on the device, and which transfer brought them.
    pub upload: Option<UploadStory>,
    /// The branch whose tube it is part of; an imported trunk without a skeleton has none.
    pub branch: Option<BranchStory>,
    /// The material's name.
    pub material: String,
}

/// The level of a trunk.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TrunkLevelStory {
    /// Collapses done.
    pub collapses: u32,
    /// Collapses that there are.
    pub all_collapses: u32,
    /// Triangles that show.
    pub triangles: u32,
}

/// A collapse of a trunk, as it changes one triangle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexCollapseStory {
    /// Its number in the sequence, from 0.
    pub collapse: u32,
    /// What the simplifier paid: squared metres of distance times square metres of surface.
    pub cost: f64,
    /// How far the surface is from that of full detail then, in metres.
    pub error: f32,
    /// The corner that goes, by its number in the mesh.
    pub vertex: u32,
    /// The vertex that it goes to.
    pub target: u32,
    /// Whether the triangle goes with it.
    pub removes: bool,
    /// Whether it is done in the frame's state.
    pub done: bool,
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
    let [made_by, changed_by] = match level {
        None => [None, None],
        Some(level) => changes(trunk, triangle, level),
    };
    Some(TrunkStory {
        level: level.map(|level| TrunkLevelStory {
            collapses: level.collapses(),
            all_collapses: trunk.collapses().collapse_count(),
            triangles: trunk.triangle_count(level),
        }),
        made_by,
        changed_by,
        upload: None,
        triangle,
        vertices: corners,
        plant: plant.map(|point| point.to_array()),
        world: plant.map(|point| placement.to_world(point).to_array()),
        branch: branch_at(crown, corners),
        material: mesh.material.name.clone(),
    })
}

/// The last collapse before a level that changes a triangle, and the first after it.
fn changes(trunk: &Trunk, triangle: u32, level: TrunkLevel) -> [Option<VertexCollapseStory>; 2] {
    let collapses = trunk.collapses();
    let story = |(collapse, vertex): (u32, u32)| {
        let step = collapses.steps()[collapse as usize];
        let number = |vertex: u32| collapses.order()[vertex as usize];
        Some(VertexCollapseStory {
            collapse,
            cost: step.cost,
            error: step.error,
            vertex: number(vertex),
            target: number(collapses.target(vertex)?),
            removes: collapses.removal(triangle) == Some(collapse + 1),
            done: collapse < level.collapses(),
        })
    };
    let (mut made, mut next) = (None, None);
    for corner in collapses.triangles()[triangle as usize] {
        let mut vertex = corner;
        while let Some(collapse) = collapses.collapse_of(vertex) {
            let found = (collapse, vertex);
            if collapse >= level.collapses() {
                next = Some(next.map_or(found, |known: (u32, u32)| known.min(found)));
                break;
            }
            made = made.max(Some(found));
            let Some(target) = collapses.target(vertex) else {
                break;
            };
            vertex = target;
        }
    }
    [made, next].map(|found| found.and_then(story))
}

/// Where on the skeleton a triangle is.
///
/// Tubes follow one another in the order of branches and share no vertices. Each begins with the ring
/// around its branch's first node, where the texture begins, and ends with one vertex at the last
/// node; between lie the rings, node by node. Branches that are too thin have no tube.
pub(super) fn branch_at(crown: &Crown, corners: [u32; 3]) -> Option<BranchStory> {
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
