//! Output folders that are there whole or not at all.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use super::ReportError;
use crate::limits;

/// The file by which spinney knows a folder of its own: [`HEADING`], then the path of every other
/// file in it, one a line, sorted, with `/` between the parts.
///
/// A folder is replaced only if it is empty or every file in it is listed there, so a note that
/// somebody left beside the results is never lost.
pub const MARKER: &str = ".spinney";

/// The first line of a marker.
const HEADING: &str = "spinney.folder/1";

/// What file managers leave behind; nobody misses it.
const LITTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A folder that is being written.
///
/// Files go to a sibling, `.NAME.spinney-…`, which takes the target's place on
/// [`commit`](Self::commit). Dropped without it, nothing is left behind: neither the sibling nor
/// folders that were created to hold the target. (A process that is killed leaves the sibling; it
/// can be deleted.)
#[derive(Debug)]
pub struct OutputFolder {
    /// The target as it was given: what messages say.
    shown: PathBuf,
    /// The target with links followed.
    target: PathBuf,
    building: PathBuf,
    /// Folders that were created around the target, outermost first.
    created: Vec<PathBuf>,
    finished: bool,
}

impl OutputFolder {
    /// Begins a folder that will be `target`.
    ///
    /// # Errors
    ///
    /// When `target` is a file or lies below one, holds something that spinney did not write, or
    /// cannot be created; then nothing has changed.
    pub fn create(target: &Path) -> Result<Self, ReportError> {
        let wanted = target;
        let target = resolved(wanted)?;
        let fail = |cause| ReportError::write(wanted, cause);
        let name = target.file_name().ok_or_else(|| {
            fail(io::Error::new(
                io::ErrorKind::InvalidInput,
                "it has no name",
            ))
        })?;
        check_replaceable(&target, wanted)?;
        let parent = target.parent().unwrap_or(Path::new(""));
        let created = create_parents(parent).map_err(fail)?;
        let mut folder = Self {
            building: PathBuf::new(),
            created,
            finished: false,
            shown: wanted.to_owned(),
            target: target.clone(),
        };
        folder.building = unused_sibling(parent, name, |path| fs::create_dir(path))
            .map_err(|cause| ReportError::write(wanted, cause))?;
        Ok(folder)
    }

    /// The folder as it will be called.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Where to write a file, such as `plots/bytes.svg`; the folders on its way are there.
    ///
    /// # Errors
    ///
    /// When the name would lead out of the folder, or a folder cannot be created.
    pub fn file(&self, name: &str) -> Result<PathBuf, ReportError> {
        let plain = |part: Component<'_>| matches!(part, Component::Normal(_));
        let parts = Path::new(name).components();
        let depth = parts.clone().count();
        let fits = (1..=limits::FOLDER_DEPTH).contains(&depth)
            && parts.clone().all(plain)
            && !name.contains(['\\', '\n', '\r', '\0'])
            && name != MARKER;
        if !fits {
            return Err(ReportError::Name {
                name: name.to_owned(),
            });
        }
        let path = self.building.join(name);
        let parent = path.parent().unwrap_or(&self.building);
        fs::create_dir_all(parent).map_err(|cause| self.failed(name, cause))?;
        Ok(path)
    }

    /// Writes a whole file.
    ///
    /// # Errors
    ///
    /// As [`file`](Self::file), and when it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), ReportError> {
        let path = self.file(name)?;
        fs::write(path, bytes).map_err(|cause| self.failed(name, cause))
    }

    /// Puts the folder in the target's place, replacing what is there.
    ///
    /// # Errors
    ///
    /// When the target became something that must not be replaced, or cannot be; then it is as it
    /// was.
    pub fn commit(mut self) -> Result<(), ReportError> {
        let fail = |cause| ReportError::write(&self.shown, cause);
        let mut marker = format!("{HEADING}\n");
        for file in files_below(&self.building).map_err(fail)? {
            marker += &file;
            marker.push('\n');
        }
        fs::write(self.building.join(MARKER), marker).map_err(fail)?;
        check_replaceable(&self.target, &self.shown)?;
        if self.target.exists() {
            let name = self.target.file_name().unwrap_or_default();
            let parent = self.target.parent().unwrap_or(Path::new(""));
            let old = unused_sibling(parent, name, |path| {
                // A rename would silently replace an empty folder.
                match path.symlink_metadata() {
                    Ok(_) => Err(io::ErrorKind::AlreadyExists.into()),
                    Err(_) => fs::rename(&self.target, path),
                }
            })
            .map_err(fail)?;
            if let Err(cause) = fs::rename(&self.building, &self.target) {
                // The first error is the one to report; the old folder is back or still beside.
                drop(fs::rename(&old, &self.target));
                return Err(fail(cause));
            }
            self.finished = true;
            return fs::remove_dir_all(&old).map_err(|cause| ReportError::write(&old, cause));
        }
        fs::rename(&self.building, &self.target).map_err(fail)?;
        self.finished = true;
        Ok(())
    }

    fn failed(&self, name: &str, cause: io::Error) -> ReportError {
        // Named as it will be called: the sibling means nothing to anybody.
        ReportError::write(&self.shown.join(name), cause)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if self.finished {
            return;
        }
        if !self.building.as_os_str().is_empty() {
            drop(fs::remove_dir_all(&self.building));
        }
        for folder in self.created.iter().rev() {
            // Only if it is empty: somebody else may use it by now.
            drop(fs::remove_dir(folder));
        }
    }
}

/// The target with links followed where it exists, so that a link stays and its folder is replaced.
fn resolved(target: &Path) -> Result<PathBuf, ReportError> {
    if let Some(file) = target.ancestors().find(|path| path.is_file()) {
        return Err(ReportError::NoFolder {
            path: target.to_owned(),
            file: file.to_owned(),
        });
    }
    if target.symlink_metadata().is_err() {
        return Ok(target.to_owned());
    }
    target
        .canonicalize()
        .map_err(|cause| ReportError::write(target, cause))
}

/// Refuses a folder, which messages call `shown`, with a file that its marker does not list.
fn check_replaceable(target: &Path, shown: &Path) -> Result<(), ReportError> {
    let fail = |cause| ReportError::write(shown, cause);
    match target.symlink_metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(cause) => return Err(fail(cause)),
        Ok(_) => {}
    }
    let known: BTreeSet<String> = match fs::read_to_string(target.join(MARKER)) {
        Ok(text) if text.lines().next() == Some(HEADING) => {
            let listed = text.lines().skip(1).map(str::to_owned);
            listed.chain([MARKER.to_owned()]).collect()
        }
        _ => BTreeSet::new(),
    };
    let litter = |file: &str| LITTER.contains(&file.rsplit('/').next().unwrap_or(file));
    let mut is_foreign = |file: &str| !known.contains(file) && !litter(file);
    match find_below(target, "", 1, &mut is_foreign).map_err(fail)? {
        None => Ok(()),
        Some(found) => Err(ReportError::Foreign {
            path: shown.to_owned(),
            found,
        }),
    }
}

/// All files, and all links as files, below a folder, sorted; what lies too deep counts as a file.
pub(super) fn files_below(folder: &Path) -> io::Result<BTreeSet<String>> {
    let mut files = BTreeSet::new();
    find_below(folder, "", 1, &mut |file| {
        files.insert(file.to_owned());
        false
    })?;
    Ok(files)
}

/// The first file, in order of names, that `is_it` says is it.
fn find_below(
    folder: &Path,
    prefix: &str,
    depth: usize,
    is_it: &mut dyn FnMut(&str) -> bool,
) -> io::Result<Option<String>> {
    let mut entries = fs::read_dir(folder)?.collect::<io::Result<Vec<_>>>()?;
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() && depth < limits::FOLDER_DEPTH {
            let below = find_below(&entry.path(), &format!("{name}/"), depth + 1, is_it)?;
            if below.is_some() {
                return Ok(below);
            }
        } else if is_it(&name) {
            return Ok(Some(name));
        }
    }
    Ok(None)
}

/// Creates the folders that lead to a target; answers those that were not there, outermost first.
fn create_parents(parent: &Path) -> io::Result<Vec<PathBuf>> {
    let missing: Vec<&Path> = parent
        .ancestors()
        .take_while(|path| !path.as_os_str().is_empty() && !path.exists())
        .collect();
    let mut created: Vec<PathBuf> = Vec::new();
    for path in missing.into_iter().rev() {
        match fs::create_dir(path) {
            Ok(()) => created.push(path.to_owned()),
            // Another run was faster, or the path goes through `..`.
            Err(_) if path.is_dir() => {}
            Err(error) => {
                for folder in created.iter().rev() {
                    drop(fs::remove_dir(folder));
                }
                return Err(error);
            }
        }
    }
    Ok(created)
}

/// Makes a hidden sibling under a name that nobody uses.
fn unused_sibling(
    parent: &Path,
    name: &OsStr,
    make: impl Fn(&Path) -> io::Result<()>,
) -> io::Result<PathBuf> {
    let mut attempt = 0;
    loop {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".spinney-{}-{attempt}", process_number()));
        let path = parent.join(hidden);
        match make(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => {
                attempt += 1;
            }
            Err(error) => return Err(error),
        }
    }
}

/// What tells apart the hidden names of two processes; 0 where there are none to tell apart.
fn process_number() -> u32 {
    if cfg!(target_family = "wasm") {
        0
    } else {
        std::process::id()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everything below a folder, with the contents of files.
    fn tree(folder: &Path) -> Vec<(String, String)> {
        let read = |file: String| {
            let text = fs::read_to_string(folder.join(&file)).expect("text");
            (file, text)
        };
        files_below(folder)
            .expect("a folder")
            .into_iter()
            .map(read)
            .collect()
    }

    fn names(folder: &Path) -> Vec<String> {
        files_below(folder).expect("a folder").into_iter().collect()
    }

    fn written(target: &Path, text: &str) {
        let folder = OutputFolder::create(target).unwrap();
        folder.write("ledger.json", text.as_bytes()).unwrap();
        folder.write("plots/a.svg", b"<svg/>").unwrap();
        folder.commit().unwrap();
    }

    #[test]
    fn folders_appear_whole_and_are_replaced_whole() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("out/run");
        written(&target, "1");
        let marker = "spinney.folder/1\nledger.json\nplots/a.svg\n";
        let wanted = [
            (MARKER, marker),
            ("ledger.json", "1"),
            ("plots/a.svg", "<svg/>"),
        ];
        assert_eq!(
            tree(&target),
            wanted.map(|(a, b)| (a.to_owned(), b.to_owned()))
        );

        let folder = OutputFolder::create(&target).unwrap();
        folder.write("other.txt", b"2").unwrap();
        assert_eq!(tree(&target).len(), 3, "the old folder stays until the end");
        folder.commit().unwrap();
        assert_eq!(names(&target), [MARKER, "other.txt"]);
        assert_eq!(fs::read_dir(root.path().join("out")).unwrap().count(), 1);
    }

    #[test]
    fn dropped_folders_leave_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("a/b/run");
        let folder = OutputFolder::create(&target).unwrap();
        folder.write("x/y.txt", b"1").unwrap();
        assert!(!target.exists());
        drop(folder);
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);

        written(&target, "1");
        let folder = OutputFolder::create(&target).unwrap();
        folder.write("ledger.json", b"2").unwrap();
        drop(folder);
        assert_eq!(fs::read_to_string(target.join("ledger.json")).unwrap(), "1");
        assert_eq!(fs::read_dir(root.path().join("a/b")).unwrap().count(), 1);
    }

    #[test]
    fn foreign_files_are_never_replaced() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("mine");
        fs::create_dir(&target).unwrap();
        written(&target, "1");

        fs::create_dir(target.join("notes")).unwrap();
        fs::write(target.join("notes/today.txt"), "work").unwrap();
        let error = OutputFolder::create(&target).unwrap_err();
        assert_eq!(
            error.to_string(),
            format!(
                "cannot write {}: it holds notes/today.txt, which spinney did not write; wanted a \
                 new or empty folder, or one from an earlier run",
                target.display()
            )
        );
        assert!(error.is_write());
        fs::remove_file(target.join("notes/today.txt")).unwrap();
        fs::write(target.join(".DS_Store"), "").unwrap();
        OutputFolder::create(&target).unwrap();

        // A marker of another making is none, even if it lists what is there.
        let other = root.path().join("other");
        fs::create_dir(&other).unwrap();
        fs::write(other.join("a.txt"), "1").unwrap();
        fs::write(other.join(MARKER), "a.txt\n").unwrap();
        assert!(matches!(
            OutputFolder::create(&other),
            Err(ReportError::Foreign { .. })
        ));
    }

    #[test]
    fn folders_that_become_foreign_meanwhile_stay() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("run");
        let folder = OutputFolder::create(&target).unwrap();
        folder.write("a.txt", b"1").unwrap();
        fs::create_dir(&target).unwrap();
        fs::write(target.join("theirs.txt"), "2").unwrap();
        assert!(matches!(folder.commit(), Err(ReportError::Foreign { .. })));
        assert_eq!(names(root.path()), ["run/theirs.txt"]);
    }

    #[test]
    fn files_in_the_way_are_named() {
        let root = tempfile::tempdir().unwrap();
        let file = root.path().join("file");
        fs::write(&file, "1").unwrap();
        for target in [file.clone(), file.join("below/it")] {
            let error = OutputFolder::create(&target).unwrap_err();
            assert_eq!(
                error.to_string(),
                format!(
                    "cannot write {}: {} is a file, wanted a folder",
                    target.display(),
                    file.display()
                )
            );
        }
        let error = OutputFolder::create(Path::new("/")).unwrap_err();
        assert_eq!(error.to_string(), "cannot write /: it has no name");
    }

    #[test]
    fn names_cannot_lead_out() {
        let root = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(&root.path().join("run")).unwrap();
        for name in ["", "../x", "/x", "a/../../x", "a\\b", MARKER, "a\nb"] {
            let error = folder.write(name, b"").unwrap_err();
            assert!(matches!(error, ReportError::Name { .. }), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links() {
        let root = tempfile::tempdir().unwrap();
        let real = root.path().join("real");
        written(&real, "1");
        let link = root.path().join("link");
        std::os::unix::fs::symlink(&real, &link).unwrap();
        written(&link, "2");
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read_to_string(real.join("ledger.json")).unwrap(), "2");
        // A link within a folder counts as a file, and is not followed.
        std::os::unix::fs::symlink("/", real.join("everything")).unwrap();
        assert!(matches!(
            OutputFolder::create(&real),
            Err(ReportError::Foreign { .. })
        ));
    }
}
