//! One tile: its triangles in the order of submission, opaque runs decided and then shaded, blended
//! runs in between.

use std::ops::Range;

use super::bin::TriangleId;
use super::cover::Candidates;
use super::frame::{BLOCK_SIDE, NOTHING};
use super::hidden::{Furthest, PATCHES_A_ROW, SIDE, patch_number};
use super::items::{Item, Items, NOBODY, each_owner};
use super::order::Order;
use super::probe::Point;
use super::setup::{Chunk, Triangle};
use super::view::{PixelBox, View};
use super::{Batch, Blend, Counters, Key, Samples, Work};
use crate::math::Vec4;

/// What all tiles of a call share.
#[derive(Debug)]
pub(super) struct Scene<'a> {
    pub(super) batches: &'a [Batch<'a>],
    /// The number of the run that each batch belongs to.
    pub(super) runs: Vec<u32>,
    pub(super) chunks: Vec<Chunk>,
    pub(super) view: View,
    pub(super) samples: Samples,
    pub(super) counters: Counters,
}

/// Memory that a thread uses again for each block.
#[derive(Debug)]
pub(super) struct Scratch {
    /// A sample of the block: one more than the entry that owns it, or [`NOBODY`].
    pub(super) owner: Vec<u32>,
    /// Whether this call has drawn the sample in a run before.
    pub(super) drawn: Vec<bool>,
    pub(super) items: Items,
    /// How far each patch of the block is seen, while an opaque run is decided.
    pub(super) furthest: Furthest,
    /// Put back by whoever takes it.
    pub(super) candidates: Option<Box<Candidates>>,
    order: Order,
    /// Batches of the opaque run with their entries.
    groups: Vec<(u32, Range<usize>)>,
    /// The triangles of a tile.
    pub(super) ids: Vec<TriangleId>,
    /// The work of the block, by batch.
    works: Works,
}

/// Work by batch; most blocks see few batches.
#[derive(Debug, Default)]
struct Works {
    of_batch: Vec<Work>,
    touched: Vec<u32>,
}

impl Works {
    fn of(&mut self, batch: u32) -> &mut Work {
        let index = batch as usize;
        if self.of_batch.len() <= index {
            self.of_batch.resize(index + 1, Work::default());
        }
        if self.of_batch[index] == Work::default() {
            self.touched.push(batch);
        }
        &mut self.of_batch[index]
    }

    /// What was counted, by ascending batch; counting starts anew.
    fn take(&mut self) -> Vec<(u32, Work)> {
        self.touched.sort_unstable();
        self.touched.dedup();
        let of_batch = &mut self.of_batch;
        let take = |batch: u32| (batch, std::mem::take(&mut of_batch[batch as usize]));
        self.touched.drain(..).map(take).collect()
    }
}

impl Scratch {
    pub(super) fn new(samples: Samples) -> Self {
        let count = (BLOCK_SIDE * BLOCK_SIDE) as usize * samples.count();
        Self {
            owner: vec![NOBODY; count],
            drawn: vec![false; count],
            items: Items::default(),
            furthest: Furthest::new(),
            candidates: None,
            order: Order::default(),
            groups: Vec::new(),
            ids: Vec::new(),
            works: Works::default(),
        }
    }

    /// The work of the block by ascending batch; counting starts anew.
    pub(super) fn take_works(&mut self) -> Vec<(u32, Work)> {
        self.works.take()
    }

    /// Forgets the block before.
    pub(super) fn reset(&mut self) {
        // Owners are nobody again: shading each run has seen to that.
        self.drawn.fill(false);
    }
}

/// A tile in work.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug)]
pub struct Tile<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) ids: &'a [TriangleId],
    pub(super) pixels: PixelBox,
    /// Column and row of the block's first pixel.
    pub(super) origin: [i32; 2],
    pub(super) depth: &'a mut [u32],
    pub(super) colour: &'a mut [Vec4],
    pub(super) shown: &'a mut [Key],
    pub(super) scratch: &'a mut Scratch,
}

impl<'a> Tile<'a> {
    /// Where the work of a batch is counted.
    #[inline]
    pub(super) fn work(&mut self, batch: u32) -> &mut Work {
        self.scratch.works.of(batch)
    }

    /// Draws all triangles of the tile.
    pub(super) fn draw(&mut self) {
        let mut entry = 0;
        let mut run = None;
        while entry < self.ids.len() {
            let number = self.triangle(entry).0.batch;
            let same = self.ids[entry..]
                .iter()
                .take_while(|id| id.of(&self.scene.chunks).batch == number)
                .count();
            let entries = entry..entry + same;
            entry = entries.end;
            let batch = &self.scene.batches[number as usize];
            let its_run = self.scene.runs[number as usize];
            if run != Some(its_run) {
                self.finish_run();
                run = Some(its_run);
            }
            match batch.blend {
                Blend::Opaque => self.scratch.groups.push((number, entries)),
                Blend::Alpha => batch.kernel.blend(self, entries),
            }
        }
        self.finish_run();
    }

    /// Decides the triangles of the opaque run, then shades what they have won.
    fn finish_run(&mut self) {
        let groups = std::mem::take(&mut self.scratch.groups);
        if let (Some((_, first)), Some((_, last))) = (groups.first(), groups.last()) {
            self.cover_run(first.start..last.end);
            self.list_items(first.start..last.end);
            for (batch, entries) in &groups {
                let kernel = self.scene.batches[*batch as usize].kernel;
                kernel.shade(self, entries.clone());
            }
        }
        self.scratch.groups = groups;
        self.scratch.groups.clear();
    }

    /// Decides opaque triangles, the nearer first: what is hidden is then found so before its alpha
    /// is tested. No picture depends on the order.
    fn cover_run(&mut self, entries: Range<usize>) {
        self.look_how_far();
        let mut order = std::mem::take(&mut self.scratch.order);
        order.sort(entries, |entry| self.triangle(entry).0.depth);
        let (scene, ids) = (self.scene, self.ids);
        let batch = |entry: u32| ids[entry as usize].of(&scene.chunks).batch;
        let same_batch = |a: &u32, b: &u32| batch(*a) == batch(*b);
        for entries in order.entries.chunk_by(same_batch) {
            let kernel = scene.batches[batch(entries[0]) as usize].kernel;
            kernel.cover(self, entries);
        }
        self.scratch.order = order;
    }

    fn look_how_far(&mut self) {
        let [from, to] = [self.pixels.first, self.pixels.last];
        let mut patches = 0_u64;
        for y in (from[1]..=to[1]).step_by(SIDE) {
            for x in (from[0]..=to[0]).step_by(SIDE) {
                patches |= 1 << patch_number(self.index(x, y));
            }
        }
        let furthest = &mut self.scratch.furthest;
        match self.scene.samples {
            Samples::One => furthest.renew::<1>(patches, self.depth),
            Samples::Four => furthest.renew::<4>(patches, self.depth),
        }
    }

    fn list_items(&mut self, entries: Range<usize>) {
        match self.scene.samples {
            Samples::One => self.sort_items::<1>(entries),
            Samples::Four => self.sort_items::<4>(entries),
        }
    }

    /// Sorts pixels by the triangles that own their samples, by counting.
    fn sort_items<const SAMPLES: usize>(&mut self, entries: Range<usize>) {
        let pixels = self.pixels;
        let mut items = std::mem::take(&mut self.scratch.items);
        items.begin(entries);
        for y in pixels.first[1]..=pixels.last[1] {
            let row = self.index(pixels.first[0], y)..self.index(pixels.last[0], y) + 1;
            for owners in self.owners::<SAMPLES>(row) {
                each_owner(owners, |owner, _| items.count(owner));
            }
        }
        items.lay_out();
        for y in pixels.first[1]..=pixels.last[1] {
            let row = self.index(pixels.first[0], y)..self.index(pixels.last[0], y) + 1;
            for (owners, index) in self.owners::<SAMPLES>(row.clone()).zip(row) {
                each_owner(owners, |owner, mask| {
                    items.put(owner, Item::new(index, mask));
                });
            }
        }
        self.scratch.items = items;
    }

    fn owners<const SAMPLES: usize>(
        &self,
        pixels: Range<usize>,
    ) -> impl Iterator<Item = &[u32; SAMPLES]> {
        let range = pixels.start * SAMPLES..pixels.end * SAMPLES;
        self.scratch.owner[range].as_chunks::<SAMPLES>().0.iter()
    }

    /// The triangle of an entry with its chunk and batch.
    #[inline]
    pub(super) fn triangle(&self, entry: usize) -> (&'a Triangle, &'a Chunk, &'a Batch<'a>) {
        let scene = self.scene;
        let id = self.ids[entry];
        let triangle = id.of(&scene.chunks);
        let batch = &scene.batches[triangle.batch as usize];
        (triangle, &scene.chunks[id.chunk()], batch)
    }

    /// The pixels of the tile that a triangle may cover.
    #[inline]
    pub(super) fn pixels_of(&self, triangle: &Triangle) -> Option<PixelBox> {
        let [ours, theirs] = [self.pixels, self.scene.view.pixels_of(triangle)?];
        let both = PixelBox {
            first: [
                ours.first[0].max(theirs.first[0]),
                ours.first[1].max(theirs.first[1]),
            ],
            last: [
                ours.last[0].min(theirs.last[0]),
                ours.last[1].min(theirs.last[1]),
            ],
        };
        let some = both.first[0] <= both.last[0] && both.first[1] <= both.last[1];
        some.then_some(both)
    }

    /// A pixel's place in its block.
    #[inline]
    pub(super) fn index(&self, x: i32, y: i32) -> usize {
        let [column, row] = [x - self.origin[0], y - self.origin[1]].map(i32::unsigned_abs);
        (row * BLOCK_SIDE + column) as usize
    }

    /// Whether all that is there in some pixels, and in what is left of their patches, is nearer.
    #[inline]
    pub(super) fn hides(&self, pixels: PixelBox, nearest: f32) -> bool {
        // Below 0 the bits would not order as depths do.
        let nearest = nearest.max(0.0).to_bits();
        let [first, last] =
            [pixels.first, pixels.last].map(|[x, y]| patch_number(self.index(x, y)));
        let columns = last % PATCHES_A_ROW - first % PATCHES_A_ROW;
        let mut row = first;
        while row <= last {
            for patch in row..=row + columns {
                if nearest <= self.scratch.furthest.of(patch) {
                    return false;
                }
            }
            row += PATCHES_A_ROW;
        }
        true
    }

    /// The column and row of a pixel at a place in the block.
    #[inline]
    pub(super) fn pixel_at(&self, index: usize) -> [i32; 2] {
        let side = BLOCK_SIDE as usize;
        let within = [index % side, index / side];
        [0, 1].map(|axis| self.origin[axis] + i32::try_from(within[axis]).unwrap_or(0))
    }

    /// Whether an entry beats, by its key, what shows at a sample at the same depth.
    #[cold]
    pub(super) fn wins_tie(&self, entry: usize, index: usize) -> bool {
        let key = |entry: usize| {
            let (triangle, _, batch) = self.triangle(entry);
            super::setup::key(batch, triangle)
        };
        match self.scratch.owner[index] {
            NOBODY => self.shown[index] != NOTHING && key(entry) < self.shown[index],
            owner => {
                let owner = owner as usize - 1;
                let ids = |entry: usize| {
                    let (triangle, _, batch) = self.triangle(entry);
                    super::setup::vertex_ids(batch, triangle)
                };
                let order = key(entry).cmp(&key(owner));
                let order = order.then_with(|| ids(entry).cmp(ids(owner)));
                // Entries are in the order of submission, whatever order they are decided in.
                order.then(entry.cmp(&owner)).is_lt()
            }
        }
    }
}

/// The three loops over a tile, compiled once a fragment stage; and a look at one pixel.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can call it")]
pub trait Passes {
    /// Opaque triangles against depth and key.
    fn cover(&self, tile: &mut Tile<'_>, entries: &[u32]);
    /// Colour of what won.
    fn shade(&self, tile: &mut Tile<'_>, entries: Range<usize>);
    /// Blended triangles in order.
    fn blend(&self, tile: &mut Tile<'_>, entries: Range<usize>);
    /// Whether a fragment passes the alpha test, and its colour.
    fn probe(&self, point: &Point<'_>) -> (bool, Vec4);
}

impl<F: super::Fragment> Passes for F {
    fn cover(&self, tile: &mut Tile<'_>, entries: &[u32]) {
        match tile.scene.samples {
            Samples::One => super::cover::cover::<F, 1>(self, tile, entries),
            Samples::Four => super::cover::cover::<F, 4>(self, tile, entries),
        }
    }

    fn shade(&self, tile: &mut Tile<'_>, entries: Range<usize>) {
        match tile.scene.samples {
            Samples::One => super::shade::shade::<F, 1>(self, tile, entries),
            Samples::Four => super::shade::shade::<F, 4>(self, tile, entries),
        }
    }

    fn blend(&self, tile: &mut Tile<'_>, entries: Range<usize>) {
        match tile.scene.samples {
            Samples::One => super::shade::blend::<F, 1>(self, tile, entries),
            Samples::Four => super::shade::blend::<F, 4>(self, tile, entries),
        }
    }

    fn probe(&self, point: &Point<'_>) -> (bool, Vec4) {
        point.look(self)
    }
}
