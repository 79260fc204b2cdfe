//! Paths that lead elsewhere, and files that are none.

use std::fs;

use super::{SCENE, SPECIES, folder, refused, spinney};

#[test]
fn folders_and_missing_files_are_refused() {
    let folder = folder();
    fs::create_dir(folder.path().join("d.toml")).unwrap();
    for (command, file) in [
        ("run", "d.toml"),
        ("inspect", "d.toml"),
        ("grow", "d.toml"),
        ("inspect", "none.png"),
        ("inspect", "none.glb"),
        ("run", "scene.toml/x"),
    ] {
        let (code, said) = refused(folder.path(), &[command, file]);
        assert_eq!(code, 2, "{command} {file}: {said}");
        assert!(said.contains("cannot read"), "{command} {file}: {said}");
    }
}

#[test]
fn scenes_that_name_roots_or_reach_nothing_are_refused() {
    let folder = folder();
    for (path, part) in [
        ("/etc/passwd", "wanted a path relative to the scene file"),
        ("C:/shrub.toml", "wanted a path relative to the scene file"),
        (
            "..\\\\shrub.toml",
            "wanted a path relative to the scene file",
        ),
        (&"../".repeat(60), "cannot read: not a regular file"),
        ("..", "cannot read: not a regular file"),
        ("shrub.toml/..", "cannot read"),
        ("../none/shrub.toml", "cannot read"),
        ("scene.toml", "scene.toml:"),
    ] {
        let text = SCENE.replace("shrub.toml", path);
        fs::write(folder.path().join("scene.toml"), text).unwrap();
        let (code, said) = refused(folder.path(), &["run", "scene.toml"]);
        assert_eq!(code, 2, "{path}: {said}");
        assert!(said.contains(part), "{path}: {said}");
    }
}

#[test]
fn texts_that_are_empty_marked_or_hold_nul_never_panic() {
    let folder = folder();
    let put = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    for (bytes, part) in [
        (&b""[..], "`schema`: found nothing"),
        (b"\xef\xbb\xbf", "`schema`: found nothing"),
        (b"\0", "1:2: "),
        (b"schema = \"spinney.scene/1\0\"", "1:26: "),
        (b"\xff\xfes\0c\0h\0", "1:1: not UTF-8"),
        (b"name = \"\xc3\"", "1:9: not UTF-8"),
    ] {
        put("scene.toml", bytes);
        let (code, said) = refused(folder.path(), &["run", "scene.toml"]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(part), "{bytes:?}: {said}");
    }
    // A byte order mark and the line ends of other systems mean nothing.
    let marked = format!("\u{feff}{}", SCENE.replace('\n', "\r\n"));
    put("scene.toml", marked.as_bytes());
    put("shrub.toml", SPECIES.replace('\n', "\r\n").as_bytes());
    let run = spinney(folder.path(), &["run", "scene.toml", "--quiet"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    for name in ["empty.png", "empty.glb", "empty.gltf", "empty.exr"] {
        put(name, b"");
        assert_eq!(refused(folder.path(), &["inspect", name]).0, 2, "{name}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_neither_hang_nor_fill_memory() {
    let folder = folder();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("pipe.toml"))
        .status();
    assert!(made.unwrap().success());
    for (link, file) in [
        ("zero", "/dev/zero"),
        ("random", "/dev/random"),
        ("pipe", "pipe.toml"),
    ] {
        for ending in ["toml", "glb", "png"] {
            let link = format!("{link}-link.{ending}");
            std::os::unix::fs::symlink(file, folder.path().join(&link)).unwrap();
            let (code, said) = refused(folder.path(), &["inspect", &link]);
            assert_eq!(code, 2, "{link}: {said}");
            assert!(said.contains("not a regular file"), "{link}: {said}");
        }
    }
    let text = SCENE.replace("shrub.toml", "pipe.toml");
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    let (code, said) = refused(folder.path(), &["run", "scene.toml"]);
    assert_eq!(code, 2, "{said}");
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_loops_refused() {
    use std::os::unix::fs::symlink;
    let folder = folder();
    symlink("scene.toml", folder.path().join("link.toml")).unwrap();
    let run = spinney(folder.path(), &["run", "link.toml", "-o", "out", "--quiet"]).output();
    assert!(run.unwrap().status.success());
    symlink("loop.toml", folder.path().join("loop.toml")).unwrap();
    let (code, said) = refused(folder.path(), &["run", "loop.toml"]);
    assert_eq!(code, 2, "{said}");
    symlink("loop", folder.path().join("loop")).unwrap();
    let (code, said) = refused(folder.path(), &["run", "scene.toml", "-o", "loop"]);
    assert_eq!(code, 4, "{said}");
}

/// Names of files are bytes, and need not be text.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_work() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    let folder = folder();
    let name = OsStr::from_bytes(b"sc\xffne.toml");
    fs::rename(folder.path().join("scene.toml"), folder.path().join(name)).unwrap();
    let out = OsStr::from_bytes(b"out\xff");
    let mut run = spinney(folder.path(), &["run", "--quiet"]);
    let run = run.arg(name).arg("-o").arg(out).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    assert!(folder.path().join(out).join("ledger.json").is_file());
}
