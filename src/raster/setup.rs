//! From corners to triangles in sub-pixels: clip, project, snap, turn, drop what covers nothing.

use super::clip::{ClipVertex, MAX_PARTS};
use super::view::{PixelBox, Projected, SUBPIXELS, View, inverse_w, range_of, snap};
use super::{Batch, Geometry, Key, MAX_VARYINGS, Topology};
use crate::math::{Vec4, index_u32};

/// Primitives that one thread sets up at a time; fixed, so that work is cut the same way always.
const PRIMITIVES_A_CHUNK: u32 = 512;
/// The most triangles of a chunk, of which each primitive has two, each cut into some.
pub(super) const TRIANGLES_A_CHUNK: usize = PRIMITIVES_A_CHUNK as usize * 2 * MAX_PARTS;

/// More than rounding moves the depth of a covered sample: each of the two weights, which are at most 1
/// in sum, is rounded six times and their sum twice, by at most 2⁻²⁴ each.
const DEPTH_ERROR: f32 = 1.0 / 1_048_576.0;

/// A triangle ready to be covered: corners in an order of positive area in y-down sub-pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Triangle {
    pub(super) x: [i32; 3],
    pub(super) y: [i32; 3],
    /// Depth at the first corner.
    pub(super) depth: f32,
    /// Depth gained a unit of the second and third edge function.
    pub(super) depth_slopes: [f32; 2],
    /// No sample that is covered is nearer.
    pub(super) nearest: f32,
    /// The vertex id of the primitive's first corner, as submitted.
    pub(super) vertex: u32,
    /// Where the corners' attributes are: in the geometry, or in the chunk's cut vertices.
    pub(super) corners: [u32; 3],
    pub(super) batch: u32,
    /// The primitive within the batch.
    pub(super) primitive: u32,
    /// The triangle within the primitive.
    pub(super) part: u8,
    pub(super) front: bool,
    /// Whether `corners` are those of the chunk.
    pub(super) cut: bool,
}

/// The primitives of one work item, set up.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    pub(super) triangles: Vec<Triangle>,
    /// The pixels that each triangle may cover.
    pub(super) boxes: Vec<PixelBox>,
    pub(super) cut: CutVertices,
}

/// Vertices that clipping made.
#[derive(Debug, Default)]
pub(super) struct CutVertices {
    pub(super) inverse_w: Vec<f32>,
    /// [`MAX_VARYINGS`] floats each; those of the batch are set.
    pub(super) varyings: Vec<[f32; MAX_VARYINGS]>,
}

/// A range of a batch's primitives.
#[derive(Debug, Clone, Copy)]
struct Segment {
    batch: u32,
    first: u32,
    count: u32,
}

/// Cuts batches into work items of a fixed number of primitives; small batches share one.
pub(super) fn set_up(view: &View, batches: &[Batch<'_>]) -> Vec<Chunk> {
    use rayon::prelude::*;
    work_items(batches)
        .par_iter()
        .map(|segments| set_up_chunk(view, batches, segments))
        .collect()
}

fn work_items(batches: &[Batch<'_>]) -> Vec<Vec<Segment>> {
    let mut items = Vec::new();
    let mut item = Vec::new();
    let mut room = PRIMITIVES_A_CHUNK;
    for (batch, number) in batches.iter().zip(0_u32..) {
        let total = index_u32(primitive_count(batch));
        let mut first = 0;
        while first < total {
            let count = room.min(total - first);
            item.push(Segment {
                batch: number,
                first,
                count,
            });
            first += count;
            room -= count;
            if room == 0 {
                items.push(std::mem::take(&mut item));
                room = PRIMITIVES_A_CHUNK;
            }
        }
    }
    if !item.is_empty() {
        items.push(item);
    }
    items
}

/// How many whole primitives a batch has.
pub(super) fn primitive_count(batch: &Batch<'_>) -> usize {
    batch.geometry.corners.len() / corners_of(batch.topology)
}

/// Corners a primitive.
pub(super) fn corners_of(topology: Topology) -> usize {
    match topology {
        Topology::TriangleList => 3,
        Topology::QuadList => 4,
        Topology::LineList => 2,
    }
}

/// The key of a triangle of a batch.
pub(super) fn key(batch: &Batch<'_>, triangle: &Triangle) -> Key {
    Key {
        group: batch.group,
        instance: batch.instance,
        vertex: triangle.vertex,
        triangle: u32::from(triangle.part),
    }
}

/// The vertex ids of the corners of a triangle's primitive, as submitted; the greatest number for a
/// corner that names no vertex.
pub(super) fn vertex_ids<'a>(
    batch: &Batch<'a>,
    triangle: &Triangle,
) -> impl Iterator<Item = u32> + use<'a> {
    let size = corners_of(batch.topology);
    let first = triangle.primitive as usize * size;
    let geometry = batch.geometry;
    let corners = geometry.corners[first..first + size].iter();
    corners.map(|&corner| {
        let id = geometry.vertex_ids.get(corner as usize);
        id.copied().unwrap_or(u32::MAX)
    })
}

fn set_up_chunk(view: &View, batches: &[Batch<'_>], segments: &[Segment]) -> Chunk {
    let primitives: u32 = segments.iter().map(|segment| segment.count).sum();
    let room = 2 * primitives as usize;
    let mut builder = Builder {
        view,
        chunk: Chunk {
            triangles: Vec::with_capacity(room),
            boxes: Vec::with_capacity(room),
            cut: CutVertices::default(),
        },
    };
    for segment in segments {
        let batch = &batches[segment.batch as usize];
        let size = corners_of(batch.topology);
        let range = segment.first as usize * size..(segment.first + segment.count) as usize * size;
        let primitives = batch.geometry.corners[range].chunks_exact(size);
        for (corners, primitive) in primitives.zip(segment.first..) {
            let place = Place {
                batch: segment.batch,
                primitive,
                geometry: batch.geometry,
                varyings: batch.kernel.varyings(),
            };
            match *corners {
                [a, b, c] => builder.triangle(&place, [a, b, c], 0),
                [a, b, c, d] => {
                    builder.triangle(&place, [a, b, c], 0);
                    builder.triangle(&place, [a, c, d], 1);
                }
                [a, b] => builder.line(&place, [a, b]),
                _ => {}
            }
        }
    }
    builder.chunk
}

/// Which primitive is set up.
struct Place<'a> {
    batch: u32,
    primitive: u32,
    geometry: &'a Geometry,
    varyings: usize,
}

struct Builder<'a> {
    view: &'a View,
    chunk: Chunk,
}

impl Builder<'_> {
    fn triangle(&mut self, place: &Place<'_>, corners: [u32; 3], part: u8) {
        let Some((corners, vertex)) = lowest_first(place.geometry, corners) else {
            return;
        };
        let at = |corner: u32| place.geometry.clip[corner as usize];
        let clip = [at(corners[0]), at(corners[1]), at(corners[2])];
        if !clip.iter().all(|position| position.is_finite()) || beside_the_view(clip) {
            return;
        }
        let positions = [widen(clip[0]), widen(clip[1]), widen(clip[2])];
        let source = Source {
            batch: place.batch,
            primitive: place.primitive,
            vertex,
            part,
            cut: false,
        };
        if positions
            .iter()
            .all(|&position| self.view.volume.contains(position))
        {
            let [a, b, c] = positions;
            let projected = [
                self.view.project(a),
                self.view.project(b),
                self.view.project(c),
            ];
            self.emit(projected, corners, source);
        } else {
            let polygon = self.view.volume.clip_triangle(positions);
            self.cut_polygon(place, corners, source, polygon.vertices());
        }
    }

    /// The polygon as a fan around its first vertex.
    fn cut_polygon(
        &mut self,
        place: &Place<'_>,
        corners: [u32; 3],
        source: Source,
        polygon: &[ClipVertex],
    ) {
        if polygon.len() < 3 {
            return;
        }
        let first = index_u32(self.chunk.cut.inverse_w.len());
        for vertex in polygon {
            self.chunk.cut.push(place, corners, vertex);
        }
        let source = Source {
            cut: true,
            ..source
        };
        for (pair, second) in polygon[1..].windows(2).zip(first + 1..) {
            let fan = [polygon[0], pair[0], pair[1]];
            let projected = fan.map(|vertex| self.view.project(vertex.position));
            self.emit(projected, [first, second, second + 1], source);
        }
    }

    /// A line as the rectangle of width 1 around it, its ends cut square.
    fn line(&mut self, place: &Place<'_>, corners: [u32; 2]) {
        let id = |corner: u32| place.geometry.vertex_ids.get(corner as usize).copied();
        let [Some(vertex), Some(other)] = corners.map(id) else {
            return;
        };
        let [a, b] = corners;
        let corners = if vertex <= other { [a, b] } else { [b, a] };
        let clip = corners.map(|corner| place.geometry.clip[corner as usize]);
        if !clip.iter().all(|position| position.is_finite()) {
            return;
        }
        let positions = clip.map(widen);
        let Some(ends) = self.view.volume.clip_line(positions) else {
            return;
        };
        let [from, to] = ends.map(|end| self.view.subpixels(end.position));
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = (dx * dx + dy * dy).sqrt();
        if length == 0.0 {
            return;
        }
        // Half a pixel to the side on which the rectangle turns counter-clockwise to the eye.
        let half = f64::from(SUBPIXELS / 2);
        let side = [dy / length * half, -dx / length * half];
        let [a, b] = ends.map(|end| self.view.project(end.position));
        let beside = |end: Projected, at: [f64; 2], sign: f64| Projected {
            x: snap(at[0] + sign * side[0]),
            y: snap(at[1] + sign * side[1]),
            ..end
        };
        let first = index_u32(self.chunk.cut.inverse_w.len());
        for end in &ends {
            let corners = [corners[0], corners[1], corners[1]];
            self.chunk.cut.push(place, corners, end);
        }
        let source = Source {
            batch: place.batch,
            primitive: place.primitive,
            vertex,
            part: 0,
            cut: true,
        };
        let rectangle = [
            beside(a, from, -1.0),
            beside(b, to, -1.0),
            beside(b, to, 1.0),
            beside(a, from, 1.0),
        ];
        let [p, q, r, s] = rectangle;
        self.emit([p, q, r], [first, first + 1, first + 1], source);
        self.emit([p, r, s], [first, first + 1, first], source);
    }

    #[inline]
    fn emit(&mut self, corner: [Projected; 3], corners: [u32; 3], source: Source) {
        let [mut x, mut y] = [corner.map(|c| c.x), corner.map(|c| c.y)];
        let Some(pixels) = self.view.pixels(range_of(x), range_of(y)) else {
            return;
        };
        let twice_area = i64::from(x[1] - x[0]) * i64::from(y[2] - y[0])
            - i64::from(x[2] - x[0]) * i64::from(y[1] - y[0]);
        if twice_area == 0 {
            return;
        }
        let mut corners = corners;
        let mut depth = corner.map(|c| c.depth);
        // Rows run downwards, so a positive area is clockwise to the eye.
        let front = twice_area < 0;
        if front {
            x.swap(1, 2);
            y.swap(1, 2);
            corners.swap(1, 2);
            depth.swap(1, 2);
        }
        let inverse_area = 1.0 / twice_area.unsigned_abs() as f32;
        self.chunk.triangles.push(Triangle {
            x,
            y,
            depth: depth[0],
            depth_slopes: [
                (depth[1] - depth[0]) * inverse_area,
                (depth[2] - depth[0]) * inverse_area,
            ],
            nearest: depth[0].min(depth[1]).min(depth[2]) - DEPTH_ERROR,
            vertex: source.vertex,
            corners,
            batch: source.batch,
            primitive: source.primitive,
            part: source.part,
            front,
            cut: source.cut,
        });
        self.chunk.boxes.push(pixels);
    }
}

/// What a triangle is part of.
#[derive(Clone, Copy)]
struct Source {
    batch: u32,
    primitive: u32,
    vertex: u32,
    part: u8,
    cut: bool,
}

impl CutVertices {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "attributes are f32, rounded once"
    )]
    fn push(&mut self, place: &Place<'_>, corners: [u32; 3], vertex: &ClipVertex) {
        let mut varyings = [0.0; MAX_VARYINGS];
        for (varying, value) in varyings[..place.varyings].iter_mut().enumerate() {
            let at = |k: usize| {
                let float = corners[k] as usize * place.varyings + varying;
                f64::from(place.geometry.varyings[float])
            };
            let [a, b, c] = vertex.weights;
            *value = (at(0) * a + at(1) * b + at(2) * c) as f32;
        }
        self.inverse_w.push(inverse_w(vertex.position[3]));
        self.varyings.push(varyings);
    }
}

/// Turns a triangle so that its lowest vertex id comes first, the first of them where two are equal;
/// with the id of what was the first corner. `None` when a corner names no vertex.
#[inline]
fn lowest_first(geometry: &Geometry, corners: [u32; 3]) -> Option<([u32; 3], u32)> {
    let [a, b, c] = corners;
    let id = |corner: u32| geometry.vertex_ids.get(corner as usize).copied();
    let (id_a, id_b, id_c) = (id(a)?, id(b)?, id(c)?);
    let turned = if id_a <= id_b && id_a <= id_c {
        [a, b, c]
    } else if id_b <= id_c {
        [b, c, a]
    } else {
        [c, a, b]
    };
    Some((turned, id_a))
}

#[inline]
fn widen(position: Vec4) -> [f64; 4] {
    let Vec4 { x, y, z, w } = position;
    [x.into(), y.into(), z.into(), w.into()]
}

/// Whether all corners are on the far side of one plane of the view, where no pixel is.
#[inline]
fn beside_the_view(clip: [Vec4; 3]) -> bool {
    clip.iter().all(|p| p.x < -p.w)
        || clip.iter().all(|p| p.x > p.w)
        || clip.iter().all(|p| p.y < -p.w)
        || clip.iter().all(|p| p.y > p.w)
        || clip.iter().all(|p| p.z < 0.0)
        || clip.iter().all(|p| p.z > p.w)
}
