//! Boxes of leaves: what pruning keeps one leaf of.

use super::{middle, quads};
use crate::math::{DVec3, index_u32};
use crate::plant::Foliage;

/// The leaves of each cluster, ascending: `wanted` clusters, or as many as there are groups where that
/// is more, or leaves where that is less. Each lies in one group.
///
/// Groups have clusters in proportion to their leaves. A group is cut across the longest side of its
/// leaves' box, so that both parts have leaves in proportion to their clusters, until each is one
/// cluster.
pub(super) fn clusters(foliage: &Foliage, wanted: u32) -> Vec<Vec<u32>> {
    let middles: Vec<DVec3> = quads(foliage).into_iter().map(middle).collect();
    let sizes = foliage.quad_groups().map(|(group, _)| group.leaf_count());
    let sizes: Vec<usize> = sizes.filter(|&size| size > 0).collect();
    // One cluster a group; the others go to the other leaves.
    let others = middles.len() - sizes.len();
    let free = (wanted as usize)
        .min(middles.len())
        .saturating_sub(sizes.len());
    let share = |leaves: usize| {
        // Neither is more than a foliage has leaves, so the product fits.
        let share = leaves as u64 * free as u64 / others.max(1) as u64;
        usize::try_from(share).expect("it is at most `free`")
    };
    let mut clusters = Vec::with_capacity(sizes.len() + free);
    let (mut first, mut before) = (0, 0);
    for size in sizes {
        let count = 1 + share(before + size - 1) - share(before);
        let mut leaves: Vec<u32> = (first..first + size).map(index_u32).collect();
        cut(&middles, &mut leaves, count, &mut clusters);
        first += size;
        before += size - 1;
    }
    clusters
}

/// Cuts leaves into so many clusters, at most as many as there are leaves.
fn cut(middles: &[DVec3], leaves: &mut [u32], count: usize, clusters: &mut Vec<Vec<u32>>) {
    if count < 2 {
        leaves.sort_unstable();
        clusters.push(leaves.to_vec());
        return;
    }
    let place = |leaf: u32| middles[leaf as usize];
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (least, greatest) = leaves.iter().fold(start, |(least, greatest), &leaf| {
        (least.min(place(leaf)), greatest.max(place(leaf)))
    });
    let axis = (greatest - least).max_position();
    let half = count / 2;
    // Each part has at least as many leaves as clusters.
    let at = leaves.len() * half / count;
    leaves.select_nth_unstable_by(at, |&one, &other| {
        let [one_at, other_at] = [one, other].map(|leaf| place(leaf)[axis]);
        one_at.total_cmp(&other_at).then(one.cmp(&other))
    });
    let (first, second) = leaves.split_at_mut(at);
    cut(middles, first, half, clusters);
    cut(middles, second, count - half, clusters);
}
