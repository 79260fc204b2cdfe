//! References: what scenes showed and cost when somebody last looked, kept beside them.
//!
//! ```text
//! scenes/**/*.toml ─find─▶ scenes ─draw─▶ pictures, ledgers' tables ──▶ digests
//! ```
//!
//! A scene `NAME.toml` anywhere below the folder of scenes, with a `[golden]` table, keeps the frames
//! that the table lists as `NAME-FRAME.png` and `NAME-FRAME.txt` at the same place below the folder
//! of references, the frame's number with four digits. All counters are exact.
//!
//! **Invariant.** What is drawn depends on the scene files and what they name, never on the order,
//! number or company of the scenes.

mod digests;
mod draw;
mod error;
mod find;
mod table;

pub use digests::{SceneDigests, digest_text};
pub use draw::KeptFrame;
pub use error::GoldenError;

use std::path::PathBuf;

use crate::run::{CrownStore, Progress};

/// A folder of scenes, and the folder of their references.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Goldens {
    /// Where scenes are looked for, at any depth.
    pub scenes: PathBuf,
    /// Where references are kept.
    pub references: PathBuf,
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
    /// Draws the frames that a scene keeps, those of its `[golden]` table or else all; `name` is its
    /// path below the folder of scenes, without its ending.
    ///
    /// Plants are grown once a process.
    ///
    /// # Errors
    ///
    /// When the scene is wrong or cannot be drawn.
    pub fn frames(&self, name: &str) -> Result<Vec<KeptFrame>, GoldenError> {
        static CROWNS: CrownStore = CrownStore::new();
        let scene = find::FoundScene::named(&self.scenes, name).read()?;
        let mut frames = Vec::new();
        draw::draw(&scene, &CROWNS, &mut |frame| frames.push(frame))?;
        Ok(frames)
    }

    /// Digests of everything that must be the same on every machine, one a scene, in the order of
    /// names: also of scenes without a `[golden]` table, whose frames are all drawn at their own size.
    ///
    /// # Errors
    ///
    /// When the folder cannot be read or holds no scene, or a scene is wrong or cannot be drawn.
    pub fn digests(&self, progress: &dyn Progress) -> Result<Vec<SceneDigests>, GoldenError> {
        let files = find::scene_files(&self.scenes)?;
        let store = CrownStore::default();
        let mut digests = Vec::new();
        progress.begin("scenes", files.len() as u64);
        for file in &files {
            let scene = file.read()?;
            digests.push(draw::draw(&scene, &store, &mut |_| {})?);
            progress.step();
        }
        Ok(digests)
    }
}
