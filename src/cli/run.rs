//! `spinney run`.

use super::arguments::{RunOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;

pub(super) fn run(
    _options: &RunOptions,
    _shared: &Shared,
    _terminal: &Terminal,
) -> Result<(), CliError> {
    Ok(())
}
