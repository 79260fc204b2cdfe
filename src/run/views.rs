//! Foliage alone, seen from everywhere: the fixed views by which levels are judged.

use std::sync::Arc;

use super::RunError;
use super::studio::{Studio, StudioOptions};
use crate::gpu::{Card, Link};
use crate::math::{Mat4, Sphere, Vec3, Vec4};
use crate::models::{
    Crown, Extraction, Gather, Kind, LEAF_GROUP, LeafFormat, ModelOptions, Occlusion, Records,
    State, Vertices, shows_foliage,
};
use crate::raster::{Counters, Image, Target};
use crate::scene::{CardOptions, PaintOptions};

/// Pixels of a picture's side.
pub const VIEW_SIDE: u32 = 512;

/// The share of the side that the sphere's diameter takes.
pub(super) const SPHERE_SHARE: f32 = 0.9;

/// The 26 directions from which foliage is judged: through the faces, edges and corners of a cube, of
/// length 1.
#[must_use]
pub fn directions() -> Vec<Vec3> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(|x| {
        steps
            .into_iter()
            .flat_map(move |y| steps.map(|z| Vec3::new(x, y, z)))
    });
    all.filter(|direction| *direction != Vec3::ZERO)
        .map(Vec3::normalize)
        .collect()
}

/// Those of the [directions] that go through the cube's eight corners: of each pair of opposite sides
/// both, and of all planes both faces.
#[must_use]
pub fn corner_directions() -> Vec<Vec3> {
    let mut corners = directions();
    corners.retain(|direction| direction.to_array().iter().all(|&along| along != 0.0));
    corners
}

/// A picture, and where leaves are in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shot {
    /// The picture.
    pub image: Image,
    /// Whether a pixel shows a leaf, by its first sample; row by row from the top.
    pub leaves: Vec<bool>,
}

impl Shot {
    /// What a target shows.
    pub(super) fn of(target: &Target) -> Self {
        let columns = 0..target.width();
        let pixels = (0..target.height()).flat_map(|y| columns.clone().map(move |x| (x, y)));
        let is_leaf = |(x, y)| {
            let key = target.key(x, y);
            key.is_some_and(|key| shows_foliage(key.group))
        };
        Self {
            image: target.resolve(),
            leaves: pixels.map(is_leaf).collect(),
        }
    }
}

/// The foliage of one crown on a device of its own, without bounds, to be seen from any direction:
/// orthographic pictures of [`VIEW_SIDE`]² pixels, a given sphere 90 % of the side, no trunk, alpha
/// test on, one sample, and always the same sky and light, that of scenes which say nothing of it, so
/// that what is found for one plant can be held against what is found for another.
#[derive(Debug)]
pub struct Views {
    studio: Studio,
    sphere: Sphere,
}

impl Views {
    /// Shows a crown at full detail, around the sphere of its original leaves, which is the same
    /// whatever simplifies them.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn new(crown: &Arc<Crown>) -> Result<Self, RunError> {
        Self::with_vertices(crown, Vertices::Float)
    }

    /// As [`new`](Self::new), the leaves placed as exactly as `vertices` says.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn with_vertices(crown: &Arc<Crown>, vertices: Vertices) -> Result<Self, RunError> {
        Self::make(crown, vertices, Sphere::of(&crown.leaf_points()))
    }

    /// Shows a crown at full detail, around a given sphere: for leaves that are what was left of
    /// others.
    ///
    /// # Errors
    ///
    /// What the device refuses.
    pub fn within(crown: &Arc<Crown>, sphere: Sphere) -> Result<Self, RunError> {
        Self::make(crown, Vertices::Float, sphere)
    }

    fn make(crown: &Arc<Crown>, vertices: Vertices, sphere: Sphere) -> Result<Self, RunError> {
        let options = ModelOptions {
            extraction: Extraction::Batched,
            gather: Gather::Single,
            format: LeafFormat {
                records: Records::Wide,
                vertices,
            },
            occlusion: Occlusion::None,
            cards: CardOptions::USUAL,
            painting: PaintOptions::USUAL,
        };
        let model = Kind::LodfStamps.model(crown, options);
        let studio = StudioOptions {
            side: VIEW_SIDE,
            link: Link::ALL[0],
            card: Card::ALL[0],
            counters: Counters::Visible,
        };
        Ok(Self {
            studio: Studio::new(model.as_ref(), &State::FINEST, &studio)?,
            sphere,
        })
    }

    /// Goes over to another level.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub fn show(&mut self, state: &State) -> Result<(), RunError> {
        self.studio.show(state)
    }

    /// The foliage as it looks from each of [`directions`].
    ///
    /// # Errors
    ///
    /// None on this device.
    pub fn shots(&mut self) -> Result<Vec<Shot>, RunError> {
        let shot = |direction| Ok(Shot::of(self.draw(direction)?));
        directions().into_iter().map(shot).collect()
    }

    /// How many pixels show a leaf from each of [`directions`].
    ///
    /// # Errors
    ///
    /// None on this device.
    pub fn covered(&mut self) -> Result<Vec<u32>, RunError> {
        let covered = |direction| Ok(self.draw(direction)?.pixels_showing(LEAF_GROUP));
        directions().into_iter().map(covered).collect()
    }

    fn draw(&mut self, direction: Vec3) -> Result<&Target, RunError> {
        let view = look_along(direction, self.sphere);
        Ok(self.studio.draw(view)?.0)
    }
}

/// The orthographic view from `direction` onto a sphere.
pub(super) fn look_along(direction: Vec3, sphere: Sphere) -> Mat4 {
    let forward = -direction;
    let [right, up] = across(direction);
    let scale = SPHERE_SHARE / sphere.radius;
    // The sphere takes depths 0.25 to 0.75.
    let deep = 0.25 / sphere.radius;
    let rows = [right * scale, up * scale, forward * deep];
    let offset = |row: Vec3| -row.dot(sphere.center);
    Mat4::from_cols(
        Vec4::new(rows[0].x, rows[1].x, rows[2].x, 0.0),
        Vec4::new(rows[0].y, rows[1].y, rows[2].y, 0.0),
        Vec4::new(rows[0].z, rows[1].z, rows[2].z, 0.0),
        Vec4::new(offset(rows[0]), offset(rows[1]), offset(rows[2]) + 0.5, 1.0),
    )
}

/// What lies to the right and up in a picture that is taken from `direction`.
fn across(direction: Vec3) -> [Vec3; 2] {
    let up = if direction.y.abs() > 0.9 {
        Vec3::Z
    } else {
        Vec3::Y
    };
    let right = (-direction).cross(up).normalize();
    [right, right.cross(-direction)]
}

/// The perspective view of a sphere's middle from `direction`, so many metres before its surface, with
/// the tangent of half the angle that the picture spans.
pub(super) fn look_from(direction: Vec3, sphere: Sphere, before: f32, tangent: f32) -> Mat4 {
    let [right, up] = across(direction);
    let forward = -direction;
    let eye = sphere.center + (sphere.radius + before) * direction;
    // Half of the way to the surface, and a little beyond the far side.
    let (near, far) = (0.5 * before, before + 2.01 * sphere.radius);
    let deep = far / (far - near);
    let rows = [right / tangent, up / tangent, forward * deep, forward];
    let offset = |row: Vec3| -row.dot(eye);
    let column =
        |axis: usize| Vec4::new(rows[0][axis], rows[1][axis], rows[2][axis], rows[3][axis]);
    let last = Vec4::new(
        offset(rows[0]),
        offset(rows[1]),
        offset(rows[2]) - deep * near,
        offset(rows[3]),
    );
    Mat4::from_cols(column(0), column(1), column(2), last)
}
