//! How much a switch of levels shows.

use serde_json::{Value, json};

use crate::report::{
    Cell, Column, PictureView, QualitySummary, ReportError, Spread, Table, ViewQuality, decimal,
};
use crate::run::{SwitchLook, ViewScale};

/// What switches do to the picture at one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchQuality {
    /// How many impostors the finer and the coarser level have.
    pub counts: [u32; 2],
    /// Which scale of the header's.
    pub scale: usize,
    /// The switch alone: the last step of the way against the coarser level.
    pub switch: StepChange,
    /// The last step before it, 1/256 of the way.
    pub step: StepChange,
    /// All of it at once: the finer level against the coarser.
    pub whole: StepChange,
}

/// What goes from one picture to another, over all directions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepChange {
    /// Pixels of another colour.
    pub changed: u64,
    /// Pixels that show a card in either picture.
    pub shown: u64,
    /// The pictures against each other, direction by direction.
    views: Vec<ViewQuality>,
}

impl StepChange {
    fn add(&mut self, [before, after]: [&PictureView; 2]) -> Result<(), ReportError> {
        let [one, other] =
            [before, after].map(|view| view.picture.rgba().as_chunks::<4>().0.iter());
        self.changed += one.zip(other).filter(|(one, other)| one != other).count() as u64;
        let shown = before.leaves.iter().zip(&after.leaves);
        self.shown += shown.filter(|(one, other)| **one || **other).count() as u64;
        self.views.push(ViewQuality::between(before, after)?);
        Ok(())
    }

    /// Pixels of another colour, as a share of those that show a card.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.changed as f64 / self.shown.max(1) as f64
    }

    /// FLIP over the directions.
    #[must_use]
    pub fn flip(&self) -> Spread {
        QualitySummary::of(&self.views).flip
    }
}

/// Adds a look to what was found, which has those of one switch and scale one after another.
pub(super) fn add(found: &mut Vec<SwitchQuality>, look: SwitchLook) -> Result<(), ReportError> {
    let SwitchLook {
        counts,
        scale,
        leaving,
        last_but_one,
        last,
        entering,
    } = look;
    let views = [leaving, last_but_one, last, entering].map(PictureView::of);
    let [leaving, last_but_one, last, entering] = views;
    let (leaving, last_but_one, last, entering) = (leaving?, last_but_one?, last?, entering?);
    let is_same = |one: &SwitchQuality| (one.counts, one.scale) == (counts, scale);
    if !found.last().is_some_and(is_same) {
        found.push(SwitchQuality {
            counts,
            scale,
            switch: StepChange::default(),
            step: StepChange::default(),
            whole: StepChange::default(),
        });
    }
    let Some(quality) = found.last_mut() else {
        return Ok(());
    };
    quality.switch.add([&last, &entering])?;
    quality.step.add([&last_but_one, &last])?;
    quality.whole.add([&leaving, &entering])
}

/// A row a switch and scale.
#[must_use]
pub fn switch_table(switches: &[SwitchQuality], scales: &[ViewScale]) -> Table {
    let columns = [
        "the switch, px",
        "% of shown",
        "FLIP (worst)",
        "a step before, px",
        "% of shown",
        "FLIP (worst)",
        "all at once, px",
        "% of shown",
        "FLIP (worst)",
    ];
    let row = |switch: &SwitchQuality| {
        let [from, to] = switch.counts;
        let scale = scales.get(switch.scale).map_or("", |scale| scale.name);
        let mut cells = vec![
            Cell::Text(format!("{from} to {to}")),
            Cell::Text(scale.to_owned()),
        ];
        for change in [&switch.switch, &switch.step, &switch.whole] {
            let Spread { mean, worst } = change.flip();
            cells.extend([
                Cell::Count(change.changed),
                Cell::Number {
                    value: 100.0 * change.share(),
                    digits: 1,
                },
                Cell::Text(format!("{} ({})", decimal(mean, 4), decimal(worst, 4))),
            ]);
        }
        cells
    };
    Table {
        columns: ["impostors", "scale"]
            .into_iter()
            .map(Column::words)
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
        rows: switches.iter().map(row).collect(),
    }
}

/// What the table tells.
pub(super) const CAPTION: &str = "Pixels of another colour, and FLIP, over 8 directions: by the switch alone, where impostors \
     that were moved into the planes of the next level are swapped for those; by the step of 1/256 of the way \
     before it; and if there were no way, but all at once.";

/// The same for programs.
pub(super) fn switch_json(switches: &[SwitchQuality], scales: &[ViewScale]) -> Value {
    let change = |change: &StepChange| {
        let Spread { mean, worst } = change.flip();
        json!({
            "changed_pixels": change.changed,
            "shown_pixels": change.shown,
            "flip": { "mean": mean, "worst": worst },
        })
    };
    let entry = |switch: &SwitchQuality| {
        json!({
            "from": switch.counts[0],
            "to": switch.counts[1],
            "scale": scales.get(switch.scale).map_or("", |scale| scale.name),
            "switch": change(&switch.switch),
            "step_before": change(&switch.step),
            "all_at_once": change(&switch.whole),
        })
    };
    switches.iter().map(entry).collect()
}
