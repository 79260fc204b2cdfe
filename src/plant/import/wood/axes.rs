//! Which segments make an axis.

use super::{Segment, Wood, place_of};
use crate::math::index_u32;
use crate::plant::import::{ImportReport, ReportKind};

/// No segment.
pub(super) const NONE: u32 = u32::MAX;

/// Segments as a forest.
#[derive(Debug)]
pub(super) struct Axes {
    /// The parent of each segment, or [`NONE`] for a root; there are no cycles.
    pub(super) parents: Vec<u32>,
    /// The child of each segment that goes on along its axis, or [`NONE`].
    pub(super) next: Vec<u32>,
    /// Where the children of each segment begin in `children`.
    first_child: Vec<u32>,
    /// The children of all segments, in the order of the file.
    children: Vec<u32>,
}

impl Axes {
    pub(super) fn of(wood: &Wood, report: &mut ImportReport) -> Self {
        let parents = without_cycles(wood, report);
        let mut first_child = vec![0_u32; parents.len() + 1];
        for &parent in parents.iter().filter(|&&parent| parent != NONE) {
            first_child[parent as usize + 1] += 1;
        }
        for place in 1..first_child.len() {
            first_child[place] += first_child[place - 1];
        }
        let mut children = vec![NONE; first_child[parents.len()] as usize];
        let mut free = first_child.clone();
        for (child, &parent) in (0_u32..).zip(&parents) {
            if parent != NONE {
                children[free[parent as usize] as usize] = child;
                free[parent as usize] += 1;
            }
        }
        let mut axes = Self {
            next: vec![NONE; parents.len()],
            parents,
            first_child,
            children,
        };
        axes.note_roots(wood, report);
        for segment in 0..index_u32(axes.parents.len()) {
            axes.next[segment as usize] = axes.successor(wood, segment, report);
        }
        axes
    }

    /// The children of a segment, in the order of the file.
    pub(super) fn children(&self, segment: u32) -> &[u32] {
        let ends = [segment, segment + 1].map(|place| self.first_child[place as usize] as usize);
        &self.children[ends[0]..ends[1]]
    }

    /// The segments without a parent.
    pub(super) fn roots(&self) -> impl Iterator<Item = u32> {
        let parents = (0_u32..).zip(&self.parents);
        parents
            .filter(|(_, parent)| **parent == NONE)
            .map(|(root, _)| root)
    }

    fn note_roots(&self, wood: &Wood, report: &mut ImportReport) {
        if let Some(second) = self.roots().nth(1) {
            let place = place_of(wood.segments[second as usize].line);
            let message = "stems that no other bears: one plant of several stems";
            report.add(
                ReportKind::Merged,
                self.roots().count() as u64,
                place,
                message,
            );
        }
    }

    /// The child that goes on: the first that is told to, or else the thickest, and of those within a tenth
    /// of its radius the straightest.
    fn successor(&self, wood: &Wood, segment: u32, report: &mut ImportReport) -> u32 {
        let children = self.children(segment);
        let of = |child: &u32| &wood.segments[*child as usize];
        let mut told = children
            .iter()
            .filter(|child| of(child).follows == Some(true));
        if let Some(&first) = told.next() {
            if let Some(second) = told.next() {
                let message = "a second one that goes on along the same axis: taken as a branch";
                let count = 1 + told.count() as u64;
                report.add(
                    ReportKind::Repaired,
                    count,
                    place_of(of(second).line),
                    message,
                );
            }
            return first;
        }
        let untold = || {
            children
                .iter()
                .filter(|child| of(child).follows.is_none())
                .copied()
        };
        if untold().nth(1).is_some() {
            let line = wood.segments[segment as usize].line;
            let message = "forks of which the file does not say what goes on: the thickest does, of those \
                           within a tenth of its radius the straightest";
            report.add(ReportKind::Guessed, 1, place_of(line), message);
        }
        let thickness = |child: u32| thickness(of(&child));
        let most = untold().map(thickness).fold(0.0, f64::max);
        let before = self.direction(wood, segment);
        let mut best = (f64::NEG_INFINITY, NONE);
        for child in untold().filter(|&child| thickness(child) >= 0.9 * most) {
            let straightness = before.dot(self.direction(wood, child));
            if best.1 == NONE || straightness > best.0 {
                best = (straightness, child);
            }
        }
        best.1
    }

    /// Where a segment starts.
    pub(super) fn start(&self, wood: &Wood, segment: u32) -> crate::math::DVec3 {
        let own = &wood.segments[segment as usize];
        let parent = self.parents[segment as usize];
        own.start.unwrap_or_else(|| {
            let bearer = wood.segments.get(parent as usize);
            bearer.map_or(own.end, |bearer| bearer.end)
        })
    }

    fn direction(&self, wood: &Wood, segment: u32) -> crate::math::DVec3 {
        let end = wood.segments[segment as usize].end;
        (end - self.start(wood, segment)).normalize_or_zero()
    }
}

/// A segment's radius where it starts, as far as it is known.
pub(super) fn thickness(segment: &Segment) -> f64 {
    segment.start_radius.or(segment.end_radius).unwrap_or(0.0)
}

/// The parents; where they lead in a circle, one segment of it becomes a root.
fn without_cycles(wood: &Wood, report: &mut ImportReport) -> Vec<u32> {
    let count = wood.segments.len();
    let parent = |segment: &Segment| segment.parent.filter(|&parent| (parent as usize) < count);
    let mut parents: Vec<u32> = wood
        .segments
        .iter()
        .map(|segment| parent(segment).unwrap_or(NONE))
        .collect();
    // The walk that came by, from 1.
    let mut walks = vec![0_u32; count];
    for start in 0..index_u32(count) {
        let walk = start + 1;
        let mut at = start;
        while walks[at as usize] == 0 {
            walks[at as usize] = walk;
            let up = parents[at as usize];
            if up == NONE {
                break;
            }
            if walks[up as usize] == walk {
                parents[up as usize] = NONE;
                let line = wood.segments[up as usize].line;
                let message = "parents that lead in a circle: one of each becomes a root";
                report.add(ReportKind::Repaired, 1, place_of(line), message);
                break;
            }
            at = up;
        }
    }
    parents
}
