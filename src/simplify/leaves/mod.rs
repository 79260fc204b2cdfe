//! Leaf collapse: which two leaves become one, which quad replaces them, in which order.
//!
//! ```text
//!  A 3──2    B 3──2          3─────2      each corner of the new leaf is that of A or of B
//!    │  │  +   │  │   ──▶    │     │      in the same role: 14 quads to choose from, no new
//!    0──1      0──1          0─────1      vertices, texture corners keep their meaning
//! ```
//!
//! What is known of the papers' simplifier FSA ([RC02](crate::references) introduces it,
//! [RRCGR](crate::references) and [RCRG06](crate::references) use it): two leaves disappear and one
//! appears that keeps an area similar to theirs and uses their vertices; pairs are judged by
//! distance and coplanarity; the published trees stop at 1.3 to 1.6 % of their leaves. The rest is
//! reconstruction: the cost below, one corner a role, the order.
//!
//! A pair costs, of the quads that it may become, the least
//!
//! ```text
//! s(A, B, quad) · (k1 · d(A, B) / D  +  k2 · (1 − |nA · nB|))  +  s(A, B) · (k3 · misfit² + k4 · malform)
//! ```
//!
//! with `d` the [distance](LeafDistance), `D` the mean spacing of the leaves (the side of the cube
//! that one leaf has to itself where there are leaves at all), `n` the unit normals, `misfit` how far
//! the quad's area is from that of all original leaves under it, as a share of the latter, and
//! `malform` how much less compact the quad is than a mean original leaf, from 0 to 1. Errors of area
//! do not add up, since the originals are what is aimed at. Squaring the misfit lets small errors
//! pass, which cancel over a crown, and forbids large ones, which do not. Folded quads
//! ([`is_folded`](super::is_folded)) are refused.
//!
//! `s` is what is seen of the two leaves, and nothing of it is the papers': a leaf counts by what is
//! seen of the originals under it from outside of the crown, where a mean original counts 1; each of
//! the two counts by the share of its corners that it loses (`s(A, B, quad)`), or both by half
//! (`s(A, B)`). So what is hidden is collapsed first, the more a leaf shows the longer it stays as it
//! is, and leaves that stand for few originals come before those that stand for many.
//! [`exposure`](LeafCollapseOptions::exposure) tells how far this goes; with 0, `s` is 1 and the order
//! is that of the formula alone. That a simplifier should spend its
//! errors where nobody can look is known of meshes ([ZT02](crate::references)).
//!
//! The order is greedy by (cost, lower leaf, higher leaf), in rounds:
//!
//! ```text
//!        ┌──────────────────────────── while there are too many leaves ──────────────────────┐
//!        ▼                                                                                   │
//!  leaves left ─cut─▶ blocks of ≤ 64 ──each on its own─▶ joins that cost ≤ t ─by cost─▶ collapses
//!                       (elsewhere each round)             t: what 75 % of the leaves offer
//! ```
//!
//! Within a block each step takes the cheapest pair of all; a search finds it without looking
//! closely at all pairs, but never misses one. Blocks know nothing of each other, so threads share
//! them out; of the next joins of all blocks the cheapest always comes first in the sequence, so it
//! is the sequence of one greedy search that takes no pair across a border and stops at `t`. A pair
//! across a border waits for the next round, which cuts elsewhere. A foliage whose groups have no
//! more than a block of leaves is collapsed as if there were no blocks: a test compares that with
//! looking at all pairs.

mod block;
mod bound;
mod candidate;
mod cost;
mod crown;
mod exposure;
mod partition;
mod shape;

use super::CollapseSequence;
use crate::math::index_u32;
use crate::plant::Foliage;
use crown::Crown;

/// How far apart two leaves are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeafDistance {
    /// Hausdorff's distance between the two sets of four vertices: counts size and turn too.
    Hausdorff,
    /// The distance of the middles of the vertices: cheaper by a third, and blind to size, so that
    /// area fails sooner at the coarse end.
    Centers,
}

/// When leaf collapse stops, and what a pair costs.
///
/// Weights count from 0 to 10⁶; less, more and NaN count as the nearest of these.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafCollapseOptions {
    /// How many leaves are left in the end, over all groups; one of each group stays in any case.
    pub stop_leaves: u32,
    /// How distance is measured.
    pub distance: LeafDistance,
    /// Cost of one mean spacing of distance (`k1`).
    pub distance_weight: f32,
    /// Cost of a right angle between the normals (`k2`).
    pub coplanarity_weight: f32,
    /// Cost of a quad with no area or twice the area wanted (`k3`).
    pub area_weight: f32,
    /// How many times the area of its originals a leaf of four originals or more aims at; for two and
    /// three, so much of the way as their number is. 1 keeps area; above, fewer and larger leaves
    /// close the gaps that they leave. Counts from 0.25 to 4, NaN
    /// as 1.
    pub area_gain: f32,
    /// Cost of a quad that is all sliver, or folded flat (`k4`).
    pub form_weight: f32,
    /// How far costs go by what is seen of the leaves: 0 takes all leaves alike, as the papers do as
    /// far as is known; 1 counts a leaf by what is seen of its originals from outside of the crown.
    /// Counts from 0 to 1, NaN as 0.
    pub exposure: f32,
    /// Pairs with a larger `1 − |nA · nB|` are never joined.
    pub coplanarity_threshold: Option<f32>,
    /// Pairs that are further apart, in mean spacings, are never joined.
    pub distance_threshold: Option<f32>,
}

impl LeafCollapseOptions {
    /// Down to `stop_leaves`, with constants tuned on species of 5,600 to 69,000 leaves, above all a
    /// yew of 48,160 and a birch of 20,376.
    ///
    /// - `area_weight` 150: less lets area shrink, since quads of full size get rare as leaves get
    ///   few (with 30 the yew keeps 90 % of its area at a tenth of its leaves, with 150 it keeps
    ///   98 %); more joins leaves from further away and takes longer.
    /// - `coplanarity_weight` and `form_weight` 0.2: without them quads bend more and one in a
    ///   hundred gets longer by a tenth; five times as much changes little but takes a fifth longer.
    ///   Few slivers arise in any case, as their areas are wrong.
    /// - `exposure` 1: with 0 the mean FLIP of half the leaves against all, over eleven species, is
    ///   nearly twice as high, above that of meshoptimizer's edge collapses on each, and a slim cypress
    ///   covers 4 % less at a quarter of its leaves. What is hidden pays with some of its area.
    /// - no thresholds: they would stop the sequence early.
    ///
    /// Covered pixels hardly depend on the others: they stay within 3 % of full detail down to a
    /// quarter of the leaves, and within 8 % at a twentieth.
    #[must_use]
    pub fn to(stop_leaves: u32) -> Self {
        Self {
            stop_leaves,
            distance: LeafDistance::Hausdorff,
            distance_weight: 1.0,
            coplanarity_weight: 0.2,
            area_weight: 150.0,
            area_gain: 1.0,
            form_weight: 0.2,
            exposure: 1.0,
            coplanarity_threshold: None,
            distance_threshold: None,
        }
    }
}

/// Goes up whenever any foliage gets another sequence than before from [`collapse_leaves`].
pub const LEAF_COLLAPSE_VERSION: u32 = 3;

/// Collapses quad leaves pair by pair, the cheapest first, never across groups.
///
/// The sequence ends with exactly [`stop_leaves`](LeafCollapseOptions::stop_leaves) leaves, or with
/// one a group where that is more. It ends earlier only when all pairs that five partitions in a row
/// bring into one block are beyond a threshold or make only folded quads; then
/// [`root_count`](CollapseSequence::root_count) is larger than asked.
///
/// Time grows with the number of leaves, and with how densely they stand by a factor of two or
/// three at most. It runs in rayon's current pool, which no result shows.
#[must_use]
#[expect(clippy::missing_panics_doc, reason = "no input reaches it")]
pub fn collapse_leaves(foliage: &Foliage, options: &LeafCollapseOptions) -> CollapseSequence {
    let mut crown = Crown::new(foliage, options);
    let original_count = index_u32(foliage.quad_count());
    crown.collapse(original_count.saturating_sub(options.stop_leaves) as usize);
    let (corners, collapses) = crown.finish();
    CollapseSequence::new(original_count, corners, collapses)
        .expect("pairs are of leaves that are left, and corners are theirs by role")
}

#[cfg(test)]
mod tests {
    use super::super::{is_folded, measure_leaves};
    use super::*;
    use crate::math::{Draws, Stream, Vec3};
    use crate::plant::{LeafGroup, Material, NO_BRANCH, Prototype};

    fn group(positions: Vec<Vec3>) -> LeafGroup {
        LeafGroup {
            name: "leaves".to_owned(),
            prototype: Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            material: Material::plain("leaf", [0.1, 0.4, 0.1]),
            owners: vec![NO_BRANCH; positions.len() / 4],
            positions,
        }
    }

    /// Rectangles of random place, turn and size in a cube of side `side`.
    fn scattered(count: usize, side: f32, seed: u64) -> Vec<Vec3> {
        let mut draws = Stream::new(seed, 0).draws();
        let vector = |draws: &mut Draws| {
            let (x, y, z) = (draws.signed(), draws.signed(), draws.signed());
            Vec3::new(x, y, z)
        };
        (0..count)
            .flat_map(|_| {
                let base = side * vector(&mut draws);
                let along = vector(&mut draws) + Vec3::splat(0.01);
                let across = along.cross(vector(&mut draws) + Vec3::splat(0.02));
                let across = (0.3 + draws.unit()) * across.normalize_or(Vec3::X);
                [base, base + across, base + across + along, base + along]
            })
            .collect()
    }

    fn foliage(groups: Vec<Vec<Vec3>>) -> Foliage {
        let groups = groups.into_iter().map(group).collect();
        Foliage { groups }
    }

    /// ```text
    /// 3──2 3──2       3─────2
    /// │A │ │B │  ──▶  │     │
    /// 0──1 0──1       0─────1
    /// ```
    #[test]
    fn two_squares_side_by_side_become_one_rectangle() {
        let square = |x: f32| {
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec3::new(x + u, v, 0.0))
        };
        let leaves = foliage(vec![[square(0.0), square(1.0)].concat()]);
        let sequence = collapse_leaves(&leaves, &LeafCollapseOptions::to(1));
        assert_eq!(sequence.corners()[2], [0, 5, 6, 3]);
        let area = measure_leaves(&leaves.quad_vertices(), &sequence, [2]).area;
        assert!((area - 2.0).abs() < 1e-6, "area {area}");
    }

    #[test]
    fn groups_stay_apart_and_keep_one_leaf_each() {
        let groups = vec![scattered(9, 2.0, 1), Vec::new(), scattered(5, 2.0, 2)];
        let sequence = collapse_leaves(&foliage(groups), &LeafCollapseOptions::to(0));
        assert_eq!(sequence.root_count(), 2);
        let mut group: Vec<u32> = (0..14).map(|leaf| u32::from(leaf >= 9)).collect();
        for collapse in sequence.collapses() {
            let [first, second] = collapse.old.map(|old| group[old as usize]);
            assert_eq!(first, second);
            group.push(first);
        }
    }

    #[test]
    fn many_blocks_end_with_as_many_leaves_as_asked_on_any_number_of_threads() {
        let leaves = foliage(vec![scattered(1500, 9.0, 8), scattered(700, 0.4, 9)]);
        let options = LeafCollapseOptions::to(3);
        let collapsed = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| collapse_leaves(&leaves, &options))
        });
        assert_eq!(collapsed[0].root_count(), 3);
        assert_eq!(collapsed[0], collapsed[1]);
        assert_eq!(collapsed[0], collapsed[2]);
    }

    #[test]
    fn nothing_to_do_is_no_collapse() {
        for (count, stop) in [(0, 0), (0, 5), (1, 0), (7, 7), (7, 9)] {
            let leaves = foliage(vec![scattered(count, 1.0, 3)]);
            let sequence = collapse_leaves(&leaves, &LeafCollapseOptions::to(stop));
            assert_eq!(sequence.collapse_count(), 0, "{count} leaves to {stop}");
        }
    }

    /// Squares along a line, in whole steps: what bounds distance is the distance itself, and many
    /// pairs cost the same.
    fn row(count: usize, seed: u64) -> Vec<Vec3> {
        let mut draws = Stream::new(seed, 1).draws();
        (0..count)
            .flat_map(|_| {
                let x = (100.0 * draws.unit()).floor();
                [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
                    .map(|(u, v)| Vec3::new(x + u, v, 0.0))
            })
            .collect()
    }

    #[test]
    fn the_search_finds_what_looking_at_all_pairs_finds() {
        let crowns = [
            vec![scattered(60, 0.5, 0), scattered(30, 9.0, 1)],
            vec![scattered(60, 20.0, 2), scattered(30, 0.0, 3)],
            vec![row(60, 4), row(30, 5)],
        ];
        for groups in crowns {
            let leaves = foliage(groups);
            for distance in [LeafDistance::Hausdorff, LeafDistance::Centers] {
                for weight in [0.0, 0.2] {
                    let options = LeafCollapseOptions {
                        distance,
                        coplanarity_weight: weight,
                        area_weight: 500.0 * weight,
                        form_weight: weight,
                        area_gain: if distance == LeafDistance::Centers {
                            0.8
                        } else {
                            1.2
                        },
                        ..LeafCollapseOptions::to(2)
                    };
                    let searched = collapse_leaves(&leaves, &options);
                    let mut crown = Crown::new(&leaves, &options);
                    crown.collapse_by_looking_at_all_pairs();
                    let (corners, collapses) = crown.finish();
                    assert_eq!(searched.collapses(), collapses);
                    assert_eq!(searched.corners(), corners);
                    assert_eq!(searched.root_count(), 2);
                    let vertices = leaves.quad_vertices();
                    let folded = |&corners: &[u32; 4]| is_folded(&vertices, corners);
                    assert!(!searched.corners().iter().any(folded));
                }
            }
        }
    }

    #[test]
    fn thresholds_stop_early_and_say_so() {
        let leaves = foliage(vec![scattered(40, 8.0, 4)]);
        let near = LeafCollapseOptions {
            distance_threshold: Some(0.5),
            ..LeafCollapseOptions::to(1)
        };
        assert!(collapse_leaves(&leaves, &near).root_count() > 1);
        let flat = LeafCollapseOptions {
            coplanarity_threshold: Some(0.0),
            ..LeafCollapseOptions::to(1)
        };
        assert!(collapse_leaves(&leaves, &flat).root_count() > 1);
    }

    #[test]
    fn any_finite_coordinates_and_weights_do() {
        let scales = [1e-38, 1e-20, 1.0, 1e20, f32::MAX / 64.0];
        let weights = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e-30, 1e30];
        for scale in scales {
            for weight in weights {
                let mut positions = scattered(20, 4.0, 5);
                for position in &mut positions[8..] {
                    *position *= scale;
                }
                // A point, and all corners on a line.
                positions[0..4].fill(Vec3::ONE);
                positions[4..8].copy_from_slice(&[0.0, 1.0, 2.0, 3.0].map(Vec3::splat));
                let options = LeafCollapseOptions {
                    distance_weight: weight,
                    coplanarity_weight: weight,
                    area_weight: weight,
                    form_weight: weight,
                    area_gain: weight,
                    ..LeafCollapseOptions::to(1)
                };
                let sequence = collapse_leaves(&foliage(vec![positions]), &options);
                let costs = sequence.collapses().iter().map(|collapse| collapse.cost);
                assert!(costs.clone().all(|cost| cost.is_finite() && cost >= 0.0));
                assert_eq!(sequence.root_count(), 1, "scale {scale}, weight {weight}");
            }
        }
    }
}
