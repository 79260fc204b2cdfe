//! Files that grow piece by piece, for what is too long to be held in memory.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::PathBuf;

use super::{OutputFolder, ReportError};

/// A file of a folder that is being written.
#[derive(Debug)]
pub(super) struct GrowingFile {
    /// As it will be called, for messages.
    path: PathBuf,
    file: BufWriter<File>,
}

impl GrowingFile {
    /// Begins a file.
    pub(super) fn create(folder: &OutputFolder, name: &str) -> Result<Self, ReportError> {
        let path = folder.target().join(name);
        let file =
            File::create(folder.file(name)?).map_err(|cause| ReportError::write(&path, cause))?;
        Ok(Self {
            path,
            file: BufWriter::new(file),
        })
    }

    /// Adds text.
    pub(super) fn add(&mut self, text: &str) -> Result<(), ReportError> {
        let written = self.file.write_all(text.as_bytes());
        written.map_err(|cause| ReportError::write(&self.path, cause))
    }

    /// Ends the file.
    pub(super) fn finish(mut self) -> Result<(), ReportError> {
        let flushed = self.file.flush();
        flushed.map_err(|cause| ReportError::write(&self.path, cause))
    }
}
