//! Two collapse sequences: collapses and clusters are known by the leaves that they join, so that
//! other numbers alone are no difference.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::bounded;
use super::leaves::LeafMatch;
use crate::math::index_u32;
use crate::models::Crown;

/// How two collapse sequences differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SequenceDifference {
    /// The first tree that shows them.
    pub tree: u32,
    /// Collapses of A, and of B.
    pub collapses: [u64; 2],
    /// The place in both sequences at which they first join other leaves, or the same leaves to
    /// another; `None` where only costs differ.
    pub first: Option<u32>,
    /// The collapse that A does there, or where costs first differ; `None` where A has no more.
    pub a: Option<CollapsePlace>,
    /// The collapse that B does there.
    pub b: Option<CollapsePlace>,
    /// The first place at which costs differ. The simplifier's unit depends on the whole crown, so
    /// one leaf less can change the costs of all collapses and the order of none.
    pub first_cost: Option<u32>,
    /// Collapses that make a leaf which the other sequence never makes, in A and in B.
    pub only: [u64; 2],
    /// Clusters of A, and of B.
    pub clusters: [u64; 2],
    /// How many clusters of A are not in B, leaf for leaf and collapse for collapse.
    pub clusters_only_a_count: u64,
    /// The first of them.
    pub clusters_only_a: Vec<ClusterPlace>,
    /// How many clusters of B are not in A.
    pub clusters_only_b_count: u64,
    /// The first of them.
    pub clusters_only_b: Vec<ClusterPlace>,
}

/// A collapse of a sequence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CollapsePlace {
    /// The two leaves that it joins.
    pub old: [u32; 2],
    /// The leaf that it makes.
    pub new: u32,
    /// What the simplifier paid.
    pub cost: f32,
    /// The cluster that it is in.
    pub cluster: u32,
}

/// A cluster of a sequence.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClusterPlace {
    /// Its number.
    pub cluster: u32,
    /// Leaves at full detail.
    pub originals: u32,
    /// The least of them.
    pub first_leaf: u32,
}

/// What names a leaf in both sequences: leaves have the same name if they are the same original, or
/// come of the same collapse of the same leaves.
#[derive(Debug)]
pub(super) struct LeafNames {
    /// By leaf, originals first, of A and of B.
    pub(super) of: [Vec<u32>; 2],
}

/// The names of both operands, and of the original leaf that each corner comes from.
type Making = ([u32; 2], [u32; 4]);

impl LeafNames {
    pub(super) fn new(a: &Crown, b: &Crown, matched: &LeafMatch) -> Self {
        let mut next = a.sequence().original_count();
        let ours: Vec<u32> = (0..next).collect();
        let theirs: Vec<u32> = matched
            .a_of_b
            .iter()
            .map(|known| {
                known.unwrap_or_else(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect();
        let mut makings: BTreeMap<Making, u32> = BTreeMap::new();
        let mut named = |crown: &Crown, mut names: Vec<u32>| {
            let sequence = crown.sequence();
            let originals = sequence.original_count() as usize;
            let new = &sequence.corners()[originals..];
            for (collapse, corners) in sequence.collapses().iter().zip(new) {
                let old = collapse.old.map(|old| names[old as usize]);
                let from =
                    corners.map(|vertex| names[sequence.original_of_vertex(vertex) as usize]);
                let name = *makings.entry((old, from)).or_insert_with(|| {
                    next += 1;
                    next - 1
                });
                names.push(name);
            }
            names
        };
        let ours = named(a, ours);
        let theirs = named(b, theirs);
        Self { of: [ours, theirs] }
    }
}

/// How the sequences that a tree shows differ; `None` if they are one but for numbers.
pub(super) fn sequence_difference(
    tree: u32,
    a: &Crown,
    b: &Crown,
    names: &LeafNames,
) -> Option<SequenceDifference> {
    let crowns = [a, b];
    let made = |side: usize| {
        let originals = crowns[side].sequence().original_count() as usize;
        &names.of[side][originals..]
    };
    let (ours, theirs) = (made(0), made(1));
    let shared = ours
        .iter()
        .zip(theirs)
        .take_while(|(one, other)| one == other);
    let first = shared.count();
    let ends = first == ours.len() && first == theirs.len();
    let pairs = a
        .sequence()
        .collapses()
        .iter()
        .zip(b.sequence().collapses());
    let first_cost = pairs
        .take(first + usize::from(!ends))
        .position(|(one, other)| one.cost.to_bits() != other.cost.to_bits());
    if ends && first_cost.is_none() {
        return None;
    }
    let place = if ends { first_cost.unwrap_or(0) } else { first };
    let known: [BTreeSet<u32>; 2] = [0, 1].map(|side| made(side).iter().copied().collect());
    let only = |side: usize| {
        let other = &known[1 - side];
        made(side)
            .iter()
            .filter(|name| !other.contains(name))
            .count() as u64
    };
    let roots: [Vec<(u32, u32)>; 2] = [0, 1].map(|side| roots(crowns[side], &names.of[side]));
    let clusters = |side: usize| {
        let others: BTreeSet<u32> = roots[1 - side].iter().map(|(_, name)| *name).collect();
        let only = roots[side]
            .iter()
            .filter(|(_, name)| !others.contains(name));
        bounded(
            only.map(|(cluster, _)| cluster_place(crowns[side], *cluster))
                .collect(),
        )
    };
    let (clusters_only_a_count, clusters_only_a) = clusters(0);
    let (clusters_only_b_count, clusters_only_b) = clusters(1);
    Some(SequenceDifference {
        tree,
        collapses: [ours.len() as u64, theirs.len() as u64],
        first: (!ends).then(|| index_u32(first)),
        a: collapse_place(a, place),
        b: collapse_place(b, place),
        first_cost: first_cost.map(index_u32),
        only: [only(0), only(1)],
        clusters: [roots[0].len() as u64, roots[1].len() as u64],
        clusters_only_a_count,
        clusters_only_a,
        clusters_only_b_count,
        clusters_only_b,
    })
}

/// The clusters with the names of their roots.
fn roots(crown: &Crown, names: &[u32]) -> Vec<(u32, u32)> {
    let clusters = (0..).zip(&crown.clusters().clusters);
    clusters
        .filter_map(|(number, cluster)| {
            let root = cluster.records.last()?.leaf;
            Some((number, names[root as usize]))
        })
        .collect()
}

fn cluster_place(crown: &Crown, number: u32) -> ClusterPlace {
    let cluster = &crown.clusters().clusters[number as usize];
    let leaves = cluster.records.iter().map(|record| record.leaf);
    ClusterPlace {
        cluster: number,
        originals: cluster.original_count(),
        first_leaf: leaves.min().unwrap_or(0),
    }
}

fn collapse_place(crown: &Crown, number: usize) -> Option<CollapsePlace> {
    let sequence = crown.sequence();
    let collapse = sequence.collapses().get(number)?;
    let new = sequence.new_leaf(index_u32(number));
    Some(CollapsePlace {
        old: collapse.old,
        new,
        cost: collapse.cost,
        cluster: crown.clusters().cluster_of_leaf[new as usize],
    })
}
