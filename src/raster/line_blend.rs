//! Lines blended over what is there, sixteen pixels at a time: four rows of four.
//!
//! Most lines are a few pixels long. Both triangles of a line are decided together, since no pixel lies in
//! both; attributes are computed pixel by pixel, all varyings at once. Whatever is long or far apart goes
//! through triangles.

use std::ops::Range;

use fearless_simd::{
    Bytes, Select, Simd, SimdBase, SimdCombine, SimdInt, SimdMask, f32x4, f32x8, f32x16, i32x16,
    mask32x8, mask32x16, u32x4, u32x8, u32x16,
};

use super::even_lines;
use super::frame::BLOCK_SIDE;
use super::line_records::{Line, range};
use super::setup::{Chunk, unfold};
use super::tile::{Choice, Tile};
use super::view::{PixelBox, SUBPIXELS};
use super::{Counters, Fragment, MAX_VARYINGS, Pixel};
use crate::math::{Vec2, Vec4};

/// Columns and rows of pixels that are decided together.
const SIDE: i32 = 4;
const TOGETHER: usize = 16;
/// The column and row of each lane.
const COLUMN_OF: [i32; TOGETHER] = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3];
const ROW_OF: [i32; TOGETHER] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3];

/// Blends some lines of a chunk over what is there, in order.
#[inline(always)]
pub(super) fn blend<S: Simd, F: Fragment>(
    simd: S,
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    let mut counts = Counts::default();
    let mut run = 0;
    while let Some(places) = choice.run(run, chunk) {
        some(simd, kernel, tile, chunk, places, &mut counts);
        run += 1;
    }
    if counts != Counts::default() {
        let exact = tile.scene.counters == Counters::Exact;
        let work = tile.work(chunk.batch);
        work.visible += counts.visible;
        if exact {
            work.covered += counts.covered;
            work.texels += counts.visible * kernel.texels_shaded();
        }
    }
}

/// A run of lines.
#[inline(always)]
fn some<S: Simd, F: Fragment>(
    simd: S,
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    places: Range<usize>,
    counts: &mut Counts,
) {
    for place in places {
        let line = &chunk.lines.line(place, F::VARYINGS);
        let pixels = line.pixels(&tile.scene.view);
        let Some(pixels) = pixels.and_then(|pixels| tile.pixels.meet(pixels)) else {
            continue;
        };
        if !fits_lanes(line, pixels) {
            by_triangles(kernel, tile, chunk, place);
        } else if F::FROM_VARYINGS && chunk.lines.are_even() {
            even_lines::draw(simd, kernel, tile, (chunk, place), line, pixels, counts);
        } else {
            let brush = Brush::<S, F>::new(simd, kernel, chunk, line, place);
            brush.draw(simd, tile, pixels, counts);
        }
    }
}

/// What was done for some lines.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) visible: u64,
    pub(super) covered: u64,
}

#[inline(never)]
fn by_triangles<F: Fragment>(kernel: &F, tile: &mut Tile<'_, '_>, chunk: &Chunk<'_>, place: usize) {
    let triangles = unfold(&tile.scene.view, chunk, place, F::VARYINGS);
    super::shade::blend::<F, 1>(kernel, tile, &triangles, Choice::ALL);
}

/// Whether the edge functions of a line stay within 32 bits at all pixels of its box and up to some lanes
/// beside it, and the box is not much larger than what is covered.
///
/// With sides up to `s` sub-pixels a value is at most `2 s (s + 17 · 256)`, which is less than 2³¹.
#[inline(always)]
fn fits_lanes(line: &Line, pixels: PixelBox) -> bool {
    const LONGEST: i32 = 30_000;
    const MOST_PIXELS: i32 = 256;
    let [x, y] = [range(line.x), range(line.y)];
    let [columns, rows] = [
        pixels.last[0] - pixels.first[0] + 1,
        pixels.last[1] - pixels.first[1] + 1,
    ];
    x[1] - x[0] <= LONGEST && y[1] - y[0] <= LONGEST && columns * rows <= MOST_PIXELS
}

/// A line ready to be drawn: what is the same at all its pixels.
///
/// Of the two triangles p-r-q and p-s-r, corners in an order of positive area, the edges are, numbered by
/// the corner that they face: r to q, q to p and p to r; s to r, r to p and p to s.
struct Brush<'b, S: Simd, F> {
    kernel: &'b F,
    edges: [Edge; EDGES],
    /// What edges gain from the first lane to each.
    gains: [i32x16<S>; EDGES],
    /// One over `w`.
    inverse_w: Affine,
    depth: Affine,
    /// Varyings over `w`, all at once: at the first end, and their slopes by triangle and edge function.
    base: f32x8<S>,
    slopes: [[f32x8<S>; 2]; 2],
    flats: &'b [f32],
}

pub(super) const EDGES: usize = 5;
/// The edges from r to q, q to p, p to r, s to r and p to s; the one from r to p is the middle one backwards.
pub(super) const RQ: usize = 0;
pub(super) const QP: usize = 1;
pub(super) const PR: usize = 2;
pub(super) const SR: usize = 3;
pub(super) const PS: usize = 4;

/// An edge of a triangle and its function, positive within, in 32 bits.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Edge {
    from: [i32; 2],
    /// The way from there to where it ends.
    along: [i32; 2],
}

/// The edges of a line.
#[inline(always)]
pub(super) fn edges_of(line: &Line) -> [Edge; EDGES] {
    let [p, q, r, s] = [0, 1, 2, 3];
    [
        Edge::of(line, r, q),
        Edge::of(line, q, p),
        Edge::of(line, p, r),
        Edge::of(line, s, r),
        Edge::of(line, p, s),
    ]
}

impl Edge {
    #[inline(always)]
    fn of(line: &Line, from: usize, to: usize) -> Self {
        let (x, y) = (line.x[from], line.y[from]);
        Self {
            from: [x, y],
            along: [line.x[to] - x, line.y[to] - y],
        }
    }

    /// At the centre of a pixel.
    #[inline(always)]
    pub(super) fn at(self, x: i32, y: i32) -> i32 {
        let px = x * SUBPIXELS + SUBPIXELS / 2 - self.from[0];
        let py = y * SUBPIXELS + SUBPIXELS / 2 - self.from[1];
        self.along[0] * py - self.along[1] * px
    }

    /// Gained a pixel to the right.
    #[inline(always)]
    pub(super) fn right(self) -> i32 {
        -self.along[1] * SUBPIXELS
    }

    /// Gained a pixel downwards.
    #[inline(always)]
    pub(super) fn down(self) -> i32 {
        self.along[0] * SUBPIXELS
    }

    /// Nothing on top and left edges, −1 on others.
    #[inline(always)]
    pub(super) fn bias(self, sign: i32) -> i32 {
        let [dx, dy] = [self.along[0] * sign, self.along[1] * sign];
        if dy < 0 || (dy == 0 && dx > 0) { 0 } else { -1 }
    }
}

/// A quantity by the second and third edge function of both triangles.
#[derive(Debug, Clone, Copy)]
struct Affine {
    base: f32,
    /// By triangle and edge function.
    slopes: [[f32; 2]; 2],
}

impl Affine {
    /// From the values at the ends. Of the first triangle the first corner alone lies at the first end, of
    /// the second one the first two.
    #[inline(always)]
    fn new([from, to]: [f32; 2], inverse_area: [f32; 2]) -> Self {
        let [one, other] = inverse_area;
        let slope = |at: f32, area: f32| (at - from) * area;
        Self {
            base: from,
            slopes: [[slope(to, one); 2], [slope(from, other), slope(to, other)]],
        }
    }

    #[inline(always)]
    fn change(&self, triangle: usize, edges: [f32; 2]) -> f32 {
        let slopes = self.slopes[triangle];
        edges[0] * slopes[0] + edges[1] * slopes[1]
    }

    /// In the first triangle where `first` says so, else in the second.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, first: mask32x16<S>, edges: [f32x16<S>; 2]) -> f32x16<S> {
        let [one, other] = self.slopes;
        let number = |value: f32| f32x16::splat(simd, value);
        let slope = [
            first.select(number(one[0]), number(other[0])),
            first.select(number(one[1]), number(other[1])),
        ];
        number(self.base) + (edges[0] * slope[0] + edges[1] * slope[1])
    }
}

impl<'b, S: Simd, F: Fragment> Brush<'b, S, F> {
    #[inline(always)]
    fn new(simd: S, kernel: &'b F, chunk: &'b Chunk<'b>, line: &Line, place: usize) -> Self {
        let edges = edges_of(line);
        let column = i32x16::from_slice(simd, &COLUMN_OF);
        let row = i32x16::from_slice(simd, &ROW_OF);
        let mut gains = [column; EDGES];
        for (gain, edge) in gains.iter_mut().zip(edges) {
            *gain =
                column * i32x16::splat(simd, edge.right()) + row * i32x16::splat(simd, edge.down());
        }
        let twice = |one: [i32; 2], other: [i32; 2]| one[0] * other[1] - one[1] * other[0];
        let (to_r, from_q, to_s) = (edges[PR].along, edges[QP].along, edges[PS].along);
        let inverse_area = [
            1.0 / twice(from_q, to_r) as f32,
            1.0 / twice(to_s, to_r) as f32,
        ];
        let over_w = line.inverse_w;
        let [from, to] = chunk.lines.varyings(place, F::VARYINGS);
        // What lies behind them is no number to compute with, above all not a tiny one, which takes long.
        let there = mask32x8::from_bitmask(simd, (1 << F::VARYINGS) - 1);
        let nothing = u32x8::splat(simd, 0);
        let (from, to): (f32x8<S>, f32x8<S>) = (
            there
                .select(u32x8::from_slice(simd, from), nothing)
                .bitcast(),
            there.select(u32x8::from_slice(simd, to), nothing).bitcast(),
        );
        let from = from * f32x8::splat(simd, over_w[0]);
        let to = to * f32x8::splat(simd, over_w[1]);
        let areas = [
            f32x8::splat(simd, inverse_area[0]),
            f32x8::splat(simd, inverse_area[1]),
        ];
        let along = (to - from) * areas[0];
        // Nothing, but where an end is infinite or no number.
        let start = from;
        Self {
            kernel,
            edges,
            gains,
            inverse_w: Affine::new(over_w, inverse_area),
            depth: Affine::new(line.depth, inverse_area),
            base: from,
            slopes: [
                [along, along],
                [(start - from) * areas[1], (to - from) * areas[1]],
            ],
            flats: &chunk.geometry.flats[line.primitive as usize * F::FLATS..][..F::FLATS],
        }
    }

    #[inline(always)]
    fn draw(&self, simd: S, tile: &mut Tile<'_, '_>, pixels: PixelBox, counts: &mut Counts) {
        // Lanes stay within the block: those beside the pixels are left out by their column and row.
        let last_start = tile
            .origin
            .map(|first| first + BLOCK_SIDE.cast_signed() - SIDE);
        let mut top = pixels.first[1];
        while top <= pixels.last[1] {
            let y = top.min(last_start[1]);
            let rows = four(y, top, pixels.last[1]);
            // Each bit four times, side by side.
            let rows = (rows & 1 | (rows & 2) << 3 | (rows & 4) << 6 | (rows & 8) << 9) * 0xF;
            let mut left = pixels.first[0];
            while left <= pixels.last[0] {
                let x = left.min(last_start[0]);
                let columns = four(x, left, pixels.last[0]) * 0x1111;
                self.sixteen(simd, tile, [x, y], rows & columns, counts);
                left = x + SIDE;
            }
            top = y + SIDE;
        }
    }

    /// The pixels from here on that are wanted.
    #[inline(always)]
    fn sixteen(
        &self,
        simd: S,
        tile: &mut Tile<'_, '_>,
        [x, y]: [i32; 2],
        wanted: u64,
        counts: &mut Counts,
    ) {
        let zero = i32x16::splat(simd, 0);
        let mut at = [zero; EDGES];
        for ((at, gain), edge) in at.iter_mut().zip(self.gains).zip(self.edges) {
            *at = gain + i32x16::splat(simd, edge.at(x, y));
        }
        let edges = &self.edges;
        let biased = |edge: usize| at[edge] + i32x16::splat(simd, edges[edge].bias(1));
        let back = zero - at[PR];
        let inside_first = biased(RQ) | biased(QP) | biased(PR);
        let inside_second =
            biased(SR) | biased(PS) | (back + i32x16::splat(simd, edges[PR].bias(-1)));
        let first = inside_first.simd_ge(zero);
        let in_first = first.to_bitmask();
        let covered = (in_first | inside_second.simd_ge(zero).to_bitmask()) & wanted;
        if covered == 0 {
            return;
        }
        let second: f32x16<S> = first.select(at[QP], back).to_float();
        let third: f32x16<S> = first.select(at[PR], at[PS]).to_float();
        let places = [second, third];
        let depth = clamped(simd, self.depth.lanes(simd, first, places));
        let index = tile.index(x, y);
        let mut rows = [u32x4::splat(simd, 0); 4];
        for (row, first) in rows.iter_mut().zip((index..).step_by(BLOCK_SIDE as usize)) {
            *row = u32x4::from_slice(simd, &tile.depth[first..][..4]);
        }
        let [one, two, three, four] = rows;
        let there: u32x16<S> = one.combine(two).combine(three.combine(four));
        let bits: u32x16<S> = depth.bitcast();
        let nearer = bits.simd_lt(there).to_bitmask() & covered;
        counts.covered += u64::from(covered.count_ones());
        counts.visible += u64::from(nearer.count_ones());
        if nearer == 0 {
            return;
        }
        let w = f32x16::splat(simd, 1.0) / self.inverse_w.lanes(simd, first, places);
        let mut all = [[0.0_f32; TOGETHER]; 4];
        second.store_slice(&mut all[0]);
        third.store_slice(&mut all[1]);
        w.store_slice(&mut all[2]);
        depth.store_slice(&mut all[3]);
        let mut rest = nearer;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize % TOGETHER;
            rest &= rest - 1;
            let (column, row) = (lane % 4, lane / 4);
            let triangle = usize::from(in_first >> lane & 1 == 0);
            let position = [
                (x + COLUMN_OF[lane]).unsigned_abs(),
                (y + ROW_OF[lane]).unsigned_abs(),
            ];
            let [second, third, w, depth] =
                [all[0][lane], all[1][lane], all[2][lane], all[3][lane]];
            let colour = self.shade(simd, triangle, [second, third], w, position, depth);
            let there = &mut tile.colour[index + row * BLOCK_SIDE as usize + column];
            *there = over(simd, colour, *there);
        }
    }

    #[inline(always)]
    fn shade(
        &self,
        simd: S,
        triangle: usize,
        edges: [f32; 2],
        w: f32,
        position: [u32; 2],
        depth: f32,
    ) -> Vec4 {
        let [second, third] = &self.slopes[triangle];
        let change = f32x8::splat(simd, edges[0]) * *second + f32x8::splat(simd, edges[1]) * *third;
        let all = (self.base + change) * f32x8::splat(simd, w);
        let mut varyings = [0.0; MAX_VARYINGS];
        all.store_slice(&mut varyings);
        let steps = self.steps(triangle);
        self.kernel.shade(&Pixel {
            derivative_x: self.derivative(triangle, steps[0], &varyings, w),
            derivative_y: self.derivative(triangle, steps[1], &varyings, w),
            varyings: &varyings,
            flats: self.flats,
            front: true,
            position,
            depth,
        })
    }

    /// What the second and third edge functions of a triangle gain a pixel to the right and downwards.
    #[inline(always)]
    fn steps(&self, triangle: usize) -> [[f32; 2]; 2] {
        let edges = &self.edges;
        if triangle == 0 {
            [
                [edges[QP].right() as f32, edges[PR].right() as f32],
                [edges[QP].down() as f32, edges[PR].down() as f32],
            ]
        } else {
            [
                [-edges[PR].right() as f32, edges[PS].right() as f32],
                [-edges[PR].down() as f32, edges[PS].down() as f32],
            ]
        }
    }

    /// (U / q)' = (U' − (U / q) q') / q, with U and q affine.
    #[inline(always)]
    fn derivative(
        &self,
        triangle: usize,
        step: [f32; 2],
        varyings: &[f32; MAX_VARYINGS],
        w: f32,
    ) -> Vec2 {
        let change_of_inverse = self.inverse_w.change(triangle, step);
        let [second, third] = &self.slopes[triangle];
        let change = |k: usize| {
            let change = step[0] * second[k] + step[1] * third[k];
            (change - varyings[k] * change_of_inverse) * w
        };
        Vec2::new(
            if F::VARYINGS > 0 { change(0) } else { 0.0 },
            if F::VARYINGS > 1 { change(1) } else { 0.0 },
        )
    }
}

/// A bit for each of four columns or rows from `first` on that lies within some.
#[inline(always)]
fn four(first: i32, least: i32, last: i32) -> u64 {
    let before = (1_u64 << (least - first)) - 1;
    let until = (2_u64 << (last - first).min(SIDE - 1)) - 1;
    until & !before
}

/// As [`clamp_depth`](super::view::clamp_depth).
#[inline(always)]
fn clamped<S: Simd>(simd: S, depth: f32x16<S>) -> f32x16<S> {
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let depth = depth.simd_gt(zero).select(depth, zero);
    depth.simd_lt(one).select(depth, one)
}

/// As [`over`](super::shade::over), all channels at once.
#[inline(always)]
fn over<S: Simd>(simd: S, source: Vec4, there: Vec4) -> Vec4 {
    let alpha = source.w;
    let factor = f32x4::from_slice(simd, &[alpha, alpha, alpha, 1.0]);
    let source = f32x4::from_slice(simd, &source.to_array()) * factor;
    let there = f32x4::from_slice(simd, &there.to_array()) * f32x4::splat(simd, 1.0 - alpha);
    let mut sum = [0.0; 4];
    (source + there).store_slice(&mut sum);
    Vec4::from_array(sum)
}
