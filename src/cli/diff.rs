//! `spinney diff`: how two images or two run folders differ.

use std::path::{Path, PathBuf};

use super::Verdict;
use super::arguments::{DiffOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use crate::report::{DiffFolder, ImageDifference, ImageFile, OutputFolder, RunDifference};

pub(super) fn diff(
    options: &DiffOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let mut folder = None;
    if let Some(path) = &shared.out {
        let output = OutputFolder::create(path)?;
        folder = Some(DiffFolder::new(output, options.tolerance));
    }
    // A folder that is not there is rather a misspelt run than an image.
    let is_image = |path: &Path| path.is_file();
    match is_image(&options.expected) || is_image(&options.actual) {
        true => images(options, shared, terminal, folder),
        false => runs(options, shared, terminal, folder),
    }
}

fn images(
    options: &DiffOptions,
    shared: &Shared,
    terminal: &Terminal,
    folder: Option<DiffFolder>,
) -> Result<Verdict, CliError> {
    let paths = [&options.expected, &options.actual];
    for path in paths {
        if path.is_dir() {
            let path = path.display();
            return Err(CliError::Usage(format!(
                "{path}: a folder, wanted an image as the other is"
            )));
        }
    }
    let files = [ImageFile::read(paths[0])?, ImageFile::read(paths[1])?];
    let Some(found) = ImageDifference::between(&files[0], &files[1], options.tolerance) else {
        let exr = files
            .iter()
            .position(|file| matches!(file, ImageFile::Exr(_)));
        return Err(CliError::Usage(format!(
            "{}: no channels R, G, B or Y of one size, wanted against a PNG",
            paths[exr.unwrap_or(0)].display()
        )));
    };
    let names = paths.map(|path| path.display().to_string());
    let [first, second] = &names;
    if let Some(folder) = folder {
        folder.finish_images(last_parts(paths), &found)?;
    }
    if shared.json {
        terminal.print(&found.to_json([first, second], options.tolerance))?;
    } else {
        let [one, other] = [files[0].format(), files[1].format()];
        let text = found.to_text(terminal.width());
        terminal.print(&format!(
            "first      {first} ({one})\nsecond     {second} ({other})\n{text}"
        ))?;
    }
    Ok(verdict(found.is_within()))
}

fn runs(
    options: &DiffOptions,
    shared: &Shared,
    terminal: &Terminal,
    mut folder: Option<DiffFolder>,
) -> Result<Verdict, CliError> {
    let paths = [&options.expected, &options.actual];
    let found =
        RunDifference::between(paths[0], paths[1], options.tolerance, &mut |frame, look| {
            match &mut folder {
                Some(folder) => folder.add_frame(frame, look),
                None => Ok(()),
            }
        })?;
    let names = paths.map(|path| path.display().to_string());
    let [first, second] = &names;
    if let Some(folder) = folder {
        folder.finish_runs(last_parts(paths), &found)?;
    }
    if shared.json {
        terminal.print(&found.to_json([first, second], options.tolerance))?;
    } else {
        let text = found.to_text(terminal.width());
        terminal.print(&format!("first   {first}\nsecond  {second}\n{text}"))?;
    }
    Ok(verdict(found.is_within()))
}

/// Whether it is the same decides.
fn verdict(is_same: bool) -> Verdict {
    match is_same {
        true => Verdict::Passed,
        false => Verdict::Failed,
    }
}

/// The names without the way to them, which would make a page another on another machine.
fn last_parts(paths: [&PathBuf; 2]) -> [&str; 2] {
    paths.map(|path| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.unwrap_or("")
    })
}
