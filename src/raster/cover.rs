//! Which samples a triangle covers and which of them it wins: the visibility buffer.
//!
//! A patch of 8 × 8 pixels at a time: what lies behind all that is there is skipped, the others'
//! depths are compared in lanes. Pixels that may win become candidates, and the alpha of a
//! triangle's candidates is tested together.

use std::ops::Range;

use super::frame::BLOCK_SIDE;
use super::hidden::patch_number;
use super::pixels::{Along, Gains, Spans, gains, visit_spans};
use super::plane::{Attributes, Edges, LANES, depth_at};
use super::setup::Triangle;
use super::tile::Tile;
use super::view::PixelBox;
use super::{Counters, Fragment};
use crate::math::index_u32;

/// Decides the opaque triangles `entries` of a tile against what is there.
pub(super) fn cover<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entries: &[u32],
) {
    let mut candidates = tile.scratch.candidates.take().unwrap_or_default();
    let exact = tile.scene.counters == Counters::Exact;
    let tests_alpha = F::TESTS_ALPHA && (exact || !kernel.keeps_all());
    for &entry in entries {
        let entry = entry as usize;
        let triangle = tile.triangle(entry).0;
        let Some(pixels) = tile.pixels_of(triangle) else {
            continue;
        };
        let mut contest = Contest::<F, SAMPLES> {
            kernel,
            edges: Edges::of(triangle),
            triangle,
            entry,
            exact,
            tests_alpha,
            tile,
            candidates: &mut candidates,
            attributes: None,
        };
        contest.fight(pixels);
    }
    tile.scratch.candidates = Some(candidates);
}

/// The most candidates that are tested together.
const MOST: usize = 2 * BLOCK_SIDE as usize;

/// Pixels of one triangle that it may win, their alpha not yet tested.
#[derive(Debug)]
pub(super) struct Candidates {
    count: usize,
    /// Their places in the block.
    index: [u32; MOST],
    /// The second and third edge functions at their centres.
    centre: [[f32; MOST]; 2],
    /// Which samples are covered, and which of these are won if alpha is there.
    covered: [u32; MOST],
    winning: [u32; MOST],
    depths: [[u32; 4]; MOST],
    /// A bit a patch of the block in which something was won.
    changed: u64,
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            count: 0,
            index: [0; MOST],
            centre: [[0.0; MOST]; 2],
            covered: [0; MOST],
            winning: [0; MOST],
            depths: [[0; 4]; MOST],
            changed: 0,
        }
    }
}

impl Candidates {
    #[inline]
    fn push<const SAMPLES: usize>(
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
        self.depths[last][..SAMPLES].copy_from_slice(&depths);
    }
}

/// A triangle against what is there.
struct Contest<'c, 't, 'a, F, const SAMPLES: usize> {
    kernel: &'c F,
    edges: Edges,
    triangle: &'a Triangle,
    entry: usize,
    exact: bool,
    tests_alpha: bool,
    tile: &'c mut Tile<'t>,
    candidates: &'c mut Candidates,
    attributes: Option<Attributes<'a>>,
}

impl<'t: 'a, 'a, F: Fragment, const SAMPLES: usize> Contest<'_, 't, 'a, F, SAMPLES> {
    #[inline(always)]
    fn fight(&mut self, pixels: PixelBox) {
        if !self.exact && self.tile.hides(pixels, self.triangle.nearest) {
            return;
        }
        let edges = self.edges;
        let gains = gains::<SAMPLES>(self.tile.scene.samples, &edges);
        visit_spans(&edges, &gains, pixels, |spans| self.row(&gains, spans));
        self.decide();
    }

    #[inline(always)]
    fn row(&mut self, gains: &Gains<SAMPLES>, spans: &Spans<SAMPLES>) {
        let [first, last] = spans.columns();
        if first > last {
            return;
        }
        if self.candidates.count > MOST - BLOCK_SIDE as usize {
            self.decide();
        }
        let triangle = self.triangle;
        let start = self.tile.index(first, spans.y);
        let end = self.tile.index(last, spans.y) + 1;
        let there = &self.tile.depth[start * SAMPLES..end * SAMPLES];
        let mut along = Along::new(&self.edges, first, spans.y);
        let mut covered_samples = 0;
        for ((there, index), x) in there
            .as_chunks::<SAMPLES>()
            .0
            .iter()
            .zip(start..)
            .zip(first..)
        {
            let covered = spans.mask(x);
            let mut winning = 0_u32;
            let mut depths = [0_u32; SAMPLES];
            for sample in 0..SAMPLES {
                if SAMPLES > 1 && covered >> sample & 1 == 0 {
                    continue;
                }
                let depth = depth_at(triangle, along.sample(gains[sample])).to_bits();
                let wins = depth < there[sample]
                    || (depth == there[sample]
                        && self.tile.wins_tie(self.entry, index * SAMPLES + sample));
                winning |= u32::from(wins) << sample;
                depths[sample] = depth;
            }
            if winning != 0 || (self.exact && covered != 0) {
                let marks = [covered, winning];
                self.candidates.push(index, along.centre(), marks, depths);
            }
            covered_samples += covered.count_ones();
            along.step();
        }
        if self.exact {
            self.tile.work(triangle.batch).covered += u64::from(covered_samples);
        }
    }

    /// Tests the alpha of the candidates; those that are there win.
    #[inline(never)]
    fn decide(&mut self) {
        let count = std::mem::take(&mut self.candidates.count);
        if count == 0 {
            return;
        }
        if !self.tests_alpha {
            for place in 0..count {
                self.win(place);
            }
        } else {
            for first in (0..count).step_by(LANES) {
                self.test(first..count.min(first + LANES));
            }
        }
        let patches = std::mem::take(&mut self.candidates.changed);
        let furthest = &mut self.tile.scratch.furthest;
        furthest.renew::<SAMPLES>(patches, self.tile.depth);
    }

    /// Tests at most 8 candidates.
    #[inline(always)]
    fn test(&mut self, places: Range<usize>) {
        let (triangle, edges, tile) = (self.triangle, &self.edges, &mut *self.tile);
        let attributes = self.attributes.get_or_insert_with(|| {
            let (_, chunk, batch) = tile.triangle(self.entry);
            Attributes::of::<F>(triangle, edges, chunk, batch)
        });
        let at = |axis: usize| {
            let lanes = self.candidates.centre[axis][places.start..].first_chunk();
            *lanes.expect("a whole number of times 8 candidates")
        };
        let centres = [at(0), at(1)];
        let pixels = attributes.pixels::<F>(centres);
        for (place, lane) in places.zip(0..LANES) {
            let index = self.candidates.index[place] as usize;
            let position = self.tile.pixel_at(index).map(i32::unsigned_abs);
            let depth = depth_at(triangle, [centres[0][lane], centres[1][lane]]);
            let keeps = pixels.hand_over(lane, position, depth, |pixel| self.kernel.keeps(pixel));
            if self.exact {
                let work = self.tile.work(triangle.batch);
                work.texels += self.kernel.texels_tested();
                if !keeps {
                    work.alpha_killed += u64::from(self.candidates.covered[place].count_ones());
                }
            }
            if keeps {
                self.win(place);
            }
        }
    }

    #[inline]
    fn win(&mut self, place: usize) {
        let index = self.candidates.index[place] as usize;
        let first = index * SAMPLES;
        self.candidates.changed |= 1 << patch_number(index);
        for sample in 0..SAMPLES {
            if self.candidates.winning[place] >> sample & 1 == 1 {
                self.tile.depth[first + sample] = self.candidates.depths[place][sample];
                self.tile.scratch.owner[first + sample] = index_u32(self.entry) + 1;
            }
        }
    }
}
