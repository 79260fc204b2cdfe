//! Boxes, spheres, cones of normals and the view frustum.

use super::{Mat4, Vec3, Vec4, Vec4Swizzles};

/// An axis-aligned box; [`Aabb::EMPTY`] holds no point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// The least coordinates.
    pub min: Vec3,
    /// The greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of no point.
    pub const EMPTY: Self = Self {
        min: Vec3::splat(f32::INFINITY),
        max: Vec3::splat(f32::NEG_INFINITY),
    };

    /// The least box that holds all of `points`.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::with)
    }

    /// This box, grown to hold `point`.
    #[must_use]
    pub fn with(self, point: Vec3) -> Self {
        Self {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// The least box that holds both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Whether no point lies in the box.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// The middle; the origin for an empty box.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        if self.is_empty() {
            Vec3::ZERO
        } else {
            0.5 * self.min + 0.5 * self.max
        }
    }

    /// The edge lengths; zero for an empty box.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        if self.is_empty() {
            Vec3::ZERO
        } else {
            self.max - self.min
        }
    }

    /// The distance from `point` to the nearest point of the box; 0 inside.
    #[must_use]
    pub fn distance(&self, point: Vec3) -> f32 {
        (point.clamp(self.min, self.max) - point).length()
    }
}

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// The middle.
    pub center: Vec3,
    /// The radius, at least 0.
    pub radius: f32,
}

impl Sphere {
    /// A ball around the middle of the points' box that holds them all: not the least one, at most
    /// √3 times its radius.
    #[must_use]
    pub fn of(points: &[Vec3]) -> Self {
        let center = Aabb::of(points.iter().copied()).center();
        let squared = points.iter().fold(0.0, |most: f32, point| {
            most.max(point.distance_squared(center))
        });
        Self {
            center,
            radius: squared.sqrt(),
        }
    }
}

/// All directions within an angle of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalCone {
    /// The axis, of length 1.
    pub axis: Vec3,
    /// The cosine of the half angle; −1 holds every direction.
    pub cosine: f32,
}

impl NormalCone {
    /// A cone around the mean direction that holds all `normals` (each of length 1).
    #[must_use]
    pub fn of(normals: &[Vec3]) -> Self {
        let axis = normals
            .iter()
            .copied()
            .fold(Vec3::ZERO, |sum, n| sum + n)
            .normalize_or_zero();
        if axis == Vec3::ZERO {
            return Self {
                axis: Vec3::Y,
                cosine: -1.0,
            };
        }
        let cosine = normals
            .iter()
            .fold(1.0, |least: f32, n| least.min(n.dot(axis)));
        Self { axis, cosine }
    }
}

/// The six planes that bound what a camera sees; a point is inside where `n · x + d ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    planes: [Vec4; 6],
}

impl Frustum {
    /// The planes of clip space `−w ≤ x, y ≤ w`, `0 ≤ z ≤ w`, seen from world space.
    #[must_use]
    pub fn of(clip_from_world: &Mat4) -> Self {
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_world.row(row));
        Self {
            planes: [w + x, w - x, w + y, w - y, z, w - z],
        }
    }

    /// Whether the box may be seen; `false` only if it lies wholly behind one plane.
    #[must_use]
    pub fn may_see(&self, bounds: &Aabb) -> bool {
        self.planes.iter().all(|plane| {
            let normal = plane.xyz();
            let farthest = Vec3::select(normal.cmpge(Vec3::ZERO), bounds.max, bounds.min);
            normal.dot(farthest) + plane.w >= 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_and_spheres_hold_their_points() {
        let points = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 0.0, 5.0)];
        let bounds = Aabb::of(points);
        assert_eq!(bounds.size(), Vec3::splat(2.0));
        assert!((bounds.distance(Vec3::new(3.0, 1.0, 4.0)) - 2.0).abs() < 1e-6);
        let ball = Sphere::of(&points);
        assert!(
            points
                .iter()
                .all(|p| p.distance(ball.center) <= ball.radius * 1.000_001)
        );
        assert!(Aabb::EMPTY.is_empty() && Aabb::EMPTY.size() == Vec3::ZERO);
    }

    #[test]
    fn frustum_sees_what_lies_ahead_only() {
        let ahead = Frustum::of(&glam::camera::rh::proj::directx::perspective(
            1.0, 1.0, 0.1, 100.0,
        ));
        let cube = |z: f32| Aabb {
            min: Vec3::new(-1.0, -1.0, z),
            max: Vec3::new(1.0, 1.0, z + 1.0),
        };
        assert!(ahead.may_see(&cube(-10.0)));
        assert!(!ahead.may_see(&cube(10.0)));
    }
}
