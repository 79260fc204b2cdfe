//! `spinney grow`: a plant from a species file.

use std::path::{Path, PathBuf};

use super::arguments::{GrowOptions, Shared};
use super::error::CliError;
use super::inspect::plant_facts;
use super::terminal::Terminal;
use crate::plant::gltf::export_glb;
use crate::plant::{Species, grow as grow_plant};

pub(super) fn grow(
    options: &GrowOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let species = Species::read(&options.species)?;
    let plant = grow_plant(&species, options.seed).map_err(|source| CliError::Grow {
        file: options.species.display().to_string(),
        source,
    })?;
    let bytes = export_glb(&plant)?;
    let target = shared.out.clone().unwrap_or_else(|| {
        let stem = options.species.file_stem().unwrap_or_default();
        PathBuf::from(stem).with_extension("glb")
    });
    write_whole(&target, &bytes)?;
    let mut facts = plant_facts(&plant);
    facts.insert(0, ("file", target.display().to_string().into()));
    terminal.print(&super::inspect::show(&facts, shared.json))
}

/// Writes a file so that it is there whole or not at all.
fn write_whole(target: &Path, bytes: &[u8]) -> Result<(), CliError> {
    let failed = |problem: std::io::Error| CliError::Write {
        place: target.display().to_string(),
        problem: problem.to_string(),
    };
    if let Some(folder) = target
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    let mut name = std::ffi::OsString::from(".");
    name.push(target.file_name().unwrap_or_default());
    name.push(format!(".spinney-{}", std::process::id()));
    let temporary = target.with_file_name(name);
    let written =
        std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, target));
    written.map_err(|problem| {
        // The file may not exist; then there is nothing to remove.
        _ = std::fs::remove_file(&temporary);
        failed(problem)
    })
}
