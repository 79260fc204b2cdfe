//! `spinney grow`: a plant from a species file, or the file with every default filled in.

use std::path::{Path, PathBuf};

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
    let is_species = |target: &PathBuf| {
        let ending = target.extension().unwrap_or_default();
        ending.eq_ignore_ascii_case("toml")
    };
    if let Some(target) = shared.out.as_ref().filter(|target| is_species(target)) {
        return write_species(&species, options, target, shared, terminal);
    }
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
    facts.extend(super::inspect::species_remarks(&species));
    terminal.print(&super::inspect::show(&facts, shared.json))
}

/// Writes the species itself, with every default filled in.
fn write_species(
    species: &SpeciesFile,
    options: &GrowOptions,
    target: &Path,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let Some(parameters) = species.species() else {
        return Err(CliError::Usage(format!(
            "{}: a grammar has no parameters to write to {}; leave -o out, or name a .glb",
            options.species.display(),
            target.display()
        )));
    };
    write_file(target, parameters.to_toml().as_bytes())?;
    let mut facts: super::inspect::Facts = vec![
        ("file", target.display().to_string().into()),
        ("kind", "species".into()),
        ("name", parameters.name.clone().into()),
    ];
    facts.extend(super::inspect::species_remarks(species));
    terminal.print(&super::inspect::show(&facts, shared.json))
}
