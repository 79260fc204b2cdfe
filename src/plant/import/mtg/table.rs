//! Sections, classes, and the columns of features.

use std::collections::BTreeMap;

use crate::limits::TABLE_COLUMNS;
use crate::plant::import::number::{FARTHEST, bounded};
use crate::plant::import::{ImportError, Source};

/// What an entity may tell of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Feature {
    /// The position of its top.
    X,
    /// The position of its top.
    Y,
    /// The position of its top.
    Z,
    /// The diameter at its top.
    Diameter,
    /// How many leaves it bears.
    LeafCount,
    /// The area of the leaves that it bears, or of the leaf that it is.
    LeafArea,
    /// The length of the leaf that it is.
    Length,
    /// The width of the leaf that it is.
    Width,
    /// The angle between the axis and the leaf that it is, in degrees.
    Insertion,
    /// The turn around the axis of the leaf that it is, in degrees.
    Azimuth,
}

/// How many kinds of features there are.
pub(super) const FEATURES: usize = 10;

impl Feature {
    /// All of them, with the names that files give them, in small letters and without signs.
    const ALL: [(Self, &'static [&'static str]); FEATURES] = [
        (Self::X, &["xx", "x"]),
        (Self::Y, &["yy", "y"]),
        (Self::Z, &["zz", "z"]),
        (
            Self::Diameter,
            &["topdia", "topdiameter", "diameter", "diam"],
        ),
        (
            Self::LeafCount,
            &["nfe", "nbleaves", "leafcount", "numberofleaves"],
        ),
        (Self::LeafArea, &["leafarea", "leavesarea", "totalleafarea"]),
        (Self::Length, &["length", "leaflength", "longueur"]),
        (Self::Width, &["width", "leafwidth", "largeur"]),
        (
            Self::Insertion,
            &["xeuler", "insertion", "insertionangle", "angle"],
        ),
        (Self::Azimuth, &["azimuth", "azimut", "phyllotaxy"]),
    ];

    /// The least number that it can be.
    fn least(self) -> f64 {
        match self {
            Self::X | Self::Y | Self::Z | Self::Insertion | Self::Azimuth => -FARTHEST,
            Self::Diameter | Self::LeafCount | Self::LeafArea | Self::Length | Self::Width => 0.0,
        }
    }
}

/// The features of one entity; not a number where the file says nothing.
pub(super) type Values = [f64; FEATURES];

/// What stands above the entities.
#[derive(Debug, Default)]
pub(super) struct Head {
    /// Scales by class.
    pub(super) classes: BTreeMap<String, u32>,
    /// The tab position of the first column of features.
    pub(super) first: usize,
    /// Tab positions of features, each with the name that the file gives it.
    columns: Vec<(usize, Feature, String)>,
}

/// A section of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Section {
    /// Nothing in it is needed.
    Other,
    /// Classes and their scales.
    Classes,
    /// Entities.
    Mtg,
}

impl Section {
    /// The section that a line begins.
    pub(super) fn of(line: &str) -> Option<Self> {
        let (name, _) = line.split_once(':')?;
        match name.trim() {
            "CODE" | "DESCRIPTION" | "FEATURES" => Some(Self::Other),
            "CLASSES" => Some(Self::Classes),
            "MTG" => Some(Self::Mtg),
            _ => None,
        }
    }
}

impl Head {
    /// Reads a line of the classes: a symbol and its scale. The line of names has no scale.
    pub(super) fn class(&mut self, line: &str) {
        let mut words = line.split_whitespace();
        if let (Some(symbol), Some(Ok(scale))) = (words.next(), words.next().map(str::parse)) {
            self.classes.insert(symbol.to_owned(), scale);
        }
    }

    /// Reads the line that follows `MTG:`: the names of features at their tab positions.
    pub(super) fn names(
        &mut self,
        number: usize,
        line: &str,
        source: &Source<'_>,
    ) -> Result<(), ImportError> {
        let names = || line.split('\t').enumerate().skip(1);
        let mut named = names().filter(|(_, name)| !name.trim().is_empty());
        self.first = named.next().map_or(0, |(place, _)| place);
        let count = 1 + names().count();
        source.limit("columns", count as u64, TABLE_COLUMNS as u64)?;
        for (feature, known) in Feature::ALL {
            // The names stand in the order of trust.
            let plain = |name: &str| -> String {
                let letters = name.chars().filter(char::is_ascii_alphanumeric);
                letters.collect::<String>().to_lowercase()
            };
            let find = |known: &&str| names().find(|(_, name)| plain(name) == *known);
            if let Some((place, name)) = known.iter().find_map(find) {
                self.columns.push((place, feature, name.trim().to_owned()));
            }
        }
        let positions = self
            .columns
            .iter()
            .take_while(|(_, feature, _)| matches!(feature, Feature::X | Feature::Y | Feature::Z));
        let found = positions.count();
        if found < 3 {
            let message = format!(
                "{found} of the columns XX, YY and ZZ, wanted 3: without positions there is no shape; digitize \
                 the plant, or compute them"
            );
            return Err(source.error(number, 1, message));
        }
        Ok(())
    }

    /// The features of a line; `None` where all cells are empty or cut, or hold a word for nothing.
    pub(super) fn values(
        &self,
        number: usize,
        line: &str,
        cells: &[&str],
        source: &Source<'_>,
    ) -> Result<Option<Values>, ImportError> {
        let mut values = [f64::NAN; FEATURES];
        let mut is_empty = true;
        for (place, feature, name) in &self.columns {
            let cell = cells.get(*place).map_or("", |cell| cell.trim());
            if matches!(cell, "" | "-" | "?" | "." | "NA" | "NaN" | "nan") {
                continue;
            }
            let range = feature.least()..=FARTHEST;
            // Where tabs separate, a comma is a decimal point.
            let value = bounded(&cell.replace(',', "."), name, &range)
                .map_err(|message| source.error(number, column_of(line, *place), message))?;
            values[*feature as usize] = value;
            is_empty = false;
        }
        Ok((!is_empty).then_some(values))
    }
}

/// The column of the file, from 1, in which the cell at a tab position begins.
pub(super) fn column_of(line: &str, place: usize) -> usize {
    let cells = line.split('\t').take(place);
    1 + cells.map(|cell| cell.chars().count() + 1).sum::<usize>()
}
