//! Where views lie on sheets, the targets of a bake.

/// Sheets of one size with views side by side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Sheets {
    /// Columns and rows of pixels of every sheet.
    pub(super) size: [u32; 2],
    /// Where each view lies, sheets ascending.
    pub(super) places: Vec<Place>,
}

/// Where a view lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// On which sheet.
    pub(super) sheet: u32,
    /// Its first column.
    pub(super) x: u32,
    /// Its first row.
    pub(super) y: u32,
}

/// Wide enough for a few views, however small they are.
const LEAST_WIDTH: u32 = 2048;

impl Sheets {
    /// Places views in their order, in rows from the left, rows from the top, on sheets of at most so
    /// many pixels; a view that is larger has a sheet of its own.
    pub(super) fn of(sizes: &[[u32; 2]], pixels: u32) -> Self {
        let most = |axis: usize| {
            sizes
                .iter()
                .map(|size| size[axis])
                .max()
                .unwrap_or(1)
                .max(1)
        };
        let width = most(0).max(LEAST_WIDTH);
        let height = most(1).max(pixels / width);
        let mut next = Place {
            sheet: 0,
            x: 0,
            y: 0,
        };
        let (mut row_height, mut used) = (0, [1, 1]);
        let mut places = Vec::with_capacity(sizes.len());
        for &[wide, high] in sizes {
            if next.x + wide > width {
                (next.x, next.y, row_height) = (0, next.y + row_height, 0);
            }
            if next.y + high > height {
                next = Place {
                    sheet: next.sheet + 1,
                    x: 0,
                    y: 0,
                };
                row_height = 0;
            }
            places.push(next);
            next.x += wide;
            row_height = row_height.max(high);
            used = [used[0].max(next.x), used[1].max(next.y + high)];
        }
        Self { size: used, places }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_fill_rows_then_sheets() {
        let sheets = Sheets::of(&[[1024, 512]; 5], 1 << 21);
        let at = |sheet, x, y| Place { sheet, x, y };
        let wanted = [
            at(0, 0, 0),
            at(0, 1024, 0),
            at(0, 0, 512),
            at(0, 1024, 512),
            at(1, 0, 0),
        ];
        assert_eq!(sheets.places, wanted);
        assert_eq!(sheets.size, [2048, 1024]);
        assert_eq!(Sheets::of(&[[4096, 8]], 64).size, [4096, 8]);
        assert_eq!(Sheets::of(&[], 64).size, [1, 1]);
    }
}
