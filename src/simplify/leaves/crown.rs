//! The leaves that are left while a crown is simplified, and the cheapest pair among them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use super::super::Collapse;
use super::super::measure::quad_area;
use super::LeafCollapseOptions;
use super::cost::Weights;
use super::grid::{Grid, Site};
use super::shape::{Four, Scale, Shape};
use crate::math::{DVec3, index_u32};
use crate::plant::Foliage;

/// All leaves, old and new, and a queue of pairs.
///
/// **Invariant.** For every pair of leaves that are left and may be joined, one of the two has an
/// offer in the queue that costs no more than the pair: the later-born looked at all leaves when it
/// was born, and a leaf looks again when the partner in its offer is gone. So the first offer whose
/// leaves are both left is the cheapest pair of all.
#[derive(Debug)]
pub(super) struct Crown {
    weights: Weights,
    shapes: Vec<Shape>,
    group_of: Vec<u32>,
    left: Vec<bool>,
    grids: Vec<Grid>,
    offers: BinaryHeap<Reverse<Offer>>,
}

/// A leaf and the best partner that it found; the order is that of collapses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    /// The bits of the cost, which order as costs do: none is negative.
    cost: u32,
    pair: [u32; 2],
    owner: u32,
}

impl Crown {
    pub(super) fn new(foliage: &Foliage, options: &LeafCollapseOptions) -> Self {
        let leaves: Vec<[DVec3; 4]> = foliage
            .quad_vertices()
            .chunks_exact(4)
            .map(|leaf| [0, 1, 2, 3].map(|role| leaf[role].as_dvec3()))
            .collect();
        let scale = Scale::of(&leaves);
        let weights = Weights::new(options, &scale);
        let shapes: Vec<Shape> = (0..)
            .zip(&leaves)
            .map(|(leaf, quad)| {
                let corners = [0, 1, 2, 3].map(|role| 4 * leaf + role);
                let quad = quad.map(|point| scale.unit * point);
                Shape::new(
                    corners,
                    Four::new(quad.map(DVec3::as_vec3)),
                    quad_area(quad),
                )
            })
            .collect();
        let sites: Vec<Site> = (0..)
            .zip(&shapes)
            .map(|(leaf, shape)| weights.site(shape, leaf))
            .collect();
        let mut grids = Vec::new();
        let mut group_of = Vec::with_capacity(shapes.len());
        for (group, _) in foliage.quad_groups() {
            let first = group_of.len();
            group_of.resize(first + group.leaf_count(), index_u32(grids.len()));
            grids.push(Grid::new(&sites[first..group_of.len()]));
        }
        let mut crown = Self {
            weights,
            left: vec![true; shapes.len()],
            offers: BinaryHeap::with_capacity(shapes.len()),
            shapes,
            group_of,
            grids,
        };
        let found: Vec<_> = (0..index_u32(leaves.len()))
            .into_par_iter()
            .map(|leaf| crown.best_partner(leaf))
            .collect();
        for (leaf, found) in (0..).zip(found) {
            crown.offer(leaf, found);
        }
        crown
    }

    /// The corners of every leaf, old and new.
    pub(super) fn into_corners(self) -> Vec<[u32; 4]> {
        self.shapes.into_iter().map(|shape| shape.corners).collect()
    }

    /// Joins the cheapest pair; `None` when no pair is left that may be joined.
    pub(super) fn collapse_cheapest(&mut self) -> Option<Collapse> {
        loop {
            let Reverse(offer) = self.offers.pop()?;
            if !self.left[offer.owner as usize] {
                continue;
            }
            if offer.pair.iter().all(|&leaf| self.left[leaf as usize]) {
                return Some(self.collapse(offer.pair));
            }
            self.offer(offer.owner, self.best_partner(offer.owner));
        }
    }

    fn collapse(&mut self, old: [u32; 2]) -> Collapse {
        let pair = old.map(|leaf| &self.shapes[leaf as usize]);
        let (cost, candidate) = self
            .weights
            .cost(pair, f32::INFINITY)
            .expect("a pair on offer may be joined");
        let shape = candidate.shape(pair);
        let group = self.group_of[old[0] as usize];
        for leaf in old {
            self.left[leaf as usize] = false;
            let site = self.site(leaf);
            self.grids[group as usize].remove(&site);
        }
        let leaf = index_u32(self.shapes.len());
        self.shapes.push(shape);
        self.group_of.push(group);
        self.left.push(true);
        let site = self.site(leaf);
        self.grids[group as usize].insert(site);
        self.offer(leaf, self.best_partner(leaf));
        Collapse { old, cost }
    }

    /// Queues the best pair of `leaf`, if there is any.
    fn offer(&mut self, leaf: u32, found: Option<(u32, u32)>) {
        if let Some((cost, partner)) = found {
            self.offers.push(Reverse(Offer {
                cost,
                pair: [leaf.min(partner), leaf.max(partner)],
                owner: leaf,
            }));
        }
    }

    /// The bits of the least cost and the partner at that cost, the lowest if there are several.
    pub(super) fn best_partner(&self, leaf: u32) -> Option<(u32, u32)> {
        let here = self.site(leaf);
        let grid = &self.grids[self.group_of[leaf as usize] as usize];
        let mut best: Option<(u32, u32)> = None;
        let mut limit = f32::INFINITY;
        let mut reach = f32::INFINITY;
        for shell in 0.. {
            let more = grid.visit_shell(&here, shell, reach, |sites| {
                for site in sites {
                    if here.least_distance(site) > reach || site.leaf == leaf {
                        continue;
                    }
                    let pair = [&here.shape, &site.shape];
                    let Some((cost, _)) = self.weights.cost(pair, limit) else {
                        continue;
                    };
                    let found = (cost.to_bits(), site.leaf);
                    if best.is_none_or(|best| found < best) {
                        best = Some(found);
                        limit = cost;
                        reach = self.weights.reach(cost);
                    }
                }
            });
            if !more {
                break;
            }
        }
        best
    }

    /// What [`best_partner`](Self::best_partner) must find, by looking at all leaves.
    #[cfg(test)]
    pub(super) fn best_partner_of_all(&self, leaf: u32) -> Option<(u32, u32)> {
        let shape = &self.shapes[leaf as usize];
        let may_join = |other: u32| {
            self.left[other as usize]
                && other != leaf
                && self.group_of[other as usize] == self.group_of[leaf as usize]
        };
        (0..index_u32(self.shapes.len()))
            .filter(|&other| may_join(other))
            .filter_map(|other| {
                let pair = [shape, &self.shapes[other as usize]];
                let (cost, _) = self.weights.cost(pair, f32::INFINITY)?;
                Some((cost.to_bits(), other))
            })
            .min()
    }

    /// What [`collapse_cheapest`](Self::collapse_cheapest) must do, by looking at all pairs.
    #[cfg(test)]
    pub(super) fn collapse_cheapest_of_all(&mut self) -> Option<Collapse> {
        let (_, old) = (0..index_u32(self.shapes.len()))
            .filter(|&leaf| self.left[leaf as usize])
            .filter_map(|leaf| {
                let (cost, other) = self.best_partner_of_all(leaf)?;
                Some((cost, [leaf.min(other), leaf.max(other)]))
            })
            .min()?;
        Some(self.collapse(old))
    }

    fn site(&self, leaf: u32) -> Site {
        self.weights.site(&self.shapes[leaf as usize], leaf)
    }
}
