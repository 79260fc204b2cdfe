//! References: what scenes showed and cost when somebody last looked, kept beside them.
//!
//! ```text
//! scenes/**/*.toml ─find─▶ scenes ─draw─▶ frames, digests ─┬─compare─▶ Outcome ─▶ page, JUnit, …
//!                                                          │
//! golden/**/*.png, *.txt, digests.txt ─────────────────────┴─bless───▶ golden/
//! ```
//!
//! A scene `NAME.toml` anywhere below the folder of scenes, with a `[golden]` table, keeps the frames
//! that the table lists as `NAME-FRAME.png` and `NAME-FRAME.txt` at the same place below the folder
//! of references, the frame's number with four digits. All counters are exact. A line for each scene,
//! with or without that table, can be kept in `digests.txt`.
//!
//! **Invariant.** What is drawn depends on the scene files and what they name, never on the order,
//! number or company of the scenes.

mod annotation;
mod assert;
mod bless;
mod change;
mod check;
mod compare;
mod digests;
mod draw;
mod error;
mod find;
mod json;
mod junit;
mod lines;
mod outcome;
mod page;
mod reference;
mod table;
mod words;

pub use annotation::github_annotations;
pub use assert::{TEST_FOLDER, assert_scene};
pub use bless::{Blessing, Deed};
pub use change::Change;
pub use digests::{SceneDigests, digest_text};
pub use draw::KeptFrame;
pub use error::GoldenError;
pub use json::GOLDEN_SCHEMA;
pub use junit::junit;
pub use outcome::{
    Case, CaseOutcome, Counts, Evidence, Finding, FindingKind, Outcome, SceneOutcome,
};
pub use reference::{MAX_FILE_BYTES, MAX_SIDE};

use std::path::PathBuf;

use rayon::prelude::{IntoParallelRefIterator as _, ParallelIterator as _};

use crate::run::{CrownStore, Progress};

/// A folder of scenes, and the folder of their references.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Goldens {
    /// Where scenes are looked for, at any depth.
    pub scenes: PathBuf,
    /// Where references are kept.
    pub references: PathBuf,
}

/// Which scenes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Selection {
    /// Only those that have this in their names: paths below the folder of scenes, without ending.
    pub only: Option<String>,
}

impl Selection {
    /// All.
    pub const ALL: Self = Self { only: None };
}

/// What blessing does with references that no scene keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unused {
    /// They stay.
    Keep,
    /// They are removed.
    Remove,
}

impl Default for Goldens {
    /// `scenes` and `golden`.
    fn default() -> Self {
        Self {
            scenes: PathBuf::from("scenes"),
            references: PathBuf::from("golden"),
        }
    }
}

impl Goldens {
    /// Digests of everything that must be the same on every machine, one a scene, in the order of
    /// names: also of scenes without a `[golden]` table, whose frames are all drawn at their own size.
    ///
    /// # Errors
    ///
    /// When the folder cannot be read or holds no scene, or a scene is wrong or cannot be drawn.
    pub fn digests(&self, progress: &dyn Progress) -> Result<Vec<SceneDigests>, GoldenError> {
        let files = find::scene_files(&self.scenes)?;
        let store = CrownStore::default();
        progress.begin("scenes", files.len() as u64);
        let of_file = |file: &find::FoundScene| {
            let digests = draw::draw(&file.read()?, &store, &mut |_| {});
            progress.step();
            digests
        };
        // All of them, so that it is the first error that is told.
        let digests: Vec<_> = files.par_iter().map(of_file).collect();
        digests.into_iter().collect()
    }
}
