//! Directions on an octahedron, and the fragment stage that blends the three nearest views.
//!
//! ```text
//!   hemisphere           sphere                   a direction lies in a triangle of three views,
//!  −X ────── +Z      −Y ──── −Z ──── −Y           whose barycentric weights blend them:
//!   │   +Y    │      −X      +Y      +X            a ── b
//!  −Z ────── +X      −Y ──── +Z ──── −Y            │ ╲ •│     • of a, b and c
//!                                                  d ── c
//! ```
//!
//! The mapping is the octahedral one ([CDEGLMM14](crate::references), § 3.1); views on it, blended by
//! threes, are what engines have used since [B18](crate::references). They blend without depth here, as
//! there where parallax is switched off.

use super::bake::ViewFrame;
use super::rival_card::RivalCard;
use crate::gpu::{Fragment, MipMap, Pixel, Wrap};
use crate::math::{Vec2, Vec3, Vec4, det};
use crate::models::shadow::Lighting;

/// Which directions have views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dome {
    /// Those from above, which is where trees are mostly seen from; from below the nearest of them.
    Hemisphere,
    /// All.
    Sphere,
}

/// Views a side of the square.
pub(super) const OCTAHEDRAL_SIDE: u32 = 8;

impl Dome {
    /// The direction of a place of the square from (−1, −1) to (1, 1): a unit vector.
    pub(super) fn direction(self, place: Vec2) -> Vec3 {
        let (x, z) = match self {
            Self::Hemisphere => (0.5 * (place.x + place.y), 0.5 * (place.x - place.y)),
            Self::Sphere => (place.x, place.y),
        };
        let y = 1.0 - x.abs() - z.abs();
        let folded = if y < 0.0 {
            let sign = |value: f32| if value < 0.0 { -1.0 } else { 1.0 };
            Vec3::new((1.0 - z.abs()) * sign(x), y, (1.0 - x.abs()) * sign(z))
        } else {
            Vec3::new(x, y, z)
        };
        // On the rim of a hemisphere y may round to less than nothing.
        let folded = match self {
            Self::Hemisphere => Vec3::new(x, y.max(0.0), z),
            Self::Sphere => folded,
        };
        folded.normalize_or_zero()
    }

    /// The place of a direction.
    pub(super) fn place(self, direction: Vec3) -> Vec2 {
        let Vec3 { x, y, z } = direction;
        let y = match self {
            Self::Hemisphere => y.max(0.0),
            Self::Sphere => y,
        };
        let sum = (x.abs() + z.abs()) + y.abs();
        if sum == 0.0 {
            return Vec2::ZERO;
        }
        let (x, z) = (x / sum, z / sum);
        match self {
            Self::Hemisphere => Vec2::new(x + z, x - z),
            Self::Sphere if y < 0.0 => {
                let sign = |value: f32| if value < 0.0 { -1.0 } else { 1.0 };
                Vec2::new((1.0 - z.abs()) * sign(x), (1.0 - x.abs()) * sign(z))
            }
            Self::Sphere => Vec2::new(x, z),
        }
    }

    /// The directions of all views, row by row.
    pub(super) fn directions(self) -> impl Iterator<Item = Vec3> {
        let at = |number: u32| 2.0 * number as f32 / (OCTAHEDRAL_SIDE - 1) as f32 - 1.0;
        let views = 0..OCTAHEDRAL_SIDE * OCTAHEDRAL_SIDE;
        let places = views
            .map(move |view| Vec2::new(at(view % OCTAHEDRAL_SIDE), at(view / OCTAHEDRAL_SIDE)));
        places.map(move |place| self.direction(place))
    }

    /// The three views around a direction with their weights, which add up to 1.
    #[inline(always)]
    pub(super) fn around(self, direction: Vec3) -> [(usize, f32); 3] {
        const CELLS: f32 = (OCTAHEDRAL_SIDE - 1) as f32;
        let place = (self.place(direction) * 0.5 + Vec2::splat(0.5)) * CELLS;
        let place = place.clamp(Vec2::ZERO, Vec2::splat(CELLS));
        let (column, x) = whole_and_rest(place.x);
        let (row, y) = whole_and_rest(place.y);
        let side = OCTAHEDRAL_SIDE as usize;
        let view = |right: usize, down: usize| (row + down) * side + column + right;
        if x > y {
            [(view(0, 0), 1.0 - x), (view(1, 0), x - y), (view(1, 1), y)]
        } else {
            [(view(0, 0), 1.0 - y), (view(0, 1), y - x), (view(1, 1), x)]
        }
    }
}

/// The cell of a coordinate within [0, 7], at most the last, and how far into it.
#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to a few cells before"
)]
fn whole_and_rest(coordinate: f32) -> (usize, f32) {
    let whole = (coordinate as usize).min(OCTAHEDRAL_SIDE as usize - 2);
    (whole, coordinate - whole as f32)
}

/// So many directions around +Y, level, the first of them +Z, each further to +X.
pub(super) fn directions_around(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |number| {
        let angle = std::f32::consts::TAU * number as f32 / count as f32;
        let (sine, cosine) = det::sin_cos(angle);
        Vec3::new(sine, 0.0, cosine)
    })
}

/// Where the ray from a viewer through `point` meets the plane of a frame through its origin, as the
/// frame sees it. `eye` is the viewer, `scale` 1; or the direction to it, and 0. Points are told from the
/// origin. The ray that runs within the plane meets it nowhere.
#[inline(always)]
pub(super) fn on_plane(frame: &ViewFrame, point: Vec3, (eye, scale): (Vec3, f32)) -> Option<Vec2> {
    let along = eye - scale * point;
    let slope = along.dot(frame.toward);
    let met = point - along * (point.dot(frame.toward) / slope);
    (slope != 0.0).then(|| Vec2::new(met.dot(frame.right), met.dot(frame.up)))
}

/// Reads the three views around the direction to the viewer, each where the ray through the pixel meets
/// its plane, and blends them; alpha is tested once blended.
#[derive(Debug)]
pub(super) struct OctahedralFragment<'a> {
    pub(super) dome: Dome,
    pub(super) cards: Vec<RivalCard>,
    pub(super) colour: Option<&'a MipMap>,
    pub(super) normal: Option<&'a MipMap>,
    pub(super) alpha_cutoff: f32,
    pub(super) lighting: Lighting<'a>,
}

/// Where to read one of three views.
#[derive(Debug, Clone, Copy)]
struct Seen {
    at: Vec2,
    weight: f32,
}

impl OctahedralFragment<'_> {
    /// Where to read each view, and at which level; what lies beside a view has no weight.
    #[inline(always)]
    fn seen(&self, texture: &MipMap, pixel: &Pixel<'_>) -> ([Seen; 3], u32) {
        let [_, _, x, y, z, ..] = *pixel.varyings;
        let point = Vec3::new(x, y, z);
        let (eye, scale) = (
            Vec3::new(pixel.flats[3], pixel.flats[4], pixel.flats[5]),
            pixel.flats[6],
        );
        // Views have cells of one size.
        let sides = self
            .cards
            .first()
            .map_or(Vec2::ZERO, |card| card.cell.sides);
        let level = texture.level_for(pixel.derivative_x * sides, pixel.derivative_y * sides);
        let (width, height) = texture.level_size(level);
        let texel = Vec2::new(1.0 / width as f32, 1.0 / height as f32);
        let seen = self.dome.around(eye).map(|(view, weight)| {
            let nowhere = Seen {
                at: Vec2::ZERO,
                weight: 0.0,
            };
            let Some(card) = self.cards.get(view) else {
                return nowhere;
            };
            let met = on_plane(&card.frame, point, (eye, scale));
            let coordinate = met.map(|met| card.rectangle.coordinate(met));
            match coordinate {
                Some(at) if is_in_unit_square(at) => Seen {
                    at: card.cell.clamped(at, texel),
                    weight,
                },
                _ => nowhere,
            }
        });
        (seen, level)
    }
}

#[inline(always)]
fn is_in_unit_square(at: Vec2) -> bool {
    at.x >= 0.0 && at.y >= 0.0 && at.x <= 1.0 && at.y <= 1.0
}

impl Fragment for OctahedralFragment<'_> {
    const VARYINGS: usize = 5;
    const FLATS: usize = 7;
    const TESTS_ALPHA: bool = true;
    const IN_LANES: bool = false;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let Some(texture) = self.colour else {
            return false;
        };
        let (seen, level) = self.seen(texture, pixel);
        let [a, b, c] = seen.map(|Seen { at, weight }| {
            if weight > 0.0 {
                weight * texture.alpha(at, level, Wrap::Clamp)
            } else {
                0.0
            }
        });
        (a + b) + c >= self.alpha_cutoff
    }

    fn texels_tested(&self) -> u64 {
        12
    }

    fn texels_shaded(&self) -> u64 {
        24 + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let Some((colour, normals)) = self.colour.zip(self.normal) else {
            return Vec4::ZERO;
        };
        let (seen, level) = self.seen(colour, pixel);
        let (mut albedo, mut normal, mut sum) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        for Seen { at, weight } in seen {
            if weight > 0.0 {
                let texel = colour.sample(at, level, Wrap::Clamp);
                let weight = weight * texel.w;
                albedo += weight * texel.truncate();
                let coded = normals.sample(at, level, Wrap::Clamp).truncate();
                normal += weight * (2.0 * coded - Vec3::ONE);
                sum += weight;
            }
        }
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let to_light = Vec3::new(pixel.flats[0], pixel.flats[1], pixel.flats[2]);
        let toward = (share * normal).dot(to_light).max(0.0);
        (share * albedo * self.lighting.at(toward, pixel)).extend(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_are_inverse() {
        for dome in [Dome::Hemisphere, Dome::Sphere] {
            for column in -9_i16..=9 {
                for row in -9_i16..=9 {
                    let place = Vec2::new(f32::from(column), f32::from(row)) / 10.0;
                    let direction = dome.direction(place);
                    assert!((direction.length() - 1.0).abs() < 1e-6);
                    assert!(
                        dome.place(direction).distance(place) < 1e-5,
                        "{dome:?} {place}"
                    );
                    assert!(dome == Dome::Sphere || direction.y >= 0.0);
                }
            }
        }
        assert_eq!(Dome::Sphere.direction(Vec2::ONE), Vec3::NEG_Y);
        assert_eq!(Dome::Hemisphere.direction(Vec2::ONE), Vec3::X);
        assert_eq!(Dome::Hemisphere.place(Vec3::NEG_Y), Vec2::ZERO);
    }

    #[test]
    fn weights_add_up_and_one_view_alone_shows_from_its_direction() {
        for dome in [Dome::Hemisphere, Dome::Sphere] {
            for (view, direction) in dome.directions().enumerate() {
                let around = dome.around(direction);
                let alike = |other: usize| {
                    let other = dome.directions().nth(other).expect("there are 64");
                    other.distance(direction) < 1e-5
                };
                // Views on the rim of a sphere show from the same direction twice.
                let own: f32 = around
                    .iter()
                    .filter(|(other, _)| *other == view || alike(*other))
                    .map(|(_, weight)| weight)
                    .sum();
                assert!(own > 0.999, "{dome:?} {view}: {around:?}");
            }
            let around = dome.around(Vec3::new(0.3, 0.5, -0.7));
            let sum: f32 = around.iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-6);
            assert!(
                around
                    .iter()
                    .all(|(view, weight)| *view < 64 && *weight >= 0.0)
            );
        }
    }

    #[test]
    fn rays_meet_planes() {
        let frame = ViewFrame::upright(Vec3::ZERO, Vec3::X);
        // From (10, 0, 0) through (5, 1, 0): at x = 0 it is 2 up.
        let met = on_plane(&frame, Vec3::new(5.0, 1.0, 0.0), (10.0 * Vec3::X, 1.0));
        assert_eq!(met, Some(Vec2::new(0.0, 2.0)));
        let parallel = on_plane(&frame, Vec3::new(5.0, 1.0, -3.0), (Vec3::X, 0.0));
        assert_eq!(parallel, Some(Vec2::new(3.0, 1.0)));
        assert_eq!(on_plane(&frame, Vec3::ONE, (Vec3::Y, 0.0)), None);
    }
}
