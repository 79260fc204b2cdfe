//! Details of pictures: where they lie, and how they are cut out.

use crate::report::thumbnail::enlarged;
use crate::report::{Picture, ReportError};

/// A part of a picture, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Window {
    /// Of its upper left corner.
    pub(super) corner: [u32; 2],
    pub(super) size: [u32; 2],
}

/// How many times larger a detail is shown.
const ENLARGED: u32 = 3;

/// The two windows, of a grid of windows an eighth as wide as the picture and a fourth as high, in which
/// differences add up to the most: the worst first, of equals the upper left one.
pub(super) fn worst(size: [u32; 2], differences: &[u8]) -> [Window; 2] {
    let [width, height] = size;
    let window = [(width / 8).max(1), (height / 4).max(1)];
    let corners = (0..height / window[1])
        .flat_map(|row| (0..width / window[0]).map(move |column| [column, row]));
    let windows = corners.map(|[column, row]| Window {
        corner: [column * window[0], row * window[1]],
        size: window,
    });
    let mut found: Vec<(u64, Window)> = windows
        .map(|window| (sum(width, differences, window), window))
        .collect();
    // Stable: the first of equals stays the first.
    found.sort_by_key(|(sum, _)| std::cmp::Reverse(*sum));
    let at = |place: usize| {
        let whole = Window {
            corner: [0, 0],
            size,
        };
        found.get(place).map_or(whole, |(_, window)| *window)
    };
    [at(0), at(1)]
}

fn sum(width: u32, differences: &[u8], window: Window) -> u64 {
    let rows = differences.chunks_exact(width.max(1) as usize);
    let rows = rows.skip(window.corner[1] as usize);
    rows.take(window.size[1] as usize)
        .flat_map(|row| {
            let first = window.corner[0] as usize;
            &row[first..first + window.size[0] as usize]
        })
        .map(|&by| u64::from(by))
        .sum()
}

impl Window {
    /// What it shows of a picture, enlarged.
    pub(super) fn of(self, picture: &Picture) -> Result<Picture, ReportError> {
        let [left, top] = self.corner;
        let [width, height] = self.size;
        let rows = picture
            .rgba()
            .chunks_exact(4 * picture.width().max(1) as usize);
        let rows = rows.skip(top as usize).take(height as usize);
        let bytes = rows.flat_map(|row| &row[4 * left as usize..4 * (left + width) as usize]);
        let part = Picture::new(width, height, bytes.copied().collect())?;
        enlarged(&part, ENLARGED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ```text
    ///  . . . . . . . 3
    ///  . . 1 . . . . .
    ///  . . 1 . . . . .
    ///  . . . . . . . .
    /// ```
    #[test]
    fn the_worst_windows_come_first_and_the_upper_left_of_equals() {
        let mut differences = [0_u8; 32];
        differences[7] = 3;
        differences[10] = 1;
        differences[18] = 1;
        let [worst, second] = worst([8, 4], &differences);
        assert_eq!((worst.corner, worst.size), ([7, 0], [1, 1]));
        assert_eq!(second.corner, [2, 1]);
        let greys = differences.map(|by| [by, by, by, 255]);
        let picture = Picture::new(8, 4, greys.as_flattened().to_vec()).expect("small");
        let detail = worst.of(&picture).expect("smaller");
        assert_eq!((detail.width(), detail.height()), (3, 3));
        assert_eq!(detail.rgba()[..4], [3, 3, 3, 255]);
    }
}
