//! `spinney storage`: what keeping a foliage takes, by the papers' accounting and in truth.

use std::path::Path;

use super::arguments::{Shared, StorageOptions};
use super::error::CliError;
use super::prepare::Prepared;
use super::terminal::Terminal;
use crate::raster::Counters;
use crate::report::storage_report;
use crate::scene::PlantSource;

pub(super) fn storage(
    options: &StorageOptions,
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
    drop(progress);
    let mut reports = Vec::new();
    for (number, crown) in prepared.world.crowns.iter().enumerate() {
        let tree = prepared
            .world
            .trees
            .iter()
            .position(|tree| tree.crown == number);
        let source = tree
            .and_then(|tree| prepared.scene.trees.get(tree))
            .map(|tree| &tree.source);
        let name = latin(options.scene.parent(), source)
            .unwrap_or_else(|| crown.plant().name().to_owned());
        reports.push(storage_report(&name, crown, prepared.options.model));
    }
    if shared.json {
        let list: Vec<String> = reports.iter().map(|report| report.to_json()).collect();
        return terminal.print(&format!("[{}]", list.join(",\n")));
    }
    let texts: Vec<String> = reports
        .iter()
        .map(|report| report.to_text(terminal.width()))
        .collect();
    terminal.print(&texts.join("\n"))
}

/// The botanical name of a grown tree: what the papers' tables list.
fn latin(folder: Option<&Path>, source: Option<&PlantSource>) -> Option<String> {
    let Some(PlantSource::Species(path)) = source else {
        return None;
    };
    let species = crate::plant::Species::read(&folder?.join(path)).ok()?;
    Some(species.latin)
}
