//! One pixel under the microscope: every fragment that falls on it, whatever becomes of it.
//!
//! The same set-up, edge functions, depths and fragment stages as in [`render`](super::render), by
//! the rule book's own words and without tiles, spans, lanes or anything that leaves work out. So it
//! is slow a triangle, and a second witness of what the fast way shows.

use super::by_sample::{Verdict, moved};
use super::plane::{Attributes, Edges, coordinates, depth_at};
use super::setup::{Chunk, Spare, Triangle, key, set_up, vertex_ids};
use super::view::{PixelBox, SUBPIXELS, View};
use super::{Batch, Blend, Fragment, Key, Samples};
use crate::math::{Vec4, index_u32};

/// A fragment: what a triangle is at a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbedFragment {
    /// The triangle's key.
    pub key: Key,
    /// The vertex ids of the primitive's corners, as submitted.
    pub corners: Vec<u32>,
    /// The depth at each sample that the triangle covers, at least one; of a fragment whose alpha is
    /// coverage, at those of them that are there, if any is.
    pub depths: Vec<Option<f32>>,
    /// Whether the alpha test keeps it; where alpha is coverage, whether it is there at any sample.
    pub kept: bool,
    /// Whether the triangle is seen from its front.
    pub front: bool,
    /// How it meets what is there.
    pub blend: Blend,
    /// The linear colour that it has, also where it does not show.
    pub colour: Vec4,
}

/// The fragments of batches at a pixel of a target of this size, in the order of submission.
#[must_use]
pub fn probe(
    [width, height]: [u32; 2],
    samples: Samples,
    batches: &[Batch<'_>],
    pixel: [u32; 2],
) -> Vec<ProbedFragment> {
    if pixel[0] >= width || pixel[1] >= height {
        return Vec::new();
    }
    let view = View::new(width, height, samples);
    let at = pixel.map(u32::cast_signed);
    let here = PixelBox {
        first: at,
        last: at,
    };
    let mut fragments = Vec::new();
    for (batch, number) in batches.iter().zip(0..) {
        for part in 0..index_u32(batch.geometry.parts(batch.topology)) {
            let hull = batch.geometry.hull(part as usize);
            let reaches = hull.is_none_or(|hull| {
                let reach = view.reach(&hull, batch.topology);
                reach.is_some_and(|reach| reach.pixels.meet(here).is_some())
            });
            if reaches {
                let chunk = set_up(&view, batch, [number, part], None, &mut Spare::default());
                look(&chunk, batch, samples, pixel, &mut fragments);
            }
        }
    }
    fragments
}

/// Adds the fragments of a chunk at a pixel.
fn look(
    chunk: &Chunk<'_>,
    batch: &Batch<'_>,
    samples: Samples,
    pixel: [u32; 2],
    fragments: &mut Vec<ProbedFragment>,
) {
    let at = pixel.map(u32::cast_signed);
    for triangle in &chunk.triangles {
        let pixels = triangle.pixels;
        let inside = |axis: usize| (pixels.first[axis]..=pixels.last[axis]).contains(&at[axis]);
        if !inside(0) || !inside(1) {
            continue;
        }
        let edges = Edges::of(triangle);
        let planes: Vec<Option<f32>> = samples
            .offsets()
            .iter()
            .map(|&offset| depth_of_sample(triangle, &edges, at, offset))
            .collect();
        if planes.iter().all(Option::is_none) {
            continue;
        }
        let point = Point {
            triangle,
            chunk,
            edges,
            pixel,
            samples,
        };
        let (verdict, colour) = batch.kernel.probe(&point, batch.blend);
        let depth = |(sample, plane): (usize, &Option<f32>)| {
            plane.map(|plane| (verdict.samples >> sample & 1 == 1, verdict.depth(plane)))
        };
        let depths: Vec<Option<(bool, f32)>> = planes.iter().enumerate().map(depth).collect();
        let kept = depths.iter().flatten().any(|(there, _)| *there);
        // Of a fragment that is nowhere it is told where it would be.
        let depth = |depth: &(bool, f32)| (depth.0 || !kept).then_some(depth.1);
        fragments.push(ProbedFragment {
            key: key(batch, triangle),
            corners: vertex_ids(batch, chunk, triangle).collect(),
            depths: depths
                .iter()
                .map(|at| at.as_ref().and_then(depth))
                .collect(),
            kept,
            front: triangle.front,
            blend: batch.blend,
            colour,
        });
    }
}

/// The depth at a sample of a pixel, if the triangle covers it.
fn depth_of_sample(
    triangle: &Triangle,
    edges: &Edges,
    [x, y]: [i32; 2],
    offset: [i32; 2],
) -> Option<f32> {
    let [dx, dy] = offset.map(|offset| i64::from(offset - SUBPIXELS / 2));
    let centre = edges.at_pixel(x, y);
    let at: [i64; 3] =
        std::array::from_fn(|k| centre[k] + (edges.right[k] * dx + edges.down[k] * dy));
    let covered = (0..3).all(|k| at[k] + edges.bias[k] >= 0);
    covered.then(|| depth_at(triangle, coordinates([at[1], at[2]])))
}

/// A pixel of a triangle.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug)]
pub struct Point<'a> {
    triangle: &'a Triangle,
    chunk: &'a Chunk<'a>,
    edges: Edges,
    pixel: [u32; 2],
    samples: Samples,
}

impl Point<'_> {
    /// What the fragment is, and its colour.
    pub(super) fn look<F: Fragment>(&self, fragment: &F, blend: Blend) -> (Verdict, Vec4) {
        let [x, y] = self.pixel.map(u32::cast_signed);
        let [_, second, third] = self.edges.at_pixel(x, y);
        let centre = coordinates([second, third]);
        let depth = depth_at(self.triangle, centre);
        let attributes = Attributes::of::<F>(self.triangle, &self.edges, self.chunk);
        attributes.pixel::<F, _>(centre, self.pixel, depth, |pixel| match blend {
            Blend::Opaque => (
                Verdict::of(fragment, pixel, self.samples),
                fragment.shade(&moved(fragment, pixel)),
            ),
            Blend::Alpha | Blend::AlphaAndDepth | Blend::Sorted | Blend::Add => {
                (Verdict::tested(fragment, pixel), fragment.shade(pixel))
            }
        })
    }
}
