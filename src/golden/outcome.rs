//! What a check found.

use std::fmt;
use std::path::PathBuf;

use super::change::Change;
use crate::report::Difference;

/// What a check of scenes found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outcome {
    /// Every scene that was compared or should have been, in the order of names.
    pub scenes: Vec<SceneOutcome>,
    /// What no scene keeps: references without a frame, lines of digests without a scene.
    pub strays: Vec<Finding>,
    /// Whether `digests.txt` was there to be compared.
    pub digests: bool,
}

/// What a check found of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneOutcome {
    /// Its path below the folder of scenes, without its ending.
    pub name: String,
    /// The scene file.
    pub file: PathBuf,
    /// The line of its `[golden]` heading, or 1.
    pub line: usize,
    /// The largest difference of a channel that passes.
    pub tolerance: u8,
    /// Why that is right.
    pub reason: Option<String>,
    /// What was compared, in order.
    pub cases: Vec<CaseOutcome>,
}

/// What was compared at once.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseOutcome {
    /// What it is.
    pub case: Case,
    /// All that is wrong with it.
    pub findings: Vec<Finding>,
    /// How a picture differs that passes by its scene's tolerance.
    pub tolerated: Option<Difference>,
}

/// A part of a scene that is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// That it can be read and drawn at all.
    Scene,
    /// A frame: its picture and its ledger.
    Frame(u32),
    /// Its line of `digests.txt`.
    Digests,
}

/// Something that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The file that it is about: a reference, or the scene.
    pub file: PathBuf,
    /// What is wrong.
    pub kind: FindingKind,
    /// What to look at, where there is something.
    pub evidence: Option<Evidence>,
}

/// What can be wrong.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FindingKind {
    /// The picture is another.
    Picture(Difference),
    /// The picture has another size.
    Size {
        /// Pixels of the reference.
        expected: [u32; 2],
        /// Pixels of the frame.
        actual: [u32; 2],
    },
    /// The ledger is another; without changes, the table differs in form only.
    Ledger(Vec<Change>),
    /// These parts of a line of digests are others.
    Digests(Vec<String>),
    /// There is no reference.
    Missing,
    /// There is no line of digests.
    MissingLine,
    /// The reference is no frame's.
    Unused,
    /// A line of digests is no scene's.
    UnusedLine {
        /// Its number, from 1.
        line: usize,
        /// The scene that it names.
        scene: String,
    },
    /// The reference is larger than it may be.
    Oversized {
        /// Width and height, where they are known.
        size: Option<[u32; 2]>,
        /// The size of the file.
        bytes: u64,
    },
    /// The reference or scene cannot be read, or the scene not be drawn.
    Unreadable(String),
}

/// A file for people to look at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Evidence {
    /// Its name below the folder of what was found: that of the reference.
    pub name: String,
    /// What is in it: expected, differing and actual picture side by side where two differ, else what
    /// the scene shows now.
    pub bytes: Vec<u8>,
}

/// How many of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Scenes that were compared or should have been.
    pub scenes: usize,
    /// Scenes in which nothing is wrong.
    pub same: usize,
    /// Frames that were compared.
    pub frames: usize,
    /// Frames that pass by their scene's tolerance only.
    pub tolerated: usize,
    /// Pictures, ledgers and lines of digests that differ.
    pub differ: usize,
    /// References that are missing.
    pub missing: usize,
    /// References that no frame has.
    pub unused: usize,
    /// References that are too large.
    pub oversized: usize,
    /// References and scenes that cannot be read or drawn.
    pub unreadable: usize,
}

impl Outcome {
    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.strays.is_empty() && self.scenes.iter().all(SceneOutcome::is_same)
    }

    /// Everything that is wrong, in order.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.scenes
            .iter()
            .flat_map(SceneOutcome::findings)
            .chain(&self.strays)
    }

    /// How many of each.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let cases = || self.scenes.iter().flat_map(|scene| &scene.cases);
        let is_frame = |case: &&CaseOutcome| matches!(case.case, Case::Frame(_));
        let mut counts = Counts {
            scenes: self.scenes.len(),
            same: self.scenes.iter().filter(|scene| scene.is_same()).count(),
            frames: cases().filter(is_frame).count(),
            tolerated: cases().filter(|case| case.tolerated.is_some()).count(),
            ..Counts::default()
        };
        for finding in self.findings() {
            match finding.kind {
                FindingKind::Picture(_)
                | FindingKind::Size { .. }
                | FindingKind::Ledger(_)
                | FindingKind::Digests(_) => counts.differ += 1,
                FindingKind::Missing | FindingKind::MissingLine => counts.missing += 1,
                FindingKind::Unused | FindingKind::UnusedLine { .. } => counts.unused += 1,
                FindingKind::Oversized { .. } => counts.oversized += 1,
                FindingKind::Unreadable(_) => counts.unreadable += 1,
            }
        }
        counts
    }

    /// Whether nothing could be compared since the input is bad: no scene can be read and drawn.
    #[must_use]
    pub fn is_all_unreadable(&self) -> bool {
        let is_broken = |scene: &SceneOutcome| {
            let mut cases = scene.cases.iter();
            cases.any(|case| case.case == Case::Scene && !case.findings.is_empty())
        };
        !self.scenes.is_empty() && self.scenes.iter().all(is_broken)
    }
}

impl SceneOutcome {
    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.cases.iter().all(|case| case.findings.is_empty())
    }

    /// Everything that is wrong, in order.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.cases.iter().flat_map(|case| &case.findings)
    }
}

impl FindingKind {
    /// One word: `differs`, `missing`, `unused`, `oversized` or `unreadable`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Picture(_) | Self::Size { .. } | Self::Ledger(_) | Self::Digests(_) => "differs",
            Self::Missing | Self::MissingLine => "missing",
            Self::Unused | Self::UnusedLine { .. } => "unused",
            Self::Oversized { .. } => "oversized",
            Self::Unreadable(_) => "unreadable",
        }
    }
}

/// `frame 4`, `digests`, `scene`.
impl fmt::Display for Case {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Scene => out.write_str("scene"),
            Self::Frame(number) => write!(out, "frame {number}"),
            Self::Digests => out.write_str("digests"),
        }
    }
}

/// `golden/lodf/slots-0004.png: missing`.
impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.display().to_string();
        match &self.kind {
            // Errors name their file and place themselves.
            FindingKind::Unreadable(message) if message.starts_with(&file) => {
                out.write_str(message)
            }
            kind => write!(out, "{file}: {kind}"),
        }
    }
}

/// How many changes of a ledger are named in a sentence.
const CHANGES_NAMED: usize = 4;

impl fmt::Display for FindingKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Picture(difference) => difference.fmt(out),
            Self::Size { expected, actual } => write!(
                out,
                "{} × {} pixels, expected {} × {}",
                actual[0], actual[1], expected[0], expected[1]
            ),
            Self::Ledger(changes) if changes.is_empty() => {
                out.write_str("the table says the same in another form")
            }
            Self::Ledger(changes) => {
                let named = changes.iter().take(CHANGES_NAMED);
                let named: Vec<String> = named.map(ToString::to_string).collect();
                out.write_str(&named.join(", "))?;
                match changes.len().saturating_sub(CHANGES_NAMED) {
                    0 => Ok(()),
                    more => write!(out, ", and {more} more"),
                }
            }
            Self::Digests(parts) => {
                let verb = if parts.len() == 1 {
                    "differs"
                } else {
                    "differ"
                };
                write!(out, "{} {verb}", parts.join(", "))
            }
            Self::Missing => out.write_str("missing"),
            Self::MissingLine => out.write_str("missing: no line for this scene"),
            Self::Unused => out.write_str("unused: no scene keeps it"),
            Self::UnusedLine { line, scene } => {
                write!(out, "line {line}: unused: there is no scene {scene:?}")
            }
            Self::Oversized { size, bytes } => {
                if let Some([width, height]) = size {
                    write!(out, "{width} × {height} pixels in ")?;
                }
                let (side, most) = (super::MAX_SIDE, super::MAX_FILE_BYTES);
                write!(
                    out,
                    "{bytes} bytes, wanted at most {side} a side in {most} bytes"
                )
            }
            Self::Unreadable(message) => out.write_str(message),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_are_told_in_words() {
        let change = |after: &str| Change {
            what: "leaves".to_owned(),
            before: Some("4".to_owned()),
            after: Some(after.to_owned()),
        };
        let many = (5..11).map(|after| change(&after.to_string())).collect();
        for (kind, words) in [
            (
                FindingKind::Size {
                    expected: [3, 2],
                    actual: [6, 1],
                },
                "6 × 1 pixels, expected 3 × 2",
            ),
            (FindingKind::Ledger(vec![change("3")]), "leaves 4 → 3 (-1)"),
            (
                FindingKind::Ledger(many),
                "leaves 4 → 5 (+1), leaves 4 → 6 (+2), leaves 4 → 7 (+3), leaves 4 → 8 (+4), \
                 and 2 more",
            ),
            (
                FindingKind::Digests(vec!["models".to_owned(), "images".to_owned()]),
                "models, images differ",
            ),
            (
                FindingKind::Oversized {
                    size: Some([161, 4]),
                    bytes: 900,
                },
                "161 × 4 pixels in 900 bytes, wanted at most 160 a side in 32768 bytes",
            ),
        ] {
            assert_eq!(kind.to_string(), words);
        }
    }
}
