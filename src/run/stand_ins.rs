//! What stands in for leaves, held against them: from 26 directions at several distances, and what a
//! frame takes of the card, near and far.
//!
//! ```text
//! crown ─┬─ leaves ─────────────────▶ the reference
//!        ├─ flattened N ────────────▶ against leaves: the error of planes
//!        ├─ impostors N ────────────▶ against leaves: all of it
//!        └─ impostors N, flattened ─▶ against flattened N: the error of textures
//! ```
//!
//! [GSS05](crate::references), § 4: impostors are "equivalent to moving and rotating the leaves a little toward
//! their common planes". So what they do wrong splits into what planes do and what textures do, and
//! each can be looked at alone.

use std::cmp::Reverse;
use std::sync::Arc;

use super::RunError;
use super::options::SessionOptions;
use super::progress::Progress;
use super::studio::{Studio, StudioOptions};
use super::views::{SPHERE_SHARE, Shot, directions, look_from};
use super::world::{World, finest_planes, with_foliage};
use crate::gpu::Ledger;
use crate::math::{Sphere, Vec3, det, index_u32, whole_u32};
use crate::models::{Crown, Kind, Model, ModelOptions, State};
use crate::plant::LeafGroup;
use crate::raster::Counters;
use crate::scene::{CardCounts, CardOptions};
use crate::simplify::leaves_of_cluster;

/// What is looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInOptions {
    /// The kinds of cards to hold against leaves.
    pub kinds: Vec<Kind>,
    /// Numbers of planes, in which leaves are flattened and impostors stand.
    pub counts: Vec<u32>,
    /// From how far.
    pub scales: Vec<ViewScale>,
    /// The least and the largest radius of the crown in pixels of the curve of frame times; the radius
    /// doubles from point to point.
    pub radii: [f32; 2],
    /// The picture's height, and link and card by which times are modelled.
    pub session: SessionOptions,
    /// The angle between the upper and lower edge of a picture of that height, in degrees.
    pub field_of_view: f32,
}

/// A distance from which things are judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewScale {
    /// Its name.
    pub name: &'static str,
    /// Metres from the eye to the sphere around the leaves.
    pub before: f32,
}

impl ViewScale {
    /// The scales of [GSS05](crate::references), § 1, which gives ranges alone: "individual branches and
    /// leaves", "an arm's reach to some tens of meters", "may exceed several hundred meters".
    pub const ALL: [Self; 3] = [
        Self {
            name: "insect",
            before: 1.0,
        },
        Self {
            name: "human",
            before: 15.0,
        },
        Self {
            name: "vehicle",
            before: 200.0,
        },
    ];
}

/// Whose leaves something stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Leaves {
    /// The plant's.
    Original,
    /// The same in the planes of their clusters.
    Flattened,
}

/// Leaves, or what stands in for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct StandIn {
    /// What draws it.
    pub kind: Kind,
    /// In how many planes, where it has planes.
    pub planes: Option<u32>,
    /// Whose leaves.
    pub leaves: Leaves,
}

impl StandIn {
    /// The plant's leaves as they are.
    pub const LEAVES: Self = Self {
        kind: Kind::Full,
        planes: None,
        leaves: Leaves::Original,
    };

    /// What it is held against: flattened leaves for cards that stand for them, else the plant's.
    #[must_use]
    pub fn reference(self) -> Self {
        match self.leaves {
            Leaves::Flattened if self.kind != Kind::Full => Self {
                kind: Kind::Full,
                ..self
            },
            Leaves::Original | Leaves::Flattened => Self::LEAVES,
        }
    }

    /// Such as `leaves`, `flattened-32`, `impostors-direct-32` and `impostors-direct-32 of flattened`.
    #[must_use]
    pub fn label(self) -> String {
        let planes = self.planes.map(|planes| format!("-{planes}"));
        let planes = planes.unwrap_or_default();
        match (self.kind, self.leaves) {
            (Kind::Full, Leaves::Original) => "leaves".to_owned(),
            (Kind::Full, Leaves::Flattened) => format!("flattened{planes}"),
            (kind, Leaves::Original) => format!("{}{planes}", kind.label()),
            (kind, Leaves::Flattened) => format!("{}{planes} of flattened", kind.label()),
        }
    }
}

/// What is found of a stand-in.
#[derive(Debug, Clone, PartialEq)]
pub enum StandInFound {
    /// How it looks at one scale.
    Look(StandInLook),
    /// What it takes; after all its looks.
    Cost(StandInCost),
    /// The leaves of a cluster alone.
    Cluster(ClusterLook),
}

/// How the leaves of one cluster look.
#[derive(Debug, Clone, PartialEq)]
pub struct ClusterLook {
    /// In how many planes the leaves are.
    pub planes: u32,
    /// Which of the clusters it is.
    pub cluster: u32,
    /// How many leaves it has.
    pub leaves: u32,
    /// The picture from the front, from as far as the second scale.
    pub shot: Shot,
}

/// How a stand-in looks at one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInLook {
    /// What.
    pub stand_in: StandIn,
    /// Which of the scales asked for.
    pub scale: usize,
    /// The pictures, from each of [`directions`].
    pub shots: Vec<Shot>,
    /// What drawing them took, all together.
    pub frames: Ledger,
}

/// What a stand-in takes.
#[derive(Debug, Clone, PartialEq)]
pub struct StandInCost {
    /// What.
    pub stand_in: StandIn,
    /// Triangles of a frame.
    pub triangles: u64,
    /// The upload of the model and one instance.
    pub initial: Ledger,
    /// What they hold on the device, in bytes.
    pub resident_bytes: u64,
    /// What a frame takes by the crown's radius in pixels.
    pub curve: Vec<CurvePoint>,
}

/// Frames at one distance.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// The radius of the sphere around the leaves, in pixels.
    pub radius: f32,
    /// What [`CURVE_VIEWS`] frames took, all together.
    pub frames: Ledger,
}

/// Frames a point of the curve: from the four sides.
pub const CURVE_VIEWS: u64 = 4;

/// Looks at everything asked for: leaves; then for each number of planes flattened leaves, and of each
/// kind cards for the plant's leaves and for the flattened ones; kinds that stand in no planes once,
/// at the end. Everything is of the world's first plant; without one, nothing is found.
///
/// # Errors
///
/// What the device refuses, and what `take` answers.
pub fn stand_ins<E: From<RunError>>(
    world: &World,
    options: &StandInOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(StandInFound) -> Result<(), E>,
) -> Result<(), E> {
    let Some(crown) = world.crowns.first() else {
        return Ok(());
    };
    let sphere = sphere_of(crown);
    let all = asked_for(options);
    progress.begin("stand-ins", all.len() as u64);
    show_clusters(crown, sphere, options, &mut take)?;
    let mut flat: Option<(u32, Arc<Crown>)> = None;
    for stand_in in all {
        let cards = match stand_in
            .planes
            .and_then(|planes| CardCounts::new(&[planes]))
        {
            Some(levels) => CardOptions {
                levels,
                ..options.session.model.cards
            },
            None => options.session.model.cards,
        };
        let leaves = match (stand_in.leaves, stand_in.planes) {
            (Leaves::Flattened, Some(planes)) => {
                let known = flat.take().filter(|(known, _)| *known == planes);
                let flattened = known.map_or_else(
                    || Arc::clone(&world.plant_alone(0).flattened(&cards).crowns[0]),
                    |(_, crown)| crown,
                );
                flat = Some((planes, Arc::clone(&flattened)));
                flattened
            }
            (Leaves::Original | Leaves::Flattened, _) => Arc::clone(crown),
        };
        let model = stand_in.kind.model(
            &leaves,
            ModelOptions {
                cards,
                ..options.session.model
            },
        );
        look_at(stand_in, model.as_ref(), sphere, options, &mut take)?;
        progress.step();
    }
    Ok(())
}

/// The two clusters with the most leaves, of as many planes as the scene's cards have at their finest
/// level, as Figure 4 of [GSS05](crate::references) shows two of its 32.
fn show_clusters<E: From<RunError>>(
    crown: &Crown,
    sphere: Sphere,
    options: &StandInOptions,
    take: &mut impl FnMut(StandInFound) -> Result<(), E>,
) -> Result<(), E> {
    let scale = options.scales.get(1).or(options.scales.first());
    let Some(scale) = scale else {
        return Ok(());
    };
    let plant = crown.plant();
    let level = finest_planes(plant, &options.session.model.cards);
    let mut sizes = vec![0_u32; level.planes.len()];
    for &cluster in &level.cluster_of_site {
        sizes[cluster as usize] += 1;
    }
    let mut largest: Vec<u32> = (0..index_u32(sizes.len())).collect();
    largest.sort_by_key(|&cluster| Reverse(sizes[cluster as usize]));
    let screen = Screen::new(options);
    for &cluster in largest.iter().take(2) {
        let leaves = leaves_of_cluster(plant.foliage(), &level, cluster);
        let alone = Arc::new(with_foliage(plant, leaves));
        let model = Kind::Full.model(&alone, options.session.model);
        let mut camera = screen.camera(model.as_ref(), sphere, scale.before)?;
        take(StandInFound::Cluster(ClusterLook {
            planes: index_u32(sizes.len()),
            cluster,
            leaves: sizes[cluster as usize],
            shot: camera.shot(Vec3::Z)?.0,
        }))?;
    }
    Ok(())
}

/// The stand-ins in order: each after what it is held against.
fn asked_for(options: &StandInOptions) -> Vec<StandIn> {
    let in_planes = |kind: &&Kind| kind.names().0 == "impostors";
    let mut all = vec![StandIn::LEAVES];
    for &count in &options.counts {
        let flat = StandIn {
            kind: Kind::Full,
            planes: Some(count),
            leaves: Leaves::Flattened,
        };
        all.push(flat);
        for &kind in options.kinds.iter().filter(in_planes) {
            for leaves in [Leaves::Original, Leaves::Flattened] {
                all.push(StandIn {
                    kind,
                    leaves,
                    ..flat
                });
            }
        }
    }
    let others = options.kinds.iter().filter(|kind| !in_planes(kind));
    all.extend(others.map(|&kind| StandIn {
        kind,
        ..StandIn::LEAVES
    }));
    all
}

fn look_at<E: From<RunError>>(
    stand_in: StandIn,
    model: &dyn Model,
    sphere: Sphere,
    options: &StandInOptions,
    take: &mut impl FnMut(StandInFound) -> Result<(), E>,
) -> Result<(), E> {
    let screen = Screen::new(options);
    // Other models of the same leaves show the same.
    let is_looked_at = stand_in == StandIn::LEAVES
        || stand_in.leaves == Leaves::Flattened
        || !stand_in.kind.shows_leaves();
    let scales = options.scales.iter().enumerate().filter(|_| is_looked_at);
    for (scale, view) in scales {
        let mut frames = Ledger::default();
        let mut shots = Vec::new();
        let mut camera = screen.camera(model, sphere, view.before)?;
        for direction in directions() {
            let (shot, ledger) = camera.shot(direction)?;
            shots.push(shot);
            frames.add(&ledger);
        }
        take(StandInFound::Look(StandInLook {
            stand_in,
            scale,
            shots,
            frames,
        }))?;
    }
    // What stands for flattened leaves costs what stands for leaves costs.
    if stand_in.leaves == Leaves::Flattened && stand_in.kind != Kind::Full {
        return Ok(());
    }
    let mut cost = StandInCost {
        stand_in,
        triangles: 0,
        initial: Ledger::default(),
        resident_bytes: 0,
        curve: Vec::new(),
    };
    let [mut radius, most] = options.radii;
    while radius <= most {
        let mut camera = screen.camera(model, sphere, screen.before(sphere, radius))?;
        let mut frames = Ledger::default();
        for side in [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z] {
            frames.add(&camera.shot(side)?.1);
        }
        cost.curve.push(CurvePoint { radius, frames });
        cost.triangles = triangles(stand_in, model, &camera.studio);
        cost.resident_bytes = camera.studio.resident_bytes;
        cost.initial = camera.studio.initial;
        radius *= 2.0;
    }
    take(StandInFound::Cost(cost))
}

/// The sphere around all leaves, of whatever prototype.
pub(super) fn sphere_of(crown: &Crown) -> Sphere {
    let groups = crown.plant().foliage().groups.iter();
    let positions: Vec<Vec3> = groups
        .flat_map(|group| group.positions.iter().copied())
        .collect();
    Sphere::of(&positions)
}

/// Triangles of a frame: those of all leaves, or the cards that stand for them.
fn triangles(stand_in: StandIn, model: &dyn Model, studio: &Studio) -> u64 {
    if !stand_in.kind.shows_leaves() {
        return studio.resident.card_triangles();
    }
    let groups = model.crown().plant().foliage().groups.iter();
    let of_group = |group: &LeafGroup| group.leaf_count() * group.prototype.triangles_per_leaf();
    groups.map(|group| of_group(group) as u64).sum()
}

/// A screen, of which only what the crown takes is drawn: so a picture's mean is over as much sky near
/// and far, while pixels are as large as on the whole screen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Screen {
    /// Rows.
    height: u32,
    /// Pixels in a metre at one metre.
    focal: f32,
    studio: StudioOptions,
}

impl Screen {
    pub(super) fn new(options: &StandInOptions) -> Self {
        let height = options.session.size.height();
        let half = 0.5 * options.field_of_view.to_radians();
        Self {
            height,
            focal: 0.5 * height as f32 / det::tan(half),
            studio: StudioOptions {
                side: 1,
                link: options.session.link,
                card: options.session.card,
                counters: Counters::Exact,
            },
        }
    }

    /// The radius of a sphere in pixels, the eye so many metres before it.
    fn radius(&self, sphere: Sphere, before: f32) -> f32 {
        // The tangent of the angle whose sine is radius / distance.
        self.focal * sphere.radius / (before * (before + 2.0 * sphere.radius)).sqrt()
    }

    /// How far before a sphere it has that radius.
    fn before(&self, sphere: Sphere, radius: f32) -> f32 {
        let tangent = self.focal / radius;
        sphere.radius * (tangent * tangent / (1.0 + (1.0 + tangent * tangent).sqrt()))
    }

    /// A camera before a sphere that may turn around it.
    pub(super) fn camera(
        &self,
        model: &dyn Model,
        sphere: Sphere,
        before: f32,
    ) -> Result<Camera, RunError> {
        // What has no size is looked at all the same.
        let sphere = Sphere {
            radius: sphere.radius.max(1e-3),
            ..sphere
        };
        let wanted = 2.0 * self.radius(sphere, before) / SPHERE_SHARE;
        let side = whole_u32(f64::from(wanted.ceil())).clamp(8, self.height.max(8));
        let studio = StudioOptions {
            side,
            ..self.studio
        };
        Ok(Camera {
            studio: Studio::new(model, &State::FINEST, &studio)?,
            sphere,
            before,
            tangent: 0.5 * side as f32 / self.focal,
        })
    }
}

/// What a screen shows of a model from a distance.
#[derive(Debug)]
pub(super) struct Camera {
    pub(super) studio: Studio,
    sphere: Sphere,
    before: f32,
    tangent: f32,
}

impl Camera {
    pub(super) fn shot(&mut self, direction: Vec3) -> Result<(Shot, Ledger), RunError> {
        let view = look_from(direction, self.sphere, self.before, self.tangent);
        let (target, ledger) = self.studio.draw(view)?;
        Ok((Shot::of(target), ledger))
    }
}
