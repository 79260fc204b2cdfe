//! How far collapsed leaves lie from the originals: a sound bound in metres for every collapse.
//!
//! The error of a leaf bounds Hausdorff's distance between it and all originals under it: no point
//! of either lies farther from the other. It is found by going up the tree once, with two numbers a
//! leaf, from the originals and to them:
//!
//! ```text
//! away(new)  = max over children (away(child) + h(child → new))     how far originals lie from it
//! back(new)  = max over pieces, min over children (h(piece → child) + back(child))  it from them
//! error(new) = max(away, back, errors of the children)
//! ```
//!
//! `h(A → B)`, how far a point of `A` lies from `B` at most, is bounded in turn, triangle by triangle
//! of `A`: the distance to a triangle is convex, so that of the corners to one and the same triangle
//! of `B` bounds that of all points between them; so does the distance of the corners to those of
//! the same roles. A new leaf mostly spans both children, so on the way back each of its triangles is
//! cut into four at the middles of its edges, and each piece takes the child that it lies nearer to.
//! The bounds add up on the way to the root, so they are generous where collapses go to and fro.

use crate::math::{DVec3, Vec3, index_u32};
use crate::simplify::{Clusters, CollapseSequence};

/// The errors of all collapses of a crown, in metres of the plant's own space.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafErrors {
    of_collapse: Vec<f32>,
    /// By cluster, one more than collapses: the greatest error so far.
    curves: Vec<Vec<f32>>,
}

impl LeafErrors {
    /// The errors of a sequence over these vertices.
    pub(super) fn of(vertices: &[Vec3], sequence: &CollapseSequence, clusters: &Clusters) -> Self {
        let of_collapse = collapse_errors(vertices, sequence);
        let curve = |ops: &[u32]| {
            let steps = ops.iter().scan(0.0_f32, |greatest, &op| {
                *greatest = greatest.max(of_collapse[op as usize]);
                Some(*greatest)
            });
            std::iter::once(0.0).chain(steps).collect()
        };
        let clusters = clusters.clusters.iter();
        let curves = clusters.map(|cluster| curve(&cluster.ops)).collect();
        Self {
            of_collapse,
            curves,
        }
    }

    /// The error of the leaf that each collapse makes; never less than those of its children.
    #[must_use]
    pub fn of_collapses(&self) -> &[f32] {
        &self.of_collapse
    }

    /// The greatest error that a cluster ever showed up to each number of collapses, from none to
    /// all: ascending, the first is 0.
    ///
    /// It is that of the leaves made, not of those that show: a leaf that is gone lies under one
    /// that shows, and that one's error is no less. So both are the same.
    #[must_use]
    pub fn curve(&self, cluster: u32) -> &[f32] {
        &self.curves[cluster as usize]
    }

    /// The most collapses of a cluster whose error in metres `fits`; whoever takes an error must take
    /// all that are less.
    #[must_use]
    pub fn collapses_while(&self, cluster: u32, fits: impl Fn(f32) -> bool) -> u32 {
        let taken = self.curve(cluster).partition_point(|&error| fits(error));
        index_u32(taken.saturating_sub(1))
    }
}

/// What is known of a leaf on the way up.
#[derive(Clone, Copy)]
struct Known {
    away: f64,
    back: f64,
    error: f32,
}

fn collapse_errors(vertices: &[Vec3], sequence: &CollapseSequence) -> Vec<f32> {
    let quad = |leaf: u32| {
        let corners = sequence.corners()[leaf as usize];
        Quad(corners.map(|vertex| vertices[vertex as usize].as_dvec3()))
    };
    let original = Known {
        away: 0.0,
        back: 0.0,
        error: 0.0,
    };
    let mut known = vec![original; sequence.original_count() as usize];
    known.reserve(sequence.collapses().len());
    for (op, collapse) in (0..).zip(sequence.collapses()) {
        let new = quad(sequence.new_leaf(op));
        let mut above = Known {
            away: 0.0,
            back: 0.0,
            error: 0.0,
        };
        let children = collapse.old.map(|old| (known[old as usize], quad(old)));
        for (below, child) in &children {
            above.away = above.away.max(below.away + child.reach_to(&new));
            above.error = above.error.max(below.error);
        }
        let [first, second] = children.map(|(below, child)| {
            let reaches = new.pieces_reach_to(&child);
            reaches.map(|reach| reach + below.back)
        });
        for (first, second) in first.into_iter().zip(second) {
            above.back = above.back.max(first.min(second));
        }
        above.error = above.error.max(rounded_up(above.away.max(above.back)));
        known.push(above);
    }
    let new_leaves = &known[sequence.original_count() as usize..];
    new_leaves.iter().map(|known| known.error).collect()
}

/// As `f32`, not less than it was, nor than it would have been without rounding on the way; the
/// largest finite number at most.
fn rounded_up(error: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "rounds, then goes up")]
    let single = (error * (1.0 + 1e-9)).min(f64::from(f32::MAX)) as f32;
    if single > 0.0 {
        single.next_up().min(f32::MAX)
    } else {
        0.0
    }
}

/// A leaf's corners by role; its triangles are 0-1-2 and 0-2-3.
struct Quad([DVec3; 4]);

const TRIANGLES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

impl Quad {
    /// A bound of how far a point of this quad lies from `other`.
    fn reach_to(&self, other: &Self) -> f64 {
        let same_role: [f64; 4] =
            std::array::from_fn(|role| self.0[role].distance_squared(other.0[role]));
        let greatest = |corners: [usize; 3], squared: [f64; 4]| {
            corners
                .iter()
                .fold(0.0, |most: f64, &role| most.max(squared[role]))
        };
        let by_role = TRIANGLES.map(|corners| greatest(corners, same_role));
        if by_role == [0.0; 2] {
            return 0.0;
        }
        let to_triangles = TRIANGLES.map(|target| {
            let triangle = target.map(|role| other.0[role]);
            std::array::from_fn(|role| {
                // Collapses keep corners in place: most of the time that is all there is to see.
                if target.contains(&role) && same_role[role] == 0.0 {
                    0.0
                } else {
                    distance_squared(self.0[role], triangle)
                }
            })
        });
        let of_triangle = |number: usize| {
            let corners = TRIANGLES[number];
            let [first, second] = to_triangles.map(|squared| greatest(corners, squared));
            by_role[number].min(first).min(second)
        };
        of_triangle(0).max(of_triangle(1)).sqrt()
    }

    /// Bounds of how far points of this quad lie from `other`, for each of the eight pieces of its
    /// triangles.
    fn pieces_reach_to(&self, other: &Self) -> [f64; 8] {
        let [a, b, c, d] = self.0;
        let points = [
            a,
            b,
            c,
            d,
            (a + b) * 0.5,
            (b + c) * 0.5,
            (c + a) * 0.5,
            (c + d) * 0.5,
            (d + a) * 0.5,
        ];
        let [first, second] = TRIANGLES.map(|target| {
            let triangle = target.map(|role| other.0[role]);
            points.map(|point| distance_squared(point, triangle))
        });
        PIECES.map(|corners| {
            let greatest = |squared: &[f64; 9]| {
                let [a, b, c] = corners.map(|corner| squared[corner]);
                a.max(b).max(c)
            };
            greatest(&first).min(greatest(&second)).sqrt()
        })
    }
}

/// The pieces of both triangles, in the points of [`Quad::pieces_reach_to`]: three at the corners,
/// one in the middle.
const PIECES: [[usize; 3]; 8] = [
    [0, 4, 6],
    [1, 4, 5],
    [2, 5, 6],
    [4, 5, 6],
    [0, 6, 8],
    [2, 6, 7],
    [3, 7, 8],
    [6, 7, 8],
];

/// The squared distance of a point to a triangle, which may be a line or a point.
fn distance_squared(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let area_squared = normal.length_squared();
    // Inside all three edges, the plane is nearest.
    let beside_ab = normal.cross(ab).dot(ap);
    let beside_ac = ac.cross(normal).dot(ap);
    let beside_bc = normal.cross(c - b).dot(point - b);
    if area_squared > 0.0 && beside_ab >= 0.0 && beside_ac >= 0.0 && beside_bc >= 0.0 {
        let height = normal.dot(ap);
        return height * height / area_squared;
    }
    let to_edge = |from: DVec3, along: DVec3| {
        let length_squared = along.length_squared();
        let share = if length_squared > 0.0 {
            ((point - from).dot(along) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        point.distance_squared(from + along * share)
    };
    to_edge(a, ab).min(to_edge(a, ac)).min(to_edge(b, c - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::simplify::{Collapse, examples};

    /// ```text
    /// 3──2 3──2      3─────2
    /// │A │ │B │  ─▶  │     │     a gap of 1 between them is covered: 0.5 from either
    /// 0──1 0──1      0─────1
    /// ```
    #[test]
    fn two_squares_apart_are_off_by_half_the_gap() {
        let square = |x: f32| {
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec3::new(x + u, v, 0.0))
        };
        let vertices = [square(0.0), square(2.0)].concat();
        let corners = vec![[0, 1, 2, 3], [4, 5, 6, 7], [0, 5, 6, 3]];
        let collapse = Collapse {
            old: [0, 1],
            cost: 0.0,
        };
        let sequence = CollapseSequence::new(2, corners, vec![collapse]).expect("sound");
        let clusters = Clusters::of(&sequence);
        let errors = LeafErrors::of(&vertices, &sequence, &clusters);
        assert!((errors.of_collapses()[0] - 0.5).abs() < 1e-5);
        assert_eq!(errors.curve(0), [0.0, errors.of_collapses()[0]]);
        assert_eq!(
            [0.0, 0.49, 0.51].map(|limit| errors.collapses_while(0, |error| error <= limit)),
            [0, 0, 1]
        );
    }

    #[test]
    fn distances_to_a_triangle_have_three_kinds_of_nearest_points() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let cases = [
            (DVec3::new(0.2, 0.2, 3.0), 9.0),
            (DVec3::new(0.5, -2.0, 0.0), 4.0),
            (DVec3::new(-3.0, -4.0, 0.0), 25.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.5),
        ];
        for (point, wanted) in cases {
            assert!((distance_squared(point, triangle) - wanted).abs() < 1e-12);
        }
        let line = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert!((distance_squared(DVec3::new(3.0, 1.0, 0.0), line) - 2.0).abs() < 1e-12);
    }

    /// Hausdorff's distance of a leaf to its originals, over points of both: never more than it is.
    fn sampled(vertices: &[Vec3], sequence: &CollapseSequence, leaf: u32) -> f64 {
        let quad = |leaf: u32| {
            let corners = sequence.corners()[leaf as usize];
            corners.map(|vertex| vertices[vertex as usize].as_dvec3())
        };
        let mut originals = Vec::new();
        let mut pending = vec![leaf];
        while let Some(leaf) = pending.pop() {
            match leaf.checked_sub(sequence.original_count()) {
                Some(op) => pending.extend(sequence.collapses()[op as usize].old),
                None => originals.push(quad(leaf)),
            }
        }
        let triangles = |quad: [DVec3; 4]| TRIANGLES.map(|corners| corners.map(|role| quad[role]));
        let one_way = |from: &[[DVec3; 4]], to: &[[DVec3; 4]]| {
            let mut most = 0.0_f64;
            for [a, b, c] in from.iter().flat_map(|&quad| triangles(quad)) {
                for (i, j) in (0..=6).flat_map(|i| (0..=6 - i).map(move |j| (i, j))) {
                    let point = a + (b - a) * (f64::from(i) / 6.0) + (c - a) * (f64::from(j) / 6.0);
                    let nearest = to
                        .iter()
                        .flat_map(|&quad| triangles(quad))
                        .fold(f64::INFINITY, |least, triangle| {
                            least.min(distance_squared(point, triangle))
                        });
                    most = most.max(nearest);
                }
            }
            most.sqrt()
        };
        let new = [quad(leaf)];
        one_way(&new, &originals).max(one_way(&originals, &new))
    }

    #[test]
    fn bounds_are_sound_and_grow_towards_the_root() {
        let (mut bounds, mut truths) = (0.0, 0.0);
        for seed in 0..30 {
            let mut draws = Stream::new(seed, 0).draws();
            let vertices: Vec<Vec3> = (0..36_u8)
                .map(|corner| {
                    let offset = Vec3::new(draws.signed(), draws.signed(), draws.signed());
                    Vec3::new(f32::from(corner / 4 % 3), f32::from(corner / 12), 0.0) + 0.6 * offset
                })
                .collect();
            for ops in [examples::WSCG, examples::FRAMEWORK] {
                let sequence = examples::sequence(9, &ops);
                let errors = LeafErrors::of(&vertices, &sequence, &Clusters::of(&sequence));
                for (op, collapse) in (0..).zip(sequence.collapses()) {
                    let error = errors.of_collapses()[op as usize];
                    for old in collapse.old.iter().filter_map(|old| old.checked_sub(9)) {
                        assert!(errors.of_collapses()[old as usize] <= error);
                    }
                    let truth = sampled(&vertices, &sequence, sequence.new_leaf(op));
                    assert!(truth <= f64::from(error), "seed {seed}, op {op}");
                    bounds += f64::from(error);
                    truths += truth;
                }
            }
        }
        assert!(bounds < 2.5 * truths, "{bounds} against {truths}");
    }

    #[test]
    fn leaves_that_stay_have_no_error_and_huge_ones_a_finite_one() {
        let same = vec![[0, 1, 2, 3], [4, 5, 6, 7], [0, 5, 2, 7]];
        let collapse = Collapse {
            old: [0, 1],
            cost: 0.0,
        };
        let sequence = CollapseSequence::new(2, same, vec![collapse]).expect("sound");
        let clusters = Clusters::of(&sequence);
        let errors = |vertices: &[Vec3]| LeafErrors::of(vertices, &sequence, &clusters);
        assert_eq!(errors(&[Vec3::ONE; 8]).of_collapses(), [0.0]);
        let far: Vec<Vec3> = [1.0, -1.0, 0.5, -0.5, 0.2, -0.7, 0.9, -0.1]
            .map(|x: f32| Vec3::new(x, -x, 0.3) * f32::MAX)
            .to_vec();
        let error = errors(&far).of_collapses()[0];
        assert!(error > 1e38 && error <= f32::MAX, "{error}");
    }
}
