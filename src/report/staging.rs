//! Hidden siblings in which files and folders are written before they take their names.
//!
//! ```text
//! .NAME.spinney-P-N         a file, or a folder, that is being written      P, N: process, attempt
//! .NAME.spinney-P-N.lock    held by the process that writes the folder
//! .NAME.spinney-P-N.old     the folder that is being replaced
//! ```
//!
//! A process that is killed leaves them behind. The next that writes NAME finds nobody holding the
//! lock (of a file, its own), finishes an exchange of folders that was cut short, and removes the
//! rest. Where files cannot be locked, as in WebAssembly, nothing is ever taken for left behind.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

/// A file of a hidden name that this process alone holds.
#[derive(Debug)]
pub(super) struct Held {
    pub(super) file: File,
    pub(super) path: PathBuf,
}

/// Creates a hidden file beside what will be called `name`, and holds it.
pub(super) fn hold(parent: &Path, name: &OsStr, ending: &str) -> io::Result<Held> {
    let mut attempt = 0;
    loop {
        let path = parent.join(hidden(name, attempt, ending));
        let taken = match File::create_new(&path) {
            Ok(file) => {
                // Who cleans up may have come between: then it holds the file, or has removed it.
                let is_held = !matches!(file.try_lock(), Err(TryLockError::WouldBlock));
                if is_held && path.exists() {
                    return Ok(Held { file, path });
                }
                io::ErrorKind::AlreadyExists.into()
            }
            Err(error) => error,
        };
        if taken.kind() != io::ErrorKind::AlreadyExists || attempt == MOST_ATTEMPTS {
            return Err(taken);
        }
        attempt += 1;
    }
}

/// More than anybody writes one thing at once.
const MOST_ATTEMPTS: u32 = 1000;

fn hidden(name: &OsStr, attempt: u32, ending: &str) -> OsString {
    let mut hidden = prefix(name);
    hidden.push(format!("{}-{attempt}{ending}", process_number()));
    hidden
}

fn prefix(name: &OsStr) -> OsString {
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".spinney-");
    prefix
}

/// What tells apart the hidden names of two processes; 0 where there are none to tell apart.
fn process_number() -> u32 {
    if cfg!(target_family = "wasm") {
        0
    } else {
        std::process::id()
    }
}

/// The ending of what is locked while a folder is written.
pub(super) const LOCK: &str = ".lock";

/// The ending of a folder that is being replaced.
pub(super) const OLD: &str = ".old";

/// Removes what killed processes left beside `name`; `recover` is first given the folder that was
/// being written and the one that was being replaced, of which either may not be there.
///
/// What cannot be removed stays: it is in nobody's way.
pub(super) fn sweep(parent: &Path, name: &OsStr, recover: impl Fn(&Path, &Path)) {
    let here = if parent.as_os_str().is_empty() {
        Path::new(".")
    } else {
        parent
    };
    let Ok(entries) = fs::read_dir(here) else {
        return;
    };
    let prefix = prefix(name);
    for entry in entries.flatten() {
        let found = entry.file_name();
        let Some(rest) = rest_of(&found, &prefix) else {
            continue;
        };
        // Neither links nor pipes: opening those has effects.
        if !entry.file_type().is_ok_and(|kind| kind.is_file()) {
            continue;
        }
        let path = parent.join(&found);
        match rest.strip_suffix(LOCK) {
            Some(number) if is_number(number) => {
                let Some(_held) = abandoned(&path) else {
                    continue;
                };
                let building = path.with_extension("");
                let old = path.with_extension(&OLD[1..]);
                recover(&building, &old);
                let gone = [&building, &old].map(|folder| match fs::remove_dir_all(folder) {
                    Err(error) => error.kind() == io::ErrorKind::NotFound,
                    Ok(()) => true,
                });
                if gone == [true; 2] {
                    drop(fs::remove_file(&path));
                }
            }
            None if is_number(rest) && abandoned(&path).is_some() => drop(fs::remove_file(&path)),
            _ => {}
        }
    }
}

fn rest_of<'a>(found: &'a OsStr, prefix: &OsStr) -> Option<&'a str> {
    let rest = found
        .as_encoded_bytes()
        .strip_prefix(prefix.as_encoded_bytes())?;
    std::str::from_utf8(rest).ok()
}

/// Whether a text is `P-N`.
fn is_number(text: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    matches!(text.split_once('-'), Some((process, attempt)) if digits(process) && digits(attempt))
}

/// A file that nobody holds, held.
fn abandoned(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    file.try_lock().is_ok().then_some(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn only_what_nobody_holds_is_swept() {
        let root = tempfile::tempdir().unwrap();
        let name = OsStr::new("a.glb");
        let held = hold(root.path(), name, "").unwrap();
        let folder = OsStr::new("run");
        let other = hold(root.path(), folder, LOCK).unwrap();
        let kept = [
            ".a.glb.spinney-x-0",
            ".b.glb.spinney-1-0",
            "a.glb",
            ".a.glb.spinney-1-0.txt",
        ];
        for file in kept {
            fs::write(root.path().join(file), "").unwrap();
        }
        fs::create_dir(root.path().join(".run.spinney-2-0")).unwrap();
        for file in [
            ".a.glb.spinney-1-0",
            ".a.glb.spinney-1-1",
            ".run.spinney-3-0.lock",
        ] {
            fs::write(root.path().join(file), "").unwrap();
        }
        fs::create_dir(root.path().join(".run.spinney-3-0")).unwrap();
        fs::create_dir(root.path().join(".run.spinney-3-0.old")).unwrap();
        let sweep_both = || [name, folder].map(|name| sweep(root.path(), name, |_, _| {}));
        sweep_both();
        let path = |held: &Held| held.path.file_name().unwrap().to_str().unwrap().to_owned();
        let mut wanted: Vec<String> = kept.map(str::to_owned).into();
        wanted.extend([path(&held), path(&other), ".run.spinney-2-0".to_owned()]);
        wanted.sort();
        assert_eq!(names(root.path()), wanted);
        let (held_path, other_path) = (path(&held), path(&other));
        drop((held, other));
        sweep_both();
        let left = names(root.path());
        assert!(!left.contains(&held_path) && !left.contains(&other_path));
    }

    #[test]
    fn each_hold_has_a_name_of_its_own() {
        let root = tempfile::tempdir().unwrap();
        let hold = || hold(root.path(), OsStr::new("a"), "").unwrap();
        let (one, two) = (hold(), hold());
        assert_ne!(one.path, two.path);
    }
}
