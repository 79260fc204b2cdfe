//! How foliage moves when the camera moves sideways: optical flow from exact correspondences.
//!
//! ```text
//!  camera at A ─▶ picture ─▶ what shows at a pixel, and how deep ─▶ its point in space ─┐
//!                                                                    Model::carried     │
//!  camera at B ◀─ where the picture has that point ◀────────────────────────────────────┘
//! ```
//!
//! Nothing is estimated from pictures. A pixel's depth says where what it shows lies; the model says where
//! that very point of its surface is once the camera has moved ([`Model::carried`]): leaves and impostors
//! stay where they are, billboards turn. The flow of the pixel is the way from its own centre to where the
//! moved camera sees that point, whether it is hidden there or not.
//!
//! At each pixel that shows a leaf of the original, the flow of a level of detail is held against that of
//! the original. Where it shows nothing, or something that is gone when the camera has moved, the pixel has
//! no counterpart.

use std::sync::Arc;

use super::RunError;
use super::progress::Progress;
use crate::gpu::{
    Card, Device, DeviceDescriptor, Link, Load, RenderPass, TargetDescriptor, TargetId,
};
use crate::math::{DMat4, DVec2, DVec3, DVec4, Mat4, Sphere, Vec2, Vec3, Vec4, det};
use crate::models::{
    Crown, Environment, Kind, Model, ModelOptions, Placement, Resident, State, View, Viewpoint,
    frame_commands,
};
use crate::raster::{Counters, Options, Samples, Target, TileSize};

/// How far away the camera moves, in radii of the sphere around the foliage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParallaxDistance {
    /// What people call it.
    pub name: &'static str,
    /// From the sphere's centre, in its radii; above 1.
    pub radii: f64,
}

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallaxOptions {
    /// Pixels of a picture's side.
    pub side: u32,
    /// Vertical and horizontal field of view, in degrees.
    pub field_of_view: f64,
    /// Into how many steps 45° around the tree are divided: the camera takes each of them once, sideways.
    pub steps: u32,
    /// From where.
    pub distances: Vec<ParallaxDistance>,
}

impl ParallaxOptions {
    /// Insect, human and vehicle scale of [GSS05](crate::references) for one tree: from where the crown
    /// fills the picture to where it is a tenth of it. 45° hold one change of view of sprites that are
    /// taken from 8 sides.
    #[must_use]
    pub fn usual() -> Self {
        let distance = |name, radii| ParallaxDistance { name, radii };
        Self {
            side: 512,
            field_of_view: 45.0,
            steps: 16,
            distances: vec![
                distance("near", 2.7),
                distance("middle", 6.75),
                distance("far", 27.0),
            ],
        }
    }
}

/// A model that is measured, at one of its levels.
#[derive(Debug, Clone)]
pub struct ParallaxSubject {
    /// What it is called in tables.
    pub label: String,
    /// The model.
    pub kind: Kind,
    /// How it works.
    pub model: ModelOptions,
    /// Its level.
    pub state: State,
    /// What it is made of, if that is not the original itself: leaves that lie elsewhere.
    pub crown: Option<Arc<Crown>>,
}

impl ParallaxSubject {
    /// Whether both are levels of one model.
    fn is_of(&self, other: &Self) -> bool {
        let same_crown = match (&self.crown, &other.crown) {
            (None, None) => true,
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            (None, Some(_)) | (Some(_), None) => false,
        };
        self.kind == other.kind && self.model == other.model && same_crown
    }
}

/// What one subject did from one distance, over all steps.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallaxMeasure {
    /// [`ParallaxSubject::label`].
    pub label: String,
    /// From where.
    pub distance: ParallaxDistance,
    /// Pixels that show a leaf of the original.
    pub pixels: u64,
    /// Those of them for which the subject has no counterpart.
    pub missing: u64,
    /// How far the subject's flow ends from the original's at the others, in pixels.
    pub error: PixelSpread,
    /// The picture of the step in the middle.
    pub flow: FlowPicture,
}

/// The middle and the end of many distances, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PixelSpread {
    /// The mean.
    pub mean: f64,
    /// What 95 % do not exceed: the smallest of those that as many, rounded up, do not.
    pub most: f64,
}

/// What the original did from one distance: how much there is to get wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct ParallaxScale {
    /// From where.
    pub distance: ParallaxDistance,
    /// The same in metres of the plant's space.
    pub metres: f64,
    /// How far the camera moves in a step, in metres.
    pub step: f64,
    /// How far leaves move in the picture, beside what the centre of the foliage does, in pixels: a
    /// billboard that faces the camera has none of it.
    pub parallax: PixelSpread,
    /// How far the nearest point of the sphere would: the end of the scale of flow pictures.
    pub most: f64,
    /// The picture of the step in the middle.
    pub flow: FlowPicture,
}

/// The flow at each pixel less that of the foliage's centre, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowPicture {
    /// Pixels of a side.
    pub side: u32,
    /// In pixels, x to the right and y down.
    pub pixels: Vec<FlowPixel>,
}

/// What a pixel of a [`FlowPicture`] shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlowPixel {
    /// No foliage.
    Empty,
    /// Something that is gone when the camera has moved.
    Gone,
    /// Something that moves.
    Moves(Vec2),
}

/// All that was measured of a plant.
#[derive(Debug, Clone, PartialEq)]
pub struct Parallax {
    /// The plant's name.
    pub plant: String,
    /// What was asked for.
    pub options: ParallaxOptions,
    /// The radius of the sphere around its leaves, in metres.
    pub radius: f64,
    /// The original, a distance each.
    pub scales: Vec<ParallaxScale>,
    /// The subjects in their order, each from all distances.
    pub measures: Vec<ParallaxMeasure>,
}

/// Measures how foliage of a crown moves, held against all its original leaves.
///
/// # Errors
///
/// What the device refuses.
pub fn parallax(
    crown: &Arc<Crown>,
    subjects: &[ParallaxSubject],
    model: ModelOptions,
    options: &ParallaxOptions,
    progress: &dyn Progress,
) -> Result<Parallax, RunError> {
    let sphere = Sphere::of(&crown.leaf_points());
    let all = options.distances.len() as u64 * u64::from(options.steps);
    progress.begin("parallax", all * (1 + subjects.len() as u64));
    let original = ParallaxSubject {
        label: "original".to_owned(),
        kind: Kind::Full,
        model,
        state: State::FINEST,
        crown: None,
    };
    let mut original = Scope::new(crown, &original, options)?;
    // Levels of one model are shown on one device.
    let mut scopes: Vec<(&ParallaxSubject, Scope)> = Vec::new();
    let mut scope_of: Vec<usize> = Vec::new();
    for subject in subjects {
        let known = scopes.iter().position(|(known, _)| known.is_of(subject));
        if known.is_none() {
            scopes.push((subject, Scope::new(crown, subject, options)?));
        }
        scope_of.push(known.unwrap_or(scopes.len() - 1));
    }
    let mut scales = Vec::new();
    let mut measures: Vec<Vec<ParallaxMeasure>> = vec![Vec::new(); subjects.len()];
    // One distance after another, so that the original's flow is kept for one only.
    for &distance in &options.distances {
        let steps = 0..options.steps;
        let steps: Vec<Step> = steps
            .map(|number| Step::new(sphere, distance, number, options))
            .collect();
        let flows = |scope: &mut Scope| -> Result<Vec<FlowPicture>, RunError> {
            let flow = |step| {
                let flow = scope.flow(step)?;
                progress.step();
                Ok(flow)
            };
            steps.iter().map(flow).collect()
        };
        let truth = flows(&mut original)?;
        let moves = truth.iter().flat_map(FlowPicture::moves);
        scales.push(ParallaxScale {
            distance,
            metres: distance.radii * f64::from(sphere.radius),
            step: steps.first().map_or(0.0, |step| step.sideways.length()),
            parallax: PixelSpread::of(moves.map(Vec2::length).collect()),
            most: steps.first().map_or(0.0, |step| step.most),
            flow: middle(&truth, options),
        });
        for ((subject, &scope), measures) in subjects.iter().zip(&scope_of).zip(&mut measures) {
            let (_, scope) = &mut scopes[scope];
            scope.show(&subject.state)?;
            let found = flows(scope)?;
            let mut sum = Comparison::default();
            for (truth, found) in truth.iter().zip(&found) {
                sum.add(truth, found);
            }
            measures.push(ParallaxMeasure {
                label: subject.label.clone(),
                distance,
                pixels: sum.pixels,
                missing: sum.missing,
                error: PixelSpread::of(sum.errors),
                flow: middle(&found, options),
            });
        }
    }
    Ok(Parallax {
        plant: crown.plant().name().to_owned(),
        options: options.clone(),
        radius: f64::from(sphere.radius),
        scales,
        measures: measures.into_iter().flatten().collect(),
    })
}

/// The picture of the step in the middle.
fn middle(flows: &[FlowPicture], options: &ParallaxOptions) -> FlowPicture {
    let flow = flows.get(flows.len() / 2).cloned();
    flow.unwrap_or_else(|| FlowPicture {
        side: options.side,
        pixels: Vec::new(),
    })
}

/// Pixels of the original and what became of them.
#[derive(Debug, Default)]
struct Comparison {
    pixels: u64,
    missing: u64,
    errors: Vec<f32>,
}

impl Comparison {
    fn add(&mut self, truth: &FlowPicture, found: &FlowPicture) {
        for (truth, found) in truth.pixels.iter().zip(&found.pixels) {
            let FlowPixel::Moves(truth) = truth else {
                continue;
            };
            self.pixels += 1;
            match found {
                FlowPixel::Moves(found) => self.errors.push((*found - *truth).length()),
                FlowPixel::Empty | FlowPixel::Gone => self.missing += 1,
            }
        }
    }
}

impl PixelSpread {
    fn of(mut values: Vec<f32>) -> Self {
        values.sort_unstable_by(f32::total_cmp);
        let count = values.len();
        let Some(place) = (95 * count).div_ceil(100).checked_sub(1) else {
            return Self::default();
        };
        Self {
            mean: values.iter().map(|&value| f64::from(value)).sum::<f64>() / count as f64,
            most: f64::from(values[place]),
        }
    }
}

impl FlowPicture {
    fn moves(&self) -> impl Iterator<Item = Vec2> + '_ {
        self.pixels.iter().filter_map(|pixel| match pixel {
            FlowPixel::Moves(flow) => Some(*flow),
            FlowPixel::Empty | FlowPixel::Gone => None,
        })
    }
}

/// A camera that looks at the centre of the foliage, and moves to its right without turning.
#[derive(Debug, Clone, Copy)]
struct Step {
    views: [Viewpoint; 2],
    center: DVec3,
    sideways: DVec3,
    most: f64,
}

impl Step {
    fn new(
        sphere: Sphere,
        distance: ParallaxDistance,
        number: u32,
        options: &ParallaxOptions,
    ) -> Self {
        let (center, radius) = (sphere.center.as_dvec3(), f64::from(sphere.radius));
        let metres = distance.radii * radius;
        let eighth = std::f64::consts::FRAC_PI_4;
        let width = eighth / f64::from(options.steps.max(1));
        // Where sprites change their view lies within a step, not between two.
        let around = width * (f64::from(number) + 0.5);
        let (sine, cosine) = (det::sin_f64(around), det::cos_f64(around));
        let outwards = DVec3::new(sine, 0.0, cosine);
        let right = DVec3::new(cosine, 0.0, -sine);
        let tangent = det::sin_f64(width) / det::cos_f64(width);
        let sideways = right * (metres * tangent);
        let half = options.field_of_view.to_radians() / 2.0;
        let focal = det::cos_f64(half) / det::sin_f64(half);
        let view = |eye: DVec3| {
            let rows = [right, DVec3::Y, outwards];
            let view = DMat4::from_cols(
                DVec4::new(rows[0].x, rows[1].x, rows[2].x, 0.0),
                DVec4::new(rows[0].y, rows[1].y, rows[2].y, 0.0),
                DVec4::new(rows[0].z, rows[1].z, rows[2].z, 0.0),
                DVec4::new(-rows[0].dot(eye), -rows[1].dot(eye), -rows[2].dot(eye), 1.0),
            );
            // The sphere lies between the planes, with room for what stands beside it.
            let (near, far) = (
                metres - 1.01 * radius.min(metres / 1.02),
                metres + 1.5 * radius,
            );
            let deep = far / (near - far);
            let clip = DMat4::from_cols(
                DVec4::new(focal, 0.0, 0.0, 0.0),
                DVec4::new(0.0, focal, 0.0, 0.0),
                DVec4::new(0.0, 0.0, deep, -1.0),
                DVec4::new(0.0, 0.0, deep * near, 0.0),
            );
            Viewpoint {
                eye: eye.as_vec3(),
                clip_from_plant: (clip * view).as_mat4(),
            }
        };
        let eye = center + outwards * metres;
        let to_pixels = focal * f64::from(options.side) / 2.0 * metres * tangent;
        Self {
            views: [view(eye), view(eye + sideways)],
            center,
            sideways,
            most: to_pixels * (1.0 / (metres - radius).max(0.01 * metres) - 1.0 / metres),
        }
    }
}

/// A model on a device of its own, seen from where a step begins.
#[derive(Debug)]
struct Scope {
    model: Box<dyn Model>,
    device: Device,
    environment: Environment,
    resident: Box<dyn Resident>,
    target: TargetId,
}

impl Scope {
    fn new(
        crown: &Arc<Crown>,
        subject: &ParallaxSubject,
        options: &ParallaxOptions,
    ) -> Result<Self, RunError> {
        let mut device = Device::new(DeviceDescriptor {
            memory_bytes: u64::MAX,
            link: Link::ALL[0],
            card: Card::named("gtx770").unwrap_or(Card::ALL[0]),
            raster: Options {
                tile: TileSize::Side64,
                counters: Counters::Visible,
            },
        });
        let environment = Environment::of_kind(&mut device, 1, subject.kind)?;
        environment.place(&mut device.queue(), 0, &Placement::IDENTITY)?;
        let crown = subject.crown.as_ref().unwrap_or(crown);
        let model = subject.kind.model(crown, subject.model);
        let shared = model.upload(&mut device, &environment)?;
        let resident = shared.instance(&mut device, &subject.state, 0)?;
        let target = device.create_target(&TargetDescriptor {
            label: "parallax",
            width: options.side,
            height: options.side,
            samples: Samples::One,
        })?;
        Ok(Self {
            model,
            device,
            environment,
            resident,
            target,
        })
    }

    fn show(&mut self, state: &State) -> Result<(), RunError> {
        self.resident.commit(&mut self.device.queue(), state)?;
        Ok(())
    }

    fn flow(&mut self, step: &Step) -> Result<FlowPicture, RunError> {
        let view = View {
            clip_from_world: step.views[0].clip_from_plant,
            to_light: Vec3::Y,
            light: Vec3::ONE,
            ambient: Vec3::ONE,
        };
        let mut queue = self.device.queue();
        self.environment.set_view(&mut queue, &view)?;
        let mut steps = Vec::new();
        self.resident.draw(&mut steps);
        let pass = RenderPass {
            label: "parallax".to_owned(),
            target: self.target,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            },
            steps,
        };
        let residents = std::iter::once(&*self.resident);
        queue.submit(&frame_commands(
            &self.environment,
            pass,
            Vec::new(),
            residents,
        ))?;
        // Nobody asks what it cost.
        self.device.take_ledger();
        let target = self.device.inspect_target(self.target)?;
        let (model, state) = (self.model.as_ref(), self.resident.state());
        Ok(flow_of(target, model, state, step))
    }
}

/// The flow at each pixel of a picture.
fn flow_of(target: &Target, model: &dyn Model, state: &State, step: &Step) -> FlowPicture {
    let side = target.width();
    let [from, to] = step.views;
    let clip_from_plant = [from, to].map(|view| wide(view.clip_from_plant));
    let plant_from_clip = clip_from_plant[0].inverse();
    let half = f64::from(side) / 2.0;
    let pixel_of = |clip_from_plant: &DMat4, point: DVec3| {
        let clip = *clip_from_plant * point.extend(1.0);
        let at = DVec2::new(clip.x, -clip.y) / clip.w;
        (at + DVec2::ONE) * half
    };
    let of_center = {
        let [before, after] =
            [0, 1].map(|view: usize| pixel_of(&clip_from_plant[view], step.center));
        after - before
    };
    let flow = |x: u32, y: u32| {
        // Nothing but foliage is drawn.
        let Some(key) = target.key(x, y) else {
            return FlowPixel::Empty;
        };
        let here = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let at = here / half - DVec2::ONE;
        let depth = f64::from(target.depth(x, y));
        let point = plant_from_clip * DVec4::new(at.x, -at.y, depth, 1.0);
        let point = point.truncate() / point.w;
        match model.carried(state, key, point, [&from, &to]) {
            None => FlowPixel::Gone,
            Some(point) => {
                let flow = pixel_of(&clip_from_plant[1], point) - here;
                FlowPixel::Moves((flow - of_center).as_vec2())
            }
        }
    };
    let rows = 0..target.height();
    FlowPicture {
        side,
        pixels: rows
            .flat_map(|y| (0..side).map(move |x| (x, y)))
            .map(|(x, y)| flow(x, y))
            .collect(),
    }
}

fn wide(matrix: Mat4) -> DMat4 {
    matrix.as_dmat4()
}
