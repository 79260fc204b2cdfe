//! Files that mean harm, and a program that is killed.

mod killed;
mod limits;
mod paths;

use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

/// A shrub of two hundred leaves, and a scene of it: in all, milliseconds.
const SPECIES: &str = "schema = \"spinney.species/1\"\nname = \"shrub\"\nleaf_count = 200\n\
    stop_leaves = 5\n[crown]\nlevels = 2\nscale = 2.0\n[stems]\nbranches = [1, 20, 1, 1]\n\
    [[foliage]]\nsilhouette = \"round\"\n";

const SCENE: &str = "schema = \"spinney.scene/1\"\nsize = [48, 32]\nframes = 6\n\
    tree = [{ species = \"shrub.toml\" }]\n\
    [camera]\npath = [{ eye = [0, 1, 5], target = [0, 1, 0] }, \
    { frame = 5, eye = [0, 1, 30], target = [0, 1, 0] }]\n";

/// A folder with the scene and its species.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("shrub.toml"), SPECIES).expect("writable");
    std::fs::write(folder.path().join("scene.toml"), SCENE).expect("writable");
    folder
}

/// The program with arguments, run in `folder`.
fn spinney(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_spinney"));
    command.env_remove("XDG_CACHE_HOME").env_remove("HOME");
    command.args(arguments).current_dir(folder);
    command
}

/// What the program says when it refuses, with its exit code.
fn refused(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let output = spinney(folder, arguments).output().expect("starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!said.contains("panicked"), "{arguments:?}: {said}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    (output.status.code().expect("not killed"), said)
}
