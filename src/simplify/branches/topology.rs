//! Which branches go, and when: how far a branch with all that it bears reaches from its bearer.

use super::skeletal::{Attachment, BranchAxis, BranchSkeleton, nearest_share};
use crate::math::{Vec3, index_u32};

/// How many internodes of the bearer, to both sides of the attachment, are looked at. Fewer than
/// there are make the distance too long, never too short.
const REACH: usize = 32;

/// How often an internode is halved at most to find its distance.
const HALVINGS: u32 = 6;

/// Halving ends where the distance is known to this share of itself.
const CLOSE: f32 = 1.0 / 32.0;

/// The order in which branches are removed ([ZBMJLDC17](crate::references), section 5.3).
///
/// The paper names a Hausdorff distance and its sum over a branch and its children, no formula. Here
///
/// ```text
///   acc(b) = h(b → bearer) + max(R_b, acc(c) for every c that b bears)
/// ```
///
/// with `h` the greatest distance from a point of the branch's axis to the bearer's axis, and `R_b` the
/// branch's greatest radius. (The symmetric distance is ruled by the bearer's far end and would never
/// let a branch go.) So no point of what goes with `b` is farther than `acc(b)` from the axis that
/// stays, and no branch goes before what it bears. `h` is an upper bound, at most 1⁄32 too long where
/// six halvings of an internode are enough.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TopologyOrder {
    accumulated: Vec<f32>,
    order: Vec<u32>,
}

impl TopologyOrder {
    /// The order of all branches of a skeleton.
    #[must_use]
    pub fn of(skeleton: &BranchSkeleton) -> Self {
        let branches = &skeleton.branches;
        // Of each branch, what its own wood and what it bears reach from its axis.
        let radius = |branch: &BranchAxis| {
            let vectors = skeleton.vectors_of(branch).iter();
            vectors.fold(0.0, |most: f32, vector| most.max(vector.radius))
        };
        let mut reach: Vec<f32> = branches.iter().map(radius).collect();
        let mut accumulated = vec![f32::INFINITY; branches.len()];
        for (number, branch) in branches.iter().enumerate().rev() {
            if let Some(attachment) = branch.attachment {
                let distance = distance_to_bearer(skeleton, branch, attachment);
                accumulated[number] = distance + reach[number];
                let bearer = &mut reach[attachment.branch as usize];
                *bearer = bearer.max(accumulated[number]);
            }
        }
        let mut order: Vec<u32> = (0..index_u32(branches.len()))
            .filter(|&branch| branches[branch as usize].attachment.is_some())
            .collect();
        // Equals: what is borne comes later in the skeleton and goes first.
        order.sort_by(|&one, &other| {
            let [a, b] = [one, other].map(|branch| accumulated[branch as usize]);
            a.total_cmp(&b).then(other.cmp(&one))
        });
        Self { accumulated, order }
    }

    /// `acc` of every branch, in metres: infinite for a root, which never goes.
    #[must_use]
    pub fn accumulated(&self) -> &[f32] {
        &self.accumulated
    }

    /// The branches that go at all, first those that go first.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The branches that are gone at an error `E4`, in metres: a first part of the order.
    #[must_use]
    pub fn removed(&self, error: f32) -> &[u32] {
        let gone = |&branch: &u32| self.accumulated[branch as usize] <= error;
        &self.order[..self.order.partition_point(gone)]
    }
}

/// The greatest distance from a point of the branch's axis to the bearer's axis, at most: FACTS' safe
/// bound, closer where an internode is halved.
fn distance_to_bearer(
    skeleton: &BranchSkeleton,
    branch: &BranchAxis,
    attachment: Attachment,
) -> f32 {
    let bearer = skeleton.vectors_of(&skeleton.branches[attachment.branch as usize]);
    let node = attachment.node as usize;
    let near = &bearer[node.saturating_sub(REACH)..(node + REACH + 2).min(bearer.len())];
    let points: Vec<Vec3> = near.iter().map(|vector| vector.position).collect();
    let mut room = [Vec::new(), Vec::new()];
    let nodes = skeleton.vectors_of(branch);
    let mut most = 0.0_f32;
    if let [only] = nodes {
        distances(only.position, &points, &mut room[0]);
        most = least(&room[0]);
    }
    for ends in nodes.windows(2) {
        let ends = [ends[0].position, ends[1].position];
        most = most.max(segment_distance(ends, &points, most, HALVINGS, &mut room));
    }
    most
}

/// The distances of a point to all segments of a polyline; to a single point where it has none.
fn distances(point: Vec3, polyline: &[Vec3], all: &mut Vec<f32>) {
    all.clear();
    if let [only] = polyline {
        all.push(point.distance(*only));
    }
    all.extend(polyline.windows(2).map(|ends| {
        let share = nearest_share(point, ends[0], ends[1]);
        point.distance(ends[0] + share * (ends[1] - ends[0]))
    }));
}

fn least(distances: &[f32]) -> f32 {
    distances.iter().copied().fold(f32::INFINITY, f32::min)
}

/// The greatest distance from a point of a segment to a polyline, at most; `known` when it is no
/// more than that.
///
/// The distance to *one* segment is convex, so that along the way it is no more than at one of the
/// ends; the least such over the polyline's segments is an upper bound, the distance of either end
/// a lower.
fn segment_distance(
    ends: [Vec3; 2],
    polyline: &[Vec3],
    known: f32,
    halvings: u32,
    room: &mut [Vec<f32>; 2],
) -> f32 {
    for (end, all) in ends.iter().zip(room.iter_mut()) {
        distances(*end, polyline, all);
    }
    let pairs = room[0].iter().zip(&room[1]);
    let upper = pairs.fold(f32::INFINITY, |least, (a, b)| least.min(a.max(*b)));
    let lower = least(&room[0]).max(least(&room[1]));
    if upper <= known || upper - lower <= CLOSE * upper || halvings == 0 {
        return upper;
    }
    let middle = 0.5 * (ends[0] + ends[1]);
    let first = segment_distance([ends[0], middle], polyline, known, halvings - 1, room);
    let known = known.max(first);
    first.max(segment_distance(
        [middle, ends[1]],
        polyline,
        known,
        halvings - 1,
        room,
    ))
}

#[cfg(test)]
mod tests {
    use super::super::frame::FrameMethod;
    use super::*;
    use crate::plant::{Branch, Node, Skeleton};

    /// The node that bears a branch, and where its nodes lie.
    type Twig<'a> = (Option<u32>, &'a [(f32, f32)]);

    fn skeleton(branches: &[Twig<'_>], radius: f32) -> BranchSkeleton {
        let mut all = Skeleton::default();
        for &(bearer, points) in branches {
            all.branches.push(Branch {
                bearer,
                level: 0,
                first_node: index_u32(all.nodes.len()),
                node_count: index_u32(points.len()),
            });
            all.nodes.extend(points.iter().map(|&(x, y)| Node {
                position: Vec3::new(x, y, 0.0),
                radius,
            }));
        }
        BranchSkeleton::of(&all, FrameMethod::DoubleReflection)
    }

    /// ```text
    ///   │  ╱            the twig reaches 2 from the trunk, its own twig 1 from the twig
    ///   ├─╱──           and both are 0.125 thick
    ///   │
    /// ```
    #[test]
    fn distances_add_up_to_the_root() {
        let tree = skeleton(
            &[
                (None, &[(0.0, 0.0), (0.0, 4.0)]),
                (Some(0), &[(0.0, 1.0), (2.0, 1.0)]),
                (Some(2), &[(1.0, 1.0), (1.0, 2.0)]),
            ],
            0.125,
        );
        let order = TopologyOrder::of(&tree);
        assert_eq!(order.accumulated(), [f32::INFINITY, 3.125, 1.125]);
        assert_eq!(order.order(), [2, 1]);
        assert_eq!(order.removed(1.0), [0_u32; 0]);
        assert_eq!(order.removed(1.125), [2]);
        assert_eq!(order.removed(f32::INFINITY), [2, 1]);
    }

    #[test]
    fn a_way_across_a_bend_is_measured_between_its_ends() {
        // From one leg of a right angle to the other: both ends touch, the middle is √½ away from
        // both legs... of which the nearer is a half away.
        let tree = skeleton(
            &[
                (None, &[(0.0, 1.0), (0.0, 0.0), (1.0, 0.0)]),
                (Some(0), &[(0.0, 1.0), (1.0, 0.0)]),
            ],
            0.0,
        );
        let found = TopologyOrder::of(&tree).accumulated()[1];
        assert!((0.5..=0.5 * 1.04).contains(&found), "{found}");
    }

    #[test]
    fn twins_at_the_same_place_go_last_first() {
        let twig: &[(f32, f32)] = &[(0.0, 1.0), (1.0, 1.0)];
        let tree = skeleton(
            &[
                (None, &[(0.0, 0.0), (0.0, 2.0)]),
                (Some(0), twig),
                (Some(0), twig),
            ],
            0.0,
        );
        assert_eq!(TopologyOrder::of(&tree).order(), [2, 1]);
    }
}
