//! `spinney sweep --bytes`: what every model of each plant sends, without a picture.

use super::arguments::{Shared, SweepOptions};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::gpu::{Card, Link};
use crate::models::{Kind, LeafFormat, TrunkKind};
use crate::raster::Counters;
use crate::report::{ByteReport, OutputFolder, bytes_json, bytes_text, write_bytes};
use crate::run::{self, ByteOptions, Variant};
use crate::scene::to_toml;

/// The links where none is asked for: the papers' bus and a new one.
const LINKS: [&str; 2] = ["agp8x", "pcie5x16"];

pub(super) fn bytes(
    options: &SweepOptions,
    variants: Option<Vec<Variant>>,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let prepared = Prepared::new(
        &options.scene,
        None,
        Counters::Visible,
        shared,
        terminal,
        &progress,
    )?;
    let target = folder(shared, &format!("{}-bytes", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let links = match shared.link {
        Some(link) => vec![link],
        None => LINKS.into_iter().filter_map(Link::named).collect(),
    };
    let walk = ByteOptions {
        variants: variants.unwrap_or_else(|| all_on(prepared.options.card)),
        steps: options.steps,
        links: links.clone(),
        session: prepared.options,
    };
    let mut plants = run::bytes(&prepared.scene, &prepared.world, &walk, &progress)?;
    for (number, plant) in plants.iter_mut().enumerate() {
        plant.name = prepared.plant_name(number, &options.scene);
    }
    drop(progress);
    let report = ByteReport {
        resolved: to_toml(&prepared.scene),
        scene: prepared.scene.name,
        steps: options.steps,
        links,
        plants,
    };
    write_bytes(&output, &report)?;
    output.commit()?;
    if shared.json {
        return terminal.print(&bytes_json(&report));
    }
    let text = bytes_text(&report, terminal.width());
    let target = target.display();
    terminal.print(&format!(
        "{text}\n{target}: plots, tables and report.html\n"
    ))
}

/// All foliage that a card can do, with quantised vertices what else is smallest; then every trunk
/// with levels, where the foliage stays as it is, and slots of trunks gathered.
fn all_on(card: Card) -> Vec<Variant> {
    let quantised = [
        Kind::LodfHost,
        Kind::LodfSlots,
        Kind::LodfStamps,
        Kind::LodfDevice,
    ];
    let quantised = quantised.map(|kind| Variant {
        format: LeafFormat::ALL[3],
        gathered: kind == Kind::LodfSlots,
        ..Variant::usual(kind)
    });
    // Branches are another tree than the mesh: `spinney branches` tells what they send.
    let trunks = TrunkKind::all().filter(|kind| !kind.has_errors());
    let trunks = trunks.flat_map(|trunk| {
        let trunk = |gathered| Variant {
            trunk: Some(trunk),
            gathered,
            ..Variant::usual(Kind::Full)
        };
        [trunk(false), trunk(true)]
    });
    let all = Variant::ALL.into_iter().chain(quantised).chain(trunks);
    all.filter(|variant| variant.is_sound() && variant.runs_on(card))
        .collect()
}
