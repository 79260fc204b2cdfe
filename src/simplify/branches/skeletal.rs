//! Skeletal vectors: all that there is to know about a branch, 52 bytes a node.

use super::frame::{Frame, FrameMethod, moving_frames};
use crate::math::{Vec3, index_u32};
use crate::plant::Skeleton;

/// A node with its radius and frame ([ZBMJLDC17](crate::references), section 4.2): `G = (P, R; T, N, B)`.
///
/// | bytes | field           | type      | unit, space          |
/// |------:|-----------------|-----------|----------------------|
/// |  0–11 | position `P`    | 3 × `f32` | metres, world        |
/// | 12–15 | radius `R`      | `f32`     | metres               |
/// | 16–27 | tangent `T`     | 3 × `f32` | unit vector, world   |
/// | 28–39 | normal `N`      | 3 × `f32` | unit vector, world   |
/// | 40–51 | binormal `B`    | 3 × `f32` | unit vector, world   |
///
/// Little-endian and unpadded: [`BYTES`](Self::BYTES) is what one node costs on the bus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkeletalVector {
    /// Where the node lies.
    pub position: Vec3,
    /// The radius of the wood there, at least 0.
    pub radius: f32,
    /// How the circle there lies: across the tangent.
    pub frame: Frame,
}

impl SkeletalVector {
    /// Thirteen floats.
    pub const BYTES: u32 = 52;

    /// As it lies in memory.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES as usize] {
        let Frame {
            tangent,
            normal,
            binormal,
        } = self.frame;
        let mut bytes = [0; Self::BYTES as usize];
        let directions = [tangent, normal, binormal].map(|direction| direction.to_array());
        let floats = self.position.to_array().into_iter().chain([self.radius]);
        let floats = floats.chain(directions.into_iter().flatten());
        for (room, float) in bytes.chunks_exact_mut(4).zip(floats) {
            room.copy_from_slice(&float.to_le_bytes());
        }
        bytes
    }

    /// `R (N cos θ + B sin θ)`: from the node to a point of its circle, given the two numbers.
    #[must_use]
    pub fn spoke(&self, cosine: f32, sine: f32) -> Vec3 {
        self.radius * (cosine * self.frame.normal + sine * self.frame.binormal)
    }
}

/// A branch: a run of skeletal vectors from base to tip, and where another bears it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchAxis {
    /// Where it grows from; `None` for a root.
    pub attachment: Option<Attachment>,
    /// The branching level: 0 for a trunk.
    pub level: u32,
    /// The first of its vectors.
    pub first: u32,
    /// How many it has, at least 1: one more than it has internodes.
    pub count: u32,
}

/// A place on the branch that bears another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attachment {
    /// The bearer, an earlier branch.
    pub branch: u32,
    /// The node of it at or below the place, counted from its base.
    pub node: u32,
    /// How far towards the next node the place lies, 0 to 1: the point of the internode that is
    /// nearest to the base of what is borne.
    pub share: f32,
}

/// All branches of a plant as skeletal vectors, bearers before what they bear.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BranchSkeleton {
    /// The vectors of all branches; runs follow one another without gaps.
    pub vectors: Vec<SkeletalVector>,
    /// The distance of each vector's node from its branch's base along the axis, in metres
    /// (`t` of eq. 1).
    pub along: Vec<f32>,
    /// The branches.
    pub branches: Vec<BranchAxis>,
}

impl BranchSkeleton {
    /// Frames along every branch of a skeleton.
    #[must_use]
    pub fn of(skeleton: &Skeleton, method: FrameMethod) -> Self {
        let mut all = Self {
            vectors: Vec::with_capacity(skeleton.nodes.len()),
            along: Vec::with_capacity(skeleton.nodes.len()),
            branches: Vec::with_capacity(skeleton.branches.len()),
        };
        let mut owners: Vec<u32> = Vec::with_capacity(skeleton.nodes.len());
        for (number, branch) in (0..).zip(&skeleton.branches) {
            let nodes = skeleton.nodes_of(branch);
            let points: Vec<Vec3> = nodes.iter().map(|node| node.position).collect();
            let attachment = branch.bearer.map(|node| {
                let bearer = owners[node as usize];
                all.attachment(bearer, node, points[0])
            });
            let first = index_u32(all.vectors.len());
            let mut along = 0.0;
            let mut last = points[0];
            for (node, frame) in nodes.iter().zip(moving_frames(&points, method)) {
                along += last.distance(node.position);
                last = node.position;
                all.along.push(along);
                all.vectors.push(SkeletalVector {
                    position: node.position,
                    radius: node.radius,
                    frame,
                });
                owners.push(number);
            }
            all.branches.push(BranchAxis {
                attachment,
                level: branch.level,
                first,
                count: branch.node_count,
            });
        }
        all
    }

    /// The vectors of one branch, base first.
    ///
    /// # Panics
    ///
    /// When `branch` is none of this skeleton's.
    #[must_use]
    pub fn vectors_of(&self, branch: &BranchAxis) -> &[SkeletalVector] {
        &self.vectors[branch.run()]
    }

    fn attachment(&self, bearer: u32, node: u32, base: Vec3) -> Attachment {
        let branch = &self.branches[bearer as usize];
        let node = node - branch.first;
        let ends = self.vectors_of(branch).get(node as usize..);
        let share = match ends {
            Some([start, end, ..]) => nearest_share(base, start.position, end.position),
            _ => 0.0,
        };
        Attachment {
            branch: bearer,
            node,
            share,
        }
    }
}

impl BranchAxis {
    /// Which of all vectors are this branch's.
    #[must_use]
    pub fn run(&self) -> std::ops::Range<usize> {
        let first = self.first as usize;
        first..first + self.count as usize
    }
}

/// Where on the way from `start` to `end` the point lies that is nearest to `point`: 0 to 1.
pub(super) fn nearest_share(point: Vec3, start: Vec3, end: Vec3) -> f32 {
    let way = end - start;
    let square = way.length_squared();
    if square > 0.0 {
        ((point - start).dot(way) / square).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::{Branch, Node};

    /// ```text
    ///   2
    ///   │  4
    ///   1 ╱        the twig 3–4 grows half way between nodes 0 and 1
    ///   │3
    ///   0
    /// ```
    #[test]
    fn branches_know_where_they_grow() {
        let node = |x: f32, y: f32| Node {
            position: Vec3::new(x, y, 0.0),
            radius: 0.25,
        };
        let branch = |bearer, first_node, node_count| Branch {
            bearer,
            level: u32::from(bearer.is_some()),
            first_node,
            node_count,
        };
        let skeleton = Skeleton {
            nodes: vec![
                node(0.0, 0.0),
                node(0.0, 2.0),
                node(0.0, 3.0),
                node(0.0, 1.0),
                node(1.0, 2.0),
            ],
            branches: vec![branch(None, 0, 3), branch(Some(0), 3, 2)],
        };
        let all = BranchSkeleton::of(&skeleton, FrameMethod::DoubleReflection);
        assert_eq!(all.branches[0].attachment, None);
        let wanted = Attachment {
            branch: 0,
            node: 0,
            share: 0.5,
        };
        assert_eq!(all.branches[1].attachment, Some(wanted));
        assert_eq!(all.along[..3], [0.0, 2.0, 3.0]);
        assert_eq!(all.vectors_of(&all.branches[1]).len(), 2);
    }

    #[test]
    fn a_vector_is_thirteen_floats_in_order() {
        let vector = SkeletalVector {
            position: Vec3::new(1.0, 2.0, 3.0),
            radius: 4.0,
            frame: Frame {
                tangent: Vec3::new(5.0, 6.0, 7.0),
                normal: Vec3::new(8.0, 9.0, 10.0),
                binormal: Vec3::new(11.0, 12.0, 13.0),
            },
        };
        let bytes = vector.to_bytes();
        let floats: Vec<f32> = bytes
            .chunks_exact(4)
            .map(|four| f32::from_le_bytes([four[0], four[1], four[2], four[3]]))
            .collect();
        let wanted: Vec<f32> = (1_u8..14).map(f32::from).collect();
        assert_eq!(floats, wanted);
    }
}
