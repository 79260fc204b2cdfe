//! A run's folder explains itself: it runs anew wherever it lies, tells what a pixel shows, and where
//! two runs part.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Output;

use tempfile::TempDir;

use crate::program::{self, program};

/// Three frames of a broom of 600 leaves, far enough to collapse.
pub(crate) const SCENE: &str = r#"schema = "spinney.scene/1"
size = [64, 48]
frames = 3

[[tree]]
species = "kinds/shrub.toml"

[[tree]]
species = "kinds/shrub.toml"
at = [2.0, 0.0, -1.0]
turn = 40.0

[camera]
path = [
    { frame = 0, eye = [0.0, 1.0, 6.0], target = [0.0, 1.0, 0.0] },
    { frame = 2, eye = [0.0, 1.0, 30.0], target = [0.0, 1.0, 0.0] },
]

[model]
mode = "slots"
d_min = 5.0
d_max = 40.0
"#;

/// What the program says on a terminal of 80 columns.
fn said_by(folder: &Path, arguments: &[&str]) -> Output {
    let mut program = program(folder, arguments);
    program.env("COLUMNS", "80").output().expect("it starts")
}

/// What the program prints when it ends with `code`.
pub(crate) fn printed(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = said_by(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

pub(crate) fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("below the folder")).expect("a folder");
    std::fs::write(path, bytes).expect("writable");
}

/// A broom of 600 leaves with `more` keys of its leaves.
pub(crate) fn shrub(more: &str) -> String {
    let text = program::shrub(600, 20);
    let small = text.replacen("[leaves]", &format!("[leaves]\n{more}"), 1);
    assert!(small.contains(more), "{small}");
    small
}

/// A folder with `scene.toml` and its species.
pub(crate) fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(folder.path(), "scene.toml", SCENE);
    write(folder.path(), "kinds/shrub.toml", shrub(""));
    folder
}

/// All files below a folder with their bytes.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(next) = pending.pop() {
        for entry in std::fs::read_dir(next).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                pending.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("below").to_owned();
                found.insert(name, std::fs::read(path).expect("readable"));
            }
        }
    }
    found
}

#[test]
fn a_run_runs_anew_from_its_folder_alone() {
    let here = folder();
    let here = here.path();
    printed(here, &["run", "scene.toml", "-o", "out/x"], 0);
    let first = files(&here.join("out/x"));
    assert_eq!(
        first[Path::new("plants/shrub.toml")],
        shrub("").into_bytes()
    );
    // The species changes, the run moves, and is run from elsewhere.
    write(here, "kinds/shrub.toml", shrub("omit = [7]\n"));
    let there = tempfile::tempdir().expect("a temporary folder");
    let moved = there.path().join("kept");
    std::fs::create_dir_all(&moved).expect("a folder");
    for (name, bytes) in &first {
        write(&moved, name.to_str().expect("UTF-8"), bytes);
    }
    let scene = moved.join("scene.resolved.toml");
    printed(here, &["run", scene.to_str().expect("UTF-8"), "-o", "y"], 0);
    let second = files(&here.join("y"));
    assert_eq!(
        first.keys().collect::<Vec<_>>(),
        second.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &first {
        assert!(second[name] == *bytes, "{}", name.display());
    }
    // What the original scene gives now is another tree, and says so when it is pinned.
    let pinned = std::fs::read_to_string(&scene).expect("readable");
    write(here, "pinned.toml", pinned.replace("plants/", "kinds/"));
    let output = said_by(here, &["run", "pinned.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("has digest"));
}

#[test]
fn plant_files_take_along_what_lies_beside_them() {
    let here = folder();
    let here = here.path();
    printed(here, &["grow", "kinds/shrub.toml", "-o", "shrub.glb"], 0);
    let glb = std::fs::read(here.join("shrub.glb")).expect("readable");
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes"));
    let json = 20..20 + word(12) as usize;
    let text = String::from_utf8(glb[json.clone()].to_vec()).expect("JSON");
    let uri = "\"buffers\":[{\"uri\":\"../far%20away/tree.bin\",";
    let document = text.replacen("\"buffers\":[{", uri, 1);
    assert!(document.contains(uri), "{document}");
    write(here, "kinds/one/tree.gltf", &document);
    write(here, "kinds/far away/tree.bin", &glb[json.end + 8..]);
    let with = |file: &str, name: &str| {
        let species = "species = \"kinds/shrub.toml\"";
        let scene = SCENE.replace(species, &format!("file = \"{file}\""));
        write(here, name, scene);
    };
    with("kinds/one/tree.gltf", "apart.toml");
    with("shrub.glb", "whole.toml");
    for name in ["apart", "whole"] {
        let scene = format!("{name}.toml");
        printed(here, &["run", &scene, "-o", name], 0);
        let again = format!("{name}/scene.resolved.toml");
        printed(here, &["run", &again, "-o", "again"], 0);
        assert!(
            files(&here.join(name)) == files(&here.join("again")),
            "{name}"
        );
    }
    let copies = files(&here.join("apart/plants"));
    let names: Vec<_> = copies
        .keys()
        .map(|name| name.display().to_string())
        .collect();
    assert_eq!(names, ["tree/below/tree.gltf", "tree/far away/tree.bin"]);
    assert!(here.join("whole/plants/shrub.glb").is_file());
}

/// What `--json` tells.
pub(crate) fn told(folder: &Path, arguments: &[&str], code: i32) -> serde_json::Value {
    let text = printed(folder, &[&["explain", "--json"], arguments].concat(), code);
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn one_leaf_less_is_named() {
    let here = folder();
    let here = here.path();
    printed(here, &["run", "scene.toml", "-o", "a"], 0);
    write(here, "kinds/shrub.toml", shrub("omit = [312]\n"));
    printed(here, &["run", "scene.toml", "-o", "b"], 0);
    let report = told(here, &["a", "b"], 1);
    assert_eq!(report["schema"], "spinney.explain/1");
    assert_eq!(report["plant_files"][0]["keys"][0]["key"], "leaves.omit");
    assert_eq!(report["asked_count"], 0);
    let plants = report["plants"].as_array().expect("a list");
    assert_eq!(plants.len(), 1, "both trees are of one plant");
    let plant = &plants[0];
    assert_eq!(plant["only_a_count"], 1);
    assert_eq!(plant["only_a"][0]["leaf"], 312);
    assert_eq!([&plant["only_b_count"], &plant["moved_count"]], [0, 0]);
    assert_eq!(plant["renumbered"], 599 - 312);
    assert_eq!(plant["parts"], serde_json::json!([]));
    let branch = plant["only_a"][0]["branch"].as_u64().expect("it grew");
    let summary = report["summary"].as_str().expect("a sentence");
    let start = format!("leaf 312 of tree 0 (branch {branch}) stands in A alone; ");
    assert!(summary.starts_with(&start), "{summary}");
    assert!(
        summary.contains("the runs part before the first frame"),
        "{summary}"
    );
    // The leaf's four vertices are what one device has more.
    let vertices = report["buffers"].as_array().expect("a list");
    let vertices = vertices
        .iter()
        .find(|buffer| buffer["label"] == "leaf vertices");
    let inserted = &vertices.expect("they differ")["inserted"];
    assert_eq!([&inserted["start"], &inserted["end"]], [312 * 48, 313 * 48]);
    assert!(
        inserted["record"]
            .as_str()
            .expect("words")
            .contains("leaf 312, corner 0")
    );
    let pixels = report["frames"][0]["pixels"].as_u64().expect("a count");
    assert!((1..64 * 48).contains(&pixels), "{pixels}");
    // The other way round it is B's.
    let back = told(here, &["b", "a"], 1);
    assert_eq!(back["plants"][0]["only_b"][0]["leaf"], 312);
    let text = printed(here, &["explain", "a", "b"], 1);
    assert!(text.contains("leaf 312 of tree 0"), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );
}

#[test]
fn equal_runs_are_the_same_and_others_are_none() {
    let here = folder();
    let here = here.path();
    printed(here, &["run", "scene.toml", "-o", "a"], 0);
    printed(here, &["run", "scene.toml", "-o", "b", "--threads", "1"], 0);
    let text = printed(here, &["explain", "a", "b"], 0);
    assert!(text.contains("same"), "{text}");
    assert_eq!(told(here, &["a", "b"], 0)["same"], true);
    for arguments in [
        &["explain", "a", "kinds"][..],
        &["explain", "a"],
        &["explain", "a", "--pixel", "64,0"],
        &["explain", "a", "--pixel", "0,0", "--frame", "3"],
        &["explain", "a", "b", "--pixel", "0,0"],
    ] {
        assert_eq!(printed(here, arguments, 2), "", "{arguments:?}");
    }
}

#[test]
fn two_modes_have_the_same_leaves_and_send_other_bytes() {
    let here = folder();
    let here = here.path();
    printed(here, &["run", "scene.toml", "-o", "a"], 0);
    write(
        here,
        "scene.toml",
        SCENE.replace("\"slots\"", "\"cluster\""),
    );
    printed(here, &["run", "scene.toml", "-o", "b"], 0);
    let report = told(here, &["a", "b"], 1);
    for list in ["plants", "sequences", "frames", "plant_files"] {
        assert_eq!(report[list], serde_json::json!([]), "{list}");
    }
    assert_eq!(report["asked"][0]["key"], "model.mode");
    let summary = report["summary"].as_str().expect("a sentence");
    for part in [
        "A asks for model.mode",
        "all leaves",
        "all pictures are the same",
    ] {
        assert!(summary.contains(part), "{summary}");
    }
    let operation = &report["operation"];
    assert!(
        operation["a"]["sent"] != operation["b"]["sent"],
        "{operation}"
    );
}

#[test]
fn a_pixel_is_what_the_run_showed_or_says_so() {
    let here = folder();
    let here = here.path();
    write(
        here,
        "scene.toml",
        SCENE.replace("frames", "samples = 4\nframes"),
    );
    printed(here, &["run", "scene.toml", "-o", "a"], 0);
    let pixel = ["a", "--pixel", "31,25", "--frame", "1"];
    let report = told(here, &pixel, 0);
    assert_eq!([&report["agrees"], &report["frame"]["same"]], [true, true]);
    let samples = report["samples"].as_array().expect("a list");
    assert_eq!(samples.len(), 4);
    let shows = samples.iter().find_map(|sample| sample["shows"].as_u64());
    let shows = usize::try_from(shows.expect("the broom is there")).expect("small");
    assert!(
        ["leaf", "trunk"].contains(&report["fragments"][shows]["what"].as_str().expect("a word"))
    );
    let text = printed(here, &[&["explain"][..], &pixel].concat(), 0);
    assert!(text.contains("rivals"), "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 80),
        "{text}"
    );

    let path = here.join("a/ledger.json");
    let ledger = std::fs::read_to_string(&path).expect("readable");
    let at = ledger.find("image_digest").expect("frames have digests") + 15;
    let digit = if &ledger[at..=at] == "0" { "1" } else { "0" };
    std::fs::write(&path, [&ledger[..at], digit, &ledger[at + 1..]].concat()).expect("writable");
    let report = told(here, &["a", "--pixel", "31,25"], 1);
    assert_eq!(report["frame"]["same"], false);
}

/// The microscope and the rasterizer are two ways to one picture: each pixel's least fragment by
/// depth and key is what shows.
#[test]
fn probed_pixels_are_what_is_drawn() {
    use spinney::raster::{Counters, Options, TileSize};
    use spinney::run::{Session, SessionOptions, Silent, World};
    use spinney::scene::SceneFile;

    let here = folder();
    for (mode, samples) in [("slots", 1), ("stamps", 4)] {
        let scene = SCENE
            .replace("\"slots\"", &format!("{mode:?}"))
            .replace("[64, 48]", "[24, 18]")
            .replace("frames", &format!("samples = {samples}\nframes"));
        write(here.path(), "scene.toml", scene);
        let file = SceneFile::read(&here.path().join("scene.toml")).expect("a sound scene");
        let world = World::build(&file.scene, here.path(), &Silent).expect("it grows");
        let raster = Options {
            tile: TileSize::Side32,
            counters: Counters::Visible,
        };
        let options = SessionOptions::of(&file.scene, raster).expect("known names");
        let mut session = Session::new(&file.scene, &world, &options).expect("it fits");
        for frame in 0..2 {
            session.frame(frame).expect("our own device");
        }
        let target = session.device().inspect_target(session.target());
        let target = target.expect("a session keeps its target");
        let mut hidden = 0;
        for (x, y) in (0..18).flat_map(|y| (0..24).map(move |x| (x, y))) {
            let fragments = session.probe([x, y]).expect("our own pass");
            let mut colours = Vec::new();
            for sample in 0..samples {
                let kept = fragments.iter().filter(|fragment| fragment.kept);
                let here = kept.filter_map(|one| Some((one.depths[sample]?, one)));
                hidden += here.clone().count().saturating_sub(1);
                let least = here.min_by_key(|(depth, one)| (depth.to_bits(), one.key));
                if sample == 0 {
                    assert_eq!(target.key(x, y), least.map(|(_, one)| one.key), "{x},{y}");
                    let depth = least.map_or(1.0, |(depth, _)| depth);
                    assert_eq!(target.depth(x, y).to_bits(), depth.to_bits(), "{x},{y}");
                }
                colours.push(least.map_or(session.background(), |(_, one)| one.colour));
            }
            let colour = match *colours {
                [a, b, c, d] => ((a + b) + (c + d)) * 0.25,
                _ => colours[0],
            };
            assert_eq!(target.colour(x, y), colour, "{x},{y}");
        }
        assert!(hidden > 10, "something hides something: {hidden}");
    }
}

/// A triangle of a trunk begins at the ring around the node that is told.
#[test]
fn trunk_triangles_know_their_branch_and_node() {
    use spinney::explain::{RecordedRun, Replay, explain_pixel};
    use spinney::run::Silent;

    let here = folder();
    printed(here.path(), &["run", "scene.toml", "-o", "a"], 0);
    let run = RecordedRun::read(&here.path().join("a")).expect("a run");
    let world = run.world(&Silent).expect("its own copies");
    let mut replay = Replay::new(&run, &world).expect("it fits");
    replay.draw_next().expect("its own states");
    let session = replay.session();
    let target = session.device().inspect_target(session.target());
    let target = target.expect("a session keeps its target");
    let pixels = (0..48).flat_map(|y| (0..64).map(move |x| [x, y]));
    let wood: Vec<[u32; 2]> = pixels
        .filter(|&[x, y]| target.key(x, y).is_some_and(|key| key.group == 0))
        .collect();
    assert!(wood.len() > 10, "{wood:?}");
    for pixel in [wood[0], wood[wood.len() / 2], wood[wood.len() - 1]] {
        let report = explain_pixel(&run, None, pixel, &Silent).expect("a pixel of it");
        let shown = report.samples[0].shows.expect("the trunk");
        let place = &report.fragments[usize::try_from(shown).expect("small")];
        let trunk = place.trunk.as_ref().expect("a triangle of it");
        let branch = trunk.branch.as_ref().expect("it grew");
        let crown = &world.crowns[world.trees[place.tree as usize].crown];
        let skeleton = crown.plant().skeleton().expect("it grew");
        let found = &skeleton.branches[branch.branch as usize];
        assert_eq!(
            (found.level, found.node_count),
            (branch.level, branch.nodes)
        );
        let nodes = skeleton.nodes_of(found);
        let node = nodes[branch.node as usize];
        let lowest = (0..3)
            .min_by_key(|&corner| trunk.vertices[corner])
            .expect("three");
        let corner = spinney::math::Vec3::from_array(trunk.plant[lowest]);
        // On the ring, but for the bulges of trunks with lobes.
        let away = corner.distance(node.position);
        let ring = 0.5 * node.radius..=1.5 * node.radius;
        assert!(
            ring.contains(&away),
            "{pixel:?}: {away} from a node of {ring:?}"
        );
    }
}
