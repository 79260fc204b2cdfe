//! Numbers of texts.

use std::ops::RangeInclusive;

/// Coordinates, lengths and radii beyond this are no measurements: the earth to the sun, in metres.
pub(super) const FARTHEST: f64 = 1.5e11;

/// The number that a text is, which has to lie in a range.
pub(super) fn bounded(text: &str, name: &str, range: &RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.parse().ok();
    number.filter(|number| range.contains(number)).ok_or_else(|| {
        format!(
            "{name} is {text:?}, wanted a number from {} to {}; set it right, or take the line out",
            range.start(),
            range.end()
        )
    })
}

/// The whole number that a text is in any form that numbers have, if 64 bits of a float hold it exactly.
#[expect(
    clippy::cast_possible_truncation,
    reason = "whole and within the range"
)]
pub(super) fn whole(text: &str) -> Option<i64> {
    let number: f64 = text.parse().ok()?;
    let is_exact = number.abs() <= 9_007_199_254_740_992.0 && number.trunc() == number;
    is_exact.then_some(number as i64)
}
