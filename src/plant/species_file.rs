//! A file that a scene names as a tree's species, of either kind.

use std::path::Path;

use super::rl_system::RlSystem;
use super::{GrowError, Plant, Species, grow};
use crate::document::{Document, DocumentError};

/// What a tree grows from; the ending of the file's name says which.
#[derive(Debug, Clone)]
pub enum SpeciesFile {
    /// The parameters of a tree, `*.toml`.
    WeberPenn(Box<Species>),
    /// A grammar, `*.rls`.
    RlSystem(Box<RlSystem>),
}

impl SpeciesFile {
    /// Reads a species of either kind.
    ///
    /// # Errors
    ///
    /// As [`Species::parse`] and [`RlSystem::parse`] do, or when the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::parse(&Document::read(path)?)
    }

    /// The species that a document describes, by the ending of its name.
    ///
    /// # Errors
    ///
    /// As [`SpeciesFile::read`], once the file is read.
    pub fn parse(document: &Document) -> Result<Self, DocumentError> {
        Ok(if Self::ending_of(&document.file) == "rls" {
            Self::RlSystem(Box::new(RlSystem::parse(document)?))
        } else {
            Self::WeberPenn(Box::new(Species::parse(document)?))
        })
    }

    /// The ending of a file of the kind that a name says: `rls` or `toml`.
    #[must_use]
    pub fn ending_of(file: &str) -> &'static str {
        let ending = Path::new(file).extension();
        if ending.is_some_and(|ending| ending.eq_ignore_ascii_case("rls")) {
            "rls"
        } else {
            "toml"
        }
    }

    /// Grows the plant that a seed names; the same on every machine.
    ///
    /// # Errors
    ///
    /// As [`grow`] and [`RlSystem::grow`].
    pub fn grow(&self, seed: u64) -> Result<Plant, GrowError> {
        match self {
            Self::WeberPenn(species) => grow(species, seed),
            Self::RlSystem(system) => Ok(system.grow(seed)?.plant),
        }
    }

    /// The botanical name; may be empty.
    #[must_use]
    pub fn latin(&self) -> &str {
        match self {
            Self::WeberPenn(species) => &species.latin,
            Self::RlSystem(system) => system.latin(),
        }
    }

    /// How many leaves remain after all collapses, where the file says so.
    #[must_use]
    pub fn stop_leaves(&self) -> Option<u32> {
        match self {
            Self::WeberPenn(species) => species.stop_leaves,
            Self::RlSystem(system) => system.stop_leaves(),
        }
    }
}
