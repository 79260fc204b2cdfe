//! From axes to the nodes of branches.
//!
//! ```text
//!     segment s            next n                  segment s
//!   A ━━━━━━━━━━━ B' · B ━━━━━━━━━━            A ━━━━━━━━━○━━━━━━ B
//!     B' within a radius of B: one node B                  ╲  a branch starts here:
//!                                                           ╲ a node between A and B
//! ```

use std::collections::VecDeque;

use super::axes::{Axes, NONE, thickness};
use super::{Grown, Place, Wood, place_of};
use crate::math::{DVec3, index_u32};
use crate::plant::import::frame::Frame;
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::{Branch, Node, Skeleton};

/// Points nearer than this are one, in metres: a hundredth of what positions are precise to.
const SAME_POINT: f64 = 1e-6;

/// Joints that gape less than this are not worth a word, in metres: what files round to.
const ROUNDING: f64 = 1e-3;

/// A branch that is to be laid.
#[derive(Debug)]
struct Head {
    segment: u32,
    bearer: Option<u32>,
    level: u32,
    /// Where it starts.
    start: DVec3,
    /// A point on its bearer's axis, where it starts outside of the bearer's wood.
    bridge: Option<DVec3>,
}

/// A node in the file's space.
#[derive(Debug, Clone, Copy)]
struct Point {
    position: DVec3,
    radius: f64,
}

/// What is being laid.
#[derive(Debug)]
struct Layer<'a> {
    wood: &'a Wood,
    axes: &'a Axes,
    frame: &'a Frame,
    /// How long a unit is, in metres.
    unit: f64,
    grown: Grown,
    waiting: VecDeque<Head>,
}

/// Lays all branches, bearers before what they bear.
pub(super) fn lay(wood: &Wood, axes: &Axes, frame: &Frame, report: &mut ImportReport) -> Grown {
    let count = wood.segments.len();
    let mut layer = Layer {
        wood,
        axes,
        frame,
        unit: f64::from(frame.length(1.0)),
        grown: Grown {
            skeleton: Skeleton::default(),
            places: vec![Place::default(); count],
        },
        waiting: VecDeque::new(),
    };
    for root in axes.roots() {
        let head = Head {
            segment: root,
            bearer: None,
            level: 0,
            start: axes.start(wood, root),
            bridge: None,
        };
        layer.waiting.push_back(head);
    }
    while let Some(head) = layer.waiting.pop_front() {
        layer.branch(&head, report);
    }
    layer.grown
}

impl Layer<'_> {
    fn branch(&mut self, head: &Head, report: &mut ImportReport) {
        let first_node = self.next_node();
        let radius = thickness(&self.wood.segments[head.segment as usize]);
        if let Some(position) = head.bridge {
            self.push(Point { position, radius });
        }
        let mut at = Point {
            position: head.start,
            radius,
        };
        self.push(at);
        let mut segment = head.segment;
        while segment != NONE {
            at = self.segment(segment, at, head.level, report);
            segment = self.axes.next[segment as usize];
        }
        self.grown.skeleton.branches.push(Branch {
            bearer: head.bearer,
            level: head.level,
            first_node,
            node_count: self.next_node() - first_node,
        });
    }

    /// Lays a segment from the last node on; returns the node where the next begins.
    fn segment(
        &mut self,
        segment: u32,
        from: Point,
        level: u32,
        report: &mut ImportReport,
    ) -> Point {
        let own = self.wood.segments[segment as usize];
        let next = self.axes.next[segment as usize];
        let end_radius = own.end_radius.or(own.start_radius).unwrap_or(0.0);
        let mut to = Point {
            position: own.end,
            radius: end_radius,
        };
        let mut gap = None;
        if next != NONE {
            let after = &self.wood.segments[next as usize];
            let joint = Point {
                position: after.start.unwrap_or(own.end),
                radius: after.start_radius.unwrap_or(end_radius),
            };
            let distance = joint.position.distance(to.position);
            let reach = joint.radius.max(thickness(&own)).max(ROUNDING / self.unit);
            // Not a number is a gap.
            if distance <= reach {
                if distance * self.unit > ROUNDING {
                    let message = format!(
                        "{} that start up to a radius away from the end of the one before: they meet \
                         where the later starts",
                        self.wood.what
                    );
                    report.add(ReportKind::Merged, 1, place_of(after.line), message);
                }
                to = joint;
            } else {
                gap = Some((joint, after.line));
            }
        }
        let first = self.next_node() - 1;
        let splits = self.laterals(segment, [from, to], level, report);
        let length = from.position.distance(to.position);
        if length * self.unit <= SAME_POINT {
            // A lone point is how files begin whose segments have no starts.
            let is_root = self.axes.parents[segment as usize] == NONE;
            let is_point = own.start.is_none() && is_root;
            if !is_point && from.position.distance(own.end) * self.unit <= SAME_POINT {
                let message = format!("{} without length: joined with the next", self.wood.what);
                report.add(ReportKind::Merged, 1, place_of(own.line), message);
            }
            let node = self.node(to);
            self.grown.skeleton.nodes[first as usize] = node;
        } else {
            for split in splits {
                self.push(split);
            }
            self.push(to);
        }
        self.grown.places[segment as usize] = Place {
            branch: index_u32(self.grown.skeleton.branches.len()),
            first,
            last: self.next_node() - 1,
        };
        let Some((joint, line)) = gap else {
            return to;
        };
        let message = format!(
            "{} that start more than a radius away from the end of the one before: bridged",
            self.wood.what
        );
        report.add(ReportKind::Repaired, 1, place_of(line), message);
        self.push(joint);
        joint
    }

    /// Queues the branches that a segment bears; returns the nodes that it gets for them between its ends,
    /// in their order.
    fn laterals(
        &mut self,
        segment: u32,
        [from, to]: [Point; 2],
        level: u32,
        report: &mut ImportReport,
    ) -> Vec<Point> {
        let next = self.axes.next[segment as usize];
        let span = to.position - from.position;
        let length = span.length();
        let along = |start: DVec3| {
            let share = (start - from.position).dot(span) / (length * length);
            share.clamp(0.0, 1.0) * length
        };
        let children = self.axes.children(segment).iter();
        let mut starts: Vec<(f64, u32)> = children
            .filter(|child| **child != next)
            .map(|&child| {
                let start = self.wood.segments[child as usize].start;
                (start.map_or(length, along), child)
            })
            .collect();
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut splits: Vec<(f64, Point)> = Vec::new();
        let first = self.next_node() - 1;
        let is_point = length * self.unit <= SAME_POINT;
        // The last node's number is known when all splits are.
        let mut heads = Vec::with_capacity(starts.len());
        for (along, child) in starts {
            let share = along / length;
            let radius = from.radius + share * (to.radius - from.radius);
            let own = &self.wood.segments[child as usize];
            let (bearer, node) = if is_point || length - along <= radius {
                (None, to)
            } else if along <= radius {
                (Some(first), from)
            } else {
                let is_near = |split: &(f64, Point)| along - split.0 <= radius;
                if !splits.last().is_some_and(is_near) {
                    let position = from.position + share * span;
                    splits.push((along, Point { position, radius }));
                }
                let (_, split) = splits[splits.len() - 1];
                (Some(first + index_u32(splits.len())), split)
            };
            let start = own.start.unwrap_or(node.position);
            let reach = node.radius.max(ROUNDING / self.unit);
            let is_outside = start.distance(node.position) > reach;
            if is_outside {
                let message =
                    "branches that start outside of the wood that bears them: led back to its axis";
                report.add(ReportKind::Repaired, 1, place_of(own.line), message);
            }
            heads.push(Head {
                segment: child,
                bearer,
                level: level + 1,
                start,
                bridge: is_outside.then_some(node.position),
            });
        }
        let last = if is_point {
            first
        } else {
            first + index_u32(splits.len()) + 1
        };
        for head in heads {
            let bearer = head.bearer.or(Some(last));
            self.waiting.push_back(Head { bearer, ..head });
        }
        splits.into_iter().map(|(_, split)| split).collect()
    }

    fn next_node(&self) -> u32 {
        index_u32(self.grown.skeleton.nodes.len())
    }

    fn node(&self, point: Point) -> Node {
        Node {
            position: self.frame.point(point.position),
            radius: self.frame.length(point.radius),
        }
    }

    fn push(&mut self, point: Point) {
        let node = self.node(point);
        self.grown.skeleton.nodes.push(node);
    }
}
