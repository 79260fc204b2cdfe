//! Text documents at the border: where in a file something is wrong, and reading TOML tables with
//! errors that say so.

use std::path::Path;

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
    /// The largest text file that is read, in bytes.
    pub const MAX_BYTES: u64 = 16 << 20;

    /// Reads a UTF-8 file of at most [`Document::MAX_BYTES`].
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is too large or is not UTF-8; then line and column are 1, or
    /// the place of the first byte that is no UTF-8.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        use std::io::Read as _;
        let file = path.display().to_string();
        let fail = |message: String| DocumentError {
            file: file.clone(),
            line: 1,
            column: 1,
            message,
        };
        let opened =
            std::fs::File::open(path).map_err(|error| fail(format!("cannot read: {error}")))?;
        let mut bytes = Vec::new();
        opened
            .take(Self::MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| fail(format!("cannot read: {error}")))?;
        if bytes.len() as u64 > Self::MAX_BYTES {
            return Err(fail(format!("larger than {} bytes", Self::MAX_BYTES)));
        }
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

/// Line and column, both from 1, of a byte offset.
#[must_use]
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before: Vec<char> = text
        .char_indices()
        .take_while(|(at, _)| *at < offset)
        .map(|(_, c)| c)
        .collect();
    let line = 1 + before.iter().filter(|&&c| c == '\n').count();
    let column = 1 + before.iter().rev().take_while(|&&c| c != '\n').count();
    (line, column)
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
