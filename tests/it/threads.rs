//! What the program leaves on disk says nothing of how many threads wrote it.

use std::collections::BTreeMap;
use std::path::Path;

use crate::program::{program, walk_past_two};
use crate::support::contents;

/// How the program is told: `--threads`, `RAYON_NUM_THREADS`.
const TOLD: [[Option<&str>; 2]; 4] = [
    [Some("1"), None],
    [Some("64"), None],
    [None, Some("3")],
    [None, None],
];

#[test]
fn run_folders_are_the_same_with_any_number_of_threads() {
    let arguments = ["run", "scene.toml", "--layers", "--counters", "exact"];
    let kinds = [
        "csv", "exr", "html", "json", "jsonl", "png", "spinney", "toml",
    ];
    assert_same_folders(
        &arguments,
        &kinds,
        &["frame-0002.exr", "ledger.json", "trace.json"],
    );
}

#[test]
fn sweep_folders_are_the_same_with_any_number_of_threads() {
    let arguments = ["sweep", "scene.toml", "--steps", "3"];
    assert_same_folders(
        &arguments,
        &["csv", "html", "json", "md", "spinney", "svg"],
        &["sweep.csv"],
    );
}

/// Runs the program in every way it can be told of threads, and compares the folders, which must
/// hold files of just these kinds, these among them.
fn assert_same_folders(arguments: &[&str], kinds: &[&str], named: &[&str]) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let species = Path::new(env!("CARGO_MANIFEST_DIR"));
    let species = species.join("scenes/species/pistacia_lentiscus.toml");
    std::fs::copy(species, folder.path().join("shrub.toml")).expect("the shipped species");
    // Several tiles, and more bytes of picture than one thread digests.
    let scene = walk_past_two("shrub.toml", [224, 160], 3);
    std::fs::write(folder.path().join("scene.toml"), scene).expect("writable");
    let mut wanted = None;
    for [threads, environment] in TOLD {
        let mut program = program(folder.path(), arguments);
        program.args(["-o", "out"]).env_remove("RAYON_NUM_THREADS");
        if let Some(threads) = threads {
            program.args(["--threads", threads]);
        }
        if let Some(threads) = environment {
            program.env("RAYON_NUM_THREADS", threads);
        }
        let output = program.output().expect("the program starts");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        let out = folder.path().join("out");
        let mut files = BTreeMap::from([("standard output".to_owned(), output.stdout)]);
        contents(&out, "", &mut files);
        std::fs::remove_dir_all(out).expect("writable");
        let Some(wanted) = &wanted else {
            let kind = |file: &String| Some(file.rsplit_once('.')?.1.to_owned());
            let mut found: Vec<_> = files.keys().filter_map(kind).collect();
            found.sort_unstable();
            found.dedup();
            assert_eq!(found, kinds, "kinds of files");
            for file in named {
                assert!(files.contains_key(*file), "{file} is missing");
            }
            wanted = Some(files);
            continue;
        };
        let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&files), names(wanted), "{threads:?}, {environment:?}");
        for (file, bytes) in &files {
            assert!(
                *bytes == wanted[file],
                "{file} differs: {threads:?}, {environment:?}"
            );
        }
    }
}
