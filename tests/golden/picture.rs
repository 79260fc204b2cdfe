//! Two pictures: how they differ, in words and side by side.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};
use spinney::raster::Image;

/// What a comparison found.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Difference {
    /// No channel of any pixel differs by more than the tolerance.
    Within,
    /// In words: how many pixels, by how much, where.
    Beyond(String),
}

/// Compares channel by channel.
pub(crate) fn compare(expected: &Image, actual: &Image, tolerance: u8) -> Difference {
    let sizes = [expected, actual].map(|image| (image.width, image.height));
    if sizes[0] != sizes[1] {
        let [(w0, h0), (w1, h1)] = sizes;
        return Difference::Beyond(format!("{w1} x {h1} pixels, expected {w0} x {h0}"));
    }
    let mut count = 0_u32;
    let mut largest = 0;
    let [mut left, mut top, mut right, mut bottom] = [u32::MAX, u32::MAX, 0, 0];
    for (index, (one, other)) in (0..).zip(pixels(expected).zip(pixels(actual))) {
        let difference = apart(*one, *other);
        if difference > tolerance {
            let (x, y) = (index % actual.width, index / actual.width);
            count += 1;
            largest = largest.max(difference);
            (left, right) = (left.min(x), right.max(x));
            (top, bottom) = (top.min(y), bottom.max(y));
        }
    }
    if count == 0 {
        return Difference::Within;
    }
    Difference::Beyond(format!(
        "{count} of {} pixels differ, by up to {largest} of 255, x {left}..={right}, y {top}..={bottom}",
        actual.width * actual.height
    ))
}

/// Expected, differing and actual side by side; the middle shows what agrees as pale grey, and what
/// differs the redder the more it does.
pub(crate) fn triptych(expected: &Image, actual: &Image, tolerance: u8) -> Image {
    const GAP: u32 = 2;
    let (width, height) = (
        expected.width.max(actual.width),
        expected.height.max(actual.height),
    );
    let none = [0; 4];
    let at = |image: &Image, x: u32, y: u32| {
        let inside = x < image.width && y < image.height;
        let index = y as usize * image.width as usize + x as usize;
        if inside {
            pixels(image).nth(index).copied().unwrap_or(none)
        } else {
            none
        }
    };
    let column = |x: u32, y: u32| {
        let (panel, x) = (x / (width + GAP), x % (width + GAP));
        let (one, other) = (at(expected, x, y), at(actual, x, y));
        match panel {
            _ if x >= width => [255; 4],
            0 => one,
            1 => match apart(one, other) {
                difference if difference > tolerance => [255, 160 - difference / 2, 0, 255],
                _ => {
                    let grey = 192 + one[1] / 8;
                    [grey, grey, grey, 255]
                }
            },
            _ => other,
        }
    };
    let whole = 3 * width + 2 * GAP;
    Image {
        width: whole,
        height,
        rgba: (0..height)
            .flat_map(|y| (0..whole).flat_map(move |x| column(x, y)))
            .collect(),
    }
}

/// A PNG file as small as it gets: without alpha where all of it is opaque.
pub(crate) fn encode(image: &Image) -> Vec<u8> {
    let mut png = Vec::new();
    let opaque = pixels(image).all(|pixel| pixel[3] == 255);
    let encoder =
        PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive);
    let (bytes, format) = if opaque {
        let rgb = pixels(image).flat_map(|&[r, g, b, _]| [r, g, b]).collect();
        (rgb, ExtendedColorType::Rgb8)
    } else {
        (image.rgba.clone(), ExtendedColorType::Rgba8)
    };
    encoder
        .write_image(&bytes, image.width, image.height, format)
        .expect("a picture fills its size");
    png
}

fn pixels(image: &Image) -> impl Iterator<Item = &[u8; 4]> + '_ {
    image.rgba.as_chunks::<4>().0.iter()
}

/// The largest difference of a channel.
fn apart(one: [u8; 4], other: [u8; 4]) -> u8 {
    let channels = one.into_iter().zip(other).map(|(a, b)| a.abs_diff(b));
    channels.max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3 × 2 grey pixels, one of them another grey.
    fn grey(odd: usize, value: u8) -> Image {
        let mut rgba = [100, 100, 100, 255].repeat(6);
        rgba[4 * odd + 1] = value;
        Image {
            width: 3,
            height: 2,
            rgba,
        }
    }

    #[test]
    fn differences_are_told_with_number_size_and_place() {
        let (one, other) = (grey(0, 100), grey(5, 130));
        assert_eq!(compare(&one, &one, 0), Difference::Within);
        assert_eq!(compare(&one, &other, 30), Difference::Within);
        let words = "1 of 6 pixels differ, by up to 30 of 255, x 2..=2, y 1..=1";
        assert_eq!(
            compare(&one, &other, 29),
            Difference::Beyond(words.to_owned())
        );
        let wide = Image {
            width: 6,
            height: 1,
            ..one.clone()
        };
        let words = "6 x 1 pixels, expected 3 x 2";
        assert_eq!(
            compare(&one, &wide, 255),
            Difference::Beyond(words.to_owned())
        );
    }

    #[test]
    fn the_middle_of_three_shows_what_differs() {
        let image = triptych(&grey(0, 100), &grey(5, 130), 0);
        assert_eq!((image.width, image.height), (13, 2));
        let reds: Vec<usize> = pixels(&image)
            .enumerate()
            .filter(|(_, pixel)| pixel[0] == 255 && pixel[2] == 0)
            .map(|(index, _)| index)
            .collect();
        assert_eq!(reds, [13 + 5 + 2]);
    }

    #[test]
    fn files_read_back() {
        let image = grey(3, 7);
        let png = encode(&image);
        let read = image::load_from_memory(&png).unwrap().into_rgba8();
        assert_eq!(read.into_raw(), image.rgba);
        let mut clear = image;
        clear.rgba[3] = 9;
        let read = image::load_from_memory(&encode(&clear))
            .unwrap()
            .into_rgba8();
        assert_eq!(read.into_raw(), clear.rgba);
    }
}
