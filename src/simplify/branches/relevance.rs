//! The baseline: procedural pruning, which drops what has least volume.

use super::skeletal::{BranchAxis, BranchSkeleton};
use crate::math::{Vec3, index_u32};

/// Branches in order of relevance, after [LCV03](crate::references): *a reconstruction*.
///
/// The original embeds resolutions into the chain of a parametric L-system and orders branches by a
/// metric whose formula we do not have. What is known is what it does: of a willow it drops the long
/// thin branches ([ZBMJLDC17](crate::references), figure 15b). Volume does the same, so here a branch is
/// as relevant as its wood and all wood that it bears have volume, `π ∫ R² ds`, frustum by frustum. A
/// branch that stays keeps all of its nodes, and a bearer is never less relevant than what it bears.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BranchRelevance {
    volumes: Vec<f32>,
    order: Vec<u32>,
}

impl BranchRelevance {
    /// The relevance of all branches of a skeleton.
    #[must_use]
    pub fn of(skeleton: &BranchSkeleton) -> Self {
        let branches = &skeleton.branches;
        let own = |branch| volume(skeleton, branch);
        let mut volumes: Vec<f32> = branches.iter().map(own).collect();
        for (number, branch) in branches.iter().enumerate().rev() {
            if let Some(attachment) = branch.attachment {
                volumes[attachment.branch as usize] += volumes[number];
            }
        }
        let mut order: Vec<u32> = (0..index_u32(branches.len())).collect();
        // Equals: a bearer comes before what it bears.
        order.sort_by(|&one, &other| {
            let [a, b] = [one, other].map(|branch| volumes[branch as usize]);
            b.total_cmp(&a).then(one.cmp(&other))
        });
        Self { volumes, order }
    }

    /// All branches, the most relevant first: a resolution keeps a first part of them.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The volume of every branch with all that it bears, in cubic metres.
    #[must_use]
    pub fn volumes(&self) -> &[f32] {
        &self.volumes
    }
}

fn volume(skeleton: &BranchSkeleton, branch: &BranchAxis) -> f32 {
    let vectors = skeleton.vectors_of(branch);
    vectors.windows(2).fold(0.0, |sum, ends| {
        let [low, high] = [ends[0].radius, ends[1].radius];
        let length = Vec3::distance(ends[0].position, ends[1].position);
        let squares = low * low + low * high + high * high;
        sum + std::f32::consts::FRAC_PI_3 * length * squares
    })
}

#[cfg(test)]
mod tests {
    use super::super::frame::FrameMethod;
    use super::*;
    use crate::plant::{Branch, Node, Skeleton};

    #[test]
    fn long_thin_branches_go_first() {
        // A stump, a long rod a tenth as thick, a short thick twig, and a twig of the stump's own.
        let mut skeleton = Skeleton::default();
        let mut add = |bearer, length: f32, radius: f32| {
            skeleton.branches.push(Branch {
                bearer,
                level: 0,
                first_node: index_u32(skeleton.nodes.len()),
                node_count: 2,
            });
            skeleton.nodes.extend([0.0, length].map(|y| Node {
                position: Vec3::Y * y,
                radius,
            }));
        };
        add(None, 1.0, 1.0);
        add(Some(0), 10.0, 0.1);
        add(Some(0), 1.0, 0.5);
        add(Some(2), 0.5, 0.0);
        let skeleton = BranchSkeleton::of(&skeleton, FrameMethod::DoubleReflection);
        let relevance = BranchRelevance::of(&skeleton);
        assert_eq!(relevance.order(), [0, 2, 1, 3]);
        let wanted = std::f32::consts::PI * (1.0 + 0.1 + 0.25);
        assert!((relevance.volumes()[0] - wanted).abs() < 1e-5);
    }
}
