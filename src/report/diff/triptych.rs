//! Three pictures in one: what was expected, what differs, what there is.

use super::difference::{apart, rows, size};
use crate::math::index_u32;
use crate::report::{Picture, ReportError};

/// Columns between the pictures.
const GAP: usize = 2;

/// Their colour.
const PAPER: [u8; 4] = [255; 4];

/// Where a picture has no pixel.
const NOTHING: [u8; 4] = [0; 4];

/// Expected, differing and actual side by side.
///
/// The middle shows what agrees up to the tolerance as pale grey, and what differs the redder the
/// more it does; where only one of two pictures of unequal size has a pixel, it differs.
///
/// # Errors
///
/// When it would be larger than a picture can be.
pub fn triptych(
    expected: &Picture,
    actual: &Picture,
    tolerance: u8,
) -> Result<Picture, ReportError> {
    let [[w0, h0], [w1, h1]] = [expected, actual].map(size);
    let (panel, height) = (w0.max(w1) as usize, h0.max(h1));
    let whole = 3 * panel + 2 * GAP;
    let pixels = whole as u64 * u64::from(height);
    let width = u32::try_from(whole).unwrap_or(u32::MAX);
    if width > Picture::MAX_SIDE || pixels > u64::from(Picture::MAX_PIXELS) {
        return Err(ReportError::Samples {
            what: "triptych".to_owned(),
            found: usize::try_from(pixels).unwrap_or(usize::MAX),
            width,
            height,
            wanted: format!(
                "at most {} a side, {} in all",
                Picture::MAX_SIDE,
                Picture::MAX_PIXELS
            ),
        });
    }
    let mut triptych: Vec<[u8; 4]> = Vec::with_capacity(whole * height as usize);
    let (mut one_rows, mut other_rows) = (rows(expected), rows(actual));
    for _ in 0..height {
        let one = one_rows.next().unwrap_or(&[]);
        let other = other_rows.next().unwrap_or(&[]);
        let at = |row: &[[u8; 4]], x: usize| row.get(x).copied();
        triptych.extend((0..panel).map(|x| at(one, x).unwrap_or(NOTHING)));
        triptych.extend([PAPER; GAP]);
        triptych.extend((0..panel).map(|x| between(at(one, x), at(other, x), tolerance)));
        triptych.extend([PAPER; GAP]);
        triptych.extend((0..panel).map(|x| at(other, x).unwrap_or(NOTHING)));
    }
    Picture::new(width, height, triptych.into_flattened())
}

/// The middle of a triptych alone, with both sides divided by `factor`, rounded up: a pixel that
/// stands for several shows the largest difference of them, so that none is lost.
///
/// # Errors
///
/// None for two pictures.
pub(super) fn differing(
    expected: &Picture,
    actual: &Picture,
    tolerance: u8,
    factor: u32,
) -> Result<Picture, ReportError> {
    let [[w0, h0], [w1, h1]] = [expected, actual].map(size);
    let step = factor.max(1) as usize;
    let (width, height) = (w0.max(w1) as usize, h0.max(h1) as usize);
    let [one, other]: [Vec<&[[u8; 4]]>; 2] =
        [expected, actual].map(|picture| rows(picture).collect());
    let at =
        |rows: &[&[[u8; 4]]], x: usize, y: usize| rows.get(y).and_then(|row| row.get(x)).copied();
    let mut pixels = Vec::new();
    for top in (0..height).step_by(step) {
        for left in (0..width).step_by(step) {
            let rows = top..height.min(top + step);
            let places = rows.flat_map(|y| (left..width.min(left + step)).map(move |x| (x, y)));
            let shown = places.map(|(x, y)| between(at(&one, x, y), at(&other, x, y), tolerance));
            // Of reds the one with least green; only without any the first of the others.
            let key = |pixel: &[u8; 4]| match is_red(*pixel) {
                true => pixel[1],
                false => u8::MAX,
            };
            pixels.push(shown.min_by_key(key).unwrap_or(NOTHING));
        }
    }
    let [columns, lines] = [width, height].map(|side| index_u32(side.div_ceil(step)));
    Picture::new(columns, lines, pixels.into_flattened())
}

/// The colour of a difference.
fn between(one: Option<[u8; 4]>, other: Option<[u8; 4]>, tolerance: u8) -> [u8; 4] {
    let red = |difference: u8| [255, 160 - difference / 2, 0, 255];
    match (one, other) {
        (None, None) => NOTHING,
        (Some(one), Some(other)) => match apart(one, other).into_iter().max().unwrap_or(0) {
            difference if difference > tolerance => red(difference),
            _ => {
                let grey = 192 + one[1] / 8;
                [grey, grey, grey, 255]
            }
        },
        _ => red(u8::MAX),
    }
}

/// Whether a colour is that of a difference.
fn is_red([red, _, blue, alpha]: [u8; 4]) -> bool {
    (red, blue, alpha) == (255, 0, 255)
}

#[cfg(test)]
mod tests {
    use super::super::tests::grey;
    use super::*;

    /// Which pixels are red, as places in a row.
    fn reds(picture: &Picture) -> Vec<(usize, usize)> {
        let row = |(y, row): (usize, &[[u8; 4]])| {
            let red = row.iter().enumerate().filter(|(_, pixel)| is_red(**pixel));
            red.map(|(x, _)| (x, y)).collect::<Vec<_>>()
        };
        rows(picture).enumerate().flat_map(row).collect()
    }

    #[test]
    fn the_middle_of_three_shows_what_differs() {
        let (one, other) = (grey(0, 100), grey(5, 130));
        let found = triptych(&one, &other, 29).unwrap();
        assert_eq!(size(&found), [13, 2]);
        assert_eq!(reds(&found), [(5 + 2, 1)]);
        for (row, (one, other)) in rows(&found).zip(rows(&one).zip(rows(&other))) {
            assert_eq!((&row[..3], &row[10..]), (one, other));
            assert_eq!(
                (&row[3..5], &row[8..10]),
                (&[PAPER; 2][..], &[PAPER; 2][..])
            );
        }
        assert_eq!(reds(&triptych(&one, &other, 30).unwrap()), []);
    }

    #[test]
    fn no_difference_is_lost_where_the_middle_is_made_smaller() {
        let (one, other) = (grey(0, 100), grey(4, 130));
        let found = differing(&one, &other, 0, 2).unwrap();
        assert_eq!(size(&found), [2, 1]);
        assert_eq!(reds(&found), [(0, 0)]);
        let whole = differing(&one, &other, 0, 1).unwrap();
        let middle: Vec<_> = rows(&triptych(&one, &other, 0).unwrap())
            .flat_map(|row| row[5..8].to_vec())
            .collect();
        assert_eq!(whole.rgba(), middle.as_flattened());
    }

    #[test]
    fn what_only_one_has_differs_whatever_the_tolerance() {
        let white = |width, height| {
            let rgba = vec![255; 4 * (width * height) as usize];
            Picture::new(width, height, rgba).unwrap()
        };
        //  expected 3 × 1, actual 1 × 2: both have the corner, none the bottom right
        let found = triptych(&white(3, 1), &white(1, 2), 255).unwrap();
        assert_eq!(reds(&found), [(6, 0), (7, 0), (5, 1)]);
        let bottom = rows(&found).nth(1).unwrap();
        assert_eq!(bottom[6..8], [NOTHING; 2]);
        assert_eq!(bottom[10], [255; 4]);
    }

    #[test]
    fn what_would_be_too_large_is_refused_before_it_is_made() {
        let line = |width, height| {
            let rgba = vec![0; 4 * 60_000];
            Picture::new(width, height, rgba).unwrap()
        };
        let error = triptych(&line(60_000, 1), &line(1, 60_000), 0).unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("triptych: 10800240000 samples")
        );
    }
}
