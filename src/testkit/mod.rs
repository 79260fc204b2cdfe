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
//! Our own models go through the same door ([`ModelStructure`], [`Stage`]).
//!
//! **Invariant.** Nothing here trusts what it tests: what is visible in a state is replayed from the
//! history, what is resident from the log of writes.

mod contents;
mod device;
mod history;
pub mod laws;
mod operation;
mod stage;
mod structure;
mod violation;

pub use crate::models::State;
pub use contents::Contents;
pub use device::{
    Change, Counted, DeviceModel, Itemised, Picture, Reads, Residency, Resource,
    check_device_model, check_end,
};
pub use history::{History, HistoryError};
pub use operation::{Operation, Walk};
pub use stage::Stage;
pub use structure::{ModelStructure, Structure, check_structure};
pub use violation::{Law, Tally, Violation};
