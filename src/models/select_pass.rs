//! The compute program that selects: from the camera, or a state, to what every cluster of the
//! instances of a species draws.
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
//! are done), its number, and the collapses of each cluster for `VARIABLE`: `u32` each. Instances of a
//! species lie one behind another in *rooms* numbered from 0, and so do the clusters of all of them,
//! `G` a room: what is computed for cluster `g` of room `r` has place `G r + g` in its buffer, and
//! corners of room `r` count from `4 R r` on, for `R` records of a species.
//!
//! Arithmetic is that of the host: [`collapses_at`] is called by both. It compares distances in `f64`,
//! which cards do more slowly than `f32`; that is not modelled.

use super::clip_box::ClipBox;
use super::environment::{Camera, INSTANCE_SLOT, Placement, VIEW_SLOT, View};
use super::select::collapses_at;
use super::{Crown, Extent, Occlusion};
use crate::gpu::{Access, ComputeLayout, ComputeProgram, Group, IndirectRecord, Words};
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

/// With [two phases](Occlusion::TwoPhase): the slot of what was seen last time, of which alone
/// arguments are then written.
pub(super) const SEEN_SLOT: u32 = 7;

/// Clusters a group.
pub(super) const GROUP_CLUSTERS: u32 = 64;
/// Words before the first cluster.
pub(super) const CROWN_WORDS: usize = 8;
/// Words a cluster.
pub(super) const CLUSTER_WORDS: usize = 8;

/// How many groups select for so many clusters of all instances.
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
pub(super) struct SelectPass(pub(super) Occlusion);

impl ComputeProgram for SelectPass {
    fn layout(&self) -> ComputeLayout {
        const SLOTS: [Access; 8] = [
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
            Access::Recall,
        ];
        let (name, slots) = match self.0 {
            Occlusion::None => ("select", &SLOTS[..SEEN_SLOT as usize]),
            Occlusion::TwoPhase => ("select-seen", &SLOTS[..]),
        };
        ComputeLayout {
            name,
            version: 2,
            slots,
            // A cluster: a distance and a division, 24 steps of a search, eight corners of a box
            // through two matrices against six planes.
            group_operations: GROUP_CLUSTERS * 1024,
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let clusters = cluster_count(group);
        let records_each = 2 * group.u32(CROWN_SLOT as usize, 3) - clusters;
        let mut selection: Option<Selection> = None;
        for number in 0..group.len(COLLAPSES_SLOT as usize) {
            let place = Place::of(group, number, clusters);
            let mut selected = match selection.take() {
                Some(selection) if selection.place.room == place.room => selection,
                _ => Selection::read(group, place),
            };
            let cluster = Cluster::read(group, place.cluster);
            let collapses = selected.collapses(group, &cluster);
            let first = match self.0 {
                Occlusion::None => true,
                Occlusion::TwoPhase => group.u32(SEEN_SLOT as usize, place.word()) != 0,
            };
            let shows = first && selected.may_show(&cluster);
            let records = 2 * cluster.originals - 1;
            let window = records.saturating_sub(2 * collapses);
            // Records before the cluster's own: two a collapse and a root, of each cluster before.
            let start = place.room * records_each + 2 * cluster.before + cluster.number;
            let arguments = IndirectRecord {
                corner_count: 4 * window,
                instances: u32::from(shows),
                first_corner: 4 * (start + records - window),
                instance: selected.instance,
            };
            selection = Some(selected);
            group.set(COLLAPSES_SLOT as usize, number, collapses);
            for (word, bytes) in arguments.to_bytes().as_chunks::<4>().0.iter().enumerate() {
                let at = 4 * number + word;
                group.set(ARGUMENT_SLOT as usize, at, u32::from_le_bytes(*bytes));
            }
        }
    }
}

/// How many clusters an instance has.
pub(super) fn cluster_count(group: &mut Group<'_>) -> u32 {
    group.u32(CROWN_SLOT as usize, 4)
}

/// The same where a draw has the crown bound.
pub(super) fn crown_cluster_count(crown: Words<'_>) -> u32 {
    crown.u32(4)
}

/// How far vertices may be displaced along each axis.
pub(super) fn step(group: &mut Group<'_>) -> Vec3 {
    Vec3::from_array(group.f32s(CROWN_SLOT as usize, 5))
}

/// Which cluster of which instance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// The instance's room.
    pub(super) room: u32,
    pub(super) cluster: u32,
    /// Clusters a room, above 0.
    clusters: u32,
}

impl Place {
    /// That of a cluster that a group owns, counted from its first, with so many an instance.
    pub(super) fn of(group: &Group<'_>, number: usize, clusters: u32) -> Self {
        let clusters = clusters.max(1);
        let word = GROUP_CLUSTERS * group.number() + index_u32(number);
        Self {
            room: word / clusters,
            cluster: word % clusters,
            clusters,
        }
    }

    /// Its place among the clusters of all instances.
    pub(super) fn word(self) -> usize {
        self.clusters as usize * self.room as usize + self.cluster as usize
    }

    /// The first word of its instance's detail.
    pub(super) fn detail(self) -> usize {
        (2 + self.clusters as usize) * self.room as usize
    }
}

/// A cluster of the crown.
pub(super) struct Cluster {
    number: u32,
    before: u32,
    originals: u32,
    bounds: Aabb,
}

impl Cluster {
    pub(super) fn read(group: &mut Group<'_>, number: u32) -> Self {
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

    /// Its box, where vertices may be displaced by `step`.
    pub(super) fn displaced(&self, step: Vec3) -> Aabb {
        Aabb {
            min: self.bounds.min - step,
            max: self.bounds.max + step,
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
    /// That of any of its clusters.
    place: Place,
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
    fn read(group: &mut Group<'_>, place: Place) -> Self {
        let [source, instance] = group.u32s(DETAIL_SLOT as usize, place.detail());
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
            place,
            source,
            instance,
            placement,
            clip_from_world,
            step: step(group),
            done,
            camera,
        }
    }

    /// The collapses done in a cluster.
    fn collapses(&mut self, group: &mut Group<'_>, cluster: &Cluster) -> u32 {
        match (self.done, self.source) {
            (Some(done), _) => cluster.collapses_after(group, self.place.clusters, done),
            (None, VARIABLE) => {
                let first = self.place.detail() + 2;
                group.u32(DETAIL_SLOT as usize, first + cluster.number as usize)
            }
            (None, _) => collapses_at(
                self.camera.criterion_for(&self.placement),
                self.placement.to_plant(self.camera.eye),
                cluster.bounds.center(),
                cluster.originals,
                1,
            ),
        }
    }

    fn may_show(&self, cluster: &Cluster) -> bool {
        let bounds = cluster.displaced(self.step);
        !ClipBox::new(&self.clip_from_world, &self.placement, &bounds).is_out_of_sight()
    }
}
