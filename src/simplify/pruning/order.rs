//! Which leaves meet, and when: rounds of pairs.

use crate::math::{Stream, index_u32};

/// The stream of the order of leaves.
const LEAVES: u64 = 0x70_7275_6e65;

/// The stream of the places of pairs within a round.
const PLACES: u64 = 0x70_7275_6e66;

/// All collapses of these clusters of leaves, in order; of each pair the first stays.
///
/// ```text
///  round 1            a b c d e         in the order that is drawn for the leaves
///                     └┬┘ └┬┘ │
///  round 2        e    p   q  ┘         what is left over comes first, then what is new
///                 └─┬──┘   │
///  round 3          q      r            …
/// ```
///
/// A round is over once every cluster has done it. Within it the `p` pairs of a cluster come one in each
/// `p`-th of the round, at a place that is drawn: all clusters shrink at the same rate, and in each
/// leaves are consumed in the order in which they are born.
pub(super) fn pairs(clusters: Vec<Vec<u32>>, seed: u64) -> Vec<[u32; 2]> {
    let (leaves, places) = (Stream::new(seed, LEAVES), Stream::new(seed, PLACES));
    let originals: usize = clusters.iter().map(Vec::len).sum();
    let mut queues = clusters;
    for queue in &mut queues {
        queue.sort_by_cached_key(|&leaf| (leaves.u64(leaf.into()), leaf));
    }
    let mut collapses: Vec<[u32; 2]> = Vec::with_capacity(originals);
    loop {
        let mut round: Vec<(u64, usize, [u32; 2])> = Vec::new();
        for (number, queue) in queues.iter_mut().enumerate() {
            let (met, rest) = queue.as_chunks::<2>();
            for (place, &pair) in (0..).zip(met) {
                // The first leaf, which meets another once a round, draws for both.
                let drawn = places.u64(pair[0].into()) >> 32;
                let time = ((place << 32) + drawn) / met.len() as u64;
                round.push((time, number, pair));
            }
            *queue = rest.to_vec();
        }
        if round.is_empty() {
            return collapses;
        }
        // Equal times of a cluster stay in order.
        round.sort_by_key(|&(time, number, _)| (time, number));
        for (_, number, pair) in round {
            queues[number].push(index_u32(originals + collapses.len()));
            collapses.push(pair);
        }
    }
}
