//! The bytes of every model of each plant of a scene: the tables, and which models nothing beats.
//!
//! ```text
//! PlantBytes, … ─┬─ bytes_json, bytes_csv ──▶ bytes.json, bytes.csv   a row a plant, model and link
//!                ├─ bytes_plots ────────────▶ plots/pareto*.svg
//!                ├─ bytes_text, _markdown ──▶ terminal, table.md
//!                └─ bytes_page ─────────────▶ report.html
//! ```
//!
//! Models of foliage are compared among each other, and so are those of trunks, whose variants name
//! one (`full+lodstrips-device`: the foliage stays at full detail, so that what changes is the trunk).
//!
//! **Invariant.** A model is called better than another only where bytes *and* modelled time fall.
//! Streams stand apart in every table; only [comparing](sums::Cost) takes what goes down the bus
//! together.

mod entries;
mod files;
mod plots;
mod sums;
mod table;

pub use files::{BYTES_SCHEMA, bytes_csv, bytes_json, bytes_page, write_bytes};
pub use plots::bytes_plots;
pub use table::{bytes_markdown, bytes_text};

pub(super) use plots::color;
pub(super) use sums::dominates;

use crate::gpu::Link;
use crate::run::PlantBytes;

/// What was walked, and what was found.
#[derive(Debug, Clone, PartialEq)]
pub struct ByteReport {
    /// The scene's name.
    pub scene: String,
    /// Steps from full detail to the coarsest.
    pub steps: u32,
    /// The links by which wire bytes and times are modelled.
    pub links: Vec<Link>,
    /// The plants, in the order of the scene.
    pub plants: Vec<PlantBytes>,
    /// The scene as a scene file, for the page; without it the page shows none.
    pub resolved: String,
}
