//! What draws draw, cut into parts that lie close together: kept from pass to pass, so that a part which
//! cannot be seen costs no vertex.
//!
//! ```text
//!  buffers, runs of corners ─▶ corners ─▶ parts of 64 primitives, a box each ─▶ rasterizer
//!       (versions)               └──────────── kept while nothing was written ──────────┘
//! ```
//!
//! **Invariant.** A mesh is a function of the bytes of the buffers that its key names and of the runs. It
//! is never asked where reads are tracked, and no picture and no counter depends on it.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::pass::Corners;
use super::program::{Bindings, Program};
use super::resource::Buffer;
use super::{BufferId, ProgramId};
use crate::math::{Vec3, index_u32};
use crate::raster::{Blend, Boxes, PART};

/// What a mesh depends on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MeshKey {
    pub(super) program: ProgramId,
    pub(super) source: Corners,
    /// Vertices, indices and what hulls depend on, each with the version of its bytes.
    pub(super) buffers: Vec<(Option<BufferId>, u64)>,
    /// The first corner, the number of corners and the first vertex of each record.
    pub(super) runs: Vec<[u32; 3]>,
}

/// The primitives of a draw.
#[derive(Debug)]
pub(super) struct Mesh {
    /// Whole primitives, in the order of submission.
    pub(super) corners: Vec<u32>,
    /// Strips as they were submitted, a restart between two.
    pub(super) strips: Option<Vec<u32>>,
    parts: Option<Parts>,
}

/// Primitives by parts.
#[derive(Debug)]
struct Parts {
    /// The primitives in an order in which neighbours follow one another, if their own is not one.
    sorted: Option<Sorted>,
    /// The box of each part.
    boxes: Vec<[Vec3; 2]>,
    /// The boxes of the primitives of each part, once the mesh is drawn again.
    of_primitives: OnceLock<Vec<Boxes>>,
}

#[derive(Debug)]
struct Sorted {
    /// Their places in the order of submission.
    order: Vec<u32>,
    corners: Vec<u32>,
    /// The bytes of the vertex of each corner, where they take about as much room as in their buffer.
    vertices: Option<Vec<u8>>,
}

impl Mesh {
    pub(super) fn new(corners: Vec<u32>, strips: Option<Vec<u32>>) -> Self {
        Self {
            corners,
            strips,
            parts: None,
        }
    }

    /// Finds the boxes of parts, where a program tells them.
    pub(super) fn cut(
        &mut self,
        program: &dyn Program,
        bindings: &Bindings<'_>,
        vertices: Option<(&Buffer, u32)>,
    ) {
        let layout = program.layout();
        let Some(hulls) = program.hulls().filter(|_| layout.blend == Blend::Opaque) else {
            return;
        };
        let size = layout.topology.corners();
        let bounds = |corners: &[u32]| hulls.bounds(corners, bindings);
        let boxes = |corners: &[u32]| -> Vec<[Vec3; 2]> {
            let parts = corners.par_chunks(PART * size).with_min_len(16);
            parts.map(bounds).collect()
        };
        let mut parts = Parts {
            boxes: boxes(&self.corners),
            of_primitives: OnceLock::new(),
            sorted: None,
        };
        // Primitives that a vertex stage may leave out have no place that is known.
        if layout.pulled_primitive_bytes == 0 && scattered(&parts.boxes) {
            let primitives: Vec<Vec3> = self
                .corners
                .par_chunks(size)
                .with_min_len(256)
                .map(|corners| {
                    let [least, greatest] = bounds(corners);
                    least + greatest
                })
                .collect();
            let mut order: Vec<u32> = (0..index_u32(primitives.len())).collect();
            gather(&primitives, &mut order);
            let at = |&primitive: &u32| &self.corners[primitive as usize * size..][..size];
            let corners: Vec<u32> = order.iter().flat_map(at).copied().collect();
            parts.boxes = boxes(&corners);
            parts.sorted = Some(Sorted {
                vertices: copies(&corners, vertices),
                order,
                corners,
            });
        }
        self.parts = Some(parts);
    }

    /// Finds the boxes of primitives, where those of parts are known: for a mesh that is drawn more than
    /// once.
    pub(super) fn look_closer(&self, program: &dyn Program, bindings: &Bindings<'_>) {
        let (Some(parts), Some(hulls)) = (&self.parts, program.hulls()) else {
            return;
        };
        let size = program.layout().topology.corners();
        parts.of_primitives.get_or_init(|| {
            let corners = parts.sorted.as_ref().map(|sorted| &sorted.corners);
            let corners = corners.unwrap_or(&self.corners);
            let of_part = |corners: &[u32]| {
                let mut boxes = Boxes {
                    middle: [[0.0; PART]; 3],
                    half: [[0.0; PART]; 3],
                };
                for (number, corners) in corners.chunks_exact(size).enumerate() {
                    let [least, greatest] = hulls.bounds(corners, bindings);
                    let middle = (least + greatest) * 0.5;
                    // A little more than rounding takes away.
                    let half = (greatest - middle).max(middle - least) * (1.0 + 1e-6);
                    for axis in 0..3 {
                        boxes.middle[axis][number] = middle[axis];
                        boxes.half[axis][number] = half[axis];
                    }
                }
                boxes
            };
            let parts = corners.par_chunks(PART * size).with_min_len(16);
            parts.map(of_part).collect()
        });
    }

    /// The boxes of a part's primitives, where they are known.
    pub(super) fn boxes(&self, part: usize) -> Option<&Boxes> {
        self.parts.as_ref()?.of_primitives.get()?.get(part)
    }

    /// The corners of a part of primitives of so many corners.
    pub(super) fn part(&self, part: usize, size: usize) -> &[u32] {
        let sorted = self.parts.as_ref().and_then(|parts| parts.sorted.as_ref());
        let corners = sorted.map_or(&self.corners, |sorted| &sorted.corners);
        let first = part * PART * size;
        &corners[first..corners.len().min(first + PART * size)]
    }

    /// The bytes of the vertices of all corners, part after part, where they were copied.
    pub(super) fn copies(&self) -> Option<&[u8]> {
        self.parts.as_ref()?.sorted.as_ref()?.vertices.as_deref()
    }

    /// The box of a part, where it is known.
    pub(super) fn bounds(&self, part: usize) -> Option<[Vec3; 2]> {
        self.parts.as_ref()?.boxes.get(part).copied()
    }

    /// The place in the order of submission of a primitive of a part.
    pub(super) fn place(&self, part: usize, primitive: usize) -> usize {
        let number = part * PART + primitive;
        let sorted = self.parts.as_ref().and_then(|parts| parts.sorted.as_ref());
        sorted.map_or(number, |sorted| sorted.order[number] as usize)
    }
}

/// The bytes of the vertices of corners; none where that is much more than all vertices.
fn copies(corners: &[u32], vertices: Option<(&Buffer, u32)>) -> Option<Vec<u8>> {
    let (buffer, stride) = vertices?;
    let stride = stride as usize;
    let of = |&corner: &u32| {
        let first = corner as usize * stride;
        &buffer.bytes[first..first + stride]
    };
    let fits = corners.len() * stride <= 2 * buffer.bytes.len() && stride.is_multiple_of(4);
    fits.then(|| corners.iter().flat_map(of).copied().collect())
}

/// Whether boxes are far larger than those of as many parts need to be: on average more than three times
/// as wide as a cube that is their share of the whole.
fn scattered(boxes: &[[Vec3; 2]]) -> bool {
    const FEW: usize = 8;
    if boxes.len() < FEW {
        return false;
    }
    let width = |[least, greatest]: &[Vec3; 2]| {
        let size = *greatest - *least;
        f64::from(size.x) + f64::from(size.y) + f64::from(size.z)
    };
    let whole = boxes.iter().fold(boxes[0], |[least, greatest], [a, b]| {
        [least.min(*a), greatest.max(*b)]
    });
    let mean = boxes.iter().map(width).sum::<f64>() / boxes.len() as f64;
    // The cube of the ratio, so that no root is needed.
    let ratio = mean / width(&whole) / 3.0;
    ratio * ratio * ratio * boxes.len() as f64 > 1.0
}

/// Orders points so that each part of them lies close together, and within parts those of each eighth:
/// halved at a multiple of that many across the longest side of their box, again and again.
fn gather(points: &[Vec3], order: &mut [u32]) {
    let together = if order.len() > PART { PART } else { PART / 8 };
    if order.len() <= together {
        return;
    }
    let at = |&number: &u32| points[number as usize];
    let first = at(&order[0]);
    let [least, greatest] = order
        .iter()
        .map(at)
        .fold([first; 2], |[a, b], point| [a.min(point), b.max(point)]);
    let size = greatest - least;
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let middle = (order.len() / 2).div_ceil(together) * together;
    order.select_nth_unstable_by(middle, |a, b| {
        at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(b))
    });
    let (one, other) = order.split_at_mut(middle);
    if together < PART {
        gather(points, one);
        gather(points, other);
        return;
    }
    rayon::join(|| gather(points, one), || gather(points, other));
}

/// The meshes of the last passes.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    known: BTreeMap<MeshKey, (Arc<Mesh>, u64)>,
    pass: u64,
}

/// After so many passes in which nobody drew it, a mesh is forgotten.
const PASSES: u64 = 8;

impl Meshes {
    /// Begins a pass: forgets what was not drawn for long.
    pub(super) fn begin_pass(&mut self) {
        self.pass += 1;
        let pass = self.pass;
        self.known.retain(|_, (_, used)| *used + PASSES >= pass);
    }

    /// The mesh of a key, made if it is not known, else looked at closer.
    pub(super) fn get<E>(
        &mut self,
        key: MeshKey,
        make: impl FnOnce() -> Result<Mesh, E>,
        look_closer: impl FnOnce(&Mesh),
    ) -> Result<Arc<Mesh>, E> {
        if let Some((mesh, used)) = self.known.get_mut(&key) {
            *used = self.pass;
            look_closer(mesh);
            return Ok(Arc::clone(mesh));
        }
        let mesh = Arc::new(make()?);
        self.known.insert(key, (Arc::clone(&mesh), self.pass));
        Ok(mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_points_are_gathered() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let points: Vec<Vec3> = (0..5000)
            .map(|_| Vec3::new(next(), next(), next()))
            .collect();
        let boxes = |order: &[u32]| -> Vec<[Vec3; 2]> {
            let parts = order.chunks(PART).map(|part| {
                let at = part.iter().map(|&number| points[number as usize]);
                let first = points[part[0] as usize];
                at.fold([first; 2], |[a, b], point| [a.min(point), b.max(point)])
            });
            parts.collect()
        };
        let mut order: Vec<u32> = (0..5000).collect();
        assert!(scattered(&boxes(&order)));
        gather(&points, &mut order);
        assert!(!scattered(&boxes(&order)));
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..5000), "every one is there once");
    }
}
