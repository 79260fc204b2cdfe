//! `spinney storage`: what keeping a foliage takes, by the papers' accounting and in truth.

mod published;

use super::arguments::{Shared, StorageOptions};
use super::error::CliError;
use super::prepare::Prepared;
use super::terminal::Terminal;
use crate::raster::Counters;
use crate::report::{self, PrintedSize, is_paper_tree, storage_report};
use crate::simplify::{Accounting, CollapseSequence, PUBLISHED_ROWS, PublishedCell, StorageCounts};

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
        let name = prepared.plant_name(number, &options.scene);
        let accountings = accountings(&name, crown.sequence());
        reports.push(storage_report(
            &name,
            (crown, prepared.world.trunks[number].as_ref()),
            prepared.options.model,
            accountings,
        ));
    }
    if shared.json {
        let list: Vec<String> = reports.iter().map(|report| report.to_json()).collect();
        return terminal.print(&format!("[{}]", list.join(",\n")));
    }
    let width = terminal.width();
    let mut texts: Vec<String> = reports.iter().map(|report| report.to_text(width)).collect();
    let tables = published::published(&reports, width);
    if !tables.is_empty() {
        texts.push(tables);
    }
    terminal.print(&texts.join("\n"))
}

/// Every way of counting, each with what the papers print for a tree of this name.
fn accountings(name: &str, sequence: &CollapseSequence) -> Vec<report::Accounting> {
    let counts = StorageCounts::of(sequence);
    let printed = |accounting: Accounting| {
        let rows = PUBLISHED_ROWS
            .iter()
            .filter(move |row| row.accounting() == accounting && is_paper_tree(name, row.tree));
        rows.map(|row| PrintedSize {
            table: row.table.to_owned(),
            mebibyte_hundredths: row.size,
            leaves: u64::from(row.originals),
            erratum: row.erratum(PublishedCell::Size).map(str::to_owned),
        })
        .collect()
    };
    Accounting::ALL
        .into_iter()
        .map(|accounting| report::Accounting {
            name: accounting.name().to_owned(),
            bytes: accounting.bytes(counts),
            printed: printed(accounting),
        })
        .collect()
}
