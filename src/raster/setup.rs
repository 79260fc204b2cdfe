//! From corners to triangles in sub-pixels: clip, project, snap, turn, drop what covers nothing.

use std::borrow::Cow;
use std::sync::Arc;

use fearless_simd::{Simd, dispatch};

use super::clip::{ClipVertex, MAX_PARTS};
use super::line_records::Lines;
use super::lines::stroke;
use super::project::{Projection, TOGETHER};
use super::reach::{Cover, Reach};
use super::source::{ALL, PART, Part};
use super::view::{PixelBox, Projected, View, inverse_w, range_of};
use super::{Batch, Blend, Geometry, Key, MAX_FLATS, MAX_VARYINGS, Topology};
use crate::math::{Vec4, index_u32};

/// The most triangles of a part, of which each primitive has two, each cut into some.
pub(super) const MOST_TRIANGLES: usize = PART * 2 * MAX_PARTS;

/// More than rounding moves the depth of a covered sample: each of the two weights, which are at most 1
/// in sum, is rounded six times and their sum twice, by at most 2⁻²⁴ each.
pub(super) const DEPTH_ERROR: f32 = 1.0 / 1_048_576.0;

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
    /// The pixels that it may cover.
    pub(super) pixels: PixelBox,
    /// The primitive within the part's geometry.
    pub(super) primitive: u32,
    /// The triangle within the primitive.
    pub(super) part: u8,
    pub(super) front: bool,
    /// Whether `corners` are those of the chunk.
    pub(super) cut: bool,
}

/// The primitives of a part, set up: those triangles that may cover a sample.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug)]
pub struct Chunk<'a> {
    pub(super) batch: u32,
    /// The part of the batch.
    pub(super) part: u32,
    /// The primitives of the part that were made.
    pub(super) wanted: u64,
    pub(super) geometry: Cow<'a, Geometry>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) cut: CutVertices,
    /// Lines that are no triangles.
    pub(super) lines: Lines,
}

/// Vertices that clipping made.
#[derive(Debug, Default)]
pub(super) struct CutVertices {
    pub(super) inverse_w: Vec<f32>,
    /// [`MAX_VARYINGS`] floats each; those of the batch are set.
    pub(super) varyings: Vec<[f32; MAX_VARYINGS]>,
}

/// Memory of chunks that nobody needs any more.
#[derive(Debug, Default)]
pub(super) struct Spare {
    geometries: Vec<Geometry>,
    triangles: Vec<Vec<Triangle>>,
}

impl Spare {
    /// Takes a chunk apart, unless somebody else needs it.
    pub(super) fn take(&mut self, chunk: Arc<Chunk<'_>>) {
        let Some(chunk) = Arc::into_inner(chunk) else {
            return;
        };
        if chunk.triangles.capacity() > 0 {
            let mut triangles = chunk.triangles;
            triangles.clear();
            self.triangles.push(triangles);
        }
        if let Cow::Owned(geometry) = chunk.geometry
            && geometry.clip.capacity() > 0
        {
            self.geometries.push(geometry);
        }
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
pub(super) fn vertex_ids<'c>(
    batch: &Batch<'_>,
    chunk: &'c Chunk<'_>,
    triangle: &Triangle,
) -> impl Iterator<Item = u32> + use<'c> {
    let size = batch.topology.corners();
    let first = triangle.primitive as usize * size;
    let geometry = &*chunk.geometry;
    let corners = geometry.corners[first..first + size].iter();
    corners.map(|&corner| {
        let id = geometry.vertex_ids.get(corner as usize);
        id.copied().unwrap_or(u32::MAX)
    })
}

/// Sets up a part of a batch, of which both numbers are told.
///
/// Triangles that `cover` hides may be left out: they lie wholly on it, unless all that is wanted does.
pub(super) fn set_up<'a>(
    view: &View,
    batch: &Batch<'a>,
    [number, part]: [u32; 2],
    cover: Option<&Cover<'_>>,
    spare: &mut Spare,
) -> Chunk<'a> {
    let wanted = cover.map_or(ALL, |cover| shown(view, batch, part as usize, cover));
    if wanted == 0 {
        return Chunk {
            batch: number,
            part,
            wanted,
            geometry: Cow::Owned(Geometry::default()),
            triangles: Vec::new(),
            cut: CutVertices::default(),
            lines: Lines::default(),
        };
    }
    let source = batch.geometry;
    let Part {
        geometry,
        primitives,
    } = source.part(
        part as usize,
        batch.topology,
        wanted,
        spare.geometries.pop().unwrap_or_default(),
    );
    check(batch, &geometry);
    let mut builder = Builder {
        view,
        geometry: &geometry,
        varyings: batch.kernel.varyings(),
        cover,
        triangles: spare.triangles.pop().unwrap_or_default(),
        cut: CutVertices::default(),
    };
    let (size, first) = (batch.topology.corners(), index_u32(primitives.start));
    let corners = &geometry.corners[primitives.start * size..primitives.end * size];
    let level = view.level;
    builder.triangles.reserve(primitives.len() / 2);
    match batch.topology {
        Topology::TriangleList => {
            dispatch!(level, simd => builder.all::<_, 3>(simd, corners, first));
        }
        Topology::QuadList => {
            dispatch!(level, simd => builder.all::<_, 4>(simd, corners, first));
        }
        Topology::LineList => {
            for (corners, primitive) in corners.as_chunks().0.iter().zip(first..) {
                builder.line(primitive, *corners);
            }
        }
    }
    let Builder {
        mut triangles, cut, ..
    } = builder;
    if batch.blend == Blend::Opaque && are_large(&triangles) {
        triangles.sort_by(|a, b| a.nearest.total_cmp(&b.nearest));
    }
    Chunk {
        batch: number,
        part,
        wanted,
        geometry,
        triangles,
        cut,
        lines: Lines::default(),
    }
}

/// The primitives of a part that may show as far as their boxes tell, a bit each.
fn shown(view: &View, batch: &Batch<'_>, part: usize, cover: &Cover<'_>) -> u64 {
    if !cover.alone {
        return ALL;
    }
    let (hull, boxes) = (batch.geometry.hull(part), batch.geometry.boxes(part));
    let (Some(hull), Some(boxes)) = (hull, boxes) else {
        return ALL;
    };
    dispatch!(view.level, simd => view.shown_of(simd, &hull, boxes, cover))
}

/// A line of a chunk, with so many varyings, as two triangles in a chunk of their own.
pub(super) fn unfold<'c>(
    view: &View,
    chunk: &'c Chunk<'_>,
    place: usize,
    count: usize,
) -> Chunk<'c> {
    let line = &chunk.lines.line(place, count);
    let mut cut = CutVertices::default();
    for (end, of_end) in chunk.lines.varyings(place, count).into_iter().enumerate() {
        let mut varyings = [0.0; MAX_VARYINGS];
        for (varying, &bits) in varyings[..count].iter_mut().zip(of_end) {
            *varying = f32::from_bits(bits);
        }
        cut.inverse_w.push(line.inverse_w[end]);
        cut.varyings.push(varyings);
    }
    let mut builder = Builder {
        view,
        geometry: &chunk.geometry,
        varyings: 0,
        cover: None,
        triangles: Vec::new(),
        cut,
    };
    let source = Source {
        primitive: line.primitive,
        // Blended triangles have no key.
        vertex: 0,
        part: 0,
        cut: true,
    };
    let corner = |corner: usize, end: usize| Projected {
        x: line.x[corner],
        y: line.y[corner],
        depth: line.depth[end],
    };
    let rectangle = [corner(0, 0), corner(1, 1), corner(2, 1), corner(3, 0)];
    builder.rectangle(rectangle, 0, source);
    Chunk {
        batch: chunk.batch,
        part: chunk.part,
        wanted: chunk.wanted,
        triangles: builder.triangles,
        cut: builder.cut,
        geometry: Cow::Borrowed(&chunk.geometry),
        lines: Lines::default(),
    }
}

/// Whether triangles are so large that those in front hide many pixels of those behind them.
fn are_large(triangles: &[Triangle]) -> bool {
    const PIXELS: usize = 64;
    let pixels = triangles.iter().map(|triangle| triangle.pixels.count());
    pixels.sum::<usize>() > PIXELS * triangles.len()
}

pub(super) fn check(batch: &Batch<'_>, geometry: &Geometry) {
    let (varyings, flats) = (batch.kernel.varyings(), batch.kernel.flats());
    assert!(
        varyings <= MAX_VARYINGS && flats <= MAX_FLATS,
        "a kernel has {varyings} varyings and {flats} flats, the most is {MAX_VARYINGS} and {MAX_FLATS}"
    );
    let vertices = geometry.clip.len();
    assert!(
        geometry.vertex_ids.len() == vertices && geometry.varyings.len() == vertices * varyings,
        "{vertices} vertices have {} ids and {} floats, their kernel wants {varyings} each",
        geometry.vertex_ids.len(),
        geometry.varyings.len(),
    );
    let primitives = geometry.primitive_count(batch.topology);
    assert!(
        geometry.flats.len() >= primitives * flats,
        "{primitives} primitives have {} flats, their kernel wants {flats} each",
        geometry.flats.len(),
    );
}

impl Chunk<'_> {
    /// Where its triangles may show; `None` if there are none.
    pub(super) fn reach(&self) -> Option<Reach> {
        let reaches = self.triangles.iter().map(|triangle| Reach {
            pixels: triangle.pixels,
            nearest: triangle.nearest.max(0.0),
        });
        reaches.reduce(Reach::and)
    }

    /// About how many bytes it takes.
    pub(super) fn bytes(&self) -> u64 {
        let geometry = match &self.geometry {
            Cow::Borrowed(_) => 0,
            Cow::Owned(geometry) => geometry.bytes(),
        };
        geometry + self.lines.bytes() + (self.triangles.len() * size_of::<Triangle>()) as u64
    }
}

struct Builder<'a> {
    view: &'a View,
    geometry: &'a Geometry,
    varyings: usize,
    cover: Option<&'a Cover<'a>>,
    triangles: Vec<Triangle>,
    cut: CutVertices,
}

impl Builder<'_> {
    /// Triangles or quads, eight at a time as far as they need not be cut.
    #[inline(always)]
    fn all<S: Simd, const CORNERS: usize>(&mut self, simd: S, corners: &[u32], first: u32) {
        let mut primitive = first;
        for corners in corners.chunks(CORNERS * TOGETHER) {
            let projection = Projection::<CORNERS>::new(simd, self.view, self.geometry, corners);
            let shown = projection.shown(self.view, self.cover);
            let mut rest = shown[0] | shown[1] | projection.alone;
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let corners = &corners[lane * CORNERS..][..CORNERS];
                let primitive = primitive + index_u32(lane);
                let alone = projection.alone >> lane & 1 == 1;
                let small = projection.small >> lane & 1 == 1;
                for part in 0..CORNERS - 2 {
                    if !alone && shown[part] >> lane & 1 == 0 {
                        continue;
                    }
                    let places = [0, part + 1, part + 2];
                    let of = [corners[0], corners[part + 1], corners[part + 2]];
                    let part = u8::from(part == 1);
                    if alone {
                        self.triangle(primitive, of, part);
                    } else {
                        let at = projection.triangle(lane, places);
                        self.projected(primitive, of, part, at, small);
                    }
                }
            }
            primitive += index_u32(TOGETHER);
        }
    }

    /// A triangle on the target that need not be cut; `covers` where it is known to cover a sample.
    #[inline(always)]
    fn projected(
        &mut self,
        primitive: u32,
        corners: [u32; 3],
        part: u8,
        at: [Projected; 3],
        covers: bool,
    ) {
        let ids = &self.geometry.vertex_ids;
        let [a, b, c] = corners.map(|corner| ids[corner as usize]);
        let [p, q, r] = at;
        let [i, j, k] = corners;
        let source = Source {
            primitive,
            vertex: a,
            part,
            cut: false,
        };
        if a <= b && a <= c {
            self.emit([p, q, r], [i, j, k], source, covers);
        } else if b <= c {
            self.emit([q, r, p], [j, k, i], source, covers);
        } else {
            self.emit([r, p, q], [k, i, j], source, covers);
        }
    }

    #[inline(never)]
    fn triangle(&mut self, primitive: u32, corners: [u32; 3], part: u8) {
        let Some((corners, vertex)) = lowest_first(self.geometry, corners) else {
            return;
        };
        let at = |corner: u32| self.geometry.clip[corner as usize];
        let clip = [at(corners[0]), at(corners[1]), at(corners[2])];
        if !clip.iter().all(|position| position.is_finite()) || beside_the_view(clip) {
            return;
        }
        let positions = [widen(clip[0]), widen(clip[1]), widen(clip[2])];
        let source = Source {
            primitive,
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
            self.emit(projected, corners, source, false);
        } else {
            let polygon = self.view.volume.clip_triangle(positions);
            self.cut_polygon(corners, source, polygon.vertices());
        }
    }

    /// The polygon as a fan around its first vertex.
    fn cut_polygon(&mut self, corners: [u32; 3], source: Source, polygon: &[ClipVertex]) {
        if polygon.len() < 3 {
            return;
        }
        let first = index_u32(self.cut.inverse_w.len());
        for vertex in polygon {
            self.cut.push(self.geometry, self.varyings, corners, vertex);
        }
        let source = Source {
            cut: true,
            ..source
        };
        for (pair, second) in polygon[1..].windows(2).zip(first + 1..) {
            let fan = [polygon[0], pair[0], pair[1]];
            let projected = fan.map(|vertex| self.view.project(vertex.position));
            self.emit(projected, [first, second, second + 1], source, false);
        }
    }

    /// A line as the rectangle of width 1 around it.
    fn line(&mut self, primitive: u32, corners: [u32; 2]) {
        let Some(stroke) = stroke(self.view, self.geometry, corners) else {
            return;
        };
        let first = index_u32(self.cut.inverse_w.len());
        for end in &stroke.ends {
            self.cut
                .push_end(self.geometry, self.varyings, stroke.corners, end);
        }
        let source = Source {
            primitive,
            vertex: stroke.vertex,
            part: 0,
            cut: true,
        };
        self.rectangle(stroke.rectangle, first, source);
    }

    /// The rectangle of a line of which the ends are two cut vertices.
    fn rectangle(&mut self, [p, q, r, s]: [Projected; 4], first: u32, source: Source) {
        self.emit([p, q, r], [first, first + 1, first + 1], source, false);
        self.emit([p, r, s], [first, first + 1, first], source, false);
    }

    #[inline(always)]
    fn emit(&mut self, corner: [Projected; 3], corners: [u32; 3], source: Source, covers: bool) {
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
        if !covers && self.view.is_missed(x, y, pixels) {
            return;
        }
        let inverse_area = 1.0 / twice_area.unsigned_abs() as f32;
        self.triangles.push(Triangle {
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
            pixels,
            primitive: source.primitive,
            part: source.part,
            front,
            cut: source.cut,
        });
    }
}

/// What a triangle is part of.
#[derive(Clone, Copy)]
struct Source {
    primitive: u32,
    vertex: u32,
    part: u8,
    cut: bool,
}

impl CutVertices {
    /// The end of a line.
    pub(super) fn push_end(
        &mut self,
        geometry: &Geometry,
        count: usize,
        [a, b]: [u32; 2],
        end: &ClipVertex,
    ) {
        self.push(geometry, count, [a, b, b], end);
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "attributes are f32, rounded once"
    )]
    fn push(&mut self, geometry: &Geometry, count: usize, corners: [u32; 3], vertex: &ClipVertex) {
        let mut varyings = [0.0; MAX_VARYINGS];
        for (varying, value) in varyings[..count].iter_mut().enumerate() {
            let at = |k: usize| {
                let float = corners[k] as usize * count + varying;
                f64::from(geometry.varyings[float])
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
pub(super) fn widen(position: Vec4) -> [f64; 4] {
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
