//! A share of the work, for several processes or machines.

/// Every `count`-th frame or step from the `index`-th on. All are selected and committed in every
/// shard, and those of the shard are drawn, so that what is drawn never depends on the sharding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Shard {
    /// Which, from 0.
    pub index: u32,
    /// Of how many, above `index`.
    pub count: u32,
}

impl Shard {
    /// The one shard that is everything.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Whether a frame or step belongs to this shard.
    #[must_use]
    pub fn draws(self, number: u32) -> bool {
        number % self.count.max(1) == self.index
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}/{}", self.index, self.count)
    }
}

/// Measures as their bits, for `#[serde(with = "exact")]`: JSON's readers may miss the last one.
pub(super) mod exact {
    use serde::{Deserialize as _, Deserializer, Serializer};

    #[expect(
        clippy::trivially_copy_pass_by_ref,
        reason = "serde hands fields over by reference"
    )]
    pub(in super::super) fn serialize<S: Serializer>(
        value: &f64,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        to.serialize_u64(value.to_bits())
    }

    pub(in super::super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<f64, D::Error> {
        u64::deserialize(from).map(f64::from_bits)
    }
}

/// Points likewise.
pub(super) mod exact_place {
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    use crate::math::Vec3;

    #[expect(
        clippy::trivially_copy_pass_by_ref,
        reason = "serde hands fields over by reference"
    )]
    pub(in super::super) fn serialize<S: Serializer>(
        place: &Vec3,
        to: S,
    ) -> Result<S::Ok, S::Error> {
        place.to_array().map(f32::to_bits).serialize(to)
    }

    pub(in super::super) fn deserialize<'de, D: Deserializer<'de>>(
        from: D,
    ) -> Result<Vec3, D::Error> {
        let bits = <[u32; 3]>::deserialize(from)?;
        Ok(Vec3::from_array(bits.map(f32::from_bits)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_belongs_to_one_shard() {
        for count in 1..6 {
            let shards = || (0..count).map(|index| Shard { index, count });
            for number in 0..20 {
                assert_eq!(shards().filter(|shard| shard.draws(number)).count(), 1);
            }
        }
        assert!((0..9).all(|number| Shard::WHOLE.draws(number)));
    }
}
