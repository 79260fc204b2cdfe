//! Every golden scene drawn in several ways: with everything rasterized, and with all that leaves work
//! out; with the best instructions, and with those that every machine has.

use std::path::Path;

use spinney::raster::{Counters, Instructions, Options, TileSize};
use spinney::run::{Session, SessionOptions, Silent, World};
use spinney::scene::SceneFile;

/// Scenes below a folder, in the order of names.
fn scenes(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(scenes(&path));
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            found.push(path);
        }
    }
    found
}

#[test]
fn what_is_left_out_cannot_be_seen() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/golden");
    let scenes = scenes(&folder);
    assert!(scenes.len() > 40, "{} scenes", scenes.len());
    let ways = [
        (Counters::Exact, Instructions::Scalar, TileSize::Side64),
        (Counters::Visible, Instructions::Scalar, TileSize::Side32),
        (Counters::Visible, Instructions::Best, TileSize::Side64),
    ];
    let mut frames_compared = 0;
    let mut hidden = 0;
    for file in &scenes {
        let scene = SceneFile::read(file).expect("a sound scene").scene;
        // Scenes of digests alone are large, and drawn by the program in both ways too.
        let Some(golden) = &scene.golden else {
            continue;
        };
        let from = file.parent().expect("a file lies in a folder");
        let world = World::build(&scene, from, &Silent).expect("plants grow");
        let seen = ways.map(|(counters, instructions, tile)| {
            let raster = Options { tile, counters };
            let options = SessionOptions {
                instructions,
                size: golden.size,
                ..SessionOptions::of(&scene, raster).expect("known names")
            };
            let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
            let frames = golden.frames.iter().map(|&number| {
                let frame = session.frame(number).expect("a frame");
                let mut ledger = frame.ledger.clone();
                (ledger.work, ledger.gpu_ticks) = (None, None);
                hidden += session.device().skips().hidden;
                (frame.image_digest, ledger)
            });
            frames.collect::<Vec<_>>()
        });
        frames_compared += golden.frames.len();
        assert_eq!(seen[0], seen[1], "{}", file.display());
        assert_eq!(seen[0], seen[2], "{}", file.display());
    }
    assert!(
        frames_compared > 50 && hidden > 1000,
        "{frames_compared} frames, {hidden} hidden"
    );
}
