//! The files that a document names.

use super::container::split;
use super::scan;
use super::uri::{decode_data, relative_path};
use crate::plant::import::{ImportError, ImportReport, Source};

/// The files beside a document that its buffers and images lie in: relative paths, `%` sequences
/// decoded, in the order of naming.
///
/// # Errors
///
/// When the document is no JSON.
pub(in crate::plant) fn named_files(source: &Source<'_>) -> Result<Vec<String>, ImportError> {
    let container = split(source.file(), source.bytes(), &mut ImportReport::default())?;
    let parsed = scan::parse(source.file(), container.json, container.json_offset)?;
    let buffers = parsed.root.buffers.iter().map(|buffer| &buffer.uri);
    let images = parsed.root.images.iter().map(|image| &image.uri);
    let beside = buffers.chain(images).flatten();
    Ok(beside
        .filter(|uri| decode_data(uri).is_none())
        .filter_map(|uri| relative_path(uri).ok())
        .collect())
}
