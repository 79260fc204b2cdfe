//! The golden scenes, and their frames drawn.
//!
//! `scenes/golden/SUITE/NAME.toml` is a scene. With a `[golden]` table, the frames that it lists are
//! kept as pictures and ledgers, `golden/SUITE/NAME-FRAME.{png,txt}`, at the table's size; without,
//! every frame is kept as a digest, at the scene's own size. All counters are exact.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Frame, Session, SessionOptions, Silent, World};
use spinney::scene::{Golden, ImageSize, Scene, Tree};

use crate::table::Context;

/// The folder of the package: what all paths start from.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A golden scene.
#[derive(Debug)]
pub(crate) struct GoldenScene {
    /// `SUITE/NAME`.
    pub(crate) name: String,
    scene: Scene,
    folder: PathBuf,
}

/// A frame of a golden scene.
#[derive(Debug)]
pub(crate) struct Drawn {
    /// `SUITE/NAME-FRAME`, the frame's number with four digits.
    pub(crate) name: String,
    /// What it shows and what it cost.
    pub(crate) frame: Frame,
    /// What the ledger's table says beside the frame.
    pub(crate) context: Context,
}

/// The path of something in the package.
pub(crate) fn path(below: &str) -> PathBuf {
    Path::new(ROOT).join(below)
}

/// The names of all golden scenes, `SUITE/NAME`, in order.
pub(crate) fn names() -> Vec<String> {
    files_below(&path("scenes/golden"))
        .iter()
        .filter_map(|file| file.strip_suffix(".toml").map(str::to_owned))
        .collect()
}

/// The files two levels below a folder as `FOLDER/FILE`, in order.
pub(crate) fn files_below(folder: &Path) -> Vec<String> {
    let entries = |folder: &Path| -> Vec<(String, PathBuf)> {
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let name = |path: &Path| Some(path.file_name()?.to_str()?.to_owned());
        paths
            .filter_map(|path| Some((name(&path)?, path)))
            .collect()
    };
    let mut files: Vec<String> = entries(folder)
        .into_iter()
        .flat_map(|(suite, path)| {
            let files = entries(&path).into_iter();
            files.map(move |(file, _)| format!("{suite}/{file}"))
        })
        .collect();
    files.sort();
    files
}

impl GoldenScene {
    /// Reads a scene by its name.
    pub(crate) fn read(name: &str) -> Self {
        let file = path("scenes/golden").join(format!("{name}.toml"));
        let scene = Scene::read(&file).unwrap_or_else(|error| panic!("{error}"));
        let folder = file.parent().expect("a file lies in a folder").to_owned();
        Self {
            name: name.to_owned(),
            scene,
            folder,
        }
    }

    /// What is kept as pictures, if anything.
    pub(crate) fn golden(&self) -> Option<&Golden> {
        self.scene.golden.as_ref()
    }

    /// What it shows.
    pub(crate) fn world(&self) -> Arc<World> {
        world(&self.scene, &self.folder)
    }

    /// The size and the numbers of the frames that are kept.
    fn kept(&self) -> (ImageSize, Vec<u32>) {
        match &self.scene.golden {
            Some(golden) => (golden.size, golden.frames.clone()),
            None => (self.scene.size, (0..self.scene.frames).collect()),
        }
    }

    /// Draws the frames that are kept; the others are committed, since a ledger counts what changed
    /// since the frame before.
    pub(crate) fn draw(&self) -> Vec<Drawn> {
        let world = self.world();
        let raster = Options {
            tile: TileSize::Side64,
            counters: Counters::Exact,
        };
        let (size, frames) = self.kept();
        let fail = |error| panic!("{}: {error}", self.name);
        let options = SessionOptions {
            size,
            ..SessionOptions::of(&self.scene, raster).unwrap_or_else(fail)
        };
        let mut session = Session::new(&self.scene, &world, &options)
            .unwrap_or_else(|error| panic!("{}: {error}", self.name));
        let mut next = 0;
        let mut drawn = Vec::new();
        for number in frames {
            for skipped in next..number {
                session.skip(skipped).expect("a session's own device");
            }
            next = number + 1;
            let frame = session.frame(number).expect("a session's own device");
            drawn.push(Drawn {
                name: frame_name(&self.name, number),
                frame,
                context: Context {
                    size,
                    samples: options.samples,
                    initial: session.initial().clone(),
                },
            });
        }
        drawn
    }
}

/// The name of a frame: `SUITE/NAME-FRAME`.
pub(crate) fn frame_name(scene: &str, frame: u32) -> String {
    format!("{scene}-{frame:04}")
}

/// What decides a world: the folder that paths start from, the trees, where collapse stops.
type WorldKey = (PathBuf, Vec<Tree>, Option<u32>);

/// Worlds that were built already: most scenes differ in the model alone.
static WORLDS: Mutex<Vec<(WorldKey, Arc<World>)>> = Mutex::new(Vec::new());

fn world(scene: &Scene, folder: &Path) -> Arc<World> {
    let key = (
        folder.to_owned(),
        scene.trees.clone(),
        scene.model.stop_leaves,
    );
    // Held while building, so that nobody builds the same.
    let mut worlds = WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, world)) = worlds.iter().find(|(known, _)| *known == key) {
        return Arc::clone(world);
    }
    let world = World::build(scene, folder, &Silent).unwrap_or_else(|error| panic!("{error}"));
    let world = Arc::new(world);
    worlds.push((key, Arc::clone(&world)));
    world
}
