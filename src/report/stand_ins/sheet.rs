//! Pictures of a stand-in at all scales, side by side.

use crate::math::index_u32;
use crate::report::thumbnail::{enlarged, shrink};
use crate::report::{Picture, ReportError};
use crate::run::StandIn;

/// Pixels of a cell's side.
const CELL: u32 = 256;

/// White pixels between cells.
const GAP: u32 = 4;

/// A row of the sheet.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strip {
    pub(super) stand_in: StandIn,
    cells: Vec<Picture>,
}

impl Strip {
    pub(super) fn of(stand_in: StandIn) -> Self {
        Self {
            stand_in,
            cells: Vec::new(),
        }
    }

    /// Adds a square picture: one that is too large made smaller, one that is much too small enlarged, both by
    /// a whole factor.
    pub(super) fn add(&mut self, picture: &Picture) -> Result<(), ReportError> {
        let side = picture.width().max(1);
        let cell = if side > CELL {
            shrink(picture, side.div_ceil(CELL))?
        } else {
            enlarged(picture, CELL / side)?
        };
        self.cells.push(cell);
        Ok(())
    }

    /// All cells in a row.
    pub(super) fn picture(&self) -> Result<Picture, ReportError> {
        beside(&self.cells)
    }
}

/// All strips, one below the other; `None` without any.
pub(super) fn stacked(strips: &[Strip]) -> Result<Option<Picture>, ReportError> {
    let rows: Vec<Picture> = strips
        .iter()
        .map(Strip::picture)
        .collect::<Result<_, _>>()?;
    let Some(width) = rows.iter().map(Picture::width).max() else {
        return Ok(None);
    };
    let mut rgba = Vec::new();
    for row in &rows {
        let bytes = row.rgba().chunks_exact(4 * row.width().max(1) as usize);
        let missing = 4 * (width - row.width()) as usize;
        for line in bytes {
            rgba.extend_from_slice(line);
            rgba.resize(rgba.len() + missing, u8::MAX);
        }
    }
    let height = rows.iter().map(Picture::height).sum();
    Picture::new(width, height, rgba).map(Some)
}

/// Pictures in cells of a row, each in the middle of its own.
fn beside(cells: &[Picture]) -> Result<Picture, ReportError> {
    let pitch = CELL + GAP;
    let width = pitch * index_u32(cells.len());
    let mut rgba = vec![u8::MAX; 4 * width as usize * pitch as usize];
    for (number, cell) in cells.iter().enumerate() {
        let (left, top) = (
            index_u32(number) * pitch + (pitch - cell.width()) / 2,
            (pitch - cell.height()) / 2,
        );
        let lines = cell.rgba().chunks_exact(4 * cell.width() as usize);
        for (y, line) in (top..).zip(lines) {
            let first = 4 * (y as usize * width as usize + left as usize);
            rgba[first..first + line.len()].copy_from_slice(line);
        }
    }
    Picture::new(width, pitch, rgba)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(side: u32, grey: u8) -> Picture {
        let pixel = [grey, grey, grey, 255];
        Picture::new(side, side, pixel.repeat((side * side) as usize)).expect("small")
    }

    #[test]
    fn cells_are_of_a_size_whatever_the_pictures_are() {
        let mut strip = Strip::of(StandIn::LEAVES);
        for (side, grey) in [(768, 10), (300, 20), (30, 30)] {
            strip.add(&plain(side, grey)).expect("it fits");
        }
        let sides: Vec<u32> = strip.cells.iter().map(Picture::width).collect();
        assert_eq!(sides, [256, 150, 240]);
        let row = strip.picture().expect("it fits");
        assert_eq!((row.width(), row.height()), (780, 260));
        for (number, grey) in [(0_usize, 10), (1, 20), (2, 30)] {
            let middle = 4 * (130 * 780 + number * 260 + 130);
            assert_eq!(row.rgba()[middle], grey);
        }
        let both = stacked(&[strip.clone(), strip])
            .expect("it fits")
            .expect("two strips");
        assert_eq!((both.width(), both.height()), (780, 520));
        assert_eq!(stacked(&[]).expect("nothing"), None);
    }
}
