//! `spinney merge`: the folders of all shards become the folder of an unsharded run or walk.

use std::path::Path;

use super::arguments::{MergeOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use super::{run, sweep};
use crate::report::{self, Merged};

pub(super) fn merge(
    options: &MergeOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let target = |scene: &str, is_sweep: bool| match is_sweep {
        true => run::folder(shared, &format!("{scene}-sweep")),
        false => run::folder(shared, scene),
    };
    let (merged, target) = report::merge(&options.folders, target, &progress)?;
    drop(progress);
    let target: &Path = &target;
    match merged {
        Merged::Run { header, rows, path } => {
            let rows = (&rows[..], path.as_ref());
            run::closing(rows, header.link, target, shared, terminal)
        }
        Merged::Sweep {
            header,
            sweep,
            quality,
        } => sweep::closing(&header, &sweep, quality.as_ref(), target, shared, terminal),
    }
}
