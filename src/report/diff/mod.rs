//! Two of a kind: how much they differ, where, and how that looks.
//!
//! ```text
//!  Picture ┐            ┌─▶ Difference: how many pixels, by how much, where
//!          ├─ compare ──┤
//!  Picture ┘            └─▶ triptych: expected | differing | actual
//! ```
//!
//! **Invariant.** What is found is a function of the two things compared: sums are taken in the
//! order of pixels, whatever the number of threads.

mod difference;
mod triptych;

pub use difference::{Difference, SizeMismatch};
pub use triptych::triptych;

#[cfg(test)]
mod tests {
    use crate::report::Picture;

    /// 3 × 2 grey pixels, one of them another grey.
    pub(super) fn grey(odd: usize, value: u8) -> Picture {
        let mut rgba = [100, 100, 100, 255].repeat(6);
        rgba[4 * odd + 1] = value;
        Picture::new(3, 2, rgba).expect("filled")
    }
}
