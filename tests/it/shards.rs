//! What several processes drew, joined, is what one draws: byte for byte.

use std::collections::BTreeMap;
use std::path::Path;

use crate::program::{shrub, spinney, walk_past_two};
use crate::support::contents;

/// A folder with the scene and its species.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = walk_past_two("below/shrub.toml", [96, 64], 6);
    std::fs::create_dir(folder.path().join("below")).expect("writable");
    std::fs::write(folder.path().join("below/shrub.toml"), shrub(300, 9)).expect("writable");
    std::fs::write(folder.path().join("scene.toml"), scene).expect("writable");
    folder
}

fn words(arguments: &str) -> Vec<&str> {
    arguments.split(' ').collect()
}

/// Runs the program, which must succeed; answers what it prints.
fn done(folder: &Path, arguments: &str) -> String {
    let output = spinney(folder, &words(arguments));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {said}");
    String::from_utf8(output.stdout).expect("text")
}

/// Runs the program, which must refuse its input; answers what it says.
fn refused(folder: &Path, arguments: &str) -> String {
    let output = spinney(folder, &words(arguments));
    assert_eq!(output.status.code(), Some(2), "{arguments}");
    String::from_utf8(output.stderr).expect("text")
}

fn assert_same(one: &Path, other: &Path) {
    let [mut ours, mut theirs] = [BTreeMap::new(), BTreeMap::new()];
    contents(one, "", &mut ours);
    contents(other, "", &mut theirs);
    let names = |found: &BTreeMap<String, Vec<u8>>| found.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&ours), names(&theirs), "files and folders");
    for (name, bytes) in &ours {
        assert!(*bytes == theirs[name], "{name} differs");
    }
}

#[test]
fn joined_shards_of_a_run_are_the_run() {
    let folder = folder();
    let folder = folder.path();
    let run = "run scene.toml --frames 1..6 --layers --counters exact";
    let whole = done(folder, &format!("{run} -o whole"));
    for shard in 0..3 {
        done(folder, &format!("{run} -o s{shard} --shard {shard}/3"));
    }
    // In any order.
    let joined = done(folder, "merge s2 s0 s1 -o joined");
    assert_same(&folder.join("whole"), &folder.join("joined"));
    assert_eq!(joined.replace("joined", "whole"), whole);
    // More shards than frames: some draw nothing.
    let run = "run scene.toml --frames 4..5";
    done(folder, &format!("{run} -o whole"));
    done(folder, &format!("{run} -o s0 --shard 0/2"));
    done(folder, &format!("{run} -o s1 --shard 1/2"));
    done(folder, "merge s0 s1 -o joined");
    assert_same(&folder.join("whole"), &folder.join("joined"));
}

#[test]
fn joined_shards_of_a_sweep_are_the_sweep() {
    let folder = folder();
    let folder = folder.path();
    let sweep = "sweep scene.toml --steps 4 --models vdf-host,lodf-slots-gathered,lodf-stamps";
    done(folder, &format!("{sweep} -o whole"));
    for shard in 0..2 {
        done(folder, &format!("{sweep} -o s{shard} --shard {shard}/2"));
    }
    done(folder, "merge s0 s1 -o joined");
    assert_same(&folder.join("whole"), &folder.join("joined"));
    // The pictures of the page come from the shards, and must be those that were written.
    let pictures = std::fs::read_dir(folder.join("s1/pictures")).expect("a folder");
    let pictures = pictures.map(|entry| entry.expect("readable").path());
    let pictures: Vec<_> = pictures.collect();
    assert_eq!(pictures.len(), 2, "levels 1 and 3, the same for all models");
    std::fs::copy(&pictures[0], &pictures[1]).expect("writable");
    let said = refused(folder, "merge s0 s1 -o other");
    assert!(
        said.contains("not the picture that was written there"),
        "{said}"
    );
    // More shards than steps: one draws nothing.
    for shard in 0..6 {
        done(folder, &format!("{sweep} -o s{shard} --shard {shard}/6"));
    }
    done(folder, "merge s0 s1 s2 s3 s4 s5 -o joined");
    assert_same(&folder.join("whole"), &folder.join("joined"));
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let folder = folder();
    let folder = folder.path();
    let run = "run scene.toml --frames 0..2";
    done(folder, &format!("{run} -o whole"));
    done(folder, &format!("{run} -o s0 --shard 0/2"));
    done(folder, &format!("{run} -o s1 --shard 1/2"));
    done(folder, &format!("{run} -o far --shard 1/2 --size 90x64"));
    let said = refused(folder, "merge s0 whole -o joined");
    assert!(said.contains("whole: holds no shard.jsonl"), "{said}");
    let said = refused(folder, "merge s0 -o joined");
    assert!(said.contains("s0: shard 1/2 is missing"), "{said}");
    let said = refused(folder, "merge s1 -o joined");
    assert!(said.contains("s1: shard 0/2 is missing"), "{said}");
    let said = refused(folder, "merge s0 s0 -o joined");
    assert!(said.contains("s0: shard 0/2 is there twice"), "{said}");
    let said = refused(folder, "merge s0 far -o joined");
    assert!(
        said.contains("from another scene or with other flags"),
        "{said}"
    );
    std::fs::copy(
        folder.join("s0/frame-0000.png"),
        folder.join("s1/frame-0001.png"),
    )
    .expect("writable");
    let said = refused(folder, "merge s0 s1 -o joined");
    assert!(
        said.contains("frame-0001.png: the picture has digest"),
        "{said}"
    );
    let path = folder.join("s0/shard.jsonl");
    let text = std::fs::read_to_string(&path).expect("text");
    for length in [0, 10, text.len() - 1] {
        std::fs::write(&path, &text[..length]).expect("writable");
        let said = refused(folder, "merge s0 s1 -o joined");
        assert!(said.contains("shard.jsonl"), "{said}");
    }
    let more = text + "{}\n";
    std::fs::write(&path, more).expect("writable");
    done(folder, &format!("{run} -o s1 --shard 1/2"));
    let said = refused(folder, "merge s0 s1 -o joined");
    assert!(said.contains("shard.jsonl:3: more lines"), "{said}");
    assert!(!folder.join("joined").exists());
}

#[test]
fn shards_of_scenes_that_cost_the_same_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let scene = std::fs::read_to_string(folder.join("scene.toml")).expect("text");
    // Neither sends a byte more or less, and the scene is called the same.
    let moved = scene.replace("eye = [0.0, 1.2, 3.0]", "eye = [0.0, 1.2, 4.0]");
    assert_ne!(scene, moved);
    std::fs::create_dir(folder.join("moved")).expect("writable");
    std::fs::create_dir(folder.join("moved/below")).expect("writable");
    std::fs::write(folder.join("moved/below/shrub.toml"), shrub(300, 9)).expect("writable");
    std::fs::write(folder.join("moved/scene.toml"), moved).expect("writable");
    let flags = "--steps 3 --models lodf-stamps --shard";
    done(folder, &format!("sweep scene.toml {flags} 0/2 -o s0"));
    for other in ["moved/scene.toml", "scene.toml --counters visible"] {
        done(folder, &format!("sweep {other} {flags} 1/2 -o s1"));
        let said = refused(folder, "merge s0 s1 -o joined");
        assert!(
            said.contains("s1") && said.contains("from another scene or with other flags"),
            "{other}: {said}"
        );
    }
    // A run whose counters differ.
    let run = "run scene.toml --frames 0..2";
    done(folder, &format!("{run} --shard 0/2 -o s0"));
    done(folder, &format!("{run} --shard 1/2 -o s1 --counters exact"));
    let said = refused(folder, "merge s0 s1 -o joined");
    assert!(said.contains("or with other flags"), "{said}");
    assert!(!folder.join("joined").exists());
}

#[test]
fn files_that_are_missing_from_a_shard_are_a_fault_of_the_input() {
    let folder = folder();
    let folder = folder.path();
    let run = "run scene.toml --frames 0..2 --layers";
    for shard in 0..2 {
        done(folder, &format!("{run} -o s{shard} --shard {shard}/2"));
    }
    let refused_for = |name: &str| {
        let said = refused(folder, "merge s0 s1 -o joined");
        let place = Path::new(name).display().to_string();
        assert!(
            said.contains(&place) && said.contains("cannot read"),
            "{said}"
        );
        assert!(!folder.join("joined").exists());
    };
    // The layers of a frame, then not even a file of that name.
    let layers = folder.join("s1/frame-0001.exr");
    let bytes = std::fs::read(&layers).expect("layers");
    std::fs::remove_file(&layers).expect("writable");
    refused_for("s1/frame-0001.exr");
    std::fs::create_dir(&layers).expect("writable");
    refused_for("s1/frame-0001.exr");
    std::fs::remove_dir(&layers).expect("writable");
    std::fs::write(&layers, bytes).expect("writable");
    done(folder, "merge s0 s1 -o whole");
    // What cannot be written is the other fault.
    std::fs::write(folder.join("file"), "").expect("writable");
    let output = spinney(folder, &words("merge s0 s1 -o file/joined"));
    assert_eq!(output.status.code(), Some(4), "{output:?}");
}
