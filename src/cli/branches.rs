//! `spinney branches`: wood and needles as polygons and lines, at a list of errors.

use super::Verdict;
use super::arguments::{BranchArguments, BranchPart, Drawing, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::raster::Counters;
use crate::report::{BranchReport, OutputFolder, branch_text, write_branches};
use crate::run::{BranchStudy, World, branch_looks, branch_modes, branch_steps, helix, methods};
use crate::scene::Scene;

pub(super) fn branches(
    options: &BranchArguments,
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
    let target = folder(shared, &format!("{}-branches", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let study = BranchStudy {
        errors: options.errors.clone(),
        session: prepared.options,
    };
    let (scene, world): (&Scene, &World) = (&prepared.scene, &prepared.world);
    let mut report = BranchReport::default();
    for part in &options.parts {
        let looks = &mut report.looks;
        let take = |look| -> Result<(), CliError> {
            looks.push(look);
            Ok(())
        };
        match part {
            BranchPart::Levels => branch_looks(scene, world, &study, &progress, take)?,
            BranchPart::Helix => {
                branch_looks(scene, &helix(world), &study, &progress, take)?;
            }
            BranchPart::Modes => report.modes = branch_modes(scene, world, &study, &progress)?,
            BranchPart::Methods => {
                report.methods = methods(scene, world, &study.session, &progress)?;
            }
            BranchPart::Steps => report.steps = branch_steps(scene, world, &study, &progress)?,
        }
    }
    drop(progress);
    write_branches(&output, &report)?;
    output.commit()?;
    let mut text = branch_text(&report, terminal.width());
    text.push_str(&format!(
        "\n{}: sheet.png, pictures, skeletons, plots and tables\n",
        target.display()
    ));
    terminal.print(&text)?;
    Ok(Verdict::Passed)
}
