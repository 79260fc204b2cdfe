//! Ways to draw the lines of a forest: a table, pictures, and where they differ from the truth.
//!
//! ```text
//! run::transparency ─▶ TransparencyLook ─▶ write_transparency
//!    transparency.csv     pictures/NAME.png     differences/NAME.png, in false colours     legend.svg
//!    details.png: a row a way; of two windows each the truth, the way and the difference
//! ```
//!
//! **Invariant.** Bytes of different streams are never added; modelled times are.

mod false_colour;
mod windows;

use self::windows::Window;
use super::{Cell, Column, OutputFolder, Picture, ReportError, Table, sheet};
use crate::gpu::{Ledger, nanoseconds};
use crate::run::TransparencyLook;

/// The greatest difference of intensity, of 255, that is hardly seen.
const SMALL: u8 = 8;

/// A row a way: how it draws, what that takes, and how many pixels are wrong.
#[must_use]
pub fn transparency_table(looks: &[TransparencyLook]) -> Table {
    let numbers = [
        "levels a pass",
        "passes",
        "draws",
        "sent, B",
        "read back, B",
        "fragments",
        "blended or won",
        "modelled, ns",
        "wrong, > 0",
        "wrong, > 8",
        "naive / wrong, > 0",
        "naive / wrong, > 8",
    ];
    let words = ["way", "packing", "order", "blend"];
    let row = |look: &TransparencyLook| {
        let choice = look.way.choice;
        let text = |text: &str| Cell::Text(text.to_owned());
        let naive = looks
            .iter()
            .find(|naive| naive.is_naive() && naive.way.samples == look.way.samples);
        let times_fewer = |above: u8| match (naive, look.errors(above)) {
            (Some(naive), wrong @ 1..) => Cell::Number {
                value: naive.errors(above) as f64 / wrong as f64,
                digits: 2,
            },
            _ => Cell::Missing,
        };
        vec![
            text(look.way.name),
            text(choice.packing.name()),
            text(choice.order.name()),
            text(choice.blend.name()),
            Cell::Count(u64::from(choice.levels_a_pass)),
            Cell::Count(look.passes as u64),
            Cell::Count(look.frame.draws),
            Cell::Count(look.frame.upload.payload_bytes),
            Cell::Count(look.frame.readback.payload_bytes),
            (look.frame.work.as_ref()).map_or(Cell::Missing, |work| Cell::Count(work.covered)),
            Cell::Count(look.frame.visible_samples),
            frame_ns(&look.frame).map_or(Cell::Missing, Cell::Count),
            Cell::Count(look.errors(0)),
            Cell::Count(look.errors(SMALL)),
            times_fewer(0),
            times_fewer(SMALL),
        ]
    };
    Table {
        columns: (words.into_iter().map(Column::words))
            .chain(numbers.into_iter().map(Column::numbers))
            .collect(),
        rows: looks.iter().map(row).collect(),
    }
}

/// Modelled time of a frame, in nanoseconds: transfers both ways, fetches, then the card.
fn frame_ns(frame: &Ledger) -> Option<u64> {
    Some(nanoseconds(frame.frame_ticks()? + frame.readback.ticks))
}

/// The table for a terminal of so many columns.
#[must_use]
pub fn transparency_text(looks: &[TransparencyLook], width: usize) -> String {
    if looks.is_empty() {
        return String::new();
    }
    transparency_table(looks).to_text(width)
}

/// Writes everything into a folder.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_transparency(
    folder: &OutputFolder,
    looks: &[TransparencyLook],
) -> Result<(), ReportError> {
    let Some(naive) = looks.iter().find(|look| look.is_naive()) else {
        return Ok(());
    };
    let table = transparency_table(looks);
    folder.write("transparency.csv", table.to_csv().as_bytes())?;
    folder.write("legend.svg", false_colour::legend().as_bytes())?;
    let size = [naive.image.width, naive.image.height];
    let windows: [Window; 2] = windows::worst(size, &naive.differences);
    let mut rows = Vec::with_capacity(looks.len());
    for look in looks {
        let name = file_name(look.way.name);
        let shown = picture(look)?;
        folder.write(&format!("pictures/{name}.png"), &shown.to_small_png()?)?;
        let truth = looks
            .iter()
            .find(|truth| truth.is_truth() && truth.way.samples == look.way.samples);
        let Some(truth) = truth.filter(|_| !look.is_truth()) else {
            continue;
        };
        let truth = picture(truth)?;
        let differs = false_colour::picture(look.image.width, &look.differences)?;
        folder.write(&format!("differences/{name}.png"), &differs.to_small_png()?)?;
        let mut row = Vec::with_capacity(6);
        for window in windows {
            for picture in [&truth, &shown, &differs] {
                row.push(window.of(picture)?);
            }
        }
        rows.push(row);
    }
    if let Some(details) = sheet::of(&rows)? {
        folder.write("details.png", &details.to_small_png()?)?;
    }
    Ok(())
}

fn picture(look: &TransparencyLook) -> Result<Picture, ReportError> {
    let image = &look.image;
    Picture::new(image.width, image.height, image.rgba.clone())
}

/// A way's name in letters that any file may have.
fn file_name(name: &str) -> String {
    name.replace(", ", "-").replace(' ', "_")
}
