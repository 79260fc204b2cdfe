//! The order of collapses: always the cheapest that is left.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::VertexCollapseOptions;
use super::collapses::{VertexCollapse, VertexCollapses, lowest_first};
use super::quadric::Quadric;
use super::surface::{Surface, first_removal};
use crate::math::index_u32;
use crate::plant::Mesh;

/// A collapse that may be the next: `(bits of its cost, u, v, version of u)`. Costs are at least 0, so
/// their bits are ordered as they are.
type Candidate = Reverse<(u64, u32, u32, u32)>;

pub(super) fn collapse(mesh: &Mesh, options: VertexCollapseOptions) -> VertexCollapses {
    let mut sequence = Sequence::new(mesh);
    while sequence.surface.triangle_count > options.stop_triangles {
        let Some((u, v, cost)) = sequence.next() else {
            break;
        };
        sequence.collapse(u, v, cost);
    }
    sequence.finish()
}

struct Sequence<'a> {
    surface: Surface<'a>,
    quadrics: Vec<Quadric>,
    /// How far the surface at each point may be from that of full detail, in metres.
    errors: Vec<f64>,
    heap: BinaryHeap<Candidate>,
    /// Counts up when a point's candidate is another.
    versions: Vec<u32>,
    /// Vertices in the order in which they go, each with its target.
    gone: Vec<(u32, u32)>,
    starts: Vec<u32>,
    removal: Vec<u32>,
    steps: Vec<VertexCollapse>,
    neighbours: Vec<u32>,
    costs: Vec<(u64, u32)>,
}

impl<'a> Sequence<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let surface = Surface::new(mesh);
        let points = surface.points.len();
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        let removal = triangles
            .map(|corners| first_removal(corners.map(|vertex| surface.point_of[vertex as usize])));
        let mut sequence = Self {
            removal: removal.collect(),
            quadrics: surface.quadrics(),
            errors: vec![0.0; points],
            heap: BinaryHeap::with_capacity(points),
            versions: vec![0; points],
            gone: Vec::new(),
            starts: Vec::new(),
            steps: Vec::new(),
            neighbours: Vec::new(),
            costs: Vec::new(),
            surface,
        };
        for point in 0..index_u32(points) {
            sequence.look(point);
        }
        sequence
    }

    /// Puts the cheapest collapse of a point that is not refused into the heap.
    ///
    /// It stays what it is until a triangle around the point or a neighbour's quadric changes.
    fn look(&mut self, point: u32) {
        self.versions[point as usize] += 1;
        let mut neighbours = std::mem::take(&mut self.neighbours);
        self.surface.neighbours(point, &mut neighbours);
        let mut costs = std::mem::take(&mut self.costs);
        costs.clear();
        let ours = self.quadrics[point as usize];
        costs.extend(neighbours.iter().map(|&other| {
            let mut quadric = ours;
            quadric.add(&self.quadrics[other as usize]);
            let by_planes = quadric.at(self.surface.points[other as usize]);
            let area = self.surface.area_change(point, other);
            let cost = by_planes.max(area * area);
            (cost.to_bits(), other)
        }));
        costs.sort_unstable();
        let surface = &mut self.surface;
        let mut best = costs.iter().copied();
        if let Some((cost, other)) = best.find(|&(_, other)| surface.may_collapse(point, other)) {
            let version = self.versions[point as usize];
            self.heap.push(Reverse((cost, point, other, version)));
        }
        self.neighbours = neighbours;
        self.costs = costs;
    }

    fn next(&mut self) -> Option<(u32, u32, f64)> {
        loop {
            let Reverse((cost, u, v, version)) = self.heap.pop()?;
            if self.versions[u as usize] == version {
                return Some((u, v, f64::from_bits(cost)));
            }
        }
    }

    fn collapse(&mut self, u: u32, v: u32, cost: f64) {
        let mut around = Vec::new();
        self.surface.neighbours(u, &mut around);
        let done = self.surface.collapse(u, v);
        let level = index_u32(self.steps.len()) + 1;
        for &triangle in &done.removed {
            self.removal[triangle as usize] = level;
        }
        self.starts.push(index_u32(self.gone.len()));
        let vertices = self.surface.vertices[u as usize].iter().copied();
        self.gone.extend(vertices.zip(done.targets));
        let moved = self.errors[u as usize] + done.distance;
        let held = &mut self.errors[v as usize];
        *held = held.max(moved);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "metres, rounded once; what is beyond becomes infinite"
        )]
        let error = moved as f32;
        let before = self.steps.last().map_or(0.0, |step| step.error);
        self.steps.push(VertexCollapse {
            cost,
            error: error.max(before),
            triangles: index_u32(done.removed.len()),
        });
        let quadric = self.quadrics[u as usize];
        self.quadrics[v as usize].add(&quadric);
        // Nothing of a point that is gone counts any more.
        self.versions[u as usize] += 1;
        let mut beside = Vec::new();
        self.surface.neighbours(v, &mut beside);
        around.extend(beside);
        around.push(v);
        around.sort_unstable();
        around.dedup();
        for point in around {
            if point != u {
                self.look(point);
            }
        }
    }

    fn finish(mut self) -> VertexCollapses {
        let vertices = self.surface.point_of.len();
        self.starts.push(index_u32(self.gone.len()));
        let mut number = vec![u32::MAX; vertices];
        let mut order: Vec<u32> = self.gone.iter().map(|&(vertex, _)| vertex).collect();
        let mut stays = vec![true; vertices];
        for &vertex in &order {
            stays[vertex as usize] = false;
        }
        order.extend(
            (0..)
                .zip(&stays)
                .filter(|(_, stays)| **stays)
                .map(|(v, _): (u32, _)| v),
        );
        for (new, &old) in (0..).zip(&order) {
            number[old as usize] = new;
        }
        let renamed = |vertex: u32| number[vertex as usize];
        let targets = self.gone.iter().map(|&(_, target)| renamed(target));
        let corners = self.surface.mesh_triangles();
        VertexCollapses {
            target: targets.collect(),
            triangles: corners
                .map(|corners| lowest_first(corners.map(renamed)))
                .collect(),
            order,
            starts: self.starts,
            removal: self.removal,
            steps: self.steps,
        }
    }
}
