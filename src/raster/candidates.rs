//! Pixels of one triangle that wait for their alpha to be tested.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x16, mask32x16, u32x16};

use super::frame::BLOCK_SIDE;
use super::tile::Tile;
use crate::math::index_u32;

/// The most candidates: the pixels of a tile.
const MOST: usize = (BLOCK_SIDE * BLOCK_SIDE) as usize;

/// How many join at once.
pub(super) const TOGETHER: usize = 16;

/// Room for lanes beyond the last candidate.
const ROOM: usize = MOST + TOGETHER;

/// Pixels of one triangle that it may win, their alpha not yet tested.
#[derive(Debug)]
pub(super) struct Candidates {
    pub(super) count: usize,
    /// Their places in the block.
    pub(super) index: [u32; ROOM],
    /// The second and third edge functions at their centres.
    pub(super) centre: [[f32; ROOM]; 2],
    /// Which samples are covered, and which of these are won if alpha is there.
    pub(super) covered: [u32; ROOM],
    winning: [u32; ROOM],
    /// The bits of the depths, sample by sample.
    pub(super) depths: [[u32; ROOM]; 4],
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            count: 0,
            index: [0; ROOM],
            centre: [[0.0; ROOM]; 2],
            covered: [0; ROOM],
            winning: [0; ROOM],
            depths: [[0; ROOM]; 4],
        }
    }
}

/// Pixels with one sample each, in lanes.
pub(super) struct Joining<S: Simd> {
    pub(super) index: u32x16<S>,
    pub(super) centre: [f32x16<S>; 2],
    pub(super) depth: u32x16<S>,
    /// A bit for each that is covered.
    pub(super) covered: u64,
    /// A bit for each of these that is won if alpha is there.
    pub(super) winning: u64,
}

impl Candidates {
    #[inline(always)]
    pub(super) fn push<const SAMPLES: usize>(
        &mut self,
        index: usize,
        centre: [f32; 2],
        [covered, winning]: [u32; 2],
        depths: [u32; SAMPLES],
    ) {
        let last = self.count % MOST;
        self.count = last + 1;
        self.index[last] = index_u32(index);
        self.centre[0][last] = centre[0];
        self.centre[1][last] = centre[1];
        self.covered[last] = covered;
        self.winning[last] = winning;
        for (all, depth) in self.depths.iter_mut().zip(depths) {
            all[last] = depth;
        }
    }

    /// Those that are covered join.
    #[inline(always)]
    pub(super) fn join<S: Simd>(&mut self, simd: S, joining: &Joining<S>) {
        let last = self.count % MOST;
        let Joining {
            index,
            centre,
            depth,
            covered,
            winning,
        } = joining;
        let mask = mask32x16::from_bitmask(simd, *covered);
        index
            .compress(mask)
            .store_slice(&mut self.index[last..][..TOGETHER]);
        centre[0]
            .compress(mask)
            .store_slice(&mut self.centre[0][last..][..TOGETHER]);
        centre[1]
            .compress(mask)
            .store_slice(&mut self.centre[1][last..][..TOGETHER]);
        depth
            .compress(mask)
            .store_slice(&mut self.depths[0][last..][..TOGETHER]);
        let one = u32x16::splat(simd, 1);
        one.store_slice(&mut self.covered[last..][..TOGETHER]);
        one.store_slice(&mut self.winning[last..][..TOGETHER]);
        self.count = last + covered.count_ones() as usize;
        if covered != winning {
            self.lose(last, *covered, *winning);
        }
    }

    /// Of some from a place on, those covered, all but some win nothing.
    fn lose(&mut self, first: usize, covered: u64, winning: u64) {
        let mut rest = covered;
        for place in &mut self.winning[first..self.count] {
            *place = u32::from(winning >> rest.trailing_zeros() & 1 == 1);
            rest &= rest.wrapping_sub(1);
        }
    }

    /// One of them wins.
    #[inline(always)]
    pub(super) fn win<const SAMPLES: usize>(
        &self,
        tile: &mut Tile<'_, '_>,
        place: usize,
        mark: u32,
    ) {
        let first = self.index[place] as usize * SAMPLES;
        for sample in 0..SAMPLES {
            if self.winning[place] >> sample & 1 == 1 {
                tile.depth[first + sample] = self.depths[sample][place];
                tile.scratch.owner[first + sample] = mark;
            }
        }
    }
}
