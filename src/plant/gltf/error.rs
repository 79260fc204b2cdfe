//! Why a file is refused, or a plant cannot be written.

use crate::document::DocumentError;
use crate::plant::PlantError;

/// Why a file is not imported. A refused file leaves nothing behind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file cannot be read at all.
    #[error("{file}: {message}")]
    Read {
        /// The file, as the user named it.
        file: String,
        /// What the system says.
        message: String,
    },
    /// The file is larger than [`PLANT_FILE_BYTES`](crate::limits::PLANT_FILE_BYTES).
    #[error("{file}: {bytes} bytes exceed the limit of {limit}; split the scene or simplify it")]
    TooLarge {
        /// The file, as the user named it.
        file: String,
        /// How many bytes it has.
        bytes: u64,
        /// How many it may have.
        limit: u64,
    },
    /// The binary container is broken.
    #[error("{file}: byte {offset}: {message}")]
    Binary {
        /// The file, as the user named it.
        file: String,
        /// Where in the file, from 0.
        offset: u64,
        /// What was found, and what would be right.
        message: String,
    },
    /// The JSON is broken, or a value has the wrong type.
    #[error("{0}")]
    Syntax(DocumentError),
    /// A value of the document does not fit what it names or what is supported.
    #[error("{file}: {pointer}: {message}")]
    Value {
        /// The file, as the user named it.
        file: String,
        /// The JSON pointer of the value.
        pointer: String,
        /// What was found, and what would be right.
        message: String,
    },
    /// A foliage name that nothing bears.
    #[error("{file}: no node, mesh, material or primitive is named {name:?}; there are: {known}")]
    Name {
        /// The file, as the user named it.
        file: String,
        /// The name asked for.
        name: String,
        /// The names that the file has.
        known: String,
    },
    /// The parts do not make a plant.
    #[error("{file}: {source}")]
    Plant {
        /// The file, as the user named it.
        file: String,
        /// What does not fit.
        source: PlantError,
    },
}

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
