//! What the fuzz targets do with bytes: plain functions, so that tests replay them without a fuzzer.
//!
//! ```text
//! seeds ──seed──▶ corpus/TARGET/ ──cargo fuzz run TARGET──▶ scene, species, gltf, obj, …
//!   └────────────────────── cargo test ────────────────────────────────┘
//! ```
//!
//! **Invariant.** A target returns on any input. It panics where a reader does, and where what was
//! read breaks a promise: what is written reads back as the same.

mod exr;
mod gltf;
mod import;
mod seeds;
mod species;
mod trace;
mod wood;

pub use exr::exr;
pub use gltf::{gltf, png};
pub use import::{arbaro, obj, opf};
pub use seeds::{seeds, words};
pub use species::species;
pub use trace::trace;
pub use wood::wood;

use std::path::Path;
use std::sync::OnceLock;

use spinney::document::Document;
use spinney::plant::{Species, grow};
use spinney::report::OpsReader;
use spinney::run::{StandingTree, World, crown};
use spinney::scene::{SceneFile, to_toml};

/// A target's function.
pub type Target = fn(&[u8]);

/// Every target by its name.
pub const TARGETS: &[(&str, Target)] = &[
    ("arbaro", arbaro),
    ("exr", exr),
    ("gltf", gltf),
    ("obj", obj),
    ("opf", opf),
    ("ops", ops),
    ("png", png),
    ("scene", scene),
    ("species", species),
    ("trace", trace),
    ("wood", wood),
];

/// A text file's bytes as a document; `None` where they are no UTF-8, which reading refuses.
fn document(file: &str, bytes: &[u8]) -> Option<Document> {
    let text = std::str::from_utf8(bytes).ok()?.to_owned();
    Some(Document {
        file: file.to_owned(),
        text,
    })
}

/// Scene files: what is read has finite views, and comes back equal when it is written.
pub fn scene(bytes: &[u8]) {
    let Some(document) = document("fuzz.toml", bytes) else {
        return;
    };
    let scene = match SceneFile::parse(document) {
        Ok(file) => {
            // Later stages ask for places by keys that the file may lack.
            _ = file.source.error("tree[0].species", "");
            _ = file.source.error("device.link.none[7]", "");
            file.scene
        }
        Err(error) => {
            _ = error.to_string();
            return;
        }
    };
    for frame in [0, scene.frames / 2, scene.frames - 1] {
        let view = scene.camera.at(frame, scene.size);
        assert!(
            view.clip_from_world.is_finite(),
            "frame {frame} is seen by {view:?}"
        );
    }
    let written = to_toml(&scene);
    let again = document_of(&written);
    assert_eq!(again, scene, "{written}");
    assert_eq!(again.digest(), scene.digest(), "{written}");
}

fn document_of(written: &str) -> spinney::scene::Scene {
    let document = document("written.toml", written.as_bytes()).expect("a text");
    match SceneFile::parse(document) {
        Ok(file) => file.scene,
        Err(error) => panic!("{error}\n{written}"),
    }
}

/// The lines of `ops.jsonl`, for a world of two small trees.
pub fn ops(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let world = world();
    let mut reader = OpsReader::new(world);
    for line in text.lines() {
        match reader.read(line) {
            Ok((_, states)) => {
                assert_eq!(states.len(), world.trees.len());
                for (state, tree) in states.iter().zip(&world.trees) {
                    _ = state
                        .foliage
                        .leaf_count(world.crowns[tree.crown].clusters());
                }
            }
            Err(error) => _ = error.to_string(),
        }
    }
}

/// Two trees of 60 leaves each, of one plant.
pub(crate) fn world() -> &'static World {
    static WORLD: OnceLock<World> = OnceLock::new();
    WORLD.get_or_init(|| {
        let document = document("bush.toml", species::BUSH.as_bytes()).expect("a text");
        let species = Species::parse(&document).expect("our own");
        let plant = grow(&species, 1).expect("our own");
        let placement = spinney::models::Placement {
            position: spinney::math::Vec3::ZERO,
            rotation: spinney::math::Quat::IDENTITY,
            scale: 1.0,
        };
        let crowns = vec![std::sync::Arc::new(crown(plant, Some(5)))];
        let standing = StandingTree {
            crown: 0,
            placement,
        };
        World::of(crowns, vec![standing; 2])
    })
}

/// Gives every file that the command line names to a target.
pub fn replay(target: Target) {
    for path in std::env::args_os().skip(1) {
        let path = Path::new(&path);
        match std::fs::read(path) {
            Ok(bytes) => target(&bytes),
            Err(error) => panic!("{}: {error}", path.display()),
        }
    }
}
