//! Quantitative structure models: wood that was fitted to scanned trees, cylinder by cylinder.
//!
//! ```text
//!  text ─Rows─▶ cells ─┬─Layout──▶ cylinders of TreeQSM, SimpleForest, aRchi ─┐
//!                      └─fields──▶ nodes of raycloudtools ────────────────────┴▶ Wood
//! ```
//!
//! | format | id | root's parent | a line holds |
//! |---|---|---|---|
//! | `TreeQSM` | the line's number, from 1 | 0 | start, unit axis, length, radius |
//! | `SimpleForest` | a column, from 0 | −1 | start, end, radius |
//! | aRchi | a column, from 1 | 0 | start, end, radius |
//! | raycloudtools | the place in the line, from 0 | −1 | a whole tree: tip and radius of each node |
//!
//! All are in metres with +Z up, and hold no leaves. A cylinder's radius is constant: where one follows
//! another, the joint has the later one's.

mod cylinders;
mod layout;
mod rows;
mod treefile;

#[cfg(test)]
mod tests;

pub(super) use cylinders::read as read_cylinders;
pub(super) use treefile::read as read_treefile;

use super::frame::{Frame, Unit, UpAxis};
use super::wood::{Wood, plant, trunk};
use super::{ImportError, ImportOptions, ImportReport, Source};
use crate::plant::{Foliage, Plant};

/// The plant of a model's wood.
fn plant_of(
    wood: &Wood,
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    if let Some(name) = options.foliage.first() {
        return Err(ImportError::Name {
            file: source.file().to_owned(),
            name: name.clone(),
            known: "no leaves in this format".to_owned(),
        });
    }
    let frame = Frame::new(options.reading, UpAxis::Z, Unit::M);
    let frame = wood.stand(frame, report);
    let grown = wood.grow(&frame, report);
    let trunk = trunk(&grown.skeleton, report);
    plant(source, grown.skeleton, trunk, Foliage::default())
}
