//! Why a file is refused.

use crate::document::DocumentError;
use crate::plant::{GrowError, PlantError};

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
    /// A text is broken, or a value of it has the wrong type.
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
    /// The format is not known, or what the user says of it does not fit.
    #[error("{file}: {message}")]
    Format {
        /// The file, as the user named it.
        file: String,
        /// What was found, and the way out.
        message: String,
    },
    /// More of something than is read.
    #[error("{file}: {found} {what} exceed the limit of {limit}; split or thin the tree")]
    TooMany {
        /// The file, as the user named it.
        file: String,
        /// What was counted.
        what: &'static str,
        /// How many there are, at least.
        found: u64,
        /// How many there may be.
        limit: u64,
    },
    /// A species file does not grow.
    #[error("{file}: {source}")]
    Grow {
        /// The file, as the user named it.
        file: String,
        /// Why not.
        source: GrowError,
    },
    /// A foliage name that nothing bears.
    #[error("{file}: nothing is named {name:?}; there are: {known}")]
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
