//! A run's folder explains itself: it runs anew wherever it lies, tells what a pixel shows, and where
//! two runs part.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// Three frames of a broom of 600 leaves, far enough to collapse.
const SCENE: &str = r#"schema = "spinney.scene/1"
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

fn spinney(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_spinney"))
        .args(arguments)
        .current_dir(folder)
        .env("COLUMNS", "80")
        .output()
        .expect("the program starts")
}

/// What the program prints when it ends with `code`.
fn printed(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = spinney(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("below the folder")).expect("a folder");
    std::fs::write(path, bytes).expect("writable");
}

/// The shipped lentisk with 600 leaves and `more` keys of its leaves.
fn shrub(more: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species/pistacia_lentiscus.toml");
    let text = std::fs::read_to_string(path).expect("the shipped species");
    let small = text
        .replacen("leaf_count = 5594", "leaf_count = 600", 1)
        .replacen("stop_leaves = 90", "stop_leaves = 20", 1)
        .replacen("[leaves]", &format!("[leaves]\n{more}"), 1);
    for part in ["= 600", "= 20 ", more] {
        assert!(small.contains(part), "{small}");
    }
    small
}

/// A folder with `scene.toml` and its species.
fn folder() -> TempDir {
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
    write(here, "kinds/shrub.toml", shrub("bare = 0.3\n"));
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
    let output = spinney(here, &["run", "pinned.toml"]);
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
