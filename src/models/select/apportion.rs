//! A number of leaves, dealt out to clusters: as many as are to be dealt, in proportion to weights.

use crate::math::whole_u32;

/// How whole leaves are made of proportions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Apportionment {
    /// Leaf after leaf, each to the cluster with the greatest `weight / (leaves + ½)` (Webster's
    /// divisor).
    ///
    /// One leaf more never takes one from any cluster, so a budget that changes step by step makes
    /// nothing come and go: this is what selection uses.
    Divisor,
    /// Each cluster the whole part of its share, and those with the largest remainders one leaf more
    /// (Hamilton).
    ///
    /// Never further than one leaf from its share; but one leaf more in all may take one from a
    /// cluster, as from Alabama's seats in 1881.
    LargestRemainder,
}

/// The share of the greatest weight that the least counts for: no cluster's share is so small that
/// it could not be told from those beside it.
const LEAST_SHARE: f64 = 1.0 / (1_u64 << 40) as f64;

/// Deals `budget` leaves out to clusters of `sizes` leaves by their `weights`: at least one each, and
/// at most as many as there are.
///
/// A budget below the number of clusters counts as that, and one above all leaves as all. So the
/// result always adds up to exactly `budget.clamp(sizes.len(), sizes.sum())`. Equal claims are settled
/// by cluster number, the lower first. Weights that are no number or negative count as 0, and none
/// for less than 2⁻⁴⁰ of the greatest.
///
/// ```
/// use spinney::models::{Apportionment, apportion};
///
/// let dealt = apportion(10, &[4, 9, 9], &[9.0, 2.0, 1.0], Apportionment::Divisor);
/// assert_eq!(dealt, [4, 4, 2]);
/// ```
///
/// # Panics
///
/// When there is not one weight a size, or a size is 0.
#[must_use]
pub fn apportion(budget: u32, sizes: &[u32], weights: &[f64], method: Apportionment) -> Vec<u32> {
    assert_eq!(sizes.len(), weights.len(), "one weight a cluster");
    assert!(!sizes.contains(&0), "a cluster has at least one leaf");
    let all: u64 = sizes.iter().copied().map(u64::from).sum();
    let budget = u64::from(budget).clamp(sizes.len() as u64, all);
    let claims: Vec<(u32, f64)> = sizes.iter().copied().zip(relative(weights)).collect();
    match method {
        Apportionment::Divisor => divisor(budget, &claims),
        Apportionment::LargestRemainder => largest_remainder(budget, &claims),
    }
}

/// Weights as shares of the greatest, from [`LEAST_SHARE`] to 1.
fn relative(weights: &[f64]) -> impl Iterator<Item = f64> {
    let sound = |weight: f64| {
        if weight > 0.0 {
            weight.min(f64::MAX)
        } else {
            0.0
        }
    };
    let greatest = weights.iter().copied().map(sound).fold(0.0, f64::max);
    let share = move |weight: &f64| {
        if greatest > 0.0 {
            (sound(*weight) / greatest).max(LEAST_SHARE)
        } else {
            1.0
        }
    };
    weights.iter().map(share)
}

/// The claim of a cluster to one leaf more than it has; falls with the leaves, strictly, since
/// neighbours lie 2⁻²⁵ apart or more.
fn claim(weight: f64, leaves: u32) -> f64 {
    weight / (f64::from(leaves) + 0.5)
}

/// How many leaves a cluster has if every claim above `bar` is met: at least 1, at most all.
fn leaves_above(bar: f64, (size, weight): (u32, f64)) -> u32 {
    let (mut met, mut refused) = (1, size);
    while met < refused {
        let middle = met + (refused - met) / 2;
        if claim(weight, middle) > bar {
            met = middle + 1;
        } else {
            refused = middle;
        }
    }
    met
}

/// The same as handing out leaf after leaf, without doing so: what is handed out are all claims above
/// a bar, and of those that reach it exactly the first.
fn divisor(budget: u64, claims: &[(u32, f64)]) -> Vec<u32> {
    let dealt = |bar: f64| -> u64 {
        let leaves = claims
            .iter()
            .map(|&claim| u64::from(leaves_above(bar, claim)));
        leaves.sum()
    };
    // Positive floats order as their bits do. At 1 no claim is met, since one leaf is there already.
    let (mut low, mut high) = (0, 1_f64.to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if dealt(f64::from_bits(middle)) <= budget {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let bar = f64::from_bits(high);
    let mut counts: Vec<u32> = claims.iter().map(|&one| leaves_above(bar, one)).collect();
    let mut left = budget - counts.iter().copied().map(u64::from).sum::<u64>();
    for (count, &(size, weight)) in counts.iter_mut().zip(claims) {
        if left > 0 && *count < size && claim(weight, *count) >= bar {
            *count += 1;
            left -= 1;
        }
    }
    debug_assert_eq!(
        left, 0,
        "a bit lower, more claims are met than there are leaves"
    );
    counts
}

/// Shares are `clamp(λ · weight, 1, size)` with the λ for which they add up to the budget; then whole
/// parts and remainders.
fn largest_remainder(budget: u64, claims: &[(u32, f64)]) -> Vec<u32> {
    let share =
        |scale: f64, (size, weight): (u32, f64)| (scale * weight).clamp(1.0, f64::from(size));
    let sum = |scale: f64| claims.iter().map(|&one| share(scale, one)).sum::<f64>();
    // The least scale that reaches the budget, to the last bit; at the greatest all leaves show.
    let (mut low, mut high) = (0, (f64::from(u32::MAX) / LEAST_SHARE).to_bits());
    while low < high {
        let middle = low + (high - low) / 2;
        if sum(f64::from_bits(middle)) >= budget as f64 {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    let shares: Vec<f64> = claims
        .iter()
        .map(|&one| share(f64::from_bits(high), one))
        .collect();
    let mut counts: Vec<u32> = shares.iter().map(|&share| whole_u32(share)).collect();
    let mut left = budget.saturating_sub(counts.iter().copied().map(u64::from).sum());
    let mut order: Vec<usize> = (0..claims.len()).collect();
    let remainder = |cluster: usize| shares[cluster] - shares[cluster].floor();
    order.sort_by(|&one, &other| remainder(other).total_cmp(&remainder(one)));
    for cluster in order {
        if left > 0 && counts[cluster] < claims[cluster].0 {
            counts[cluster] += 1;
            left -= 1;
        }
    }
    debug_assert_eq!(left, 0, "remainders add up to what is left");
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, index_u32};

    /// Leaf after leaf, as the divisor's rule says it.
    fn leaf_after_leaf(budget: u32, sizes: &[u32], weights: &[f64]) -> Vec<u32> {
        let weights: Vec<f64> = relative(weights).collect();
        let mut counts = vec![1; sizes.len()];
        for _ in index_u32(sizes.len())..budget {
            let mut best: Option<(f64, usize)> = None;
            for cluster in (0..sizes.len()).filter(|&cluster| counts[cluster] < sizes[cluster]) {
                let claim = claim(weights[cluster], counts[cluster]);
                if best.is_none_or(|(most, _)| claim > most) {
                    best = Some((claim, cluster));
                }
            }
            let Some((_, cluster)) = best else { break };
            counts[cluster] += 1;
        }
        counts
    }

    /// Sizes and weights by a seed, ties among them.
    fn clusters(seed: u64) -> (Vec<u32>, Vec<f64>) {
        let mut draws = Stream::new(seed, 0).draws();
        let count = 1 + draws.below(9);
        let size = |draws: &mut crate::math::Draws| 1 + whole_u32(20.0 * f64::from(draws.unit()));
        let weight = |draws: &mut crate::math::Draws| {
            let coarse = 1.0 + f64::from((3.0 * draws.unit()).floor());
            let fine = f64::from(draws.unit());
            if seed.is_multiple_of(2) { coarse } else { fine }
        };
        (0..count)
            .map(|_| (size(&mut draws), weight(&mut draws)))
            .unzip()
    }

    #[test]
    fn the_divisor_hands_out_leaf_after_leaf_and_never_takes_one_back() {
        for seed in 0..400 {
            let (sizes, weights) = clusters(seed);
            let all = sizes.iter().sum();
            let mut before = vec![1; sizes.len()];
            for budget in 0..=all + 2 {
                let dealt = apportion(budget, &sizes, &weights, Apportionment::Divisor);
                assert_eq!(dealt, leaf_after_leaf(budget, &sizes, &weights));
                let clamped = budget.clamp(index_u32(sizes.len()), all);
                assert_eq!(dealt.iter().sum::<u32>(), clamped);
                assert!(dealt.iter().zip(&before).all(|(now, before)| now >= before));
                before = dealt;
            }
            assert_eq!(before, sizes);
        }
    }

    #[test]
    fn remainders_add_up_too_and_keep_the_quota_but_not_their_leaves() {
        let mut paradoxes = 0;
        for seed in 0..400 {
            let (sizes, weights) = clusters(seed);
            let all: u32 = sizes.iter().sum();
            let mut before = vec![1; sizes.len()];
            for budget in 0..=all + 2 {
                let dealt = apportion(budget, &sizes, &weights, Apportionment::LargestRemainder);
                let clamped = budget.clamp(index_u32(sizes.len()), all);
                assert_eq!(dealt.iter().sum::<u32>(), clamped);
                assert!(
                    dealt
                        .iter()
                        .zip(&sizes)
                        .all(|(n, size)| (1..=*size).contains(n))
                );
                paradoxes += u32::from(dealt.iter().zip(&before).any(|(now, then)| now < then));
                before = dealt;
            }
        }
        assert!(
            paradoxes > 100,
            "only {paradoxes} budgets took a leaf from a cluster"
        );
        // Alabama's own case, as printed in textbooks: shares 6, 6, 2 of 10 and of 11 seats.
        let seats = |budget, method| apportion(budget, &[99; 3], &[6.0, 6.0, 2.0], method);
        let remainder = |budget| seats(budget, Apportionment::LargestRemainder);
        assert_eq!(remainder(10), [4, 4, 2]);
        assert_eq!(remainder(11), [5, 5, 1]);
        let divisor = |budget| -> [u32; 3] {
            let dealt = seats(budget, Apportionment::Divisor);
            dealt.try_into().expect("three clusters")
        };
        assert_eq!([10, 11, 12].map(divisor), [[5, 4, 1], [5, 5, 1], [5, 5, 2]]);
    }

    #[test]
    fn equal_weights_deal_equal_shares() {
        for method in [Apportionment::Divisor, Apportionment::LargestRemainder] {
            for weight in [0.0, 1.0, f64::NAN, f64::INFINITY, 1e-320] {
                assert_eq!(apportion(12, &[9; 4], &[weight; 4], method), [3; 4]);
                assert_eq!(apportion(14, &[9; 4], &[weight; 4], method), [4, 4, 3, 3]);
                // What the small cannot take goes to the others, equally.
                assert_eq!(
                    apportion(14, &[9, 1, 9, 2], &[weight; 4], method),
                    [6, 1, 5, 2]
                );
            }
            assert_eq!(apportion(5, &[], &[], method), [0; 0]);
            let extreme = [f64::INFINITY, f64::NAN, -1.0, f64::MIN_POSITIVE];
            assert_eq!(apportion(12, &[5; 4], &extreme, method), [5, 3, 2, 2]);
        }
    }
}
