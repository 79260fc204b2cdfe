//! A tree of the user's own, alone in a scene that says nothing else.

use std::path::Path;

use super::arguments::Shared;
use super::cache::store;
use super::error::CliError;
use super::terminal::Terminal;
use super::tree_arguments::PlantFileOptions;
use crate::document::Document;
use crate::plant::SpeciesFile;
use crate::report::FlipWhereShown;
use crate::run::{Progress, Shot, Verdict, World};
use crate::scene::{PlantSource, Scene, SceneFile};

/// The scene that the tree stands in; its camera is never used.
const ALONE: &str = "schema = \"spinney.scene/1\"\n\
     [[tree]]\nspecies = \"tree.toml\"\n\
     [camera]\npath = [{ eye = [0, 1, 9], target = [0, 1, 0] }]\n";

/// A scene with one tree, and its plant.
#[derive(Debug)]
pub(super) struct OwnTree {
    pub(super) scene: Scene,
    pub(super) world: World,
}

impl OwnTree {
    /// Reads or grows the tree, and simplifies it.
    pub(super) fn new(
        file: &Path,
        plant: &PlantFileOptions,
        shared: &Shared,
        terminal: &Terminal,
        progress: &dyn Progress,
    ) -> Result<Self, CliError> {
        let document = Document {
            file: file.display().to_string(),
            text: ALONE.to_owned(),
        };
        let SceneFile { mut scene, .. } = SceneFile::parse(document)?;
        if let Some(link) = shared.link {
            link.name().clone_into(&mut scene.device.link);
        }
        if let Some(card) = shared.card {
            card.name().clone_into(&mut scene.device.card);
        }
        let path = file.display().to_string();
        let options = plant.import_options();
        let tree = &mut scene.trees[0];
        tree.seed = options.seed;
        tree.source = match is_species(file) {
            true => PlantSource::Species(path),
            false => PlantSource::File {
                path,
                foliage: options.foliage,
                reading: options.reading,
            },
        };
        let world = World::build_from(&scene, Path::new(""), &store(&shared.models), progress)?;
        for remark in &world.remarks {
            terminal.remark(remark);
        }
        Ok(Self { scene, world })
    }
}

/// Whether a file says how trees of a kind grow, rather than what one tree looks like.
fn is_species(file: &Path) -> bool {
    let ending = file.extension().unwrap_or_default();
    SpeciesFile::ENDINGS
        .iter()
        .any(|known| ending.eq_ignore_ascii_case(known))
}

/// By what levels are judged.
pub(super) fn judge_levels(full: &[Shot]) -> Result<Box<Verdict<CliError>>, CliError> {
    let full = FlipWhereShown::new(full)?;
    Ok(Box::new(move |level: &[Shot]| Ok(full.of(level)?)))
}
