//! Output folders that are there whole or not at all.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use super::ReportError;
use super::staging::{self, Held};
use crate::document::read_file;
use crate::limits;

/// The file by which spinney knows a folder of its own: [`HEADING`], then the path of every other
/// file in it, one a line, sorted, with `/` between the parts.
///
/// A folder is replaced only if it is empty or every file in it is listed there, so a note that
/// somebody left beside the results is never lost.
pub const MARKER: &str = ".spinney";

/// The first line of a marker.
const HEADING: &str = "spinney.folder/1";

/// Where the marker is written before it is whole.
const MARKER_PART: &str = ".spinney-part";

/// What file managers leave behind; nobody misses it.
const LITTER: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// A folder that is being written.
///
/// Files go to a sibling, `.NAME.spinney-…`, which takes the target's place on
/// [`commit`](Self::commit). Dropped without it, nothing is left behind: neither the sibling nor
/// folders that were created to hold the target. What a process that is killed leaves is removed by
/// the next that writes the same folder.
#[derive(Debug)]
pub struct OutputFolder {
    /// The target as it was given: what messages say.
    shown: PathBuf,
    /// The target with links followed.
    target: PathBuf,
    building: PathBuf,
    /// Tells other processes that somebody writes.
    lock: Held,
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
        let parent = target.parent().unwrap_or(Path::new(""));
        staging::sweep(parent, name, |new, old| recover(new, &target, old));
        check_replaceable(&target, wanted)?;
        let created = create_parents(parent).map_err(fail)?;
        let remove = |cause| {
            remove_empty(&created);
            fail(cause)
        };
        let lock = staging::hold(parent, name, staging::LOCK).map_err(remove)?;
        let building = lock.path.with_extension("");
        if let Err(cause) = fs::create_dir(&building) {
            drop(fs::remove_file(&lock.path));
            return Err(remove(cause));
        }
        Ok(Self {
            building,
            lock,
            created,
            finished: false,
            shown: wanted.to_owned(),
            target,
        })
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

    /// Copies a file into the folder.
    ///
    /// # Errors
    ///
    /// As [`file`](Self::file), and when it cannot be read or written; a pipe or device is refused.
    pub(super) fn copy(&self, from: &Path, name: &str) -> Result<(), ReportError> {
        let is_file = fs::metadata(from).is_ok_and(|metadata| metadata.is_file());
        if !is_file {
            return Err(unread(from, "no such file"));
        }
        let path = self.file(name)?;
        let copied = fs::copy(from, path);
        copied.map(drop).map_err(|cause| self.failed(name, cause))
    }

    /// Copies the files and folders below a folder to below the folder `name`.
    ///
    /// # Errors
    ///
    /// As [`copy`](Self::copy), and when something lies too deep.
    pub(super) fn copy_below(&self, from: &Path, name: &str) -> Result<(), ReportError> {
        // Made on the way to a file in it, which is never written: it may be empty.
        self.file(&format!("{name}/x"))?;
        let failed = |cause: io::Error| unread(from, cause);
        let entries = fs::read_dir(from).map_err(failed)?;
        for entry in entries {
            let entry = entry.map_err(failed)?;
            let name = format!("{name}/{}", entry.file_name().to_string_lossy());
            if entry.file_type().map_err(failed)?.is_dir() {
                self.copy_below(&entry.path(), &name)?;
            } else {
                self.copy(&entry.path(), &name)?;
            }
        }
        Ok(())
    }

    /// Puts the folder in the target's place, replacing what is there.
    ///
    /// At no time is a file under its final name that is not whole: there is the old folder, for an
    /// instant none, and then the new one.
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
        // The marker says that the folder is whole, so it has to be whole itself.
        let part = self.building.join(MARKER_PART);
        fs::write(&part, marker)
            .and_then(|()| fs::rename(&part, self.building.join(MARKER)))
            .map_err(fail)?;
        let old = self.lock.path.with_extension(&staging::OLD[1..]);
        let mut attempt = 0;
        loop {
            check_replaceable(&self.target, &self.shown)?;
            match exchange(&self.building, &self.target, &old) {
                Ok(()) => break,
                // Another run was faster; its folder is replaced in its turn.
                Err(_) if self.target.exists() && attempt < MOST_ATTEMPTS => attempt += 1,
                Err(cause) => return Err(fail(cause)),
            }
        }
        self.finished = true;
        match fs::remove_dir_all(&old) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                Err(ReportError::write(&old, cause))
            }
            _ => Ok(()),
        }
    }

    fn failed(&self, name: &str, cause: io::Error) -> ReportError {
        // Named as it will be called: the sibling means nothing to anybody.
        ReportError::write(&self.shown.join(name), cause)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        if !self.finished {
            drop(fs::remove_dir_all(&self.building));
        }
        drop(fs::remove_file(&self.lock.path));
        if self.finished {
            return;
        }
        remove_empty(&self.created);
    }
}

/// What is to be joined cannot be read: a fault of the input.
fn unread(file: &Path, why: impl std::fmt::Display) -> ReportError {
    ReportError::Shard {
        file: file.to_owned(),
        line: 0,
        message: format!("cannot read: {why}"),
    }
}

/// Removes folders, the last first, as far as they are empty: somebody else may use one by now.
fn remove_empty(folders: &[PathBuf]) {
    for folder in folders.iter().rev() {
        drop(fs::remove_dir(folder));
    }
}

/// Puts a new folder in the place of an old one, which is moved to `old`; when that fails, all is as
/// it was.
fn exchange(new: &Path, target: &Path, old: &Path) -> io::Result<()> {
    let moved = match fs::rename(target, old) {
        Ok(()) => true,
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(error) => return Err(error),
    };
    let placed = fs::rename(new, target);
    if placed.is_err() && moved && fs::rename(old, target).is_err() {
        // Somebody else's folder stands there by now, and would have replaced the old one too.
        drop(fs::remove_dir_all(old));
    }
    placed
}

/// Finishes an exchange that was cut short when nothing stood in the target's place.
fn recover(new: &Path, target: &Path, old: &Path) {
    if target.symlink_metadata().is_ok() {
        return;
    }
    let is_whole = new.join(MARKER).is_file();
    if !is_whole || fs::rename(new, target).is_err() {
        // Where there is none, nothing was replaced.
        drop(fs::rename(old, target));
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
    let mut attempt = 0;
    loop {
        let marker = marker_of(target);
        let found = foreign_file(target, &marker);
        // Another run may have put its folder there while this one was looking.
        let has_changed = !matches!(found, Ok(None)) && marker_of(target) != marker;
        if !has_changed || attempt == MOST_ATTEMPTS {
            return match found.map_err(fail)? {
                None => Ok(()),
                Some(found) => Err(ReportError::Foreign {
                    path: shown.to_owned(),
                    found,
                }),
            };
        }
        attempt += 1;
    }
}

/// How often other runs may be faster.
const MOST_ATTEMPTS: u32 = 16;

/// What a folder's marker says; empty where there is none, or one that is none of ours.
fn marker_of(target: &Path) -> String {
    let bytes = read_file(&target.join(MARKER), limits::MARKER_BYTES);
    let text = bytes.ok().and_then(|bytes| String::from_utf8(bytes).ok());
    text.filter(|text| text.lines().next() == Some(HEADING))
        .unwrap_or_default()
}

/// The first file of a folder that its marker does not list.
fn foreign_file(target: &Path, marker: &str) -> io::Result<Option<String>> {
    match target.symlink_metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        other => other?,
    };
    let known: BTreeSet<&str> = marker.lines().skip(1).chain([MARKER]).collect();
    let is_known = |file: &str| !marker.is_empty() && known.contains(file);
    let is_litter = |file: &str| LITTER.contains(&file.rsplit('/').next().unwrap_or(file));
    find_below(target, "", 1, &mut |file| {
        !is_known(file) && !is_litter(file)
    })
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
                remove_empty(&created);
                return Err(error);
            }
        }
    }
    Ok(created)
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
    fn an_exchange_that_was_cut_short_is_finished_or_undone() {
        let root = tempfile::tempdir().unwrap();
        let target = root.path().join("run");
        let folder = OutputFolder::create(&target).unwrap();
        folder.write("a", b"old").unwrap();
        folder.commit().unwrap();
        let hidden = |ending: &str| root.path().join(format!(".run.spinney-1-0{ending}"));
        for (marker, wanted) in [(MARKER, "new"), (MARKER_PART, "old")] {
            // As a process leaves it that is killed between two renames.
            fs::write(target.join("a"), "old").unwrap();
            fs::rename(&target, hidden(".old")).unwrap();
            fs::create_dir(hidden("")).unwrap();
            fs::write(hidden("").join("a"), "new").unwrap();
            fs::write(hidden("").join(marker), format!("{HEADING}\na\n")).unwrap();
            fs::write(hidden(".lock"), "").unwrap();
            drop(OutputFolder::create(&target).unwrap());
            assert_eq!(fs::read_to_string(target.join("a")).unwrap(), wanted);
            assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
        }
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
