//! Leaves that grow as others go.

use super::super::measure::quad_area;
use super::super::{Collapse, CollapseSequence, SequenceError};
use super::{middle, quads};
use crate::math::{DVec3, Vec3, index_u32};
use crate::plant::Foliage;

/// The sequence of these collapses of a foliage in which each new leaf is the first of its operands,
/// scaled about its middle until it has the area of all originals under it, but no more than
/// `most_growth` times that of the one that is left.
///
/// Only if the first has no area, and the second has, the second stays; what is left of an operand without
/// area does not grow. Vertices that a collapse adds come in the order of the foliage's groups, within one
/// in that of the collapses.
///
/// # Errors
///
/// When a collapse names a leaf that does not exist yet or is gone already.
pub fn hand_on_areas(
    foliage: &Foliage,
    collapses: &[[u32; 2]],
    most_growth: Option<f32>,
) -> Result<CollapseSequence, SequenceError> {
    let quads = quads(foliage);
    let areas: Vec<f64> = quads.iter().map(|quad| quad_area(*quad)).collect();
    let originals = index_u32(quads.len());
    let most = most_growth.filter(|most| !most.is_nan());
    let most = most.map_or(f64::INFINITY, |most| f64::from(most).max(1.0));
    // By leaf: the original that is left of it, and the area of all under it.
    let mut left: Vec<u32> = (0..originals).collect();
    let mut sums = areas.clone();
    let mut pruned: Vec<Collapse> = Vec::with_capacity(collapses.len());
    let mut scales = Vec::with_capacity(collapses.len());
    for (op, &old) in collapses.iter().enumerate() {
        let exists = left.len();
        if let Some(&leaf) = old.iter().find(|&&leaf| leaf as usize >= exists) {
            return Err(SequenceError::NotYet { op, leaf, exists });
        }
        let [first, second] = old.map(|leaf| areas[left[leaf as usize] as usize]);
        let old = if first > 0.0 || second <= 0.0 {
            old
        } else {
            [old[1], old[0]]
        };
        let [one, other] = old.map(|leaf| leaf as usize);
        let (original, sum) = (left[one], sums[one] + sums[other]);
        let own = areas[original as usize];
        let growth = if own > 0.0 {
            (sum / own).min(most)
        } else {
            1.0
        };
        left.push(original);
        sums.push(sum);
        scales.push(growth.sqrt());
        #[expect(
            clippy::cast_possible_truncation,
            reason = "kept within the type's range"
        )]
        let cost = growth.min(f64::from(f32::MAX)) as f32;
        pruned.push(Collapse { old, cost });
    }
    let new = &left[quads.len()..];
    let blocks = blocks(foliage, new);
    let mut corners: Vec<[u32; 4]> = (0..originals).map(block).collect();
    corners.extend(blocks.iter().map(|&own| block(originals + own)));
    let mut added = vec![Vec3::ZERO; 4 * new.len()];
    for ((&original, &scale), &own) in new.iter().zip(&scales).zip(&blocks) {
        let quad = quads[original as usize];
        added[4 * own as usize..][..4].copy_from_slice(&scaled(quad, scale));
    }
    CollapseSequence::with_vertices(originals, corners, pruned, added)
}

/// The numbers of a leaf's own vertices, if it has the `number`-th four of all.
fn block(number: u32) -> [u32; 4] {
    [0, 1, 2, 3].map(|role| 4 * number + role)
}

/// Which four of the added vertices are each new leaf's, given the original that is left of it.
fn blocks(foliage: &Foliage, new: &[u32]) -> Vec<u32> {
    let ends = foliage.quad_groups().scan(0, |end, (group, _)| {
        *end += group.leaf_count();
        Some(*end)
    });
    let ends: Vec<usize> = ends.collect();
    let group = |original: u32| ends.partition_point(|&end| end <= original as usize);
    let mut order: Vec<usize> = (0..new.len()).collect();
    // Stable: within a group collapses stay in order.
    order.sort_by_cached_key(|&op| group(new[op]));
    let mut blocks = vec![0; new.len()];
    for (own, op) in (0..).zip(order) {
        blocks[op] = own;
    }
    blocks
}

/// A quad scaled about its middle, as far as `f32` reaches.
fn scaled(quad: [DVec3; 4], scale: f64) -> [Vec3; 4] {
    let middle = middle(quad);
    let most = DVec3::splat(f64::from(f32::MAX));
    quad.map(|corner| {
        (middle + (corner - middle) * scale)
            .clamp(-most, most)
            .as_vec3()
    })
}
