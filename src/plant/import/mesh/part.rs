//! What a file keeps together.

use crate::math::{Vec2, Vec3, index_u32};

/// Triangles in a plant's space, without vertices that no triangle names.
#[derive(Debug, Clone)]
pub(in crate::plant) struct Part {
    /// Where the file has it.
    pub(in crate::plant) place: String,
    /// Its material among the file's.
    pub(in crate::plant) material: Option<usize>,
    /// Whether one of the names that the user gave applies.
    pub(in crate::plant) named: bool,
    /// Whether its material leaves out what is transparent.
    pub(in crate::plant) has_alpha: bool,
    /// Whether its material's name says that it is leaves.
    pub(in crate::plant) material_says: bool,
    /// Whether another name that it bears says so.
    pub(in crate::plant) name_says: bool,
    /// Where its vertices lie.
    pub(in crate::plant) positions: Vec<Vec3>,
    /// Unit normals, or zero where the file has none that can be used.
    pub(in crate::plant) normals: Vec<Vec3>,
    /// Texture coordinates, zero where the file has none.
    pub(in crate::plant) coordinates: Vec<Vec2>,
    /// Counter-clockwise seen from outside.
    pub(in crate::plant) triangles: Vec<[u32; 3]>,
}

impl Part {
    /// Keeps some of its triangles, and the vertices that these name.
    pub(super) fn keep(&mut self, triangles: Vec<[u32; 3]>) {
        let (vertices, triangles) = compact(triangles);
        let vertices = vertices.iter().map(|&vertex| vertex as usize);
        self.positions = vertices.clone().map(|v| self.positions[v]).collect();
        self.normals = vertices.clone().map(|v| self.normals[v]).collect();
        self.coordinates = vertices.map(|v| self.coordinates[v]).collect();
        self.triangles = triangles;
    }
}

/// The vertices that triangles name, ascending and each once, and the triangles by their places in this
/// list.
pub(in crate::plant) fn compact<T: Ord + Copy>(triangles: Vec<[T; 3]>) -> (Vec<T>, Vec<[u32; 3]>) {
    let mut vertices: Vec<T> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let place = |vertex: T| {
        let place = vertices.binary_search(&vertex);
        index_u32(place.expect("every vertex was collected"))
    };
    let triangles = triangles.into_iter().map(|corners| corners.map(place));
    let triangles = triangles.collect();
    (vertices, triangles)
}
