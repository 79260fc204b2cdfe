//! The file that a plant is imported from, and the files beside it that it names.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};

use super::{Format, ImportError, ImportOptions, ImportReport, gltf, import_source};
use crate::document::{DocumentError, ReadError, read_file};
use crate::limits::PLANT_FILE_BYTES;

/// A file in memory, and where others lie that it names.
#[derive(Debug)]
pub(in crate::plant) struct Source<'a> {
    file: &'a str,
    bytes: &'a [u8],
    folder: Option<&'a Path>,
    /// What was asked for beside it, each once, in the order of asking.
    named: RefCell<Vec<String>>,
    /// How many bytes files beside it may still have together.
    left: Cell<u64>,
}

impl<'a> Source<'a> {
    /// A file of at most [`PLANT_FILE_BYTES`].
    pub(in crate::plant) fn new(
        file: &'a str,
        bytes: &'a [u8],
        folder: Option<&'a Path>,
    ) -> Result<Self, ImportError> {
        let length = bytes.len() as u64;
        if length > PLANT_FILE_BYTES {
            return Err(ImportError::TooLarge {
                file: file.to_owned(),
                bytes: length,
                limit: PLANT_FILE_BYTES,
            });
        }
        Ok(Self {
            file,
            bytes,
            folder,
            named: RefCell::new(Vec::new()),
            left: Cell::new(PLANT_FILE_BYTES),
        })
    }

    /// The file, as the user named it.
    pub(in crate::plant) fn file(&self) -> &'a str {
        self.file
    }

    /// All of it.
    pub(in crate::plant) fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// Where files lie that it names, if that is known.
    pub(in crate::plant) fn folder(&self) -> Option<&'a Path> {
        self.folder
    }

    /// The file's name without folder and ending: what its plant is called.
    pub(in crate::plant) fn stem(&self) -> String {
        let stem = Path::new(self.file).file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// The ending of the file's name, in small letters, without the dot.
    pub(in crate::plant) fn ending(&self) -> String {
        let ending = Path::new(self.file).extension().unwrap_or_default();
        ending.to_string_lossy().to_lowercase()
    }

    /// All of it as UTF-8 text, without a byte order mark.
    pub(in crate::plant) fn text(&self) -> Result<&'a str, ImportError> {
        let bytes = self
            .bytes
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(self.bytes);
        std::str::from_utf8(bytes).map_err(|error| {
            let text = String::from_utf8_lossy(bytes);
            ImportError::Syntax(DocumentError::at(
                self.file,
                &text,
                error.valid_up_to(),
                "not UTF-8",
            ))
        })
    }

    /// An error in a line (from 1) and column (from 1) of the text.
    pub(in crate::plant) fn error(
        &self,
        line: usize,
        column: usize,
        message: impl Into<String>,
    ) -> ImportError {
        ImportError::Syntax(DocumentError {
            file: self.file.to_owned(),
            line,
            column,
            message: message.into(),
        })
    }

    /// Refuses more of something than a limit allows.
    pub(in crate::plant) fn limit(
        &self,
        what: &'static str,
        found: u64,
        limit: u64,
    ) -> Result<(), ImportError> {
        if found <= limit {
            return Ok(());
        }
        Err(ImportError::TooMany {
            file: self.file.to_owned(),
            what,
            found,
            limit,
        })
    }

    /// A file beside it, by the relative path that the text has, `\` read as `/`.
    ///
    /// The error says why it is not read, for a report: files beside are never needed for the shape.
    pub(in crate::plant) fn beside(&self, path: &str) -> Result<Vec<u8>, String> {
        let path = path.replace('\\', "/");
        let Some(folder) = self.folder else {
            return Err(format!("names the file {path:?}, but no folder is known"));
        };
        let relative = Path::new(&path);
        let has_drive = path.as_bytes().get(1) == Some(&b':');
        if relative.is_absolute() || relative.has_root() || has_drive || path.contains('\0') {
            return Err(format!(
                "{path:?} is not a relative path; put the file beside the document"
            ));
        }
        let place = folder.join(relative);
        if !self.named.borrow().contains(&path) {
            self.named.borrow_mut().push(path);
        }
        let bytes = read_file(&place, self.left.get()).map_err(|error| error.to_string())?;
        self.left.set(self.left.get() - bytes.len() as u64);
        Ok(bytes)
    }
}

/// Reads a plant's file.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    let file = path.display().to_string();
    read_file(path, PLANT_FILE_BYTES).map_err(|error| match error {
        ReadError::TooLarge { found, limit } => ImportError::TooLarge {
            file,
            bytes: found,
            limit,
        },
        _ => ImportError::Read {
            file,
            message: error.to_string(),
        },
    })
}

/// A plant's file and the files beside it that it names, as they lie on the disk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlantSources {
    /// The file, whole.
    pub document: Vec<u8>,
    /// The ending by which its format is known again: `glb`, say.
    pub ending: &'static str,
    /// Files that it names: the path relative to the file, as it has it (of glTF with `%` sequences
    /// decoded), and the bytes. Each once, in the order of naming.
    pub beside: Vec<(String, Vec<u8>)>,
}

/// Reads a plant's file and the files that it names, of all together at most [`PLANT_FILE_BYTES`] beside it.
///
/// A file beside it that is missing, or too large, is left out: an import that succeeds does not need it.
///
/// # Errors
///
/// As [`import`](super::import).
pub fn read_sources(path: &Path, options: &ImportOptions) -> Result<PlantSources, ImportError> {
    let file = path.display().to_string();
    let document = read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let source = Source::new(&file, &document, Some(folder))?;
    let format = Format::of(
        &source,
        options.reading.format,
        &mut ImportReport::default(),
    )?;
    let ending = format.ending(&document);
    let names = match format {
        // What it names is in its head; the meshes need not be read.
        Format::Gltf => gltf::named_files(&source)?,
        Format::TreeQsm | Format::SimpleForest | Format::Archi | Format::Treefile | Format::Mtg => {
            Vec::new()
        }
        Format::Obj | Format::Opf | Format::Ops => {
            import_source(&source, options)?;
            source.named.take()
        }
    };
    let mut beside: Vec<(String, Vec<u8>)> = Vec::new();
    let mut left = PLANT_FILE_BYTES;
    for name in names {
        let is_known = beside.iter().any(|(known, _)| *known == name);
        if !is_known && let Ok(bytes) = read_file(&PathBuf::from(folder).join(&name), left) {
            left -= bytes.len() as u64;
            beside.push((name, bytes));
        }
    }
    Ok(PlantSources {
        document,
        ending,
        beside,
    })
}
