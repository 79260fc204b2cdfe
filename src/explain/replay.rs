//! A run's folder, and the run played again from it.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::ExplainError;
use crate::document::read_file;
use crate::limits::RUN_TEXT_BYTES;
use crate::models::Kind;
use crate::report::{LEDGER_SCHEMA, OpsReader, ReportError, RunLedger};
use crate::run::{Frame, Progress, Session, SessionOptions, World};
use crate::scene::{Scene, SceneFile};

/// What a run's folder says of it.
#[derive(Debug)]
pub struct RecordedRun {
    folder: PathBuf,
    ledger: RunLedger,
    scene: Scene,
    resolved: String,
    ops: String,
    options: SessionOptions,
}

impl RecordedRun {
    /// Reads `ledger.json`, `scene.resolved.toml` and `ops.jsonl` of a folder.
    ///
    /// # Errors
    ///
    /// When one of them is missing, too large, or none of a run.
    pub fn read(folder: &Path) -> Result<Self, ExplainError> {
        let wrong = |message: String| ExplainError::NotARun {
            folder: folder.to_owned(),
            message,
        };
        let text = read_text(folder, "ledger.json")
            .map_err(|problem| wrong(format!("{problem}; wanted the folder of a `spinney run`")))?;
        let ledger: RunLedger = serde_json::from_str(&text)
            .map_err(|error| wrong(format!("ledger.json is no run's ledger: {error}")))?;
        if ledger.head.schema != LEDGER_SCHEMA {
            let found = &ledger.head.schema;
            let message = format!("ledger.json has schema {found:?}, wanted {LEDGER_SCHEMA:?}");
            return Err(wrong(message));
        }
        let ops = read_text(folder, "ops.jsonl").map_err(wrong)?;
        let path = folder.join("scene.resolved.toml");
        let file = SceneFile::read(&path)?;
        let resolved = read_text(folder, "scene.resolved.toml").map_err(wrong)?;
        let scene = file.scene;
        if ops.lines().count() != ledger.frames.len() {
            let (lines, frames) = (ops.lines().count(), ledger.frames.len());
            return Err(wrong(format!(
                "ops.jsonl has {lines} lines, but ledger.json {frames} frames"
            )));
        }
        let options = SessionOptions::exact(&scene)?;
        Ok(Self {
            folder: folder.to_owned(),
            ledger,
            scene,
            resolved,
            ops,
            options,
        })
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// What the run moved and drew.
    #[must_use]
    pub fn ledger(&self) -> &RunLedger {
        &self.ledger
    }

    /// What was asked for, nothing left to a default.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The model and mode.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.options.kind
    }

    /// How the run is played again.
    #[must_use]
    pub fn options(&self) -> &SessionOptions {
        &self.options
    }

    /// The text of the resolved scene.
    #[must_use]
    pub fn resolved(&self) -> &str {
        &self.resolved
    }

    /// The lines of states, one a frame.
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.ops.lines()
    }

    /// The text of a file of the run; `None` if it cannot be read as text.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        read_text(&self.folder, name).ok()
    }

    /// The numbers of the frames that were drawn, ascending.
    #[must_use]
    pub fn frames(&self) -> Vec<u32> {
        let frames = self.ledger.frames.iter();
        frames.filter_map(|entry| entry.frame).collect()
    }

    /// What is wrong with a line of its states.
    pub(super) fn wrong(&self, source: ReportError) -> ExplainError {
        ExplainError::Report {
            folder: self.folder.clone(),
            source,
        }
    }

    /// The plants, grown or imported from the run's own copies.
    ///
    /// # Errors
    ///
    /// When a copy is missing or is not what was drawn.
    pub fn world(&self, progress: &dyn Progress) -> Result<World, ExplainError> {
        Ok(World::build(&self.scene, &self.folder, progress)?)
    }
}

/// A run that is played again, frame after frame.
#[derive(Debug)]
pub struct Replay<'r> {
    run: &'r RecordedRun,
    session: Session<'r>,
    reader: OpsReader<'r>,
    next: usize,
}

/// A frame that was drawn again.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ReplayedFrame {
    /// Its number.
    pub frame: u32,
    /// The picture's digest as the ledger has it.
    pub ledger_digest: String,
    /// The picture's digest now.
    pub digest: String,
    /// Whether both are the same.
    pub same: bool,
}

impl<'r> Replay<'r> {
    /// Sends what is sent before the first frame, with every byte recorded.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn new(run: &'r RecordedRun, world: &'r World) -> Result<Self, ExplainError> {
        let session = Session::recorded(&run.scene, world, &run.options)?;
        Ok(Self {
            run,
            session,
            reader: OpsReader::new(world),
            next: 0,
        })
    }

    /// The session as it is now.
    #[must_use]
    pub fn session(&self) -> &Session<'r> {
        &self.session
    }

    /// Draws the next frame from its states; what was recorded before is forgotten.
    ///
    /// # Errors
    ///
    /// When a line of states is wrong.
    pub fn draw_next(&mut self) -> Result<Option<(Frame, ReplayedFrame)>, ExplainError> {
        let Some(line) = self.run.ops.lines().nth(self.next) else {
            return Ok(None);
        };
        let entry = self.run.ledger.frames.get(self.next);
        self.next += 1;
        let wrong = |source| self.run.wrong(source);
        let (number, states) = self.reader.read(line).map_err(wrong)?;
        self.session.record();
        let change = self.session.commit_states(states)?;
        let frame = self.session.draw(number, change)?;
        let ledger_digest = entry.and_then(|entry| entry.image_digest.clone());
        let ledger_digest = ledger_digest.unwrap_or_default();
        let digest = frame.image_digest.to_string();
        let replayed = ReplayedFrame {
            frame: number,
            same: ledger_digest == digest,
            ledger_digest,
            digest,
        };
        Ok(Some((frame, replayed)))
    }
}

fn read_text(folder: &Path, name: &str) -> Result<String, String> {
    let cannot = |problem: &dyn std::fmt::Display| format!("cannot read {name}: {problem}");
    let bytes =
        read_file(&folder.join(name), RUN_TEXT_BYTES).map_err(|problem| cannot(&problem))?;
    String::from_utf8(bytes).map_err(|problem| cannot(&problem))
}
