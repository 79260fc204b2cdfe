//! `spinney run`: a scene's frames, and what they cost.

use std::path::{Path, PathBuf};

use super::arguments::{Drawing, RunOptions, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::terminal::Terminal;
use crate::raster::Counters;
use crate::report::{RunFolder, RunHeader, frame_layers, run_notes, run_table};
use crate::run::{PlantFiles, Progress as _, Session};
use crate::scene::to_toml;

/// Rows of frames in the closing table.
const TABLE_ROWS: usize = 20;

pub(super) fn run(
    options: &RunOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let drawing = &options.drawing;
    let prepared = Prepared::new(
        &options.scene,
        Some(drawing),
        Counters::Visible,
        shared,
        terminal,
        &progress,
    )?;
    let (scene, world) = (&prepared.scene, &prepared.world);
    let mut session = Session::new(scene, world, &prepared.options)?;
    let target = folder(shared, &scene.name);
    let from = options.scene.parent().unwrap_or(Path::new(""));
    let (resolved, plants) = PlantFiles::gather(scene, from)?;
    let header = RunHeader {
        scene: scene.name.clone(),
        scene_digest: resolved.digest(),
        model: prepared.options.kind.label(),
        link: prepared.options.link,
        card: prepared.options.card,
        size: [scene.size.width(), scene.size.height()],
        samples: scene.samples.get(),
        resolved: to_toml(&resolved),
        resident: session.device().resident_by_label(),
    };
    let mut folder = RunFolder::create(&target, header, session.initial())?;
    folder.add_plants(&plants)?;
    drop(plants);
    let last = drawing
        .frames
        .as_ref()
        .map_or(scene.frames, |frames| frames.end);
    progress.begin("frames", u64::from(last));
    for number in 0..last {
        if wanted(drawing, number) {
            let frame = session.frame(number)?;
            folder.add(&frame)?;
            if options.layers {
                let (kind, model) = (prepared.options.kind, prepared.options.model);
                let layers = frame_layers(&session, world, kind, model, &frame);
                folder.add_layers(number, layers)?;
            }
        } else {
            session.skip(number)?;
        }
        progress.step();
    }
    drop(progress);
    let rows = folder.finish()?;
    if shared.json {
        let path = target.join("ledger.json");
        let ledger = std::fs::read_to_string(&path).map_err(|problem| CliError::Write {
            place: path.display().to_string(),
            problem: problem.to_string(),
        })?;
        return terminal.print(&ledger);
    }
    let mut text = run_table(&rows, TABLE_ROWS).to_text(terminal.width());
    text.push('\n');
    for note in run_notes(&rows, prepared.options.link) {
        text.push_str(&terminal.wrapped(&note));
    }
    text.push_str(&format!(
        "\n{}: pictures, ledger and report.html\n",
        target.display()
    ));
    terminal.print(&text)
}

/// Whether a frame is drawn, or only selected and committed.
fn wanted(drawing: &Drawing, frame: u32) -> bool {
    let in_range = drawing
        .frames
        .as_ref()
        .is_none_or(|frames| frames.contains(&frame));
    in_range
        && drawing
            .shard
            .is_none_or(|shard| frame % shard.count == shard.index)
}

/// Where a scene's output goes.
pub(super) fn folder(shared: &Shared, name: &str) -> PathBuf {
    shared
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join(name))
}
