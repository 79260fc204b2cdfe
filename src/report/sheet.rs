//! Pictures of one size in rows.

use crate::math::index_u32;
use crate::report::{Picture, ReportError};

/// White pixels between pictures.
const GAP: u32 = 4;

/// Rows of pictures, one below the other; `None` without any.
pub(super) fn of(rows: &[Vec<Picture>]) -> Result<Option<Picture>, ReportError> {
    let Some(cell) = rows.iter().flatten().next() else {
        return Ok(None);
    };
    let most = rows.iter().map(Vec::len).max().unwrap_or(0);
    let [across, down] = [cell.width() + GAP, cell.height() + GAP];
    let [width, height] = [
        across * index_u32(most) - GAP,
        down * index_u32(rows.len()) - GAP,
    ];
    let mut rgba = vec![u8::MAX; 4 * width as usize * height as usize];
    for (row, pictures) in rows.iter().enumerate() {
        for (column, picture) in pictures.iter().enumerate() {
            let left = index_u32(column) * across;
            let top = index_u32(row) * down;
            let lines = picture
                .rgba()
                .chunks_exact(4 * picture.width().max(1) as usize);
            for (y, line) in (top..height).zip(lines) {
                let first = 4 * (y as usize * width as usize + left as usize);
                rgba[first..first + line.len()].copy_from_slice(line);
            }
        }
    }
    Picture::new(width, height, rgba).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_may_be_short() {
        let plain = |grey: u8| Picture::new(2, 1, vec![grey; 8]).expect("small");
        let rows = [vec![plain(1), plain(2)], vec![plain(3)]];
        let sheet = of(&rows).expect("it fits").expect("three pictures");
        assert_eq!((sheet.width(), sheet.height()), (8, 6));
        let red = |x: usize, y: usize| sheet.rgba()[4 * (8 * y + x)];
        assert_eq!([red(0, 0), red(6, 0), red(1, 5), red(6, 5)], [1, 2, 3, 255]);
        assert_eq!(of(&[]).expect("nothing"), None);
    }
}
