//! Single files that are there whole or not at all.

use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use super::ReportError;
use super::staging::{self, Held};

/// Writes a file under a hidden name beside its own, and then renames it, replacing what is there;
/// makes the folders on its way.
///
/// # Errors
///
/// When it cannot be written; then what was there is as it was.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let fail = |cause| ReportError::write(path, cause);
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        fs::create_dir_all(folder).map_err(fail)?;
    }
    let parent = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().ok_or_else(|| {
        fail(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it has no name",
        ))
    })?;
    staging::sweep(parent, name, |_, _| {});
    let Held {
        mut file,
        path: hidden,
    } = staging::hold(parent, name, "").map_err(fail)?;
    // Held until it has its name.
    let written = file
        .write_all(bytes)
        .and_then(|()| fs::rename(&hidden, path));
    written.map_err(|cause| {
        // The first error is the one to report.
        drop(fs::remove_file(&hidden));
        fail(cause)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_replaced_whole_and_leave_nothing_beside() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("a/b.txt");
        write_file(&path, b"one").unwrap();
        write_file(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(root.path().join("a")).unwrap().count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_named_and_leaves_nothing_behind() {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("folder");
        fs::create_dir_all(path.join("within")).unwrap();
        let error = write_file(&path, b"one").unwrap_err();
        assert!(error.is_write() && error.to_string().contains("folder"));
        assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
        let error = write_file(&path.join("x/../../folder/within"), b"").unwrap_err();
        assert!(error.is_write());
    }
}
