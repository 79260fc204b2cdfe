//! Reads what `peer.py dump` wrote: the arrays that a peer draws, as they lie in its memory.
//!
//! A dump is a folder with `scene.json` and a file an array, little-endian and unpadded:
//!
//! | array | element | meaning |
//! |---|---|---|
//! | `pos`, `nrm` | 3 × `f32` | a vertex: position and unit normal, in the space of the instance |
//! | `uv` | 2 × `f32` | a vertex: texture coordinate, (0, 0) at the top left |
//! | `idx` | `u32` | a corner of a triangle |
//! | `layer` | `f32` | a vertex: the layer of the texture, if there are several |
//! | `inst` | 16 × `f32` | an instance: from its space to the world, columns first, in the order of drawing |
//! | `tex` | 4 × `u8` | a texel R, G, B, A, rows from the top, layer after layer |
//! | `xy` | 2 × `f32` | an end of a line in normalised device coordinates, y up |
//! | `rgba` | 4 × `u8` | the colour of an end of a line |

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::Fault;

/// `scene.json`.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Dump {
    /// The camera.
    pub(crate) camera: Camera,
    /// The colour behind everything.
    pub(crate) clear: [f32; 4],
    /// What is drawn, in this order.
    pub(crate) batches: Vec<Batch>,
}

/// A camera of OpenGL: clip space has z from -1 (near) to 1.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Camera {
    /// Pixels a row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// From the world to the eye, columns first.
    pub(crate) view: [f64; 16],
    /// From the eye to clip space, columns first.
    pub(crate) proj: [f64; 16],
}

/// One material with all that is drawn with it.
#[derive(Debug, serde::Deserialize)]
pub(crate) struct Batch {
    /// How fragments are tested and mixed.
    pub(crate) mode: Mode,
    /// The least alpha that passes, in mode `MASK`.
    pub(crate) cutoff: f32,
    /// What texels are multiplied by.
    pub(crate) color: [f32; 4],
    /// What lies beyond the texture's rim, across and down.
    pub(crate) wrap: [Wrapping; 2],
    arrays: BTreeMap<String, Array>,
}

/// How fragments are tested and mixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(crate) enum Mode {
    /// The nearest shows.
    Opaque,
    /// The nearest of those with enough alpha.
    Mask,
    /// In the order of drawing.
    Blend,
}

/// What lies beyond the rim of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Wrapping {
    /// The nearest texel.
    Clamp,
    /// The texture again.
    Repeat,
}

#[derive(Debug, serde::Deserialize)]
struct Array {
    file: PathBuf,
    shape: Vec<usize>,
}

impl Dump {
    /// Reads the index of a dump; arrays are read one by one.
    pub(crate) fn read(folder: &Path) -> Result<Self, Fault> {
        let file = folder.join("scene.json");
        let text = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let dump = serde_json::from_slice(&text);
        Ok(dump.map_err(|error| format!("{}: {error}", file.display()))?)
    }
}

impl Batch {
    /// Whether there is such an array.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.arrays.contains_key(name)
    }

    /// The sides of an array, outermost first.
    pub(crate) fn shape(&self, name: &str) -> &[usize] {
        self.arrays.get(name).map_or(&[], |array| &array.shape)
    }

    /// The bytes of an array.
    pub(crate) fn bytes(&self, folder: &Path, name: &str) -> Result<Vec<u8>, Fault> {
        let array = self.arrays.get(name);
        let array = array.ok_or_else(|| format!("a batch has no array {name:?}"))?;
        let file = folder.join(&array.file);
        let bytes = std::fs::read(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        Ok(bytes)
    }

    /// An array of `f32`.
    pub(crate) fn floats(&self, folder: &Path, name: &str) -> Result<Vec<f32>, Fault> {
        let bytes = self.bytes(folder, name)?;
        let (words, _) = bytes.as_chunks::<4>();
        Ok(words.iter().copied().map(f32::from_le_bytes).collect())
    }

    /// An array of `u32`.
    pub(crate) fn numbers(&self, folder: &Path, name: &str) -> Result<Vec<u32>, Fault> {
        let bytes = self.bytes(folder, name)?;
        let (words, _) = bytes.as_chunks::<4>();
        Ok(words.iter().copied().map(u32::from_le_bytes).collect())
    }
}
