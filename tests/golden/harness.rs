//! Comparing with references, and replacing them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use spinney::raster::Image;
use spinney::report::Picture;

use spinney::golden::{Goldens, KeptFrame, digest_text};
use spinney::run::Silent;
use spinney::scene::{Golden, Scene};

use crate::picture::{Difference, compare, encode, triptych};

/// The largest side of a reference, in pixels.
const MAX_SIDE: u32 = 160;

/// The largest file of a reference, in bytes.
const MAX_FILE_BYTES: usize = 32 << 10;

/// The references that are digests.
const DIGESTS: &str = "digests.txt";

/// Compares all that a scene keeps; tells everything that is wrong with it at once.
pub(crate) fn check_scene(name: &str) {
    let golden = golden(name).expect("listed scenes have a [golden] table");
    let mut wrong = String::new();
    let frames = goldens().frames(name);
    for kept in frames.unwrap_or_else(|error| panic!("{error}")) {
        let frame = frame_name(name, kept.frame.frame);
        check_picture(&frame, &kept, golden.tolerance, &mut wrong);
        check_text(&format!("{frame}.txt"), &kept.table, &mut wrong);
    }
    finish(&wrong);
}

fn goldens() -> Goldens {
    Goldens {
        scenes: path("scenes/golden"),
        references: path("golden"),
    }
}

fn golden(name: &str) -> Option<Golden> {
    let scene = Scene::read(&path("scenes/golden").join(format!("{name}.toml")));
    scene.unwrap_or_else(|error| panic!("{error}")).golden
}

/// The name of a frame: `SUITE/NAME-FRAME`.
fn frame_name(scene: &str, frame: u32) -> String {
    format!("{scene}-{frame:04}")
}

/// The path of something in the package.
fn path(below: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(below)
}

/// The names of all golden scenes, `SUITE/NAME`, in order.
fn names() -> Vec<String> {
    files_below(&path("scenes/golden"))
        .iter()
        .filter_map(|file| file.strip_suffix(".toml").map(str::to_owned))
        .collect()
}

/// The files two levels below a folder as `FOLDER/FILE`, in order.
fn files_below(folder: &Path) -> Vec<String> {
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

/// Compares `golden/digests.txt`.
pub(crate) fn check_digests() {
    let digests = goldens().digests(&Silent);
    let text = digest_text(&digests.unwrap_or_else(|error| panic!("{error}")));
    let mut wrong = String::new();
    check_text(DIGESTS, &text, &mut wrong);
    finish(&wrong);
}

/// Checks that every reference is some frame's, and every scene some test's.
pub(crate) fn check_references(tested: &[&str]) {
    let mut wanted = BTreeSet::new();
    let mut untested = Vec::new();
    for name in names() {
        if let Some(golden) = golden(&name) {
            for frame in &golden.frames {
                let frame = frame_name(&name, *frame);
                wanted.extend([format!("{frame}.png"), format!("{frame}.txt")]);
            }
            if !tested.contains(&name.as_str()) {
                untested.push(name);
            }
        }
    }
    assert!(
        untested.is_empty(),
        "scenes that no test names: {untested:?}"
    );
    let mut wrong = String::new();
    for file in files_below(&path("golden"))
        .iter()
        .filter(|file| !wanted.contains(*file))
    {
        if blessing() {
            std::fs::remove_file(reference(file)).expect("references can be removed");
            _ = writeln!(wrong, "golden/{file}: removed");
        } else {
            _ = writeln!(wrong, "golden/{file}: no test draws it");
        }
    }
    finish(&wrong);
}

fn check_picture(name: &str, kept: &KeptFrame, tolerance: u8, wrong: &mut String) {
    let file = format!("{name}.png");
    let actual = &kept.frame.image;
    let png = encode(actual);
    if actual.width.max(actual.height) > MAX_SIDE || png.len() > MAX_FILE_BYTES {
        let (width, height, bytes) = (actual.width, actual.height, png.len());
        _ = writeln!(
            wrong,
            "golden/{file}: {width} x {height} pixels in {bytes} bytes, at most {MAX_SIDE} a side \
             in {MAX_FILE_BYTES} bytes"
        );
        return;
    }
    let known = reference(&file);
    if !known.exists() {
        if !bless(&file, &png, wrong) {
            put(&artifact(&file), &png);
            _ = writeln!(
                wrong,
                "golden/{file}: missing; see {}",
                artifact(&file).display()
            );
        }
        return;
    }
    let expected = match Picture::read(&known) {
        Ok(picture) => Image {
            width: picture.width(),
            height: picture.height(),
            rgba: picture.rgba().to_vec(),
        },
        Err(error) => {
            if !bless(&file, &png, wrong) {
                _ = writeln!(wrong, "{error}");
            }
            return;
        }
    };
    match compare(&expected, actual, tolerance) {
        Difference::Within => {}
        Difference::Beyond(words) => {
            if !bless(&file, &png, wrong) {
                put(
                    &artifact(&file),
                    &encode(&triptych(&expected, actual, tolerance)),
                );
            }
            let seen = artifact(&file);
            _ = writeln!(wrong, "golden/{file}: {words}; see {}", seen.display());
        }
    }
}

fn check_text(file: &str, actual: &str, wrong: &mut String) {
    let expected = std::fs::read_to_string(reference(file)).unwrap_or_default();
    if expected == actual || bless(file, actual.as_bytes(), wrong) {
        return;
    }
    put(&artifact(file), actual.as_bytes());
    if expected.is_empty() {
        _ = writeln!(
            wrong,
            "golden/{file}: missing; see {}",
            artifact(file).display()
        );
        return;
    }
    _ = writeln!(
        wrong,
        "golden/{file}: expected (-) and actual (+) lines differ"
    );
    let only = |sign: char, these: &str, those: &str, wrong: &mut String| {
        let known: BTreeSet<&str> = those.lines().collect();
        for line in these.lines().filter(|line| !known.contains(line)) {
            _ = writeln!(wrong, "  {sign} {line}");
        }
    };
    only('-', &expected, actual, wrong);
    only('+', actual, &expected, wrong);
}

/// Replaces a reference when asked to, and tells so; never in CI.
fn bless(file: &str, bytes: &[u8], wrong: &mut String) -> bool {
    if blessing() {
        put(&reference(file), bytes);
        _ = writeln!(wrong, "golden/{file}: blessed");
    }
    blessing()
}

fn blessing() -> bool {
    let asked = std::env::var_os("BLESS").is_some_and(|value| value == "1");
    let automatic = std::env::var_os("CI").is_some_and(|value| !value.is_empty());
    assert!(!(asked && automatic), "references are not blessed in CI");
    asked
}

/// Fails with all that is wrong.
fn finish(wrong: &str) {
    assert!(wrong.is_empty(), "\n{wrong}");
}

fn reference(file: &str) -> PathBuf {
    path("golden").join(file)
}

/// Where what was found instead is put: `target/golden/`.
fn artifact(file: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden");
    folder.join(file)
}

fn put(file: &Path, bytes: &[u8]) {
    let folder = file.parent().expect("a file lies in a folder");
    std::fs::create_dir_all(folder).expect("folders can be made");
    std::fs::write(file, bytes).expect("files can be written");
}
