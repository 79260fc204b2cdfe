//! Filters that come apart into one along rows and one along columns, band by band.
//!
//! ```text
//!  rows of a picture        a band, with a margin      filtered: the band's rows
//!  ────────────────         ┌───────────┐
//!                    ──▶    │ ─ margin ─│     ──▶    ┌───────────┐
//!  ────────────────         │   rows    │            │   rows    │
//!                           │ ─ margin ─│            └───────────┘
//!                           └───────────┘
//! ```
//!
//! Bands bound the memory, and are what threads share out among them; what a row becomes depends on
//! no band. Every sum is taken in the order of the weights.

use std::ops::Range;

use rayon::prelude::{IntoParallelIterator as _, ParallelIterator as _};

/// Rows of a band: some times the margins, few enough to stay in a processor's cache.
pub(super) const BAND_ROWS: usize = 64;

/// The weights of a filter along one direction, an odd number, the middle one at 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kernel(Vec<f64>);

impl Kernel {
    /// A filter from its weights at `-radius ..= radius`.
    pub(super) fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        let side = |index: usize| index as f64 - radius as f64;
        Self((0..=2 * radius).map(|index| weight(side(index))).collect())
    }

    /// The filter with positive weights that sum to 1, and negative ones, if any, to −1.
    pub(super) fn normalized(mut self) -> Self {
        let sum = |is_wanted: fn(f64) -> bool| -> f64 {
            self.0.iter().filter(|weight| is_wanted(**weight)).sum()
        };
        let (positive, negative) = (sum(|weight| weight > 0.0), -sum(|weight| weight < 0.0));
        for weight in &mut self.0 {
            *weight /= if *weight < 0.0 { negative } else { positive };
        }
        self
    }

    /// The sum of the weights.
    pub(super) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    /// How far it reaches.
    pub(super) fn radius(&self) -> usize {
        self.0.len() / 2
    }

    /// A plane filtered along its rows; beyond their ends they go on as they end.
    pub(super) fn along_rows(&self, plane: &[f64], width: usize) -> Vec<f64> {
        let radius = self.radius();
        let mut filtered = vec![0.0; plane.len()];
        let mut padded = vec![0.0; width + 2 * radius];
        let rows = plane.chunks_exact(width);
        for (row, filtered) in rows.zip(filtered.chunks_exact_mut(width)) {
            padded[..radius].fill(row[0]);
            padded[radius..radius + width].copy_from_slice(row);
            padded[radius + width..].fill(row[width - 1]);
            for (weight, row) in self.0.iter().zip(padded.windows(width)) {
                add(filtered, *weight, row);
            }
        }
        filtered
    }

    /// A plane filtered along its columns, without the margin of so many rows above and below.
    pub(super) fn along_columns(&self, plane: &[f64], width: usize, margin: usize) -> Vec<f64> {
        let first = margin - self.radius();
        let height = plane.len() / width - 2 * margin;
        let mut filtered = vec![0.0; height * width];
        for (y, filtered) in filtered.chunks_exact_mut(width).enumerate() {
            let rows = plane[(first + y) * width..].chunks_exact(width);
            for (weight, row) in self.0.iter().zip(rows) {
                add(filtered, *weight, row);
            }
        }
        filtered
    }
}

fn add(sums: &mut [f64], weight: f64, row: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += weight * value;
    }
}

/// What `work` makes of each row, band by band, in the order of rows.
pub(super) fn by_bands<T: Send>(
    rows: Range<usize>,
    work: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    let bands = rows.len().div_ceil(BAND_ROWS);
    let band = |index: usize| {
        let first = rows.start + index * BAND_ROWS;
        work(first..rows.end.min(first + BAND_ROWS))
    };
    let bands: Vec<Vec<T>> = (0..bands).into_par_iter().map(band).collect();
    bands.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_go_on_and_margins_are_cut() {
        let kernel = Kernel::new(1, |place| place + 2.0);
        // 1 2 3 over  | 1 0 | with its ends repeated
        //             | 0 4 |
        let plane = [1.0, 0.0, 0.0, 4.0];
        assert_eq!(kernel.along_rows(&plane, 2), [3.0, 1.0, 12.0, 20.0]);
        let plane = [9.0, 1.0, 2.0, 4.0, 9.0];
        assert_eq!(kernel.along_columns(&plane, 1, 2), [1.0 + 4.0 + 12.0]);
        assert_eq!(kernel.along_columns(&plane, 1, 1).len(), 3);
    }

    #[test]
    fn positive_and_negative_weights_balance() {
        let kernel = Kernel::new(1, |place| 3.0 * place * place - 1.0).normalized();
        assert_eq!(kernel.0, [0.5, -1.0, 0.5]);
        assert_eq!(kernel.sum(), 0.0);
    }

    #[test]
    fn bands_come_in_order_and_cover_every_row() {
        let rows = by_bands(3..3 + 3 * BAND_ROWS + 1, |rows| rows.collect());
        assert_eq!(rows, (3..3 + 3 * BAND_ROWS + 1).collect::<Vec<_>>());
        assert!(by_bands(3..3, |rows| rows.collect::<Vec<_>>()).is_empty());
    }
}
