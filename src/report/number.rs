//! Numbers as people read them; the same text on every machine.

/// An integer with a separator between groups of three digits.
#[must_use]
pub fn grouped(value: u64, separator: &str) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text += separator;
        }
        text.push(digit);
    }
    text
}

/// A number with at most so many digits after the point, and no zeros at the end.
///
/// Rounds half to even on the exact value, as the standard library does; never `-0`.
#[must_use]
pub fn decimal(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" => "0".to_owned(),
        _ => text.to_owned(),
    }
}

/// A number with a decimal prefix: `1.5M`, `20k`, `0.25`, `3µ`, with at most so
/// many digits after the point.
#[must_use]
pub(super) fn short(value: f64, digits: usize) -> String {
    const PREFIXES: [(f64, &str); 8] = [
        (1e15, "P"),
        (1e12, "T"),
        (1e9, "G"),
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "µ"),
    ];
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    // From 0.001 on without a prefix: 0.25 is easier to read than 250m.
    let fits = |(factor, prefix): &(f64, &str)| match *prefix {
        "" => size >= 0.001,
        _ => size >= *factor,
    };
    match PREFIXES.iter().find(|prefix| fits(prefix)) {
        Some((factor, prefix)) if size < 1e18 => {
            format!("{}{prefix}", decimal(value / factor, digits))
        }
        _ => format!("{value:e}"),
    }
}

/// A number of hundredths with both digits, such as `0.07`.
#[must_use]
pub fn hundredths(value: u64) -> String {
    format!("{}.{:02}", value / 100, value % 100)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_stand_in_groups_of_three() {
        for (value, text) in [
            (0, "0"),
            (999, "999"),
            (1000, "1,000"),
            (1_234_567, "1,234,567"),
            (u64::MAX, "18,446,744,073,709,551,615"),
        ] {
            assert_eq!(grouped(value, ","), text);
        }
    }

    #[test]
    fn decimals_end_where_they_say_nothing() {
        for (value, digits, text) in [
            (1.5, 3, "1.5"),
            (100.0, 0, "100"),
            (100.0, 2, "100"),
            (-0.001, 2, "0"),
            (0.125, 2, "0.12"),
            (2.0 / 3.0, 3, "0.667"),
            (f64::NAN, 2, "NaN"),
        ] {
            assert_eq!(decimal(value, digits), text);
        }
    }

    #[test]
    fn prefixes_keep_numbers_short() {
        for (value, text) in [
            (0.0, "0"),
            (20.0, "20"),
            (-1500.0, "-1.5k"),
            (2.5e6, "2.5M"),
            (0.25, "0.25"),
            (0.0005, "500µ"),
            (3e-6, "3µ"),
            (1e-9, "1e-9"),
            (1e21, "1e21"),
        ] {
            assert_eq!(short(value, 3), text);
        }
    }
}
