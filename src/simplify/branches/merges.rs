//! Internode merging: what every merge of a branch costs, computed once for all errors.
//!
//! ```text
//!  nodes      0────1────2────3────4          a merge k → l drops what lies between and keeps the
//!  merges     └─────────┘    ┊    ┊          skeletal vectors of both ends
//!                  └─────────┘    ┊
//!             └───────────────────┘
//! ```

use super::skeletal::{BranchAxis, BranchSkeleton, SkeletalVector};
use crate::math::{Vec3, det, index_u32};

/// Merges of up to this many internodes are all there; see [`MergeTable`].
pub const WHOLE_MERGES: usize = 16;

/// Two nodes of a branch between which all others may go, and what that costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Merge {
    /// The node that begins it, counted through all branches.
    pub from: u32,
    /// The deviation `φ` of the axis, in metres: the longest `X` of eq. 4.
    pub skeleton: f32,
    /// The deviation `ϕ` of radius and frame, in metres: √2 times the longest `Y` or `Z` of eq. 4.
    pub radius: f32,
}

/// All merges that the torsion limit admits, with their errors
/// ([ZBMJLDC17](crate::references), eqs. 2–5).
///
/// A merge of `k → l` moves no point of the surface by more than `ψ = φ + ϕ`, in either direction:
/// points at equal arc length and angle belong together, their difference is linear between nodes,
/// so that it is longest at one.
///
/// How many there are is bounded: of up to [`WHOLE_MERGES`] internodes all; of up to twice as many
/// those whose ends are even, of up to four times those whose ends are multiples of four, and so
/// on, where the tip counts as a multiple of any number. So a branch of `K` internodes has less
/// than `32 K` of them, and the merge of all of it is always among them. (The paper's index range
/// leaves out all that reach the tip.)
///
/// Single internodes are not listed: they are always there and cost nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MergeTable {
    merges: Vec<Merge>,
    /// Where the merges that end at a node begin; one more than there are nodes.
    first: Vec<usize>,
}

impl MergeTable {
    /// The merges of all branches.
    ///
    /// `torsion_limit` (`Γ`, in radians) bounds the twist between the ends by what they lean from
    /// the merged segment together: `∠(T_k, L) + ∠(T_l, L)`, after eq. A2, with `L` the direction
    /// from the first node to the last.
    #[must_use]
    pub fn of(skeleton: &BranchSkeleton, torsion_limit: f32) -> Self {
        let mut table = Self {
            merges: Vec::new(),
            first: Vec::with_capacity(skeleton.vectors.len() + 1),
        };
        let limit = det::cos(torsion_limit.clamp(0.0, std::f32::consts::PI));
        for branch in &skeleton.branches {
            table.add(skeleton, branch, limit);
        }
        table.first.push(table.merges.len());
        table
    }

    /// The merges that end at a node, by where they begin.
    ///
    /// # Panics
    ///
    /// When there is no such node.
    #[must_use]
    pub fn ending_at(&self, node: usize) -> &[Merge] {
        &self.merges[self.first[node]..self.first[node + 1]]
    }

    /// How many merges there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.merges.len()
    }

    fn add(&mut self, skeleton: &BranchSkeleton, branch: &BranchAxis, limit: f32) {
        let vectors = skeleton.vectors_of(branch);
        let along = &skeleton.along[branch.run()];
        let tip = vectors.len() - 1;
        for to in 0..=tip {
            self.first.push(self.merges.len());
            for from in starts(to, tip) {
                if !twists_less(&vectors[from], &vectors[to], limit) {
                    continue;
                }
                let (skeleton, radius) = deviation(&vectors[from..=to], &along[from..=to]);
                self.merges.push(Merge {
                    from: branch.first + index_u32(from),
                    skeleton,
                    radius,
                });
            }
        }
    }
}

/// Where the merges begin that end at a node, lowest first; see [`MergeTable`].
fn starts(to: usize, tip: usize) -> impl Iterator<Item = usize> {
    let mut widest = 1;
    while WHOLE_MERGES * widest < to && (to == tip || to.is_multiple_of(2 * widest)) {
        widest *= 2;
    }
    let steps = std::iter::successors(Some(widest), |step| (*step > 1).then_some(step / 2));
    steps.flat_map(move |step| {
        // Shorter ones are those of the next smaller step.
        let shortest = if step > 1 { WHOLE_MERGES * step / 2 } else { 1 };
        let lowest = to
            .saturating_sub(WHOLE_MERGES * step)
            .next_multiple_of(step);
        (lowest..to.saturating_sub(shortest)).step_by(step)
    })
}

/// Whether both ends together lean from the way between them by no more than the angle whose cosine
/// is `limit`.
fn twists_less(start: &SkeletalVector, end: &SkeletalVector, limit: f32) -> bool {
    let way = (end.position - start.position).normalize_or_zero();
    let [first, second] = [start, end].map(|end| end.frame.tangent.dot(way).clamp(-1.0, 1.0));
    // Of two angles that are more than half a turn together the cosine of the sum rises again.
    if first + second <= 0.0 {
        return false;
    }
    let sine = |cosine: f32| (1.0 - cosine * cosine).max(0.0).sqrt();
    first * second - sine(first) * sine(second) >= limit
}

/// `φ` and `ϕ` of a merge of all internodes between these nodes (eqs. 3–5).
#[must_use]
pub fn deviation(vectors: &[SkeletalVector], along: &[f32]) -> (f32, f32) {
    let (Some(start), Some(end)) = (vectors.first(), vectors.last()) else {
        return (0.0, 0.0);
    };
    let length = along[along.len() - 1] - along[0];
    let [start_normal, end_normal] = [start, end].map(|end| end.radius * end.frame.normal);
    let [start_binormal, end_binormal] = [start, end].map(|end| end.radius * end.frame.binormal);
    let (mut skeleton, mut radius) = (0.0_f32, 0.0_f32);
    for (node, along_node) in vectors.iter().zip(along) {
        let share = if length > 0.0 {
            (along_node - along[0]) / length
        } else {
            0.0
        };
        let blend = |start: Vec3, end: Vec3| (1.0 - share) * start + share * end;
        let x = blend(start.position, end.position) - node.position;
        let y = blend(start_normal, end_normal) - node.radius * node.frame.normal;
        let z = blend(start_binormal, end_binormal) - node.radius * node.frame.binormal;
        skeleton = skeleton.max(x.length_squared());
        radius = radius.max(y.length_squared()).max(z.length_squared());
    }
    (skeleton.sqrt(), std::f32::consts::SQRT_2 * radius.sqrt())
}

#[cfg(test)]
mod tests {
    use super::super::frame::FrameMethod;
    use super::super::tests::branch;
    use super::*;
    use crate::math::Stream;

    fn skeleton(points: &[(Vec3, f32)]) -> BranchSkeleton {
        BranchSkeleton::of(&branch(points), FrameMethod::DoubleReflection)
    }

    /// ```text
    ///       1           the middle node lies a half off the straight way
    ///     ╱   ╲
    ///   0       2
    /// ```
    #[test]
    fn a_roof_deviates_by_its_height_and_a_spindle_by_its_radius() {
        let roof = skeleton(&[
            (Vec3::ZERO, 0.0),
            (Vec3::new(1.0, 0.5, 0.0), 0.0),
            (Vec3::new(2.0, 0.0, 0.0), 0.0),
        ]);
        let table = MergeTable::of(&roof, std::f32::consts::PI);
        let [merge] = table.ending_at(2) else {
            panic!("one merge");
        };
        assert_eq!((merge.from, merge.skeleton, merge.radius), (0, 0.5, 0.0));
        let spindle = skeleton(&[(Vec3::ZERO, 0.0), (Vec3::Y, 0.5), (Vec3::Y * 4.0, 1.0)]);
        let table = MergeTable::of(&spindle, 0.1);
        let [merge] = table.ending_at(2) else {
            panic!("one merge");
        };
        // A quarter of the way up the radius would be 0.25.
        let wanted = std::f32::consts::SQRT_2 * 0.25;
        assert!(merge.skeleton.abs() < 1e-6 && (merge.radius - wanted).abs() < 1e-6);
    }

    #[test]
    fn torsion_limits_merges() {
        // A quarter circle in four steps of 22.5°. All of it leans 33.75° at both ends, three steps
        // 33.75° and 22.5°, two 11.25° and 22.5° from an end, 22.5° twice between.
        let arc: Vec<(Vec3, f32)> = (0_u8..=4)
            .map(|step| {
                let (sine, cosine) = det::sin_cos(std::f32::consts::FRAC_PI_8 * f32::from(step));
                (Vec3::new(cosine, sine, 0.0), 0.1)
            })
            .collect();
        let arc = skeleton(&arc);
        let count = |degrees: f32| MergeTable::of(&arc, degrees.to_radians()).count();
        let found = [0.0, 30.0, 40.0, 50.0, 60.0, 70.0, 180.0].map(count);
        assert_eq!(found, [0, 0, 2, 3, 5, 6, 6]);
    }

    #[test]
    fn merges_are_bounded_and_reach_from_end_to_end() {
        for internodes in [1_usize, 2, 15, 16, 17, 40, 200, 515] {
            let mut draws = Stream::new(1, internodes as u64).draws();
            let mut points = vec![(Vec3::ZERO, 1.0)];
            for _ in 0..internodes {
                let last = points[points.len() - 1].0;
                let aside = Vec3::new(draws.signed(), 0.0, draws.signed());
                points.push((last + Vec3::Y + 0.1 * aside, 1.0));
            }
            let all = skeleton(&points);
            let table = MergeTable::of(&all, std::f32::consts::PI);
            assert!(
                table.count() <= 32 * internodes,
                "{internodes}: {}",
                table.count()
            );
            if internodes > 1 {
                assert_eq!(table.ending_at(internodes)[0].from, 0);
            }
            if internodes <= WHOLE_MERGES {
                assert_eq!(table.count(), internodes * (internodes - 1) / 2);
            }
            for to in 0..points.len() {
                for merge in table.ending_at(to) {
                    let from = merge.from as usize;
                    let found = (merge.skeleton, merge.radius);
                    let wanted = deviation(&all.vectors[from..=to], &all.along[from..=to]);
                    assert_eq!(found, wanted);
                }
            }
        }
    }
}
