//! Brush strokes: what a painter puts down for a leaf, or for a piece of a branch.

use crate::math::Vec3;

/// A stroke in the plant's space: a flat patch that a brush's texture is laid on.
///
/// | bytes | field    | type      | unit, space                                     |
/// |------:|----------|-----------|-------------------------------------------------|
/// |  0–11 | `center` | 3 × `f32` | metres, plant                                   |
/// | 12–23 | `along`  | 3 × `f32` | half the length, in the direction of the stroke |
/// | 24–35 | `across` | 3 × `f32` | half the width, at a right angle                |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Its middle.
    pub center: Vec3,
    /// From the middle to the end at which the brush is lifted.
    pub along: Vec3,
    /// From the middle to the side that is on the right seen from the front.
    pub across: Vec3,
}

impl Stroke {
    /// Bytes of a stroke.
    pub const STRIDE: u32 = 36;

    /// Where the front faces, of unit length; zero for a stroke without area.
    #[must_use]
    pub fn normal(&self) -> Vec3 {
        let normal = self.across.as_dvec3().cross(self.along.as_dvec3());
        normal.normalize_or_zero().as_vec3()
    }

    /// The area of the patch, in square metres.
    #[must_use]
    pub fn area(&self) -> f32 {
        4.0 * self.along.cross(self.across).length()
    }

    /// Its corners by role, as those of a quad leaf: left and right at the base, right and left at the
    /// tip.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 4] {
        let (base, tip) = (self.center - self.along, self.center + self.along);
        [
            base - self.across,
            base + self.across,
            tip + self.across,
            tip - self.across,
        ]
    }
}
