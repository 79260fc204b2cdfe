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

mod channels;
mod colour;
mod difference;
mod fields;
mod filter;
mod flip;
mod image;
mod json;
mod page;
mod run;
mod ssim;
mod text;
mod triptych;

pub use channels::{ChannelDifference, ChannelDifferences};
pub use difference::{Difference, SizeMismatch};
pub use fields::FieldDifference;
pub use flip::{Flip, FlipReference, flip};
pub use image::{ImageDifference, LookDifference, Metrics};
pub use json::DIFF_SCHEMA;
pub use page::DiffFolder;
pub use run::{FileDifference, FileState, FrameDifference, RunDifference};
pub use ssim::ssim;
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

    /// The sides of [`example`].
    pub(super) const SIDES: [u32; 2] = [64, 80];

    /// Ramps and a chessboard.
    pub(super) fn example() -> Picture {
        drawn(board)
    }

    /// The example, changed as the name says.
    pub(super) fn variant(name: &str) -> Picture {
        drawn(|x, y| {
            let old = board(x, y);
            match name {
                "offset" => old.map(|value| value + 10),
                "noise" => std::array::from_fn(|channel| old[channel] + noise(x, y, channel)),
                "shift" => board(x + 1, y),
                "spots" if (7 * x + 13 * y) % 97 == 0 => [255, 0, 0],
                "one" if [x, y] == [20, 30] => [255; 3],
                "inverse" => old.map(|value| 255 - value),
                _ => old,
            }
        })
    }

    fn drawn(colour: impl Fn(u32, u32) -> [i32; 3]) -> Picture {
        let [width, height] = SIDES;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let byte = |value: i32| u8::try_from(value.clamp(0, 255)).expect("clamped");
        let rgba = places.flat_map(|(x, y)| {
            let [red, green, blue] = colour(x, y).map(byte);
            [red, green, blue, 255]
        });
        Picture::new(width, height, rgba.collect()).expect("filled")
    }

    fn board(x: u32, y: u32) -> [i32; 3] {
        let [x, y] = [x, y].map(u32::cast_signed);
        let blue = if (x / 8 + y / 8) % 2 == 1 { 180 } else { 60 };
        [40 + 2 * x, 200 - 2 * y, blue]
    }

    /// From −16 to 16.
    fn noise(x: u32, y: u32, channel: usize) -> i32 {
        let channel = [0, 83_492_791, 166_985_582][channel];
        let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ channel;
        let mixed = mixed.wrapping_mul(2_654_435_761) >> 16;
        (mixed % 33).cast_signed() - 16
    }
}
