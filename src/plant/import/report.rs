//! What an import counted, guessed, repaired and left out.

use super::Format;
use serde::Serialize;
use std::fmt;

/// What an import did; prints as a few lines of text.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct ImportReport {
    /// What the file was read as; `None` before anything is.
    pub format: Option<Format>,
    /// What the file holds, in its own words and the order of reading: how many cylinders, say.
    pub found: Vec<Found>,
    /// Triangles that became wood.
    pub trunk_triangles: u64,
    /// Leaves that are cards: two triangles, four corners.
    pub quad_leaves: u64,
    /// Leaves of any other shape.
    pub other_leaves: u64,
    /// Whether the plant was read exactly as spinney wrote it, without guesses.
    pub native: bool,
    /// All that needs saying, in the order in which it was met.
    pub entries: Vec<ReportEntry>,
}

/// How many of something a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Found {
    /// What it is, in the plural.
    pub what: &'static str,
    /// How many there are.
    pub count: u64,
}

/// One thing that needs saying.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ReportEntry {
    /// What happened.
    pub kind: ReportKind,
    /// How often.
    pub count: u64,
    /// Where first: a line, a JSON pointer, or a byte offset of a container.
    pub place: String,
    /// To what, and what it means.
    pub message: String,
}

/// What happened to a part of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ReportKind {
    /// Decided by a rule of thumb.
    Guessed,
    /// Not used, and nothing of the plant's shape is lost.
    Ignored,
    /// Left out, and something is lost.
    Dropped,
    /// Joined with something that it is not.
    Merged,
    /// Asked for by the document, but not there.
    Missing,
    /// In a form that is not supported.
    NotUnderstood,
    /// Wrong in the file, and set right.
    Repaired,
    /// Changed since spinney wrote it.
    Edited,
    /// Brought to where plants stand.
    Moved,
}

impl ImportReport {
    /// Counts `count` more of what the file holds.
    pub(in crate::plant) fn find(&mut self, what: &'static str, count: u64) {
        match self.found.iter_mut().find(|found| found.what == what) {
            Some(found) => found.count += count,
            None => self.found.push(Found { what, count }),
        }
    }

    /// How many of something the file holds.
    #[must_use]
    pub fn found(&self, what: &str) -> u64 {
        let found = self.found.iter().find(|found| found.what == what);
        found.map_or(0, |found| found.count)
    }

    /// Counts `count` more of what `message` says; the first place stays.
    pub(in crate::plant) fn add(
        &mut self,
        kind: ReportKind,
        count: u64,
        place: impl Into<String>,
        message: impl Into<String>,
    ) {
        if count == 0 {
            return;
        }
        let message = message.into();
        let known = self
            .entries
            .iter_mut()
            .rev()
            .take(RECENT)
            .find(|entry| entry.kind == kind && entry.message == message);
        match known {
            Some(entry) => entry.count += count,
            None => self.entries.push(ReportEntry {
                kind,
                count,
                place: place.into(),
                message,
            }),
        }
    }

    /// The entries of one kind.
    pub fn of_kind(&self, kind: ReportKind) -> impl Iterator<Item = &ReportEntry> {
        self.entries.iter().filter(move |entry| entry.kind == kind)
    }
}

/// How far back an equal entry is looked for. Kinds of message are few, but those that name a
/// material or an image may be as many as the file likes: a longer look would be quadratic.
const RECENT: usize = 64;

impl fmt::Display for ImportReport {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            format,
            found,
            trunk_triangles,
            quad_leaves,
            other_leaves,
            ..
        } = self;
        let how = if self.native { ", as written" } else { "" };
        if let Some(format) = format {
            write!(out, "{}: ", format.title())?;
        }
        for Found { what, count } in found {
            write!(out, "{count} {what}, ")?;
        }
        write!(
            out,
            "read as {trunk_triangles} triangles of wood, {quad_leaves} quad leaves, {other_leaves} other \
             leaves{how}"
        )?;
        self.entries
            .iter()
            .try_for_each(|entry| write!(out, "\n{entry}"))
    }
}

impl fmt::Display for ReportEntry {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            kind,
            count,
            place,
            message,
        } = self;
        if *count == 1 {
            write!(out, "{kind}: {message} (at {place})")
        } else {
            write!(out, "{kind}: {message} ({count}, first at {place})")
        }
    }
}

impl fmt::Display for ReportKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Guessed => "guessed",
            Self::Ignored => "ignored",
            Self::Dropped => "dropped",
            Self::Merged => "merged",
            Self::Missing => "missing",
            Self::NotUnderstood => "not understood",
            Self::Repaired => "repaired",
            Self::Edited => "edited",
            Self::Moved => "moved",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_entries_are_counted_and_keep_their_first_place() {
        let mut report = ImportReport::default();
        report.add(ReportKind::Dropped, 2, "/meshes/0", "points");
        report.add(ReportKind::Dropped, 1, "/meshes/4", "points");
        report.add(ReportKind::Dropped, 0, "/meshes/5", "lines");
        assert_eq!(report.entries.len(), 1);
        assert_eq!(
            report.entries[0].to_string(),
            "dropped: points (3, first at /meshes/0)"
        );
        report.find("cylinders", 3);
        report.find("cylinders", 4);
        assert_eq!(report.found("cylinders"), 7);
        assert!(report.to_string().starts_with("7 cylinders, read as 0 "));
    }
}
