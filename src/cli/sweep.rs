//! `spinney sweep`: the axis of detail, for several models side by side.

use std::path::Path;

use super::arguments::{Shared, SweepOptions};
use super::bytes;
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::gpu::Card;
use crate::models::{Kind, TrunkKind};
use crate::raster::Counters;
use crate::report::{
    OutputFolder, QualityMeter, SweepHeader, SweepPictures, SweepQuality, SweepShare, sweep_json,
    sweep_text, write_sweep, write_sweep_shard,
};
use crate::run::{self, LookOptions, Shard, Sweep, Variant};
use crate::scene::to_toml;

pub(super) fn sweep(
    options: &SweepOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let variants = variants(&options.models)?;
    if options.bytes {
        return bytes::bytes(options, variants, shared, terminal);
    }
    let progress = terminal.progress();
    let prepared = Prepared::new(
        &options.scene,
        Some(&options.drawing),
        Counters::Exact,
        shared,
        terminal,
        &progress,
    )?;
    let target = folder(shared, &format!("{}-sweep", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let header = SweepHeader {
        scene: prepared.scene.name.clone(),
        link: prepared.options.link,
        card: prepared.options.card,
        resolved: to_toml(&prepared.scene),
    };
    let shard = options.drawing.shard.unwrap_or(Shard::WHOLE);
    let walk = run::SweepOptions {
        variants: variants.unwrap_or_else(|| all_on(prepared.options.card)),
        steps: options.steps,
        shard,
        session: prepared.options,
    };
    let mut pictures = SweepPictures::default();
    let see = |at, frame: &run::Frame| -> Result<(), CliError> { Ok(pictures.add(at, frame)?) };
    let sweep = run::sweep_seen(&prepared.scene, &prepared.world, &walk, &progress, see)?;
    let quality = match options.quality {
        false => None,
        true => {
            let look = LookOptions {
                variants: walk.variants,
                steps: options.steps,
                looks: options.quality_steps,
                shard,
                session: prepared.options,
            };
            let mut meter = QualityMeter::default();
            let take = |look| -> Result<(), CliError> { Ok(meter.add(look)?) };
            run::looks(&prepared.scene, &prepared.world, &look, &progress, take)?;
            Some(meter.finish())
        }
    };
    drop(progress);
    let quality = quality.as_ref();
    write_sweep(&output, &header, &sweep, quality, &pictures)?;
    if let Some(shard) = options.drawing.shard {
        let looks = options.quality.then_some(options.quality_steps);
        let share = SweepShare {
            shard,
            scene_digest: prepared.scene.digest(),
            exact: prepared.options.raster.counters == Counters::Exact,
            steps: options.steps,
            looks,
        };
        write_sweep_shard(&output, &header, share, &sweep, quality, &pictures)?;
    }
    output.commit()?;
    closing(&header, &sweep, quality, &target, shared, terminal)
}

/// Says what a walk cost and where it lies.
pub(super) fn closing(
    header: &SweepHeader,
    sweep: &Sweep,
    quality: Option<&SweepQuality>,
    target: &Path,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    if shared.json {
        return terminal.print(&sweep_json(header, sweep, quality));
    }
    let mut text = sweep_text(sweep, quality, terminal.width());
    text.push_str(&format!(
        "\n{}: plots, tables and report.html\n",
        target.display()
    ));
    terminal.print(&text)
}

/// All that a card can do.
fn all_on(card: Card) -> Vec<Variant> {
    let all = Variant::ALL.into_iter();
    all.filter(|variant| variant.runs_on(card)).collect()
}

/// The variants that are asked for by name.
fn variants(labels: &[String]) -> Result<Option<Vec<Variant>>, CliError> {
    if labels.is_empty() {
        return Ok(None);
    }
    let variant = |label: &String| {
        Variant::labelled(label).ok_or_else(|| {
            let known: Vec<String> = Variant::ALL.iter().map(|variant| variant.label()).collect();
            let trunks: Vec<String> = TrunkKind::all().map(TrunkKind::label).collect();
            CliError::Usage(format!(
                "--models: {label:?} is unknown; known are {}, lodf-literal, each with \
                 levels also with -pruned after its mode, such as {}, and each also with a trunk, such as \
                 {}+{}: {}",
                known.join(", "),
                Variant::usual(Kind::LodfSlots).pruned().compact().label(),
                known[0],
                trunks[0],
                trunks.join(", ")
            ))
        })
    };
    labels
        .iter()
        .map(variant)
        .collect::<Result<_, _>>()
        .map(Some)
}
