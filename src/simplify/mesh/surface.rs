//! The mesh while it is simplified: points, their vertices, and the triangles around them.

use super::collapses::NEVER;
use super::quadric::Quadric;
use super::{EDGE_WEIGHT, LAST_TRIANGLES, LEAST_COSINE};
use crate::math::{DVec3, Vec3, index_u32};
use crate::plant::Mesh;

/// Points with the triangles that are left.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    mesh: &'a Mesh,
    /// Relative to the mean of all points.
    pub(super) points: Vec<DVec3>,
    pub(super) point_of: Vec<u32>,
    /// The vertices of each point, ascending.
    pub(super) vertices: Vec<Vec<u32>>,
    /// Vertices of the mesh.
    corners: Vec<[u32; 3]>,
    /// The points of the corners.
    triangles: Vec<[u32; 3]>,
    /// The triangles that are left at each point.
    around: Vec<Vec<u32>>,
    /// Whether some edge at a point has not two triangles.
    open: Vec<bool>,
    component: Vec<u32>,
    /// Triangles left in each component.
    left: Vec<u32>,
    pub(super) triangle_count: u32,
    /// Marks of points, by the number of the question that they answer.
    marks: Vec<u32>,
    question: u32,
}

/// What a collapse did.
#[derive(Debug)]
pub(super) struct Done {
    /// The triangles that went.
    pub(super) removed: Vec<u32>,
    /// Where each vertex of the point went, in the order of the vertices.
    pub(super) targets: Vec<u32>,
    /// How far the point is from what took its place, in metres.
    pub(super) distance: f64,
}

impl<'a> Surface<'a> {
    pub(super) fn new(mesh: &'a Mesh) -> Self {
        let (point_of, positions) = weld(&mesh.positions);
        let sum: DVec3 = positions.iter().sum();
        let center = sum / positions.len().max(1) as f64;
        let mut vertices = vec![Vec::new(); positions.len()];
        for (vertex, &point) in (0..).zip(&point_of) {
            vertices[point as usize].push(vertex);
        }
        let corners: Vec<[u32; 3]> = mesh.indices.as_chunks().0.to_vec();
        let triangles: Vec<[u32; 3]> = corners
            .iter()
            .map(|corners| corners.map(|vertex| point_of[vertex as usize]))
            .collect();
        let mut around = vec![Vec::new(); positions.len()];
        for (triangle, &points) in (0..).zip(&triangles) {
            if is_triangle(points) {
                for point in points {
                    around[point as usize].push(triangle);
                }
            }
        }
        let mut surface = Self {
            mesh,
            marks: vec![0; positions.len()],
            question: 0,
            open: vec![false; positions.len()],
            component: Vec::new(),
            left: Vec::new(),
            triangle_count: index_u32(triangles.iter().filter(|&&t| is_triangle(t)).count()),
            points: positions.into_iter().map(|point| point - center).collect(),
            point_of,
            vertices,
            corners,
            triangles,
            around,
        };
        surface.find_components();
        for point in 0..index_u32(surface.points.len()) {
            surface.open[point as usize] = surface.has_open_edge(point);
        }
        surface
    }

    fn find_components(&mut self) {
        const UNKNOWN: u32 = u32::MAX;
        self.component = vec![UNKNOWN; self.points.len()];
        let mut pending = Vec::new();
        for first in 0..index_u32(self.points.len()) {
            if self.component[first as usize] != UNKNOWN {
                continue;
            }
            let number = index_u32(self.left.len());
            let mut corners = 0;
            self.component[first as usize] = number;
            pending.push(first);
            while let Some(point) = pending.pop() {
                corners += index_u32(self.around[point as usize].len());
                for &triangle in &self.around[point as usize] {
                    for other in self.triangles[triangle as usize] {
                        if self.component[other as usize] == UNKNOWN {
                            self.component[other as usize] = number;
                            pending.push(other);
                        }
                    }
                }
            }
            self.left.push(corners / 3);
        }
    }

    fn has_open_edge(&self, point: u32) -> bool {
        let mut ends: Vec<u32> = self.others(point).collect();
        ends.sort_unstable();
        ends.chunk_by(|a, b| a == b).any(|same| same.len() != 2)
    }

    /// The other two corners of every triangle around a point.
    fn others(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let triangles = self.around[point as usize].iter();
        let corners = triangles.flat_map(|&triangle| self.triangles[triangle as usize]);
        corners.filter(move |&other| other != point)
    }

    /// The points that share a triangle with one, ascending.
    pub(super) fn neighbours(&self, point: u32, neighbours: &mut Vec<u32>) {
        neighbours.clear();
        neighbours.extend(self.others(point));
        neighbours.sort_unstable();
        neighbours.dedup();
    }

    /// The planes of each point: of its triangles, and across its open edges.
    ///
    /// An edge is open, too, where the two triangles on it use different vertices.
    pub(super) fn quadrics(&self) -> Vec<Quadric> {
        let mut quadrics = vec![Quadric::default(); self.points.len()];
        let mut edges = Vec::new();
        for (&points, corners) in self.triangles.iter().zip(&self.corners) {
            if !is_triangle(points) {
                continue;
            }
            let normal = self.normal(points);
            let length = normal.length();
            let unit = normal.try_normalize().unwrap_or(DVec3::ZERO);
            let plane = Quadric::plane(unit, self.points[points[0] as usize], length / 6.0);
            for (corner, &point) in points.iter().enumerate() {
                quadrics[point as usize].add(&plane);
                let next = (corner + 1) % 3;
                let (from, to) = (corners[corner], corners[next]);
                edges.push(([from.min(to), from.max(to)], [point, points[next]], unit));
            }
        }
        edges.sort_by_key(|edge| edge.0);
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            let [(_, [from, to], normal)] = *same else {
                continue;
            };
            let [from_at, to_at] = [from, to].map(|point| self.points[point as usize]);
            let edge = to_at - from_at;
            let across = edge.cross(normal).try_normalize().unwrap_or(DVec3::ZERO);
            let plane = Quadric::plane(across, from_at, EDGE_WEIGHT * edge.length_squared());
            for point in [from, to] {
                quadrics[point as usize].add(&plane);
            }
        }
        quadrics
    }

    /// The normal of a triangle, twice its area long.
    fn normal(&self, points: [u32; 3]) -> DVec3 {
        let [a, b, c] = points.map(|point| self.points[point as usize]);
        (b - a).cross(c - a)
    }

    /// By how much the area of the triangles around `u` changes when it goes to `v`, in square metres.
    pub(super) fn area_change(&self, u: u32, v: u32) -> f64 {
        let change = |sum: f64, &triangle: &u32| {
            let points = self.triangles[triangle as usize];
            let before = self.normal(points).length();
            let moved = points.map(|point| if point == u { v } else { point });
            let after = self.normal(moved).length();
            sum + 0.5 * (after - before)
        };
        self.around[u as usize].iter().fold(0.0, change).abs()
    }

    fn longest_edge(&self, triangles: &[u32]) -> f64 {
        let lengths = triangles.iter().flat_map(|&triangle| {
            let [a, b, c] = self.triangles[triangle as usize].map(|p| self.points[p as usize]);
            [a.distance(b), b.distance(c), c.distance(a)]
        });
        lengths.fold(0.0, f64::max)
    }

    /// Whether `u` may go to its neighbour `v`.
    pub(super) fn may_collapse(&mut self, u: u32, v: u32) -> bool {
        let is_last = self.left[self.component[u as usize] as usize] <= LAST_TRIANGLES;
        (is_last || self.keeps_topology(u, v)) && self.turns_little(u, v)
    }

    /// The link condition: `u` and `v` have no neighbours in common but those of the triangles between
    /// them, no such two are neighbours across from them, and no ends of the surface meet.
    fn keeps_topology(&mut self, u: u32, v: u32) -> bool {
        self.question += 2;
        let (near_u, between) = (self.question - 1, self.question);
        let mut shared = 0;
        for &triangle in &self.around[u as usize] {
            let points = self.triangles[triangle as usize];
            let is_between = points.contains(&v);
            shared += u32::from(is_between);
            for point in points {
                let mark = &mut self.marks[point as usize];
                *mark = if is_between {
                    between
                } else {
                    (*mark).max(near_u)
                };
            }
        }
        if shared == 2 && self.open[u as usize] && self.open[v as usize] {
            return false;
        }
        for &triangle in &self.around[v as usize] {
            let points = self.triangles[triangle as usize];
            if points.contains(&u) {
                continue;
            }
            let others = points.into_iter().filter(|&point| point != v);
            let mut both_between = true;
            for point in others {
                let mark = self.marks[point as usize];
                if mark == near_u {
                    return false;
                }
                both_between &= mark == between;
            }
            if both_between {
                return false;
            }
        }
        true
    }

    /// Whether no triangle that stays at `u` turns far or loses its area.
    fn turns_little(&self, u: u32, v: u32) -> bool {
        self.around[u as usize].iter().all(|&triangle| {
            let points = self.triangles[triangle as usize];
            if points.contains(&v) {
                return true;
            }
            let before = self.normal(points);
            let after = self.normal(points.map(|point| if point == u { v } else { point }));
            let lengths = before.length() * after.length();
            after != DVec3::ZERO && before.dot(after) >= LEAST_COSINE * lengths
        })
    }

    /// The triangles of the mesh that is simplified, by its vertices.
    pub(super) fn mesh_triangles(&self) -> impl Iterator<Item = [u32; 3]> + 'a {
        self.mesh.indices.as_chunks().0.iter().copied()
    }

    /// Moves `u` to `v`.
    pub(super) fn collapse(&mut self, u: u32, v: u32) -> Done {
        let targets = self.targets(u, v);
        let around = std::mem::take(&mut self.around[u as usize]);
        let mut removed = Vec::new();
        let mut distance = f64::INFINITY;
        for triangle in around {
            let points = self.triangles[triangle as usize];
            if points.contains(&v) {
                removed.push(triangle);
                for point in points.into_iter().filter(|&point| point != u) {
                    self.around[point as usize].retain(|&other| other != triangle);
                }
                continue;
            }
            let moved = points.map(|point| if point == u { v } else { point });
            self.triangles[triangle as usize] = moved;
            for corner in &mut self.corners[triangle as usize] {
                if let Ok(place) = self.vertices[u as usize].binary_search(corner) {
                    *corner = targets[place];
                }
            }
            self.around[v as usize].push(triangle);
            let [a, b, c] = moved.map(|point| self.points[point as usize]);
            distance = distance.min(to_triangle(self.points[u as usize], [a, b, c]));
        }
        if distance.is_infinite() {
            // With nothing in its place, surface went as far as its longest edge.
            distance = self.longest_edge(&removed);
        }
        self.open[v as usize] |= self.open[u as usize];
        let count = index_u32(removed.len());
        self.left[self.component[u as usize] as usize] -= count;
        self.triangle_count -= count;
        Done {
            removed,
            targets,
            distance,
        }
    }

    /// Where the vertices of `u` go: to one of `v` that they share a triangle with, the lowest of
    /// several; else to the one with the nearest texture coordinates and normal.
    fn targets(&self, u: u32, v: u32) -> Vec<u32> {
        let beside = |vertex: u32| {
            let triangles = self.around[u as usize].iter();
            let corners = triangles.map(|&triangle| self.corners[triangle as usize]);
            let with_both = corners.filter(|corners| corners.contains(&vertex));
            let others = with_both.flatten();
            others
                .filter(|&other| self.point_of[other as usize] == v)
                .min()
        };
        let likeness = |vertex: u32, other: u32| {
            let [one, two] = [vertex, other].map(|vertex| vertex as usize);
            let mesh = self.mesh;
            let across = mesh.texture_coordinates[one] - mesh.texture_coordinates[two];
            let turned = mesh.normals[one] - mesh.normals[two];
            across.as_dvec2().length_squared() + turned.as_dvec3().length_squared()
        };
        let nearest = |vertex: u32| {
            let others = self.vertices[v as usize].iter().copied();
            others.min_by(|&a, &b| likeness(vertex, a).total_cmp(&likeness(vertex, b)))
        };
        let target = |&vertex: &u32| {
            beside(vertex)
                .or_else(|| nearest(vertex))
                .expect("a point has a vertex")
        };
        self.vertices[u as usize].iter().map(target).collect()
    }
}

/// Whether three points are different.
fn is_triangle([a, b, c]: [u32; 3]) -> bool {
    a != b && b != c && c != a
}

/// The first level at which a triangle of the untouched mesh is gone.
pub(super) fn first_removal(points: [u32; 3]) -> u32 {
    if is_triangle(points) { NEVER } else { 0 }
}

/// The point of each vertex, numbered in the order of their first vertices, and where they are.
pub(super) fn weld(positions: &[Vec3]) -> (Vec<u32>, Vec<DVec3>) {
    // Zero has two signs and is one place.
    let bits = |vertex: u32| {
        let position = positions[vertex as usize] + Vec3::ZERO;
        position.to_array().map(f32::to_bits)
    };
    let mut order: Vec<u32> = (0..index_u32(positions.len())).collect();
    order.sort_unstable_by_key(|&vertex| (bits(vertex), vertex));
    let mut first = vec![0; positions.len()];
    for same in order.chunk_by(|&a, &b| bits(a) == bits(b)) {
        for &vertex in same {
            first[vertex as usize] = same[0];
        }
    }
    let mut points = Vec::new();
    let mut point_of: Vec<u32> = Vec::with_capacity(positions.len());
    for (vertex, &first) in (0..).zip(&first) {
        if first == vertex {
            point_of.push(index_u32(points.len()));
            points.push(positions[vertex as usize].as_dvec3());
        } else {
            point_of.push(point_of[first as usize]);
        }
    }
    (point_of, points)
}

/// The distance from a point to a triangle.
fn to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let beyond = |from: DVec3, to: DVec3| (to - from).cross(point - from).dot(normal) < 0.0;
    let edges = [(a, b), (b, c), (c, a)];
    if normal != DVec3::ZERO && !edges.iter().any(|&(from, to)| beyond(from, to)) {
        return (point - a).dot(normal).abs() / normal.length();
    }
    let distances = edges.map(|(from, to)| {
        let edge = to - from;
        let along = ((point - from).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE))
            .clamp(0.0, 1.0);
        point.distance(from + along * edge)
    });
    distances.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_triangle_are_to_its_face_edges_and_corners() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let distance = |x, y, z| to_triangle(DVec3::new(x, y, z), triangle);
        assert!((distance(0.2, 0.2, -3.0) - 3.0).abs() < 1e-12);
        assert!((distance(0.5, -2.0, 0.0) - 2.0).abs() < 1e-12);
        assert!((distance(4.0, 0.0, 4.0) - 5.0).abs() < 1e-12);
        assert!((to_triangle(DVec3::X, [DVec3::ZERO; 3]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn equal_positions_are_one_point_with_either_zero() {
        let positions = [Vec3::ONE, Vec3::ZERO, Vec3::ONE, Vec3::new(-0.0, 0.0, -0.0)];
        let (point_of, points) = weld(&positions);
        assert_eq!(point_of, [0, 1, 0, 1]);
        assert_eq!(points, [DVec3::ONE, DVec3::ZERO]);
    }
}
