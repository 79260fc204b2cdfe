//! The compute program that selects: from the camera, or a state, to what every cluster of an instance
//! draws.
//!
//! A crown on the device, little-endian:
//!
//! | words | field | type |
//! |------:|-------|------|
//! | 0–2 | centre of the crown's box | 3 × `f32`, plant |
//! | 3 | original leaves | `u32` |
//! | 4 | clusters `G` | `u32` |
//! | 5–7 | how far vertices may be displaced along each axis | 3 × `f32`, plant |
//! | 8 + 8 g | collapses of the clusters before cluster `g` | `u32` |
//! | 9 + 8 g | original leaves of cluster `g` | `u32` |
//! | 10 + 8 g … | least, then greatest corner of its box | 6 × `f32`, plant |
//! | 8 + 8 G … | the global number of each collapse, cluster by cluster, ascending | `u32` each |
//!
//! The detail of an instance: its source ([`CAMERA`], [`VARIABLE`], or how many collapses of the sequence
//! are done), its number, and the collapses of each cluster for `VARIABLE`: `u32` each.
//!
//! Arithmetic is that of the host: [`collapses_at`] is called by both. It compares distances in `f64`,
//! which cards do more slowly than `f32`; that is not modelled.

use super::environment::{Camera, INSTANCE_SLOT, Placement, VIEW_SLOT, View};
use super::select::collapses_at;
use super::{Crown, Extent};
use crate::gpu::{Access, ComputeLayout, ComputeProgram, Group, IndirectRecord};
use crate::math::{Aabb, Mat4, Vec3, index_u32};

/// The source that says: by the camera.
pub(super) const CAMERA: u32 = u32::MAX - 1;
/// The source that says: every cluster has a count of its own.
pub(super) const VARIABLE: u32 = u32::MAX;

/// The slot of the camera.
pub(super) const CAMERA_SLOT: u32 = 2;
/// The slot of the crown.
pub(super) const CROWN_SLOT: u32 = 3;
/// The slot of the instance's detail.
pub(super) const DETAIL_SLOT: u32 = 4;
/// The slot of the collapses done in each cluster: written.
pub(super) const COLLAPSES_SLOT: u32 = 5;
/// The slot of the draw arguments: written.
pub(super) const ARGUMENT_SLOT: u32 = 6;

/// Clusters a group.
const GROUP_CLUSTERS: u32 = 64;
/// Words before the first cluster.
pub(super) const CROWN_WORDS: usize = 8;
/// Words a cluster.
pub(super) const CLUSTER_WORDS: usize = 8;

/// How many groups select for so many clusters.
pub(super) fn group_count(clusters: u32) -> u32 {
    clusters.div_ceil(GROUP_CLUSTERS)
}

/// How many bytes a crown has.
pub(super) fn crown_size(crown: &Crown) -> u64 {
    let (roots, collapses) = (
        crown.sequence().root_count(),
        crown.sequence().collapse_count(),
    );
    4 * (CROWN_WORDS as u64 + CLUSTER_WORDS as u64 * u64::from(roots) + u64::from(collapses))
}

/// A crown as the program reads it; vertices may be displaced by `step`.
pub(super) fn crown_bytes(crown: &Crown, step: Vec3) -> Vec<u8> {
    let sequence = crown.sequence();
    let mut words: Vec<u32> = crown.center().to_array().map(f32::to_bits).to_vec();
    words.extend([sequence.original_count(), sequence.root_count()]);
    words.extend(step.to_array().map(f32::to_bits));
    let clusters = &crown.clusters().clusters;
    let mut before = 0;
    for (cluster, bounds) in clusters.iter().zip(crown.cluster_bounds()) {
        words.extend([before, cluster.original_count()]);
        before += index_u32(cluster.ops.len());
        let corners = [bounds.min, bounds.max].map(|corner| corner.to_array());
        words.extend(corners.as_flattened().iter().map(|float| float.to_bits()));
    }
    words.extend(clusters.iter().flat_map(|cluster| &cluster.ops));
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct SelectPass;

impl ComputeProgram for SelectPass {
    fn layout(&self) -> ComputeLayout {
        const SLOTS: [Access; 7] = [
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Own {
                group_bytes: 4 * GROUP_CLUSTERS,
            },
            Access::Own {
                group_bytes: 16 * GROUP_CLUSTERS,
            },
        ];
        ComputeLayout {
            name: "select",
            version: 1,
            slots: &SLOTS,
            // A cluster: a distance and a division, 24 steps of a search, eight corners of a box
            // through two matrices against six planes.
            group_operations: GROUP_CLUSTERS * 1024,
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let crown = CROWN_SLOT as usize;
        let clusters = group.u32(crown, 4);
        let first = GROUP_CLUSTERS * group.number();
        let mut selection = Selection::read(group);
        for place in 0..GROUP_CLUSTERS.min(clusters.saturating_sub(first)) {
            let cluster = Cluster::read(group, first + place);
            let collapses = selection.collapses(group, &cluster, clusters);
            let shows = selection.may_show(&cluster.bounds);
            let records = 2 * cluster.originals - 1;
            let window = records.saturating_sub(2 * collapses);
            // Records before the cluster's own: two a collapse and a root, of each cluster before.
            let start = 2 * cluster.before + cluster.number;
            let arguments = IndirectRecord {
                corner_count: 4 * window,
                instances: u32::from(shows),
                first_corner: 4 * (start + records - window),
                instance: selection.instance,
            };
            group.set(COLLAPSES_SLOT as usize, place as usize, collapses);
            for (word, bytes) in arguments.to_bytes().as_chunks::<4>().0.iter().enumerate() {
                let at = 4 * place as usize + word;
                group.set(ARGUMENT_SLOT as usize, at, u32::from_le_bytes(*bytes));
            }
        }
    }
}

/// A cluster of the crown.
struct Cluster {
    number: u32,
    before: u32,
    originals: u32,
    bounds: Aabb,
}

impl Cluster {
    fn read(group: &mut Group<'_>, number: u32) -> Self {
        let first = CROWN_WORDS + CLUSTER_WORDS * number as usize;
        let [before, originals] = group.u32s(CROWN_SLOT as usize, first);
        let [a, b, c, d, e, f] = group.f32s(CROWN_SLOT as usize, first + 2);
        Self {
            number,
            before,
            originals: originals.max(1),
            bounds: Aabb {
                min: Vec3::new(a, b, c),
                max: Vec3::new(d, e, f),
            },
        }
    }

    /// How many of its collapses are among the first `done` of the sequence.
    fn collapses_after(&self, group: &mut Group<'_>, clusters: u32, done: u32) -> u32 {
        let ops = CROWN_WORDS + CLUSTER_WORDS * clusters as usize + self.before as usize;
        let (mut from, mut to) = (0, self.originals - 1);
        while from < to {
            let middle = from + (to - from) / 2;
            if group.u32(CROWN_SLOT as usize, ops + middle as usize) < done {
                from = middle + 1;
            } else {
                to = middle;
            }
        }
        from
    }
}

/// What a group knows of its instance.
struct Selection {
    source: u32,
    instance: u32,
    placement: Placement,
    clip_from_world: Mat4,
    /// How far vertices may be displaced.
    step: Vec3,
    /// For [`CAMERA`] and a uniform state: how far the sequence has gone.
    done: Option<u32>,
    camera: Camera,
}

impl Selection {
    fn read(group: &mut Group<'_>) -> Self {
        let [source, instance] = group.u32s(DETAIL_SLOT as usize, 0);
        let placement = group.f32s(INSTANCE_SLOT as usize, 8 * instance as usize);
        let placement = Placement::from_words(placement);
        let clip_from_world = View::read_matrix(group.f32s(VIEW_SLOT as usize, 0));
        // Read only where it decides.
        let camera = match source {
            CAMERA => Camera::from_words(group.u32s(CAMERA_SLOT as usize, 0)),
            _ => Camera::AT_ORIGIN,
        };
        let criterion = camera.criterion_for(&placement);
        let done = match (source, criterion.extent) {
            (VARIABLE, _) | (CAMERA, Extent::Variable) => None,
            (CAMERA, Extent::Uniform) => {
                let center = Vec3::from_array(group.f32s(CROWN_SLOT as usize, 0));
                let [originals, roots] = group.u32s(CROWN_SLOT as usize, 3);
                let eye = placement.to_plant(camera.eye);
                Some(collapses_at(criterion, eye, center, originals, roots))
            }
            (collapses, _) => Some(collapses),
        };
        Self {
            source,
            instance,
            placement,
            clip_from_world,
            step: Vec3::from_array(group.f32s(CROWN_SLOT as usize, 5)),
            done,
            camera,
        }
    }

    /// The collapses done in a cluster.
    fn collapses(&mut self, group: &mut Group<'_>, cluster: &Cluster, clusters: u32) -> u32 {
        match (self.done, self.source) {
            (Some(done), _) => cluster.collapses_after(group, clusters, done),
            (None, VARIABLE) => group.u32(DETAIL_SLOT as usize, 2 + cluster.number as usize),
            (None, _) => collapses_at(
                self.camera.criterion_for(&self.placement),
                self.placement.to_plant(self.camera.eye),
                cluster.bounds.center(),
                cluster.originals,
                1,
            ),
        }
    }

    fn may_show(&self, bounds: &Aabb) -> bool {
        let bounds = Aabb {
            min: bounds.min - self.step,
            max: bounds.max + self.step,
        };
        may_show(&self.clip_from_world, &self.placement, &bounds)
    }
}

/// Whether a placed box may show: `false` only if all of it lies outside of one plane of clip space, by
/// more than a vertex in it can be moved by rounding.
fn may_show(clip_from_world: &Mat4, placement: &Placement, bounds: &Aabb) -> bool {
    // A few roundings of numbers as large as these, each by 2⁻²⁴ at most; 2⁻¹⁶ leaves ample room.
    const ROUNDING: f32 = 1.0 / 65_536.0;
    let farthest = bounds.min.abs().max(bounds.max.abs()).length();
    let size = placement.position.abs() + Vec3::splat(placement.scale * farthest);
    let rows = [0, 1, 2, 3].map(|row| clip_from_world.row(row));
    let room = rows.map(|row| ROUNDING * (row.truncate().abs().dot(size) + row.w.abs()));
    let [x_room, y_room, z_room, w_room] = room;
    // Inside is where all six are at least 0.
    let mut outside = [true; 6];
    for corner in 0..8 {
        let pick = |axis: usize| {
            if corner >> axis & 1 == 0 {
                bounds.min[axis]
            } else {
                bounds.max[axis]
            }
        };
        let point = placement.to_world(Vec3::new(pick(0), pick(1), pick(2)));
        let [x, y, z, w] = rows.map(|row| row.truncate().dot(point) + row.w);
        let insides = [
            w + x + w_room + x_room,
            w - x + w_room + x_room,
            w + y + w_room + y_room,
            w - y + w_room + y_room,
            z + z_room,
            w - z + w_room + z_room,
        ];
        for (all, inside) in outside.iter_mut().zip(insides) {
            // What is no number is drawn.
            *all &= inside < 0.0;
        }
    }
    !outside.contains(&true)
}
