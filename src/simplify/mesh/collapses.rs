//! The common product of mesh simplification: vertex collapses in order, with replay.

use crate::math::index_u32;
use crate::plant::Mesh;

/// Collapses of the points of a mesh, each onto another that stays.
///
/// A point is a position; where surfaces that look different meet, several vertices share it, and a
/// collapse moves all of them at once. Vertices are renumbered in the order in which they go: those
/// that the first collapse removes come first, those that stay last. So after `c` collapses the
/// vertices below [`first_vertex`](Self::first_vertex)`(c)` are gone, and the
/// [target](Self::target) of each, to which its triangles' corners move, has a higher number.
#[derive(Debug, Clone, PartialEq)]
pub struct VertexCollapses {
    pub(super) order: Vec<u32>,
    pub(super) target: Vec<u32>,
    /// One a collapse, and the number of vertices that go at all.
    pub(super) starts: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) removal: Vec<u32>,
    pub(super) steps: Vec<VertexCollapse>,
}

/// One collapse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexCollapse {
    /// What the simplifier paid: squared metres of distance times square metres of surface.
    pub cost: f64,
    /// How far the surface after this collapse is from that of full detail, in metres; never less
    /// than after the collapse before. What exactly is meant, the simplifier says.
    pub error: f32,
    /// Triangles that go.
    pub triangles: u32,
}

/// The removal of a triangle that stays to the end.
pub(super) const NEVER: u32 = u32::MAX;

impl VertexCollapses {
    /// How many collapses there are.
    #[must_use]
    pub fn collapse_count(&self) -> u32 {
        index_u32(self.steps.len())
    }

    /// How many vertices there are at full detail.
    #[must_use]
    pub fn vertex_count(&self) -> u32 {
        index_u32(self.order.len())
    }

    /// The collapses in order.
    #[must_use]
    pub fn steps(&self) -> &[VertexCollapse] {
        &self.steps
    }

    /// The vertices in the order of the new numbers, by their numbers in the mesh.
    #[must_use]
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// How many vertices are gone after so many collapses: all below this number.
    ///
    /// # Panics
    ///
    /// When there are not so many collapses.
    #[must_use]
    pub fn first_vertex(&self, collapses: u32) -> u32 {
        self.starts[collapses as usize]
    }

    /// Where a vertex that goes moves to: a vertex with a higher number. `None` for those that stay.
    #[must_use]
    pub fn target(&self, vertex: u32) -> Option<u32> {
        self.target.get(vertex as usize).copied()
    }

    /// The collapse by which a vertex goes, from 0; `None` for those that stay.
    #[must_use]
    pub fn collapse_of(&self, vertex: u32) -> Option<u32> {
        let begun = self.starts.partition_point(|&start| start <= vertex);
        (begun < self.starts.len()).then(|| index_u32(begun) - 1)
    }

    /// The triangles of the mesh at full detail, in its order, by new numbers, the lowest first.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Whether a triangle is there after so many collapses: whether its corners are three points.
    #[must_use]
    pub fn shows(&self, triangle: u32, collapses: u32) -> bool {
        collapses < self.removal[triangle as usize]
    }

    /// The first level at which a triangle is gone: 0 if two of its corners are one point at full
    /// detail already. `None` if it stays to the end.
    #[must_use]
    pub fn removal(&self, triangle: u32) -> Option<u32> {
        let level = self.removal[triangle as usize];
        (level != NEVER).then_some(level)
    }

    /// Where a vertex is after so many collapses.
    #[must_use]
    pub fn moved(&self, vertex: u32, collapses: u32) -> u32 {
        let first = self.first_vertex(collapses);
        let mut vertex = vertex;
        while vertex < first {
            vertex = self.target[vertex as usize];
        }
        vertex
    }

    /// The corners of a triangle after so many collapses, the lowest first.
    #[must_use]
    pub fn corners(&self, triangle: u32, collapses: u32) -> [u32; 3] {
        let corners = self.triangles[triangle as usize];
        lowest_first(corners.map(|vertex| self.moved(vertex, collapses)))
    }

    /// The triangles that are there after so many collapses, with their numbers: the truth that every
    /// model is held against.
    pub fn triangles_after(&self, collapses: u32) -> impl Iterator<Item = (u32, [u32; 3])> + '_ {
        let all = 0..index_u32(self.triangles.len());
        let shown = all.filter(move |&triangle| self.shows(triangle, collapses));
        shown.map(move |triangle| (triangle, self.corners(triangle, collapses)))
    }

    /// How many triangles there are after each number of collapses, from 0 to all.
    #[must_use]
    pub fn triangle_counts(&self) -> Vec<u32> {
        let there = self.removal.iter().filter(|&&level| level > 0).count();
        let mut counts = vec![index_u32(there)];
        let mut left = index_u32(there);
        for step in &self.steps {
            left -= step.triangles;
            counts.push(left);
        }
        counts
    }

    /// The mesh after so many collapses, with all vertices of full detail in the order of the new
    /// numbers; `mesh` is the one that was simplified.
    ///
    /// # Panics
    ///
    /// When it is another one.
    #[must_use]
    pub fn mesh_after(&self, mesh: &Mesh, collapses: u32) -> Mesh {
        let order = || self.order.iter().map(|&vertex| vertex as usize);
        let triangles = self.triangles_after(collapses);
        Mesh {
            positions: order().map(|vertex| mesh.positions[vertex]).collect(),
            normals: order().map(|vertex| mesh.normals[vertex]).collect(),
            texture_coordinates: order()
                .map(|vertex| mesh.texture_coordinates[vertex])
                .collect(),
            indices: triangles.flat_map(|(_, corners)| corners).collect(),
            material: mesh.material.clone(),
        }
    }
}

/// A triangle turned, its winding kept, so that its lowest corner comes first.
#[must_use]
pub fn lowest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
