//! Conifer needles: two that are alike become one, again and again, until one is left.

use std::ops::Range;

use super::nearest_needles::NearestNeedles;
use crate::math::{Vec3, index_u32};

/// A needle: a thin cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needle {
    /// Its base and its tip, in metres, world space.
    pub ends: [Vec3; 2],
    /// In metres.
    pub radius: f32,
}

/// How thick a needle is that stands for two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NeedleRadius {
    /// The mean of both, by how many needles they stand for: needles stay thin, and the crown loses
    /// mass with every merge.
    Mean,
    /// So thick that length times radius is the sum of both's: the crown keeps its area. A needle that is
    /// less than half as long as the mean of both is taken to be so long, since two that point apart
    /// would make one without length and of any thickness.
    Area,
}

/// What a needle's distance from another is measured by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NeedleUnit {
    /// The diagonal of the box around all needles of the group: every part of the measure is at most its
    /// weight, and needles that are parallel merge across the crown.
    Crown,
    /// The mean length of the group's needles: a needle away is as bad as a right angle, and what is
    /// near merges first.
    Needle,
}

/// How needles merge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NeedleOptions {
    /// How thick a merged needle is.
    pub radius: NeedleRadius,
    /// What distances are measured by.
    pub unit: NeedleUnit,
}

/// All needles of a plant and all that they are merged into
/// ([ZBMJLDC17](crate::references), section 5.5).
///
/// Two needles are the nearer the less the sum of
/// - a quarter of their distance (the mean of that of their bases and that of their tips, or crosswise
///   where that is less) by a [unit](NeedleUnit),
/// - a quarter of the angle between their lines by a right angle,
/// - half of how many needles both stand for together (the paper's merging rank) by the group's count.
///
/// The weights are the paper's; what each part is divided by is ours (the paper adds metres, degrees and
/// counts). Always the nearest two of a group merge, of equals those with the least
/// numbers; both ends of the new needle are means by rank.
///
/// A needle's *error* bounds how far its surface lies from that of every needle it stands for, in both
/// directions: what it moved at each merge, added up. It is at least the needle's diameter, so that with
/// `E5 = E3` a merged needle is a line and never more primitives than what it stands for. An error `E5`
/// is a cut through the trees of merges, and any is answered by looking once at each needle.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NeedleSequence {
    needles: Vec<Needle>,
    ranks: Vec<u32>,
    errors: Vec<f32>,
    /// The error of what a needle is merged into; infinite for the last of a group.
    until: Vec<f32>,
    merges: Vec<[u32; 2]>,
    originals: u32,
}

impl NeedleSequence {
    /// Merges the needles of each group until one is left.
    #[must_use]
    pub fn of(groups: &[Vec<Needle>], options: NeedleOptions) -> Self {
        let needles: Vec<Needle> = groups.concat();
        let count = needles.len();
        let mut sequence = Self {
            ranks: vec![1; count],
            errors: vec![0.0; count],
            until: vec![f32::INFINITY; count],
            merges: Vec::with_capacity(count),
            originals: index_u32(count),
            needles,
        };
        let mut first = 0;
        for group in groups {
            sequence.merge_all(first..first + index_u32(group.len()), options);
            first += index_u32(group.len());
        }
        sequence
    }

    /// All needles: those of the plant, then one a merge.
    #[must_use]
    pub fn needles(&self) -> &[Needle] {
        &self.needles
    }

    /// How many the plant has.
    #[must_use]
    pub fn original_count(&self) -> u32 {
        self.originals
    }

    /// The two needles of every merge, in order; the `m`-th makes needle `original_count + m`.
    #[must_use]
    pub fn merges(&self) -> &[[u32; 2]] {
        &self.merges
    }

    /// How many needles of the plant each stands for.
    #[must_use]
    pub fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    /// How far each may lie from those it stands for, in metres.
    #[must_use]
    pub fn errors(&self) -> &[f32] {
        &self.errors
    }

    /// The error of what each is merged into, in metres: infinite for the last of a group.
    #[must_use]
    pub fn until(&self) -> &[f32] {
        &self.until
    }

    /// The needles of a level with the error `E5`, in metres: each needle of the plant is stood for by
    /// exactly one of them.
    pub fn at(&self, error: f32) -> impl Iterator<Item = u32> {
        let error = if error.is_nan() { 0.0 } else { error };
        let error = error.clamp(0.0, f32::MAX);
        let ways = self.errors.iter().zip(&self.until);
        (0..)
            .zip(ways)
            .filter(move |(_, (own, until))| **own <= error && error < **until)
            .map(|(needle, _)| needle)
    }

    fn merge_all(&mut self, group: Range<u32>, options: NeedleOptions) {
        let mut nearest = NearestNeedles::of(self, group, options.unit);
        while let Some(pair) = nearest.next_pair(self) {
            let new = self.merge(pair, options.radius);
            nearest.add(self, new);
        }
    }

    /// Appends the needle that stands for two.
    fn merge(&mut self, pair: [u32; 2], radius: NeedleRadius) -> u32 {
        let [one, mut other] = pair.map(|old| self.needles[old as usize]);
        if one.is_crosswise(&other) {
            other.ends.reverse();
        }
        let [first, second] = pair.map(|old| self.ranks[old as usize]);
        let share = second as f32 / (first + second) as f32;
        let ends = [0, 1].map(|end: usize| {
            let way = other.ends[end] - one.ends[end];
            one.ends[end] + share * way
        });
        let mean = one.radius + share * (other.radius - one.radius);
        let new = Needle {
            ends,
            radius: match radius {
                NeedleRadius::Mean => mean,
                NeedleRadius::Area => {
                    let area = one.length() * one.radius + other.length() * other.radius;
                    let lengths = one.length() + share * (other.length() - one.length());
                    let length = ends[0].distance(ends[1]).max(0.5 * lengths);
                    if length > 0.0 { area / length } else { mean }
                }
            },
        };
        let moved = pair
            .iter()
            .zip([one, other])
            .map(|(&old, needle)| self.errors[old as usize] + needle.deviation(&new));
        let error = moved.fold(2.0 * new.radius, f32::max);
        for old in pair {
            self.until[old as usize] = error;
        }
        self.needles.push(new);
        self.ranks.push(first + second);
        self.errors.push(error);
        self.until.push(f32::INFINITY);
        self.merges.push(pair);
        index_u32(self.needles.len() - 1)
    }
}

impl Needle {
    pub(super) fn middle(&self) -> Vec3 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// In metres.
    pub(super) fn length(&self) -> f32 {
        self.ends[0].distance(self.ends[1])
    }

    /// From base to tip; +Y for one without length.
    pub(super) fn direction(&self) -> Vec3 {
        (self.ends[1] - self.ends[0]).normalize_or(Vec3::Y)
    }

    /// The mean distances of ends, straight and crosswise.
    fn distances(&self, other: &Self) -> [f32; 2] {
        let [base, tip] = self.ends;
        let [other_base, other_tip] = other.ends;
        [
            0.5 * (base.distance(other_base) + tip.distance(other_tip)),
            0.5 * (base.distance(other_tip) + tip.distance(other_base)),
        ]
    }

    pub(super) fn distance(&self, other: &Self) -> f32 {
        let [straight, crosswise] = self.distances(other);
        straight.min(crosswise)
    }

    fn is_crosswise(&self, other: &Self) -> bool {
        let [straight, crosswise] = self.distances(other);
        crosswise < straight
    }

    /// How far the surface of a needle lies from another's whose ends belong to its own: what the ends
    /// move, what the radius changes, and what the circles around them turn.
    fn deviation(&self, other: &Self) -> f32 {
        let moved = |end: usize| self.ends[end].distance(other.ends[end]);
        let turned = (self.direction() - other.direction()).length();
        moved(0).max(moved(1))
            + (self.radius - other.radius).abs()
            + self.radius.min(other.radius) * turned
    }
}

#[cfg(test)]
mod tests {
    use super::super::nearest_needles::PER_RADIAN;
    use super::*;
    use crate::math::{Draws, Stream, det};

    const MEAN: NeedleOptions = NeedleOptions {
        radius: NeedleRadius::Mean,
        unit: NeedleUnit::Crown,
    };
    const AREA: NeedleOptions = NeedleOptions {
        radius: NeedleRadius::Area,
        unit: NeedleUnit::Needle,
    };

    fn needle(x: f32, tilt: f32) -> Needle {
        Needle {
            ends: [Vec3::X * x, Vec3::new(x + tilt, 1.0, 0.0)],
            radius: 0.015_625,
        }
    }

    fn random(count: usize, draws: &mut Draws) -> Vec<Needle> {
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        (0..count)
            .map(|_| {
                let base = vector();
                Needle {
                    ends: [base, base + 0.1 * vector()],
                    radius: 0.001,
                }
            })
            .collect()
    }

    /// ```text
    ///   │││      │     a and b are nearest, then both with c
    ///   ab c     d
    /// ```
    #[test]
    fn the_nearest_merge_first_and_ranks_weigh() {
        let needles = vec![
            needle(0.0, 0.0),
            needle(0.25, 0.0),
            needle(1.0, 0.0),
            needle(9.0, 0.0),
        ];
        let sequence = NeedleSequence::of(&[needles], MEAN);
        // c and d both stand for one, {a, b} for two: 0.25 · 8 / 9.06 + 0.5 · 2 / 4 = 0.47 is more
        // than 0.25 · 0.875 / 9.06 + 0.5 · 3 / 4 = 0.40.
        assert_eq!(sequence.merges(), [[0, 1], [2, 4], [3, 5]]);
        assert_eq!(sequence.ranks(), [1, 1, 1, 1, 2, 3, 4]);
        let middle = sequence.needles()[5].ends[0].x;
        assert!((middle - 1.25 / 3.0).abs() < 1e-6, "{middle}");
        assert_eq!(sequence.errors()[4], 0.125);
        let at = |error| sequence.at(error).collect::<Vec<u32>>();
        assert_eq!(at(0.0), [0, 1, 2, 3]);
        assert_eq!(at(0.125), [2, 3, 4]);
        assert_eq!(at(f32::INFINITY), [6]);
        assert_eq!(at(f32::NAN), at(0.0));
    }

    #[test]
    fn needles_that_point_the_other_way_are_alike() {
        let mut turned = needle(0.1, 0.0);
        turned.ends.reverse();
        let sequence = NeedleSequence::of(&[vec![needle(0.0, 0.0), turned]], AREA);
        let merged = sequence.needles()[2];
        assert!((merged.length() - 1.0).abs() < 1e-6);
        // Area is kept: twice as thick.
        assert!((merged.radius - 0.031_25).abs() < 1e-6);
    }

    #[test]
    fn the_octree_finds_what_looking_at_all_pairs_finds() {
        let mut draws = Stream::new(9, 0).draws();
        for count in [2, 3, 10, 60] {
            let needles = random(count, &mut draws);
            let sequence = NeedleSequence::of(std::slice::from_ref(&needles), AREA);
            assert_eq!(sequence.merges(), by_hand(&needles));
        }
    }

    /// The same merges with a look at every pair.
    fn by_hand(needles: &[Needle]) -> Vec<[u32; 2]> {
        let mut all = NeedleSequence::of(&[], AREA);
        all.needles = needles.to_vec();
        all.ranks = vec![1; needles.len()];
        all.errors = vec![0.0; needles.len()];
        all.until = vec![0.0; needles.len()];
        let lengths = needles
            .iter()
            .fold(0.0, |sum, needle| sum + needle.length());
        let count = needles.len() as f32;
        let (per_metre, per_rank) = (0.25 / (lengths / count), 0.5 / count);
        let mut left: Vec<u32> = (0..index_u32(needles.len())).collect();
        while left.len() > 1 {
            let mut best: Option<(f32, [u32; 2])> = None;
            for (place, &one) in left.iter().enumerate() {
                for &other in &left[place + 1..] {
                    let [a, b] = [one, other].map(|number| all.needles[number as usize]);
                    let ranks = all.ranks[one as usize] + all.ranks[other as usize];
                    let cosine = a.direction().dot(b.direction()).abs().min(1.0);
                    let value = per_metre * a.distance(&b)
                        + per_rank * ranks as f32
                        + PER_RADIAN * det::acos(cosine);
                    if best.is_none_or(|best| value < best.0) {
                        best = Some((value, [one, other]));
                    }
                }
            }
            let (_, pair) = best.expect("two are left");
            left.retain(|number| !pair.contains(number));
            left.push(all.merge(pair, AREA.radius));
        }
        all.merges
    }

    #[test]
    fn every_needle_is_stood_for_once_within_its_error() {
        let mut draws = Stream::new(4, 0).draws();
        let groups = [random(40, &mut draws), Vec::new(), random(1, &mut draws)];
        for options in [MEAN, AREA] {
            let sequence = NeedleSequence::of(&groups, options);
            assert_eq!(sequence.merges().len(), 39);
            let mut last = usize::MAX;
            for error in [0.0, 0.05, 0.1, 0.3, 1.0, 10.0] {
                let level: Vec<u32> = sequence.at(error).collect();
                assert!(level.len() <= last);
                last = level.len();
                let stood_for: u32 = level.iter().map(|&n| sequence.ranks()[n as usize]).sum();
                assert_eq!(stood_for, 41);
            }
            assert_eq!(last, 2);
        }
    }
}
