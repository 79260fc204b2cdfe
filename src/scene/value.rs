//! Values of a scene file: what each [`Kind`] of key takes.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeValue};

use crate::limits;
use crate::math::{Digest, Vec3};

use super::keys::Kind;
use super::{Area, ImageSize};

/// A parsed value with its place.
pub(super) type Found<'a> = Spanned<DeValue<'a>>;

/// A type that a value of some [`Kind`]s can be read as.
pub(super) trait Value: Sized {
    /// The value, or the place of what does not fit.
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>>;
}

impl Value for u64 {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let value = match *kind {
            Kind::Integer { min, max } => {
                integer(found).filter(|value| (min..=max).contains(value))
            }
            Kind::OneOf(values) => integer(found).filter(|value| values.contains(value)),
            Kind::Bytes { most } => text(found).and_then(bytes).filter(|bytes| *bytes <= most),
            _ => None,
        };
        value.ok_or(found.span())
    }
}

impl Value for Vec<u64> {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let (max, most) = match *kind {
            Kind::Ascending { max, most } | Kind::Descending { max, most } => (max, most),
            _ => return Err(found.span()),
        };
        let ascending = matches!(kind, Kind::Ascending { .. });
        let list = array(found)?;
        if list.is_empty() || list.len() > most {
            return Err(found.span());
        }
        let mut values = Self::with_capacity(list.len());
        for entry in list.iter() {
            let follows = |value: &u64| match values.last() {
                Some(last) if ascending => last < value,
                Some(last) => last > value,
                None => true,
            };
            let least = u64::from(!ascending);
            let value = integer(entry).filter(|value| (least..=max).contains(value));
            let value = value.filter(follows);
            values.push(value.ok_or(entry.span())?);
        }
        Ok(values)
    }
}

impl Value for ImageSize {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let list = array(found)?;
        let (Kind::Size { side }, [width, height]) = (*kind, &list[..]) else {
            return Err(found.span());
        };
        let mut sides = [0; 2];
        for (entry, value) in [width, height].into_iter().zip(&mut sides) {
            *value = integer(entry)
                .and_then(|value| u32::try_from(value).ok())
                .filter(|value| (1..=side).contains(value))
                .ok_or(entry.span())?;
        }
        Self::new(sides[0], sides[1]).ok_or(found.span())
    }
}

impl Value for f32 {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let Kind::Number { min, max } = *kind else {
            return Err(found.span());
        };
        number_within(found, min, max)
    }
}

impl Value for Vec3 {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let list = array(found)?;
        let (Kind::Triple { min, max }, [x, y, z]) = (*kind, &list[..]) else {
            return Err(found.span());
        };
        Ok(Self::new(
            number_within(x, min, max)?,
            number_within(y, min, max)?,
            number_within(z, min, max)?,
        ))
    }
}

impl Value for String {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let fits = |text: &&str| match kind {
            Kind::Text => is_text(text),
            Kind::Name => is_name(text),
            Kind::Path => is_path(text),
            Kind::Choice(names) => names.contains(text),
            _ => false,
        };
        match text(found).filter(fits) {
            Some(text) => Ok(text.to_owned()),
            None => Err(found.span()),
        }
    }
}

impl Value for Vec<String> {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let (counts, fits): (_, fn(&str) -> bool) = match *kind {
            Kind::Texts => (0..=limits::FOLIAGE_NAMES, is_text),
            Kind::Paths { most } => (1..=most, is_path),
            _ => return Err(found.span()),
        };
        let one = |found: &Found<'_>| match text(found).filter(|text| fits(text)) {
            Some(text) => Ok(text.to_owned()),
            None => Err(found.span()),
        };
        if matches!(kind, Kind::Paths { .. }) && text(found).is_some() {
            return Ok(vec![one(found)?]);
        }
        let list = array(found)?;
        if !counts.contains(&list.len()) {
            return Err(found.span());
        }
        list.iter().map(one).collect()
    }
}

impl Value for [f32; 2] {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let list = array(found)?;
        let (Kind::Range { min, max }, [least, greatest]) = (*kind, &list[..]) else {
            return Err(found.span());
        };
        let least = number_within(least, min, max)?;
        Ok([least, number_within(greatest, least, max)?])
    }
}

impl Value for Area {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let list = array(found)?;
        let (Kind::Area { max }, [x0, z0, x1, z1]) = (*kind, &list[..]) else {
            return Err(found.span());
        };
        let mut corners = [0.0; 4];
        for (entry, corner) in [x0, z0, x1, z1].into_iter().zip(&mut corners) {
            *corner = number_within(entry, -max, max)?;
        }
        Self::new(corners).ok_or(found.span())
    }
}

impl Value for Vec<Digest> {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let list = array(found)?;
        match *kind {
            Kind::Digests { most } if list.len() <= most => {}
            _ => return Err(found.span()),
        }
        let one = |entry: &Found<'_>| {
            let digits = text(entry).and_then(hexadecimal);
            digits.map(Digest).ok_or(entry.span())
        };
        list.iter().map(one).collect()
    }
}

impl Value for [u8; 3] {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let digits = match kind {
            Kind::Color => text(found).and_then(|text| text.strip_prefix('#')),
            _ => None,
        };
        digits.and_then(hexadecimal).ok_or(found.span())
    }
}

impl Value for Digest {
    fn read(kind: &Kind, found: &Found<'_>) -> Result<Self, Range<usize>> {
        let digits = match kind {
            Kind::Digest => text(found),
            _ => None,
        };
        digits.and_then(hexadecimal).map(Self).ok_or(found.span())
    }
}

/// Whether a text is a [`Kind::Name`].
pub(super) fn is_name(text: &str) -> bool {
    text.len() <= 64
        && text.starts_with(|c: char| c.is_ascii_alphanumeric())
        && text
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
}

fn is_text(text: &str) -> bool {
    (1..=limits::TEXT_CHARACTERS).contains(&text.chars().count())
        && !text.chars().any(char::is_control)
}

/// Refused are roots, drives and backslashes: a scene must mean the same on every machine.
fn is_path(text: &str) -> bool {
    is_text(text) && !text.starts_with('/') && !text.contains(['\\', ':'])
}

fn text<'a>(found: &'a Found<'_>) -> Option<&'a str> {
    found.get_ref().as_str()
}

fn array<'a, 'b>(found: &'a Found<'b>) -> Result<&'a DeArray<'b>, Range<usize>> {
    found.get_ref().as_array().ok_or(found.span())
}

fn integer(found: &Found<'_>) -> Option<u64> {
    let integer = found.get_ref().as_integer()?;
    u64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

/// A number from its digits, rounded once; −0 becomes 0.
fn number_within(found: &Found<'_>, min: f32, max: f32) -> Result<f32, Range<usize>> {
    let number: Option<f32> = match found.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(_) => integer(found).map(|integer| integer as f32),
        _ => None,
    };
    number
        .filter(|number| (min..=max).contains(number))
        .map(|number| number + 0.0)
        .ok_or(found.span())
}

/// The units of [`Kind::Bytes`], largest first.
pub(super) const BYTE_UNITS: [(&str, u64); 4] = [
    ("GiB", 1 << 30),
    ("MiB", 1 << 20),
    ("KiB", 1 << 10),
    ("B", 1),
];

fn bytes(text: &str) -> Option<u64> {
    let (digits, unit) = text.split_once(' ')?;
    let (_, factor) = BYTE_UNITS.into_iter().find(|(name, _)| *name == unit)?;
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
    let count: u64 = digits.parse().ok().filter(|_| plain)?;
    count.checked_mul(factor)
}

fn hexadecimal<const N: usize>(digits: &str) -> Option<[u8; N]> {
    let digits = digits.as_bytes();
    if digits.len() != 2 * N {
        return None;
    }
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        let [high, low] = [pair[0], pair[1]].map(|digit| char::from(digit).to_digit(16));
        *byte = u8::try_from(high? << 4 | low?).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::super::keys::{Absent, KEYS};
    use super::*;

    #[test]
    fn every_default_can_be_read() {
        for key in KEYS {
            let Absent::Value(text) = key.absent else {
                continue;
            };
            let value = DeValue::parse(text).unwrap();
            let fits = match key.kind {
                Kind::Table => value.get_ref().is_table(),
                Kind::OneOf(_) | Kind::Integer { .. } | Kind::Bytes { .. } => {
                    u64::read(&key.kind, &value).is_ok()
                }
                Kind::Ascending { .. } | Kind::Descending { .. } => {
                    Vec::<u64>::read(&key.kind, &value).is_ok()
                }
                Kind::Size { .. } => ImageSize::read(&key.kind, &value).is_ok(),
                Kind::Number { .. } => f32::read(&key.kind, &value).is_ok(),
                Kind::Triple { .. } => Vec3::read(&key.kind, &value).is_ok(),
                Kind::Color => <[u8; 3]>::read(&key.kind, &value).is_ok(),
                Kind::Range { .. } => <[f32; 2]>::read(&key.kind, &value).is_ok(),
                Kind::Area { .. } => Area::read(&key.kind, &value).is_ok(),
                Kind::Texts | Kind::Paths { .. } => Vec::<String>::read(&key.kind, &value).is_ok(),
                Kind::Text | Kind::Name | Kind::Path | Kind::Choice(_) => {
                    String::read(&key.kind, &value).is_ok()
                }
                Kind::Digest | Kind::Digests { .. } | Kind::Tables { .. } => false,
            };
            assert!(fits, "{}: {text}", key.path);
        }
    }

    #[test]
    fn sizes_in_bytes_have_a_unit() {
        assert_eq!(bytes("256 MiB"), Some(256 << 20));
        assert_eq!(bytes("0 B"), Some(0));
        assert_eq!(bytes("17179869183 GiB"), Some(17_179_869_183 << 30));
        for wrong in [
            "256MiB",
            "256",
            "-1 B",
            "+1 B",
            "1.5 GiB",
            "17179869184 GiB",
            "1 mb",
            " B",
        ] {
            assert_eq!(bytes(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn hexadecimal_wants_all_digits_and_no_more() {
        assert_eq!(hexadecimal("00fF10"), Some([0, 255, 16]));
        for wrong in ["00fF1", "00fF100", "00fF1g", "+0fF10", "äää"] {
            assert_eq!(hexadecimal::<3>(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn paths_mean_the_same_on_every_machine() {
        assert!(is_path("../species/taxus_baccata.toml"));
        for wrong in ["", "/tree.glb", "a\\b", "C:/tree.glb", "a\nb"] {
            assert!(!is_path(wrong), "{wrong:?}");
        }
    }
}
