//! Branch strokes: from coarse to fine in one list a branch, of which a view reads the beginning.
//!
//! ```text
//!   branch, level 2    ▬▬▬▬▬ ▬▬▬▬▬ ▬▬▬▬▬ │ ▬▬ │ ▬▬ │ ▬ │ ▬ │ …
//!                       the three pieces │  one more a level of detail
//!                       always read ─────┴──────▶ as far as level and distance allow
//! ```

use std::ops::Range;

use crate::math::{Vec3, det, index_u32, whole_u32};
use crate::plant::{Branch, Node, Skeleton, Stroke};

/// How many strokes branches have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BranchStrokeOptions {
    /// How many the coarsest level of detail of every branch has, at least 1.
    pub least: u32,
    /// How many each finer one has more. A branch on the last branching level has no finer ones, one on
    /// the level before has one, and so on down to the trunk.
    pub step: u32,
}

impl BranchStrokeOptions {
    /// Three strokes a branch ([CQHCVL06](crate::references), section 3.1), and one more for each level
    /// of detail. The paper does not print its rule; with this one, its tree has 34,439 strokes before
    /// pruning, where 33,663 are left of the paper's after it.
    pub const PUBLISHED: Self = Self { least: 3, step: 1 };
}

/// From where branches are seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchView {
    /// Where the eye is, in the plant's space.
    pub eye: Vec3,
    /// What it looks at: the middle of the plant, whose distance is that of the view.
    pub target: Vec3,
    /// How many pixels a metre is at a distance of one metre.
    pub pixels: f32,
    /// Up to this distance, in metres, branches have all their strokes.
    pub full_distance: f32,
    /// Branches that are seen shorter than this, in pixels, are left out.
    pub least_pixels: f32,
}

/// The strokes of all branches of a skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchStrokes {
    options: BranchStrokeOptions,
    strokes: Vec<Stroke>,
    /// The first stroke of each branch, and the number of all.
    firsts: Vec<u32>,
}

impl BranchStrokes {
    /// Strokes along every branch.
    ///
    /// The first ones are as many equal pieces of the branch, as wide as it is; each further one lies on
    /// the surface, at places that halve what is bare, a golden angle on, and is shorter than those
    /// before.
    ///
    /// # Panics
    ///
    /// When there are 2³² strokes or more: only with options far beyond what a painter puts down.
    #[must_use]
    pub fn new(skeleton: &Skeleton, options: BranchStrokeOptions) -> Self {
        let deepest = skeleton.branches.iter().map(|branch| branch.level).max();
        let mut strokes = Vec::new();
        let mut firsts = vec![0];
        for branch in &skeleton.branches {
            let finer = options
                .step
                .saturating_mul(deepest.unwrap_or(0) - branch.level);
            let axis = Axis::of(skeleton.nodes_of(branch));
            let least = options.least.max(1);
            strokes.extend((0..least).map(|piece| axis.piece(piece, least)));
            strokes.extend((1..=finer).map(|place| axis.touch(place, least)));
            firsts.push(index_u32(strokes.len()));
        }
        Self {
            options,
            strokes,
            firsts,
        }
    }

    /// All strokes, branch by branch, each branch's from coarse to fine.
    #[must_use]
    pub fn strokes(&self) -> &[Stroke] {
        &self.strokes
    }

    /// The strokes of a branch.
    ///
    /// # Panics
    ///
    /// When there is no such branch.
    #[must_use]
    pub fn of_branch(&self, branch: usize) -> Range<u32> {
        self.firsts[branch]..self.firsts[branch + 1]
    }

    /// What a view reads, a run of [`strokes`](Self::strokes) for each branch that is not too short to be
    /// seen ([CQHCVL06](crate::references), section 5.1): of those beyond the least, the share
    /// `full_distance / distance`, rounded down. `skeleton` is that of which they were made.
    pub fn read<'a>(
        &'a self,
        skeleton: &'a Skeleton,
        view: &BranchView,
    ) -> impl Iterator<Item = Range<u32>> + 'a {
        let view = *view;
        let distance = view.eye.distance(view.target);
        let share = if distance > view.full_distance {
            view.full_distance / distance
        } else {
            1.0
        };
        let forward = (view.target - view.eye).normalize_or(-Vec3::Z);
        let branches = skeleton.branches.iter().enumerate();
        branches.filter_map(move |(number, branch)| {
            let run = self.of_branch(number);
            let finer = (run.end - run.start) - self.options.least.max(1);
            let read = whole_u32(f64::from(share) * f64::from(finer));
            let seen = seen_length(skeleton, branch, &view, forward);
            let end = run.end - finer + read.min(finer);
            (seen >= view.least_pixels).then_some(run.start..end)
        })
    }

    /// How many strokes a view reads.
    #[must_use]
    pub fn count(&self, skeleton: &Skeleton, view: &BranchView) -> u32 {
        let runs = self.read(skeleton, view);
        runs.fold(0, |sum, run| sum + (run.end - run.start))
    }

    /// Bytes of the list with the first stroke of every branch: every level of detail, once.
    #[must_use]
    pub fn implicit_bytes(&self) -> u64 {
        self.strokes.len() as u64 * u64::from(Stroke::STRIDE) + 4 * self.firsts.len() as u64
    }

    /// Bytes of a copy of every level of detail of every branch, each with its first stroke.
    #[must_use]
    pub fn copied_bytes(&self) -> u64 {
        let least = u64::from(self.options.least.max(1));
        let branches = self.firsts.windows(2);
        branches.fold(0, |sum, ends| {
            let all = u64::from(ends[1] - ends[0]);
            let step = u64::from(self.options.step.max(1));
            let levels = (all - least) / step + 1;
            // least, least + step, …, all: an arithmetic series.
            let strokes = levels * (least + all) / 2;
            sum + strokes * u64::from(Stroke::STRIDE) + 4 * levels
        })
    }
}

/// How long a branch is seen, in pixels: its pieces as they are projected; one that reaches behind the
/// eye is seen for ever long.
fn seen_length(skeleton: &Skeleton, branch: &Branch, view: &BranchView, forward: Vec3) -> f32 {
    let projected = |node: &Node| {
        let to = node.position - view.eye;
        let depth = to.dot(forward);
        (depth > 0.0).then(|| (to - depth * forward) * (view.pixels / depth))
    };
    let nodes = skeleton.nodes_of(branch);
    nodes.windows(2).fold(0.0, |sum, ends| {
        sum + match (projected(&ends[0]), projected(&ends[1])) {
            (Some(start), Some(end)) => start.distance(end),
            _ => f32::INFINITY,
        }
    })
}

/// A branch's axis, by the share of its length.
struct Axis<'a> {
    nodes: &'a [Node],
    /// The distance of each node from the base.
    along: Vec<f32>,
}

/// The golden angle: successive strokes are spread evenly around.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// How wide a stroke on the surface is, as a share of the branch.
const TOUCH_WIDTH: f32 = 0.6;

impl<'a> Axis<'a> {
    fn of(nodes: &'a [Node]) -> Self {
        let mut along = vec![0.0];
        let mut length = 0.0;
        for ends in nodes.windows(2) {
            length += ends[0].position.distance(ends[1].position);
            along.push(length);
        }
        Self { nodes, along }
    }

    /// The point at a share of the length, and the radius there.
    fn at(&self, share: f32) -> (Vec3, f32) {
        let (last, tip) = (self.along.len() - 1, self.nodes[self.nodes.len() - 1]);
        let wanted = share * self.along[last];
        let after = self.along.partition_point(|along| *along <= wanted);
        if after > last {
            return (tip.position, tip.radius);
        }
        let (first, second) = (self.nodes[after - 1], self.nodes[after]);
        let from = self.along[after - 1];
        let within = (wanted - from) / (self.along[after] - from);
        (
            first.position + within * (second.position - first.position),
            first.radius + within * (second.radius - first.radius),
        )
    }

    /// One of `pieces` equal parts of the branch.
    fn piece(&self, piece: u32, pieces: u32) -> Stroke {
        let share = |end: u32| end as f32 / pieces as f32;
        let ((start, _), (end, _)) = (self.at(share(piece)), self.at(share(piece + 1)));
        let (_, radius) = self.at((piece as f32 + 0.5) / pieces as f32);
        let along = 0.5 * (end - start);
        let (outwards, _) = around(along, piece as f32 * GOLDEN_ANGLE);
        Stroke {
            center: 0.5 * (start + end),
            along,
            across: radius * outwards,
        }
    }

    /// The `place`th stroke on the surface, from 1.
    fn touch(&self, place: u32, least: u32) -> Stroke {
        let share = halving(place);
        let half = 0.5 / (least + place) as f32;
        let (start, _) = self.at((share - half).max(0.0));
        let (end, _) = self.at((share + half).min(1.0));
        let (middle, radius) = self.at(share);
        let along = 0.5 * (end - start);
        let angle = (least + place) as f32 * GOLDEN_ANGLE;
        let (outwards, beside) = around(along, angle);
        Stroke {
            center: middle + radius * outwards,
            along,
            across: TOUCH_WIDTH * radius * beside,
        }
    }
}

/// Two directions across an axis: one at an angle around it, and a quarter turn before.
fn around(axis: Vec3, angle: f32) -> (Vec3, Vec3) {
    let axis = axis.normalize_or(Vec3::Y);
    let first = axis.any_orthonormal_vector();
    let second = axis.cross(first);
    let (sine, cosine) = det::sin_cos(angle);
    let outwards = cosine * first + sine * second;
    (outwards, axis.cross(outwards))
}

/// The `place`th of the numbers 1/2, 1/4, 3/4, 1/8, 5/8 …: the digits of the place mirrored at the point.
fn halving(place: u32) -> f32 {
    // At most 24 digits, so that the number is exact and below 1.
    (place.reverse_bits() >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trunk of 8 m, and two branches of 3 m at its end: one across the view, one towards it.
    fn fork() -> Skeleton {
        let node = |x: f32, y: f32, z: f32| Node {
            position: Vec3::new(x, y, z),
            radius: 0.1,
        };
        let branch = |bearer, level, first_node, node_count| Branch {
            bearer,
            level,
            first_node,
            node_count,
        };
        Skeleton {
            nodes: vec![
                node(0.0, -6.0, 0.0),
                node(0.0, 0.0, 0.0),
                node(0.0, 2.0, 0.0),
                node(0.0, 0.0, 0.0),
                node(3.0, 0.0, 0.0),
                node(0.0, 0.0, 0.0),
                node(0.0, 0.0, 3.0),
            ],
            branches: vec![
                branch(None, 0, 0, 3),
                branch(Some(1), 1, 3, 2),
                branch(Some(1), 1, 5, 2),
            ],
        }
    }

    fn view(distance: f32, least_pixels: f32) -> BranchView {
        BranchView {
            eye: distance * Vec3::Z,
            target: Vec3::ZERO,
            pixels: 100.0,
            full_distance: 10.0,
            least_pixels,
        }
    }

    #[test]
    fn pieces_cover_a_branch_and_touches_lie_on_its_surface() {
        let skeleton = fork();
        let strokes = BranchStrokes::new(&skeleton, BranchStrokeOptions { least: 4, step: 2 });
        assert_eq!(strokes.of_branch(0), 0..6);
        assert_eq!(strokes.of_branch(1), 6..10);
        let heights: Vec<f32> = strokes.strokes()[..4]
            .iter()
            .map(|piece| piece.center.y)
            .collect();
        assert_eq!(heights, [-5.0, -3.0, -1.0, 1.0]);
        for piece in &strokes.strokes()[..4] {
            assert_eq!(piece.along, Vec3::Y);
            assert!((piece.across.length() - 0.1).abs() < 1e-6);
        }
        for (touch, height) in strokes.strokes()[4..6].iter().zip([-2.0, -4.0]) {
            assert!((touch.center.y - height).abs() < 1e-5, "{}", touch.center);
            let away = Vec3::new(touch.center.x, 0.0, touch.center.z);
            assert!((away.length() - 0.1).abs() < 1e-6);
            assert!(touch.normal().dot(away) > 0.09, "faces outwards");
        }
    }

    #[test]
    fn less_is_read_of_what_is_far_and_nothing_of_what_is_not_seen() {
        let skeleton = fork();
        let strokes = BranchStrokes::new(&skeleton, BranchStrokeOptions { least: 3, step: 4 });
        let read = |distance, pixels| -> Vec<Range<u32>> {
            strokes.read(&skeleton, &view(distance, pixels)).collect()
        };
        assert_eq!(read(10.0, 0.0), [0..7, 7..10, 10..13]);
        assert_eq!(read(20.0, 0.0), [0..5, 7..10, 10..13]);
        assert_eq!(read(1e6, 0.0), [0..3, 7..10, 10..13]);
        // The branch towards the eye has no length in the picture; 3 m at 100 m are 3 pixels.
        assert_eq!(read(100.0, 1.0), [0..3, 7..10]);
        let alone = read(100.0, 3.5);
        assert_eq!((alone.len(), &alone[0]), (1, &(0..3)));
        assert_eq!(strokes.count(&skeleton, &view(100.0, 1.0)), 6);
        // Behind the eye nothing is judged.
        assert_eq!(read(1.0, 1e9).len(), 1);
    }

    #[test]
    fn one_list_is_smaller_than_a_copy_of_every_level() {
        let strokes = BranchStrokes::new(&fork(), BranchStrokeOptions::PUBLISHED);
        assert_eq!(strokes.implicit_bytes(), 10 * 36 + 16);
        // 3 and 4 strokes of the trunk, 3 of each branch.
        assert_eq!(strokes.copied_bytes(), 13 * 36 + 16);
    }
}
