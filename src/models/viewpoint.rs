//! From where a plant is seen.

use crate::math::{Mat4, Vec3};

/// From where a plant is seen: what models that turn towards the viewer look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewpoint {
    /// Where the viewer stands, in the plant's space.
    pub eye: Vec3,
    /// From the plant's space to clip space.
    pub clip_from_plant: Mat4,
}
