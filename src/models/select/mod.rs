//! How detail is chosen: from where a plant is seen to a [`State`](super::State); pure functions.
//!
//! ```text
//!  how many leaves                           where                              when
//! ─ paper: by distance ───────────────▶ uniform, or by each cluster's own ─┐
//! ─ a budget, a share, a step ──▶ spread: Importance ─▶ apportion ─────────┼▶ settle ─▶ spend ─▶ State
//! ─ permitted pixels of error ────────▶ within_pixels ─────────────────────┘  band      bytes
//! ```
//!
//! The papers' criterion is distance ([RRCGR](crate::references), section V); that others can be added
//! is said there, and that the application assigns a number of leaves, distributed "following some
//! specific criteria" (section IV-C). Which ones, how leaves are dealt out, errors in pixels, the band
//! and the budget of bytes are ours.
//!
//! **Invariant.** Nothing here remembers: what a choice depends on beside the view is handed in as the
//! state that stands on the device.

mod apportion;
mod importance;
mod level;
mod paper;
mod settle;
mod sight;
mod spend;
mod within;

pub use apportion::{Apportionment, apportion};
pub use importance::{
    ByDistance, ByScreenError, BySilhouette, ClusterFacts, Importance, spread, weights,
};
pub use level::{level, level_with};
pub(super) use paper::collapses_at;
pub use paper::{Criterion, Extent, select};
pub use settle::{Band, settle};
pub use sight::Sight;
pub use spend::{Move, Spent, gain, spend};
pub use within::within_pixels;
