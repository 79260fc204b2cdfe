//! A call of the rasterizer: set up, bin, and draw the tiles in parallel.

use rayon::prelude::*;

use super::bin::{Bins, Grid};
use super::frame::{BLOCK_SIDE, Block, Ready, Target};
use super::region::Region;
use super::setup::{primitive_count, set_up};
use super::tile::{Scene, Scratch, Tile};
use super::view::{PixelBox, View};
use super::{Batch, Counters, MAX_FLATS, MAX_VARYINGS, TileSize, Work};

/// How to rasterize; nothing here changes a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// How much of the target is decided at a time.
    pub tile: TileSize,
    /// Which counters are wanted.
    pub counters: Counters,
}

/// Draws batches into a target, in the order of submission as far as order matters, and returns the
/// work of each.
///
/// What was drawn before stays and is tested against, by depth and key. Runs in rayon's current
/// pool. Primitives with a corner that names no vertex are dropped, as are left-over corners.
///
/// # Panics
///
/// When a geometry's lists contradict each other or its kernel, or there are more than 2²⁸
/// primitives: lengths are checked where they enter.
pub fn render(target: &mut Target, batches: &[Batch<'_>], options: &Options) -> Vec<Work> {
    let whole = Region::whole([target.width(), target.height()]);
    render_region(target, batches, options, whole)
}

/// As [`render`], of some blocks of the target; the others stay as they are.
///
/// Regions that share no block and are all of the target, drawn one after another with the same
/// batches, leave what one call leaves, and their work adds up to its work. Opaque batches that cover
/// nothing of a region may be left out there.
///
/// # Panics
///
/// As [`render`].
pub fn render_region(
    target: &mut Target,
    batches: &[Batch<'_>],
    options: &Options,
    region: Region,
) -> Vec<Work> {
    let mut sums = vec![Work::default(); batches.len()];
    for batch in batches {
        check(batch);
    }
    let (width, height, samples) = (target.width(), target.height(), target.samples());
    if width == 0 || height == 0 {
        return sums;
    }
    let view = View::new(width, height, samples).within(region.pixels());
    let scene = Scene {
        batches,
        runs: runs(batches),
        chunks: set_up(&view, batches),
        view,
        samples,
        counters: options.counters,
    };
    let shift = options.tile.side().trailing_zeros();
    let tiles = |side: u32| side.div_ceil(options.tile.side()) as usize;
    let grid = Grid {
        columns: tiles(width),
        rows: tiles(height),
        shift,
    };
    let bins = Bins::new(grid, &scene.chunks);
    let (ready, columns, blocks) = target.parts();
    let works: Vec<Vec<(u32, Work)>> = blocks
        .par_iter_mut()
        .with_max_len(1)
        .enumerate()
        .filter(|(number, _)| region.contains([number % columns, number / columns]))
        .map_init(
            || Scratch::new(samples),
            |scratch, (number, block)| {
                let place = [number % columns, number / columns];
                draw_block(&scene, &bins, grid, ready, place, block, scratch)
            },
        )
        .collect();
    for (batch, work) in works.iter().flatten() {
        sums[*batch as usize] = sums[*batch as usize].plus(work);
    }
    sums
}

fn draw_block(
    scene: &Scene<'_>,
    bins: &Bins,
    grid: Grid,
    ready: Ready,
    place: [usize; 2],
    block: &mut Block,
    scratch: &mut Scratch,
) -> Vec<(u32, Work)> {
    let side = 1 << grid.shift;
    let tiles = (BLOCK_SIDE >> grid.shift) as usize;
    scratch.reset();
    let mut ids = std::mem::take(&mut scratch.ids);
    for row in place[1] * tiles..(place[1] + 1) * tiles {
        for column in place[0] * tiles..(place[0] + 1) * tiles {
            bins.of_tile(column, row, &mut ids);
            if ids.is_empty() {
                continue;
            }
            ready.make(block);
            let corner = |at: usize, side: i32| i32::try_from(at).unwrap_or(0) * side;
            let first = [corner(column, side), corner(row, side)];
            let mut tile = Tile {
                scene,
                ids: &ids,
                pixels: PixelBox {
                    first,
                    last: first.map(|first| first + side - 1),
                },
                origin: place.map(|at| corner(at, BLOCK_SIDE.cast_signed())),
                depth: &mut block.depth,
                colour: &mut block.colour,
                shown: &mut block.shown,
                scratch: &mut *scratch,
            };
            tile.draw();
        }
    }
    scratch.ids = ids;
    scratch.take_works()
}

/// Numbers the runs of batches that blend alike; empty batches belong to the run before them.
fn runs(batches: &[Batch<'_>]) -> Vec<u32> {
    let mut run = 0;
    let mut blend = None;
    let number = |batch: &Batch<'_>| {
        if primitive_count(batch) > 0 && blend != Some(batch.blend) {
            run += 1;
            blend = Some(batch.blend);
        }
        run
    };
    batches.iter().map(number).collect()
}

fn check(batch: &Batch<'_>) {
    let geometry = batch.geometry;
    let (varyings, flats) = (batch.kernel.varyings(), batch.kernel.flats());
    assert!(
        varyings <= MAX_VARYINGS && flats <= MAX_FLATS,
        "a kernel has {varyings} varyings and {flats} flats, the most is {MAX_VARYINGS} and {MAX_FLATS}"
    );
    let vertices = geometry.clip.len();
    assert!(
        geometry.vertex_ids.len() == vertices && geometry.varyings.len() == vertices * varyings,
        "{vertices} vertices have {} ids and {} floats, their kernel wants {varyings} each",
        geometry.vertex_ids.len(),
        geometry.varyings.len(),
    );
    let primitives = primitive_count(batch);
    assert!(
        geometry.flats.len() >= primitives * flats,
        "{primitives} primitives have {} flats, their kernel wants {flats} each",
        geometry.flats.len(),
    );
}

impl Work {
    /// The work of all.
    #[must_use]
    pub fn total(works: &[Self]) -> Self {
        works.iter().fold(Self::default(), Self::plus)
    }

    /// The work of both.
    #[must_use]
    pub fn plus(self, other: &Self) -> Self {
        Self {
            visible: self.visible + other.visible,
            covered: self.covered + other.covered,
            alpha_killed: self.alpha_killed + other.alpha_killed,
            texels: self.texels + other.texels,
        }
    }
}
