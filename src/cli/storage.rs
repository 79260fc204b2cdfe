//! `spinney storage`.

use super::arguments::{Shared, StorageOptions};
use super::error::CliError;
use super::terminal::Terminal;

pub(super) fn storage(
    _options: &StorageOptions,
    _shared: &Shared,
    _terminal: &Terminal,
) -> Result<(), CliError> {
    Ok(())
}
