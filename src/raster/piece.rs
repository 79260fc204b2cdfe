//! The parts of all batches: where each may show, and its triangles as soon as a tile asks for them.
//!
//! ```text
//!  parts ─reach─▶ pieces ─bin─▶ tiles ─the nearest first─▶ hidden? ─no─▶ set up ─▶ cover
//! ```
//!
//! A piece that is known to show on a few tiles alone is set up by the first of them to which it is not
//! hidden, and forgotten after the last. If its primitives are small and their boxes are known, each tile
//! sets up for itself what it sees of them: that is less than all. Others are set up at once and their triangles sorted into tiles,
//! as long as there is room for them.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use rayon::prelude::*;

use super::bin::Grid;
use super::lines::{self, Run, are_lines};
use super::reach::{Cover, Reach};
use super::setup::{Chunk, Spare, set_up};
use super::source::PART;
use super::view::View;
use super::{Batch, Blend};
use crate::math::index_u32;

/// A part of a batch; of lines, some parts.
#[derive(Debug)]
pub(super) struct Piece<'a> {
    pub(super) batch: u32,
    part: u32,
    pub(super) reach: Reach,
    /// Its triangles, sorted into tiles one by one.
    pub(super) sorted: Option<Arc<Chunk<'a>>>,
    /// Which of its lines may show on which tile, if they are sorted.
    pub(super) runs: Vec<Run>,
    /// Its triangles while tiles want them that it may show on.
    made: Mutex<Option<Arc<Chunk<'a>>>>,
    /// How many of these are still to come.
    pub(super) tiles: AtomicU32,
}

/// A piece that may show on more tiles is sorted triangle by triangle.
const FEW_TILES: usize = 16;

/// The pieces of all batches that may show, in the order of submission, and how many parts there are;
/// pieces are set up at once until they take so many bytes.
pub(super) fn pieces<'a>(
    view: &View,
    grid: Grid,
    batches: &[Batch<'a>],
    most_bytes: u64,
) -> (Vec<Piece<'a>>, u64) {
    let parts = batches.iter().zip(0_u32..).flat_map(|(batch, number)| {
        let parts = batch.geometry.parts(batch.topology);
        let together = if are_lines(view, batch) {
            lines::parts_together(batch)
        } else {
            1
        };
        (0..index_u32(parts))
            .step_by(together)
            .map(move |part| [number, part])
    });
    let parts: Vec<[u32; 2]> = parts.collect();
    let taken = AtomicU64::new(0);
    let found = parts.par_iter().with_min_len(64).map_init(
        Spare::default,
        |spare, &[number, part]| -> Option<Piece<'a>> {
            let batch = &batches[number as usize];
            let hull = batch.geometry.hull(part as usize);
            let piece = |reach, sorted, runs| Piece {
                batch: number,
                part,
                reach,
                sorted,
                runs,
                made: Mutex::new(None),
                tiles: AtomicU32::new(0),
            };
            if let Some(hull) = hull {
                let reach = view.reach(&hull, batch.topology)?;
                let few = batch.blend == Blend::Opaque && grid.tiles_of(reach.pixels) <= FEW_TILES;
                if few {
                    return Some(piece(reach, None, Vec::new()));
                }
            }
            let numbers = [number, part];
            let chunk = make(view, batch, numbers, None, spare);
            let (reach, runs) = match chunk.reach() {
                Some(reach) => (reach, Vec::new()),
                None => chunk.lines.sort(view, grid)?,
            };
            let bytes = chunk.bytes();
            let fits = taken.fetch_add(bytes, Ordering::Relaxed) + bytes <= most_bytes;
            if !fits {
                return Some(piece(reach, None, Vec::new()));
            }
            Some(piece(reach, Some(Arc::new(chunk)), runs))
        },
    );
    (found.flatten_iter().collect(), parts.len() as u64)
}

/// Sets up a part of a batch, of which both numbers are told, as lines or as triangles.
fn make<'a>(
    view: &View,
    batch: &Batch<'a>,
    numbers: [u32; 2],
    cover: Option<&Cover<'_>>,
    spare: &mut Spare,
) -> Chunk<'a> {
    if are_lines(view, batch) {
        lines::set_up(view, batch, numbers)
    } else {
        set_up(view, batch, numbers, cover, spare)
    }
}

/// In a part that may show on more pixels primitives are no small ones.
const MOST_PIXELS: usize = 4 * PART;

impl<'a> Piece<'a> {
    /// Whether its primitives are so small, and known so well, that each tile makes for itself what it sees
    /// of them.
    pub(super) fn is_small(&self, batches: &[Batch<'a>]) -> bool {
        let source = batches[self.batch as usize].geometry;
        self.reach.pixels.count() <= MOST_PIXELS && source.boxes(self.part as usize).is_some()
    }

    /// Its triangles, made where nobody has asked for them before: then without those that `cover` hides.
    pub(super) fn chunk(
        &self,
        view: &View,
        batches: &[Batch<'a>],
        cover: Option<&Cover<'_>>,
        spare: &mut Spare,
    ) -> Arc<Chunk<'a>> {
        if let Some(chunk) = &self.sorted {
            return Arc::clone(chunk);
        }
        if cover.is_some_and(|cover| cover.alone) {
            let batch = &batches[self.batch as usize];
            return Arc::new(make(view, batch, [self.batch, self.part], cover, spare));
        }
        let make = |cover: Option<&Cover<'_>>, spare: &mut Spare| {
            let batch = &batches[self.batch as usize];
            Arc::new(make(view, batch, [self.batch, self.part], cover, spare))
        };
        // Nothing panics while it is held but what ends the pass.
        let mut made = match self.made.try_lock() {
            Ok(made) => made,
            Err(TryLockError::Poisoned(made)) => made.into_inner(),
            Err(TryLockError::WouldBlock) => {
                // Another tile makes it now: to wait takes longer than to make what shows here.
                let alone = cover.map(|cover| Cover {
                    alone: true,
                    ..*cover
                });
                return make(alone.as_ref(), spare);
            }
        };
        Arc::clone(made.get_or_insert_with(|| make(cover, spare)))
    }

    /// A tile has done with it; the last one forgets its triangles.
    pub(super) fn done(&self, spare: &mut Spare) {
        if self.tiles.fetch_sub(1, Ordering::Relaxed) == 1 {
            let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(chunk) = made.take() {
                spare.take(chunk);
            }
        }
    }
}
