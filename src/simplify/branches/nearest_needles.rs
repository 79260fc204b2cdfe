//! Which two needles are nearest, as needles come and go.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::needles::{Needle, NeedleSequence, NeedleUnit};
use super::octree::Octree;
use crate::math::{Aabb, Vec3, det};

/// A quarter by a right angle.
pub(super) const PER_RADIAN: f32 = 0.25 / std::f32::consts::FRAC_PI_2;

/// The needles of a group that are left.
#[derive(Debug)]
pub(super) struct NearestNeedles {
    /// Their middles: no needle is nearer than its middle says.
    tree: Octree,
    /// The direction of every needle, kept because it is asked for most.
    directions: Vec<Vec3>,
    per_metre: f32,
    per_rank: f32,
    /// The nearest of each needle when it last looked: the value's bits, which sort as it does, and
    /// both numbers. The nearest two of all are always there: the later born of them found it.
    heap: BinaryHeap<Reverse<(u32, u32, u32)>>,
    gone: Vec<bool>,
}

impl NearestNeedles {
    /// All needles of a group.
    pub(super) fn of(all: &NeedleSequence, group: Range<u32>, unit: NeedleUnit) -> Self {
        let needles = &all.needles()[group.start as usize..group.end as usize];
        let count = needles.len();
        let bounds = Aabb::of(needles.iter().flat_map(|needle| needle.ends));
        let unit = match unit {
            NeedleUnit::Crown => bounds.size().length(),
            NeedleUnit::Needle => {
                let sum = needles
                    .iter()
                    .fold(0.0, |sum, needle| sum + needle.length());
                sum / count as f32
            }
        };
        let mut nearest = Self {
            tree: Octree::new(bounds),
            directions: all.needles().iter().map(Needle::direction).collect(),
            per_metre: 0.25 / unit.max(1e-9),
            per_rank: 0.5 / count as f32,
            heap: BinaryHeap::with_capacity(2 * count),
            gone: vec![false; all.needles().len() + count],
        };
        for number in group.clone() {
            nearest.insert(all, number);
        }
        for number in group {
            nearest.look(all, number);
        }
        nearest
    }

    /// Takes out the two nearest, the lower number first; `None` when only one is left.
    pub(super) fn next_pair(&mut self, all: &NeedleSequence) -> Option<[u32; 2]> {
        while let Some(Reverse((_, one, other))) = self.heap.pop() {
            if self.gone[one as usize] {
                continue;
            }
            if self.gone[other as usize] {
                // Its nearest is no more: look again.
                self.look(all, one);
                continue;
            }
            self.remove(all, one);
            self.remove(all, other);
            return Some([one.min(other), one.max(other)]);
        }
        None
    }

    /// Adds the needle that stands for two.
    pub(super) fn add(&mut self, all: &NeedleSequence, number: u32) {
        self.directions
            .push(all.needles()[number as usize].direction());
        self.insert(all, number);
        self.look(all, number);
    }

    fn insert(&mut self, all: &NeedleSequence, number: u32) {
        let needle = &all.needles()[number as usize];
        self.tree.insert(number, needle.middle());
    }

    fn remove(&mut self, all: &NeedleSequence, number: u32) {
        let needle = &all.needles()[number as usize];
        self.tree.remove(number, needle.middle());
        self.gone[number as usize] = true;
    }

    /// Finds the nearest of a needle.
    fn look(&mut self, all: &NeedleSequence, number: u32) {
        let needle = all.needles()[number as usize];
        let (line, rank) = (
            self.directions[number as usize],
            all.ranks()[number as usize],
        );
        let (per_metre, per_rank) = (self.per_metre, self.per_rank);
        let value = |other: u32, worst: f32| {
            if other == number {
                return None;
            }
            let candidate = &all.needles()[other as usize];
            let ranks = (rank + all.ranks()[other as usize]) as f32;
            let near = per_metre * needle.distance(candidate) + per_rank * ranks;
            let cosine = line.dot(self.directions[other as usize]).abs().min(1.0);
            // A chord is no longer than its arc: cheap, and refuses most.
            let chord = (2.0 - 2.0 * cosine).max(0.0).sqrt();
            if near + PER_RADIAN * chord > worst {
                return None;
            }
            Some(near + PER_RADIAN * det::acos(cosine))
        };
        let bound = |distance: f32| per_rank * (rank + 1) as f32 + per_metre * distance;
        let best = self.tree.nearest(needle.middle(), bound, value);
        if let Some((found, other)) = best {
            self.heap.push(Reverse((found.to_bits(), number, other)));
        }
    }
}
