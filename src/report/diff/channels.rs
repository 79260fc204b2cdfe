//! Channels of data: samples that differ in value or only in bits.

use std::collections::BTreeSet;

use crate::math::index_u32;
use crate::report::{Channel, LayerSamples, SampleKind, decimal, grouped};

/// How one channel of two files differs.
///
/// Two samples have one value if they compare equal or are both no number; so 0 and −0, or two kinds
/// of "no number", differ in their bits alone.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelDifference {
    /// The name of the channel.
    pub name: String,
    /// What the samples are: expected, actual. Where these are not of one kind, values are
    /// compared, and the channel differs.
    pub kinds: [SampleKind; 2],
    /// The windows: x, y, width, height; expected, actual. Where these differ nothing else is
    /// compared.
    pub windows: [[i64; 4]; 2],
    /// Samples compared.
    pub samples: u64,
    /// The largest difference that counts as none.
    pub tolerance: f64,
    /// Samples that differ by more than the tolerance, or of which one alone is no finite number.
    pub differing: u64,
    /// Samples that have one value, and not the same bits; 0 where kinds differ.
    pub bits_only: u64,
    /// Samples of unequal value of which one, or both, are no finite number.
    pub not_finite: u64,
    /// The largest difference of two finite samples.
    pub largest: f64,
    /// The first pixel that has it, row by row; or else, where `differing` is not 0, the first
    /// that differs.
    pub largest_at: Option<[u32; 2]>,
}

/// The channels of two files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChannelDifferences {
    /// The channels that both have, by name.
    pub both: Vec<ChannelDifference>,
    /// The channels that only the first has.
    pub only_expected: Vec<String>,
    /// The channels that only the second has.
    pub only_actual: Vec<String>,
}

impl ChannelDifferences {
    /// Compares channels by name; the tolerance is in units of the samples.
    #[must_use]
    pub fn between(expected: &[Channel], actual: &[Channel], tolerance: f64) -> Self {
        let names = |channels: &[Channel]| -> BTreeSet<String> {
            let names = channels.iter().map(|channel| channel.name.clone());
            names.collect()
        };
        let (one, other) = (names(expected), names(actual));
        let pair = |channel: &Channel| {
            let other = actual.iter().find(|other| other.name == channel.name)?;
            Some(ChannelDifference::between(channel, other, tolerance))
        };
        Self {
            both: expected.iter().filter_map(pair).collect(),
            only_expected: one.difference(&other).cloned().collect(),
            only_actual: other.difference(&one).cloned().collect(),
        }
    }

    /// Whether both have the same channels, with the same values up to the tolerance, and without
    /// one the same bits.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.only_expected.is_empty()
            && self.only_actual.is_empty()
            && self.both.iter().all(ChannelDifference::is_within)
    }
}

impl ChannelDifference {
    fn between(expected: &Channel, actual: &Channel, tolerance: f64) -> Self {
        let window = |channel: &Channel| {
            let ([x, y], [width, height]) = (channel.origin, channel.size);
            [
                i64::from(x),
                i64::from(y),
                i64::from(width),
                i64::from(height),
            ]
        };
        let mut found = Self {
            name: expected.name.clone(),
            kinds: [expected.kind, actual.kind],
            windows: [window(expected), window(actual)],
            samples: 0,
            tolerance,
            differing: 0,
            bits_only: 0,
            not_finite: 0,
            largest: 0.0,
            largest_at: None,
        };
        if found.windows[0] != found.windows[1] {
            return found;
        }
        let width = expected.size[0] as usize;
        let mut first = None;
        let mut add = |index: usize, one: f64, other: f64, same_bits: bool| {
            if one == other || (one.is_nan() && other.is_nan()) {
                found.bits_only += u64::from(!same_bits);
                return;
            }
            let at = || Some([index % width, index / width].map(index_u32));
            let apart = (one - other).abs();
            if !apart.is_finite() {
                found.not_finite += 1;
            } else if apart > found.largest {
                (found.largest, found.largest_at) = (apart, at());
            }
            if !apart.is_finite() || apart > tolerance {
                found.differing += 1;
                first = first.or_else(at);
            }
        };
        // Float samples are finite in `f64` if they are in `f32`, and so are their differences.
        match (&expected.samples, &actual.samples) {
            (LayerSamples::F32(one), LayerSamples::F32(other)) => {
                for (index, (one, other)) in one.iter().zip(other).enumerate() {
                    let same = one.to_bits() == other.to_bits();
                    add(index, f64::from(*one), f64::from(*other), same);
                }
            }
            (LayerSamples::U32(one), LayerSamples::U32(other)) => {
                for (index, (one, other)) in one.iter().zip(other).enumerate() {
                    add(index, f64::from(*one), f64::from(*other), true);
                }
            }
            (LayerSamples::F32(one), LayerSamples::U32(other)) => {
                for (index, (one, other)) in one.iter().zip(other).enumerate() {
                    add(index, f64::from(*one), f64::from(*other), true);
                }
            }
            (LayerSamples::U32(one), LayerSamples::F32(other)) => {
                for (index, (one, other)) in one.iter().zip(other).enumerate() {
                    add(index, f64::from(*one), f64::from(*other), true);
                }
            }
        }
        found.largest_at = found.largest_at.or(first);
        found.samples = u64::from(expected.size[0]) * u64::from(expected.size[1]);
        if expected.kind != actual.kind {
            found.bits_only = 0;
        }
        found
    }

    /// Whether kinds, windows and values are the same up to the tolerance, and without one the bits.
    #[must_use]
    pub fn is_within(&self) -> bool {
        self.kinds[0] == self.kinds[1]
            && self.windows[0] == self.windows[1]
            && self.differing == 0
            && (self.bits_only == 0 || self.tolerance > 0.0)
    }
}

/// What differs, without the name: `12 of 3,072 samples differ, by up to 0.25 at (3, 4)`.
impl std::fmt::Display for ChannelDifference {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.windows[0] != self.windows[1] {
            let [one, other] = self
                .windows
                .map(|[x, y, width, height]| format!("{width} × {height} samples from ({x}, {y})"));
            return write!(out, "{other}, expected {one}");
        }
        let mut parts = Vec::new();
        if self.kinds[0] != self.kinds[1] {
            let [one, other] = self.kinds.map(SampleKind::name);
            parts.push(format!("{other}, expected {one}"));
        }
        let samples = grouped(self.samples, ",");
        if self.differing > 0 {
            let place = match self.largest_at {
                Some([x, y]) => format!(" at ({x}, {y})"),
                None => String::new(),
            };
            let by = match self.largest > 0.0 {
                true => format!(", by up to {}", short(self.largest)),
                false => String::new(),
            };
            let count = grouped(self.differing, ",");
            parts.push(format!("{count} of {samples} samples differ{by}{place}"));
        } else if self.largest > 0.0 {
            let largest = short(self.largest);
            parts.push(format!("no sample differs by more than {largest}"));
        }
        if self.not_finite > 0 {
            let count = grouped(self.not_finite, ",");
            parts.push(format!("{count} of them are no finite numbers"));
        }
        if self.bits_only > 0 {
            let count = grouped(self.bits_only, ",");
            parts.push(format!("{count} of {samples} samples differ in bits alone"));
        }
        if parts.is_empty() {
            parts.push(format!("all {samples} samples are equal"));
        }
        out.write_str(&parts.join("; "))
    }
}

/// A difference in few digits: whole ones and those from 0.001 on as decimals.
pub(super) fn short(value: f64) -> String {
    match value {
        _ if value.fract() == 0.0 && value < 1e15 => decimal(value, 0),
        _ if (0.001..1e6).contains(&value) => decimal(value, 6),
        _ => format!("{value:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str, samples: LayerSamples) -> Channel {
        let kind = match samples {
            LayerSamples::F32(_) => SampleKind::F32,
            LayerSamples::U32(_) => SampleKind::U32,
        };
        Channel {
            name: name.to_owned(),
            kind,
            origin: [0; 2],
            size: [2, 2],
            samples,
        }
    }

    fn floats(samples: [f32; 4]) -> Channel {
        channel("Z", LayerSamples::F32(samples.to_vec()))
    }

    fn words(one: &Channel, other: &Channel) -> (bool, String) {
        let found = ChannelDifference::between(one, other, 0.0);
        (found.is_within(), found.to_string())
    }

    #[test]
    fn values_are_compared_and_bits_told_apart() {
        let (nan, odd) = (f32::NAN, f32::from_bits(0x7fc0_0001));
        let one = floats([0.0, 1.0, nan, 4.0]);
        let same = (true, "all 4 samples are equal".to_owned());
        assert_eq!(words(&one, &one), same);
        for (other, said) in [
            ([-0.0, 1.0, odd, 4.0], "2 of 4 samples differ in bits alone"),
            (
                [0.0, 1.5, nan, 4.25],
                "2 of 4 samples differ, by up to 0.5 at (1, 0)",
            ),
            (
                [0.0, 1.0, 7.0, 4.0],
                "1 of 4 samples differ at (0, 1); 1 of them are no finite numbers",
            ),
            (
                [0.0, f32::INFINITY, nan, 3.0],
                "2 of 4 samples differ, by up to 1 at (1, 1); 1 of them are no finite numbers",
            ),
        ] {
            assert_eq!(words(&one, &floats(other)), (false, said.to_owned()));
        }
    }

    #[test]
    fn tolerated_differences_are_told() {
        let (one, other) = (floats([0.0; 4]), floats([0.0, -0.0, 0.25, 0.0]));
        let found = ChannelDifference::between(&one, &other, 0.25);
        assert!(found.is_within());
        assert_eq!(
            found.to_string(),
            "no sample differs by more than 0.25; 1 of 4 samples differ in bits alone"
        );
        assert!(!ChannelDifference::between(&one, &other, 0.2).is_within());
    }

    #[test]
    fn kinds_and_windows_are_part_of_a_channel() {
        let numbers = channel("Z", LayerSamples::U32(vec![0, 1, 2, 65_535]));
        let one = floats([0.0, 1.0, 2.0, 65_536.0]);
        let said = "u32, expected f32; 1 of 4 samples differ, by up to 1 at (1, 1)";
        assert_eq!(words(&one, &numbers), (false, said.to_owned()));
        let mut moved = one.clone();
        moved.origin = [-1, 3];
        let said = "2 × 2 samples from (-1, 3), expected 2 × 2 samples from (0, 0)";
        assert_eq!(words(&one, &moved), (false, said.to_owned()));
    }

    #[test]
    fn channels_of_one_file_alone_are_named() {
        let of = |names: [&str; 2]| names.map(|name| channel(name, LayerSamples::U32(vec![1; 4])));
        let found = ChannelDifferences::between(&of(["A", "B"]), &of(["B", "C"]), 0.0);
        assert_eq!(found.both.len(), 1);
        assert_eq!(
            (found.only_expected, found.only_actual),
            (vec!["A".to_owned()], vec!["C".to_owned()])
        );
    }
}
