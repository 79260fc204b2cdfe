//! Card profiles: how long a named card would take for what was counted.
//!
//! A model. For every draw, the largest of five costs counts, since the units of a card work side
//! by side: vertices ÷ vertex rate, triangles ÷ set-up rate, samples ÷ fill rate, texels ÷ texture
//! rate, bytes ÷ memory bandwidth. Bytes are 4 per index, the vertex bytes, 4 B of depth read a
//! covered sample, and 8 B of depth and colour written a visible one. Rates are published peak
//! figures and frozen; a triangle a clock is taken for set-up.

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
        },
        Self {
            name: "geforce6800gt",
            vertices: 525,
            triangles: 350,
            samples: 5600,
            texels: 5600,
            memory: 32_000,
        },
        Self {
            name: "fx5200",
            vertices: 62,
            triangles: 62,
            samples: 1000,
            texels: 1000,
            memory: 6400,
        },
        Self {
            name: "gtx770",
            vertices: 4184,
            triangles: 4184,
            samples: 33_500,
            texels: 133_900,
            memory: 224_300,
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
        // A million a second is one a thousand nanoseconds.
        .map(|(count, rate)| (count * 1000 * TICKS_PER_NANOSECOND).div_ceil(rate))
        .max()
        .unwrap_or(0)
    }
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
}
