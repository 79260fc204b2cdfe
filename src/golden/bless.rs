//! Replacing references by what scenes show now.

use std::fs;
use std::path::PathBuf;

use super::check::Compared;
use super::digests::SceneDigests;
use super::draw::KeptFrame;
use super::error::GoldenError;
use super::lines::DigestLines;
use super::outcome::{Case, Finding, FindingKind, Outcome};
use super::reference::{FrameFiles, MAX_FILE_BYTES};
use super::{Goldens, Selection, Unused};
use crate::report::write_file;
use crate::run::Progress;

/// What blessing did.
#[derive(Debug, Clone, PartialEq)]
pub struct Blessing {
    /// What was there before, compared with what is there now.
    pub outcome: Outcome,
    /// What was done about each finding, in the order of [`Outcome::findings`].
    pub deeds: Vec<Deed>,
}

/// What blessing did about a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deed {
    /// The reference is new.
    Added,
    /// The reference was replaced.
    Replaced,
    /// The reference was removed.
    Removed,
    /// The unused reference stays, since nobody asked to remove it.
    Kept,
    /// Nothing, since the scene cannot be drawn.
    Undrawn,
    /// Nothing, since the reference would be larger than [`MAX_FILE_BYTES`].
    TooLarge,
}

/// Files to write, with what will be in them.
type Files = Vec<(PathBuf, Vec<u8>)>;

impl Blessing {
    /// Every finding with what was done about it.
    pub fn findings(&self) -> impl Iterator<Item = (&Finding, Deed)> {
        self.outcome.findings().zip(self.deeds.iter().copied())
    }

    /// Whether something stays as it was that is wrong, and that blessing should have mended.
    #[must_use]
    pub fn is_partial(&self) -> bool {
        let mut deeds = self.deeds.iter();
        deeds.any(|deed| matches!(deed, Deed::Undrawn | Deed::TooLarge))
    }

    /// A line for each finding: what was done, and by how much the reference changed; then how many
    /// of each.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let mut deeds = self.deeds.iter().copied();
        let scenes = self.outcome.scenes.iter();
        let in_scenes = scenes.flat_map(|scene| {
            let name = scene.name.as_str();
            scene.findings().map(move |finding| (name, finding))
        });
        let strays = self.outcome.strays.iter().map(|stray| ("", stray));
        for (scene, finding) in in_scenes.chain(strays) {
            let deed = deeds.next().unwrap_or(Deed::Undrawn);
            text += &deed_text(deed, scene, finding);
        }
        let counts: Vec<String> = Deed::ALL
            .into_iter()
            .filter_map(|deed| {
                let count = self.deeds.iter().filter(|done| **done == deed).count();
                (count > 0).then(|| format!("{count} {}", deed.name()))
            })
            .collect();
        let done = match counts.is_empty() {
            true => "nothing to bless".to_owned(),
            false => counts.join(", "),
        };
        format!("{text}{}; {done}\n", self.outcome.extent())
    }
}

/// What was done about a finding of a scene.
fn deed_text(deed: Deed, scene: &str, finding: &Finding) -> String {
    let mut file = finding.file.display().to_string();
    if finding.what() == "digests" && !scene.is_empty() {
        file += &format!(": {scene}");
    }
    let words = finding.words();
    match deed {
        Deed::Added | Deed::Removed => format!("{file}: {}\n", deed.name()),
        Deed::Replaced => format!("{file}: replaced: {words}\n"),
        Deed::Kept => format!("{file}: {words}; kept\n"),
        Deed::Undrawn => format!("{file}: not drawn: {words}\n"),
        Deed::TooLarge => {
            format!("{file}: not written, since it would exceed {MAX_FILE_BYTES} bytes\n")
        }
    }
}

impl Deed {
    /// Every deed.
    pub const ALL: [Self; 6] = [
        Self::Added,
        Self::Replaced,
        Self::Removed,
        Self::Kept,
        Self::Undrawn,
        Self::TooLarge,
    ];

    /// One or two words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Added => "added",
            Self::Replaced => "replaced",
            Self::Removed => "removed",
            Self::Kept => "unused kept",
            Self::Undrawn => "not drawn",
            Self::TooLarge => "too large",
        }
    }
}

impl Goldens {
    /// Replaces the references of scenes that differ from what the scenes show now, and adds those
    /// that are missing.
    ///
    /// All scenes are drawn before anything is written; every file is written whole. References of a
    /// scene that cannot be read or drawn, and those that would be too large, stay as they are.
    /// `digests.txt` is renewed if it is there.
    ///
    /// # Errors
    ///
    /// As [`check`](Self::check), and when a reference cannot be written or removed.
    pub fn bless(
        &self,
        selection: &Selection,
        unused: Unused,
        progress: &dyn Progress,
    ) -> Result<Blessing, GoldenError> {
        let mut files = Files::new();
        let mut refused = Vec::new();
        let mut renewed = Vec::new();
        let mut failed = Ok(());
        let outcome = self.survey(selection, progress, &mut |compared, frames| {
            if failed.is_ok() {
                failed = self.renew(compared, &frames, &mut files, &mut refused);
            }
            renewed.extend(digests_to_renew(compared));
        })?;
        failed?;
        if let Some(lines) = DigestLines::read(&self.digests_file()) {
            files.extend(self.renewed_lines(&lines, &renewed, &outcome, unused));
        }
        for (file, bytes) in &files {
            write_file(file, bytes)?;
        }
        let is_unused = |finding: &&Finding| finding.kind == FindingKind::Unused;
        for stray in outcome.strays.iter().filter(is_unused) {
            if unused == Unused::Remove {
                fs::remove_file(&stray.file).map_err(|cause| GoldenError::Remove {
                    file: stray.file.clone(),
                    cause,
                })?;
            }
        }
        let deed = |finding: &Finding| match &finding.kind {
            FindingKind::Unused | FindingKind::UnusedLine { .. } => match unused {
                Unused::Remove => Deed::Removed,
                Unused::Keep => Deed::Kept,
            },
            _ if refused.contains(&finding.file) => Deed::TooLarge,
            FindingKind::Missing | FindingKind::MissingLine => Deed::Added,
            _ if files.iter().any(|(file, _)| *file == finding.file) => Deed::Replaced,
            _ => Deed::Undrawn,
        };
        let deeds = outcome.findings().map(deed).collect();
        Ok(Blessing { outcome, deeds })
    }

    /// Adds the files of the frames of a scene in which something is wrong; what would be too large
    /// is refused with its frame.
    fn renew(
        &self,
        compared: &Compared,
        frames: &[KeptFrame],
        files: &mut Files,
        refused: &mut Vec<PathBuf>,
    ) -> Result<(), GoldenError> {
        for kept in frames {
            let number = kept.frame.frame;
            let mut cases = compared.outcome.cases.iter();
            let differs =
                cases.any(|case| case.case == Case::Frame(number) && !case.findings.is_empty());
            if !differs {
                continue;
            }
            let names = FrameFiles::of(&self.references, &compared.outcome.name, number);
            let picture = kept.picture()?.to_small_png()?;
            let table = kept.table.clone().into_bytes();
            let is_large = |bytes: &[u8]| bytes.len() as u64 > MAX_FILE_BYTES;
            if is_large(&picture) || is_large(&table) {
                refused.extend([names.picture, names.table]);
                continue;
            }
            // Both, also if only one differs: a table names the picture that it belongs to.
            files.extend([(names.picture, picture), (names.table, table)]);
        }
        Ok(())
    }

    /// `digests.txt` as it must be, if that is not what it is.
    fn renewed_lines(
        &self,
        lines: &DigestLines,
        renewed: &[SceneDigests],
        outcome: &Outcome,
        unused: Unused,
    ) -> Option<(PathBuf, Vec<u8>)> {
        let is_unused = |name: &str| {
            let mut strays = outcome.strays.iter();
            strays.any(|stray| match &stray.kind {
                FindingKind::UnusedLine { scene, .. } => scene == name,
                _ => false,
            })
        };
        let removes = unused == Unused::Remove && lines.names().any(|(_, name)| is_unused(name));
        if renewed.is_empty() && !removes && lines.wrong().next().is_none() {
            return None;
        }
        let keep = |name: &str| unused == Unused::Keep || !is_unused(name);
        Some((self.digests_file(), lines.with(renewed, &keep).into_bytes()))
    }
}

/// The digests of a scene whose line is missing or differs.
fn digests_to_renew(compared: &Compared) -> Option<SceneDigests> {
    let mut cases = compared.outcome.cases.iter();
    let differs = cases.any(|case| case.case == Case::Digests && !case.findings.is_empty());
    compared.digests.clone().filter(|_| differs)
}
