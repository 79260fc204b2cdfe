//! `spinney build`: levels of detail of an own tree, for other programs.

use super::arguments::Shared;
use super::error::CliError;
use super::own_tree::{OwnTree, judge_levels};
use super::run::folder;
use super::terminal::Terminal;
use super::tree_arguments::BuildOptions;
use crate::raster::{Counters, Options, TileSize};
use crate::report::{ChainReport, OutputFolder, chain_json, chain_text, write_chain};
use crate::run::{ChainOptions, SessionOptions, WalkAway, lod_chain};
use crate::scene::CardOptions;

/// Pixels of the largest picture in which levels are looked for that nobody tells from full detail.
const LARGEST_PICTURE: u32 = 256;

pub(super) fn build(
    options: &BuildOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let tree = OwnTree::new(&options.file, &options.plant, shared, terminal, &progress)?;
    let target = folder(shared, &format!("{}-levels", tree.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let (crown, trunk) = (&tree.world.crowns[0], tree.world.trunks[0].as_deref());
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Visible,
    };
    let wanted = ChainOptions {
        levels: options.levels,
        looks: WalkAway {
            side: LARGEST_PICTURE,
            distances: 6,
            tolerance: options.tolerance,
            session: SessionOptions::of(&tree.scene, raster)?,
        },
        cards: CardOptions {
            texture: options.texture,
            ..tree.scene.cards
        },
    };
    let chain = lod_chain(crown, trunk, &wanted, &progress, &judge_levels)?;
    drop(progress);
    let files = chain.files(crown.plant())?;
    let report = ChainReport::new(crown.plant().name(), &chain, &files, &tree.world.remarks);
    write_chain(&output, &report, &files)?;
    output.commit()?;
    if shared.json {
        return terminal.print(&chain_json(&report));
    }
    let mut text = chain_text(&report, terminal.width());
    text.push_str(&format!(
        "\n{}: .glb files, collapses.bin, build.json\n",
        target.display()
    ));
    terminal.print(&text)
}
