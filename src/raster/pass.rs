//! A call of the rasterizer: find out where pieces may show, and draw the tiles in parallel.

use rayon::prelude::*;

use super::bin::{Bins, Grid};
use super::frame::{BLOCK_SIDE, Block, Ready, Target};
use super::lanes::Instructions;
use super::piece::pieces;
use super::tile::{Scene, Scratch, Scratches, Tile};
use super::view::{PixelBox, View};
use super::{Batch, Counters, TileSize, Work};

/// How to rasterize; nothing here changes a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Options {
    /// How much of the target is decided at a time.
    pub tile: TileSize,
    /// Which counters are wanted.
    pub counters: Counters,
}

/// What the machine that rasterizes has; nothing here changes a picture or a counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Machine {
    /// About how many bytes triangles may take that are set up at once; others are set up where they
    /// are needed, some more than once.
    pub geometry_bytes: u64,
    /// Which instructions it may use.
    pub instructions: Instructions,
}

impl Machine {
    /// This machine with 1 GiB for triangles, more than most calls need.
    pub const THIS: Self = Self {
        geometry_bytes: 1 << 30,
        instructions: Instructions::Best,
    };
}

/// Draws batches into a target, in the order of submission as far as order matters, and returns the
/// work of each.
///
/// What was drawn before stays and is tested against, by depth and key. Runs in rayon's current
/// pool. Primitives with a corner that names no vertex are dropped, as are left-over corners.
///
/// # Panics
///
/// When a geometry's lists contradict each other or its kernel: lengths are checked where they enter.
pub fn render(target: &mut Target, batches: &[Batch<'_>], options: &Options) -> Vec<Work> {
    render_on(Machine::THIS, target, batches, options).works
}

/// As [`render`], on a machine of which something is told.
///
/// # Panics
///
/// As [`render`].
pub fn render_on(
    machine: Machine,
    target: &mut Target,
    batches: &[Batch<'_>],
    options: &Options,
) -> Rendered {
    let mut sums = vec![Work::default(); batches.len()];
    let (width, height, samples) = (target.width(), target.height(), target.samples());
    if width == 0 || height == 0 {
        return Rendered {
            works: sums,
            skips: Skips::default(),
        };
    }
    let shift = options.tile.side().trailing_zeros();
    let tiles = |side: u32| side.div_ceil(options.tile.side()) as usize;
    let grid = Grid {
        columns: tiles(width),
        rows: tiles(height),
        shift,
    };
    let view = View::new(width, height, samples).with(machine.instructions.level());
    let (pieces, parts) = pieces(&view, grid, batches, machine.geometry_bytes);
    let scene = Scene {
        batches,
        runs: runs(batches),
        pieces,
        view,
        samples,
        counters: options.counters,
    };
    let bins = Bins::new(grid, &scene.pieces);
    let (ready, columns, blocks) = target.parts();
    let scratches = Scratches::new();
    let works: Vec<(Vec<(u32, Work)>, Skips)> = blocks
        .par_iter_mut()
        .with_max_len(1)
        .enumerate()
        .map(|(number, block)| {
            let place = [number % columns, number / columns];
            let mut scratch = scratches.take(samples);
            let done = draw_block(&scene, &bins, grid, ready, place, block, &mut scratch);
            scratches.put(scratch);
            done
        })
        .collect();
    let mut skips = Skips {
        parts,
        outside: parts - scene.pieces.len() as u64,
        ..Skips::default()
    };
    for (works, of_block) in &works {
        for (batch, work) in works {
            sums[*batch as usize] = sums[*batch as usize].plus(work);
        }
        skips.visits += of_block.visits;
        skips.hidden += of_block.hidden;
    }
    Rendered { works: sums, skips }
}

/// What came of a call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rendered {
    /// The work of each batch.
    pub works: Vec<Work>,
    /// What was left out.
    pub skips: Skips,
}

/// What was left out, and why: a diagnostic of this version, no promise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Skips {
    /// Parts of all batches.
    pub parts: u64,
    /// Parts that show nowhere: beside the target, or between its samples.
    pub outside: u64,
    /// How often a tile looked at a part that may show on it.
    pub visits: u64,
    /// How often all that was there on the tile hid the part.
    pub hidden: u64,
}

fn draw_block<'a>(
    scene: &Scene<'a>,
    bins: &Bins,
    grid: Grid,
    ready: Ready,
    place: [usize; 2],
    block: &mut Block,
    scratch: &mut Scratch<'a>,
) -> (Vec<(u32, Work)>, Skips) {
    let side = 1 << grid.shift;
    let tiles = (BLOCK_SIDE >> grid.shift) as usize;
    scratch.reset();
    let mut entries = std::mem::take(&mut scratch.entries);
    for row in place[1] * tiles..(place[1] + 1) * tiles {
        for column in place[0] * tiles..(place[0] + 1) * tiles {
            bins.of_tile(column, row, &mut entries);
            if entries.is_empty() {
                continue;
            }
            ready.make(block);
            let corner = |at: usize, side: i32| i32::try_from(at).unwrap_or(0) * side;
            let first = [corner(column, side), corner(row, side)];
            let mut tile = Tile {
                scene,
                entries: &entries,
                pixels: PixelBox {
                    first,
                    last: first.map(|first| first + side - 1),
                },
                origin: place.map(|at| corner(at, BLOCK_SIDE.cast_signed())),
                depth: &mut block.depth,
                colour: &mut block.colour,
                shown: &mut block.shown,
                keys: &mut block.keys,
                scratch: &mut *scratch,
            };
            tile.draw();
        }
    }
    scratch.entries = entries;
    block.tidy();
    scratch.take_works()
}

/// Numbers the runs of batches that blend alike; empty batches belong to the run before them.
fn runs(batches: &[Batch<'_>]) -> Vec<u32> {
    let mut run = 0;
    let mut blend = None;
    let number = |batch: &Batch<'_>| {
        if batch.geometry.parts(batch.topology) > 0 && blend != Some(batch.blend) {
            run += 1;
            blend = Some(batch.blend);
        }
        run
    };
    batches.iter().map(number).collect()
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
