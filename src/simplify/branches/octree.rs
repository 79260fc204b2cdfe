//! An octree of points that come and go, searched for what is nearest by a metric of the caller's.

use crate::math::{Aabb, Vec3, index_u32};

/// How many points a leaf holds before it is divided.
const LEAF: usize = 12;

/// How often a cell is divided at most; points at the same place stay together.
const DEPTH: u32 = 20;

/// Numbered points in a cube.
#[derive(Debug, Clone)]
pub(super) struct Octree {
    cells: Vec<Cell>,
}

#[derive(Debug, Clone)]
struct Cell {
    bounds: Aabb,
    /// How many points lie in it.
    count: u32,
    depth: u32,
    inside: Inside,
}

#[derive(Debug, Clone)]
enum Inside {
    Points(Vec<(u32, Vec3)>),
    /// The first of eight cells.
    Cells(u32),
}

impl Octree {
    /// An octree for points in a box.
    pub(super) fn new(bounds: Aabb) -> Self {
        let cell = Cell {
            bounds,
            count: 0,
            depth: 0,
            inside: Inside::Points(Vec::new()),
        };
        Self { cells: vec![cell] }
    }

    /// Adds a point of the box.
    pub(super) fn insert(&mut self, number: u32, point: Vec3) {
        let mut cell = 0;
        loop {
            self.cells[cell].count += 1;
            let (bounds, depth) = (self.cells[cell].bounds, self.cells[cell].depth);
            match &mut self.cells[cell].inside {
                Inside::Cells(first) => cell = (*first + octant(&bounds, point)) as usize,
                Inside::Points(points) => {
                    points.push((number, point));
                    if points.len() > LEAF && depth < DEPTH {
                        self.divide(cell);
                    }
                    return;
                }
            }
        }
    }

    /// Takes a point out.
    pub(super) fn remove(&mut self, number: u32, point: Vec3) {
        let mut cell = 0;
        loop {
            self.cells[cell].count -= 1;
            let bounds = self.cells[cell].bounds;
            match &mut self.cells[cell].inside {
                Inside::Cells(first) => cell = (*first + octant(&bounds, point)) as usize,
                Inside::Points(points) => {
                    points.retain(|&(other, _)| other != number);
                    return;
                }
            }
        }
    }

    fn divide(&mut self, cell: usize) {
        let first = index_u32(self.cells.len());
        let (bounds, depth) = (self.cells[cell].bounds, self.cells[cell].depth);
        let middle = bounds.center();
        for octant in 0..8_u32 {
            let above = |bit: u32| octant >> bit & 1 == 1;
            let pick = |bit: u32, low: f32, middle: f32, high: f32| {
                if above(bit) {
                    (middle, high)
                } else {
                    (low, middle)
                }
            };
            let (x0, x1) = pick(0, bounds.min.x, middle.x, bounds.max.x);
            let (y0, y1) = pick(1, bounds.min.y, middle.y, bounds.max.y);
            let (z0, z1) = pick(2, bounds.min.z, middle.z, bounds.max.z);
            self.cells.push(Cell {
                bounds: Aabb {
                    min: Vec3::new(x0, y0, z0),
                    max: Vec3::new(x1, y1, z1),
                },
                count: 0,
                depth: depth + 1,
                inside: Inside::Points(Vec::new()),
            });
        }
        let inside = std::mem::replace(&mut self.cells[cell].inside, Inside::Cells(first));
        if let Inside::Points(points) = inside {
            for (number, point) in points {
                let child = &mut self.cells[(first + octant(&bounds, point)) as usize];
                child.count += 1;
                if let Inside::Points(points) = &mut child.inside {
                    points.push((number, point));
                }
            }
        }
    }

    /// The point of the least value, with it; of equals that with the least number.
    ///
    /// `value` may refuse a point that is not below the best so far, which it is told; `bound` tells
    /// what no point as far away as that is below.
    pub(super) fn nearest(
        &self,
        point: Vec3,
        bound: impl Fn(f32) -> f32,
        value: impl Fn(u32, f32) -> Option<f32>,
    ) -> Option<(f32, u32)> {
        let mut best: Option<(f32, u32)> = None;
        // Cells whose bound is known, the nearest last.
        let mut open: Vec<(f32, u32)> = vec![(bound(0.0), 0)];
        let mut children = [(0.0_f32, 0_u32); 8];
        while let Some((least, cell)) = open.pop() {
            let worst = best.map_or(f32::INFINITY, |(value, _)| value);
            if least > worst {
                continue;
            }
            match &self.cells[cell as usize].inside {
                Inside::Points(points) => {
                    for &(number, _) in points {
                        let worst = best.map_or(f32::INFINITY, |(value, _)| value);
                        let Some(found) = value(number, worst) else {
                            continue;
                        };
                        if best.is_none_or(|best| (found, number) < best) {
                            best = Some((found, number));
                        }
                    }
                }
                Inside::Cells(first) => {
                    let mut count = 0;
                    for child in *first..*first + 8 {
                        let cell = &self.cells[child as usize];
                        if cell.count > 0 {
                            children[count] = (bound(cell.bounds.distance(point)), child);
                            count += 1;
                        }
                    }
                    let children = &mut children[..count];
                    children.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
                    open.extend(children.iter().filter(|child| child.0 <= worst));
                }
            }
        }
        best
    }
}

/// Which eighth of a box a point lies in.
fn octant(bounds: &Aabb, point: Vec3) -> u32 {
    let middle = bounds.center();
    let bit = |above: bool, bit: u32| u32::from(above) << bit;
    bit(point.x >= middle.x, 0) | bit(point.y >= middle.y, 1) | bit(point.z >= middle.z, 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, index_usize};

    #[test]
    fn the_nearest_is_found_as_points_come_and_go() {
        let mut draws = Stream::new(2, 0).draws();
        let points: Vec<Vec3> = (0..600)
            .map(|number| match number % 7 {
                // Some at one place.
                0 => Vec3::splat(0.25),
                _ => Vec3::new(draws.unit(), draws.unit(), draws.unit()),
            })
            .collect();
        let mut tree = Octree::new(Aabb::of(points.iter().copied()));
        let mut there: Vec<u32> = Vec::new();
        for number in 0..600_u32 {
            tree.insert(number, points[number as usize]);
            there.push(number);
            if number % 3 == 2 {
                let gone = there.swap_remove(index_usize(draws.below(there.len() as u64)));
                tree.remove(gone, points[gone as usize]);
            }
            let from = Vec3::new(draws.unit(), draws.unit(), draws.unit());
            let distance = |number: u32| from.distance(points[number as usize]);
            let found = tree.nearest(from, |far| far, |number, _| Some(distance(number)));
            let wanted = there.iter().map(|&number| (distance(number), number));
            let wanted = wanted.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert_eq!(found, wanted);
        }
        assert_eq!(tree.nearest(Vec3::ZERO, |far| far, |_, _| None), None);
    }
}
