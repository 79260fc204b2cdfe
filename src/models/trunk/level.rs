//! How much detail of a trunk is shown.

use crate::models::Change;

/// The state of a trunk: the first `collapses` of its sequence are done.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
)]
pub struct TrunkLevel {
    /// How many.
    pub collapses: u32,
}

impl TrunkLevel {
    /// Full detail.
    pub const FINEST: Self = Self { collapses: 0 };

    /// What another level takes, but for records.
    pub(super) fn change_to(self, to: Self) -> Change {
        Change {
            collapses: to.collapses.saturating_sub(self.collapses),
            splits: self.collapses.saturating_sub(to.collapses),
            ..Change::default()
        }
    }
}
