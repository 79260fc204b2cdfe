//! Trees of other programs as plants, whatever format they are kept in.
//!
//! ```text
//!  file ─Source─▶ Format (told, or guessed by content, then by ending)
//!                   │
//!                   ├─ glTF, OBJ ───────────▶ meshes ─▶ cards? ─▶ foliage groups
//!                   │                                   rest   ─▶ trunk mesh ─rings?─▶ skeleton
//!                   ├─ TreeQSM, SimpleForest, aRchi,
//!                   │  raycloudtools, MTG ──▶ wood ─▶ skeleton ─▶ trunk mesh
//!                   └─ OPF, OPS ────────────▶ both
//!  ImportReport: what was found, guessed, repaired and left out, each with its first place
//! ```
//!
//! A [`Plant`] stands at the origin with +Y up, in metres of 32 bits. Files have other axes and units, and
//! may lie kilometres from their origin: [`Frame`] brings their points, in 64 bits, to the plant's
//! before anything is rounded.
//!
//! **Invariants.** No byte of a file is believed before it is checked. Memory stays in proportion to the
//! file and below stated limits. Nothing is dropped, guessed or left out without an entry in the
//! [`ImportReport`].

mod error;
mod format;
mod frame;
pub(in crate::plant) mod mesh;
mod mtg;
mod number;
mod obj;
mod opf;
mod placing;
mod qsm;
mod report;
pub(in crate::plant) mod rings;
mod source;
mod wood;

pub use error::ImportError;
pub use format::Format;
pub use frame::{Unit, UpAxis};
pub use report::{Found, ImportReport, ReportEntry, ReportKind};
pub use source::{PlantSources, read_sources};

pub(in crate::plant) use frame::Frame;
pub(in crate::plant) use source::Source;

use std::path::Path;

use super::Plant;
use super::gltf;

/// How a file is to be read where it does not say it, or says it wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// The format; without it the file's content, then its ending decides.
    pub format: Option<Format>,
    /// The axis that points up; without it the format's own.
    pub up: Option<UpAxis>,
    /// The unit of lengths; without it the format's own, or a guess that is reported.
    pub unit: Option<Unit>,
}

/// What the user says about a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportOptions {
    /// How it is to be read.
    pub reading: Reading,
    /// What is foliage: names of groups, objects, nodes (with all that hangs below them), meshes or
    /// materials, or primitives as `MESH#INDEX`. If there are any, nothing is guessed, and all else is
    /// wood.
    pub foliage: Vec<String>,
    /// What leaves that a file only counts are placed by.
    pub seed: u64,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            reading: Reading::default(),
            foliage: Vec::new(),
            seed: 1,
        }
    }
}

/// A plant, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The plant.
    pub plant: Plant,
    /// What was counted, guessed, repaired and left out on the way.
    pub report: ImportReport,
}

/// Imports a file of any [`Format`]; files that it names may lie beside it.
///
/// Foliage is what the options name, or what the format says, or else what looks like it. A file that
/// [`export_glb`](super::gltf::export_glb) wrote, and that was not edited, gives the plant that was written,
/// without guesses.
///
/// # Errors
///
/// When the file cannot be read, is damaged or hostile, exceeds a limit of this module, has a format that
/// is not known, or nothing bears a name that the options hold.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let file = path.display().to_string();
    let bytes = source::read(path)?;
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    import_bytes(&file, &bytes, Some(folder), options)
}

/// Imports a file that is in memory already. `file` names it in errors, its ending may say its format;
/// `folder` is where files lie that it names, without which it has to hold them itself.
///
/// # Errors
///
/// As [`import`].
pub fn import_bytes(
    file: &str,
    bytes: &[u8],
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, ImportError> {
    import_source(&Source::new(file, bytes, folder)?, options)
}

/// Imports a file; the source knows afterwards which files beside it were read.
fn import_source(source: &Source<'_>, options: &ImportOptions) -> Result<Imported, ImportError> {
    let mut report = ImportReport::default();
    let format = Format::of(source, options.reading.format, &mut report)?;
    report.format = Some(format);
    let plant = match format {
        Format::Gltf => gltf::read(source, options, &mut report),
        Format::Obj => obj::read(source, options, &mut report),
        Format::Opf => opf::read(source, options, &mut report),
        Format::Ops => opf::read_scene(source, options, &mut report),
        Format::TreeQsm | Format::SimpleForest | Format::Archi => {
            qsm::read_cylinders(format, source, options, &mut report)
        }
        Format::Treefile => qsm::read_treefile(source, options, &mut report),
        Format::Mtg => mtg::read(source, options, &mut report),
    }?;
    Ok(Imported { plant, report })
}
