//! Which samples a triangle covers and which of them it wins: the visibility buffer.
//!
//! Triangles of one sample a pixel that are not too large are decided [in lanes](super::cover_lanes), with
//! edge functions in 32 bits; the others span by span. Where alpha is tested, pixels that may win become
//! candidates, and those of a triangle are tested together.

use std::ops::Range;

use fearless_simd::{Simd, SimdBase, f32x8};

use super::candidates::Candidates;
use super::pixels::{Along, Gains, SpanRows, Spans, gains};
use super::plane::{Attributes, DepthLanes, Edges, LANES, depth_at, fits_lanes};
use super::setup::{Chunk, Triangle};
use super::tile::{Choice, Tile};
use super::view::PixelBox;
use super::{Counters, Fragment};

/// Decides opaque triangles of a tile against what is there.
#[inline(always)]
pub(super) fn cover<S: Simd, F: Fragment, const SAMPLES: usize>(
    simd: S,
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    let mut candidates = tile.scratch.candidates.take().unwrap_or_default();
    let exact = tile.scene.counters == Counters::Exact;
    for place in 0..choice.count(chunk) {
        let number = choice.triangle(place);
        let triangle = &chunk.triangles[number];
        let Some(pixels) = tile.pixels.meet(triangle.pixels) else {
            continue;
        };
        if !exact && many(pixels) {
            let nearest = triangle.nearest.max(0.0).to_bits();
            let hidden = if SAMPLES == 1 {
                tile.hides_lanes(simd, pixels, nearest)
            } else {
                tile.hides(pixels, nearest)
            };
            if hidden {
                continue;
            }
        }
        let mut contest = Contest::<F, SAMPLES> {
            kernel,
            edges: Edges::of(triangle),
            triangle,
            number,
            mark: 0,
            exact,
            tile,
            chunk,
            candidates: &mut candidates,
            attributes: None,
        };
        if SAMPLES == 1 && fits_lanes(triangle) {
            contest.fight_in_lanes(simd, pixels);
        } else {
            contest.fight(simd, pixels);
        }
    }
    tile.scratch.candidates = Some(candidates);
}

/// Whether it pays to look first if all that is there is nearer.
#[inline(always)]
fn many(pixels: PixelBox) -> bool {
    let [columns, rows] = [0, 1].map(|axis| pixels.last[axis] - pixels.first[axis] + 1);
    columns * rows >= 6
}

/// A triangle against what is there.
pub(super) struct Contest<'c, 't, 'a, F, const SAMPLES: usize> {
    kernel: &'c F,
    pub(super) edges: Edges,
    pub(super) triangle: &'c Triangle,
    pub(super) number: usize,
    /// What samples that it wins are marked with; 0 as long as there is none.
    mark: u32,
    pub(super) exact: bool,
    pub(super) tile: &'c mut Tile<'t, 'a>,
    pub(super) chunk: &'c Chunk<'c>,
    pub(super) candidates: &'c mut Candidates,
    attributes: Option<Attributes<'c>>,
}

impl<F: Fragment, const SAMPLES: usize> Contest<'_, '_, '_, F, SAMPLES> {
    /// Span by span.
    #[inline(always)]
    fn fight<S: Simd>(&mut self, simd: S, pixels: PixelBox) {
        let edges = self.edges;
        let gains = gains::<SAMPLES>(self.tile.scene.samples, &edges);
        for spans in SpanRows::of(&edges, &gains, pixels) {
            self.row(&gains, &spans);
        }
        self.decide(simd);
    }

    #[inline(always)]
    fn row(&mut self, gains: &Gains<SAMPLES>, spans: &Spans<SAMPLES>) {
        let [first, last] = spans.columns();
        if first > last {
            return;
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
                        && self
                            .tile
                            .wins_tie(self.chunk, self.number, index * SAMPLES + sample));
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
            self.tile.work(self.chunk.batch).covered += u64::from(covered_samples);
        }
    }

    /// Tests the alpha of the candidates; those that are there win.
    #[inline(always)]
    pub(super) fn decide<S: Simd>(&mut self, simd: S) {
        let count = std::mem::take(&mut self.candidates.count);
        if !F::TESTS_ALPHA {
            for place in 0..count {
                self.win(place);
            }
        } else {
            for first in (0..count).step_by(LANES) {
                self.test(simd, first..count.min(first + LANES));
            }
        }
    }

    /// Tests at most 8 candidates.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, places: Range<usize>) {
        let (first, count) = (places.start, places.len());
        let candidates = &*self.candidates;
        let centre: [f32x8<S>; 2] = [
            f32x8::from_slice(simd, &candidates.centre[0][first..][..LANES]),
            f32x8::from_slice(simd, &candidates.centre[1][first..][..LANES]),
        ];
        let mut positions = [[0; 2]; LANES];
        for (lane, position) in positions.iter_mut().enumerate().take(count) {
            let [x, y] = self.tile.pixel_at(candidates.index[first + lane] as usize);
            *position = [x.unsigned_abs(), y.unsigned_abs()];
        }
        let depths = DepthLanes::of(simd, self.triangle).at(simd, centre);
        let wanted = (1_u64 << count) - 1;
        let kept = self.keeps(simd, centre, positions, depths, wanted);
        if self.exact {
            for lane in 0..count {
                let covered = self.candidates.covered[first + lane].count_ones();
                let work = self.tile.work(self.chunk.batch);
                work.texels += self.kernel.texels_tested();
                work.alpha_killed += u64::from(covered) * (1 - (kept >> lane & 1));
            }
        }
        let mut rest = kept;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % LANES;
            rest &= rest - 1;
            self.win(first + lane);
        }
    }

    /// A bit for each of the wanted pixels whose alpha is there.
    #[inline(always)]
    fn keeps<S: Simd>(
        &mut self,
        simd: S,
        centre: [f32x8<S>; 2],
        positions: [[u32; 2]; LANES],
        depth: f32x8<S>,
        wanted: u64,
    ) -> u64 {
        if self.attributes.is_none() {
            let attributes = Attributes::of::<F>(self.triangle, &self.edges, self.chunk);
            self.attributes = Some(attributes);
        }
        let Some(attributes) = &self.attributes else {
            return 0;
        };
        let mut depths = [0.0; LANES];
        depth.store_slice(&mut depths);
        let pixels = attributes.lanes::<S, F>(simd, centre, positions, depths);
        self.kernel.keeps_lanes(simd, &pixels, wanted) & wanted
    }

    #[inline(always)]
    fn win(&mut self, place: usize) {
        let mark = self.mark();
        self.candidates.win::<SAMPLES>(self.tile, place, mark);
    }

    /// What samples are marked with that it wins.
    #[inline(always)]
    pub(super) fn mark(&mut self) -> u32 {
        if self.mark == 0 {
            self.mark = self.tile.enter(self.number);
        }
        self.mark
    }
}
