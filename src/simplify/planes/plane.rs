//! A plane by its normal and its distance.

use crate::math::{DVec3, Vec3};

/// The points `p` with `p · normal + distance = 0` ([GSS05](crate::references), § 2.1), in the plant's
/// space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Of unit length.
    pub normal: Vec3,
    /// In metres: how far the origin lies on the side to which the normal points. Not below 0 as
    /// [`cluster_planes`](super::cluster_planes) gives it.
    pub distance: f32,
}

impl Plane {
    /// How far a point lies on the side to which the normal points, in metres; below 0 on the other.
    #[must_use]
    pub fn signed_distance(&self, point: Vec3) -> f64 {
        FinePlane::of(*self).signed_distance(point.as_dvec3())
    }

    /// The point of the plane that is nearest to `point`; `point` itself where that has no finite
    /// coordinates, at the end of what `f32` holds.
    #[must_use]
    pub fn project(&self, point: Vec3) -> Vec3 {
        let plane = FinePlane::of(*self);
        let at = point.as_dvec3();
        let foot = (at - plane.signed_distance(at) * plane.normal).as_vec3();
        if foot.is_finite() { foot } else { point }
    }

    /// The same points with the normal on the other side.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self {
            normal: -self.normal,
            distance: -self.distance,
        }
    }

    /// The plane at `t` of the way from this one to `to`: this one at 0 and below, `to` at 1 and above.
    ///
    /// ```text
    ///         ╲ t = 1                [n, d] = ((1 − t) [n₀, d₀] + t [n₁, d₁]) / |(1 − t) n₀ + t n₁|
    ///          ╲   ╱ t = ½
    ///  ─────────╳─────── t = 0       the pencil of planes through the line that both share
    ///         ╱  ╲
    /// ```
    ///
    /// `to` counts as it lies, whichever way its normal points: before all else it is
    /// [reversed](Self::reversed) if that is nearer to `self`'s, so the result's front is always
    /// `self`'s and nothing turns over on the way; at 1 it is `to` or the reverse of it.
    ///
    /// The signed distance of any point from the result is what lies at `t` between those from the two
    /// planes, times a factor from 1 to √2 that depends on `t` alone. So points of both planes stay on
    /// all planes between, and a leaf that lies on one of them is never further away than √2 times from
    /// where it ends. Interpolating angle and centroid instead would part the planes from points that
    /// they share.
    #[must_use]
    pub fn between(&self, to: &Self, t: f32) -> Self {
        let from = FinePlane::of(*self);
        let reversed = from.normal.dot(FinePlane::of(*to).normal) < 0.0;
        let to = if reversed { to.reversed() } else { *to };
        if t <= 0.0 {
            return *self;
        }
        if t >= 1.0 {
            return to;
        }
        let (t, to) = (f64::from(t), FinePlane::of(to));
        // Never shorter than 1 / √2, as the two are no further apart than a right angle.
        let normal = (1.0 - t) * from.normal + t * to.normal;
        let length = normal.length();
        let distance = (1.0 - t) * from.distance + t * to.distance;
        FinePlane {
            normal: normal / length,
            distance: distance / length,
        }
        .rounded()
    }
}

/// A plane as it is computed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FinePlane {
    pub(super) normal: DVec3,
    pub(super) distance: f64,
}

impl FinePlane {
    /// The plane through a point.
    pub(super) fn through(point: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            distance: -point.dot(normal),
        }
    }

    fn of(plane: Plane) -> Self {
        // A unit vector of `f32` is of unit length only to 1e-7.
        let normal = plane.normal.as_dvec3();
        let length = normal.length();
        let length = if length > 0.0 { length } else { 1.0 };
        Self {
            normal: normal / length,
            distance: f64::from(plane.distance),
        }
    }

    pub(super) fn signed_distance(&self, point: DVec3) -> f64 {
        point.dot(self.normal) + self.distance
    }

    /// The same plane for points that are counted from `−origin`, where they were counted from 0.
    pub(super) fn moved(&self, origin: DVec3) -> Self {
        Self {
            normal: self.normal,
            distance: self.distance - origin.dot(self.normal),
        }
    }

    /// With a distance that is not below 0; where it is 0, with the first coordinate of the normal that is
    /// not 0 above it.
    pub(super) fn oriented(self) -> Plane {
        let plane = self.rounded();
        let mut signs = [
            plane.distance,
            plane.normal.x,
            plane.normal.y,
            plane.normal.z,
        ]
        .into_iter();
        let is_reversed = signs
            .find(|&sign| sign != 0.0)
            .is_some_and(|sign| sign < 0.0);
        let plane = if is_reversed { plane.reversed() } else { plane };
        // Adding 0 takes the sign from a zero, so that equal planes have equal bits.
        Plane {
            normal: plane.normal + Vec3::ZERO,
            distance: plane.distance + 0.0,
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    fn rounded(self) -> Plane {
        Plane {
            normal: self.normal.as_vec3(),
            distance: self.distance as f32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Draws, Stream};

    fn plane(normal: [f32; 3], distance: f32) -> Plane {
        Plane {
            normal: Vec3::from_array(normal).normalize(),
            distance,
        }
    }

    fn vector(draws: &mut Draws) -> Vec3 {
        Vec3::new(draws.signed(), draws.signed(), draws.signed())
    }

    #[test]
    fn distances_are_oriented_and_zero_has_a_rule() {
        let oriented = |normal: [f64; 3], distance: f64| {
            FinePlane {
                normal: DVec3::from_array(normal),
                distance,
            }
            .oriented()
        };
        let front = oriented([0.0, 1.0, 0.0], 2.0);
        assert_eq!(front, plane([0.0, 1.0, 0.0], 2.0));
        assert_eq!(oriented([0.0, -1.0, 0.0], -2.0), front);
        let through = oriented([0.0, -1.0, 0.0], 0.0);
        assert_eq!(through, plane([0.0, 1.0, 0.0], 0.0));
        assert_eq!(through.distance.to_bits(), 0);
        assert_eq!(through.normal.x.to_bits(), 0);
        assert_eq!(oriented([0.0, -0.6, 0.8], 0.0).normal.y, 0.6);
    }

    #[test]
    fn both_ends_are_exact_whichever_way_they_point() {
        let from = plane([0.3, -0.5, 0.7], 1.25);
        let to = plane([0.2, -0.6, 0.5], 0.75);
        for to in [to, to.reversed()] {
            assert_eq!(from.between(&to, 0.0), from);
            assert_eq!(from.between(&to, -3.0), from);
            let end = from.between(&to, 1.0);
            assert!(end == to || end == to.reversed());
            assert!(end.normal.dot(from.normal) > 0.0);
        }
        assert_eq!(from.between(&to, 0.4), from.between(&to.reversed(), 0.4));
        // The same plane seen from behind is no way to go.
        let still = from.between(&from.reversed(), 0.5);
        assert!((still.normal - from.normal).length() < 1e-6, "{still:?}");
        assert!((still.distance - from.distance).abs() < 1e-6, "{still:?}");
    }

    #[test]
    fn shared_points_stay_and_others_move_evenly() {
        let mut draws = Stream::new(5, 0).draws();
        for _ in 0..500 {
            let [point, other] = [0, 1].map(|_| 10.0 * vector(&mut draws));
            let [from, to] = [0, 1].map(|_| {
                let normal = vector(&mut draws).normalize_or(Vec3::X);
                FinePlane::through(point.as_dvec3(), normal.as_dvec3()).rounded()
            });
            let facing = if from.normal.dot(to.normal) < 0.0 {
                to.reversed()
            } else {
                to
            };
            let ends = [from, facing].map(|plane| plane.signed_distance(other));
            for step in 0..=8_u8 {
                let t = f32::from(step) / 8.0;
                let between = from.between(&to, t);
                assert!((between.normal.length() - 1.0).abs() < 1e-6);
                assert!(
                    between.signed_distance(point).abs() < 1e-5,
                    "{from:?} {to:?} {t}"
                );
                let even = f64::from(1.0 - t) * ends[0] + f64::from(t) * ends[1];
                let found = between.signed_distance(other);
                let (least, most) = (
                    even.abs() - 1e-4,
                    std::f64::consts::SQRT_2 * even.abs() + 1e-4,
                );
                assert!((least..=most).contains(&found.abs()), "{found} for {even}");
                assert!(found * even >= -1e-8, "{found} for {even}");
            }
        }
    }

    #[test]
    fn projections_lie_on_the_plane_below_the_point() {
        let mut draws = Stream::new(6, 0).draws();
        for _ in 0..200 {
            let plane = plane(vector(&mut draws).to_array(), 3.0 * draws.unit());
            let point = 10.0 * vector(&mut draws);
            let foot = plane.project(point);
            assert!(
                plane.signed_distance(foot).abs() < 2e-6,
                "{plane:?} {point}"
            );
            let way = point - foot;
            let across = way - way.dot(plane.normal) * plane.normal;
            assert!(across.length() < 1e-5, "{plane:?} {point}");
        }
    }
}
