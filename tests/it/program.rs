//! The program itself, and the small scenes that several tests give it.

use std::path::Path;
use std::process::{Command, Output};

/// A walk away from a small broom, of few leaves so that every command is quick.
pub(crate) const BROOM: &str = r#"schema = "spinney.scene/1"
size = [64, 48]
frames = 3

[[tree]]
species = "shrub.toml"

[camera]
path = [
    { frame = 0, eye = [0.0, 1.0, 6.0], target = [0.0, 1.0, 0.0] },
    { frame = 2, eye = [0.0, 1.0, 40.0], target = [0.0, 1.0, 0.0] },
]

[model]
mode = "slots"
"#;

/// The program about to start in a folder, with nothing of the user's.
pub(crate) fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_spinney"));
    // What is built must not come from another build.
    program.env_remove("XDG_CACHE_HOME").env_remove("HOME");
    program.env_remove("COLUMNS");
    program.args(arguments).current_dir(folder);
    program
}

/// Runs it.
pub(crate) fn spinney(folder: &Path, arguments: &[&str]) -> Output {
    let output = program(folder, arguments).output();
    output.expect("the program starts")
}

/// The shipped lentisk, a broom, with so many leaves, of which collapses leave so many.
pub(crate) fn shrub(leaves: u32, stop: u32) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = path.join("scenes/species/pistacia_lentiscus.toml");
    let text = std::fs::read_to_string(path).expect("the shipped species");
    let small = text
        .replacen("leaf_count = 5594", &format!("leaf_count = {leaves}"), 1)
        .replacen("stop_leaves = 90", &format!("stop_leaves = {stop}"), 1);
    assert!(small != text, "the species says how many");
    small
}

/// A walk past two brooms of one species, with some pixels and frames.
pub(crate) fn walk_past_two(species: &str, size: [u32; 2], frames: u32) -> String {
    let last = frames - 1;
    format!(
        r#"schema = "spinney.scene/1"
size = {size:?}
frames = {frames}

[[tree]]
species = "{species}"

[[tree]]
species = "{species}"
seed = 2
at = [1.5, 0.0, -1.0]

[camera]
path = [
    {{ frame = 0, eye = [0.0, 1.2, 3.0], target = [0.4, 0.9, 0.0] }},
    {{ frame = {last}, eye = [2.0, 1.2, 9.0], target = [0.4, 0.9, 0.0] }},
]

[model]
mode = "slots"
detail = "variable"
d_min = 2.0
d_max = 9.0
"#
    )
}
