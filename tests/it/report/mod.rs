//! What runs and walks leave behind: keys, sums, states, pages, and the same bytes every time.

mod run;
mod sweep;

use std::collections::BTreeMap;
use std::path::Path;

use spinney::document::Document;
use spinney::math::{Quat, Vec3};
use spinney::models::Placement;
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::{OutputFolder, Page, RunFolder, RunHeader, frame_layers, write_sweep};
use spinney::run::{Frame, Session, SessionOptions, StandingTree, Variant, World};
use spinney::scene::{Scene, SceneFile};

use self::sweep::{pictured_sweep, sweep_header};
use crate::support::random_crown;

/// Two trees of 40 leaves, seen by a camera that walks away.
fn world() -> World {
    let stand = |x, scale| StandingTree {
        crown: 0,
        placement: Placement {
            position: Vec3::new(x, 0.0, 0.0),
            rotation: Quat::IDENTITY,
            scale,
        },
    };
    World::of(
        vec![random_crown(5, 40, 6)],
        vec![stand(-1.0, 1.0), stand(1.5, 1.4)],
    )
}

fn scene(mode: &str, detail: &str) -> Scene {
    let text = format!(
        "schema = \"spinney.scene/1\"\nname = \"tiny\"\nsize = [48, 32]\nframes = 5\n\
         [[tree]]\nspecies = \"none.toml\"\n\
         [camera]\npath = [{{ frame = 0, eye = [0, 0, 4], target = [0, 0, 0] }}, \
         {{ frame = 4, eye = [1, 1, 12], target = [0, 0, 0] }}]\n\
         [model]\nname = \"lodf\"\nmode = \"{mode}\"\ndetail = \"{detail}\"\nd_min = 4\nd_max = 12\n"
    );
    let file = "tiny.toml".to_owned();
    SceneFile::parse(Document { file, text })
        .expect("a sound scene")
        .scene
}

fn options(scene: &Scene) -> SessionOptions {
    let raster = Options {
        tile: TileSize::Side32,
        counters: Counters::Exact,
    };
    SessionOptions::of(scene, raster).expect("known names")
}

/// The header of a run that nobody holds the memory figures against.
fn run_header(scene: &Scene) -> RunHeader {
    let options = options(scene);
    RunHeader {
        scene: scene.name.clone(),
        scene_digest: scene.digest(),
        model: options.kind.label(),
        link: options.link,
        card: options.card,
        size: [48, 32],
        samples: 1,
        resolved: "# resolved\n".to_owned(),
        resident: Vec::new(),
    }
}

/// A run written to `target`, with layers; its frames.
fn run_into(target: &Path, scene: &Scene) -> Vec<Frame> {
    let world = world();
    let options = options(scene);
    let mut session = Session::new(scene, &world, &options).expect("memory suffices");
    let header = RunHeader {
        resident: session.device().resident_by_label(),
        ..run_header(scene)
    };
    let mut folder = RunFolder::create(target, header, session.initial()).expect("a new folder");
    let mut frames = Vec::new();
    for number in 0..scene.frames {
        let frame = session.frame(number).expect("a sound frame");
        folder.add(&frame).expect("room on the disk");
        let layers = frame_layers(&session, &world, options.kind, options.model, &frame);
        folder.add_layers(number, layers).expect("room on the disk");
        frames.push(frame);
    }
    let rows = folder.finish().expect("room on the disk");
    assert_eq!(rows.len(), frames.len(), "a row a frame");
    frames
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).expect("the run wrote it")
}

/// Every file below a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        let name = path
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            let below = files(&path).into_iter();
            found.extend(below.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            found.insert(name, std::fs::read(&path).expect("readable"));
        }
    }
    found
}

/// The keys of an object in the order of the file: a reader that sorts them would not see it.
fn keys_in_order(json: &str) -> Vec<String> {
    let (mut depth, mut keys, mut text, mut quoted) = (0, Vec::new(), String::new(), false);
    let mut characters = json.chars().peekable();
    while let Some(character) = characters.next() {
        match character {
            '"' => {
                if quoted && depth == 1 && characters.peek() == Some(&':') {
                    keys.push(text.clone());
                }
                text.clear();
                quoted = !quoted;
            }
            '{' | '[' if !quoted => depth += 1,
            '}' | ']' if !quoted => depth -= 1,
            _ if quoted => text.push(character),
            _ => {}
        }
    }
    keys
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

/// Nothing in a page leads out of it.
fn assert_self_contained(html: &str) {
    assert!(html.len() < Page::MAX_BYTES, "{} bytes", html.len());
    // One script, which stands in the page, and a browser that may load nothing whatever it does.
    assert_eq!(html.matches("<script").count(), 1, "scripts");
    let policy = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; ";
    let is_strict = html.contains("<script>\"use strict\";");
    assert!(html.contains(policy) && is_strict, "its policy, its script");
    for way in ["<link", "<iframe", "<object", "@import", "url("] {
        assert!(!html.contains(way), "{way}");
    }
    for (attribute, allowed) in [("src=\"", "data:image/png;base64,"), ("href=\"", "#")] {
        for rest in html.split(attribute).skip(1) {
            assert!(rest.starts_with(allowed), "{}", &rest[..40]);
        }
    }
    // The only address is the name of SVG itself.
    let names = html.matches("xmlns=\"http://www.w3.org/2000/svg\"").count();
    let addresses = html.matches("http").count() - html.matches("http-equiv").count();
    assert_eq!(addresses, names, "addresses");
}

/// In a pool of so many threads.
fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().expect("threads").install(work)
}

#[test]
fn threads_leave_no_trace() {
    let root = tempfile::tempdir().unwrap();
    let [one, seven] = [1, 7].map(|threads| {
        let target = root.path().join(threads.to_string());
        with_threads(threads, || {
            run_into(&target.join("run"), &scene("slots", "variable"));
            let folder = OutputFolder::create(&target.join("sweep")).unwrap();
            let (sweep, pictures) = pictured_sweep(&Variant::ALL);
            write_sweep(&folder, &sweep_header(), &sweep, None, &pictures).unwrap();
            folder.commit().unwrap();
        });
        files(&target)
    });
    assert_eq!(one.len(), 29);
    assert!(one == seven, "the same files with the same bytes");
}
