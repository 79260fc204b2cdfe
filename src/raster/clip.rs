//! Cutting triangles and lines at the planes beyond which they have no place on a screen.
//!
//! The planes and their order are fixed: `w ≥ 2⁻⁴⁰`, `z ≥ 0` (near), `z ≤ w` (far), then the guard
//! band left, right, bottom, top: `|x| ≤ g_x w`, `|y| ≤ g_y w`, which keeps pixels within ±2¹⁵.
//! A cut is always computed from the end inside to the end outside, in `f64`, so both triangles of
//! a shared edge get the same new vertex.

/// A vertex of the polygon that is left: where it is, and how much of each corner of the
/// primitive it is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClipVertex {
    pub(super) position: [f64; 4],
    pub(super) weights: [f64; 3],
}

/// The volume that is kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Volume {
    guard: [f64; 2],
}

/// The most corners of a polygon that is left: each of seven planes adds one to three.
pub(super) const MAX_CORNERS: usize = 10;
/// The most triangles that one triangle leaves.
pub(super) const MAX_PARTS: usize = MAX_CORNERS - 2;

const PLANES: usize = 7;
/// Small enough to lie before any near plane, large enough that its inverse is an `f32`.
pub(super) const LEAST_W: f64 = 1.0 / (1_u64 << 40) as f64;
/// Half the width in pixels of the guard band, around the middle of the target.
const GUARD_PIXELS: f64 = 16384.0;

impl Volume {
    /// The volume of a target of `width × height` pixels.
    pub(super) fn new(width: u32, height: u32) -> Self {
        Self {
            guard: [width, height].map(|side| GUARD_PIXELS / (f64::from(side.max(1)) / 2.0)),
        }
    }

    /// How many times `w` x and y may be.
    #[inline(always)]
    pub(super) fn guard(self) -> [f64; 2] {
        self.guard
    }

    /// Whether a position is inside of all planes.
    #[inline]
    pub(super) fn contains(self, position: [f64; 4]) -> bool {
        let [x, y, z, w] = position;
        w >= LEAST_W
            && z >= 0.0
            && z <= w
            && x.abs() <= self.guard[0] * w
            && y.abs() <= self.guard[1] * w
    }

    /// How far inside of a plane a position is; negative outside.
    fn distance(self, plane: usize, position: [f64; 4]) -> f64 {
        let [x, y, z, w] = position;
        match plane {
            0 => w - LEAST_W,
            1 => z,
            2 => w - z,
            3 => self.guard[0] * w + x,
            4 => self.guard[0] * w - x,
            5 => self.guard[1] * w + y,
            _ => self.guard[1] * w - y,
        }
    }

    /// What is left of a triangle: a convex polygon of the same winding, with fewer than three
    /// corners when nothing is.
    pub(super) fn clip_triangle(self, positions: [[f64; 4]; 3]) -> Polygon {
        let mut polygon = Polygon::default();
        for (corner, position) in positions.into_iter().enumerate() {
            polygon.push(corner_vertex(corner, position));
        }
        for plane in 0..PLANES {
            let mut cut = Polygon::default();
            for index in 0..polygon.count {
                let here = polygon.vertices[index];
                let next = polygon.vertices[(index + 1) % polygon.count];
                let [d_here, d_next] = [here, next].map(|v| self.distance(plane, v.position));
                if d_here >= 0.0 {
                    cut.push(here);
                }
                if d_here >= 0.0 && d_next < 0.0 {
                    cut.push(between(here, next, d_here, d_next));
                } else if d_here < 0.0 && d_next >= 0.0 {
                    cut.push(between(next, here, d_next, d_here));
                }
            }
            polygon = cut;
        }
        polygon
    }

    /// What is left of a line, its ends in the order given.
    pub(super) fn clip_line(self, positions: [[f64; 4]; 2]) -> Option<[ClipVertex; 2]> {
        let [a, b] = positions;
        let mut line = [corner_vertex(0, a), corner_vertex(1, b)];
        for plane in 0..PLANES {
            let [first, second] = line.map(|v| self.distance(plane, v.position));
            match (first >= 0.0, second >= 0.0) {
                (true, true) => {}
                (true, false) => line[1] = between(line[0], line[1], first, second),
                (false, true) => line[0] = between(line[1], line[0], second, first),
                (false, false) => return None,
            }
        }
        Some(line)
    }
}

/// A convex polygon in clip space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Polygon {
    vertices: [ClipVertex; MAX_CORNERS],
    count: usize,
}

impl Polygon {
    pub(super) fn vertices(&self) -> &[ClipVertex] {
        &self.vertices[..self.count]
    }

    /// A polygon that rounding made to cross a plane more than twice loses its last corners.
    fn push(&mut self, vertex: ClipVertex) {
        if let Some(place) = self.vertices.get_mut(self.count) {
            *place = vertex;
            self.count += 1;
        }
    }
}

impl Default for Polygon {
    fn default() -> Self {
        Self {
            vertices: [corner_vertex(0, [0.0; 4]); MAX_CORNERS],
            count: 0,
        }
    }
}

fn corner_vertex(corner: usize, position: [f64; 4]) -> ClipVertex {
    let mut weights = [0.0; 3];
    weights[corner] = 1.0;
    ClipVertex { position, weights }
}

fn between(inside: ClipVertex, outside: ClipVertex, d_inside: f64, d_outside: f64) -> ClipVertex {
    let t = d_inside / (d_inside - d_outside);
    let mix = |a: f64, b: f64| a + (b - a) * t;
    ClipVertex {
        position: std::array::from_fn(|k| mix(inside.position[k], outside.position[k])),
        weights: std::array::from_fn(|k| mix(inside.weights[k], outside.weights[k])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume() -> Volume {
        Volume::new(100, 100)
    }

    #[test]
    fn what_is_inside_stays_as_it_is() {
        let triangle = [
            [0.0, 0.0, 0.5, 1.0],
            [1.0, 0.0, 0.5, 1.0],
            [0.0, 9.0, 0.5, 1.0],
        ];
        let polygon = volume().clip_triangle(triangle);
        let positions: Vec<[f64; 4]> = polygon.vertices().iter().map(|v| v.position).collect();
        assert_eq!(positions, triangle);
        assert!(triangle.iter().all(|&position| volume().contains(position)));
    }

    #[test]
    fn one_corner_behind_the_near_plane_leaves_a_quad() {
        let polygon = volume().clip_triangle([
            [0.0, 0.0, -1.0, 1.0],
            [1.0, 0.0, 1.0, 1.0],
            [0.0, 1.0, 1.0, 1.0],
        ]);
        let positions: Vec<[f64; 4]> = polygon.vertices().iter().map(|v| v.position).collect();
        assert_eq!(
            positions,
            [
                [0.5, 0.0, 0.0, 1.0],
                [1.0, 0.0, 1.0, 1.0],
                [0.0, 1.0, 1.0, 1.0],
                [0.0, 0.5, 0.0, 1.0],
            ]
        );
        assert_eq!(polygon.vertices()[0].weights, [0.5, 0.5, 0.0]);
    }

    #[test]
    fn what_is_behind_the_eye_is_gone() {
        let behind = [[0.0, 0.0, 0.0, -1.0]; 3];
        assert!(volume().clip_triangle(behind).vertices().len() < 3);
        assert!(volume().clip_line([behind[0], behind[1]]).is_none());
    }

    #[test]
    fn lines_are_cut_at_both_ends() {
        let line = volume()
            .clip_line([[0.0, 0.0, -1.0, 2.0], [0.0, 0.0, 3.0, 2.0]])
            .expect("its middle is inside");
        assert_eq!(line[0].position, [0.0, 0.0, 0.0, 2.0]);
        assert_eq!(line[1].position, [0.0, 0.0, 2.0, 2.0]);
        assert_eq!(line[1].weights, [0.25, 0.75, 0.0]);
    }
}
