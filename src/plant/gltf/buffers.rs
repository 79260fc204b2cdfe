//! Buffers, wherever they lie, and views of them.

use super::error::Fault;
use super::uri::{decode_data, resolve};
use crate::document::{ReadError, read_file};
use crate::limits::PLANT_FILE_BYTES;
use gltf_json::Root;
use std::cell::{Cell, OnceCell};
use std::path::Path;

/// The buffers of a document, each loaded when first asked for.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    root: &'a Root,
    folder: Option<&'a Path>,
    binary: Option<&'a [u8]>,
    buffers: Vec<OnceCell<Result<Vec<u8>, Fault>>>,
    loaded_bytes: Cell<u64>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, folder: Option<&'a Path>, binary: Option<&'a [u8]>) -> Self {
        Self {
            root,
            folder,
            binary,
            buffers: root.buffers.iter().map(|_| OnceCell::new()).collect(),
            loaded_bytes: Cell::new(0),
        }
    }

    /// The bytes of a buffer view that `pointer` names, and its stride if it states one.
    pub(super) fn view(
        &self,
        index: usize,
        pointer: &str,
    ) -> Result<(&[u8], Option<usize>), Fault> {
        let Some(view) = self.root.buffer_views.get(index) else {
            let count = self.root.buffer_views.len();
            return Err(Fault::index(pointer, "buffer view", index, count));
        };
        let at = |field: &str| format!("/bufferViews/{index}/{field}");
        let buffer = view.buffer.value();
        let Some(cell) = self.buffers.get(buffer) else {
            return Err(Fault::index(
                at("buffer"),
                "buffer",
                buffer,
                self.buffers.len(),
            ));
        };
        let bytes = cell.get_or_init(|| self.load(buffer));
        let bytes = bytes.as_ref().map_err(Fault::clone)?;
        let offset = view.byte_offset.unwrap_or_default().0;
        let length = view.byte_length.0;
        let range = range_in(offset, length, bytes.len()).ok_or_else(|| {
            let message = format!(
                "{length} bytes from byte {offset} pass the end of buffer {buffer}, which has {}",
                bytes.len()
            );
            Fault::new(at("byteLength"), message)
        })?;
        let stride = view.byte_stride.map(|stride| stride.0);
        // Zero stands for "packed" in files of old exporters.
        Ok((&bytes[range], stride.filter(|&stride| stride > 0)))
    }

    /// The bytes that a URI of the document stands for.
    pub(super) fn fetch(&self, uri: &str, pointer: &str) -> Result<Vec<u8>, Fault> {
        let left = PLANT_FILE_BYTES - self.loaded_bytes.get();
        let fail = |message: String| Fault::new(pointer, message);
        let too_large = |bytes: u64| {
            fail(format!(
                "{bytes} bytes more, but only {left} of {PLANT_FILE_BYTES} are left for this document"
            ))
        };
        let bytes = match decode_data(uri) {
            Some(_) if uri.len() as u64 / 4 * 3 > left => {
                return Err(too_large(uri.len() as u64 / 4 * 3));
            }
            Some(decoded) => decoded.map_err(fail)?,
            None => {
                let path = resolve(uri, self.folder).map_err(fail)?;
                read_file(&path, left).map_err(|error| match error {
                    ReadError::TooLarge { found, .. } => too_large(found),
                    _ => fail(format!("{uri:?}: {error}")),
                })?
            }
        };
        let loaded = self.loaded_bytes.get() + bytes.len() as u64;
        self.loaded_bytes.set(loaded.min(PLANT_FILE_BYTES));
        Ok(bytes)
    }

    fn load(&self, index: usize) -> Result<Vec<u8>, Fault> {
        let buffer = &self.root.buffers[index];
        let pointer = format!("/buffers/{index}");
        let mut bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => self.fetch(uri, &format!("{pointer}/uri"))?,
            (None, Some(binary)) if index == 0 => binary.to_vec(),
            (None, _) => {
                let message = "has no uri, and the file has no binary chunk for it";
                return Err(Fault::new(pointer, message));
            }
        };
        let (declared, found) = (buffer.byte_length.0, bytes.len());
        match usize::try_from(declared) {
            Ok(declared) if declared <= found => bytes.truncate(declared),
            _ => {
                return Err(Fault::new(
                    format!("{pointer}/byteLength"),
                    format!(
                        "promises {declared} bytes, but there are {found}; the data is cut off"
                    ),
                ));
            }
        }
        Ok(bytes)
    }
}

fn range_in(offset: u64, length: u64, available: usize) -> Option<std::ops::Range<usize>> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    let start = usize::try_from(offset).ok()?;
    (end <= available).then_some(start..end)
}
