//! Crowns that several scenes share: equal plants are grown and collapsed once.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use super::RunError;
use super::cache::ModelCache;
use super::world::{Wanted, crown_from};
use crate::document::Document;
use crate::math::{Digest, Digester};
use crate::models::{Crown, Trunk};
use crate::plant::import::import;
use crate::plant::{Plant, SpeciesFile};
use crate::scene::{PlantSource, Tree};

/// Crowns that were built already, for scenes that show the same plants.
///
/// A crown is known by what decides it, the text of its species file or the plant that was imported,
/// not by the file's name: a file that changes meanwhile gives another crown.
#[derive(Debug, Default)]
pub struct CrownStore {
    /// The one that was used last stands last.
    kept: Mutex<Kept>,
    /// Where collapses are kept beyond this process.
    cache: Option<ModelCache>,
}

type Kept = Vec<(Key, Arc<Crown>)>;

/// What decides a crown.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Key {
    plant: PlantKey,
    wanted: Wanted,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum PlantKey {
    Grown { species: Digest, seed: u64 },
    Imported { name: String, plant: Digest },
}

impl CrownStore {
    /// The most leaves that are kept, over all crowns; those that were not used for longest go
    /// first. A leaf takes some hundred bytes, so this trades up to about half a GiB for time.
    pub const MAX_LEAVES: usize = crate::limits::KEPT_LEAVES;

    /// A store that keeps nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            kept: Mutex::new(Vec::new()),
            cache: None,
        }
    }

    /// A store that keeps nothing yet, and takes collapses, of trunks too, from a cache.
    #[must_use]
    pub const fn with_cache(cache: ModelCache) -> Self {
        Self {
            kept: Mutex::new(Vec::new()),
            cache: Some(cache),
        }
    }

    /// The crown of a tree of a scene, built or as it was built before; a plant that does not fit is
    /// not simplified. What an importer has to say is added to `remarks`.
    pub(super) fn crown(
        &self,
        tree: &Tree,
        folder: &Path,
        wanted: Wanted,
        fits: &dyn Fn(&Plant) -> Result<(), RunError>,
        remarks: &mut Vec<String>,
    ) -> Result<Arc<Crown>, RunError> {
        match &tree.source {
            PlantSource::Species(path) => {
                let document = Document::read(&folder.join(path))?;
                let plant = PlantKey::Grown {
                    species: Digester::plain().raw(document.text.as_bytes()).finish(),
                    seed: tree.seed,
                };
                self.kept_or_built(Key { plant, wanted }, fits, || {
                    let species = SpeciesFile::parse(&document)?;
                    let plant = species.grow(tree.seed).map_err(|source| RunError::Grow {
                        species: path.clone(),
                        source,
                    })?;
                    Ok((plant, species.stop_leaves()))
                })
            }
            PlantSource::File { path, .. } => {
                let options = tree.import_options();
                let imported = import(&folder.join(path), &options)?;
                let entries = imported.report.entries.iter();
                remarks.extend(entries.map(|entry| format!("{path}: {entry}")));
                let plant = PlantKey::Imported {
                    name: imported.plant.name().to_owned(),
                    plant: imported.plant.digest(),
                };
                self.kept_or_built(Key { plant, wanted }, fits, || Ok((imported.plant, None)))
            }
        }
    }

    /// The trunk of a plant, if it has one, simplified to at most so many triangles or as usual; what is
    /// simplified is taken from the cache.
    pub(super) fn trunk(&self, plant: &Arc<Plant>, stop_triangles: Option<u32>) -> Option<Trunk> {
        let trunk = Trunk::of(plant, stop_triangles)?;
        Some(match &self.cache {
            Some(cache) => trunk.by(Arc::new(cache.clone())),
            None => trunk,
        })
    }

    /// The crown of a key; `plant` makes its plant, and says where to stop without a number.
    fn kept_or_built(
        &self,
        key: Key,
        fits: &dyn Fn(&Plant) -> Result<(), RunError>,
        plant: impl FnOnce() -> Result<(Plant, Option<u32>), RunError>,
    ) -> Result<Arc<Crown>, RunError> {
        let built = || -> Result<Arc<Crown>, RunError> {
            let (plant, usual) = plant()?;
            fits(&plant)?;
            let wanted = Wanted {
                stop_leaves: key.wanted.stop_leaves.or(usual),
                ..key.wanted
            };
            let cache = self.cache.as_ref();
            Ok(Arc::new(crown_from(Arc::new(plant), wanted, cache)))
        };
        // Held while building, so that nobody builds the same.
        let Some(mut kept) = self.lock() else {
            return built();
        };
        let crown = match kept.iter().position(|(known, _)| *known == key) {
            Some(index) => kept.remove(index).1,
            None => built()?,
        };
        kept.push((key, Arc::clone(&crown)));
        // Four faces of leaves of several faces take about what a quad with its collapses does.
        let leaves = |crown: &Crown| {
            (crown.sequence().original_count() + crown.faces().face_count() / 4) as usize
        };
        let mut sum: usize = kept.iter().map(|(_, crown)| leaves(crown)).sum();
        let mut first = 0;
        while sum > Self::MAX_LEAVES && first + 1 < kept.len() {
            sum -= leaves(&kept[first].1);
            first += 1;
        }
        kept.drain(..first);
        Ok(crown)
    }

    /// Waits for others; but not within a pool of threads, where the wait could be for work that the
    /// same thread has begun: then `None`, if somebody builds.
    fn lock(&self) -> Option<MutexGuard<'_, Kept>> {
        if rayon::current_thread_index().is_none() {
            return Some(self.kept.lock().unwrap_or_else(PoisonError::into_inner));
        }
        match self.kept.try_lock() {
            Ok(kept) => Some(kept),
            Err(TryLockError::Poisoned(broken)) => Some(broken.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::scene::Simplifier;

    fn tree(path: &str, seed: u64) -> Tree {
        Tree {
            source: PlantSource::Species(path.to_owned()),
            seed,
            at: Vec3::ZERO,
            turn: 0.0,
            scale: 1.0,
            plant_digest: None,
        }
    }

    #[test]
    fn what_decides_a_crown_is_not_the_files_name() {
        let folder = tempfile::tempdir().unwrap();
        let text = |leaves: u32| {
            format!(
                "schema = \"spinney.species/1\"\nname = \"broom\"\nleaf_count = {leaves}\n\
                 stop_leaves = 2\n[crown]\nlevels = 2\n[[foliage]]\nsilhouette = \"pinnate_entire\"\n"
            )
        };
        let put = |name: &str, leaves| {
            std::fs::write(folder.path().join(name), text(leaves)).unwrap();
        };
        put("a.toml", 20);
        put("b.toml", 20);
        let store = CrownStore::default();
        let simplified = |name, seed, simplifier, stop_leaves| {
            let mut remarks = Vec::new();
            let wanted = Wanted {
                simplifier,
                stop_leaves,
            };
            let crown = store.crown(
                &tree(name, seed),
                folder.path(),
                wanted,
                &|_| Ok(()),
                &mut remarks,
            );
            crown.unwrap()
        };
        let get = |name, seed, stop| simplified(name, seed, Simplifier::LeafCollapse, stop);
        let first = get("a.toml", 1, None);
        assert!(Arc::ptr_eq(&first, &get("b.toml", 1, None)));
        assert!(!Arc::ptr_eq(&first, &get("a.toml", 2, None)));
        assert!(!Arc::ptr_eq(&first, &get("a.toml", 1, Some(3))));
        let pruned = simplified("a.toml", 1, Simplifier::Pruning, None);
        assert!(!Arc::ptr_eq(&first, &pruned));
        assert_eq!(
            pruned.sequence().root_count(),
            first.sequence().root_count()
        );
        assert_eq!(pruned.sequence().added_vertices().len(), 4 * 18);
        put("a.toml", 30);
        assert_ne!(
            get("a.toml", 1, None).sequence().original_count(),
            first.sequence().original_count()
        );
        assert!(Arc::ptr_eq(&first, &get("b.toml", 1, None)));
    }
}
