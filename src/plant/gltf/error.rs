//! Why a plant cannot be written, and where in a document something is wrong.

use crate::plant::import::ImportError;

/// Why a plant is not written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// More bytes than can be read again.
    #[error("plant {plant:?}: {bytes} bytes of glTF exceed the limit of {limit}")]
    TooLarge {
        /// The plant's name.
        plant: String,
        /// How many bytes the file would have, at least.
        bytes: u64,
        /// How many it may have.
        limit: u64,
    },
    /// More groups than can be read again.
    #[error("plant {plant:?}: {groups} foliage groups exceed the limit of {limit}")]
    TooManyGroups {
        /// The plant's name.
        plant: String,
        /// How many groups it has.
        groups: usize,
        /// How many it may have.
        limit: usize,
    },
}

/// An error at a JSON pointer, before the file's name is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) pointer: String,
    pub(super) message: String,
}

impl Fault {
    pub(super) fn new(pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            pointer: pointer.into(),
            message: message.into(),
        }
    }

    /// An index that points past the end of a list.
    pub(super) fn index(
        pointer: impl Into<String>,
        what: &str,
        index: usize,
        count: usize,
    ) -> Self {
        Self::new(
            pointer,
            format!("names {what} {index}, but there are {count}"),
        )
    }

    pub(super) fn in_file(self, file: &str) -> ImportError {
        ImportError::Value {
            file: file.to_owned(),
            pointer: self.pointer,
            message: self.message,
        }
    }
}
