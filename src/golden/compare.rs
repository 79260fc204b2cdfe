//! A frame against its references.

use super::change::{Change, changes};
use super::draw::KeptFrame;
use super::outcome::{Case, CaseOutcome, Evidence, Finding, FindingKind};
use super::reference::{FrameFiles, read_picture, read_text};
use crate::report::{Difference, Picture, ReportError, triptych};

/// The fact of a table that says nothing beside a picture that is compared itself.
const PICTURE: &str = "picture";

/// Compares a frame.
///
/// # Errors
///
/// None for a frame that was drawn at a size that is kept.
pub(super) fn compare_frame(
    kept: &KeptFrame,
    files: &FrameFiles,
    tolerance: u8,
) -> Result<CaseOutcome, ReportError> {
    let actual = kept.picture()?;
    let mut outcome = CaseOutcome {
        case: Case::Frame(kept.frame.frame),
        findings: Vec::new(),
        tolerated: None,
    };
    let mut found = |kind, file: &std::path::Path, evidence| {
        let file = file.to_owned();
        let finding = Finding {
            file,
            kind,
            evidence,
        };
        outcome.findings.push(finding);
    };
    let picture = |bytes| Evidence {
        name: files.picture_name.clone(),
        bytes,
    };
    let mut is_same = false;
    match read_picture(&files.picture) {
        Err(kind) => found(kind, &files.picture, Some(picture(actual.to_small_png()?))),
        Ok(expected) => match Difference::between(&expected, &actual, tolerance) {
            Ok(difference) if difference.is_within() => {
                is_same = difference.unequal == 0;
                outcome.tolerated = (!is_same).then_some(difference);
            }
            compared => {
                let side_by_side = triptych(&expected, &actual, tolerance)?.to_small_png()?;
                let kind = match compared {
                    Ok(difference) => FindingKind::Picture(difference),
                    Err(sizes) => FindingKind::Size {
                        expected: sizes.expected,
                        actual: sizes.actual,
                    },
                };
                found(kind, &files.picture, Some(picture(side_by_side)));
            }
        },
    }
    let kind = match read_text(&files.table) {
        Err(kind) => Some(kind),
        // A line end of another system is no difference.
        Ok(expected) if expected.lines().eq(kept.table.lines()) => None,
        Ok(expected) => {
            let all = changes(&expected, &kept.table);
            let is_form = all.is_empty();
            // Whether the picture differs, and by how much, was told already, or is tolerated.
            let counts = |change: &Change| change.what != PICTURE || (is_same && tolerance == 0);
            let all: Vec<Change> = all.into_iter().filter(counts).collect();
            (is_form || !all.is_empty()).then_some(FindingKind::Ledger(all))
        }
    };
    if let Some(kind) = kind {
        let file = files.table.clone();
        let evidence = Some(Evidence {
            name: files.table_name.clone(),
            bytes: kept.table.clone().into_bytes(),
        });
        outcome.findings.push(Finding {
            file,
            kind,
            evidence,
        });
    }
    Ok(outcome)
}

impl KeptFrame {
    /// The picture, for reports.
    ///
    /// # Errors
    ///
    /// None for a frame that was drawn.
    pub fn picture(&self) -> Result<Picture, ReportError> {
        let image = &self.frame.image;
        Picture::new(image.width, image.height, image.rgba.clone())
    }
}
