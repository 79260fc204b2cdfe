//! One tile: its pieces in the order of submission, opaque runs decided and then shaded, blended runs in
//! between.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::bin::Entry;
use super::candidates::Candidates;
use super::frame::{BLOCK_SIDE, NOTHING};
use super::items::{Item, Items, NOBODY, each_owner};
use super::layers::{Layer, blend_sorted};
use super::lines::Run;
use super::piece::Piece;
use super::reach::Cover;
use super::setup::{Chunk, Spare, Triangle, key, vertex_ids};
use super::view::{PixelBox, View, clamp_depth};
use super::works::Works;
use super::{Batch, Blend, Counters, Key, Samples, Skips, Work};
use crate::math::{Vec4, index_u32};

/// What all tiles of a call share.
#[derive(Debug)]
pub(super) struct Scene<'a> {
    pub(super) batches: &'a [Batch<'a>],
    /// The number of the run that each batch belongs to.
    pub(super) runs: Vec<u32>,
    pub(super) pieces: Vec<Piece<'a>>,
    pub(super) view: View,
    pub(super) samples: Samples,
    pub(super) counters: Counters,
}

/// Memory that a thread uses again for each block.
#[derive(Debug)]
pub(super) struct Scratch<'a> {
    /// A sample of the block: one more than the place among the winners of who owns it, or [`NOBODY`].
    pub(super) owner: Vec<u32>,
    /// The triangles of the run that won a sample, some of which have lost it again.
    winners: Vec<Winner>,
    /// The chunks that they are of.
    chunks: Vec<Arc<Chunk<'a>>>,
    /// Whether this call has drawn the sample in a run before.
    pub(super) drawn: Vec<bool>,
    pub(super) items: Items,
    /// Fragments of the run in work that are blended when it ends.
    pub(super) layers: Vec<Layer>,
    /// Put back by whoever takes it.
    pub(super) candidates: Option<Box<Candidates>>,
    visits: Vec<Visit>,
    spare: Spare,
    /// What the tile must look at.
    pub(super) entries: Vec<Entry>,
    /// The work of the block, by batch.
    works: Works,
    skips: Skips,
}

/// Memory that waits for the next block, of each thread: what another one has used lies far from it.
#[derive(Debug)]
pub(super) struct Scratches<'a>(Vec<Mutex<Option<Scratch<'a>>>>);

impl<'a> Scratches<'a> {
    /// For the threads of the pool in which this is called.
    pub(super) fn new() -> Self {
        let threads = rayon::current_num_threads().max(1);
        Self((0..threads).map(|_| Mutex::new(None)).collect())
    }

    /// What waits for this thread, or fresh memory.
    pub(super) fn take(&self, samples: Samples) -> Scratch<'a> {
        let waiting = self.place().lock();
        let waiting = waiting.unwrap_or_else(PoisonError::into_inner).take();
        waiting.unwrap_or_else(|| Scratch::new(samples))
    }

    /// Lets memory wait for this thread.
    pub(super) fn put(&self, scratch: Scratch<'a>) {
        let mut waiting = self.place().lock().unwrap_or_else(PoisonError::into_inner);
        *waiting = Some(scratch);
    }

    fn place(&self) -> &Mutex<Option<Scratch<'a>>> {
        let thread = rayon::current_thread_index().unwrap_or(0);
        &self.0[thread % self.0.len()]
    }
}

/// A triangle that has won a sample.
#[derive(Debug, Clone, Copy)]
struct Winner {
    /// Its chunk's place among those of the tile.
    chunk: u32,
    triangle: u32,
}

/// Entries of one piece that follow one another.
#[derive(Debug, Clone, Copy)]
struct Visit {
    /// The bits of a depth before which none of its samples lies.
    nearest: u32,
    piece: u32,
    /// The places of its entries.
    entries: [u32; 2],
}

impl Scratch<'_> {
    fn new(samples: Samples) -> Self {
        let count = (BLOCK_SIDE * BLOCK_SIDE) as usize * samples.count();
        Self {
            owner: vec![NOBODY; count],
            drawn: vec![false; count],
            winners: Vec::new(),
            chunks: Vec::new(),
            items: Items::default(),
            layers: Vec::new(),
            candidates: None,
            visits: Vec::new(),
            spare: Spare::default(),
            entries: Vec::new(),
            works: Works::default(),
            skips: Skips::default(),
        }
    }

    /// The work of the block by ascending batch; counting starts anew.
    pub(super) fn take_works(&mut self) -> (Vec<(u32, Work)>, Skips) {
        (self.works.take(), std::mem::take(&mut self.skips))
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
pub struct Tile<'t, 'a> {
    pub(super) scene: &'t Scene<'a>,
    pub(super) entries: &'t [Entry],
    pub(super) pixels: PixelBox,
    /// Column and row of the block's first pixel.
    pub(super) origin: [i32; 2],
    pub(super) depth: &'t mut [u32],
    pub(super) colour: &'t mut [Vec4],
    /// One more than the place of a key, or [`NOTHING`].
    pub(super) shown: &'t mut [u32],
    pub(super) keys: &'t mut Vec<Key>,
    pub(super) scratch: &'t mut Scratch<'a>,
}

/// Triangles of a chunk that a tile must look at.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug, Clone, Copy)]
pub struct Choice<'c> {
    /// None for all of them.
    entries: Option<&'c [Entry]>,
}

impl Choice<'_> {
    /// All triangles.
    pub(super) const ALL: Self = Self { entries: None };

    /// The runs of lines among some, told by their numbers.
    #[inline(always)]
    pub(super) fn run(self, place: usize, chunk: &Chunk<'_>) -> Option<Range<usize>> {
        match self.entries {
            None => (place == 0).then_some(0..chunk.lines.count()),
            Some(entries) => entries.get(place).map(|entry| Run::lines(entry.triangle)),
        }
    }

    /// How many triangles there are.
    #[inline(always)]
    pub(super) fn count(self, chunk: &Chunk<'_>) -> usize {
        self.entries.map_or(chunk.triangles.len(), <[Entry]>::len)
    }

    /// The number of one of them in the chunk.
    #[inline(always)]
    pub(super) fn triangle(self, place: usize) -> usize {
        match self.entries {
            None => place,
            Some(entries) => entries[place].triangle as usize,
        }
    }
}

impl<'t, 'a> Tile<'t, 'a> {
    /// Where the work of a batch is counted.
    #[inline]
    pub(super) fn work(&mut self, batch: u32) -> &mut Work {
        self.scratch.works.of(batch)
    }

    /// Draws all that lies on the tile.
    pub(super) fn draw(&mut self) {
        let (scene, entries) = (self.scene, self.entries);
        let batch = |entry: &Entry| scene.pieces[entry.piece as usize].batch;
        let run = |entry: &Entry| scene.runs[batch(entry) as usize];
        let mut first = 0;
        for entries in entries.chunk_by(|a, b| run(a) == run(b)) {
            let range = first..first + entries.len();
            first = range.end;
            match scene.batches[batch(&entries[0]) as usize].blend {
                Blend::Opaque => self.draw_opaque(range),
                _ if self.has_colour() => self.blend(range),
                Blend::Alpha | Blend::AlphaAndDepth | Blend::Sorted | Blend::Add => {}
            }
        }
    }

    /// Whether there is anything to shade for.
    pub(super) fn has_colour(&self) -> bool {
        !self.colour.is_empty()
    }

    /// The entries of each piece; those of a piece follow one another.
    fn list_visits(&mut self, range: Range<usize>) {
        let (scene, entries) = (self.scene, self.entries);
        let visits = &mut self.scratch.visits;
        visits.clear();
        let mut first = range.start;
        for together in entries[range].chunk_by(|a, b| a.piece == b.piece) {
            let number = together[0].piece;
            let piece = &scene.pieces[number as usize];
            let nearest = match &piece.sorted {
                None => piece.reach.nearest,
                Some(chunk) => together
                    .iter()
                    .map(|entry| chunk.triangles[entry.triangle as usize].nearest)
                    .fold(1.0, f32::min)
                    .max(0.0),
            };
            let kernel = scene.batches[piece.batch as usize].kernel;
            visits.push(Visit {
                nearest: clamp_depth(nearest - kernel.moves_nearer()).to_bits(),
                piece: number,
                entries: [first, first + together.len()].map(index_u32),
            });
            first += together.len();
        }
    }

    /// The triangles of a visit, and which of them matter.
    fn look_up(&mut self, visit: Visit) -> (Arc<Chunk<'a>>, Choice<'t>) {
        let piece = &self.scene.pieces[visit.piece as usize];
        let scene = self.scene;
        let cover = Cover {
            pixels: self.pixels,
            origin: self.origin,
            depth: self.depth,
            alone: piece.is_small(scene.batches),
        };
        let exact = scene.counters == Counters::Exact;
        let kernel = scene.batches[piece.batch as usize].kernel;
        let hides = !exact && scene.samples == Samples::One && kernel.moves_nearer() == 0.0;
        let cover = hides.then_some(&cover);
        let spare = &mut self.scratch.spare;
        let chunk = piece.chunk(&scene.view, scene.batches, cover, spare);
        let [first, end] = visit.entries.map(|place| place as usize);
        let entries = &self.entries[first..end];
        let entries = piece.sorted.is_some().then_some(entries);
        (chunk, Choice { entries })
    }

    /// Decides the opaque pieces of a run, the nearer first, then shades what they have won. No picture
    /// depends on the order.
    fn draw_opaque(&mut self, range: Range<usize>) {
        self.list_visits(range);
        let mut visits = std::mem::take(&mut self.scratch.visits);
        visits.sort_unstable_by_key(|visit| (visit.nearest, visit.piece));
        let exact = self.scene.counters == Counters::Exact;
        for visit in &visits {
            let piece = &self.scene.pieces[visit.piece as usize];
            let whole = piece.sorted.is_none();
            let on_tile = self.pixels.meet(piece.reach.pixels);
            let hidden =
                on_tile.is_none_or(|pixels| whole && !exact && self.hides(pixels, visit.nearest));
            self.scratch.skips.visits += 1;
            if hidden {
                self.scratch.skips.hidden += 1;
            } else {
                let (chunk, choice) = self.look_up(*visit);
                let kernel = self.scene.batches[piece.batch as usize].kernel;
                let winners = self.scratch.winners.len();
                kernel.cover(self, &chunk, choice);
                if self.scratch.winners.len() > winners {
                    self.scratch.chunks.push(chunk);
                } else {
                    self.scratch.spare.take(chunk);
                }
            }
            if whole {
                piece.done(&mut self.scratch.spare);
            }
        }
        self.scratch.visits = visits;
        self.shade_winners();
    }

    /// Shades what the winners own, batch by batch.
    fn shade_winners(&mut self) {
        self.list_items();
        let winners = std::mem::take(&mut self.scratch.winners);
        let chunks = std::mem::take(&mut self.scratch.chunks);
        let mut first = 0;
        for together in winners.chunk_by(|a, b| a.chunk == b.chunk) {
            let chunk = &chunks[together[0].chunk as usize];
            let kernel = self.scene.batches[chunk.batch as usize].kernel;
            let range = first..first + together.len();
            first = range.end;
            kernel.shade(self, chunk, &Winners(together), range);
        }
        self.scratch.winners = winners;
        self.scratch.winners.clear();
        self.scratch.chunks = chunks;
        let Scratch { chunks, spare, .. } = &mut *self.scratch;
        for chunk in chunks.drain(..) {
            spare.take(chunk);
        }
    }

    /// Waits for the lines of some entries all at once: they lie far apart.
    fn fetch(&self, entries: Range<usize>) {
        let mut read = 0;
        for entry in &self.entries[entries] {
            if let Some(chunk) = &self.scene.pieces[entry.piece as usize].sorted {
                read ^= chunk.lines.fetch(Run::lines(entry.triangle));
            }
        }
        std::hint::black_box(read);
    }

    /// Blends pieces in their order.
    fn blend(&mut self, range: Range<usize>) {
        /// How many entries are read ahead.
        const AHEAD: usize = 16;
        let scene = self.scene;
        let (mut first, mut read) = (range.start, range.start);
        while first < range.end {
            if first >= read {
                read = range.end.min(first + AHEAD);
                self.fetch(first..read);
            }
            let number = self.entries[first].piece;
            let of_piece = |entry: &Entry| entry.piece == number;
            let count = self.entries[first..range.end]
                .iter()
                .position(|entry| !of_piece(entry));
            let end = count.map_or(range.end, |count| first + count);
            let piece = &scene.pieces[number as usize];
            let kernel = scene.batches[piece.batch as usize].kernel;
            let entries = &self.entries[first..end];
            if let Some(chunk) = &piece.sorted {
                let choice = Choice {
                    entries: Some(entries),
                };
                kernel.blend(self, chunk, choice);
            } else {
                let spare = &mut self.scratch.spare;
                let chunk = piece.chunk(&scene.view, scene.batches, None, spare);
                kernel.blend(self, &chunk, Choice::ALL);
                drop(chunk);
                piece.done(&mut self.scratch.spare);
            }
            first = end;
        }
        blend_sorted(&mut self.scratch.layers, self.colour);
    }

    /// Enters a triangle of the chunk in work among the winners; answers what its samples are marked
    /// with.
    #[inline]
    pub(super) fn enter(&mut self, triangle: usize) -> u32 {
        self.scratch.winners.push(Winner {
            chunk: index_u32(self.scratch.chunks.len()),
            triangle: index_u32(triangle),
        });
        index_u32(self.scratch.winners.len())
    }

    fn list_items(&mut self) {
        match self.scene.samples {
            Samples::One => self.sort_items::<1>(),
            Samples::Four => self.sort_items::<4>(),
        }
    }

    /// Sorts pixels by the triangles that own their samples, by counting.
    fn sort_items<const SAMPLES: usize>(&mut self) {
        let pixels = self.pixels;
        let mut items = std::mem::take(&mut self.scratch.items);
        items.begin(self.scratch.winners.len());
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

    /// A pixel's place in its block.
    #[inline(always)]
    pub(super) fn index(&self, x: i32, y: i32) -> usize {
        let [column, row] = [x - self.origin[0], y - self.origin[1]].map(i32::unsigned_abs);
        (row * BLOCK_SIDE + column) as usize
    }

    /// Whether all that is there in some pixels is nearer than a depth, of which the bits are told.
    #[inline(always)]
    pub(super) fn hides(&self, pixels: PixelBox, nearest: u32) -> bool {
        let samples = self.scene.samples.count();
        for y in pixels.first[1]..=pixels.last[1] {
            let first = self.index(pixels.first[0], y) * samples;
            let end = (self.index(pixels.last[0], y) + 1) * samples;
            let mut farthest = 0;
            for &depth in &self.depth[first..end] {
                farthest = if depth > farthest { depth } else { farthest };
            }
            if farthest >= nearest {
                return false;
            }
        }
        true
    }

    /// The column and row of a pixel at a place in the block.
    #[inline(always)]
    pub(super) fn pixel_at(&self, index: usize) -> [i32; 2] {
        let side = BLOCK_SIDE as usize;
        let within = [index % side, index / side];
        [0, 1].map(|axis| self.origin[axis] + i32::try_from(within[axis]).unwrap_or(0))
    }

    /// Whether a triangle beats, by its key, what shows at a sample at the same depth.
    #[cold]
    #[inline(never)]
    pub(super) fn wins_tie(&self, chunk: &Chunk<'_>, triangle: usize, sample: usize) -> bool {
        let batches = self.scene.batches;
        let batch = |chunk: &Chunk<'_>| &batches[chunk.batch as usize];
        let ours = &chunk.triangles[triangle];
        let our_key = key(batch(chunk), ours);
        match self.scratch.owner[sample] {
            NOBODY => match self.shown[sample] {
                NOTHING => false,
                shown => our_key < self.keys[shown as usize - 1],
            },
            owner => {
                let winner = self.scratch.winners[owner as usize - 1];
                // The chunk in work joins the others once all its triangles are decided.
                let theirs = self.scratch.chunks.get(winner.chunk as usize);
                let their_chunk = theirs.map_or(chunk, |chunk| &**chunk);
                let their = &their_chunk.triangles[winner.triangle as usize];
                let order = our_key.cmp(&key(batch(their_chunk), their));
                let order = order.then_with(|| {
                    vertex_ids(batch(chunk), chunk, ours).cmp(vertex_ids(
                        batch(their_chunk),
                        their_chunk,
                        their,
                    ))
                });
                order
                    .then_with(|| {
                        let place = |chunk: &Chunk<'_>, triangle: &Triangle| {
                            let source = batch(chunk).geometry;
                            let primitive = triangle.primitive as usize;
                            let part = chunk.part as usize;
                            (chunk.batch, source.place(part, chunk.wanted, primitive))
                        };
                        place(chunk, ours).cmp(&place(their_chunk, their))
                    })
                    .is_lt()
            }
        }
    }
}

/// Triangles of one chunk that won samples.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug)]
pub struct Winners<'w>(&'w [Winner]);

impl Winners<'_> {
    /// The numbers of the triangles.
    pub(super) fn triangles(&self) -> impl Iterator<Item = usize> {
        self.0.iter().map(|winner| winner.triangle as usize)
    }
}
