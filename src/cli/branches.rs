//! `spinney branches`: wood and needles as polygons and lines, at a list of errors.

use super::Verdict;
use super::arguments::{BranchArguments, BranchPart, Drawing, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::raster::Counters;
use crate::report::{
    BranchReport, OutputFolder, branch_text, transparency_text, write_branches, write_transparency,
};
use crate::run::{
    BranchStudy, World, branch_looks, branch_modes, branch_steps, helix, methods,
    transparency_looks,
};
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
    let parts = parts(options, &prepared.scene)?;
    let target = folder(shared, &format!("{}-branches", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let study = BranchStudy {
        errors: options.errors.clone(),
        session: prepared.options,
    };
    let (scene, world): (&Scene, &World) = (&prepared.scene, &prepared.world);
    let mut report = BranchReport::default();
    let mut transparency = Vec::new();
    for part in &parts {
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
            BranchPart::Transparency => {
                transparency = transparency_looks(scene, world, &study.session, &progress)?;
            }
        }
    }
    drop(progress);
    write_branches(&output, &report)?;
    write_transparency(&output, &transparency)?;
    output.commit()?;
    let mut text = branch_text(&report, terminal.width());
    text += &transparency_text(&transparency, terminal.width());
    let contents = match (report == BranchReport::default(), transparency.is_empty()) {
        (true, false) => "details.png, pictures, differences and a table",
        _ => "sheet.png, pictures, skeletons, plots and tables",
    };
    text.push_str(&format!("\n{}: {contents}\n", target.display()));
    terminal.print(&text)?;
    Ok(Verdict::Passed)
}

/// What is asked for, or what suits the scene.
fn parts(options: &BranchArguments, scene: &Scene) -> Result<Vec<BranchPart>, CliError> {
    let parts = match (options.parts.is_empty(), scene.grove) {
        (false, _) => options.parts.clone(),
        (true, Some(_)) => vec![BranchPart::Transparency],
        (true, None) => vec![BranchPart::Levels, BranchPart::Modes],
    };
    if parts.contains(&BranchPart::Transparency) && scene.grove.is_none() {
        let problem = "the part \"transparency\" needs a scene with a table [grove]";
        return Err(CliError::Usage(problem.to_owned()));
    }
    Ok(parts)
}
