//! What every foliage model is built from: leaves, their collapses, and the clusters.

use std::sync::Arc;

use crate::math::{Aabb, Vec3};
use crate::plant::Plant;
use crate::simplify::{Clusters, CollapseSequence};

/// The quad leaves of a plant with their collapses; shared by all models of it.
#[derive(Debug, Clone)]
pub struct Crown {
    plant: Arc<Plant>,
    vertices: Vec<Vec3>,
    sequence: CollapseSequence,
    clusters: Clusters,
    cluster_centers: Vec<Vec3>,
    center: Vec3,
}

impl Crown {
    /// The crown of a plant with a sequence over its quad leaves.
    ///
    /// # Panics
    ///
    /// When the sequence is not over this plant's quad leaves.
    #[must_use]
    pub fn new(plant: Arc<Plant>, sequence: CollapseSequence) -> Self {
        let vertices = plant.foliage().quad_vertices();
        assert_eq!(
            vertices.len(),
            4 * sequence.original_count() as usize,
            "the sequence is over the plant's quad leaves"
        );
        let clusters = Clusters::of(&sequence);
        let mut bounds = vec![Aabb::EMPTY; clusters.clusters.len()];
        for (corners, &cluster) in sequence.corners().iter().zip(&clusters.cluster_of_leaf) {
            let bounds = &mut bounds[cluster as usize];
            for &vertex in corners {
                *bounds = bounds.with(vertices[vertex as usize]);
            }
        }
        let cluster_centers = bounds.iter().map(Aabb::center).collect();
        let center = bounds
            .iter()
            .fold(Aabb::EMPTY, |all, one| all.union(*one))
            .center();
        Self {
            plant,
            vertices,
            sequence,
            clusters,
            cluster_centers,
            center,
        }
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &Arc<Plant> {
        &self.plant
    }

    /// The vertices of the original leaves, four a leaf.
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
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

    /// The centre of the box around all leaves, in the plant's space.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        self.center
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
