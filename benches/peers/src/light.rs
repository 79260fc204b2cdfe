//! The light that all peers have.

use spinney::math::Vec3;

/// Light from everywhere.
pub(crate) const AMBIENT: f32 = 0.35;

/// Light from one side, on what faces it.
pub(crate) const DIFFUSE: f32 = 0.65;

/// The unit vector towards the light.
pub(crate) fn towards_light() -> Vec3 {
    Vec3::new(0.4, 0.8, 0.45).normalize()
}
