//! `spinney compare`: which scheme for a tree of one's own, and what it costs.

use super::arguments::Shared;
use super::error::CliError;
use super::own_tree::{OwnTree, judge_levels};
use super::run::folder;
use super::terminal::Terminal;
use super::tree_arguments::CompareArguments;
use crate::gpu::Card;
use crate::models::{Kind, TrunkKind};
use crate::raster::{Counters, Options, TileSize};
use crate::report::{CompareReport, OutputFolder, compare_json, compare_text, write_compare};
use crate::run::{
    CompareOptions, Compared, Scheme, SessionOptions, Variant, WalkAway, compare as walk,
};
use crate::scene::CardOptions;

pub(super) fn compare(
    options: &CompareArguments,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let mut tree = OwnTree::new(&options.file, &options.plant, shared, terminal, &progress)?;
    let target = folder(shared, &format!("{}-compare", tree.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Exact,
    };
    tree.scene.cards.texture = options.texture;
    // As many as it takes, rather than not at all; what they take is told.
    tree.scene.cards.layers = CardOptions::MOST_LAYERS;
    let session = SessionOptions::of(&tree.scene, raster)?;
    let wanted = CompareOptions {
        leaves: leaf_schemes(session.card),
        wood: TrunkKind::all().collect(),
        looks: WalkAway {
            side: options.side,
            distances: options.distances,
            tolerance: options.tolerance,
            session,
        },
    };
    let crown = &tree.world.crowns[0];
    let mut report = CompareReport {
        plant: crown.plant().name().to_owned(),
        leaves: crown.plant().foliage().leaf_count() as u64,
        link: session.link,
        card: session.card,
        tolerance: options.tolerance,
        remarks: tree.world.remarks.clone(),
        triangles: crown
            .plant()
            .trunk()
            .map_or(0, |trunk| trunk.triangle_count().into()),
        leaf_schemes: Vec::new(),
        wood_schemes: Vec::new(),
        left_out: Vec::new(),
    };
    let Compared { found, left_out } = walk(&tree.world, &wanted, &progress, &judge_levels)?;
    report.left_out = left_out;
    for found in found {
        let schemes = match found.scheme {
            Scheme::Leaves(_) => &mut report.leaf_schemes,
            Scheme::Wood(_) => &mut report.wood_schemes,
        };
        schemes.push(found);
    }
    drop(progress);
    write_compare(&output, &report)?;
    output.commit()?;
    if shared.json {
        return terminal.print(&compare_json(&report));
    }
    let mut text = compare_text(&report, terminal.width());
    text.push_str(&format!(
        "\n{}: report.html, tables, plots, sheets\n",
        target.display()
    ));
    terminal.print(&text)
}

/// All that a card can do at a level that is asked for.
fn leaf_schemes(card: Card) -> Vec<Variant> {
    let pruned = Variant::usual(Kind::LodfStamps).pruned();
    let cards = [
        Kind::Impostors,
        Kind::IndirectImpostors,
        Kind::FacingBillboard,
        Kind::Sprites,
        Kind::CrossedCards,
        Kind::Octahedral,
    ];
    let all = Variant::ALL.into_iter().chain([pruned]);
    let all = all.chain(cards.map(Variant::usual));
    // Those that choose their own detail by the camera are not asked to be as coarse as others.
    all.filter(|variant| variant.runs_on(card) && !variant.kind.selects())
        .collect()
}
