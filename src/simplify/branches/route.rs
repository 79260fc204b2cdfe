//! Which merges to take: the cheapest way from base to tip.

use std::ops::Range;

use super::merges::MergeTable;
use super::shares::BranchErrors;

/// What merging may deviate, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Allowed {
    /// `E1`, of the axis.
    pub(super) skeleton: f32,
    /// `E2`, of radius and frame.
    pub(super) radius: f32,
}

impl Allowed {
    /// What a level's errors allow.
    pub(super) fn of(errors: &BranchErrors) -> Self {
        Self {
            skeleton: errors.skeleton,
            radius: errors.radius,
        }
    }
}

/// A node that stays, with the cost of the merge that ends there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    /// The node, counted through all branches.
    pub(super) node: usize,
    /// `φ` of the merge from the stop before; 0 for an internode as it was, and for the first.
    pub(super) skeleton: f32,
    /// Its `ϕ`.
    pub(super) radius: f32,
}

/// The best way to a node.
#[derive(Debug, Clone, Copy)]
struct Way {
    primitives: u64,
    stops: u32,
    /// The stop before.
    from: Stop,
}

/// Room for ways that is used again from branch to branch.
#[derive(Debug, Default)]
pub(super) struct Router {
    ways: Vec<Way>,
}

impl Router {
    /// The nodes of a branch that stay: those of the merges with the fewest primitives together, of
    /// these the ones with the fewest nodes, of these the ones that begin at the lowest.
    ///
    /// The merges that are allowed are a graph over the nodes, and this is a shortest way through
    /// it. A smaller error leaves a part of the graph and makes no internode cheaper, so it never
    /// leads to fewer primitives; to merge greedily from the base would.
    ///
    /// `primitives` tells what an internode between two nodes costs.
    pub(super) fn stops(
        &mut self,
        table: &MergeTable,
        nodes: Range<usize>,
        allowed: Allowed,
        primitives: impl Fn(usize, usize) -> u32,
    ) -> Vec<Stop> {
        let (first, last) = (nodes.start, nodes.end - 1);
        let stop = |node, skeleton, radius| Stop {
            node,
            skeleton,
            radius,
        };
        self.ways.clear();
        self.ways.push(Way {
            primitives: 0,
            stops: 0,
            from: stop(first, 0.0, 0.0),
        });
        for to in first + 1..=last {
            let merges = table.ending_at(to).iter();
            let merges = merges
                .filter(|merge| {
                    merge.skeleton <= allowed.skeleton && merge.radius <= allowed.radius
                })
                .map(|merge| stop(merge.from as usize, merge.skeleton, merge.radius));
            let ways = merges.chain([stop(to - 1, 0.0, 0.0)]).map(|from| {
                let before = self.ways[from.node - first];
                Way {
                    primitives: before.primitives + u64::from(primitives(from.node, to)),
                    stops: before.stops + 1,
                    from,
                }
            });
            // Of equals the first stays, which begins at the lowest node.
            let best = ways.reduce(|best, way| {
                if (way.primitives, way.stops) < (best.primitives, best.stops) {
                    way
                } else {
                    best
                }
            });
            self.ways.extend(best);
        }
        let mut stops = Vec::new();
        let mut node = last;
        while node > first {
            let from = self.ways[node - first].from;
            stops.push(stop(node, from.skeleton, from.radius));
            node = from.node;
        }
        stops.push(stop(first, 0.0, 0.0));
        stops.reverse();
        stops
    }
}

#[cfg(test)]
mod tests {
    use super::super::frame::FrameMethod;
    use super::super::skeletal::BranchSkeleton;
    use super::super::tests;
    use super::*;
    use crate::math::Vec3;

    fn branch(points: &[(f32, f32, f32)]) -> MergeTable {
        let points = points.iter();
        let points: Vec<_> = points
            .map(|&(x, y, radius)| (Vec3::new(x, y, 0.0), radius))
            .collect();
        let skeleton = BranchSkeleton::of(&tests::branch(&points), FrameMethod::DoubleReflection);
        MergeTable::of(&skeleton, std::f32::consts::PI)
    }

    fn nodes(table: &MergeTable, count: usize, error: f32, edges: &[u32]) -> Vec<usize> {
        let allowed = Allowed {
            skeleton: error,
            radius: error,
        };
        let cost = |from: usize, to: usize| edges[from].max(edges[to]);
        let stops = Router::default().stops(table, 0..count, allowed, cost);
        stops.iter().map(|stop| stop.node).collect()
    }

    /// ```text
    ///     1   3
    ///   0   2   4      every node a quarter off the line through its neighbours
    /// ```
    #[test]
    fn fewest_primitives_then_fewest_nodes_then_the_lowest() {
        let zigzag: Vec<(f32, f32, f32)> = [(0, 0), (1, 1), (2, 0), (3, 1), (4, 0)]
            .map(|(x, y): (u8, u8)| (f32::from(x), 0.25 * f32::from(y), 0.0))
            .to_vec();
        let table = branch(&zigzag);
        assert_eq!(nodes(&table, 5, 0.0, &[3; 5]), [0, 1, 2, 3, 4]);
        assert_eq!(nodes(&table, 5, 0.3, &[3; 5]), [0, 4]);
        // Straight, but the ends are fine: to leave the fine ends at once costs least.
        let rod: Vec<(f32, f32, f32)> = (0_u8..5).map(|x| (f32::from(x), 0.0, 0.0)).collect();
        let table = branch(&rod);
        assert_eq!(nodes(&table, 5, 0.0, &[9, 3, 3, 3, 3]), [0, 4]);
        assert_eq!(nodes(&table, 5, 0.0, &[3, 3, 3, 3, 3]), [0, 4]);
        assert_eq!(nodes(&table, 5, -1.0, &[3, 3, 3, 3, 3]), [0, 1, 2, 3, 4]);
        assert_eq!(nodes(&table, 1, 1.0, &[3]), [0]);
    }
}
