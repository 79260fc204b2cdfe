//! From where a plant is seen, and how large things look.

use super::super::Placement;
use crate::math::{Aabb, Frustum, Mat4, Vec3};
use crate::scene::View;

/// A view of one tree, in the plant's own space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    eye: Vec3,
    scale: f32,
    view: View,
    frustum: Frustum,
}

impl Sight {
    /// The view of a tree that stands somewhere.
    #[must_use]
    pub fn of(view: &View, placement: &Placement) -> Self {
        let world_from_plant = Mat4::from_scale_rotation_translation(
            Vec3::splat(placement.scale),
            placement.rotation,
            placement.position,
        );
        Self {
            eye: placement.to_plant(view.eye),
            scale: placement.scale,
            view: *view,
            frustum: Frustum::of(&(view.clip_from_world * world_from_plant)),
        }
    }

    /// Where the viewer stands, in the plant's space.
    #[must_use]
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// How many pixels a metre of the plant spans at a distance from the eye, both in the plant's
    /// metres; what is nearer than the near plane counts as there.
    ///
    /// As in the middle of the image. Towards its edges what lies as far away stands nearer to the
    /// image's plane, and looks larger by up to the square of one over the cosine of the angle.
    #[must_use]
    pub fn pixels_per_metre(&self, distance: f32) -> f64 {
        f64::from(self.view.pixels_per_metre(distance * self.scale)) * f64::from(self.scale)
    }

    /// The same at the nearest point of a box.
    #[must_use]
    pub fn pixels_per_metre_at(&self, bounds: &Aabb) -> f64 {
        self.pixels_per_metre(bounds.distance(self.eye))
    }

    /// Whether a box of the plant's space may be seen.
    #[must_use]
    pub fn may_see(&self, bounds: &Aabb) -> bool {
        self.frustum.may_see(bounds)
    }
}
