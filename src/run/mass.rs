//! Whether foliage keeps its mass: how much of a picture it covers, seen from everywhere.

use std::sync::Arc;

use super::RunError;
use crate::gpu::{
    Card, Command, Device, DeviceDescriptor, Link, Load, RenderPass, TargetDescriptor,
};
use crate::math::{Mat4, Sphere, Vec3, Vec4};
use crate::models::{
    Crown, Environment, Extraction, Gather, Kind, LEAF_GROUP, LeafFormat, ModelOptions, Placement,
    State, View,
};
use crate::raster::{Counters, Options, Samples, TileSize};
use crate::simplify::measure_leaves;

/// Pixels of a picture's side.
const SIDE: u32 = 512;

/// The share of the side that the bounding sphere's diameter takes.
const SPHERE_SHARE: f32 = 0.9;

/// How much foliage there is to see in one state.
#[derive(Debug, Clone, PartialEq)]
pub struct Mass {
    /// Leaves shown.
    pub leaves: u32,
    /// Pixels that show a leaf, for each of [`directions`].
    pub covered: Vec<u32>,
    /// The summed area of the leaves, in square metres.
    pub area: f64,
    /// Leaves that are folded.
    pub folded: u32,
}

impl Mass {
    /// The mean of the covered pixels.
    #[must_use]
    pub fn mean_covered(&self) -> f64 {
        let sum: u64 = self.covered.iter().map(|&pixels| u64::from(pixels)).sum();
        sum as f64 / self.covered.len().max(1) as f64
    }

    /// Covered pixels against `full`'s: the mean over all directions, and the one that is furthest
    /// from 1.
    #[must_use]
    pub fn against(&self, full: &Self) -> (f64, f64) {
        let mean = self.mean_covered() / full.mean_covered();
        let ratios = self.covered.iter().zip(&full.covered);
        let worst = ratios
            .map(|(&some, &all)| f64::from(some) / f64::from(all.max(1)))
            .max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
        (mean, worst.unwrap_or(1.0))
    }

    /// The share of the bounding sphere's disc that is covered, over all directions.
    #[must_use]
    pub fn share_of_disc(&self) -> f64 {
        let radius = f64::from(SPHERE_SHARE) * f64::from(SIDE) / 2.0;
        self.mean_covered() / (std::f64::consts::PI * radius * radius)
    }
}

/// The 26 directions from which mass is judged: through the faces, edges and corners of a cube, of
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

/// Measures states of a crown: orthographic pictures of 512 × 512 pixels from 26 directions, the
/// bounding sphere of the leaves 90 % of the side, no trunk, alpha test on, one sample.
///
/// # Errors
///
/// What the device refuses.
pub fn mass(crown: &Arc<Crown>, states: &[State]) -> Result<Vec<Mass>, RunError> {
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
        format: LeafFormat::WIDE,
    };
    let model = Kind::LodfStamps.model(crown, options);
    let shared = model.upload(&mut device, &environment)?;
    let mut resident = shared.instance(&mut device, &State::FINEST, 0)?;
    let target = device.create_target(&TargetDescriptor {
        label: "mass",
        width: SIDE,
        height: SIDE,
        samples: Samples::One,
    })?;
    let sphere = Sphere::of(crown.vertices());
    let mut masses = Vec::new();
    for state in states {
        resident.commit(&mut device.queue(), state)?;
        let visible = state.visible(crown.clusters());
        let measure = measure_leaves(crown.vertices(), crown.sequence(), visible);
        let mut covered = Vec::new();
        for direction in directions() {
            let view = View {
                clip_from_world: look_along(direction, sphere),
                to_light: Vec3::Y,
                light: Vec3::ONE,
                ambient: Vec3::ONE,
            };
            environment.set_view(&mut device.queue(), &view)?;
            let mut steps = Vec::new();
            resident.draw(&mut steps);
            let load = Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            };
            let pass = RenderPass {
                label: "mass".to_owned(),
                target,
                load,
                steps,
            };
            device.queue().submit(&[Command::Render(pass)])?;
            let picture = device.inspect_target(target)?;
            covered.push(picture.pixels_showing(LEAF_GROUP));
        }
        device.take_ledger();
        let (leaves, area, folded) = (measure.leaves, measure.area, measure.folded);
        masses.push(Mass {
            leaves,
            covered,
            area,
            folded,
        });
    }
    Ok(masses)
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
