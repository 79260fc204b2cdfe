//! Card profiles: how long a named card would take for what was counted.
//!
//! A model. For every draw, the largest of five costs counts, since the units of a card work side
//! by side: vertices ÷ vertex rate, triangles ÷ set-up rate (of programs whose vertex stage pulls, whichever
//! is more of what they are given and what they emit), samples ÷ fill rate, texels ÷ texture
//! rate, bytes ÷ memory bandwidth. Bytes are 4 per index, the vertex bytes, 4 B of depth read a
//! covered sample, and 8 B of depth and colour written a visible one. Rates are published peak
//! figures and frozen; a triangle a clock is taken for set-up.
//!
//! For every dispatch of a compute pass, the larger of two costs counts: arithmetic operations ÷ the
//! rate of its cores (one operation a core and clock; a multiply-add is one), and bytes that groups
//! read and write ÷ memory bandwidth. Cards before Direct3D 11 have no compute passes. The GTX 770
//! has 1536 cores at 1046 MHz.

use super::Ticks;
use crate::gpu::TICKS_PER_NANOSECOND;

/// A graphics card by its peak rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Card {
    name: &'static str,
    /// Millions of vertices a second.
    vertices: u64,
    /// Millions of triangles set up a second.
    triangles: u64,
    /// Millions of samples tested a second.
    samples: u64,
    /// Millions of texels read a second.
    texels: u64,
    /// Megabytes a second to its memory.
    memory: u64,
    /// Millions of arithmetic operations a second in compute passes, of cards that run them.
    operations: Option<u64>,
}

/// What one dispatch did, as far as its time depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DispatchWork {
    /// Arithmetic operations.
    pub operations: u64,
    /// Bytes read and written.
    pub bytes: u64,
}

/// What one draw did, as far as its time depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DrawWork {
    /// Vertices submitted.
    pub vertices: u64,
    /// Triangles submitted.
    pub triangles: u64,
    /// Samples covered.
    pub covered: u64,
    /// Samples visible at the end.
    pub visible: u64,
    /// Texels read.
    pub texels: u64,
    /// Bytes of indices and vertices read.
    pub input_bytes: u64,
}

/// As its name.
impl serde::Serialize for Card {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name)
    }
}

impl<'de> serde::Deserialize<'de> for Card {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = std::borrow::Cow::<'de, str>::deserialize(from)?;
        let unknown = || serde::de::Error::custom(format!("no card is called {name:?}"));
        Self::named(&name).ok_or_else(unknown)
    }
}

impl Card {
    /// All cards by name.
    pub const ALL: [Self; 4] = [
        Self {
            name: "geforce6800",
            vertices: 406,
            triangles: 325,
            samples: 3900,
            texels: 3900,
            memory: 22_400,
            operations: None,
        },
        Self {
            name: "geforce6800gt",
            vertices: 525,
            triangles: 350,
            samples: 5600,
            texels: 5600,
            memory: 32_000,
            operations: None,
        },
        Self {
            name: "fx5200",
            vertices: 62,
            triangles: 62,
            samples: 1000,
            texels: 1000,
            memory: 6400,
            operations: None,
        },
        Self {
            name: "gtx770",
            vertices: 4184,
            triangles: 4184,
            samples: 33_500,
            texels: 133_900,
            memory: 224_300,
            operations: Some(1_606_656),
        },
    ];

    /// The card named `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|card| card.name == name)
    }

    /// Its name on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// How long one draw takes.
    #[must_use]
    pub fn ticks(&self, work: &DrawWork) -> Ticks {
        let bytes = work.input_bytes + 4 * work.covered + 8 * work.visible;
        [
            (work.vertices, self.vertices),
            (work.triangles, self.triangles),
            (work.covered, self.samples),
            (work.texels, self.texels),
            (bytes, self.memory),
        ]
        .into_iter()
        .map(|(count, rate)| ticks_at(count, rate))
        .max()
        .unwrap_or(0)
    }

    /// Whether it runs compute passes.
    #[must_use]
    pub fn computes(&self) -> bool {
        self.operations.is_some()
    }

    /// How long one dispatch takes; nothing on a card that runs none.
    #[must_use]
    pub fn dispatch_ticks(&self, work: &DispatchWork) -> Ticks {
        self.operations.map_or(0, |rate| {
            ticks_at(work.operations, rate).max(ticks_at(work.bytes, self.memory))
        })
    }
}

/// How long a count takes at a rate in millions a second: one in a thousand nanoseconds.
fn ticks_at(count: u64, rate: u64) -> Ticks {
    (count * 1000 * TICKS_PER_NANOSECOND).div_ceil(rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slowest_unit_decides() {
        let card = Card::named("geforce6800").expect("a named card");
        let vertices = DrawWork {
            vertices: 406_000,
            triangles: 203_000,
            ..DrawWork::default()
        };
        assert_eq!(card.ticks(&vertices), 1_000_000 * TICKS_PER_NANOSECOND);
        let fill = DrawWork {
            covered: 7_800_000,
            ..vertices
        };
        assert_eq!(card.ticks(&fill), 2_000_000 * TICKS_PER_NANOSECOND);
        assert_eq!(card.ticks(&DrawWork::default()), 0);
    }

    #[test]
    fn a_dispatch_takes_its_arithmetic_or_its_bytes() {
        let card = Card::named("gtx770").expect("a named card");
        let work = |operations, bytes| card.dispatch_ticks(&DispatchWork { operations, bytes });
        let millisecond = 1_000_000 * TICKS_PER_NANOSECOND;
        assert_eq!(work(1_606_656_000, 224_300_000), millisecond);
        assert_eq!(work(1_606_656_000, 448_600_000), 2 * millisecond);
        let old = Card::named("geforce6800").expect("a named card");
        assert!(card.computes() && !old.computes());
    }
}
