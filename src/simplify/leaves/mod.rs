//! Leaf collapse: which two leaves become one, which quad replaces them, in which order.

mod candidate;
mod cost;
mod grid;
mod shape;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::measure::quad_area;
use super::{Collapse, CollapseSequence};
use crate::math::{DVec3, index_u32};
use crate::plant::Foliage;
use cost::Weights;
use grid::{Grid, Site};
use shape::{Four, Scale, Shape};

/// How far apart two leaves are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeafDistance {
    /// Hausdorff's distance between the two sets of four vertices.
    Hausdorff,
    /// The distance of the middles of the vertices.
    Centers,
}

/// When leaf collapse stops, and what a pair costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafCollapseOptions {
    /// How many leaves are left in the end, over all groups.
    pub stop_leaves: u32,
    /// How distance is measured.
    pub distance: LeafDistance,
    /// `k1`.
    pub distance_weight: f32,
    /// `k2`.
    pub coplanarity_weight: f32,
    /// `k3`.
    pub area_weight: f32,
    /// `k4`.
    pub form_weight: f32,
    /// Pairs with a larger `1 − |nA · nB|` are refused.
    pub coplanarity_threshold: Option<f32>,
    /// Pairs further apart, in mean spacings, are refused.
    pub distance_threshold: Option<f32>,
}

impl LeafCollapseOptions {
    /// Tuned constants.
    #[must_use]
    pub fn to(stop_leaves: u32) -> Self {
        Self {
            stop_leaves,
            distance: LeafDistance::Hausdorff,
            distance_weight: 1.0,
            coplanarity_weight: 0.5,
            area_weight: 8.0,
            form_weight: 0.5,
            coplanarity_threshold: None,
            distance_threshold: None,
        }
    }
}

/// Collapses leaves pair by pair.
#[must_use]
pub fn collapse_leaves(foliage: &Foliage, options: &LeafCollapseOptions) -> CollapseSequence {
    let vertices = foliage.quad_vertices();
    let mut corners = Vec::with_capacity(vertices.len() / 2);
    let mut group_of = Vec::with_capacity(corners.capacity());
    for (number, (group, _)) in foliage.quad_groups().enumerate() {
        for _ in 0..group.leaf_count() {
            let vertex = 4 * index_u32(corners.len());
            corners.push([vertex, vertex + 1, vertex + 2, vertex + 3]);
            group_of.push(index_u32(number));
        }
    }
    let leaves: Vec<[DVec3; 4]> = vertices
        .chunks_exact(4)
        .map(|leaf| [0, 1, 2, 3].map(|role| leaf[role].as_dvec3()))
        .collect();
    let scale = Scale::of(&leaves);
    let unit = scale.unit();
    let shapes: Vec<Shape> = corners
        .iter()
        .zip(&leaves)
        .map(|(&corners, leaf)| {
            let points = leaf.map(|point| unit * point);
            Shape::new(
                corners,
                Four::new(points.map(DVec3::as_vec3)),
                quad_area(points),
            )
        })
        .collect();
    let original_count = index_u32(shapes.len());
    let mut crown = Crown::new(shapes, group_of, Weights::new(options, &scale));
    let wanted = original_count.saturating_sub(options.stop_leaves);
    let mut collapses = Vec::with_capacity(wanted as usize);
    while index_u32(collapses.len()) < wanted {
        let Some(collapse) = crown.collapse_cheapest() else {
            break;
        };
        collapses.push(collapse);
    }
    let corners = crown.shapes.iter().map(|shape| shape.corners).collect();
    CollapseSequence::new(original_count, corners, collapses)
        .expect("pairs are alive, and corners are taken from them by role")
}

/// The leaves that are left, with all that finds the cheapest pair.
#[derive(Debug)]
struct Crown {
    weights: Weights,
    shapes: Vec<Shape>,
    group_of: Vec<u32>,
    alive: Vec<bool>,
    grids: Vec<Grid>,
    heap: BinaryHeap<Reverse<Offer>>,
}

/// A pair that one of its leaves offers; the order is that of collapses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    cost_bits: u32,
    pair: [u32; 2],
    owner: u32,
}

impl Crown {
    fn new(shapes: Vec<Shape>, group_of: Vec<u32>, weights: Weights) -> Self {
        let count = shapes.len();
        let sites: Vec<Site> = (0..index_u32(count))
            .zip(&shapes)
            .map(|(leaf, shape)| weights.site(shape, leaf))
            .collect();
        let mut grids = Vec::new();
        let mut start = 0;
        for group in group_of.chunk_by(|a, b| a == b) {
            grids.push(Grid::new(&sites[start..start + group.len()]));
            start += group.len();
        }
        let mut crown = Self {
            weights,
            alive: vec![true; count],
            shapes,
            group_of,
            grids,
            heap: BinaryHeap::with_capacity(count),
        };
        for leaf in 0..index_u32(count) {
            crown.offer(leaf);
        }
        crown
    }

    fn collapse_cheapest(&mut self) -> Option<Collapse> {
        loop {
            let Reverse(offer) = self.heap.pop()?;
            if !self.alive[offer.owner as usize] {
                continue;
            }
            if offer.pair.iter().all(|&leaf| self.alive[leaf as usize]) {
                return Some(self.collapse(offer.pair));
            }
            self.offer(offer.owner);
        }
    }

    fn site(&self, leaf: u32) -> Site {
        self.weights.site(&self.shapes[leaf as usize], leaf)
    }

    fn collapse(&mut self, old: [u32; 2]) -> Collapse {
        let pair = old.map(|leaf| &self.shapes[leaf as usize]);
        let (cost, candidate) = self
            .weights
            .of(pair, f32::INFINITY)
            .expect("an offered pair has a cost");
        let original_area = pair[0].original_area + pair[1].original_area;
        let shape = Shape::new(
            candidate.corners(pair),
            candidate.points(pair),
            original_area,
        );
        let group = self.group_of[old[0] as usize];
        for leaf in old {
            self.alive[leaf as usize] = false;
            let site = self.site(leaf);
            self.grids[group as usize].remove(site);
        }
        let leaf = index_u32(self.shapes.len());
        self.shapes.push(shape);
        self.group_of.push(group);
        self.alive.push(true);
        let site = self.site(leaf);
        self.grids[group as usize].insert(site);
        self.offer(leaf);
        Collapse { old, cost }
    }

    fn offer(&mut self, leaf: u32) {
        if let Some((cost_bits, partner)) = self.best_partner(leaf) {
            self.heap.push(Reverse(Offer {
                cost_bits,
                pair: [leaf.min(partner), leaf.max(partner)],
                owner: leaf,
            }));
        }
    }

    fn best_partner(&self, leaf: u32) -> Option<(u32, u32)> {
        let shape = &self.shapes[leaf as usize];
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
                    let other = &self.shapes[site.leaf as usize];
                    let pair = if site.leaf < leaf {
                        [other, shape]
                    } else {
                        [shape, other]
                    };
                    let Some((cost, _)) = self.weights.of(pair, limit) else {
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
}
