//! Axes of plots: which range they show, and where their ticks stand.

use crate::math::det;

use super::number::short;

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it measures, with the unit: `payload a frame, B`.
    pub label: String,
    /// How values become places.
    pub scale: Scale,
}

/// How values become places on an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences are equally far apart.
    Linear,
    /// Equal ratios are equally far apart; only values above 0 have a place.
    Log,
}

impl Scale {
    /// Whether a value has a place.
    pub(super) fn shows(self, value: f64) -> bool {
        // Far enough from the ends of what can be computed with.
        let size = value.abs();
        match self {
            Self::Linear => size <= 1e30,
            Self::Log => (1e-30..=1e30).contains(&value),
        }
    }

    /// The value on an axis of equal differences.
    fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => log10(value),
        }
    }
}

/// What an axis shows, from `low` to `high`, in places of its scale.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisRange {
    scale: Scale,
    low: f64,
    high: f64,
}

impl AxisRange {
    /// From the least to the greatest value.
    pub(super) fn tight(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let places = values.map(|value| scale.place(value));
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), place| {
            (low.min(place), high.max(place))
        });
        let (low, high) = match (low < high, low == high) {
            (true, _) => (low, high),
            // Room around a single value; nothing at all shows 0 to 1.
            (_, true) if scale == Scale::Log => (low - 0.45, low + 0.45),
            (_, true) if low == 0.0 => (0.0, 1.0),
            (_, true) => (low - 0.5 * low.abs(), low + 0.5 * low.abs()),
            _ => (0.0, 1.0),
        };
        Self { scale, low, high }
    }

    /// From tick to tick around all values, and from 0 where they are not far from it.
    pub(super) fn round(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let mut range = Self::tight(scale, values);
        if scale == Scale::Linear {
            if range.low > 0.0 && range.low < 0.7 * range.high {
                range.low = 0.0;
            }
            let step = step(range.low, range.high);
            range.low = (range.low / step).floor() * step;
            range.high = (range.high / step).ceil() * step;
        } else if range.high - range.low > 1.0 {
            range.low = range.low.floor();
            range.high = range.high.ceil();
        }
        range
    }

    /// Where a value stands, from 0 (low) to 1 (high).
    pub(super) fn share(&self, value: f64) -> Option<f64> {
        let place = |value| (self.scale.place(value) - self.low) / (self.high - self.low);
        self.scale.shows(value).then(|| place(value))
    }

    /// Where ticks stand, from 0 to 1, and what is written there.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        let mut ticks = match self.scale {
            Scale::Linear => self.within(linear_ticks(self.low, self.high)),
            Scale::Log => self.within(self.log_ticks()),
        };
        if ticks.len() < 2 && self.scale == Scale::Log {
            let [low, high] = [self.low, self.high].map(|place| det::pow_f64(10.0, place));
            ticks = self.within(linear_ticks(low, high));
        }
        // As few digits as tell all ticks apart.
        let labels = |digits| -> Vec<String> {
            ticks
                .iter()
                .map(|(_, value)| short(*value, digits))
                .collect()
        };
        let distinct = |labels: &Vec<String>| labels.windows(2).all(|pair| pair[0] != pair[1]);
        let labels = [3, 6, 9, 12]
            .into_iter()
            .map(labels)
            .find(distinct)
            .unwrap_or_else(|| labels(15));
        ticks.iter().map(|(share, _)| *share).zip(labels).collect()
    }

    /// Ticks on the axis, each with its place from 0 to 1.
    fn within(&self, values: Vec<f64>) -> Vec<(f64, f64)> {
        // A hair beyond the ends is rounding.
        let within = |(share, _): &(f64, f64)| (-1e-6..=1.0 + 1e-6).contains(share);
        let placed = values
            .into_iter()
            .filter_map(|value| Some((self.share(value)?, value)));
        placed.filter(within).collect()
    }

    /// 1-2-5 in each decade where there are few, else every so many decades.
    fn log_ticks(&self) -> Vec<f64> {
        let (first, last) = (self.low.floor(), self.high.ceil());
        let stride = ((last - first) / 8.0).ceil().max(1.0);
        let mantissas: &[f64] = if last - first <= 3.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        steps((last - first) / stride)
            .flat_map(|index| {
                let power = power_of_ten(first + index * stride);
                mantissas.iter().map(move |mantissa| mantissa * power)
            })
            .collect()
    }
}

fn linear_ticks(low: f64, high: f64) -> Vec<f64> {
    let step = step(low, high);
    let first = (low / step - 1e-6).ceil();
    let count = ((high - low) / step + 1e-6).floor();
    steps(count).map(|index| (first + index) * step).collect()
}

/// 1, 2 or 5 times a power of ten: at most eight ticks.
fn step(low: f64, high: f64) -> f64 {
    let rough = (high - low) / 7.0;
    let power = power_of_ten(log10(rough).floor());
    let fitting = [1.0, 2.0, 5.0].into_iter().find(|m| m * power >= rough);
    fitting.unwrap_or(10.0) * power
}

/// 0, 1, 2 … up to `count`, which is small by construction of steps.
fn steps(count: f64) -> impl Iterator<Item = f64> {
    (0..=64_u8)
        .map(f64::from)
        .take_while(move |index| *index <= count)
}

fn log10(value: f64) -> f64 {
    det::log_f64(value) / std::f64::consts::LN_10
}

/// By multiplication, so that it is exact where it can be.
fn power_of_ten(exponent: f64) -> f64 {
    let times = steps(exponent.abs())
        .skip(1)
        .fold(1.0, |power, _| power * 10.0);
    if exponent < 0.0 { 1.0 / times } else { times }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(range: &AxisRange) -> String {
        let labels: Vec<String> = range.ticks().into_iter().map(|(_, label)| label).collect();
        labels.join(" ")
    }

    fn round(scale: Scale, values: &[f64]) -> String {
        labels(&AxisRange::round(scale, values.iter().copied()))
    }

    #[test]
    fn linear_ticks_are_1_2_5() {
        for (values, wanted) in [
            (&[0.0, 1.0][..], "0 0.2 0.4 0.6 0.8 1"),
            (&[10.0, 90.0], "0 20 40 60 80 100"),
            (&[900.0, 1000.0], "900 920 940 960 980 1k"),
            (&[-3.0, 4.0], "-3 -2 -1 0 1 2 3 4"),
            (&[0.0, 3.3e6], "0 500k 1M 1.5M 2M 2.5M 3M 3.5M"),
            (&[5.0], "0 2 4 6 8"),
            (&[0.0], "0 0.2 0.4 0.6 0.8 1"),
            (&[], "0 0.2 0.4 0.6 0.8 1"),
        ] {
            assert_eq!(round(Scale::Linear, values), wanted, "{values:?}");
        }
    }

    #[test]
    fn log_ticks_are_decades() {
        for (values, wanted) in [
            (&[1.0, 1000.0][..], "1 2 5 10 20 50 100 200 500 1k"),
            (&[3.0, 2e5], "1 10 100 1k 10k 100k 1M"),
            (&[1.0, 1e16], "1 100 10k 1M 100M 10G 1T 100T 10P"),
            (&[40.0], "20 50 100"),
        ] {
            assert_eq!(round(Scale::Log, values), wanted, "{values:?}");
        }
    }

    #[test]
    fn tight_ranges_end_with_the_values() {
        let range = AxisRange::tight(Scale::Linear, [3.0, 17.0].into_iter());
        assert_eq!(labels(&range), "4 6 8 10 12 14 16");
        assert_eq!(range.share(3.0), Some(0.0));
        assert_eq!(range.share(17.0), Some(1.0));
        assert_eq!(range.share(f64::NAN), None);
        assert_eq!(
            AxisRange::tight(Scale::Log, [1.0, 9.0].into_iter()).share(0.0),
            None
        );
    }

    #[test]
    fn any_range_has_a_few_ticks() {
        for low in [-1e30, -7.3, -1e-30, 0.0, 1e-30, 0.1, 123_456.789, 1e30] {
            for high in [-1e29, 1e-29, 0.1 + 1e-12, 123_456.790, 1e30] {
                for scale in [Scale::Linear, Scale::Log] {
                    let values = [low, high].into_iter().filter(|value| scale.shows(*value));
                    let ticks = AxisRange::round(scale, values.clone()).ticks();
                    assert!((2..=12).contains(&ticks.len()), "{low} {high} {ticks:?}");
                    let tight = AxisRange::tight(scale, values).ticks();
                    assert!((2..=12).contains(&tight.len()), "{low} {high} {tight:?}");
                }
            }
        }
    }
}
