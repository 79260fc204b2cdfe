//! What every foliage model is built from: leaves, their collapses, and the clusters.

use std::sync::{Arc, OnceLock};

use super::{FaceLeaves, LeafErrors, State};
use crate::math::{Aabb, Vec3, index_u32};
use crate::plant::Plant;
use crate::simplify::{Clusters, CollapseSequence, PlaneLevel, measure_leaves};

/// The quad leaves of a plant with their collapses, and its leaves of several faces; shared by all models
/// of it.
#[derive(Debug, Clone)]
pub struct Crown {
    plant: Arc<Plant>,
    vertices: Vec<Vec3>,
    sequence: CollapseSequence,
    clusters: Clusters,
    cluster_bounds: Vec<Aabb>,
    cluster_centers: Vec<Vec3>,
    bounds: Aabb,
    faces: FaceLeaves,
    errors: OnceLock<LeafErrors>,
    mean_leaf_area: OnceLock<f64>,
    planes: Option<PlaneLevel>,
}

impl Crown {
    /// The crown of a plant with a sequence over its quad leaves.
    ///
    /// # Panics
    ///
    /// When the sequence is not over this plant's quad leaves.
    #[must_use]
    pub fn new(plant: Arc<Plant>, sequence: CollapseSequence) -> Self {
        let mut vertices = plant.foliage().quad_vertices();
        assert_eq!(
            vertices.len(),
            4 * sequence.original_count() as usize,
            "the sequence is over the plant's quad leaves"
        );
        vertices.extend_from_slice(sequence.added_vertices());
        let clusters = Clusters::of(&sequence);
        let mut cluster_bounds = vec![Aabb::EMPTY; clusters.clusters.len()];
        for (corners, &cluster) in sequence.corners().iter().zip(&clusters.cluster_of_leaf) {
            let bounds = &mut cluster_bounds[cluster as usize];
            for &vertex in corners {
                *bounds = bounds.with(vertices[vertex as usize]);
            }
        }
        let cluster_centers = cluster_bounds.iter().map(Aabb::center).collect();
        let faces = FaceLeaves::of(plant.foliage(), index_u32(vertices.len()));
        let bounds = cluster_bounds
            .iter()
            .fold(faces.bounds(), |all, one| all.union(*one));
        Self {
            plant,
            vertices,
            sequence,
            clusters,
            cluster_bounds,
            cluster_centers,
            bounds,
            faces,
            errors: OnceLock::new(),
            mean_leaf_area: OnceLock::new(),
            planes: None,
        }
    }

    /// The same where the leaves are known to lie in these planes: impostors, if as many are asked for,
    /// stand there and need not look for them.
    #[must_use]
    pub fn in_planes(self, planes: PlaneLevel) -> Self {
        Self {
            planes: Some(planes),
            ..self
        }
    }

    /// The planes that leaves are [known to lie in](Self::in_planes).
    #[must_use]
    pub fn planes(&self) -> Option<&PlaneLevel> {
        self.planes.as_ref()
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &Arc<Plant> {
        &self.plant
    }

    /// All vertices, four a leaf that has its own: those of the original leaves, then those that
    /// collapses add.
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The vertices of the original leaves, four a leaf: the same whatever simplifies them.
    #[must_use]
    pub fn original_vertices(&self) -> &[Vec3] {
        &self.vertices[..4 * self.sequence.original_count() as usize]
    }

    /// The leaves of several faces, which no collapse changes.
    #[must_use]
    pub fn faces(&self) -> &FaceLeaves {
        &self.faces
    }

    /// The vertices of all leaves at full detail: [those of quads](Self::original_vertices), then those
    /// of leaves of several faces.
    #[must_use]
    pub fn leaf_points(&self) -> Vec<Vec3> {
        let foliage = self.plant.foliage();
        let faces = foliage
            .face_groups()
            .flat_map(|found| &found.group.positions);
        self.original_vertices()
            .iter()
            .chain(faces)
            .copied()
            .collect()
    }

    /// How many leaves show in a state, those of several faces too; none where cards show.
    #[must_use]
    pub fn shown_leaves(&self, state: &State) -> u64 {
        if matches!(state, State::Cards(_) | State::Strokes(_)) {
            return 0;
        }
        let quads = state.leaf_count(&self.clusters);
        u64::from(quads) + u64::from(self.faces.leaf_count())
    }

    /// How many triangles these leaves have: two a quad.
    #[must_use]
    pub fn shown_triangles(&self, state: &State) -> u64 {
        if matches!(state, State::Cards(_) | State::Strokes(_)) {
            return 0;
        }
        let quads = state.leaf_count(&self.clusters);
        2 * u64::from(quads) + u64::from(self.faces.face_count())
    }

    /// The collapses.
    #[must_use]
    pub fn sequence(&self) -> &CollapseSequence {
        &self.sequence
    }

    /// The clusters.
    #[must_use]
    pub fn clusters(&self) -> &Clusters {
        &self.clusters
    }

    /// The centre of each cluster's box, in the plant's space.
    #[must_use]
    pub fn cluster_centers(&self) -> &[Vec3] {
        &self.cluster_centers
    }

    /// The box of each cluster's leaves, old and new, in the plant's space. New leaves that take their
    /// corners from the originals add nothing to it; those with vertices of their own may.
    #[must_use]
    pub fn cluster_bounds(&self) -> &[Aabb] {
        &self.cluster_bounds
    }

    /// The box around all leaves, old and new, in the plant's space; also around those of several faces.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The centre of the box around all leaves, old and new, in the plant's space.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        self.bounds.center()
    }

    /// How far collapsed leaves lie from the originals; found when it is asked for first.
    #[must_use]
    pub fn errors(&self) -> &LeafErrors {
        let errors = || LeafErrors::of(&self.vertices, &self.sequence, &self.clusters);
        self.errors.get_or_init(errors)
    }

    /// The mean area of an original leaf in square metres of the plant's space; 0 without leaves.
    #[must_use]
    pub fn mean_leaf_area(&self) -> f64 {
        *self.mean_leaf_area.get_or_init(|| {
            let originals = 0..self.sequence.original_count();
            let measure = measure_leaves(&self.vertices, &self.sequence, originals);
            measure.area / f64::from(measure.leaves.max(1))
        })
    }

    /// The bytes of one leaf record: four vertex indices in the order of corner roles, 16 bytes,
    /// little-endian.
    #[must_use]
    pub fn record_bytes(&self, leaf: u32) -> [u8; 16] {
        let mut bytes = [0; 16];
        let corners = self.sequence.corners()[leaf as usize];
        for (four, corner) in bytes.chunks_exact_mut(4).zip(corners) {
            four.copy_from_slice(&corner.to_le_bytes());
        }
        bytes
    }

    /// The records of several leaves, one after another.
    pub fn records_bytes(&self, leaves: impl IntoIterator<Item = u32>) -> Vec<u8> {
        leaves
            .into_iter()
            .flat_map(|leaf| self.record_bytes(leaf))
            .collect()
    }

    /// The bytes of the vertices: three `f32` each, 12 bytes, little-endian.
    #[must_use]
    pub fn vertex_bytes(&self) -> Vec<u8> {
        self.vertices
            .iter()
            .flat_map(|v| v.to_array())
            .flat_map(f32::to_le_bytes)
            .collect()
    }
}
