//! Foliage alone, seen from everywhere: the fixed views by which levels are judged.

use std::sync::Arc;

use super::RunError;
use crate::gpu::{
    Card, Command, Device, DeviceDescriptor, Link, Load, RenderPass, TargetDescriptor, TargetId,
};
use crate::math::{Mat4, Sphere, Vec3, Vec4};
use crate::models::{
    Crown, Environment, Extraction, Gather, Kind, LEAF_GROUP, LeafFormat, ModelOptions, Occlusion,
    Placement, Records, Resident, State, Vertices, View, shows_foliage,
};
use crate::raster::{Counters, Image, Options, Samples, Target, TileSize, decode_srgb};
use crate::scene::CardOptions;

/// Pixels of a picture's side.
pub const VIEW_SIDE: u32 = 512;

/// The share of the side that the sphere's diameter takes.
pub(super) const SPHERE_SHARE: f32 = 0.9;

/// The sRGB colour behind the leaves: a hazy sky.
const SKY: [u8; 3] = [185, 207, 228];

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
    device: Device,
    environment: Environment,
    resident: Box<dyn Resident>,
    target: TargetId,
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
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: u64::MAX,
            link: Link::ALL[0],
            card: Card::ALL[0],
            raster: Options {
                tile: TileSize::Side64,
                counters: Counters::Visible,
            },
        });
        let environment = Environment::new(&mut device, 1)?;
        environment.place(&mut device.queue(), 0, &Placement::IDENTITY)?;
        let options = ModelOptions {
            extraction: Extraction::Batched,
            gather: Gather::Single,
            format: LeafFormat {
                records: Records::Wide,
                vertices,
            },
            occlusion: Occlusion::None,
            cards: CardOptions::USUAL,
        };
        let model = Kind::LodfStamps.model(crown, options);
        let shared = model.upload(&mut device, &environment)?;
        let resident = shared.instance(&mut device, &State::FINEST, 0)?;
        let target = device.create_target(&TargetDescriptor {
            label: "view",
            width: VIEW_SIDE,
            height: VIEW_SIDE,
            samples: Samples::One,
        })?;
        Ok(Self {
            device,
            environment,
            resident,
            target,
            sphere,
        })
    }

    /// Goes over to another level.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub fn show(&mut self, state: &State) -> Result<(), RunError> {
        self.resident.commit(&mut self.device.queue(), state)?;
        Ok(())
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
        let view = View {
            clip_from_world: look_along(direction, self.sphere),
            to_light: Vec3::new(0.4, 0.8, 0.45).normalize(),
            light: Vec3::new(0.85, 0.82, 0.75),
            ambient: Vec3::new(0.25, 0.28, 0.32),
        };
        let mut queue = self.device.queue();
        self.environment.set_view(&mut queue, &view)?;
        let mut steps = Vec::new();
        self.resident.draw(&mut steps);
        let load = Load::Clear {
            color: decode_srgb(SKY),
            depth: 1.0,
        };
        let pass = RenderPass {
            label: "view".to_owned(),
            target: self.target,
            load,
            steps,
        };
        queue.submit(&[Command::Render(pass)])?;
        // Nobody asks what it cost.
        self.device.take_ledger();
        Ok(self.device.inspect_target(self.target)?)
    }
}

/// The orthographic view from `direction` onto a sphere.
fn look_along(direction: Vec3, sphere: Sphere) -> Mat4 {
    let forward = -direction;
    let up = if direction.y.abs() > 0.9 {
        Vec3::Z
    } else {
        Vec3::Y
    };
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
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
