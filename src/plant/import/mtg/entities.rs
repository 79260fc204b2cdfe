//! Who bears whom.

use std::collections::BTreeMap;

use super::steps::{Relation, Step, steps};
use super::table::{Feature, Head, Section, Values, column_of};
use crate::limits::{SKIPPED_ENTITIES, TABLE_COLUMNS, WOOD_SEGMENTS};
use crate::math::index_u32;
use crate::plant::import::wood::place_of;
use crate::plant::import::{ImportError, ImportReport, ReportKind, Source};

/// No entity.
pub(super) const NONE: u32 = u32::MAX;

/// An entity of any scale.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entity {
    /// The entity before it, or [`NONE`]: it has a smaller number.
    pub(super) parent: u32,
    /// How it goes on from that.
    pub(super) relation: Relation,
    /// Its class, among [`Entities::classes`].
    pub(super) class: u32,
    /// The number behind its class, if it has one.
    index: Option<u64>,
    /// Whether a doubled sign skips it.
    pub(super) is_between: bool,
    /// Whether it has parts.
    pub(super) has_parts: bool,
    /// The line that names it.
    pub(super) line: u32,
    /// Its features, among [`Entities::values`], or [`NONE`].
    values: u32,
}

/// All entities, in the order of the file: bearers before what they bear.
#[derive(Debug, Default)]
pub(super) struct Entities {
    /// The entities.
    pub(super) all: Vec<Entity>,
    /// The classes that occur.
    pub(super) classes: Vec<String>,
    /// The features that are told.
    values: Vec<Values>,
    head: Head,
    /// Numbers of classes.
    numbers: BTreeMap<String, u32>,
    /// The last entity of each column.
    last: Vec<u32>,
}

impl Entities {
    pub(super) fn read(
        text: &str,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<Self, ImportError> {
        let mut entities = Self::default();
        let mut section = Section::Other;
        let mut has_names = false;
        for (number, line) in (1..).zip(text.lines()) {
            if line.trim().is_empty() || line.trim_start().starts_with('#') {
                continue;
            }
            if let Some(begun) = Section::of(line) {
                section = begun;
                continue;
            }
            match section {
                Section::Other => {}
                Section::Classes => entities.head.class(line),
                Section::Mtg if has_names => entities.line(number, line, source, report)?,
                Section::Mtg => {
                    entities.head.names(number, line, source)?;
                    has_names = true;
                }
            }
        }
        if entities.all.is_empty() {
            let message =
                "no entities, wanted a section MTG: with a line of names and lines of entities";
            return Err(source.error(1, 1, message));
        }
        report.find("entities", entities.all.len() as u64);
        Ok(entities)
    }

    /// A feature of an entity, if the file tells it.
    pub(super) fn value(&self, entity: u32, feature: Feature) -> Option<f64> {
        let values = self.values.get(self.all[entity as usize].values as usize)?;
        Some(values[feature as usize]).filter(|value| !value.is_nan())
    }

    /// Reads a line of entities. What stands left of the first column of features is topology.
    fn line(
        &mut self,
        number: usize,
        line: &str,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<(), ImportError> {
        // What stands beyond all columns is nothing's.
        let cells: Vec<&str> = line.split('\t').take(TABLE_COLUMNS).collect();
        let left = &cells[..cells.len().min(self.head.first)];
        let mut entity = NONE;
        for (place, cell) in left.iter().enumerate() {
            let cell = cell.trim();
            if !cell.is_empty() {
                entity = self.cell(number, [line, cell], place, source, report)?;
            }
        }
        let values = self.head.values(number, line, &cells, source)?;
        match (entity, values) {
            (NONE, None) => {}
            (NONE, Some(_)) => {
                let column = column_of(line, self.head.first);
                let message = format!(
                    "features without an entity in the {} columns left of them",
                    self.head.first
                );
                return Err(source.error(number, column, message));
            }
            (_, None) => {}
            (_, Some(values)) => {
                self.all[entity as usize].values = index_u32(self.values.len());
                self.values.push(values);
            }
        }
        Ok(())
    }

    /// Reads a cell of topology; returns its last entity.
    fn cell(
        &mut self,
        number: usize,
        [line, cell]: [&str; 2],
        place: usize,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<u32, ImportError> {
        let blanks = |text: &str| text.chars().take_while(|c| c.is_whitespace()).count();
        let cell_blanks = line.split('\t').nth(place).map_or(0, blanks);
        let column = column_of(line, place) + cell_blanks;
        let (goes_on, steps) =
            steps(cell).map_err(|(at, message)| source.error(number, column + at, message))?;
        self.last.resize(self.last.len().max(place + 1), NONE);
        let left = || self.last[..place].iter().rev().find(|last| **last != NONE);
        let mut entity = if goes_on {
            self.last[place]
        } else {
            left().copied().unwrap_or(NONE)
        };
        if goes_on && entity == NONE {
            let message =
                format!("^ goes on from nothing: no entity above it in column {place} of tabs");
            return Err(source.error(number, column, message));
        }
        for step in &steps {
            entity = self.step(entity, step, number, source, report)?;
        }
        self.last[place] = entity;
        Ok(entity)
    }

    /// Adds the entity of a step, and those that it skips.
    fn step(
        &mut self,
        before: u32,
        step: &Step<'_>,
        number: usize,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<u32, ImportError> {
        let known = self.numbers.get(step.symbol).copied();
        let class = known.unwrap_or(index_u32(self.classes.len()));
        if known.is_none() {
            self.numbers.insert(step.symbol.to_owned(), class);
            self.classes.push(step.symbol.to_owned());
            if !self.head.classes.contains_key(step.symbol) {
                let message = "classes that CLASSES does not list: read as any other";
                report.add(ReportKind::NotUnderstood, 1, place_of(number), message);
            }
        }
        let from = self.all.get(before as usize);
        let from = from
            .filter(|from| from.class == class)
            .and_then(|from| from.index);
        let last = step.index;
        let first = match (step.skips, from, last) {
            (true, Some(from), Some(last)) if from < last => Some(from + 1),
            _ => last,
        };
        let between = last.zip(first).map_or(0, |(last, first)| last - first);
        for (what, found, limit) in [
            ("entities between two of a line", between, SKIPPED_ENTITIES),
            (
                "entities",
                between.saturating_add(self.all.len() as u64 + 1),
                WOOD_SEGMENTS as u64,
            ),
        ] {
            source.limit(what, found, limit)?;
        }
        let mut parent = before;
        for back in (0..=between).rev() {
            if step.relation == Relation::Part && parent != NONE {
                self.all[parent as usize].has_parts = true;
            }
            self.all.push(Entity {
                parent,
                relation: step.relation,
                class,
                index: last.map(|last| last - back),
                is_between: back > 0,
                has_parts: false,
                line: index_u32(number),
                values: NONE,
            });
            parent = index_u32(self.all.len() - 1);
        }
        Ok(parent)
    }
}
