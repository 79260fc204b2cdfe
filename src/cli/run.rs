//! `spinney run`: a scene's frames, and what they cost.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::arguments::{Drawing, RunOptions, Shared};
use super::error::CliError;
use super::frame_folder::FrameFolder;
use super::prepare::Prepared;
use super::terminal::Terminal;
use crate::gpu::Link;
use crate::raster::Counters;
use crate::report::{
    FrameRow, PathEntry, RunFolder, RunHeader, RunShare, frame_layers, run_notes, run_table,
};
use crate::run::{PlantFiles, PopMeter, Progress as _, Session, Shard};
use crate::scene::{Scene, to_toml};

/// Rows of frames in the closing table.
const TABLE_ROWS: usize = 20;

pub(super) fn run(
    options: &RunOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let progress = terminal.progress();
    let drawing = &options.drawing;
    let mut prepared = Prepared::new(
        &options.scene,
        Some(drawing),
        Counters::Visible,
        shared,
        terminal,
        &progress,
    )?;
    if options.budget_bytes.is_some() {
        prepared.scene.model.budget_bytes = options.budget_bytes;
    }
    if let Some(hysteresis) = options.hysteresis {
        prepared.scene.model.hysteresis = hysteresis;
    }
    let (scene, world) = (&prepared.scene, &prepared.world);
    let mut session = Session::new(scene, world, &prepared.options)?;
    let target = folder(shared, &scene.name);
    let mut export = match &options.export_frame {
        None => None,
        Some(folder) => Some(FrameFolder::create(folder, &target)?),
    };
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
    let frames = frames(drawing, scene);
    if let Some(shard) = drawing.shard {
        folder.share(&RunShare {
            shard,
            frames: frames.clone(),
            layers: options.layers,
            popping: options.popping,
            exact: prepared.options.raster.counters == Counters::Exact,
        })?;
    }
    let mut meter = match options.popping {
        false => None,
        true => Some(PopMeter::new(scene, world, &prepared.options)?),
    };
    let shard = drawing.shard.unwrap_or(Shard::WHOLE);
    progress.begin("frames", u64::from(frames.end));
    for number in 0..frames.end {
        if frames.contains(&number) && shard.draws(number) {
            let mut frame = session.frame(number)?;
            if let Some(meter) = &mut meter {
                frame.popping = meter.frame(number, &frame.states, &session.drawn()?)?;
            }
            folder.add(&frame)?;
            if options.layers {
                let (kind, model) = (prepared.options.kind, prepared.options.model);
                let layers = frame_layers(&session, world, kind, model, &frame);
                folder.add_layers(number, layers)?;
            }
            if let Some(export) = &mut export {
                export.add(scene, world, &prepared.options, &frame)?;
            }
        } else {
            session.skip(number)?;
            if let Some(meter) = &mut meter {
                meter.skip(number, &session.states());
            }
        }
        progress.step();
    }
    drop(progress);
    let path = folder.path();
    let rows = folder.finish()?;
    if let Some(export) = export {
        export.finish()?;
    }
    let link = prepared.options.link;
    closing((&rows, path.as_ref()), link, &target, shared, terminal)
}

/// Says what a run cost and where it lies.
pub(super) fn closing(
    (rows, path): (&[FrameRow], Option<&PathEntry>),
    link: Link,
    target: &Path,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    if shared.json {
        let path = target.join("ledger.json");
        let ledger = std::fs::read_to_string(&path).map_err(|problem| CliError::Write {
            place: path.display().to_string(),
            problem: problem.to_string(),
        })?;
        return terminal.print(&ledger);
    }
    let mut text = run_table(rows, TABLE_ROWS).to_text(terminal.width());
    text.push('\n');
    let path = path.map(PathEntry::note);
    for note in run_notes(rows, link).into_iter().chain(path) {
        text.push_str(&terminal.wrapped(&note));
    }
    text.push_str(&format!(
        "\n{}: pictures, ledger and report.html\n",
        target.display()
    ));
    terminal.print(&text)
}

/// The frames of all shards together.
fn frames(drawing: &Drawing, scene: &Scene) -> Range<u32> {
    drawing.frames.clone().unwrap_or(0..scene.frames)
}

/// Where a scene's output goes.
pub(super) fn folder(shared: &Shared, name: &str) -> PathBuf {
    shared
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join(name))
}
