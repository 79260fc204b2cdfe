//! How much detail of a trunk is shown.

use crate::simplify::ErrorStep;

/// The state of a trunk.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum TrunkLevel {
    /// The first so many collapses of a mesh's sequence are done.
    Collapses(u32),
    /// Branches are off by no more than an error.
    Error(ErrorStep),
}

impl TrunkLevel {
    /// Full detail.
    pub const FINEST: Self = Self::Collapses(0);

    /// How many collapses of a mesh are done: none where an error is said.
    #[must_use]
    pub fn collapses(self) -> u32 {
        match self {
            Self::Collapses(collapses) => collapses,
            Self::Error(_) => 0,
        }
    }

    /// The error of branches: the least where collapses are said.
    #[must_use]
    pub fn step(self) -> ErrorStep {
        match self {
            Self::Collapses(_) => ErrorStep::FINEST,
            Self::Error(step) => step,
        }
    }
}

impl Default for TrunkLevel {
    fn default() -> Self {
        Self::FINEST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_written_by_what_they_say() {
        let texts = [
            (TrunkLevel::FINEST, r#"{"collapses":0}"#),
            (TrunkLevel::Collapses(7), r#"{"collapses":7}"#),
            (TrunkLevel::Error(ErrorStep::new(31)), r#"{"error":31}"#),
        ];
        for (level, text) in texts {
            assert_eq!(serde_json::to_string(&level).unwrap(), text);
            assert_eq!(serde_json::from_str::<TrunkLevel>(text).unwrap(), level);
        }
    }
}
