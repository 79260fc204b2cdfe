//! The laws by name, and what a broken one says.

use std::fmt;

/// A law of level of detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Law {
    /// Every original leaf stands under exactly one visible leaf.
    Partition,
    /// What is visible has been made, and has not been consumed.
    BirthBeforeDeath,
    /// A split brings back what was visible before the collapse.
    SplitUndoesCollapse,
    /// What is shown and held depends on the state, not on the way to it.
    HistoryIndependence,
    /// Less detail never shows more leaves, nor leaves of more detail.
    MonotoneDetail,
    /// Every byte that a draw can read is what a fresh upload would hold.
    Residency,
    /// What was written gives what is held, and its lengths add up to what was counted.
    Conservation,
    /// The same leaves give the same picture, and bytes that no draw reads do not matter.
    ImageEquality,
    /// No step of K-means over leaves raises the total error.
    ErrorNeverRises,
}

impl Law {
    /// Every law.
    pub const ALL: [Self; 9] = [
        Self::Partition,
        Self::BirthBeforeDeath,
        Self::SplitUndoesCollapse,
        Self::HistoryIndependence,
        Self::MonotoneDetail,
        Self::Residency,
        Self::Conservation,
        Self::ImageEquality,
        Self::ErrorNeverRises,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Partition => "partition",
            Self::BirthBeforeDeath => "birth before death",
            Self::SplitUndoesCollapse => "split undoes collapse",
            Self::HistoryIndependence => "history independence",
            Self::MonotoneDetail => "monotone detail",
            Self::Residency => "residency",
            Self::Conservation => "conservation",
            Self::ImageEquality => "image equality",
            Self::ErrorNeverRises => "K-means error never rises",
        }
    }

    /// What it says.
    #[must_use]
    pub fn sentence(self) -> &'static str {
        match self {
            Self::Partition => "every original leaf stands under exactly one visible leaf",
            Self::BirthBeforeDeath => "what is visible has been made, and has not been consumed",
            Self::SplitUndoesCollapse => "a split brings back what a collapse took",
            Self::HistoryIndependence => "what is shown depends on the state, not on the way to it",
            Self::MonotoneDetail => "less detail never shows more",
            Self::Residency => "every byte that a draw can read is what a fresh upload holds",
            Self::Conservation => "what was written is what is held and what was counted",
            Self::ImageEquality => "the same leaves give the same picture",
            Self::ErrorNeverRises => "no step of K-means over leaves raises the total error",
        }
    }

    pub(super) fn index(self) -> usize {
        self as usize
    }
}

impl fmt::Display for Law {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(self.name())
    }
}

/// A law that was found broken. Prints as
/// `LAW is broken PLACE: WHAT: expected EXPECTED, found FOUND`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{law} is broken {place}: {what}: expected {expected}, found {found}")]
pub struct Violation {
    /// Which law.
    pub law: Law,
    /// Where: in which state, after which step; reads on after "is broken".
    pub place: String,
    /// What does not agree.
    pub what: String,
    /// The number or the bytes that would be right.
    pub expected: String,
    /// The number or the bytes that are there.
    pub found: String,
}

impl Violation {
    pub(super) fn new(
        law: Law,
        place: impl Into<String>,
        what: impl Into<String>,
        expected: impl fmt::Display,
        found: impl fmt::Display,
    ) -> Self {
        Self {
            law,
            place: place.into(),
            what: what.into(),
            expected: expected.to_string(),
            found: found.to_string(),
        }
    }

    /// The same, found at a place of a longer way.
    #[must_use]
    pub fn at(mut self, place: &str) -> Self {
        self.place = format!("{place}, {}", self.place);
        self
    }
}

/// How many times each law was checked.
///
/// A law without data is never checked, and its count says so: it stays 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    checked: [u64; Law::ALL.len()],
}

impl Tally {
    /// How many times a law was checked.
    #[must_use]
    pub fn checked(&self, law: Law) -> u64 {
        self.checked[law.index()]
    }

    /// Counts one check of a law and hands its result on.
    ///
    /// # Errors
    ///
    /// `result`'s own.
    pub fn count(&mut self, law: Law, result: Result<(), Violation>) -> Result<(), Violation> {
        self.checked[law.index()] += 1;
        result
    }

    /// Adds what another counted.
    pub fn add(&mut self, other: &Self) {
        for (sum, count) in self.checked.iter_mut().zip(other.checked) {
            *sum += count;
        }
    }
}

/// As in "partition 12, residency 3": laws that were never checked are left out.
impl fmt::Display for Tally {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let checked = Law::ALL.into_iter().filter(|&law| self.checked(law) > 0);
        for (number, law) in checked.enumerate() {
            let comma = if number == 0 { "" } else { ", " };
            write!(out, "{comma}{law} {}", self.checked(law))?;
        }
        Ok(())
    }
}
