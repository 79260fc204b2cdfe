//! The lines of a trace as types, and reading them within limits.

use std::fmt;
use std::io::{BufRead, Read as _};
use std::marker::PhantomData;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::document::DocumentError;
use crate::limits;

/// The schema of this version.
pub(super) const SCHEMA: &str = "spinney.trace/1";

/// A part that every step of a trace tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TracePart {
    /// The leaves that show.
    Visible,
    /// What was sent.
    Writes,
    /// What was counted.
    Counted,
    /// What is held.
    Resident,
    /// What a draw may read.
    Reads,
    /// What a fresh upload would hold.
    Fresh,
    /// A digest of the picture.
    Image,
}

impl TracePart {
    /// Its key in a step.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Writes => "writes",
            Self::Counted => "counted",
            Self::Resident => "resident",
            Self::Reads => "reads",
            Self::Fresh => "fresh",
            Self::Image => "image",
        }
    }

    /// Whether it speaks of resources.
    pub(super) fn needs_resources(self) -> bool {
        matches!(
            self,
            Self::Writes | Self::Resident | Self::Reads | Self::Fresh
        )
    }
}

/// The first line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    pub(super) schema: String,
    pub(super) leaves: u32,
    #[serde(deserialize_with = "few::<_, _, { limits::TRACE_LEAVES as usize }>")]
    pub(super) collapses: Vec<[u32; 2]>,
    #[serde(deserialize_with = "few::<_, _, 7>")]
    pub(super) parts: Vec<TracePart>,
    #[serde(
        default,
        deserialize_with = "few::<_, _, { limits::TRACE_RESOURCES }>",
        skip_serializing_if = "Vec::is_empty"
    )]
    pub(super) resources: Vec<NamedSize>,
}

/// A resource of the header.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NamedSize {
    pub(super) name: String,
    pub(super) bytes: u64,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) host: bool,
}

/// Every further line.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Step {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) level: Option<u32>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_LEAVES as usize }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) clusters: Option<Vec<u32>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) collapse: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) split: Option<u32>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_ENTRIES }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) visible: Option<Vec<u32>>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_ENTRIES }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) writes: Option<Vec<Transfer>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) computed: Option<Transfer>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) counted: Option<StepCounts>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_RESOURCES }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) resident: Option<Vec<Hex>>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_ENTRIES }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) reads: Option<Vec<(usize, u64, u64)>>,
    #[serde(
        default,
        deserialize_with = "some_few::<_, _, { limits::TRACE_RESOURCES }>",
        skip_serializing_if = "Option::is_none"
    )]
    pub(super) fresh: Option<Vec<Hex>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) image: Option<String>,
}

impl Step {
    /// Whether it tells a part.
    pub(super) fn tells(&self, part: TracePart) -> bool {
        match part {
            TracePart::Visible => self.visible.is_some(),
            TracePart::Writes => self.writes.is_some(),
            TracePart::Counted => self.counted.is_some(),
            TracePart::Resident => self.resident.is_some(),
            TracePart::Reads => self.reads.is_some(),
            TracePart::Fresh => self.fresh.is_some(),
            TracePart::Image => self.image.is_some(),
        }
    }
}

pub(super) const PARTS: [TracePart; 7] = [
    TracePart::Visible,
    TracePart::Writes,
    TracePart::Counted,
    TracePart::Resident,
    TracePart::Reads,
    TracePart::Fresh,
    TracePart::Image,
];

/// The ranges of one transfer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Transfer(
    #[serde(deserialize_with = "few::<_, _, { limits::TRACE_ENTRIES }>")] pub(super) Vec<Range>,
);

/// One range of a transfer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Range {
    pub(super) to: usize,
    pub(super) at: u64,
    pub(super) hex: Hex,
}

/// What the program counted in one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepCounts {
    pub(super) transfers: u64,
    pub(super) bytes: u64,
}

/// Bytes, in a file as hexadecimal text.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Hex(pub(super) Vec<u8>);

impl Serialize for Hex {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let digits = self.0.iter().map(|byte| format!("{byte:02x}"));
        serializer.serialize_str(&digits.collect::<String>())
    }
}

impl<'de> Deserialize<'de> for Hex {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = std::borrow::Cow::<str>::deserialize(deserializer)?;
        let digit = |digit: u8| char::from(digit).to_digit(16);
        let pairs = text.as_bytes().chunks(2).map(|pair| match *pair {
            [high, low] => digit(high)
                .zip(digit(low))
                .and_then(|(high, low)| u8::try_from(16 * high + low).ok()),
            _ => None,
        });
        let bytes: Option<Vec<u8>> = pairs.collect();
        let wrong = || D::Error::custom("wanted bytes as pairs of hexadecimal digits");
        bytes.map(Self).ok_or_else(wrong)
    }
}

fn few<'de, D: Deserializer<'de>, T: Deserialize<'de>, const MOST: usize>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    deserializer.deserialize_seq(Few::<T, MOST>(PhantomData))
}

fn some_few<'de, D: Deserializer<'de>, T: Deserialize<'de>, const MOST: usize>(
    deserializer: D,
) -> Result<Option<Vec<T>>, D::Error> {
    few::<D, T, MOST>(deserializer).map(Some)
}

/// Reads a list of at most so many entries.
struct Few<T, const MOST: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de>, const MOST: usize> Visitor<'de> for Few<T, MOST> {
    type Value = Vec<T>;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "a list of at most {MOST} entries")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = list.next_element()? {
            if entries.len() == MOST {
                return Err(A::Error::custom(format!("more than {MOST} entries")));
            }
            entries.push(entry);
        }
        Ok(entries)
    }
}

/// The lines of a trace, one in memory at a time.
pub(super) struct Lines<'f, R> {
    file: &'f str,
    input: R,
    line: Vec<u8>,
    pub(super) number: usize,
}

impl<'f, R: BufRead> Lines<'f, R> {
    pub(super) fn new(file: &'f str, input: R) -> Self {
        Self {
            file,
            input,
            line: Vec::new(),
            number: 0,
        }
    }

    /// The next line that is not blank, as a value; `None` at the end.
    pub(super) fn next<T: for<'de> Deserialize<'de>>(
        &mut self,
    ) -> Result<Option<T>, DocumentError> {
        loop {
            self.line.clear();
            let most = limits::TRACE_LINE_BYTES as u64 + 1;
            let mut limited = self.input.by_ref().take(most);
            let read = limited.read_until(b'\n', &mut self.line);
            self.number += 1;
            let read = read.map_err(|error| self.error(1, format!("cannot read: {error}")))?;
            if read == 0 {
                return Ok(None);
            }
            if self.line.len() > limits::TRACE_LINE_BYTES {
                let message = format!("a line of more than {} bytes", limits::TRACE_LINE_BYTES);
                return Err(self.error(1, message));
            }
            if !self.line.trim_ascii().is_empty() {
                let value = serde_json::from_slice(&self.line);
                return value.map(Some).map_err(|error| {
                    let text = error.to_string();
                    let place = format!(" at line {} column {}", error.line(), error.column());
                    let message = text.strip_suffix(&place).unwrap_or(&text);
                    self.error(error.column().max(1), message)
                });
            }
        }
    }

    /// An error in the present line.
    pub(super) fn error(&self, column: usize, message: impl Into<String>) -> DocumentError {
        DocumentError {
            file: self.file.to_owned(),
            line: self.number,
            column,
            message: message.into(),
        }
    }
}
