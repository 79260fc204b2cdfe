//! The laws, each as a check of its own.
//!
//! | law | looks at | check |
//! |---|---|---|
//! | [partition](partition()) | what is visible in a state | every original leaf stands under exactly one visible leaf |
//! | [birth before death](birth_before_death()) | the same | what is visible has been made, and has not been consumed |
//! | [split undoes collapse](split_undoes_collapse()) | two moments | a split brings back what a collapse took |
//! | [history independence](history_independence()) | two ways | what is shown depends on the state, not on the way to it |
//! | [monotone detail](monotone_detail()) | two states | less detail never shows more; [by distance](detail_by_distance()) neither |
//! | [residency](residency()) | two models | every byte that a draw can read is what a fresh upload holds |
//! | [conservation](conservation()) | one model | what was written is what is held and what was counted |
//! | [image equality](image_equality()) | two models | the same leaves give the same picture, whatever lies in dead bytes |
//! | [K-means error never rises](error_never_rises()) | one clustering | no step raises the total error |
//!
//! Each says in its documentation which bug it was seen to catch; `spinney selftest` plants them all.

mod cut;
mod error;
mod memory;
mod ways;

pub use cut::{birth_before_death, partition};
pub use error::error_never_rises;
pub(super) use memory::same_bytes;
pub use memory::{
    conservation, conservation_of, image_equality, poison_dead_bytes, residency, residency_of,
    same_picture,
};
pub use ways::{
    Asked, detail_by_distance, history_independence, monotone_detail, split_undoes_collapse,
};
