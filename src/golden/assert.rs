//! Goldens as tests.

use std::path::{Path, PathBuf};

use super::check::Candidate;
use super::find::FoundScene;
use super::lines::DigestLines;
use super::outcome::{Finding, SceneOutcome};
use super::{GoldenError, Goldens, Selection};
use crate::report::{ReportError, write_file};
use crate::run::CrownStore;

/// Where tests put what they found, below the folder that they run in.
pub const TEST_FOLDER: &str = "target/golden-tests";

/// Grown once a process.
static CROWNS: CrownStore = CrownStore::new();

/// Compares a scene with its references, for a test: `scenes/trees/oak.toml`, a path below the
/// folder `scenes` where the test runs, with references in `golden`.
///
/// ```no_run
/// #[test]
/// fn oak() {
///     spinney::golden::assert_scene("scenes/trees/oak.toml");
/// }
/// ```
///
/// # Panics
///
/// As [`Goldens::assert_scene`], and when the path is no TOML file below `scenes`.
pub fn assert_scene(path: impl AsRef<Path>) {
    let path = path.as_ref();
    let goldens = Goldens::default();
    let below = path.strip_prefix(&goldens.scenes).ok();
    let name = below.and_then(name_of);
    let Some(name) = name else {
        panic!(
            "{}: wanted a TOML file below the folder {}",
            path.display(),
            goldens.scenes.display()
        );
    };
    goldens.assert_scene(&name);
}

/// The name of a scene file below its folder.
fn name_of(below: &Path) -> Option<String> {
    let parts: Option<Vec<&str>> = below.iter().map(|part| part.to_str()).collect();
    let name = parts?.join("/");
    name.strip_suffix(".toml").map(str::to_owned)
}

impl Goldens {
    /// Compares a scene with its references and its line of digests, for a test; `name` is its path
    /// below the folder of scenes, without its ending. Equal plants are grown once a process.
    ///
    /// # Panics
    ///
    /// With all that is wrong, and where to look at it: files below [`TEST_FOLDER`].
    pub fn assert_scene(&self, name: &str) {
        let found = FoundScene::named(&self.scenes, name);
        let candidate = Candidate {
            read: found.read(),
            found,
        };
        let lines = DigestLines::read(&self.digests_file());
        assert!(
            candidate.is_kept() || lines.is_some(),
            "{}: it has no [golden] table, so nothing of it is kept",
            candidate.found.file.display()
        );
        let compared = self.compare(&candidate, &CROWNS, lines.as_ref(), &mut Vec::new());
        let outcome = compared.outcome;
        if outcome.is_same() {
            return;
        }
        let folder = PathBuf::from(TEST_FOLDER);
        let mut wrong = format!("\n{}:{}: {name}\n", outcome.file.display(), outcome.line);
        for finding in outcome.findings() {
            wrong += &format!("  {finding}\n{}", seen(finding, &folder));
        }
        panic!("{wrong}  {}\n", self.advice(&outcome));
    }

    /// How to make the references what the scene shows.
    fn advice(&self, outcome: &SceneOutcome) -> String {
        let usual = Self::default();
        let mut command = "spinney golden bless".to_owned();
        if self.scenes != usual.scenes {
            command += &format!(" {}", self.scenes.display());
        }
        if self.references != usual.references {
            command += &format!(" --golden {}", self.references.display());
        }
        format!("if this is wanted: {command} --only {}", outcome.name)
    }

    /// The names of all scenes of which something is kept, in order: those with a `[golden]` table,
    /// and all where there is a `digests.txt`. For a test that each has a test.
    ///
    /// # Errors
    ///
    /// When the folder cannot be read or holds no scene.
    pub fn names(&self) -> Result<Vec<String>, GoldenError> {
        let all = DigestLines::read(&self.digests_file()).is_some();
        let candidates = self.candidates()?.into_iter();
        Ok(candidates
            .filter(|candidate| all || candidate.is_kept())
            .map(|candidate| candidate.found.name)
            .collect())
    }

    /// References, and lines of digests, that no scene keeps.
    ///
    /// # Errors
    ///
    /// When a folder cannot be read or holds no scene.
    pub fn unused(&self) -> Result<Vec<Finding>, GoldenError> {
        let lines = DigestLines::read(&self.digests_file());
        self.strays(&self.candidates()?, lines.as_ref(), &Selection::ALL)
    }
}

/// Puts what a finding shows where one can look at it, and says where.
fn seen(finding: &Finding, folder: &Path) -> String {
    let Some(evidence) = &finding.evidence else {
        return String::new();
    };
    let file = folder.join(&evidence.name);
    let written: Result<(), ReportError> = write_file(&file, &evidence.bytes);
    match written {
        Ok(()) => format!("    see {}\n", file.display()),
        Err(error) => format!("    {error}\n"),
    }
}
