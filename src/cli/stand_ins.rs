//! `spinney stand-ins`: what stands in for leaves, against leaves.

use super::Verdict;
use super::arguments::{Drawing, Shared, StandInArguments, StandInPart};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::models::Kind;
use crate::raster::Counters;
use crate::report::{
    OutputFolder, StandInHeader, StandInMeter, stand_in_json, stand_in_text, write_stand_ins,
};
use crate::run::{
    StandInOptions, TextureSetting, ViewScale, level_switches, stand_ins as look, texture_looks,
};
use crate::scene::{ModelName, Projection};

/// What a screen spans that a scene says nothing of, in degrees.
const USUAL_FIELD_OF_VIEW: f32 = 60.0;

pub(super) fn stand_ins(
    options: &StandInArguments,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let kinds = kinds(&options.models)?;
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
    if prepared.scene.model.name == ModelName::Flattened {
        let what = "the scene's leaves are flattened already; wanted another `model.name`";
        return Err(CliError::Usage(format!(
            "{}: {what}",
            options.scene.display()
        )));
    }
    let target = folder(shared, &format!("{}-stand-ins", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let asked = StandInOptions {
        kinds,
        counts: options.planes.clone(),
        scales: ViewScale::ALL.to_vec(),
        radii: [4.0, 0.5 * prepared.scene.size.height() as f32],
        session: prepared.options,
        field_of_view: match prepared.scene.camera.projection() {
            Projection::Perspective {
                vertical_field_of_view,
            } => vertical_field_of_view,
            Projection::Orthographic { .. } => USUAL_FIELD_OF_VIEW,
        },
    };
    let plant = prepared.world.plants.first();
    let mut meter = StandInMeter::new(StandInHeader {
        scene: prepared.scene.name.clone(),
        plant: plant.map_or_else(String::new, |plant| plant.name().to_owned()),
        link: prepared.options.link,
        card: prepared.options.card,
        height: prepared.scene.size.height(),
        field_of_view: asked.field_of_view,
        scales: asked.scales.clone(),
    });
    for part in &options.parts {
        let world = &prepared.world;
        match part {
            StandInPart::Looks => {
                let take = |found| -> Result<(), CliError> { Ok(meter.add(found)?) };
                look(world, &asked, &progress, take)?;
            }
            StandInPart::Switches => {
                let take = |found| -> Result<(), CliError> { Ok(meter.add_switch(found)?) };
                level_switches(world, &asked, &progress, take)?;
            }
            StandInPart::Textures => {
                let settings = TextureSetting::usual();
                let take = |found| -> Result<(), CliError> { Ok(meter.add_textures(found)?) };
                texture_looks(world, &settings, &asked, &progress, take)?;
            }
        }
    }
    drop(progress);
    let report = meter.finish();
    write_stand_ins(&output, &report)?;
    output.commit()?;
    if shared.json {
        terminal.print(&stand_in_json(&report))?;
    } else {
        let mut text = stand_in_text(&report, terminal.width());
        text.push_str(&format!(
            "\n{}: sheet.png, plots, tables and report.html\n",
            target.display()
        ));
        terminal.print(&text)?;
    }
    Ok(Verdict::Passed)
}

/// The kinds that are asked for by name.
fn kinds(labels: &[String]) -> Result<Vec<Kind>, CliError> {
    let kind = |label: &String| {
        let is_card = |kind: &Kind| !kind.shows_leaves() && !kind.paints();
        let is_stand_in = |kind: &Kind| is_card(kind) || *kind == Kind::LodfHost;
        Kind::labelled(label).filter(is_stand_in).ok_or_else(|| {
            let known = Kind::ALL.into_iter().filter(is_stand_in);
            let known: Vec<String> = known.map(Kind::label).collect();
            CliError::Usage(format!(
                "--models: {label:?} stands for no leaves; known are {}",
                known.join(", ")
            ))
        })
    };
    labels.iter().map(kind).collect()
}
