//! A file that a scene names as a tree's species, of any kind.

use std::path::Path;

use super::import::ImportReport;
use super::rl_system::RlSystem;
use super::{ArbaroSpecies, GrowError, Plant, Species, grow};
use crate::document::{Document, DocumentError};

/// What a tree grows from; the file's content and the ending of its name say which.
#[derive(Debug, Clone)]
pub enum SpeciesFile {
    /// The parameters of a tree, `*.toml`.
    WeberPenn(Box<Species>),
    /// The parameters of a tree as Arbaro keeps them, `*.xml`.
    Arbaro(Box<ArbaroSpecies>),
    /// A grammar, `*.rls`.
    RlSystem(Box<RlSystem>),
}

impl SpeciesFile {
    /// The endings of the kinds' files.
    pub const ENDINGS: [&str; 3] = ["toml", "rls", "xml"];

    /// Reads a species of any kind.
    ///
    /// # Errors
    ///
    /// As [`Species::parse`], [`ArbaroSpecies::parse`] and [`RlSystem::parse`] do, or when the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::parse(&Document::read(path)?)
    }

    /// The species that a document describes, by its content and the ending of its name.
    ///
    /// # Errors
    ///
    /// As [`SpeciesFile::read`], once the file is read.
    pub fn parse(document: &Document) -> Result<Self, DocumentError> {
        let ending = Self::ending_of(&document.file);
        Ok(if ending == "rls" {
            Self::RlSystem(Box::new(RlSystem::parse(document)?))
        } else if ending == "xml" || ArbaroSpecies::is_one(document) {
            Self::Arbaro(Box::new(ArbaroSpecies::parse(document)?))
        } else {
            Self::WeberPenn(Box::new(Species::parse(document)?))
        })
    }

    /// The ending of a file of the kind that a name says: `rls`, `xml` or `toml`.
    #[must_use]
    pub fn ending_of(file: &str) -> &'static str {
        let found = Path::new(file).extension().unwrap_or_default();
        let mut known = Self::ENDINGS.into_iter();
        known
            .find(|ending| found.eq_ignore_ascii_case(ending))
            .unwrap_or("toml")
    }

    /// The parameters that the tree grows by; a grammar has none.
    #[must_use]
    pub fn species(&self) -> Option<&Species> {
        match self {
            Self::WeberPenn(species) => Some(species),
            Self::Arbaro(arbaro) => Some(&arbaro.species),
            Self::RlSystem(_) => None,
        }
    }

    /// How a file of another program was understood.
    #[must_use]
    pub fn report(&self) -> Option<&ImportReport> {
        match self {
            Self::Arbaro(arbaro) => Some(&arbaro.report),
            Self::WeberPenn(_) | Self::RlSystem(_) => None,
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
            Self::Arbaro(arbaro) => grow(&arbaro.species, seed),
            Self::RlSystem(system) => Ok(system.grow(seed)?.plant),
        }
    }

    /// The botanical name; may be empty.
    #[must_use]
    pub fn latin(&self) -> &str {
        match self {
            Self::WeberPenn(species) => &species.latin,
            Self::Arbaro(arbaro) => &arbaro.species.latin,
            Self::RlSystem(system) => system.latin(),
        }
    }

    /// How many leaves remain after all collapses, where the file says so.
    #[must_use]
    pub fn stop_leaves(&self) -> Option<u32> {
        match self {
            Self::WeberPenn(species) => species.stop_leaves,
            Self::Arbaro(arbaro) => arbaro.species.stop_leaves,
            Self::RlSystem(system) => system.stop_leaves(),
        }
    }
}
