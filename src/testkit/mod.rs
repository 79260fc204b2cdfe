//! Testing level-of-detail structures, yours or ours: histories, laws, and counter-examples.
//!
//! ```text
//!  History ─┬─ build ──▶ your Structure ───── visible ─────┐
//!  (leaves, │                                              ├──▶ laws ──▶ Tally, or a Violation
//!  collapses)  build ──▶ your DeviceModel ─ bytes, reads, ─┘             that says which law,
//!           │                               log, counters,               where, and both numbers
//!  Walk ────┘ (operations)                  picture
//! ```
//!
//! - [`Structure`] is a collapse/split structure without any device: three functions.
//!   [`check_structure`] takes it through a [`Walk`] and checks every law of structures.
//! - [`DeviceModel`] is a model that keeps something on a device, be it ours or not.
//!   [`check_device_model`] takes it through states and checks what it holds, sends and draws.
//! - The [`laws`] are functions of their own too, for harnesses that work otherwise.
//!
//! - With the feature `testkit`, `testkit::strategy` draws random histories, walks and foliage for
//!   proptest, and shrinks what fails.
//! - A program in any language can record a [`trace`] of what it does;
//!   [`check_trace`](trace::check_trace) checks it.
//! - [`selftest`] plants known faults and fails unless the laws find each.
//!
//! Our own models go through the same door ([`ModelStructure`], [`Stage`], and whole forests as
//! [`ForestStage`]).
//!
//! **Invariant.** Nothing here trusts what it tests: what is visible in a state is replayed from the
//! history, what is resident from the log of writes.

mod contents;
mod device;
mod forest;
mod history;
pub mod laws;
mod meddled;
mod operation;
mod paper;
mod selftest;
mod simpler;
mod stage;
#[cfg(feature = "testkit")]
pub mod strategy;
mod structure;
pub mod trace;
mod violation;
mod watch;

pub use crate::models::State;
pub use contents::Contents;
pub use device::{
    Change, Counted, DeviceModel, Itemised, Picture, Reads, Residency, Resource,
    check_device_model, check_end,
};
pub use forest::ForestStage;
pub use history::{History, HistoryError};
pub use meddled::{Meddled, Meddling, Redraw};
pub use operation::{Operation, Walk};
pub use paper::{LeafCount, PaperFault, PaperLodf};
pub use selftest::{Counterexample, MutantReport, SelftestReport, selftest};
pub use simpler::{Simpler, TreeWalk};
pub use stage::Stage;
pub use structure::{ModelStructure, Structure, check_structure};
pub use violation::{Law, Tally, Violation};
