//! Every target over its seeds, and over small damage done to each.

use spinney_fuzz::{TARGETS, seeds, words};

#[test]
fn targets_return_on_every_seed_and_on_damaged_ones() {
    for (name, target) in TARGETS {
        let seeds = seeds(name);
        assert!(seeds.len() >= 3 && !words(name).is_empty(), "{name}");
        for (number, (_, bytes)) in (0_u64..).zip(&seeds) {
            target(bytes);
            for round in 0..8 {
                target(&damaged(bytes, 97 * number + round));
            }
        }
    }
}

/// Some bytes changed, left out or cut off, by a generator of random numbers (splitmix64).
fn damaged(bytes: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed;
    let mut below = |end: usize| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        usize::try_from((mixed ^ (mixed >> 31)) % (end.max(1) as u64)).expect("below a length")
    };
    let mut bytes = bytes.to_vec();
    for _ in 0..=below(3) {
        let place = below(bytes.len());
        match below(4) {
            0 => bytes.truncate(place),
            1 if !bytes.is_empty() => drop(bytes.remove(place)),
            2 => bytes.insert(place, b"0-[{\"\0\xff9"[below(8)]),
            _ => {
                if let Some(byte) = bytes.get_mut(place) {
                    *byte ^= 1 << below(8);
                }
            }
        }
    }
    bytes
}
