//! How much detail of a trunk is shown.

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
}
