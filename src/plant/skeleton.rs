//! The branch graph: polylines with radii, each borne by an earlier one.

use super::PlantError;
use crate::math::{Digester, Vec3};

/// All branches of a plant, bearers before what they bear.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Skeleton {
    /// The points of all branches; each branch owns a run of them, base first.
    pub nodes: Vec<Node>,
    /// The branches; the runs of nodes follow one another without gaps.
    pub branches: Vec<Branch>,
}

/// A point on a branch's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Where it lies, in world space.
    pub position: Vec3,
    /// The radius of the wood there, in metres, at least 0.
    pub radius: f32,
}

/// One axis: a polyline of nodes from base to tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Branch {
    /// The node of an earlier branch that bears this one; `None` for a root.
    pub bearer: Option<u32>,
    /// The branching level: 0 for a trunk.
    pub level: u32,
    /// The first of its nodes.
    pub first_node: u32,
    /// How many nodes it has, at least 1.
    pub node_count: u32,
}

impl Skeleton {
    /// The nodes of one branch, base first.
    ///
    /// # Panics
    ///
    /// When `branch` is none of this skeleton's.
    #[must_use]
    pub fn nodes_of(&self, branch: &Branch) -> &[Node] {
        let first = branch.first_node as usize;
        &self.nodes[first..first + branch.node_count as usize]
    }

    /// The branches that no other bears.
    pub fn roots(&self) -> impl Iterator<Item = &Branch> {
        self.branches
            .iter()
            .filter(|branch| branch.bearer.is_none())
    }

    pub(super) fn check(&self) -> Result<(), PlantError> {
        let part = || "skeleton".to_owned();
        let mut next = 0_usize;
        for (place, branch) in self.branches.iter().enumerate() {
            if branch.first_node as usize != next || branch.node_count == 0 {
                return Err(PlantError::Index {
                    part: part(),
                    place,
                    what: "first node",
                    index: u64::from(branch.first_node),
                    count: next,
                });
            }
            if let Some(bearer) = branch.bearer
                && bearer as usize >= next
            {
                return Err(PlantError::Index {
                    part: part(),
                    place,
                    what: "bearing node",
                    index: u64::from(bearer),
                    count: next,
                });
            }
            next += branch.node_count as usize;
        }
        if next != self.nodes.len() {
            let (found, wanted) = (self.nodes.len(), next);
            return Err(PlantError::Length {
                part: part(),
                what: "nodes",
                found,
                wanted,
            });
        }
        for (place, node) in self.nodes.iter().enumerate() {
            if !node.position.is_finite() || !node.radius.is_finite() || node.radius < 0.0 {
                return Err(PlantError::Number {
                    part: part(),
                    place,
                    value: format!("{} radius {}", node.position, node.radius),
                    wanted: "finite, not negative",
                });
            }
        }
        Ok(())
    }

    pub(super) fn digest_into(&self, digester: &mut Digester) {
        digester.u64(self.nodes.len() as u64);
        for node in &self.nodes {
            digester.vec3(node.position).f32(node.radius);
        }
        digester.u64(self.branches.len() as u64);
        for branch in &self.branches {
            digester.u32(branch.bearer.map_or(u32::MAX, |bearer| bearer));
            digester
                .u32(branch.level)
                .u32(branch.first_node)
                .u32(branch.node_count);
        }
    }
}
