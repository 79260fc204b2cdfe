//! Multi-scale tree graphs: plants as digitized by hand, entity by entity.
//!
//! ```text
//! CODE:      FORM-A
//! CLASSES:   SYMBOL SCALE …          lines ─Table─▶ Entities ─Shape─▶ Wood, leaves ─▶ Skeleton, Foliage
//! FEATURES:  NAME TYPE                 (who bears whom)  (where)          (placing)
//! MTG:
//! ENTITY-CODE     XX   YY   ZZ   TopDia
//! /P1/A1          0    0    0
//!     ^/S1        0    0    20   12         `/` the first part of an entity, at a finer scale
//!     ^<S2<<S5    0    0    80   9          `<` the next on its axis, `<<` with those between
//!             +A1 5    0    83   4          `+` a branch
//! ```
//!
//! A leading `^` goes on from the last entity of its column, any other line hangs on the last one of a column
//! to its left. An entity with parts is where its first part begins; one without parts is a segment that ends
//! at its position, as thick there as its diameter says.
//!
//! Tabs separate cells; texts are UTF-8, or else Latin-1. Up is +Z. Files do not say their unit: it is guessed by
//! the plant's height.

mod entities;
mod shape;
mod steps;
mod table;
mod units;

#[cfg(test)]
mod tests;

use std::borrow::Cow;

use super::placing::place;
use super::wood::{plant, trunk};
use super::{ImportError, ImportOptions, ImportReport, Source};
use crate::plant::Plant;
use entities::Entities;
use shape::Shape;

/// Reads a multi-scale tree graph.
///
/// Leaves are what the options name by class, or else classes that are called so; and what entities tell by
/// number or area.
///
/// # Errors
///
/// When the file has no section MTG or no columns of positions, a line hangs on nothing, an entity's name or a
/// number is not one, there are too many entities or leaves, or the options name a class that is not there.
pub(super) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let text = text(source.bytes());
    let entities = Entities::read(&text, source, report)?;
    let shape = Shape::of(&entities, source, options, report)?;
    let frame = shape.wood.stand(shape.frame, report);
    let grown = shape.wood.grow(&frame, report);
    let leaves = shape.leaves(&entities, &frame, &grown);
    let foliage = place(&grown.skeleton, &leaves, options.seed, source, report)?;
    let trunk = trunk(&grown.skeleton, report);
    plant(source, grown.skeleton, trunk, foliage)
}

/// A text that is UTF-8, or else Latin-1, of which every byte is a character.
fn text(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().copied().map(char::from).collect()),
    }
}
