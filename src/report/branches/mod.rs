//! Branches at a list of errors: tables, a sheet of pictures, skeletons, curves.
//!
//! ```text
//! run::branches ─▶ BranchLook, BranchModeCost, BranchStep ─▶ BranchReport ─▶ write_branches
//!    levels.csv, modes.csv, steps.csv, methods.csv     sheet.png: a row an order of removal, a picture an error
//!    pictures/*.png: all, polygons, lines     skeletons/*.svg     plots/edges.svg, plots/steps.svg
//! ```
//!
//! **Invariant.** Bytes of different streams are never added; modelled times are.

mod methods;
mod skeleton;
mod table;

pub use methods::method_table;
pub use table::{branch_level_table, branch_mode_table, branch_step_table, branch_text};

use super::axis::{Axis, Scale};
use super::plot::{Plot, Series};
use super::{OutputFolder, Picture, ReportError, sheet};
use crate::run::{BranchLook, BranchModeCost, BranchStep, MethodFound, StudyWay, edge_curves};

/// Everything that was found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BranchReport {
    /// The levels, finest first; after all of one order of removal those of the next.
    pub looks: Vec<BranchLook>,
    /// What modes take.
    pub modes: Vec<BranchModeCost>,
    /// The steps along the path.
    pub steps: Vec<BranchStep>,
    /// Every model beside the others.
    pub methods: Vec<MethodFound>,
}

/// A name for a level's files, such as `0.0387m` or `0.0387m-pruned`.
fn name(look: &BranchLook) -> String {
    let error = look.level.asked;
    match look.level.way {
        StudyWay::Error => format!("{error}m"),
        StudyWay::Pruning => format!("{error}m-pruned"),
    }
}

/// Writes everything into a folder.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_branches(folder: &OutputFolder, report: &BranchReport) -> Result<(), ReportError> {
    for (name, table) in [
        ("levels.csv", branch_level_table(report)),
        ("modes.csv", branch_mode_table(report)),
        ("steps.csv", branch_step_table(report)),
        ("methods.csv", method_table(&report.methods)),
    ] {
        if !table.rows.is_empty() {
            folder.write(name, table.to_csv().as_bytes())?;
        }
    }
    let mut rows: Vec<Vec<Picture>> = Vec::new();
    for look in &report.looks {
        let name = name(look);
        for (which, kind) in ["", "-polygons", "-lines"].into_iter().enumerate() {
            let png = picture(look, which)?.to_small_png()?;
            folder.write(&format!("pictures/{name}{kind}.png"), &png)?;
        }
        let svg = skeleton::to_svg(look);
        folder.write(&format!("skeletons/{name}.svg"), svg.as_bytes())?;
        let is_first_of_row = look.level.asked == report.looks[0].level.asked;
        if is_first_of_row || rows.is_empty() {
            rows.push(Vec::new());
        }
        if let Some(row) = rows.last_mut() {
            row.push(picture(look, 0)?);
        }
    }
    if let Some(sheet) = sheet::of(&rows)? {
        folder.write("sheet.png", &sheet.to_small_png()?)?;
    }
    folder.write("plots/edges.svg", edge_plot().to_svg().as_bytes())?;
    if !report.steps.is_empty() {
        let plot = step_plot(&report.steps);
        folder.write("plots/steps.svg", plot.to_svg().as_bytes())?;
    }
    Ok(())
}

/// The picture of all, of polygons or of lines.
fn picture(look: &BranchLook, which: usize) -> Result<Picture, ReportError> {
    let image = &look.images[which];
    Picture::new(image.width, image.height, image.rgba.clone())
}

/// Figure 5 of [ZBMJLDC17](crate::references): how many edges a circle has by its error as a share of the
/// radius, and the curve above which these steps stay.
#[must_use]
pub fn edge_plot() -> Plot {
    let [steps, curve] = edge_curves();
    let series = |name: &str, points| Series {
        name: name.to_owned(),
        points,
    };
    Plot {
        title: "Edges of a circle by the error of its polygon".to_owned(),
        x: linear("error / radius"),
        y: linear("edges"),
        series: vec![
            series("edges, at most 16", steps),
            series("parts of edges", curve),
        ],
    }
}

fn linear(label: &str) -> Axis {
    Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
    }
}

/// How much frames differ from the one before.
fn step_plot(steps: &[BranchStep]) -> Plot {
    let series = |name: &str, value: fn(&BranchStep) -> f64| Series {
        name: name.to_owned(),
        points: steps
            .iter()
            .map(|step| [f64::from(step.frame), value(step)])
            .collect(),
    };
    Plot {
        title: "Difference to the frame before".to_owned(),
        x: linear("frame"),
        y: linear("mean difference, of 255"),
        series: vec![
            series("errors by distance", |step| step.by_distance),
            series("finest error", |step| step.finest),
        ],
    }
}
