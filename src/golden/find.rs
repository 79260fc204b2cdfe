//! Scene files in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use super::GoldenError;
use crate::document::Document;
use crate::report::MARKER;
use crate::run::{RunError, SessionOptions};
use crate::scene::SceneFile;

/// How deep a scene file may lie: what is found about it is put as deep below another folder.
const MAX_DEPTH: usize = crate::limits::FOLDER_DEPTH;

/// A scene file, not read yet.
#[derive(Debug, Clone)]
pub(super) struct FoundScene {
    /// Its path below the folder of scenes, with `/` between the parts, without its ending.
    pub(super) name: String,
    /// Its path, beginning with the folder as it was given.
    pub(super) file: PathBuf,
}

/// A scene that was read.
#[derive(Debug)]
pub(super) struct ReadScene {
    /// As [`FoundScene::name`].
    pub(super) name: String,
    /// As [`FoundScene::file`].
    pub(super) file: PathBuf,
    /// What it says, and where.
    pub(super) scene: SceneFile,
    /// How it is drawn: at the size of its `[golden]` table, if it has one, with exact counters.
    pub(super) options: SessionOptions,
}

/// All scene files below a folder, in the order of names.
///
/// Files that do not end in `.toml` or name another schema are passed over, and so are folders that
/// spinney wrote or whose name begins with a dot.
pub(super) fn scene_files(folder: &Path) -> Result<Vec<FoundScene>, GoldenError> {
    let mut found = Vec::new();
    for (name, file) in files_below(folder)? {
        let Some(name) = name.strip_suffix(".toml") else {
            continue;
        };
        // What cannot be read is told when it is, with the others.
        let is_scene = Document::read(&file).map_or(true, |document| names_schema(&document.text));
        if is_scene {
            let name = name.to_owned();
            found.push(FoundScene { name, file });
        }
    }
    // By the name without its ending: `a-b` comes before `a/b`, whatever follows.
    found.sort_by(|one, other| one.name.cmp(&other.name));
    match found.is_empty() {
        true => Err(GoldenError::NoScene {
            folder: folder.to_owned(),
        }),
        false => Ok(found),
    }
}

/// All files below a folder that spinney did not write as a folder: path below it, and path.
pub(super) fn files_below(folder: &Path) -> Result<Vec<(String, PathBuf)>, GoldenError> {
    let mut files = Vec::new();
    collect(folder, "", 0, &mut files)?;
    files.sort();
    Ok(files)
}

fn collect(
    folder: &Path,
    prefix: &str,
    depth: usize,
    files: &mut Vec<(String, PathBuf)>,
) -> Result<(), GoldenError> {
    if depth >= MAX_DEPTH {
        return Err(GoldenError::Deep {
            folder: folder.to_owned(),
            limit: MAX_DEPTH,
        });
    }
    let fail = |cause| GoldenError::Read {
        folder: folder.to_owned(),
        cause,
    };
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        entries.push(entry.map_err(fail)?);
    }
    for entry in entries {
        let file = folder.join(entry.file_name());
        let hidden = entry.file_name().to_string_lossy().starts_with('.');
        // A link to a file is one; a link to a folder is not followed, since it may lead around.
        let is_folder = entry.file_type().map_err(fail)?.is_dir();
        if hidden || (is_folder && file.join(MARKER).exists()) || (!is_folder && file.is_dir()) {
            continue;
        }
        let name = match entry.file_name().into_string() {
            Ok(name) if !name.contains(|c: char| c.is_control() || c == '\\') => name,
            _ => return Err(GoldenError::Name { file }),
        };
        if is_folder {
            collect(&file, &format!("{prefix}{name}/"), depth + 1, files)?;
        } else {
            files.push((format!("{prefix}{name}"), file));
        }
    }
    Ok(())
}

/// Whether a line gives `schema` the name of a version of scenes.
fn names_schema(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim_start().trim_start_matches(['"', '\'']);
        line.starts_with("schema") && line.contains("spinney.scene/")
    })
}

impl FoundScene {
    /// The scene of a name, whether it is there or not.
    pub(super) fn named(folder: &Path, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            file: folder.join(format!("{name}.toml")),
        }
    }

    /// Reads the file.
    pub(super) fn read(&self) -> Result<ReadScene, GoldenError> {
        let scene = SceneFile::read(&self.file)?;
        let mut options = SessionOptions::exact(&scene.scene).map_err(|error| match &error {
            RunError::Name { key, .. } => {
                GoldenError::Scene(scene.source.error(key, error.to_string()).into())
            }
            _ => GoldenError::Run {
                file: self.file.clone(),
                source: Box::new(error),
            },
        })?;
        if let Some(golden) = &scene.scene.golden {
            options.size = golden.size;
        }
        Ok(ReadScene {
            name: self.name.clone(),
            file: self.file.clone(),
            scene,
            options,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_known_by_their_schema() {
        for text in [
            "schema = \"spinney.scene/1\"",
            "# A scene.\n  schema='spinney.scene/9'\nbroken",
            "\"schema\" = \"spinney.scene/1\"",
        ] {
            assert!(names_schema(text), "{text}");
        }
        for text in [
            "",
            "schema = \"spinney.species/1\"",
            "# schema = \"spinney.scene/1\"",
            "[package]\nname = \"spinney.scene/1\"",
        ] {
            assert!(!names_schema(text), "{text}");
        }
    }

    #[test]
    fn names_are_paths_below_the_folder() {
        let root = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let file = root.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        };
        let scene = "schema = \"spinney.scene/1\"";
        for name in ["b.toml", "a/b/c/d.toml", "a/b.toml", "a-b.toml"] {
            put(name, scene);
        }
        put("a/species.toml", "schema = \"spinney.species/1\"");
        put("a/notes.md", scene);
        put(".git/x.toml", scene);
        put("out/scene.resolved.toml", scene);
        put("out/.spinney", "");
        let found = scene_files(root.path()).unwrap();
        let names: Vec<&str> = found.iter().map(|scene| scene.name.as_str()).collect();
        assert_eq!(names, ["a-b", "a/b", "a/b/c/d", "b"]);
        assert_eq!(found[1].file, root.path().join("a/b.toml"));

        let empty = root.path().join(".git");
        fs::remove_file(empty.join("x.toml")).unwrap();
        assert!(matches!(
            scene_files(&empty),
            Err(GoldenError::NoScene { .. })
        ));
        assert!(matches!(
            scene_files(&root.path().join("none")),
            Err(GoldenError::Read { .. })
        ));
    }
}
