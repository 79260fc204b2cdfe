//! Differences as colours, and the colours' legend.

use crate::report::html::escape;
use crate::report::{Picture, ReportError};

/// The colours of differences, evenly spaced from 0 to 255: from the sea over the shore to what burns.
const STOPS: [[u8; 3]; 6] = [
    [0, 0, 64],
    [0, 64, 255],
    [0, 224, 208],
    [96, 224, 0],
    [255, 216, 0],
    [224, 0, 0],
];

/// Where a picture differs, as colours.
pub(super) fn picture(width: u32, differences: &[u8]) -> Result<Picture, ReportError> {
    let pixels = differences.iter().map(|&by| {
        let [r, g, b] = colour(by);
        [r, g, b, u8::MAX]
    });
    let pixels: Vec<[u8; 4]> = pixels.collect();
    let rows = differences.len() / width.max(1) as usize;
    let height = crate::math::index_u32(rows);
    Picture::new(width, height, pixels.into_flattened())
}

/// Between two stops as far as it goes. The root of a difference goes along the ramp: most are small.
fn colour(by: u8) -> [u8; 3] {
    let last = STOPS.len() - 1;
    let along = (f64::from(by) / 255.0).sqrt() * last as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 0 to the last stop"
    )]
    let stop = (along as usize).min(last - 1);
    let share = along - stop as f64;
    std::array::from_fn(|channel| {
        let [from, to] = [stop, stop + 1].map(|stop| f64::from(STOPS[stop][channel]));
        let value = from + share * (to - from);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two bytes"
        )]
        let byte = (value + 0.5) as u8;
        byte
    })
}

/// The colours and what they stand for.
pub(super) fn legend() -> String {
    const MARKS: [u8; 8] = [0, 1, 8, 32, 64, 128, 192, 255];
    let title = "Difference of intensity from the truth, of 255";
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 544 60\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"544\" height=\"60\" fill=\"white\"/>\n\
         <text x=\"16\" y=\"16\">{}</text>\n",
        escape(title)
    );
    // Twice as wide as there are places, each with the difference whose colour is there.
    for place in 0..=255_u8 {
        let share = f64::from(place) / 255.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of 255"
        )]
        let [r, g, b] = colour((share * share * 255.0 + 0.5) as u8);
        let x = 16 + 2 * u32::from(place);
        svg += &format!(
            "<rect x=\"{x}\" y=\"22\" width=\"2\" height=\"16\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>\n"
        );
    }
    for mark in MARKS {
        let x = 16.0 + 2.0 * 255.0 * (f64::from(mark) / 255.0).sqrt();
        svg += &format!("<text x=\"{x:.1}\" y=\"53\" text-anchor=\"middle\">{mark}</text>\n");
    }
    svg += "</svg>\n";
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_ramp_are_its_stops_and_no_two_small_differences_look_alike() {
        assert_eq!((colour(0), colour(255)), (STOPS[0], STOPS[5]));
        for by in 1..=64 {
            assert_ne!(colour(by), colour(by - 1), "{by}");
        }
        let shown = picture(2, &[0, 255]).expect("two pixels");
        assert_eq!((shown.width(), shown.height()), (2, 1));
        assert_eq!(shown.rgba(), [0, 0, 64, 255, 224, 0, 0, 255]);
    }
}
