//! A run that is killed at any moment leaves no file under its final name that is not whole.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use spinney::report::{ImageFile, MARKER};

use super::{folder, spinney};

/// The names in a folder.
fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    names.map(|name| name.expect("ours are UTF-8")).collect()
}

/// Every file below a folder that is there, relative to it.
fn files(folder: &Path, prefix: &str, found: &mut BTreeSet<String>) {
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            files(&path, &format!("{prefix}{name}/"), found);
        } else {
            found.insert(format!("{prefix}{name}"));
        }
    }
}

/// Whether a run's folder is there; and if so, it is whole.
fn is_whole(run: &Path) -> bool {
    if !run.exists() {
        return false;
    }
    let mut found = BTreeSet::new();
    files(run, "", &mut found);
    let marker = std::fs::read_to_string(run.join(MARKER)).expect("a marker");
    let listed: BTreeSet<String> = marker.lines().skip(1).map(str::to_owned).collect();
    assert!(found.remove(MARKER), "the marker was read");
    assert_eq!(found, listed, "the marker lists all");
    for name in &found {
        let path = run.join(name);
        let bytes = std::fs::read(&path).expect("a file");
        if name.ends_with(".json") {
            serde_json::from_slice::<serde_json::Value>(&bytes).expect("whole JSON");
        } else if name.ends_with(".jsonl") {
            for line in bytes
                .split(|byte| *byte == b'\n')
                .filter(|line| !line.is_empty())
            {
                serde_json::from_slice::<serde_json::Value>(line).expect("whole lines");
            }
            assert!(bytes.ends_with(b"\n"), "{name} ends with a line");
        } else if name.ends_with(".png") || name.ends_with(".exr") {
            ImageFile::read(&path).expect("a whole image");
        } else if name.ends_with(".html") {
            assert!(bytes.ends_with(b"</html>\n"), "{name} ends");
        }
    }
    for name in [
        "ledger.json",
        "ledger.csv",
        "ops.jsonl",
        "report.html",
        "scene.resolved.toml",
    ] {
        assert!(found.contains(name), "{name}");
    }
    true
}

/// Starts a run, kills it after some milliseconds, and says whether it had ended before.
fn killed_after(folder: &Path, milliseconds: u64) -> bool {
    let mut run = spinney(
        folder,
        &["run", "scene.toml", "-o", "run", "--layers", "--quiet"],
    )
    .stdout(Stdio::null())
    .spawn()
    .expect("starts");
    std::thread::sleep(Duration::from_millis(milliseconds));
    let ended = run.try_wait().expect("a child").is_some();
    run.kill().expect("a child");
    run.wait().expect("a child");
    ended
}

#[test]
fn killed_at_any_moment_a_run_is_whole_or_not_there() {
    let folder = folder();
    let run = folder.path().join("run");
    // Delays that grow until a run ends within them, and then smaller ones, so that the last
    // moments, when folders are exchanged, are met with and without an old folder.
    let mut delay = 1;
    while !killed_after(folder.path(), delay) {
        is_whole(&run);
        delay += 1 + delay / 4;
    }
    assert!(is_whole(&run), "a run that ended");
    for share in 1..=12 {
        killed_after(folder.path(), delay * share / 12);
        // For an instant the old folder is away and the new one not in; the next run finishes that.
        let is_between = names(folder.path())
            .iter()
            .any(|name| name.ends_with(".old"));
        assert!(is_whole(&run) || is_between, "the old run or the new one");
    }
    let ended = spinney(
        folder.path(),
        &["run", "scene.toml", "-o", "run", "--quiet"],
    )
    .output();
    assert!(ended.expect("starts").status.success());
    assert!(is_whole(&run));
    let left: BTreeSet<String> = ["run", "scene.toml", "shrub.toml"]
        .map(str::to_owned)
        .into();
    assert_eq!(names(folder.path()), left, "what was left behind is swept");
}

#[test]
fn a_plant_that_is_grown_is_whole_or_as_it_was() {
    let folder = folder();
    let arguments = ["grow", "shrub.toml", "-o", "shrub.glb"];
    let grown = spinney(folder.path(), &arguments).output().expect("starts");
    assert!(grown.status.success());
    let whole = std::fs::read(folder.path().join("shrub.glb")).expect("written");
    for milliseconds in [0, 1, 2, 4, 7, 11, 16, 24, 40] {
        let mut child = spinney(folder.path(), &arguments)
            .stdout(Stdio::null())
            .spawn()
            .expect("starts");
        std::thread::sleep(Duration::from_millis(milliseconds));
        child.kill().expect("a child");
        child.wait().expect("a child");
        let found = std::fs::read(folder.path().join("shrub.glb")).expect("still there");
        assert!(found == whole, "after {milliseconds} ms");
    }
    assert!(
        spinney(folder.path(), &arguments)
            .output()
            .expect("starts")
            .status
            .success()
    );
    let left = ["scene.toml", "shrub.glb", "shrub.toml"].map(str::to_owned);
    assert_eq!(names(folder.path()), BTreeSet::from(left));
}

#[test]
fn runs_into_the_same_folder_at_once_replace_each_other_whole() {
    let folder = folder();
    let start = || {
        spinney(
            folder.path(),
            &["run", "scene.toml", "-o", "run", "--quiet"],
        )
        .stdout(Stdio::null())
        .spawn()
        .expect("starts")
    };
    for _ in 0..2 {
        let runs = [start(), start(), start()];
        for mut run in runs {
            assert!(run.wait().expect("a child").success());
        }
        assert!(is_whole(&folder.path().join("run")));
    }
    assert_eq!(names(folder.path()).len(), 3, "{:?}", names(folder.path()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_and_leaves_nothing() {
    let folder = folder();
    // Of a process's files none may grow past 8 blocks of 512 bytes: as if the disk were full.
    let output = std::process::Command::new("sh")
        .args([
            "-c",
            "trap '' XFSZ; ulimit -f 8; exec \"$0\" run scene.toml -o run --quiet",
        ])
        .arg(env!("CARGO_BIN_EXE_spinney"))
        .env_remove("XDG_CACHE_HOME")
        .env_remove("HOME")
        .current_dir(folder.path())
        .output()
        .expect("starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("cannot write run/"), "{said}");
    assert_eq!(names(folder.path()).len(), 2, "{:?}", names(folder.path()));
    // A device that takes nothing.
    let (code, said) = super::refused(folder.path(), &["run", "scene.toml", "-o", "/dev/full/run"]);
    assert_eq!(code, 4, "{said}");
    let output = spinney(folder.path(), &["help", "scene"])
        .stdout(
            std::fs::OpenOptions::new()
                .write(true)
                .open("/dev/full")
                .expect("there"),
        )
        .output()
        .expect("starts");
    assert_eq!(output.status.code(), Some(4));
}
