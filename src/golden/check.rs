//! Drawing scenes and comparing them, told one after another.

use std::collections::BTreeSet;
use std::path::PathBuf;

use rayon::prelude::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::compare::compare_frame;
use super::digests::SceneDigests;
use super::draw::{KeptFrame, draw};
use super::error::GoldenError;
use super::find::{FoundScene, ReadScene, files_below, scene_files};
use super::lines::DigestLines;
use super::outcome::{Case, CaseOutcome, Finding, FindingKind, Outcome, SceneOutcome};
use super::reference::{FrameFiles, scene_of};
use super::{Goldens, Selection};
use crate::run::{CrownStore, Progress};
use crate::scene::SceneError;

/// Scenes whose frames are kept at once, until they are told in order.
const AT_ONCE: usize = 16;

/// A scene file, and what it says or why it says nothing.
#[derive(Debug)]
pub(super) struct Candidate {
    pub(super) found: FoundScene,
    pub(super) read: Result<ReadScene, GoldenError>,
}

/// A scene that was compared.
#[derive(Debug)]
pub(super) struct Compared {
    pub(super) outcome: SceneOutcome,
    /// Its digests, if it could be drawn.
    pub(super) digests: Option<SceneDigests>,
}

impl Goldens {
    /// Draws scenes and compares them with their references.
    ///
    /// Everything that is wrong with a scene or reference is a finding; no scene keeps others from
    /// being compared.
    ///
    /// # Errors
    ///
    /// When a folder cannot be read, or there is nothing to compare.
    pub fn check(
        &self,
        selection: &Selection,
        progress: &dyn Progress,
    ) -> Result<Outcome, GoldenError> {
        self.survey(selection, progress, &mut |_, _| {})
    }

    /// As [`check`](Self::check); each scene that could be drawn is told with its frames.
    pub(super) fn survey(
        &self,
        selection: &Selection,
        progress: &dyn Progress,
        tell: &mut dyn FnMut(&Compared, Vec<KeptFrame>),
    ) -> Result<Outcome, GoldenError> {
        let candidates = self.candidates()?;
        let lines = DigestLines::read(&self.digests_file());
        let wanted: Vec<&Candidate> = candidates
            .iter()
            .filter(|candidate| selection.has(&candidate.found.name))
            .filter(|candidate| lines.is_some() || candidate.is_kept())
            .collect();
        if wanted.is_empty() {
            return Err(GoldenError::NothingKept {
                folder: self.scenes.clone(),
                only: selection.only.clone(),
            });
        }
        let mut outcome = Outcome {
            digests: lines.is_some(),
            ..Outcome::default()
        };
        let store = CrownStore::new();
        progress.begin("scenes", wanted.len() as u64);
        for some in wanted.chunks(AT_ONCE) {
            let compared: Vec<_> = some
                .par_iter()
                .map(|candidate| {
                    let mut frames = Vec::new();
                    let compared = self.compare(candidate, &store, lines.as_ref(), &mut frames);
                    progress.step();
                    (compared, frames)
                })
                .collect();
            for (compared, frames) in compared {
                tell(&compared, frames);
                outcome.scenes.push(compared.outcome);
            }
        }
        outcome.strays = self.strays(&candidates, lines.as_ref(), selection)?;
        Ok(outcome)
    }

    /// Every scene file, read.
    pub(super) fn candidates(&self) -> Result<Vec<Candidate>, GoldenError> {
        let files = scene_files(&self.scenes)?.into_iter();
        let candidate = |found: FoundScene| Candidate {
            read: found.read(),
            found,
        };
        Ok(files.map(candidate).collect())
    }

    /// Draws and compares a scene; adds the frames that it keeps to `frames`.
    pub(super) fn compare(
        &self,
        candidate: &Candidate,
        store: &CrownStore,
        lines: Option<&DigestLines>,
        frames: &mut Vec<KeptFrame>,
    ) -> Compared {
        let mut outcome = SceneOutcome {
            name: candidate.found.name.clone(),
            file: candidate.found.file.clone(),
            line: 1,
            tolerance: 0,
            reason: None,
            cases: Vec::new(),
        };
        let read = match &candidate.read {
            Ok(read) => read,
            Err(error) => return unreadable(outcome, error),
        };
        let golden = read.scene.scene.golden.as_ref();
        if let Some(golden) = golden {
            outcome.line = read.scene.source.error("golden", "").line;
            outcome.tolerance = golden.tolerance;
            outcome.reason.clone_from(&golden.reason);
        }
        let drawn = draw(read, store, &mut |kept| {
            // Without the table, frames can be many and large, and only their digests are wanted.
            if golden.is_some() {
                frames.push(kept);
            }
        });
        let digests = match drawn {
            Ok(digests) => digests,
            Err(error) => {
                frames.clear();
                return unreadable(outcome, &error);
            }
        };
        for kept in &*frames {
            let files = FrameFiles::of(&self.references, &outcome.name, kept.frame.frame);
            let case = compare_frame(kept, &files, outcome.tolerance);
            outcome.cases.push(case.unwrap_or_else(|error| CaseOutcome {
                case: Case::Frame(kept.frame.frame),
                findings: vec![Finding {
                    file: files.picture,
                    kind: FindingKind::Unreadable(error.to_string()),
                    evidence: None,
                }],
                tolerated: None,
            }));
        }
        if let Some(lines) = lines {
            let kind = lines.compare(&digests, outcome.tolerance);
            outcome.cases.push(CaseOutcome {
                case: Case::Digests,
                findings: kind
                    .map(|kind| Finding {
                        file: self.digests_file(),
                        kind,
                        evidence: None,
                    })
                    .into_iter()
                    .collect(),
                tolerated: None,
            });
        }
        Compared {
            outcome,
            digests: Some(digests),
        }
    }

    /// References and lines of digests that no scene keeps, by their names.
    pub(super) fn strays(
        &self,
        candidates: &[Candidate],
        lines: Option<&DigestLines>,
        selection: &Selection,
    ) -> Result<Vec<Finding>, GoldenError> {
        let mut strays = Vec::new();
        let stray = |file: PathBuf, kind| Finding {
            file,
            kind,
            evidence: None,
        };
        if let Some(lines) = lines {
            let is_scene = |name: &str| candidates.iter().any(|found| found.found.name == name);
            for (number, name) in lines.names() {
                if selection.has(name) && !is_scene(name) {
                    let kind = FindingKind::UnusedLine {
                        line: number,
                        scene: name.to_owned(),
                    };
                    strays.push(stray(self.digests_file(), kind));
                }
            }
            for (number, message) in lines.wrong() {
                let place = self.digests_file().display().to_string();
                let kind = FindingKind::Unreadable(format!("{place}:{number}:1: {message}"));
                strays.push(stray(self.digests_file(), kind));
            }
        }
        if !self.references.exists() {
            return Ok(strays);
        }
        let mut kept = BTreeSet::new();
        // What a scene that cannot be read keeps is not known.
        let mut unknown = BTreeSet::new();
        for candidate in candidates {
            let name = candidate.found.name.as_str();
            match &candidate.read {
                Err(_) => _ = unknown.insert(name),
                Ok(read) => {
                    let golden = read.scene.scene.golden.iter();
                    for &frame in golden.flat_map(|golden| &golden.frames) {
                        let files = FrameFiles::of(&self.references, name, frame);
                        kept.extend([files.picture_name, files.table_name]);
                    }
                }
            }
        }
        for (name, file) in files_below(&self.references)? {
            let scene = scene_of(&name).filter(|scene| selection.has(scene));
            if scene.is_some_and(|scene| !unknown.contains(scene) && !kept.contains(&name)) {
                strays.push(stray(file, FindingKind::Unused));
            }
        }
        Ok(strays)
    }

    /// Where digests are kept, if they are.
    pub(super) fn digests_file(&self) -> PathBuf {
        self.references.join("digests.txt")
    }
}

impl Candidate {
    /// Whether it has, or could have, references.
    pub(super) fn is_kept(&self) -> bool {
        let read = self.read.as_ref();
        read.map_or(true, |read| read.scene.scene.golden.is_some())
    }
}

impl Selection {
    /// Whether a scene is one of them.
    fn has(&self, name: &str) -> bool {
        let only = self.only.as_deref();
        only.is_none_or(|only| name.contains(only))
    }
}

fn unreadable(mut outcome: SceneOutcome, error: &GoldenError) -> Compared {
    if let GoldenError::Scene(SceneError::Document(place)) = error {
        outcome.line = place.line;
    }
    outcome.cases = vec![CaseOutcome {
        case: Case::Scene,
        findings: vec![Finding {
            file: outcome.file.clone(),
            kind: FindingKind::Unreadable(error.to_string()),
            evidence: None,
        }],
        tolerated: None,
    }];
    Compared {
        outcome,
        digests: None,
    }
}
