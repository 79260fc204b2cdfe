//! The programs that expand skeletons: they are called with nodes, or needles, and emit what a level has there.

use super::expand::{End, Ends};
use super::lines::{Seen, line_fragments};
use super::parameters::{PARAMETER_SLOT, Parameters};
use crate::gpu::{Bindings, Blend, Geometry, Kernel, Layout, Program, Topology, VertexCall, Words};
use crate::math::Vec3;
use crate::models::trunk::MeshProgram;
use crate::simplify::{BranchErrors, ErrorStep, Frame, RouteChange, SkeletalVector, upright_frame};

/// The slot of the instance's step.
pub(super) const STEP_SLOT: u32 = 4;
/// The slot of skeletal vectors, or of needles.
pub(super) const NODE_SLOT: u32 = 5;
/// The slot of the ways from the base.
pub(super) const ALONG_SLOT: u32 = 6;
/// The slot of where each node's routes begin; the highest bit says that a branch ends there.
pub(super) const FIRST_SLOT: u32 = 7;
/// The slot of routes.
pub(super) const ROUTE_SLOT: u32 = 8;

/// The bit of a route's first place that says that the node is a branch's last.
pub(super) const TIP_BIT: u32 = 1 << 31;

/// Words of a needle: both ends, the radius, the first step that has it and the first that has not.
pub(super) const NEEDLE_WORDS: usize = 8;

/// Numbers of vertices a node: rings of two ends, an apex, a cap.
const IDS: u32 = 512;
const APEX: u32 = 256;

/// What is expanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::models) enum Of {
    /// Polygons of internodes.
    WoodPolygons,
    /// Lines of internodes.
    WoodLines,
    /// Polygons of needles.
    NeedlePolygons,
    /// Lines of needles.
    NeedleLines,
}

impl Of {
    pub(super) fn is_lines(self) -> bool {
        matches!(self, Self::WoodLines | Self::NeedleLines)
    }

    fn is_wood(self) -> bool {
        matches!(self, Self::WoodPolygons | Self::WoodLines)
    }

    /// Corners a node: a primitive for each, whatever comes of it.
    pub(super) fn corners(self) -> u32 {
        if self.is_lines() { 2 } else { 3 }
    }
}

/// The program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::models) struct SkeletonProgram(pub(in crate::models) Of);

impl Program for SkeletonProgram {
    fn layout(&self) -> Layout {
        let Self(of) = *self;
        Layout {
            name: match of {
                Of::WoodPolygons => "branch skeleton polygons",
                Of::WoodLines => "branch skeleton lines",
                Of::NeedlePolygons => "needle polygons",
                Of::NeedleLines => "needle lines",
            },
            version: 1,
            topology: if of.is_lines() {
                Topology::LineList
            } else {
                Topology::TriangleList
            },
            blend: if of.is_lines() {
                Blend::Alpha
            } else {
                Blend::Opaque
            },
            vertex_stride: 0,
            // Where its routes begin and end and two of them, and of both ends vector and way from the base;
            // as if every node had an internode.
            pulled_primitive_bytes: if of.is_wood() { 8 + 8 + 2 * 56 } else { 32 },
            // What stands between the stages: a vertex as others keep it in a buffer.
            pulled_vertex_bytes: if of.is_lines() { 36 } else { 32 },
            storage_slots: if of.is_wood() { 9 } else { 6 },
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let Self(of) = *self;
        let level = Level::read(call.bindings);
        let seen = Seen::of(call);
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let size = of.corners();
        for primitive in call.corners.chunks_exact(size as usize) {
            let number = primitive[0] / size;
            let internode = if of.is_wood() {
                level.wood(number, storage)
            } else {
                level.needle(number, storage(NODE_SLOT))
            };
            let Some(internode) = internode else {
                continue;
            };
            let most = level.parameters.most_edges;
            let circles = (level.errors.polygon, most);
            if of.is_lines() {
                let BranchErrors {
                    polygon, epsilon, ..
                } = level.errors;
                let alpha = level.parameters.alpha;
                let opaque = alpha.opaque_width(polygon, epsilon);
                let normals = level.parameters.normals();
                let lines = (0..).zip(internode.lines(circles, (normals, alpha, opaque)));
                for (line, ends) in lines {
                    let ids = [internode.start.ring, internode.end.ring].map(|ring| ring + line);
                    seen.line(&ends, ids, &level.parameters, geometry);
                }
            } else {
                internode.polygons(circles, (&seen.view, &seen.placement), geometry);
            }
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        if self.0.is_lines() {
            line_fragments(bindings)
        } else {
            MeshProgram.fragment_stage(bindings)
        }
    }
}

/// Which level an instance shows.
struct Level {
    parameters: Parameters,
    step: ErrorStep,
    errors: BranchErrors,
}

impl Level {
    fn read(bindings: &Bindings<'_>) -> Self {
        let parameters = Parameters::read(bindings.storage(PARAMETER_SLOT as usize));
        let step = bindings.storage(STEP_SLOT as usize).u32(0);
        let step = ErrorStep::new(u16::try_from(step).unwrap_or(u16::MAX));
        Self {
            parameters,
            step,
            errors: parameters.errors(step),
        }
    }

    /// The internode that ends at a node, if one does.
    fn wood<'a>(&self, node: u32, storage: impl Fn(u32) -> Words<'a>) -> Option<Ends> {
        let [first, next] = storage(FIRST_SLOT).u32s(node as usize);
        let [from, to] = [first, next].map(|place| place & !TIP_BIT);
        let routes = storage(ROUTE_SLOT);
        let route = |place: u32| RouteChange::of_word(routes.u32(place as usize));
        // The last change up to the step, by halving.
        let (mut low, mut high) = (from, to);
        while low < high {
            let middle = u32::midpoint(low, high);
            if route(middle).step <= self.step {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let back = if low > from { route(low - 1).back } else { 0 };
        let start = node.checked_sub(back).filter(|_| back > 0)?;
        let end = |node: u32| End {
            vector: read_vector(storage(NODE_SLOT), node),
            along: storage(ALONG_SLOT).f32(node as usize),
            ring: IDS * node,
        };
        Some(Ends {
            start: end(start),
            end: end(node),
            apex: IDS * node + APEX,
            is_tip: first & TIP_BIT != 0,
        })
    }

    /// A needle, if the level has it.
    fn needle(&self, needle: u32, needles: Words<'_>) -> Option<Ends> {
        let first = NEEDLE_WORDS * needle as usize;
        let steps = needles.u32(first + NEEDLE_WORDS - 1);
        let step = u32::from(self.step.number());
        if step < steps >> 16 || step >= steps & 0xffff {
            return None;
        }
        let [x, y, z, tip_x, tip_y, tip_z, radius] = needles.f32s(first);
        let ends = [Vec3::new(x, y, z), Vec3::new(tip_x, tip_y, tip_z)];
        let frame = upright_frame((ends[1] - ends[0]).normalize_or(Vec3::Y));
        let end = |end: usize, along| End {
            vector: SkeletalVector {
                position: ends[end],
                radius,
                frame,
            },
            along,
            ring: IDS * needle + if end == 0 { 0 } else { APEX / 2 },
        };
        Some(Ends {
            start: end(0, 0.0),
            end: end(1, ends[0].distance(ends[1])),
            apex: IDS * needle + APEX,
            is_tip: true,
        })
    }
}

fn read_vector(vectors: Words<'_>, node: u32) -> SkeletalVector {
    let floats: [f32; 13] = vectors.f32s(13 * node as usize);
    let vector = |first: usize| Vec3::new(floats[first], floats[first + 1], floats[first + 2]);
    SkeletalVector {
        position: vector(0),
        radius: floats[3],
        frame: Frame {
            tangent: vector(4),
            normal: vector(7),
            binormal: vector(10),
        },
    }
}
