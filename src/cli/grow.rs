//! `spinney grow`: a plant from a species file.

use std::path::PathBuf;

use super::arguments::{GrowOptions, Shared};
use super::error::CliError;
use super::inspect::plant_facts;
use super::terminal::Terminal;
use crate::plant::SpeciesFile;
use crate::plant::gltf::export_glb;
use crate::report::write_file;

pub(super) fn grow(
    options: &GrowOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let species = SpeciesFile::read(&options.species)?;
    let plant = species
        .grow(options.seed)
        .map_err(|source| CliError::Grow {
            file: options.species.display().to_string(),
            source,
        })?;
    let bytes = export_glb(&plant)?;
    let target = shared.out.clone().unwrap_or_else(|| {
        let stem = options.species.file_stem().unwrap_or_default();
        PathBuf::from(stem).with_extension("glb")
    });
    write_file(&target, &bytes)?;
    let mut facts = plant_facts(&plant);
    facts.insert(0, ("file", target.display().to_string().into()));
    terminal.print(&super::inspect::show(&facts, shared.json))
}
