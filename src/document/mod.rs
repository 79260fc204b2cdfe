//! Files at the border: reading them whole up to a limit, where in a text something is wrong, reading
//! TOML tables and XML with errors that say so, and enums whose values they choose by name.

mod choices;
mod png;
mod xml;

use std::path::Path;

use crate::limits;

pub(crate) use choices::choices;
pub use png::check_png;
pub(crate) use xml::parse_xml;

/// What is wrong with a text file, and where.
///
/// Prints as `FILE:LINE:COLUMN: MESSAGE`; lines and columns count from 1, columns in characters.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {message}")]
pub struct DocumentError {
    /// The file, as the user named it.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column, from 1, in characters.
    pub column: usize,
    /// What is wrong, what was found, and what would be right.
    pub message: String,
}

impl DocumentError {
    /// An error at a byte offset of `text`.
    #[must_use]
    pub fn at(file: &str, text: &str, offset: usize, message: impl Into<String>) -> Self {
        let (line, column) = line_and_column(text, offset);
        Self {
            file: file.to_owned(),
            line,
            column,
            message: message.into(),
        }
    }
}

/// A text file with its name, for errors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Document {
    /// The file, as the user named it.
    pub file: String,
    /// All of its text.
    pub text: String,
}

impl Document {
    /// Reads a UTF-8 file of at most [`limits::TEXT_BYTES`].
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is too large or is not UTF-8; then line and column are 1, or
    /// the place of the first byte that is no UTF-8.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        let file = path.display().to_string();
        let bytes = read_file(path, limits::TEXT_BYTES).map_err(|error| DocumentError {
            file: file.clone(),
            line: 1,
            column: 1,
            message: error.to_string(),
        })?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self { file, text }),
            Err(error) => {
                let offset = error.utf8_error().valid_up_to();
                let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
                Err(DocumentError::at(&file, &text, offset, "not UTF-8"))
            }
        }
    }

    /// An error at a byte offset.
    #[must_use]
    pub fn error(&self, offset: usize, message: impl Into<String>) -> DocumentError {
        DocumentError::at(&self.file, &self.text, offset, message)
    }

    /// The document as a value, by `serde`.
    ///
    /// # Errors
    ///
    /// What `toml` says, at its line and column: syntax, unknown or missing keys, wrong types.
    pub fn parse_toml<T: serde::de::DeserializeOwned>(&self) -> Result<T, DocumentError> {
        toml::from_str(&self.text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            self.error(offset, error.message())
        })
    }
}

/// Reads a whole regular file of at most `limit` bytes: what every reader begins with.
///
/// # Errors
///
/// When the system cannot read it, it is a folder, pipe or device, which can keep a reader waiting
/// for ever, or it is larger; then no more than the limit was read.
pub fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    use std::io::Read as _;
    let failed = |error: std::io::Error| ReadError::System(error.to_string());
    let metadata = std::fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(ReadError::NoFile);
    }
    let mut bytes = Vec::new();
    let mut found = metadata.len();
    if found <= limit {
        // It may grow, or hold more than it says, as some of the system's own files do.
        let file = std::fs::File::open(path).map_err(failed)?;
        let mut file = file.take(limit.saturating_add(1));
        file.read_to_end(&mut bytes).map_err(failed)?;
        found = bytes.len() as u64;
    }
    if found > limit {
        return Err(ReadError::TooLarge { found, limit });
    }
    Ok(bytes)
}

/// Why a file was not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// What the system says.
    #[error("cannot read: {0}")]
    System(String),
    /// A folder, a pipe or a device.
    #[error("cannot read: not a regular file")]
    NoFile,
    /// It has more bytes than it may.
    #[error("{found} bytes exceed the limit of {limit}")]
    TooLarge {
        /// How many it has, at least.
        found: u64,
        /// How many it may have.
        limit: u64,
    },
}

/// Line and column, both from 1, of a byte offset.
#[must_use]
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.char_indices().take_while(|(at, _)| *at < offset);
    before.fold((1, 1), |(line, column), (_, c)| match c {
        '\n' => (line + 1, 1),
        _ => (line, column + 1),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_become_lines_and_columns() {
        assert_eq!(line_and_column("ab\ncd", 0), (1, 1));
        assert_eq!(line_and_column("ab\ncd", 4), (2, 2));
        assert_eq!(line_and_column("äb", 2), (1, 2));
        assert_eq!(line_and_column("", 9), (1, 1));
    }
}
