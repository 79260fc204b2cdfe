//! The numbers in tables.

use super::{BranchReport, method_table};
use crate::gpu::{Ledger, nanoseconds};
use crate::report::{Cell, Column, Table};
use crate::run::{BranchLook, BranchStep, StudyWay};

/// A row a level: what is left of the first plant.
#[must_use]
pub fn branch_level_table(report: &BranchReport) -> Table {
    let columns = [
        "error, cm",
        "drawn, cm",
        "quads",
        "triangles",
        "lines",
        "needle polygons",
        "needle lines",
        "of the finest, %",
        "skeleton lines",
        "off by at most, cm",
        "draws",
        "frame, ns",
    ];
    let total = |look: &BranchLook| look.wood.total() + look.needles.total();
    let finest = report.looks.first().map_or(1, total).max(1);
    let row = |look: &BranchLook| {
        let removal = match look.level.way {
            StudyWay::Error => "by error",
            StudyWay::Pruning => "pruned by volume",
        };
        // Micrometres, so that what was written in decimals is shown in as few.
        let centimetres = |metres: f32| Cell::Number {
            value: (1e6 * f64::from(metres)).round() / 1e4,
            digits: 3,
        };
        vec![
            Cell::Text(removal.to_owned()),
            centimetres(look.level.asked),
            centimetres(look.level.step.error()),
            Cell::Count(look.wood.quads),
            Cell::Count(look.wood.triangles),
            Cell::Count(look.wood.lines),
            Cell::Count(look.needles.quads + look.needles.triangles),
            Cell::Count(look.needles.lines),
            Cell::Number {
                value: 100.0 * total(look) as f64 / finest as f64,
                digits: 2,
            },
            Cell::Count(look.internodes),
            match look.level.way {
                StudyWay::Error => centimetres(look.bound.to_level.max(look.bound.to_plant)),
                StudyWay::Pruning => Cell::Missing,
            },
            Cell::Count(look.frame.draws),
            (look.frame.frame_ticks().map(nanoseconds)).map_or(Cell::Missing, Cell::Count),
        ]
    };
    Table {
        columns: [Column::words("way")]
            .into_iter()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
        rows: report.looks.iter().map(row).collect(),
    }
}

/// A row a mode: what is kept, what changes send, and how long frames take.
#[must_use]
pub fn branch_mode_table(report: &BranchReport) -> Table {
    let columns = [
        "once a species, B",
        "once a tree, B",
        "host, B",
        "sent at first, B",
        "a change, mean B",
        "a change, most B",
        "vertices in",
        "bus, mean ns",
        "card, mean ns",
        "card, finest frame, ns",
    ];
    let rows = report.modes.iter().map(|cost| {
        let sent: Vec<u64> = cost
            .changes
            .iter()
            .map(|(_, ledger)| ledger.upload.payload_bytes)
            .collect();
        let count = (sent.len() as u64).max(1);
        let mean = |value: fn(&Ledger) -> u64| {
            let all = cost.changes.iter().map(|(_, ledger)| value(ledger));
            Cell::Count(all.sum::<u64>() / count)
        };
        let finest = cost.changes.last().and_then(|(_, ledger)| ledger.gpu_ticks);
        vec![
            Cell::Text(cost.kind.mode.name().to_owned()),
            Cell::Count(cost.storage.shared_bytes),
            Cell::Count(cost.storage.instance_bytes),
            Cell::Count(cost.storage.host_bytes),
            Cell::Count(cost.initial.upload.payload_bytes),
            Cell::Count(sent.iter().sum::<u64>() / count),
            Cell::Count(sent.iter().copied().max().unwrap_or(0)),
            mean(|ledger| ledger.vertices),
            mean(|ledger| nanoseconds(ledger.upload.ticks)),
            mean(|ledger| nanoseconds(ledger.gpu_ticks.unwrap_or(0))),
            finest.map_or(Cell::Missing, |ticks| Cell::Count(nanoseconds(ticks))),
        ]
    });
    Table {
        rows: rows.collect(),
        columns: [Column::words("mode")]
            .into_iter()
            .chain(columns.into_iter().map(Column::numbers))
            .collect(),
    }
}

/// A row a frame of the path: how much it differs from the one before.
#[must_use]
pub fn branch_step_table(report: &BranchReport) -> Table {
    let columns = [
        "frame",
        "error, cm",
        "by distance",
        "at the finest",
        "beyond",
    ];
    let number = |value: f64| Cell::Number { value, digits: 4 };
    let row = |step: &BranchStep| {
        vec![
            Cell::Count(u64::from(step.frame)),
            number(100.0 * f64::from(step.step.error())),
            number(step.by_distance),
            number(step.finest),
            number(step.by_distance - step.finest),
        ]
    };
    Table {
        columns: columns.into_iter().map(Column::numbers).collect(),
        rows: report.steps.iter().map(row).collect(),
    }
}

/// Everything for a terminal of so many columns; of the steps the worst.
#[must_use]
pub fn branch_text(report: &BranchReport, width: usize) -> String {
    let mut text = String::new();
    let tables = [
        branch_level_table(report),
        branch_mode_table(report),
        method_table(&report.methods),
    ];
    for table in tables {
        if !table.rows.is_empty() {
            text += &table.to_text(width);
            text.push('\n');
        }
    }
    let beyond = |step: &&BranchStep| step.by_distance - step.finest;
    let mut worst: Option<&BranchStep> = None;
    for step in &report.steps {
        if worst.is_none_or(|worst| beyond(&step) > beyond(&worst)) {
            worst = Some(step);
        }
    }
    if let Some(worst) = worst {
        text += &format!(
            "Worst step: frame {} differs from the one before by {:.4} of 255, {:.4} at the finest error\n",
            worst.frame, worst.by_distance, worst.finest
        );
    }
    text
}
