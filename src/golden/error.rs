//! Why nothing can be said about goldens at all.

use std::io;
use std::path::PathBuf;

use crate::report::ReportError;
use crate::run::RunError;
use crate::scene::SceneError;

/// Why scenes cannot be drawn, or references not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GoldenError {
    /// A folder cannot be read.
    #[error("{}: cannot read: {cause}", folder.display())]
    Read {
        /// The folder.
        folder: PathBuf,
        /// What the system says.
        #[source]
        cause: io::Error,
    },
    /// Folders lie in each other too deep.
    #[error("{}: folders within folders, wanted at most {limit}", folder.display())]
    Deep {
        /// The folder at which the search gave up.
        folder: PathBuf,
        /// How deep folders may lie.
        limit: usize,
    },
    /// A file has a name that no report could show.
    #[error("{}: wanted a name of text without control characters and backslashes", file.display())]
    Name {
        /// The file.
        file: PathBuf,
    },
    /// There is nothing to draw.
    #[error("{}: no scene in this folder, wanted TOML files that begin with schema = \"{}\"", folder.display(), crate::scene::SCHEMA)]
    NoScene {
        /// The folder.
        folder: PathBuf,
    },
    /// There is nothing to compare.
    #[error("{}: no scene in this folder has a [golden] table{}", folder.display(), among(only.as_deref()))]
    NothingKept {
        /// The folder.
        folder: PathBuf,
        /// What names of scenes had to have in them.
        only: Option<String>,
    },
    /// A reference cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// A reference cannot be removed.
    #[error("{}: cannot remove: {cause}", file.display())]
    Remove {
        /// The file.
        file: PathBuf,
        /// What the system says.
        #[source]
        cause: io::Error,
    },
    /// A scene file says something wrong.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A scene cannot be drawn.
    #[error("{}: {source}", file.display())]
    Run {
        /// The scene file.
        file: PathBuf,
        /// Why.
        source: Box<RunError>,
    },
}

fn among(only: Option<&str>) -> String {
    only.map_or(String::new(), |only| format!(" and {only:?} in its name"))
}

impl GoldenError {
    /// Whether the output cannot be written, as opposed to a fault of the input.
    #[must_use]
    pub fn is_write(&self) -> bool {
        match self {
            Self::Report(error) => error.is_write(),
            Self::Remove { .. } => true,
            _ => false,
        }
    }
}
