//! The program as a user meets it: exit codes, messages with a place, nothing left behind.

use std::path::{Path, PathBuf};
use std::process::Output;

use tempfile::TempDir;

use crate::program::{BROOM, spinney};

/// A folder with `scene.toml` and `shrub.toml`, each with a text replaced.
fn folder(scene: (&str, &str), species: (&str, &str)) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shrub = std::fs::read_to_string(repository("scenes/species/pistacia_lentiscus.toml"))
        .expect("the shipped species");
    for (name, text, (from, to)) in [
        ("scene.toml", BROOM, scene),
        ("shrub.toml", shrub.as_str(), species),
    ] {
        assert!(text.contains(from), "{name} says {from:?}");
        std::fs::write(folder.path().join(name), text.replacen(from, to, 1)).expect("writable");
    }
    folder
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// What must hold of a run that is refused: the code, all of `parts` in one error on standard
/// error, nothing on standard output, and no output left behind.
fn assert_refused(folder: &Path, arguments: &[&str], code: i32, parts: &[&str]) {
    let before = listing(folder);
    let output = spinney(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    for part in parts {
        assert!(
            said.contains(part),
            "{arguments:?}: {part:?} is not in {said:?}"
        );
    }
    assert!(
        output.stdout.is_empty(),
        "{}",
        String::from_utf8_lossy(&output.stdout)
    );
    assert_eq!(
        listing(folder),
        before,
        "{arguments:?} left something behind"
    );
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder).expect("readable") {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                pending.push(path.clone());
            }
            found.push(path);
        }
    }
    found.sort();
    found
}

const SAME: (&str, &str) = ("", "");
const RUN: [&str; 2] = ["run", "scene.toml"];

#[test]
fn wrong_scenes_are_refused_with_file_line_and_column() {
    for (scene, parts) in [
        (("frames = 3", "framse = 3"), ["scene.toml:3:1:", "framse"]),
        (
            ("frames = 3", "frames = \"three\""),
            ["scene.toml:3:10:", "three"],
        ),
        (
            ("eye = [0.0, 1.0, 6.0]", "eye = [nan, 1.0, 6.0]"),
            ["scene.toml:10:", "nan"],
        ),
        (
            ("size = [64, 48]", "size = [-64, 48]"),
            ["scene.toml:2:", "-64"],
        ),
        (
            ("size = [64, 48]", "size = [0, 48]"),
            ["scene.toml:2:", "0"],
        ),
        (
            ("size = [64, 48]", "size = [1000000, 1000000]"),
            ["scene.toml:2:", "1000000"],
        ),
        (
            ("mode = \"slots\"", "mode = \"slats\""),
            ["scene.toml:15:8:", "slats"],
        ),
        (("shrub.toml", "none.toml"), ["none.toml", "cannot read"]),
        (("frames = 3", "frames = "), ["scene.toml:3:", ""]),
    ] {
        let folder = folder(scene, SAME);
        assert_refused(folder.path(), &RUN, 2, &parts);
    }
}

#[test]
fn wrong_species_are_refused_with_file_line_and_column() {
    for (species, part) in [
        (("leaf_count = 5594", "leaf_count = 0"), "0"),
        (
            ("leaf_count = 5594", "leaf_count = 10000000000"),
            "10000000000",
        ),
        (("leaf_count = 5594", "leaf_count = 5594.5"), "5594.5"),
        (("leaf_count", "leave_count"), "leave_count"),
    ] {
        let folder = folder(SAME, species);
        assert_refused(folder.path(), &RUN, 2, &["shrub.toml:", part]);
        let grow = ["grow", "shrub.toml", "-o", "tree.glb"];
        assert_refused(folder.path(), &grow, 2, &["shrub.toml:", part]);
    }
}

#[test]
fn names_that_mean_nothing_are_refused_where_they_stand() {
    let device = format!("{BROOM}\n[device]\nlink = \"isa\"\n");
    let folder = folder(SAME, SAME);
    std::fs::write(folder.path().join("scene.toml"), device).expect("writable");
    assert_refused(
        folder.path(),
        &RUN,
        2,
        &["scene.toml:18:8:", "isa", "pcie1x16"],
    );
}

#[test]
fn too_small_a_memory_budget_is_exit_code_3() {
    let small = ("[model]", "[device]\nmemory = \"64 KiB\"\n\n[model]");
    let folder = folder(small, SAME);
    assert_refused(folder.path(), &RUN, 3, &["65536", "1081056"]);
}

#[test]
fn an_output_path_below_a_file_is_exit_code_4() {
    let folder = folder(SAME, SAME);
    for arguments in [
        ["run", "scene.toml", "-o", "shrub.toml/out"],
        ["sweep", "scene.toml", "-o", "shrub.toml/out"],
        ["grow", "shrub.toml", "-o", "shrub.toml/tree.glb"],
    ] {
        assert_refused(folder.path(), &arguments, 4, &["shrub.toml"]);
    }
}

#[test]
fn a_folder_that_is_not_ours_is_refused() {
    let folder = folder(SAME, SAME);
    let other = folder.path().join("other");
    std::fs::create_dir(&other).expect("writable");
    std::fs::write(other.join("notes.txt"), "mine").expect("writable");
    assert_refused(
        folder.path(),
        &["run", "scene.toml", "-o", "other"],
        4,
        &["other"],
    );
    assert_eq!(
        std::fs::read_to_string(other.join("notes.txt")).expect("still there"),
        "mine"
    );
}

#[test]
fn broken_plant_files_are_refused_with_a_byte_offset() {
    let folder = folder(SAME, SAME);
    let path = folder.path();
    assert!(
        spinney(path, &["grow", "shrub.toml", "-o", "whole.glb"])
            .status
            .success()
    );
    let whole = std::fs::read(path.join("whole.glb")).expect("just written");
    let mut hostile = whole.clone();
    hostile[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    for (name, bytes) in [
        ("cut.glb", &whole[..whole.len() / 2]),
        ("hostile.glb", &hostile),
    ] {
        std::fs::write(path.join(name), bytes).expect("writable");
        assert_refused(path, &["inspect", name], 2, &[name, "byte"]);
        let scene = BROOM.replace("species = \"shrub.toml\"", &format!("file = \"{name}\""));
        std::fs::write(path.join("broken.toml"), scene).expect("writable");
        assert_refused(path, &["run", "broken.toml"], 2, &[name, "byte"]);
    }
}

#[test]
fn bad_usage_is_exit_code_2() {
    let folder = folder(SAME, SAME);
    for arguments in [
        &["run"][..],
        &["run", "scene.toml", "--size", "0x0"],
        &["run", "scene.toml", "--size", "1000000x1000000"],
        &["run", "scene.toml", "--samples", "3"],
        &["run", "scene.toml", "--frames", "2..9"],
        &["run", "scene.toml", "--shard", "2/2"],
        &["run", "scene.toml", "--budget-bytes", "0"],
        &["run", "scene.toml", "--budget-bytes", "-4"],
        &["run", "scene.toml", "--budget-bytes", "4294967297"],
        &["run", "scene.toml", "--budget-bytes", "1 KiB"],
        &["run", "missing.toml"],
        &["sweep", "scene.toml", "--models", "magic"],
        &["sweep", "scene.toml", "--steps", "0"],
        &["inspect", "scene.txt"],
        &["dance"],
    ] {
        assert_refused(folder.path(), arguments, 2, &[]);
    }
}

#[test]
fn grown_plants_import_as_the_same_plant() {
    let folder = folder(SAME, SAME);
    let path = folder.path();
    let digest = |output: &Output| {
        let facts: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("JSON on standard output");
        facts["plant_digest"].as_str().expect("a digest").to_owned()
    };
    let grown = spinney(path, &["grow", "shrub.toml", "-o", "tree.glb", "--json"]);
    let read = spinney(path, &["inspect", "tree.glb", "--json"]);
    assert_eq!(digest(&grown), digest(&read));
}

#[test]
fn a_cache_of_models_changes_no_output() {
    let here = folder(("", ""), ("", ""));
    let run = |name: &str, arguments: &[&str]| {
        let all = [&["run", "scene.toml", "--json", "-o", name], arguments].concat();
        let output = spinney(here.path(), &all);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        std::fs::read(here.path().join(name).join("ledger.json")).expect("a ledger")
    };
    let none = run("none", &["--no-cache"]);
    let models = || {
        let entries = std::fs::read_dir(here.path().join("models")).expect("a folder");
        let paths = entries.map(|entry| entry.expect("readable").path());
        paths.collect::<Vec<PathBuf>>()
    };
    assert_eq!(run("missed", &["--cache", "models"]), none);
    let [model] = &models()[..] else {
        panic!("one model: {:?}", models());
    };
    assert_eq!(run("hit", &["--cache", "models"]), none);
    std::fs::write(model, "spoilt").expect("writable");
    assert_eq!(run("spoilt", &["--cache", "models"]), none);
    let both = ["run", "scene.toml", "--no-cache", "--cache", "models"];
    assert_refused(here.path(), &both, 2, &["--no-cache", "--cache"]);
}
