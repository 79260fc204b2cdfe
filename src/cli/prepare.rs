//! From a scene file and flags to a scene and its plants.

use std::path::Path;

use super::arguments::{CounterChoice, Drawing, Shared};
use super::cache::store;
use super::error::CliError;
use super::terminal::Terminal;
use crate::plant::SpeciesFile;
use crate::raster::{Counters, Options, TileSize};
use crate::run::{Progress, RunError, SessionOptions, StandingTree, World};
use crate::scene::{ImageSize, PlantSource, SampleCount, Scene, SceneFile, SceneSource};

/// A scene with the flags' overrides, and its plants.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) scene: Scene,
    pub(super) world: World,
    pub(super) options: SessionOptions,
}

impl Prepared {
    pub(super) fn new(
        path: &Path,
        drawing: Option<&Drawing>,
        counters: Counters,
        shared: &Shared,
        terminal: &Terminal,
        progress: &dyn Progress,
    ) -> Result<Self, CliError> {
        let SceneFile { mut scene, source } = SceneFile::read(path)?;
        if let Some(link) = shared.link {
            link.name().clone_into(&mut scene.device.link);
        }
        if let Some(card) = shared.card {
            card.name().clone_into(&mut scene.device.card);
        }
        let mut counters = counters;
        if let Some(drawing) = drawing {
            override_drawing(&mut scene, drawing)?;
            counters = match drawing.counters {
                None => counters,
                Some(CounterChoice::Visible) => Counters::Visible,
                Some(CounterChoice::Exact) => Counters::Exact,
            };
        }
        let raster = Options {
            tile: TileSize::Side64,
            counters,
        };
        let options = SessionOptions::of(&scene, raster).map_err(|error| place(&source, error))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let world = World::build_from(&scene, folder, &store(&shared.models), progress)?;
        for remark in &world.remarks {
            terminal.remark(remark);
        }
        let digests: Vec<_> = world.plants.iter().map(|plant| plant.digest()).collect();
        scene.pin_plants(|tree| Some(digests[world.trees.get(tree)?.crown]));
        Ok(Self {
            scene,
            world,
            options,
        })
    }
}

impl Prepared {
    /// The botanical name of a plant that was grown, which the papers' tables list, else its own; of a
    /// scene at `path`.
    pub(super) fn plant_name(&self, number: usize, path: &Path) -> String {
        let is_one = |tree: &StandingTree| tree.crown == number;
        let tree = self.world.trees.iter().position(is_one);
        let latin = || {
            let trees = self.scene.standing_trees();
            let PlantSource::Species(species) = &trees.get(tree?)?.source else {
                return None;
            };
            let species = SpeciesFile::read(&path.parent()?.join(species)).ok()?;
            Some(species.latin().to_owned())
        };
        latin().unwrap_or_else(|| self.world.crowns[number].plant().name().to_owned())
    }
}

/// Points an unknown name at the line that has it.
fn place(source: &SceneSource, error: RunError) -> CliError {
    match &error {
        RunError::Name { key, .. } => source.error(key, error.to_string()).into(),
        _ => error.into(),
    }
}

fn override_drawing(scene: &mut Scene, drawing: &Drawing) -> Result<(), CliError> {
    if let Some((width, height)) = drawing.size {
        scene.size = ImageSize::new(width, height).ok_or_else(|| {
            CliError::Usage(format!(
                "--size {width}x{height}: wanted sides of 1 to {} and at most {} pixels",
                ImageSize::MAX_SIDE,
                ImageSize::MAX_PIXELS
            ))
        })?;
    }
    if let Some(samples) = drawing.samples {
        scene.samples = SampleCount::new(samples)
            .ok_or_else(|| CliError::Usage(format!("--samples {samples}: wanted 1 or 4")))?;
    }
    if let Some(frames) = &drawing.frames
        && frames.end > scene.frames
    {
        return Err(CliError::Usage(format!(
            "--frames {}..{}: the scene has frames 0..{}",
            frames.start, frames.end, scene.frames
        )));
    }
    Ok(())
}
