//! Numbers with one answer on every machine, and the shapes that all stages share.
//!
//! **Spaces.** World space is right-handed with +Y up, in metres. View space looks along −Z. Clip
//! space has `0 ≤ z ≤ w`, as in Direct3D, Vulkan and WebGPU. Pixels count from the top-left corner,
//! x to the right, y downwards; the centre of pixel (0, 0) lies at (0.5, 0.5).
//!
//! **Rounding.** `+ − × ÷ √` and conversions are exact as IEEE 754 states them; every other function
//! of a float goes through [`det`]. glam is built with `scalar-math` and `libm`, so its results are
//! those of plain scalar code. Nothing here fuses a multiplication with an addition.

pub mod bounds;
pub mod det;
pub mod lanes;
pub mod rng;

pub use bounds::{Aabb, Frustum, NormalCone, Sphere};
pub use glam::{
    Affine3A, DMat3, DMat4, DVec2, DVec3, DVec4, Mat3, Mat4, Quat, UVec2, Vec2, Vec3, Vec4,
    Vec4Swizzles,
};
pub use rng::{Draws, Stream};

/// A BLAKE3 digest; what goes into it is documented where it is made.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digest(pub [u8; 32]);

impl std::fmt::Display for Digest {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(out, "{byte:02x}"))
    }
}

impl std::fmt::Debug for Digest {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "Digest({self})")
    }
}

/// As 64 hexadecimal digits.
impl serde::Serialize for Digest {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Digest {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let text = std::borrow::Cow::<'de, str>::deserialize(from)?;
        let wrong = || serde::de::Error::custom("wanted 64 hexadecimal digits");
        let digits: Option<Vec<u8>> = text
            .chars()
            .map(|digit| {
                digit
                    .to_digit(16)
                    .and_then(|value| u8::try_from(value).ok())
            })
            .collect();
        let digits = digits
            .filter(|digits| digits.len() == 64)
            .ok_or_else(wrong)?;
        let mut bytes = [0; 32];
        for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
            *byte = 16 * pair[0] + pair[1];
        }
        Ok(Self(bytes))
    }
}

/// Collects the bytes of a digest: integers and floats little-endian, strings and lists with a
/// `u64` length before them, so that no two different values share a byte string.
#[derive(Debug, Clone, Default)]
pub struct Digester(blake3::Hasher);

impl Digester {
    /// A digester that begins with `domain`, so that two kinds of value never collide.
    #[must_use]
    pub fn new(domain: &str) -> Self {
        let mut digester = Self(blake3::Hasher::new());
        digester.text(domain);
        digester
    }

    /// A digester that begins with nothing, for digests whose layout is a contract of its own.
    #[must_use]
    pub fn plain() -> Self {
        Self::default()
    }

    /// Adds bytes as they are, without their length.
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        // The same digest; below about this size, handing work to other threads costs more.
        if bytes.len() < 1 << 17 {
            self.0.update(bytes);
        } else {
            self.0.update_rayon(bytes);
        }
        self
    }

    /// Adds bytes with their length before them.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.u64(bytes.len() as u64);
        self.raw(bytes)
    }

    /// Adds a string as UTF-8 with its length before it.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }

    /// Adds four bytes.
    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Adds eight bytes.
    pub fn u64(&mut self, value: u64) -> &mut Self {
        self.raw(&value.to_le_bytes())
    }

    /// Adds the bits of a float; `-0` and `0` differ.
    pub fn f32(&mut self, value: f32) -> &mut Self {
        self.u32(value.to_bits())
    }

    /// Adds three floats.
    pub fn vec3(&mut self, value: Vec3) -> &mut Self {
        self.f32(value.x).f32(value.y).f32(value.z)
    }

    /// The digest of all that was added.
    #[must_use]
    pub fn finish(&self) -> Digest {
        Digest(*self.0.finalize().as_bytes())
    }
}

/// A length or index as `u32`.
///
/// # Panics
///
/// When `value` does not fit; sizes are checked against limits far below where data enters.
#[must_use]
#[inline]
pub fn index_u32(value: usize) -> u32 {
    u32::try_from(value).expect("sizes are limited at the border to far below 2^32")
}

/// A size in bytes as an index into memory.
///
/// # Panics
///
/// When `value` does not fit; what is asked about lies in memory already, so it does.
#[must_use]
#[inline]
pub fn index_usize(value: u64) -> usize {
    usize::try_from(value).expect("what lies in memory has an index")
}

/// A unit vector across a direction: by the axis that it leans towards least.
#[must_use]
pub fn perpendicular(direction: Vec3) -> Vec3 {
    let size = direction.abs();
    let axis = if size.x <= size.y && size.x <= size.z {
        Vec3::X
    } else if size.y <= size.z {
        Vec3::Y
    } else {
        Vec3::Z
    };
    direction.cross(axis).normalize_or(Vec3::X)
}

/// The whole part of a number, 0 for less or no number, `u32::MAX` for more.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates, as documented"
)]
pub fn whole_u32(value: f64) -> u32 {
    value as u32
}
