//! The files that a plant is imported from, as they lie on the disk.

use std::path::Path;

use super::container::{read, split};
use super::report::ImportReport;
use super::uri::{decode_data, relative_path};
use super::{ImportError, scan};
use crate::document::read_file;
use crate::limits::PLANT_FILE_BYTES;

/// A document and the files beside it that it names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlantSources {
    /// The document: JSON, or a GLB with all its chunks.
    pub document: Vec<u8>,
    /// Files that buffers and images lie in: the path relative to the document, as the document has
    /// it but with `%` sequences decoded, and the bytes. Each once, in the order of naming.
    pub beside: Vec<(String, Vec<u8>)>,
}

impl PlantSources {
    /// Whether the document is a GLB.
    #[must_use]
    pub fn is_binary(&self) -> bool {
        self.document.starts_with(b"glTF")
    }
}

/// Reads a `.glb` or `.gltf` file and the files that its buffers and images lie in, of all together
/// at most [`PLANT_FILE_BYTES`] beside the document.
///
/// A file beside it that is missing, or too large, is left out: an import that succeeds does not
/// need it.
///
/// # Errors
///
/// When the document cannot be read, is too large, or is no JSON.
pub fn read_sources(path: &Path) -> Result<PlantSources, ImportError> {
    let file = path.display().to_string();
    let document = read(path)?;
    let container = split(&file, &document, &mut ImportReport::default())?;
    let parsed = scan::parse(&file, container.json, container.json_offset)?;
    let buffers = parsed.root.buffers.iter().map(|buffer| &buffer.uri);
    let images = parsed.root.images.iter().map(|image| &image.uri);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut beside: Vec<(String, Vec<u8>)> = Vec::new();
    let mut left = PLANT_FILE_BYTES;
    for uri in buffers.chain(images).flatten() {
        if decode_data(uri).is_some() {
            continue;
        }
        let Ok(relative) = relative_path(uri) else {
            continue;
        };
        if beside.iter().any(|(known, _)| *known == relative) {
            continue;
        }
        if let Ok(bytes) = read_file(&folder.join(&relative), left) {
            left -= bytes.len() as u64;
            beside.push((relative, bytes));
        }
    }
    drop(parsed);
    Ok(PlantSources { document, beside })
}
