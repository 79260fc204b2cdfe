//! What a patch of 8 × 8 pixels hides: the furthest depth in it.
//!
//! Kept beside the depths of the samples, so that what lies behind a whole patch is left out without
//! a look at its pixels. No picture depends on it.

use super::frame::BLOCK_SIDE;

/// Pixels a side of a patch.
pub(super) const SIDE: usize = 8;

/// Patches a side of a block.
pub(super) const PATCHES_A_ROW: usize = BLOCK_SIDE as usize / SIDE;

/// The furthest depth in each patch of a block, as bits.
#[derive(Debug)]
pub(super) struct Furthest([u32; PATCHES_A_ROW * PATCHES_A_ROW]);

impl Furthest {
    pub(super) fn new() -> Self {
        Self([u32::MAX; PATCHES_A_ROW * PATCHES_A_ROW])
    }

    #[inline]
    pub(super) fn of(&self, patch: usize) -> u32 {
        self.0[patch % (PATCHES_A_ROW * PATCHES_A_ROW)]
    }

    /// Looks again at the patches that have a bit in `patches`.
    pub(super) fn renew<const SAMPLES: usize>(&mut self, patches: u64, depths: &[u32]) {
        let mut rest = patches;
        while rest != 0 {
            let patch = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let (row, column) = (patch / PATCHES_A_ROW, patch % PATCHES_A_ROW);
            let first = (row * BLOCK_SIDE as usize + column) * SIDE * SAMPLES;
            let mut furthest = [0.0_f32; SIDE];
            for row in depths[first..]
                .chunks(BLOCK_SIDE as usize * SAMPLES)
                .take(SIDE)
            {
                for lanes in row[..SIDE * SAMPLES].as_chunks::<SIDE>().0 {
                    for lane in 0..SIDE {
                        furthest[lane] = further(f32::from_bits(lanes[lane]), furthest[lane]);
                    }
                }
            }
            let furthest = furthest.into_iter().fold(0.0, further);
            self.0[patch] = furthest.to_bits();
        }
    }
}

#[inline(always)]
fn further(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The patch of the pixel at a place in the block.
#[inline]
pub(super) fn patch_number(index: usize) -> usize {
    let side = BLOCK_SIDE as usize;
    index / side / SIDE * PATCHES_A_ROW + index % side / SIDE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_furthest_sample_of_a_patch_counts() {
        let side = BLOCK_SIDE as usize;
        let mut depths = vec![0.5_f32.to_bits(); 4 * side * side];
        let pixel = 17 * side + 31;
        depths[4 * pixel + 3] = 0.75_f32.to_bits();
        let mut furthest = Furthest::new();
        furthest.renew::<4>(1 << 19 | 1 << 20, &depths);
        assert_eq!(patch_number(pixel), 19, "third row, fourth column");
        assert_eq!(
            [19, 20].map(|patch| furthest.of(patch)),
            [0.75, 0.5].map(f32::to_bits)
        );
        assert_eq!(furthest.of(18), u32::MAX, "not looked at");
    }
}
