//! The levels of a patch: all samples where they stand in it, as polygons and lines.

use std::ops::Range;
use std::sync::Arc;

use crate::math::{Aabb, Vec3, Vec4, index_u32};
use crate::models::{Placement, Trunk};
use crate::plant::{Material, Prototype};
use crate::simplify::{BranchMesh, BranchVertex, ErrorStep, PrimitiveCounts};

/// A tree of a patch.
#[derive(Debug, Clone)]
pub struct GroveSample {
    /// Its wood and needles; its plant has a skeleton, or it shows nothing.
    pub trunk: Arc<Trunk>,
    /// Where it stands in the patch.
    pub placement: Placement,
}

/// What of a patch lies in five buffers.
#[derive(Debug, Default)]
pub(super) struct PatchBytes {
    /// Of polygons, 28 B each: position, normal (3 × `f32` each), number of the material (`u32`).
    pub(super) vertices: Vec<u8>,
    /// `u32` each.
    pub(super) indices: Vec<u8>,
    /// Ends of lines, 32 B each: position, normal (3 × `f32` each), opacity (`f32`), number of the material
    /// (`u32`).
    pub(super) line_vertices: Vec<u8>,
    /// `u32` each.
    pub(super) line_indices: Vec<u8>,
    /// 16 B each: linear colour (3 × `f32`), 0.
    pub(super) materials: Vec<u8>,
}

/// Corners of polygons, then of lines.
type Corners = [Range<u32>; 2];

/// The levels of a patch, from fine to coarse.
#[derive(Debug)]
pub(super) struct PatchLevels {
    bytes: PatchBytes,
    /// Of each level, in the patch's metres.
    errors: Vec<f32>,
    /// Of each level the corners of each sample, one behind the other.
    samples: Vec<Vec<Corners>>,
    counts: Vec<PrimitiveCounts>,
    bounds: Aabb,
}

impl PatchLevels {
    pub(super) fn of(samples: &[GroveSample], levels: u32) -> Self {
        let mut all = Self {
            bytes: PatchBytes::default(),
            errors: Vec::new(),
            samples: Vec::new(),
            counts: Vec::new(),
            bounds: bounds_of(samples),
        };
        // Every sample has two materials, bark and needles.
        for sample in samples {
            for color in colors(&sample.trunk) {
                let floats = [color.x, color.y, color.z, 0.0];
                let bytes = floats.into_iter().flat_map(f32::to_le_bytes);
                all.bytes.materials.extend(bytes);
            }
        }
        for step in steps(samples, levels) {
            // An error of the patch: as much less of a sample that is drawn larger.
            all.errors.push(step.error());
            let mut counts = PrimitiveCounts::default();
            let mut corners = Vec::new();
            for (number, sample) in (0..).zip(samples) {
                let own = ErrorStep::within(step.error() / sample.placement.scale);
                let level = sample.trunk.branch_level(own);
                let of_level = level.counts();
                counts.quads += of_level.quads;
                counts.triangles += of_level.triangles;
                counts.lines += of_level.lines;
                let wood = all.add(&level.branches, &sample.placement, 2 * number);
                let needles = all.add(&level.needles, &sample.placement, 2 * number + 1);
                let [polygons, lines] = [0, 1].map(|what| wood[what].start..needles[what].end);
                corners.push([polygons, lines]);
            }
            all.samples.push(corners);
            all.counts.push(counts);
        }
        all
    }

    /// Appends a mesh; the corners of its polygons and lines.
    fn add(&mut self, mesh: &BranchMesh, placement: &Placement, material: u32) -> Corners {
        let bytes = &mut self.bytes;
        let mut on_line = vec![false; mesh.vertices.len()];
        for &vertex in mesh.lines.iter().flatten() {
            on_line[vertex as usize] = true;
        }
        let mut numbers = Vec::with_capacity(mesh.vertices.len());
        for (vertex, on_line) in mesh.vertices.iter().zip(on_line) {
            let (buffer, stride) = if on_line {
                (&mut bytes.line_vertices, 32)
            } else {
                (&mut bytes.vertices, 28)
            };
            numbers.push(index_u32(buffer.len() / stride));
            let BranchVertex {
                position,
                normal,
                alpha,
                ..
            } = *vertex;
            let position = placement.to_world(position).to_array();
            let normal = (placement.rotation * normal).to_array();
            let floats = position.into_iter().chain(normal);
            buffer.extend(floats.flat_map(f32::to_le_bytes));
            if on_line {
                buffer.extend(alpha.to_le_bytes());
            }
            buffer.extend(material.to_le_bytes());
        }
        let polygons = mesh.drawn_triangles().flatten();
        let lines = mesh.lines.iter().copied().flatten();
        [
            append(&mut bytes.indices, &numbers, polygons),
            append(&mut bytes.line_indices, &numbers, lines),
        ]
    }

    pub(super) fn bytes(&self) -> &PatchBytes {
        &self.bytes
    }

    pub(super) fn count(&self) -> usize {
        self.errors.len()
    }

    pub(super) fn errors(&self) -> &[f32] {
        &self.errors
    }

    pub(super) fn counts(&self, level: usize) -> PrimitiveCounts {
        self.counts[level]
    }

    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    pub(super) fn sample_count(&self) -> u32 {
        index_u32(self.samples.first().map_or(0, Vec::len))
    }

    /// The corners of a sample at a level.
    pub(super) fn sample(&self, level: usize, sample: u32) -> Corners {
        self.samples[level][sample as usize].clone()
    }

    /// The corners of all samples at a level.
    pub(super) fn whole(&self, level: usize) -> Corners {
        let samples = &self.samples[level];
        [0, 1].map(|what| match (samples.first(), samples.last()) {
            (Some(first), Some(last)) => first[what].start..last[what].end,
            _ => 0..0,
        })
    }

    /// The patch's box and the error of each level, as the device reads them.
    pub(super) fn table_bytes(&self) -> Vec<u8> {
        let Aabb { min, max } = self.bounds;
        let corners = [min, max].map(|corner| corner.to_array());
        let floats = corners.as_flattened().iter().chain(&self.errors);
        floats.flat_map(|float| float.to_le_bytes()).collect()
    }
}

/// Appends corners by the numbers of their vertices; where they lie.
fn append(buffer: &mut Vec<u8>, numbers: &[u32], corners: impl Iterator<Item = u32>) -> Range<u32> {
    let start = index_u32(buffer.len() / 4);
    let numbers = corners.map(|vertex| numbers[vertex as usize]);
    buffer.extend(numbers.flat_map(u32::to_le_bytes));
    start..index_u32(buffer.len() / 4)
}

/// The errors of the levels: evenly from the finest that a sample asks for to the coarsest.
fn steps(samples: &[GroveSample], levels: u32) -> Vec<ErrorStep> {
    let ends = samples
        .iter()
        .map(|sample| sample.trunk.branch_choice().steps());
    let Some([finest, coarsest]) = ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]) else {
        return vec![ErrorStep::FINEST];
    };
    let last = levels.clamp(1, 8) - 1;
    let mut steps: Vec<ErrorStep> = (0..=last)
        .map(|level| finest.towards(coarsest, level, last.max(1)))
        .collect();
    steps.dedup();
    steps
}

/// The linear colours of bark and of needles.
fn colors(trunk: &Trunk) -> [Vec3; 2] {
    let of = |material: &Material| Vec4::from_array(material.base_color).truncate();
    let bark = of(&trunk.mesh().material);
    let mut groups = trunk.plant().foliage().groups.iter();
    let needles = groups.find(|group| matches!(group.prototype, Prototype::Needle { .. }));
    let needles = needles.map_or(bark, |group| of(&group.material));
    [bark, needles]
}

/// A box around all samples, and around what is put in their place at any level.
fn bounds_of(samples: &[GroveSample]) -> Aabb {
    let mut all: Option<Aabb> = None;
    for sample in samples {
        let bounds = sample.trunk.branches().bounds();
        let [_, coarsest] = sample.trunk.branch_choice().steps();
        let room = Vec3::splat(coarsest.error());
        let [least, greatest] = [bounds.min - room, bounds.max + room];
        for corner in 0..8_u32 {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    least[axis]
                } else {
                    greatest[axis]
                }
            };
            let point = sample
                .placement
                .to_world(Vec3::new(pick(0), pick(1), pick(2)));
            all = Some(match all {
                None => Aabb {
                    min: point,
                    max: point,
                },
                Some(Aabb { min, max }) => Aabb {
                    min: min.min(point),
                    max: max.max(point),
                },
            });
        }
    }
    all.unwrap_or(Aabb {
        min: Vec3::ZERO,
        max: Vec3::ZERO,
    })
}
