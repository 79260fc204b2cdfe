//! `spinney paint`: a painted plant at its levels, as the paper's figures and table have it.

use super::Verdict;
use super::arguments::{Drawing, PaintArguments, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::models::Painting;
use crate::raster::Counters;
use crate::report::{
    OutputFolder, PUBLISHED_PAINTING, PaintHeader, PaintReport, paint_text, write_painting,
};
use crate::run::{PaintStudy, shimmer};
use crate::scene::{PaintOptions, PaintReach, PaintRows, Projection};
use crate::simplify::strokes::extract;

/// Branches and leaves of the paper's test tree.
const PUBLISHED_TREE: [usize; 2] = [9841, 8748];

pub(super) fn paint(
    options: &PaintArguments,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let drawing = Drawing {
        size: options.size,
        samples: None,
        frames: None,
        counters: None,
        shard: None,
    };
    let progress = terminal.progress();
    let prepared = Prepared::new(
        &options.scene,
        Some(&drawing),
        Counters::Exact,
        shared,
        terminal,
        &progress,
    )?;
    let study = PaintStudy::of(&prepared.scene, &prepared.world, &prepared.options);
    let study = study
        .ok_or_else(|| CliError::Usage(format!("{}: wanted a tree", options.scene.display())))?;
    let target = folder(shared, &format!("{}-painted", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let plant = study.plant();
    let branches = plant
        .skeleton()
        .map_or(0, |skeleton| skeleton.branches.len());
    let is_published = [branches, plant.foliage().leaf_count()] == PUBLISHED_TREE;
    let published = PUBLISHED_PAINTING.map(|level| level.branches);
    let levels = study.levels(is_published.then_some(&published[..]));
    let mut pictures = Vec::new();
    study.figures(&levels, &progress, |picture| pictures.push(picture))?;
    let report = PaintReport {
        header: PaintHeader {
            scene: prepared.scene.name.clone(),
            plant: plant.name().to_owned(),
            camera: (
                [prepared.scene.size.width(), prepared.scene.size.height()],
                match prepared.scene.camera.projection() {
                    Projection::Perspective {
                        vertical_field_of_view,
                    } => vertical_field_of_view,
                    Projection::Orthographic { .. } => 0.0,
                },
            ),
            near: study.near(),
            link: prepared.options.link,
            card: prepared.options.card,
            is_published,
        },
        mixed: if is_published {
            mixed(&study)
        } else {
            Vec::new()
        },
        costs: study.costs(&levels)?,
        storage: study.storage(),
        shimmer: if options.steps > 0 {
            shimmer(&study, &[0.0, 0.25, 1.0], options.steps, &progress)?
        } else {
            Vec::new()
        },
        pictures,
        levels,
    };
    drop(progress);
    write_painting(&output, &report)?;
    output.commit()?;
    let mut text = paint_text(&report, terminal.width());
    text.push_str(&format!(
        "\n{}: figure-3.png, figure-4.png, figure-5.png, tables and report.html\n",
        target.display()
    ));
    terminal.print(&text)?;
    Ok(Verdict::Passed)
}

/// The other reading of figure 4: rows by plain thresholds, each number wanted met by the best mixture of two
/// rows.
fn mixed(study: &PaintStudy) -> Vec<u32> {
    let rows = PaintRows::new(PaintReach::Distances(&[100, 300, 900]), &[30, 60, 90]);
    let plain = PaintOptions {
        rows: rows.unwrap_or(PaintRows::USUAL),
        at_once: 8,
        inward: 0.0,
        ..*study.painting().options()
    };
    let painting = Painting::of(study.plant(), &plain);
    let wanted = PUBLISHED_PAINTING.map(|level| level.leaves);
    wanted
        .map(|wanted| extract(painting.levels(), wanted).strokes)
        .to_vec()
}
