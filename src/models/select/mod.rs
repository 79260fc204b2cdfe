//! How detail is chosen.

mod apportion;
mod level;
mod paper;

pub use apportion::{Apportionment, apportion};
pub use level::level;
pub use paper::{Criterion, Extent, select};
