//! Which samples a triangle covers and which of them it wins: the visibility buffer.
//!
//! Triangles of one sample a pixel that are not too large are decided in lanes, eight pixels of a row at
//! a time, with edge functions in 32 bits; the others span by span. Either way pixels that may win become
//! candidates, and the alpha of a triangle's candidates is tested together.

use std::ops::Range;

use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdInt, SimdMask, f32x8, i32x8, mask32x8, u32x8,
};

use super::frame::BLOCK_SIDE;
use super::pixels::{Along, Gains, SpanRows, Spans, gains};
use super::plane::{Attributes, DepthLanes, Edges, LANES, depth_at, fits_lanes, narrow, step};
use super::setup::{Chunk, Triangle};
use super::tile::{Choice, Tile};
use super::view::PixelBox;
use super::{Counters, Fragment};
use crate::math::index_u32;

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
        if !exact && many(pixels) && tile.hides(pixels, triangle.nearest.max(0.0).to_bits()) {
            continue;
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
    columns * rows >= 24
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
        }
    }
}

impl Candidates {
    #[inline(always)]
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
    triangle: &'c Triangle,
    number: usize,
    /// What samples that it wins are marked with; 0 as long as there is none.
    mark: u32,
    exact: bool,
    tile: &'c mut Tile<'t, 'a>,
    chunk: &'c Chunk<'c>,
    candidates: &'c mut Candidates,
    attributes: Option<Attributes<'c>>,
}

impl<F: Fragment, const SAMPLES: usize> Contest<'_, '_, '_, F, SAMPLES> {
    /// Eight pixels of a row at a time, one sample each.
    #[inline(always)]
    fn fight_in_lanes<S: Simd>(&mut self, simd: S, pixels: PixelBox) {
        let [x0, y0] = pixels.first;
        let [x1, y1] = pixels.last;
        // Lanes stay within the block: those beside the pixels are left out by their column.
        let last_start = self.tile.origin[0] + BLOCK_SIDE.cast_signed() - LANE_COUNT;
        let lane = i32x8::from_slice(simd, &[0, 1, 2, 3, 4, 5, 6, 7]);
        let (right, down, bias) = (self.edges.right, self.edges.down, self.edges.bias);
        let (right, down) = (
            [step(right[0]), step(right[1]), step(right[2])],
            [step(down[0]), step(down[1]), step(down[2])],
        );
        let along = [
            lane * i32x8::splat(simd, right[0]),
            lane * i32x8::splat(simd, right[1]),
            lane * i32x8::splat(simd, right[2]),
        ];
        let below = [
            i32x8::splat(simd, down[0]),
            i32x8::splat(simd, down[1]),
            i32x8::splat(simd, down[2]),
        ];
        let biases = [
            i32x8::splat(simd, narrow(bias[1])),
            i32x8::splat(simd, narrow(bias[2])),
        ];
        let zero = i32x8::splat(simd, 0);
        let depths = DepthLanes::of(simd, self.triangle);
        let mut start = x0;
        while start <= x1 {
            let x = start.min(last_start);
            let wanted = columns(x, start, x1);
            let [top, bottom] = self.rows(x, [y0, y1], right, down);
            let at = self.edges.at_pixel(x, top);
            let mut first = along[0] + i32x8::splat(simd, narrow(at[0] + bias[0]));
            let mut second = along[1] + i32x8::splat(simd, narrow(at[1]));
            let mut third = along[2] + i32x8::splat(simd, narrow(at[2]));
            let mut index = self.tile.index(x, top);
            for _ in top..=bottom {
                let outside = first | (second + biases[0]) | (third + biases[1]);
                let covered = outside.simd_ge(zero).to_bitmask() & wanted;
                if covered != 0 {
                    self.row_in_lanes(simd, &depths, [second, third], covered, index);
                }
                first += below[0];
                second += below[1];
                third += below[2];
                index += BLOCK_SIDE as usize;
            }
            start = x + LANE_COUNT;
        }
        if F::TESTS_ALPHA {
            self.decide(simd);
        }
    }

    /// The rows, of some, outside of which no edge function is positive in all lanes from a column on.
    #[inline(always)]
    fn rows(&self, x: i32, [y0, y1]: [i32; 2], right: [i32; 3], down: [i32; 3]) -> [i32; 2] {
        /// Of fewer it costs less to look at each.
        const MANY_ROWS: i32 = 6;
        let [mut top, mut bottom] = [y0, y1];
        if y1 - y0 < MANY_ROWS {
            return [top, bottom];
        }
        let at = self.edges.at_pixel(x, y0);
        for edge in 0..3 {
            let first = narrow(at[edge] + self.edges.bias[edge]);
            let most = first + (right[edge] * (LANE_COUNT - 1)).max(0);
            let down = down[edge];
            if most < 0 && down > 0 {
                top = top.max(y0 + (-1 - most) / down + 1);
            } else if most < 0 {
                return [y0, y0 - 1];
            } else if down < 0 {
                bottom = bottom.min(y0 + most / -down);
            }
        }
        // An empty range begins within the block, too.
        if top <= bottom {
            [top, bottom]
        } else {
            [y0, y0 - 1]
        }
    }

    #[inline(always)]
    fn row_in_lanes<S: Simd>(
        &mut self,
        simd: S,
        depths: &DepthLanes<S>,
        edges: [i32x8<S>; 2],
        covered: u64,
        index: usize,
    ) {
        let centre: [f32x8<S>; 2] = [edges[0].to_float(), edges[1].to_float()];
        let depth = depths.at(simd, centre);
        let bits: u32x8<S> = depth.bitcast();
        let there = u32x8::from_slice(simd, &self.tile.depth[index..][..LANES]);
        let mut winning = bits.simd_lt(there).to_bitmask() & covered;
        let mut equal = bits.simd_eq(there).to_bitmask() & covered;
        while equal != 0 {
            let lane = equal.trailing_zeros() as usize;
            equal &= equal - 1;
            let wins = self.tile.wins_tie(self.chunk, self.number, index + lane);
            winning |= u64::from(wins) << lane;
        }
        if self.exact {
            let count = u64::from(covered.count_ones());
            self.tile.work(self.chunk.batch).covered += count;
        } else if winning == 0 {
            return;
        }
        let tested = if self.exact { covered } else { winning };
        if !F::TESTS_ALPHA || tested.count_ones() >= MANY_LANES {
            if F::TESTS_ALPHA {
                let [x, y] = self.tile.pixel_at(index);
                let (x, y) = (x.unsigned_abs(), y.unsigned_abs());
                let positions = [
                    [x, y],
                    [x + 1, y],
                    [x + 2, y],
                    [x + 3, y],
                    [x + 4, y],
                    [x + 5, y],
                    [x + 6, y],
                    [x + 7, y],
                ];
                let kept = self.keeps(simd, centre, positions, depth, tested);
                winning &= kept;
                if self.exact {
                    let tested = u64::from(tested.count_ones());
                    let work = self.tile.work(self.chunk.batch);
                    work.texels += tested * self.kernel.texels_tested();
                    work.alpha_killed += tested - u64::from(kept.count_ones());
                }
            }
            if winning != 0 {
                let mark = self.mark();
                let mask = mask32x8::from_bitmask(simd, winning);
                let depths = mask.select(bits, there);
                depths.store_slice(&mut self.tile.depth[index..][..LANES]);
                let owners = &mut self.tile.scratch.owner[index..][..LANES];
                let held = u32x8::from_slice(simd, owners);
                let held = mask.select(u32x8::splat(simd, mark), held);
                held.store_slice(owners);
            }
            return;
        }
        if self.candidates.count > MOST - LANES {
            self.decide(simd);
        }
        let (mut depths, mut centres) = ([0_u32; LANES], [[0.0_f32; LANES]; 2]);
        bits.store_slice(&mut depths);
        centre[0].store_slice(&mut centres[0]);
        centre[1].store_slice(&mut centres[1]);
        let mut rest = tested;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % LANES;
            rest &= rest - 1;
            let wins = u32::from(winning >> lane & 1 == 1);
            let at = [centres[0][lane], centres[1][lane]];
            self.candidates
                .push(index + lane, at, [1, wins], [depths[lane]]);
        }
    }

    /// Span by span.
    #[inline(always)]
    fn fight<S: Simd>(&mut self, simd: S, pixels: PixelBox) {
        let edges = self.edges;
        let gains = gains::<SAMPLES>(self.tile.scene.samples, &edges);
        for spans in SpanRows::of(&edges, &gains, pixels) {
            self.row(simd, &gains, &spans);
        }
        self.decide(simd);
    }

    #[inline(always)]
    fn row<S: Simd>(&mut self, simd: S, gains: &Gains<SAMPLES>, spans: &Spans<SAMPLES>) {
        let [first, last] = spans.columns();
        if first > last {
            return;
        }
        if self.candidates.count > MOST - BLOCK_SIDE as usize {
            self.decide(simd);
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
    fn decide<S: Simd>(&mut self, simd: S) {
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
        win::<SAMPLES>(self.tile, self.candidates, place, mark);
    }

    /// What samples are marked with that it wins.
    #[inline(always)]
    fn mark(&mut self) -> u32 {
        if self.mark == 0 {
            self.mark = self.tile.enter(self.number);
        }
        self.mark
    }
}

#[inline(always)]
fn win<const SAMPLES: usize>(
    tile: &mut Tile<'_, '_>,
    candidates: &Candidates,
    place: usize,
    mark: u32,
) {
    let first = candidates.index[place] as usize * SAMPLES;
    for sample in 0..SAMPLES {
        if candidates.winning[place] >> sample & 1 == 1 {
            tile.depth[first + sample] = candidates.depths[place][sample];
            tile.scratch.owner[first + sample] = mark;
        }
    }
}

/// So many lanes of a row are tested where they are found, fewer with others of the triangle.
const MANY_LANES: u32 = 4;

/// As many as [`LANES`].
const LANE_COUNT: i32 = 8;
const _: () = assert!(LANES == LANE_COUNT.unsigned_abs() as usize, "one number");

/// The bits of the lanes from column `x` on that lie within some columns.
#[inline(always)]
fn columns(x: i32, first: i32, last: i32) -> u64 {
    let before = (1_u64 << (first - x)) - 1;
    let until = (2_u64 << (last - x).min(LANE_COUNT - 1)) - 1;
    until & !before
}
