//! Convex hulls of grid points, exact: quickhull where they fill space, and what is left of it in a
//! plane, on a line and at a point.
//!
//! ```text
//!        p ·            the facets that p sees (strictly) go; each edge
//!         ╱ ╲           between one that goes and one that stays, the
//!     ───╱───╲───       horizon, gets a facet with p; what lay outside the
//!       │ hull │        facets that went is outside a new one, or inside
//! ```
//!
//! A point in the plane of a facet does not see it, so flat faces are several triangles, and a corner
//! of one may lie within a face or an edge of the hull. Only the *extreme* points are reported, which
//! are convex combinations of no others: those where three edges or more meet at which the hull bends.
//! As sets they depend on neither the order of the points nor that of the steps.

use std::collections::VecDeque;

use super::flat::{ends_of_line, polygon};
use super::grid::{Grid, Plane, minus};
use crate::math::index_u32;

/// No point, no facet.
const NONE: u32 = u32::MAX;

/// The smallest affine space that holds all points, named by points that span it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Span {
    Point,
    Line,
    Plane([u32; 3]),
    Space([u32; 4]),
}

/// Finds hulls; keeps its memory from one to the next.
#[derive(Debug)]
pub(super) struct HullFinder<'a> {
    grid: &'a Grid,
    facets: Vec<Facet>,
    queue: VecDeque<u32>,
    /// The next point outside the same facet, by point.
    next: Vec<u32>,
    /// The facet of the horizon that begins at a point.
    begins: Vec<u32>,
    /// How many edges at which the hull bends end at a point; 3 stands for more.
    bends: Vec<u8>,
}

/// A triangle of the hull, counter-clockwise seen from outside.
#[derive(Debug, Clone)]
struct Facet {
    corners: [u32; 3],
    /// The facets beyond the edges from each corner to the next.
    neighbors: [u32; 3],
    plane: Plane,
    /// The first of the points outside, [`NONE`] when there is none.
    outside: u32,
    /// The furthest of them, and how far.
    furthest: (u32, f64),
    /// Whether it is one of the hull's still.
    stands: bool,
}

impl<'a> HullFinder<'a> {
    pub(super) fn new(grid: &'a Grid) -> Self {
        let points = grid.len();
        Self {
            grid,
            facets: Vec::new(),
            queue: VecDeque::new(),
            next: vec![NONE; points],
            begins: vec![NONE; points],
            bends: vec![0; points],
        }
    }

    /// The extreme points of some distinct points, ascending.
    pub(super) fn extremes(&mut self, points: &[u32]) -> Vec<u32> {
        let mut extremes = match self.span(points) {
            Span::Point => points.iter().take(1).copied().collect(),
            Span::Line => ends_of_line(points),
            Span::Plane(corners) => polygon(self.grid, corners, points),
            Span::Space(simplex) => {
                self.wrap(simplex, points);
                self.corners_of_bends()
            }
        };
        extremes.sort_unstable();
        extremes
    }

    /// The triangles of the hull of some distinct points, counter-clockwise seen from outside; none
    /// where they lie in a plane.
    #[cfg(test)]
    pub(super) fn triangles(&mut self, points: &[u32]) -> Vec<[u32; 3]> {
        let Span::Space(simplex) = self.span(points) else {
            return Vec::new();
        };
        self.wrap(simplex, points);
        let standing = self.facets.iter().filter(|facet| facet.stands);
        standing.map(|facet| facet.corners).collect()
    }

    /// Points that are far from each other, from the line through two, from the plane through three;
    /// where rounding finds none, integers look again.
    fn span(&self, points: &[u32]) -> Span {
        let Some(&first) = points.first() else {
            return Span::Point;
        };
        let from_first = |point: u32| minus(self.grid.at(point), self.grid.at(first));
        let distance = |point: u32| {
            let [x, y, z] = from_first(point);
            x * x + y * y + z * z
        };
        let second = furthest(points, distance);
        if second == first {
            return Span::Point;
        }
        let edge = from_first(second);
        let from_line = |point: u32| {
            let [x, y, z] = cross(edge, from_first(point));
            x * x + y * y + z * z
        };
        let off_line = |point: &u32| self.grid.exact_normal([first, second, *point]) != [0; 3];
        let third = Some(furthest(points, from_line)).filter(off_line);
        let Some(third) = third.or_else(|| points.iter().copied().find(off_line)) else {
            return Span::Line;
        };
        let corners = [first, second, third];
        let plane = self.grid.plane(corners);
        let from_plane = |point: u32| plane.height(self.grid.at(point)).abs();
        let off_plane = |point: &u32| self.grid.side(corners, *point).is_ne();
        let fourth = Some(furthest(points, from_plane)).filter(off_plane);
        match fourth.or_else(|| points.iter().copied().find(off_plane)) {
            None => Span::Plane(corners),
            Some(fourth) => Span::Space([first, second, third, fourth]),
        }
    }

    /// Builds the hull, from a simplex outwards.
    fn wrap(&mut self, simplex: [u32; 4], points: &[u32]) {
        self.facets.clear();
        self.queue.clear();
        let [a, mut b, mut c, d] = simplex;
        if self.grid.side([a, b, c], d).is_gt() {
            (b, c) = (c, b);
        }
        self.add([a, b, c], [1, 2, 3]);
        self.add([b, a, d], [0, 3, 2]);
        self.add([c, b, d], [0, 1, 3]);
        self.add([a, c, d], [0, 2, 1]);
        for &point in points {
            self.place(point, 0);
        }
        self.queue.extend(0..4);
        let (mut seen, mut horizon) = (Vec::new(), Vec::new());
        while let Some(facet) = self.queue.pop_front() {
            let Facet {
                stands,
                furthest: (point, _),
                ..
            } = self.facets[facet as usize];
            if stands && point != NONE {
                self.look(facet, point, &mut seen, &mut horizon);
                self.extend(point, &seen, &horizon);
            }
        }
    }

    fn add(&mut self, corners: [u32; 3], neighbors: [u32; 3]) {
        self.facets.push(Facet {
            corners,
            neighbors,
            plane: self.grid.plane(corners),
            outside: NONE,
            furthest: (NONE, 0.0),
            stands: true,
        });
    }

    /// How far a point is above a facet, if it is.
    #[inline]
    fn above(&self, facet: &Facet, point: u32) -> Option<f64> {
        let height = facet.plane.height(self.grid.at(point));
        if height > facet.plane.slack {
            return Some(height);
        }
        let is_above =
            height >= -facet.plane.slack && self.grid.exact_side(facet.corners, point).is_gt();
        is_above.then_some(height)
    }

    /// Puts a point outside the first facet, from `first` on, that it is above, if there is one.
    #[inline]
    fn place(&mut self, point: u32, first: usize) {
        let mut facets = first..self.facets.len();
        let found = facets.find_map(|facet| {
            let height = self.above(&self.facets[facet], point)?;
            Some((facet, height))
        });
        if let Some((facet, height)) = found {
            let facet = &mut self.facets[facet];
            self.next[point as usize] = facet.outside;
            facet.outside = point;
            if facet.furthest.0 == NONE || height > facet.furthest.1 {
                facet.furthest = (point, height);
            }
        }
    }

    /// The facets that a point sees, from one that it does; and the edges around them, each as its
    /// ends and the facet beyond.
    fn look(&mut self, from: u32, point: u32, seen: &mut Vec<u32>, horizon: &mut Vec<[u32; 3]>) {
        seen.clear();
        horizon.clear();
        seen.push(from);
        self.facets[from as usize].stands = false;
        let mut next = 0;
        while let Some(&facet) = seen.get(next) {
            next += 1;
            let Facet {
                corners, neighbors, ..
            } = self.facets[facet as usize];
            for edge in 0..3 {
                let beyond = neighbors[edge];
                let other = &self.facets[beyond as usize];
                if !other.stands {
                    continue;
                }
                if self.above(other, point).is_some() {
                    self.facets[beyond as usize].stands = false;
                    seen.push(beyond);
                } else {
                    horizon.push([corners[edge], corners[(edge + 1) % 3], beyond]);
                }
            }
        }
    }

    /// Puts a cone of facets from the horizon to the point in place of those that were seen.
    fn extend(&mut self, point: u32, seen: &[u32], horizon: &[[u32; 3]]) {
        let first = self.facets.len();
        for &[start, end, beyond] in horizon {
            let facet = index_u32(self.facets.len());
            self.begins[start as usize] = facet;
            self.add([start, end, point], [beyond, NONE, NONE]);
            let edges = &mut self.facets[beyond as usize];
            let shared = edges.corners.iter().position(|corner| *corner == end);
            edges.neighbors[shared.expect("the facet beyond has the edge, turned")] = facet;
        }
        // The horizon is one ring, so at each of its corners one of its edges ends and one begins.
        for (facet, &[_, end, _]) in horizon.iter().enumerate() {
            let after = self.begins[end as usize];
            self.facets[first + facet].neighbors[1] = after;
            self.facets[after as usize].neighbors[2] = index_u32(first + facet);
        }
        for &facet in seen {
            let mut outside = self.facets[facet as usize].outside;
            while outside != NONE {
                let following = self.next[outside as usize];
                if outside != point {
                    self.place(outside, first);
                }
                outside = following;
            }
        }
        let added = index_u32(first)..index_u32(self.facets.len());
        self.queue.extend(added);
    }

    /// The points at which at least three bent edges end, in no order.
    fn corners_of_bends(&mut self) -> Vec<u32> {
        let mut extremes = Vec::new();
        for place in 0..self.facets.len() {
            let facet = &self.facets[place];
            if !facet.stands {
                continue;
            }
            let corners = facet.corners;
            for edge in 0..3 {
                let other = &self.facets[self.facets[place].neighbors[edge] as usize];
                let ends = [corners[edge], corners[(edge + 1) % 3]];
                // Each edge is met from both sides, and counts once.
                let is_second = ends[0] > ends[1];
                let apex = other.corners.iter().find(|corner| !ends.contains(corner));
                let apex = *apex.expect("a triangle has a third corner");
                if is_second || self.grid.side(corners, apex).is_eq() {
                    continue;
                }
                for end in ends {
                    let bends = &mut self.bends[end as usize];
                    if *bends == 2 {
                        extremes.push(end);
                    }
                    *bends = (*bends + 1).min(3);
                }
            }
        }
        for facet in self.facets.iter().filter(|facet| facet.stands) {
            for corner in facet.corners {
                self.bends[corner as usize] = 0;
            }
        }
        extremes
    }
}

/// The first of the points at which a measure is largest.
fn furthest(points: &[u32], measure: impl Fn(u32) -> f64) -> u32 {
    let mut best = (NONE, f64::NEG_INFINITY);
    for &point in points {
        let found = measure(point);
        if found > best.1 {
            best = (point, found);
        }
    }
    best.0
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, Vec3};

    /// The originals of the extreme points.
    fn extremes(points: &[Vec3]) -> Vec<u32> {
        let grid = Grid::new(points);
        let all: Vec<u32> = (0..index_u32(grid.len())).collect();
        let found = HullFinder::new(&grid).extremes(&all);
        grid.originals_of(&found)
    }

    fn lattice(side: usize) -> Vec<Vec3> {
        let axis = move || (0..side).map(|at| at as f32);
        axis()
            .flat_map(|x| axis().flat_map(move |y| axis().map(move |z| Vec3::new(x, y, z))))
            .collect()
    }

    #[test]
    fn a_cube_has_eight_corners_however_many_points_lie_on_its_faces() {
        for side in 2..6 {
            let points = lattice(side);
            let corner = |value: f32| value == 0.0 || value == (side - 1) as f32;
            let wanted: Vec<u32> = (0..)
                .zip(&points)
                .filter(|(_, point)| point.to_array().into_iter().all(corner))
                .map(|(index, _)| index)
                .collect();
            assert_eq!(extremes(&points), wanted);
        }
    }

    #[test]
    fn flat_and_straight_sets_have_corners_and_ends() {
        // 2 5 3
        //  4 6     tilted in space; 5 on an edge, 4 and 6 inside
        // 0   1
        let plane = [
            (0., 0.),
            (4., 0.),
            (0., 4.),
            (4., 4.),
            (1., 2.),
            (2., 4.),
            (3., 2.),
        ];
        let tilted = plane.map(|(x, y): (f32, f32)| Vec3::new(x, y, 3.0 * x - 2.0 * y));
        assert_eq!(extremes(&tilted), [0, 1, 2, 3]);
        let line = [3.0, 1.0, 2.0, -4.0, 3.0].map(|x: f32| Vec3::new(x, -x, 2.0 * x));
        assert_eq!(extremes(&line), [0, 3, 4], "copies go together");
        assert_eq!(extremes(&[Vec3::ONE; 3]), [0, 1, 2]);
        assert_eq!(extremes(&[]), [0_u32; 0]);
        assert_eq!(
            extremes(&[Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]),
            [0, 1, 2, 3]
        );
    }

    /// Against the definition, on a coarse lattice where most points share planes with many others: a
    /// point is within the hull of others when no plane through three points has it alone outside.
    #[test]
    fn hulls_hold_all_points_and_only_extremes_are_needed() {
        for seed in 0..300 {
            let draws = Stream::new(seed, 40);
            let count = 5 + draws.below(0, 40);
            let side = 2 + draws.below(1, 6);
            let points: Vec<Vec3> = (0..count)
                .map(|point| {
                    let axis = |axis| draws.below(2 + 3 * point + axis, side) as f32;
                    Vec3::new(axis(0), axis(1), axis(2))
                })
                .collect();
            let grid = Grid::new(&points);
            let all: Vec<u32> = (0..index_u32(grid.len())).collect();
            let mut finder = HullFinder::new(&grid);
            let triangles = finder.triangles(&all);
            let found = finder.extremes(&all);
            for &corners in &triangles {
                let outside = all
                    .iter()
                    .filter(|point| grid.side(corners, **point).is_gt());
                assert_eq!(outside.count(), 0, "seed {seed}");
            }
            // The extremes alone have the same hull, and each of them is needed.
            assert_eq!(finder.extremes(&found), found, "seed {seed}");
            for &left_out in found.iter().filter(|_| !triangles.is_empty()) {
                let others: Vec<u32> = all.iter().copied().filter(|p| *p != left_out).collect();
                let around = finder.triangles(&others);
                let sees = |corners: &[u32; 3]| grid.side(*corners, left_out).is_gt();
                assert!(around.is_empty() || around.iter().any(sees), "seed {seed}");
            }
            let others: Vec<u32> = all.iter().copied().filter(|p| !found.contains(p)).collect();
            let around = finder.triangles(&found);
            for point in others {
                assert!(
                    around
                        .iter()
                        .all(|corners| grid.side(*corners, point).is_le()),
                    "seed {seed}: {point}"
                );
            }
        }
    }
}
