//! Copies of the files that a scene's plants come from: what makes a run's folder whole.
//!
//! ```text
//!  scene, its folder ─gather─▶ scene that names plants/…, and the files to put there
//!    species = "../yew.toml"     species = "plants/yew.toml"
//! ```
//!
//! A species becomes `plants/NAME.toml` or `.rls`, a plant file `plants/NAME.glb` or of another ending; one that names
//! files beside it gets a folder of its own, `plants/NAME/NAME.gltf`, in which they lie as
//! its paths want them. NAME is that of the original; the second of a name becomes `NAME-2`.
//!
//! **Invariant.** Names depend on the scene's paths alone, and gathering from what was gathered gives
//! the same names and bytes again.

use std::collections::BTreeMap;
use std::path::{Component, Path};

use super::RunError;
use crate::document::Document;
use crate::plant::SpeciesFile;
use crate::plant::import::{ImportOptions, PlantSources, read_sources};
use crate::scene::{PlantSource, Scene};

/// The most bytes of all plants' files together that a run keeps copies of.
pub const MAX_PLANT_FILE_BYTES: u64 = crate::limits::COPIED_BYTES;

/// The files that a scene's plants come from, under the names that they have in a run's folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PlantFiles {
    files: BTreeMap<String, Vec<u8>>,
    folders: Vec<String>,
    bytes: u64,
}

impl PlantFiles {
    /// Reads the files of a scene whose paths start at `folder`, and answers the scene with its paths
    /// changed to the copies'. Each path is copied once, byte for byte.
    ///
    /// # Errors
    ///
    /// When a file cannot be read, or they exceed [`MAX_PLANT_FILE_BYTES`].
    pub fn gather(scene: &Scene, folder: &Path) -> Result<(Scene, Self), RunError> {
        let mut plants = Self::default();
        let mut scene = scene.clone();
        let mut known: BTreeMap<String, String> = BTreeMap::new();
        let mut taken: Vec<String> = Vec::new();
        let mut copy =
            |source: &PlantSource, options: &ImportOptions| -> Result<String, RunError> {
                let (PlantSource::Species(path) | PlantSource::File { path, .. }) = source;
                if let Some(copy) = known.get(path) {
                    return Ok(copy.clone());
                }
                let name = free_name(path, &mut taken);
                let copy = match source {
                    PlantSource::Species(path) => plants.add_species(&name, &folder.join(path))?,
                    PlantSource::File { path, .. } => {
                        plants.add_import(&name, read_sources(&folder.join(path), options)?)?
                    }
                };
                known.insert(path.clone(), copy.clone());
                Ok(copy)
            };
        for tree in &mut scene.trees {
            let copy = copy(&tree.source, &tree.import_options())?;
            match &mut tree.source {
                PlantSource::Species(path) | PlantSource::File { path, .. } => *path = copy,
            }
        }
        for species in scene
            .forests
            .iter_mut()
            .flat_map(|forest| forest.species_mut())
        {
            let source = PlantSource::Species(species.path.clone());
            species.path = copy(&source, &ImportOptions::default())?;
        }
        Ok((scene, plants))
    }

    /// The files by name, relative to the resolved scene, `/` between the parts.
    pub fn files(&self) -> impl Iterator<Item = (&str, &[u8])> {
        let files = self.files.iter();
        files.map(|(name, bytes)| (name.as_str(), bytes.as_slice()))
    }

    /// Folders that must exist though no file lies in them, since a path leads in and out again.
    pub fn folders(&self) -> impl Iterator<Item = &str> {
        self.folders.iter().map(String::as_str)
    }

    fn add_species(&mut self, name: &str, path: &Path) -> Result<String, RunError> {
        let document = Document::read(path)?;
        let copy = format!("plants/{name}.{}", SpeciesFile::ending_of(&document.file));
        self.add(copy.clone(), document.text.into_bytes())?;
        Ok(copy)
    }

    fn add_import(&mut self, name: &str, sources: PlantSources) -> Result<String, RunError> {
        let ending = sources.ending;
        if sources.beside.is_empty() {
            let copy = format!("plants/{name}.{ending}");
            self.add(copy.clone(), sources.document)?;
            return Ok(copy);
        }
        // As deep as the paths lead out, so that all of them end within.
        let paths = sources.beside.iter().map(|(path, _)| path.as_str());
        let depth = paths.map(height).max().unwrap_or(0);
        let home: Vec<String> = ["plants", name]
            .into_iter()
            .chain(std::iter::repeat_n("below", depth))
            .map(str::to_owned)
            .collect();
        let copy = format!("{}/{name}.{ending}", home.join("/"));
        self.add(copy.clone(), sources.document)?;
        for (path, bytes) in sources.beside {
            let mut place = home.clone();
            for part in Path::new(&path).components() {
                match part {
                    Component::ParentDir => {
                        let left = place.join("/");
                        place.pop();
                        if !home.join("/").starts_with(&left) && !self.folders.contains(&left) {
                            self.folders.push(left);
                        }
                    }
                    Component::Normal(part) => place.push(part.to_string_lossy().into_owned()),
                    Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
                }
            }
            self.add(place.join("/"), bytes)?;
        }
        Ok(copy)
    }

    fn add(&mut self, name: String, bytes: Vec<u8>) -> Result<(), RunError> {
        self.bytes += bytes.len() as u64;
        if self.bytes > MAX_PLANT_FILE_BYTES {
            return Err(RunError::PlantFiles {
                found: self.bytes,
                limit: MAX_PLANT_FILE_BYTES,
            });
        }
        self.files.entry(name).or_insert(bytes);
        Ok(())
    }
}

/// How many folders up a relative path leads at its highest.
fn height(path: &str) -> usize {
    let (mut depth, mut highest) = (0_usize, 0);
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir if depth == 0 => highest += 1,
            Component::ParentDir => depth -= 1,
            Component::Normal(_) => depth += 1,
            Component::CurDir | Component::RootDir | Component::Prefix(_) => {}
        }
    }
    highest
}

/// The file's name without its ending, in letters that every system has, and unlike those before
/// even where case does not count.
fn free_name(path: &str, taken: &mut Vec<String>) -> String {
    let stem = Path::new(path).file_stem().unwrap_or_default();
    let plain = |c: char| {
        let keeps = c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
        if keeps { c } else { '-' }
    };
    let mut name: String = stem.to_string_lossy().chars().map(plain).take(64).collect();
    if name.trim_matches('.').is_empty() {
        "plant".clone_into(&mut name);
    }
    let mut number = 1;
    let mut free = name.clone();
    while taken.contains(&free.to_ascii_lowercase()) {
        number += 1;
        free = format!("{name}-{number}");
    }
    taken.push(free.to_ascii_lowercase());
    free
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_free_and_stay_so() {
        let paths = [
            "x-2.toml",
            "a/X.toml",
            "b/x.glb",
            "c/my tree.toml",
            "...",
            "",
        ];
        let mut taken = Vec::new();
        let names = paths.map(|path| free_name(path, &mut taken));
        assert_eq!(names, ["x-2", "X", "x-3", "my-tree", "plant", "plant-2"]);
        let mut taken = Vec::new();
        let again = names.clone().map(|name| {
            let path = format!("plants/{name}.toml");
            free_name(&path, &mut taken)
        });
        assert_eq!(again, names);
    }

    #[test]
    fn paths_beside_end_within() {
        let heights = [
            "a.bin",
            "../a.bin",
            "b/../../a.bin",
            "b/../a.bin",
            "./../../a",
        ]
        .map(height);
        assert_eq!(heights, [0, 1, 1, 0, 2]);
        let sources = PlantSources {
            document: b"{}".to_vec(),
            ending: "gltf",
            beside: vec![
                ("../t/a.png".to_owned(), vec![1]),
                ("b/../c.bin".to_owned(), vec![2]),
            ],
        };
        let mut plants = PlantFiles::default();
        let copy = plants.add_import("tree", sources).expect("it is small");
        assert_eq!(copy, "plants/tree/below/tree.gltf");
        let names: Vec<&str> = plants.files().map(|(name, _)| name).collect();
        assert_eq!(
            names,
            [
                "plants/tree/below/c.bin",
                "plants/tree/below/tree.gltf",
                "plants/tree/t/a.png"
            ]
        );
        let folders: Vec<&str> = plants.folders().collect();
        assert_eq!(folders, ["plants/tree/below/b"]);
    }
}
