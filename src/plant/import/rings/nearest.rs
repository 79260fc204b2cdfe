//! Which of many axes a point is nearest to: a tree of boxes, halved along their longest side.

use crate::math::{DVec3, index_u32};

/// A piece of a tube's axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Its tube; a point may ask for tubes below a number alone.
    pub(super) tube: u32,
    pub(super) ends: [DVec3; 2],
    pub(super) radii: [f64; 2],
}

impl Axis {
    /// How far a point is from the wood around the axis; below 0 within.
    fn gap(&self, point: DVec3) -> f64 {
        let [start, end] = self.ends;
        let span = end - start;
        let square = span.length_squared();
        let share = if square > 0.0 {
            ((point - start).dot(span) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let radius = self.radii[0] + share * (self.radii[1] - self.radii[0]);
        point.distance(start + share * span) - radius
    }
}

/// Axes in boxes.
#[derive(Debug)]
pub(super) struct Axes<'a> {
    axes: &'a [Axis],
    /// The axes, box by box.
    order: Vec<u32>,
    boxes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    least: DVec3,
    most: DVec3,
    radius: f64,
    /// The least number of a tube within.
    tube: u32,
    /// A run of `order`.
    first: u32,
    count: u32,
    /// The first of two boxes that follow one another, or 0 for none.
    halves: u32,
}

/// Axes of a box that is not halved further.
const LEAF: u32 = 4;

impl<'a> Axes<'a> {
    pub(super) fn new(axes: &'a [Axis]) -> Self {
        let mut all = Self {
            axes,
            order: (0..index_u32(axes.len())).collect(),
            boxes: Vec::new(),
        };
        all.boxes.push(all.node(0, index_u32(axes.len())));
        let mut next = 0;
        while next < all.boxes.len() {
            all.halve(next);
            next += 1;
        }
        all
    }

    fn node(&self, first: u32, count: u32) -> Node {
        let mut node = Node {
            least: DVec3::INFINITY,
            most: DVec3::NEG_INFINITY,
            radius: 0.0,
            tube: u32::MAX,
            first,
            count,
            halves: 0,
        };
        for &axis in &self.order[first as usize..(first + count) as usize] {
            let axis = &self.axes[axis as usize];
            for end in axis.ends {
                node.least = node.least.min(end);
                node.most = node.most.max(end);
            }
            node.radius = node.radius.max(axis.radii[0]).max(axis.radii[1]);
            node.tube = node.tube.min(axis.tube);
        }
        node
    }

    fn halve(&mut self, number: usize) {
        let node = self.boxes[number];
        if node.count <= LEAF {
            return;
        }
        let size = node.most - node.least;
        let side = (0..3).fold(
            0,
            |best, side| if size[side] > size[best] { side } else { best },
        );
        let axes = self.axes;
        let middle = |axis: u32| {
            let [start, end] = axes[axis as usize].ends;
            start[side] + end[side]
        };
        let run = &mut self.order[node.first as usize..(node.first + node.count) as usize];
        let half = node.count / 2;
        run.select_nth_unstable_by(half as usize, |&a, &b| {
            middle(a).total_cmp(&middle(b)).then(a.cmp(&b))
        });
        let low = self.node(node.first, half);
        let high = self.node(node.first + half, node.count - half);
        self.boxes[number].halves = index_u32(self.boxes.len());
        self.boxes.extend([low, high]);
    }

    /// The axis of a tube below `before` in whose wood a point is deepest, or to which it is nearest, and
    /// how far it is from there; of equals the first.
    pub(super) fn nearest(&self, point: DVec3, before: u32) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut stack = vec![0_u32];
        while let Some(number) = stack.pop() {
            let node = &self.boxes[number as usize];
            let outside = (node.least - point).max(point - node.most).max(DVec3::ZERO);
            let least = outside.length() - node.radius;
            if node.tube >= before || best.is_some_and(|(_, gap)| least > gap) {
                continue;
            }
            if node.halves != 0 {
                stack.extend([node.halves, node.halves + 1]);
                continue;
            }
            let run = node.first as usize..(node.first + node.count) as usize;
            for &number in &self.order[run] {
                let axis = &self.axes[number as usize];
                let gap = axis.gap(point);
                let is_better = best.is_none_or(|best| (gap, number) < (best.1, best.0));
                if axis.tube < before && is_better {
                    best = Some((number, gap));
                }
            }
        }
        best
    }
}
