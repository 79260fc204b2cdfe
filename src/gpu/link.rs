//! Links between host and device: what a transfer occupies on the wire, and how long.
//!
//! A model, in integers. Time is counted in [`Ticks`] of 1/4096 ns, in which one byte on any of
//! these links takes a whole number.
//!
//! - **PCI Express**, 16 lanes: payload is padded to 4 bytes and cut into packets of at most 256
//!   bytes, each with 24 bytes of framing, sequence number, header and checksum; the line code
//!   (8b/10b up to 2.0, 128b/130b from 3.0) is in the time of a byte. Acknowledgements and flow
//!   control travel the other way and are left out.
//! - **AGP**, 32 bits at 66⅔ MHz times its multiplier: payload is padded to 8 bytes; requests go
//!   over the side band. Reading back runs at the PCI rate of 133⅓ MB/s.
//! - Every transfer has a latency of 1 µs. What the driver spends on a call (about 10 µs in 2005)
//!   is processor time, not the link's, and left out.

/// Time in units of 1/4096 ns.
pub type Ticks = u64;

/// Ticks in a nanosecond.
pub const TICKS_PER_NANOSECOND: Ticks = 4096;

/// A link between host memory and the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Link {
    name: &'static str,
    packets: Packets,
    down: Ticks,
    up: Ticks,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Packets {
    /// Payload is padded to a multiple of this.
    granule: u64,
    /// The most payload of one packet.
    most: u64,
    /// Bytes that go with each packet.
    overhead: u64,
}

const AGP: Packets = Packets {
    granule: 8,
    most: u64::MAX,
    overhead: 0,
};
const PCIE: Packets = Packets {
    granule: 4,
    most: 256,
    overhead: 24,
};
const AGP_READBACK: Ticks = 30_720;
const LATENCY: Ticks = 1000 * TICKS_PER_NANOSECOND;

/// As its name.
impl serde::Serialize for Link {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name)
    }
}

impl<'de> serde::Deserialize<'de> for Link {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let name = std::borrow::Cow::<'de, str>::deserialize(from)?;
        let unknown = || serde::de::Error::custom(format!("no link is called {name:?}"));
        Self::named(&name).ok_or_else(unknown)
    }
}

impl Link {
    /// All links by name, slowest first; a byte takes `down` ticks to the device, `up` from it.
    pub const ALL: [Self; 9] = [
        Self {
            name: "agp1x",
            packets: AGP,
            down: 15_360,
            up: AGP_READBACK,
        },
        Self {
            name: "agp2x",
            packets: AGP,
            down: 7680,
            up: AGP_READBACK,
        },
        Self {
            name: "agp4x",
            packets: AGP,
            down: 3840,
            up: AGP_READBACK,
        },
        Self {
            name: "agp8x",
            packets: AGP,
            down: 1920,
            up: AGP_READBACK,
        },
        Self {
            name: "pcie1x16",
            packets: PCIE,
            down: 1024,
            up: 1024,
        },
        Self {
            name: "pcie2x16",
            packets: PCIE,
            down: 512,
            up: 512,
        },
        Self {
            name: "pcie3x16",
            packets: PCIE,
            down: 260,
            up: 260,
        },
        Self {
            name: "pcie4x16",
            packets: PCIE,
            down: 130,
            up: 130,
        },
        Self {
            name: "pcie5x16",
            packets: PCIE,
            down: 65,
            up: 65,
        },
    ];

    /// The link named `name`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|link| link.name == name)
    }

    /// Its name on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Bytes on the wire for one transfer of `payload` bytes.
    #[must_use]
    pub fn wire_bytes(&self, payload: u64) -> u64 {
        let padded = payload.next_multiple_of(self.packets.granule);
        padded + self.packets.overhead * payload.div_ceil(self.packets.most)
    }

    /// How long one transfer of `payload` bytes to the device takes.
    #[must_use]
    pub fn ticks_down(&self, payload: u64) -> Ticks {
        LATENCY + self.down * self.wire_bytes(payload)
    }

    /// How long one transfer of `payload` bytes from the device takes.
    #[must_use]
    pub fn ticks_up(&self, payload: u64) -> Ticks {
        LATENCY + self.up * self.wire_bytes(payload)
    }
}

/// Ticks as nanoseconds, rounded up.
#[must_use]
pub fn nanoseconds(ticks: Ticks) -> u64 {
    ticks.div_ceil(TICKS_PER_NANOSECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link(name: &str) -> Link {
        Link::named(name).expect("a named link")
    }

    #[test]
    fn a_cluster_update_on_pcie_1_is_five_packets() {
        let pcie = link("pcie1x16");
        assert_eq!(pcie.wire_bytes(1200), 1320);
        assert_eq!(nanoseconds(pcie.ticks_down(1200)), 1330);
        assert_eq!(pcie.wire_bytes(4), 28);
    }

    #[test]
    fn rates_are_those_of_the_standards() {
        // Gigabytes a second of payload with 256-byte packets, to the printed digit.
        for (name, rate) in [("pcie1x16", 3657), ("pcie2x16", 7314), ("pcie3x16", 14_404)] {
            let payload = 256_u64 << 20;
            let ticks = link(name).ticks_down(payload) - LATENCY;
            let megabytes_per_second =
                u128::from(payload) * u128::from(TICKS_PER_NANOSECOND) * 1000 / u128::from(ticks);
            assert!(
                megabytes_per_second.abs_diff(rate) <= 1,
                "{name}: {megabytes_per_second}"
            );
        }
        let agp = link("agp8x");
        assert_eq!(agp.wire_bytes(4), 8);
        assert_eq!(nanoseconds(agp.ticks_down(3200) - LATENCY), 1500);
    }
}
