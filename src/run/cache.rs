//! Built models in a folder, for the next process that needs them.
//!
//! ```text
//! foliage, options ─key─▶ KEY.model ─read, checked─▶ sequence
//!                              ▲  └─ anything wrong ─▶ built anew ─┐
//!                              └───── temporary, then renamed ◀────┘
//! ```
//!
//! A file, all numbers little-endian:
//!
//! |  bytes | content |
//! |-------:|---|
//! |    0–7 | `spinney` and a 0 |
//! |   8–11 | kind of model: 1, leaf collapses; 2, a [trunk](super::trunks) |
//! |  12–43 | key: BLAKE3 of all that decides the model, and of the version of what builds it |
//! |  44–51 | length of the rest in bytes |
//! |  52–83 | BLAKE3 of bytes 0–51 and the rest |
//! | 84–end | the model |
//!
//! Only leaf collapses are kept: pruning takes hardly longer than to read what it makes. They are `L` and
//! `C` as `u32`; of every new leaf the four corners, `u32`; of every collapse
//! both old leaves, `u32`, and the bits of the cost.
//!
//! **Invariant.** What a cache returns is what would have been built: a file counts only with its own
//! key, length and digest, and if it holds a sound sequence over as many leaves. A folder that cannot
//! be read or written is an empty one. Digests do not tell who wrote a file: who may write to the
//! folder can put another sound sequence there.

use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

use crate::limits;
use crate::math::{Digest, Digester, index_u32};
use crate::plant::Foliage;
use crate::simplify::{
    Collapse, CollapseSequence, LEAF_COLLAPSE_VERSION, LeafCollapseOptions, LeafDistance,
    collapse_leaves,
};

/// A folder of built models; safe with several processes at once.
#[derive(Debug, Clone)]
pub struct ModelCache {
    folder: PathBuf,
    limit: CacheLimit,
}

/// How much a cache keeps; what was written first goes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheLimit {
    /// Bytes of all files together.
    pub bytes: u64,
    /// Files.
    pub files: usize,
}

impl CacheLimit {
    /// That of [`limits`].
    pub const USUAL: Self = Self {
        bytes: limits::CACHE_BYTES,
        files: limits::CACHE_FILES,
    };
}

impl ModelCache {
    /// A cache in a folder, which is made when there is something to put there. Other files there are
    /// left alone.
    #[must_use]
    pub fn new(folder: PathBuf, limit: CacheLimit) -> Self {
        Self { folder, limit }
    }

    /// [`collapse_leaves`](crate::simplify::collapse_leaves), read where it was built before.
    #[must_use]
    pub fn collapse_leaves(
        &self,
        foliage: &Foliage,
        options: &LeafCollapseOptions,
    ) -> CollapseSequence {
        let leaves = index_u32(foliage.quad_count());
        self.kept_or_built(
            (LEAF_COLLAPSES, leaf_collapse_key(foliage, options)),
            leaf_collapse_bytes(leaves),
            |model| read_leaf_collapses(model, leaves),
            || collapse_leaves(foliage, options),
            write_leaf_collapses,
        )
    }

    /// The model of a kind and key of at most `most` bytes, read if a sound one is kept, or built and
    /// kept from now on.
    pub(super) fn kept_or_built<T>(
        &self,
        (kind, key): (u32, Digest),
        most: u64,
        sound: impl FnOnce(&[u8]) -> Option<T>,
        build: impl FnOnce() -> T,
        write: impl FnOnce(&T) -> Vec<u8>,
    ) -> T {
        let path = self.folder.join(format!("{key}{ENDING}"));
        if let Some(kept) = read(&path, kind, key, most).and_then(|model| sound(&model)) {
            return kept;
        }
        let built = build();
        // Where nothing can be written, nothing is kept.
        self.keep(&path, &file(kind, key, &write(&built))).ok();
        built
    }

    /// Writes a file whole or not at all, then removes the oldest beyond the limit.
    fn keep(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        if bytes.len() as u64 > self.limit.bytes || self.limit.files == 0 {
            return Ok(());
        }
        fs::create_dir_all(&self.folder)?;
        let (temporary, mut file) = self.temporary(path)?;
        let written = file.write_all(bytes);
        drop(file);
        let renamed = written.and_then(|()| fs::rename(&temporary, path));
        if renamed.is_err() {
            fs::remove_file(&temporary).ok();
        }
        renamed?;
        self.remove_oldest(path)
    }

    /// A new file that nobody else writes.
    fn temporary(&self, path: &Path) -> io::Result<(PathBuf, File)> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mut attempt = 0;
        loop {
            let path = self.folder.join(format!("{name}.{attempt}{UNFINISHED}"));
            match File::create_new(&path) {
                Ok(file) => return Ok((path, file)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
            attempt += 1;
            if attempt == MOST_WRITERS {
                return Err(io::ErrorKind::AlreadyExists.into());
            }
        }
    }

    /// Removes what was written first until the limit is kept, but never what was just written. What
    /// a process left unfinished goes the same way.
    fn remove_oldest(&self, newest: &Path) -> io::Result<()> {
        let mut files = Vec::new();
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            let path = entry.path();
            // Somebody else may have removed it by now.
            if let Ok(about) = entry.metadata()
                && about.is_file()
                && is_ours(&path)
            {
                let is_newest = path == newest;
                files.push((is_newest, about.modified()?, path, about.len()));
            }
        }
        files.sort_unstable();
        let mut count = files.len();
        let mut bytes = files
            .iter()
            .fold(0_u64, |sum, file| sum.saturating_add(file.3));
        for (is_newest, _, path, length) in files {
            if is_newest || (bytes <= self.limit.bytes && count <= self.limit.files) {
                break;
            }
            fs::remove_file(path).ok();
            bytes -= length;
            count -= 1;
        }
        Ok(())
    }
}

/// How the names of files end, after their key.
const ENDING: &str = ".model";

/// How the names of files end that are being written.
const UNFINISHED: &str = ".unfinished";

/// More than anybody writes one model at once.
const MOST_WRITERS: u32 = 100;

/// Whether a file has a name that a cache gives: a key, then an ending.
fn is_ours(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split_once('.').is_some_and(|(key, ending)| {
        let is_key = key.len() == 64 && key.bytes().all(|digit| digit.is_ascii_hexdigit());
        is_key && (ending == &ENDING[1..] || ending.ends_with(UNFINISHED))
    })
}

const MAGIC: &[u8; 8] = b"spinney\0";

/// The kind of [`CollapseSequence`].
const LEAF_COLLAPSES: u32 = 1;

/// Bytes before the model.
const HEAD: usize = 84;

/// All of a file.
fn file(kind: u32, key: Digest, model: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + model.len());
    bytes.extend(MAGIC);
    bytes.extend(kind.to_le_bytes());
    bytes.extend(key.0);
    bytes.extend((model.len() as u64).to_le_bytes());
    let digest = Digester::plain().raw(&bytes).raw(model).finish();
    bytes.extend(digest.0);
    bytes.extend(model);
    bytes
}

/// The model in a file, if it is whole, of this kind and key, and no longer than `most` bytes.
fn read(path: &Path, kind: u32, key: Digest, most: u64) -> Option<Vec<u8>> {
    // Not a pipe, which would be waited for.
    let length = fs::metadata(path).ok().filter(fs::Metadata::is_file)?.len();
    let model_length = length.checked_sub(HEAD as u64)?;
    if model_length > most {
        return None;
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).ok()?);
    let opened = File::open(path).ok()?;
    // It may have been replaced meanwhile.
    opened.take(length).read_to_end(&mut bytes).ok()?;
    let (head, model) = bytes.split_at_checked(HEAD)?;
    let is_whole = head == &file(kind, key, model)[..HEAD];
    is_whole.then(|| model.to_vec())
}

/// The most that the leaf collapses of so many leaves take.
fn leaf_collapse_bytes(leaves: u32) -> u64 {
    8 + COLLAPSE_BYTES as u64 * u64::from(leaves)
}

/// Bytes of a collapse: corners, old leaves, cost.
const COLLAPSE_BYTES: usize = 16 + 8 + 4;

fn write_leaf_collapses(sequence: &CollapseSequence) -> Vec<u8> {
    let collapses = sequence.collapses();
    let mut bytes = Vec::with_capacity(8 + COLLAPSE_BYTES * collapses.len());
    bytes.extend(sequence.original_count().to_le_bytes());
    bytes.extend(sequence.collapse_count().to_le_bytes());
    let new = &sequence.corners()[sequence.original_count() as usize..];
    for vertex in new.iter().flatten() {
        bytes.extend(vertex.to_le_bytes());
    }
    for Collapse { old, cost } in collapses {
        bytes.extend(old[0].to_le_bytes());
        bytes.extend(old[1].to_le_bytes());
        bytes.extend(cost.to_bits().to_le_bytes());
    }
    bytes
}

/// A sequence over `leaves` leaves, if there is a sound one.
fn read_leaf_collapses(bytes: &[u8], leaves: u32) -> Option<CollapseSequence> {
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let (&[original_count, collapse_count], words) = words.split_first_chunk::<2>()?;
    let count = collapse_count as usize;
    let wanted = count.checked_mul(COLLAPSE_BYTES / 4)?;
    if !rest.is_empty() || words.len() != wanted || original_count != leaves {
        return None;
    }
    let (new, olds) = words.split_at(4 * count);
    let corners = (0..leaves).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
    let corners = corners.chain(new.as_chunks::<4>().0.iter().copied());
    let collapses: Vec<Collapse> = olds
        .as_chunks::<3>()
        .0
        .iter()
        .map(|&[first, second, cost]| Collapse {
            old: [first, second],
            cost: f32::from_bits(cost),
        })
        .collect();
    let is_cost = |collapse: &Collapse| collapse.cost.is_finite() && collapse.cost >= 0.0;
    if !collapses.iter().all(is_cost) {
        return None;
    }
    // Nor do leaf collapses add vertices.
    CollapseSequence::new(leaves, corners.collect(), collapses).ok()
}

/// The digest of all that decides the collapses: BLAKE3 over the domain
/// `spinney.cache.leaf-collapses/1`, the version, the options in their order, and of every group the
/// number of leaves and the positions.
fn leaf_collapse_key(foliage: &Foliage, options: &LeafCollapseOptions) -> Digest {
    let LeafCollapseOptions {
        stop_leaves,
        distance,
        distance_weight,
        coplanarity_weight,
        area_weight,
        area_gain,
        form_weight,
        exposure,
        coplanarity_threshold,
        distance_threshold,
    } = *options;
    let mut digester = Digester::new("spinney.cache.leaf-collapses/1");
    digester.u32(LEAF_COLLAPSE_VERSION).u32(stop_leaves);
    digester.u32(match distance {
        LeafDistance::Hausdorff => 0,
        LeafDistance::Centers => 1,
    });
    for weight in [
        distance_weight,
        coplanarity_weight,
        area_weight,
        area_gain,
        form_weight,
        exposure,
    ] {
        digester.f32(weight);
    }
    for threshold in [coplanarity_threshold, distance_threshold] {
        digester.u32(u32::from(threshold.is_some()));
        digester.f32(threshold.unwrap_or(0.0));
    }
    for (group, _) in foliage.quad_groups() {
        digester.u64(group.leaf_count() as u64);
    }
    let coordinates = foliage.quad_vertices();
    let coordinates = coordinates.iter().flat_map(|vertex| vertex.to_array());
    let bytes: Vec<u8> = coordinates.flat_map(f32::to_le_bytes).collect();
    digester.bytes(&bytes).finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, Vec3};
    use crate::plant::{LeafGroup, Material, NO_BRANCH, Prototype};

    /// Squares of random place and size.
    fn foliage(count: usize, seed: u64) -> Foliage {
        let mut draws = Stream::new(seed, 0).draws();
        let positions: Vec<Vec3> = (0..count)
            .flat_map(|_| {
                let (x, y, z) = (draws.signed(), draws.signed(), draws.signed());
                let base = 3.0 * Vec3::new(x, y, z);
                let side = 0.1 + draws.unit();
                [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
                    .map(|(u, v)| base + Vec3::new(u, v, 0.0))
            })
            .collect();
        Foliage {
            groups: vec![LeafGroup {
                name: "leaves".to_owned(),
                prototype: Prototype::Quad {
                    texture_corners: Prototype::WHOLE_IMAGE,
                },
                material: Material::plain("leaf", [0.1, 0.4, 0.1]),
                owners: vec![NO_BRANCH; count],
                positions,
            }],
        }
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
    }

    #[test]
    fn a_hit_is_what_was_built_and_tampered_files_are_built_anew() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ModelCache::new(folder.path().join("a/b"), CacheLimit::USUAL);
        let leaves = foliage(90, 1);
        let options = LeafCollapseOptions::to(7);
        let built = collapse_leaves(&leaves, &options);
        assert_eq!(cache.collapse_leaves(&leaves, &options), built);
        let [path] = &files(&folder.path().join("a/b"))[..] else {
            panic!("one file, and nothing unfinished");
        };
        let sound = fs::read(path).unwrap();
        assert_eq!(sound.len(), HEAD + 8 + COLLAPSE_BYTES * 83);
        assert_eq!(read_leaf_collapses(&sound[HEAD..], 90), Some(built.clone()));
        // Magic, kind, key, length, digest, counts, corners, collapses; then cut short or grown.
        for at in [0, 8, 12, 44, 51, 52, 84, 88, 92, 1500, sound.len() - 1] {
            let mut tampered = sound.clone();
            tampered[at] ^= 0x40;
            fs::write(path, &tampered).unwrap();
            assert_eq!(cache.collapse_leaves(&leaves, &options), built, "byte {at}");
            assert_eq!(fs::read(path).unwrap(), sound, "byte {at}");
        }
        for tampered in [
            &[][..],
            &sound[..83],
            &sound[..84],
            &[&sound[..], &[0]].concat(),
        ] {
            fs::write(path, tampered).unwrap();
            assert_eq!(cache.collapse_leaves(&leaves, &options), built);
            assert_eq!(fs::read(path).unwrap(), sound);
        }
        // A sound file of another sequence, told by its key; and what a digest does not tell.
        let other = collapse_leaves(&leaves, &LeafCollapseOptions::to(8));
        let key = leaf_collapse_key(&leaves, &LeafCollapseOptions::to(8));
        let model = write_leaf_collapses(&other);
        fs::write(path, file(LEAF_COLLAPSES, key, &model)).unwrap();
        assert_eq!(cache.collapse_leaves(&leaves, &options), built);
        for (word, value) in [(0, 91), (1, 0), (1, u32::MAX), (2, 1), (2 + 4 * 83, 80_000)] {
            let mut model = sound[HEAD..].to_vec();
            model[4 * word..][..4].copy_from_slice(&u32::to_le_bytes(value));
            assert_eq!(read_leaf_collapses(&model, 90), None, "word {word}");
        }
        let mut model = sound[HEAD..].to_vec();
        let last = model.len() - 4;
        model[last..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(read_leaf_collapses(&model, 90), None);
    }

    #[test]
    fn every_option_and_position_decides_the_key() {
        let leaves = foliage(10, 1);
        let base = LeafCollapseOptions::to(3);
        let key = |options| leaf_collapse_key(&leaves, &options);
        let keys = [
            key(base),
            key(LeafCollapseOptions::to(4)),
            key(LeafCollapseOptions {
                distance: LeafDistance::Centers,
                ..base
            }),
            key(LeafCollapseOptions {
                distance_weight: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                coplanarity_weight: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                area_weight: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                area_gain: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                form_weight: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                exposure: 0.7,
                ..base
            }),
            key(LeafCollapseOptions {
                coplanarity_threshold: Some(0.0),
                ..base
            }),
            key(LeafCollapseOptions {
                distance_threshold: Some(0.0),
                ..base
            }),
            leaf_collapse_key(&foliage(10, 2), &base),
        ];
        for (number, key) in keys.iter().enumerate() {
            assert!(!keys[..number].contains(key), "key {number}");
        }
    }

    #[test]
    fn a_folder_that_cannot_be_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("file");
        fs::write(&blocked, "no folder").unwrap();
        let cache = ModelCache::new(blocked.join("cache"), CacheLimit::USUAL);
        let (leaves, options) = (foliage(20, 3), LeafCollapseOptions::to(2));
        let built = collapse_leaves(&leaves, &options);
        assert_eq!(cache.collapse_leaves(&leaves, &options), built);
    }

    #[test]
    fn the_oldest_go_and_other_files_stay() {
        let folder = tempfile::tempdir().unwrap();
        let limit = CacheLimit {
            bytes: 1 << 20,
            files: 2,
        };
        let cache = ModelCache::new(folder.path().to_owned(), limit);
        let options = LeafCollapseOptions::to(2);
        fs::write(folder.path().join("letter.model"), "keep me").unwrap();
        for seed in 0..5 {
            let built = cache.collapse_leaves(&foliage(20, seed), &options);
            assert_eq!(cache.collapse_leaves(&foliage(20, seed), &options), built);
        }
        let left = files(folder.path());
        assert_eq!(left.len(), 3, "{left:?}");
        assert!(left.contains(&folder.path().join("letter.model")));
        // A file larger than all may be is not written.
        let limit = CacheLimit {
            bytes: 100,
            files: 9,
        };
        let small = ModelCache::new(folder.path().to_owned(), limit);
        let built = small.collapse_leaves(&foliage(20, 9), &options);
        assert_eq!(built, collapse_leaves(&foliage(20, 9), &options));
        assert_eq!(files(folder.path()), left);
    }

    #[test]
    fn several_writers_at_once_get_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ModelCache::new(folder.path().to_owned(), CacheLimit::USUAL);
        let (leaves, options) = (foliage(60, 4), LeafCollapseOptions::to(2));
        let built = collapse_leaves(&leaves, &options);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| assert_eq!(cache.collapse_leaves(&leaves, &options), built));
            }
        });
        let [path] = &files(folder.path())[..] else {
            panic!("one file, and nothing unfinished");
        };
        let kept = read_leaf_collapses(&fs::read(path).unwrap()[HEAD..], 60);
        assert_eq!(kept, Some(built));
    }
}
