//! `spinney sweep`.

use super::arguments::{Shared, SweepOptions};
use super::error::CliError;
use super::terminal::Terminal;

pub(super) fn sweep(
    _options: &SweepOptions,
    _shared: &Shared,
    _terminal: &Terminal,
) -> Result<(), CliError> {
    Ok(())
}
