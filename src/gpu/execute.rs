//! Executes passes: runs vertex stages, hands geometry to the rasterizer, counts.

use std::borrow::Cow;

use rayon::prelude::{IntoParallelIterator as _, ParallelIterator as _};

use super::assemble::{fetched, fetched_bytes, windows};
use super::card::DrawWork;
use super::ledger::{Cause, Ledger, Stream, WorkCounts};
use super::mesh::Meshes;
use super::pass::{Corners, Load, RenderPass};
use super::plan::{Plan, PlannedDraw, plan};
use super::program::{Bindings, Transform, VertexCall, Words};
use super::{Device, GpuError};
use crate::math::index_u32;
use crate::raster::{
    self, ALL, Batch, Boxes, Counters, Geometry, Hull, Instructions, Kernel, PART, Part,
    ProbedFragment, Skips, Source, Target, Topology, nth,
};

/// The most corners of a primitive.
const MAX_CORNERS: usize = 4;

/// Why bytes are pulled by draws.
const FETCH: Cause = Cause::of("draw");

/// Executes one pass, or refuses it whole.
pub(super) fn render(device: &mut Device, pass: &RenderPass) -> Result<(), GpuError> {
    device.target(pass.target)?;
    let mut meshes = std::mem::take(&mut device.meshes);
    let plan = plan(device, &mut meshes, pass);
    device.meshes = meshes;
    let plan = plan?;
    watch_reads(device, &plan);
    let mut slot = device.targets[pass.target.index() as usize]
        .take()
        .expect("checked above");
    if let Load::Clear { color, depth } = pass.load {
        slot.target.clear(color, depth);
    }
    let (outcomes, skips) = draw(device, &plan, &mut slot.target);
    device.skips = skips;
    device.targets[pass.target.index() as usize] = Some(slot);
    count(device, &plan, &outcomes);
    Ok(())
}

/// Checks and counts one pass as [`render`] does, and draws nothing: no sample is visible.
pub(super) fn tally(device: &mut Device, pass: &RenderPass) -> Result<(), GpuError> {
    if device.descriptor.raster.counters == Counters::Exact {
        let what = "exact counters of a pass that is not drawn".to_owned();
        return Err(GpuError::Unsupported { what });
    }
    device.target(pass.target)?;
    let mut meshes = std::mem::take(&mut device.meshes);
    let plan = plan(device, &mut meshes, pass);
    device.meshes = meshes;
    let plan = plan?;
    let outcomes = vec![Outcome::default(); plan.draws.len()];
    count(device, &plan, &outcomes);
    Ok(())
}

/// Draws a plan; answers what came of each draw.
fn draw(device: &Device, plan: &Plan, target: &mut Target) -> (Vec<Outcome>, Skips) {
    let options = device.descriptor.raster;
    let sources = sources(device, plan);
    let kernels = kernels(&sources);
    let batches = batches(&sources, &kernels);
    let rendered = raster::render_on(device.machine, target, &batches, &options);
    let counted = options.counters == Counters::Exact;
    let outcomes = rendered
        .works
        .into_iter()
        .zip(&sources)
        .map(|(work, source)| {
            let pulls = counted && source.draw.state.program.layout().pulled_vertex_bytes > 0;
            let [emitted_vertices, emitted_primitives] =
                if pulls { source.emitted() } else { [0; 2] };
            Outcome {
                work,
                emitted_vertices,
                emitted_primitives,
            }
        });
    (outcomes.collect(), rendered.skips)
}

/// Every fragment of a pass at one pixel, as if it were executed; nothing is drawn or counted.
pub(super) fn probe(
    device: &Device,
    pass: &RenderPass,
    pixel: [u32; 2],
) -> Result<Vec<ProbedFragment>, GpuError> {
    let target = &device.target(pass.target)?.target;
    let (size, samples) = ([target.width(), target.height()], target.samples());
    let plan = plan(device, &mut Meshes::default(), pass)?;
    let sources = sources(device, &plan);
    let kernels = kernels(&sources);
    let batches = batches(&sources, &kernels);
    Ok(raster::probe(size, samples, &batches, pixel))
}

/// A draw as the rasterizer asks for it: the vertex stage runs part by part.
#[derive(Debug)]
struct DrawSource<'a> {
    draw: &'a PlannedDraw,
    bindings: Bindings<'a>,
    /// What takes the boxes of parts to clip space, where there are boxes.
    transform: Option<Transform>,
    instructions: Instructions,
}

fn sources<'a>(device: &'a Device, plan: &'a Plan) -> Vec<DrawSource<'a>> {
    let source = |draw: &'a PlannedDraw| {
        let bindings = draw.state.bindings(device);
        let hulls = draw.state.program.hulls();
        let known = hulls.filter(|_| draw.mesh.bounds(0).is_some());
        DrawSource {
            draw,
            transform: known.map(|hulls| hulls.transform(&bindings, draw.instance)),
            bindings,
            instructions: device.machine.instructions,
        }
    };
    plan.draws.iter().map(source).collect()
}

fn kernels<'a>(sources: &[DrawSource<'a>]) -> Vec<Box<dyn Kernel + 'a>> {
    let kernel = |source: &DrawSource<'a>| {
        let program = &source.draw.state.program;
        program.fragment_stage(&source.bindings)
    };
    sources.iter().map(kernel).collect()
}

fn batches<'b>(
    sources: &'b [DrawSource<'_>],
    kernels: &'b [Box<dyn Kernel + '_>],
) -> Vec<Batch<'b>> {
    let kernels = kernels.iter().map(|kernel| &**kernel);
    let batch = |(source, kernel): (&'b DrawSource<'_>, &'b dyn Kernel)| Batch {
        geometry: source,
        topology: source.draw.topology,
        kernel,
        blend: source.draw.state.program.layout().blend,
        group: source.draw.group,
        instance: source.draw.instance,
    };
    sources.iter().zip(kernels).map(batch).collect()
}

impl DrawSource<'_> {
    fn emit(&self, part: usize, wanted: u64, mut geometry: Geometry) -> Geometry {
        let size = self.draw.topology.corners();
        let all = self.draw.mesh.part(part, size);
        let copies = self.draw.mesh.copies();
        // Primitives that are wanted, and where their vertices are among the copies.
        let (mut corners, mut places) = ([0; PART * MAX_CORNERS], [0; PART * MAX_CORNERS]);
        let first = index_u32(PART * part);
        let into = [&mut corners, &mut places];
        let count = match self.draw.topology {
            Topology::TriangleList => choose::<3>(all, wanted, first, into),
            Topology::QuadList => choose::<4>(all, wanted, first, into),
            Topology::LineList => choose::<2>(all, wanted, first, into),
        };
        let call = VertexCall {
            corners: &corners[..count],
            places: match copies {
                Some(_) => &places[..count],
                None => &corners[..count],
            },
            vertices: match copies {
                Some(copies) => Words::of_bytes(copies),
                None => self.bindings.vertices(),
            },
            instance: self.draw.instance,
            bindings: &self.bindings,
            instructions: self.instructions,
        };
        geometry.clear();
        self.draw.state.program.vertex_stage(&call, &mut geometry);
        geometry
    }

    /// How many vertices and primitives the vertex stage emits.
    fn emitted(&self) -> [u64; 2] {
        let topology = self.draw.topology;
        let emitted = (0..self.parts(topology)).into_par_iter().map(|part| {
            let geometry = self.emit(part, ALL, Geometry::default());
            [geometry.clip.len(), geometry.primitive_count(topology)].map(|count| count as u64)
        });
        let emitted: Vec<[u64; 2]> = emitted.collect();
        let add = |[a, b]: [u64; 2], [c, d]: [u64; 2]| [a + c, b + d];
        emitted.into_iter().fold([0; 2], add)
    }
}

impl Source for DrawSource<'_> {
    fn parts(&self, topology: Topology) -> usize {
        let corners = self.draw.mesh.corners.len();
        (corners / topology.corners()).div_ceil(PART)
    }

    fn hull(&self, part: usize) -> Option<Hull> {
        let Transform { columns, slack } = self.transform?;
        let [least, greatest] = self.draw.mesh.bounds(part)?;
        let corners = [least, greatest].map(|corner| corner.to_array().map(f64::from));
        let farthest: f64 = (0..3)
            .map(|axis| corners[0][axis].abs().max(corners[1][axis].abs()))
            .sum();
        Some(Hull {
            corners,
            clip: columns,
            slack: std::array::from_fn(|row| slack[0][row] + farthest * slack[1][row]),
        })
    }

    fn boxes(&self, part: usize) -> Option<&Boxes> {
        self.draw.mesh.boxes(part)
    }

    fn part(&self, part: usize, topology: Topology, wanted: u64, spare: Geometry) -> Part<'_> {
        let geometry = self.emit(part, wanted, spare);
        Part {
            primitives: 0..geometry.primitive_count(topology),
            geometry: Cow::Owned(geometry),
        }
    }

    fn place(&self, part: usize, wanted: u64, primitive: usize) -> usize {
        self.draw.mesh.place(part, nth(wanted, primitive))
    }
}

/// Lists the corners of the wanted primitives of a part, and their numbers among the corners of all parts;
/// the part's first primitive has this number. Answers how many there are.
fn choose<const CORNERS: usize>(
    all: &[u32],
    wanted: u64,
    first: u32,
    [corners, places]: [&mut [u32; PART * MAX_CORNERS]; 2],
) -> usize {
    let corners = corners.as_chunks_mut::<CORNERS>().0.iter_mut();
    let mut rooms = corners.zip(places.as_chunks_mut::<CORNERS>().0);
    let mut count = 0;
    for (number, primitive) in (0_u32..).zip(all.as_chunks::<CORNERS>().0) {
        if wanted >> number & 1 == 1
            && let Some((corners, places)) = rooms.next()
        {
            *corners = *primitive;
            let place = (first + number) * index_u32(CORNERS);
            for (to, place) in places.iter_mut().zip(place..) {
                *to = place;
            }
            count += CORNERS;
        }
    }
    count
}

/// What came of a draw.
#[derive(Debug, Clone, Copy, Default)]
struct Outcome {
    work: raster::Work,
    /// Vertices that the vertex stage emitted.
    emitted_vertices: u64,
    /// Primitives that it emitted.
    emitted_primitives: u64,
}

/// Marks what the input assembler reads, and lets programs mark the rest.
fn watch_reads(device: &mut Device, plan: &Plan) {
    let Some(mut reads) = device.reads.take() else {
        return;
    };
    for (id, range) in &plan.argument_reads {
        reads.watch(
            *id,
            device.buffer(*id).map_or(0, |buffer| buffer.bytes.len()),
        );
        reads.mark(*id, range.clone());
    }
    for draw in &plan.draws {
        let state = &draw.state;
        let bound = state
            .storage
            .into_iter()
            .flatten()
            .chain(state.vertices)
            .chain(state.indices);
        for id in bound {
            reads.watch(id, device.buffer(id).map_or(0, |buffer| buffer.bytes.len()));
        }
        if let (1.., Some(id)) = (draw.source.index_bytes(), state.indices) {
            for &(first, count) in &draw.runs {
                let size = draw.source.index_bytes() as usize;
                let first = size * first as usize;
                reads.mark(id, first..first + size * count as usize);
            }
        }
        if let Ok((indices, vertices)) = state.inputs(device, draw.source) {
            let key = (draw.group, draw.instance);
            let of_draw = if draw.source == Corners::Strips {
                let primitives = windows(draw.submitted()).map(|(_, corners)| &corners[..]);
                fetched(key, primitives, indices, vertices)
            } else {
                let per_primitive = draw.topology.corners();
                let primitives = draw.mesh.corners.chunks_exact(per_primitive);
                fetched(key, primitives, indices, vertices)
            };
            reads.fetched.extend(of_draw);
        }
    }
    device.reads = Some(reads);
}

/// Enters a pass into the ledger; `outcomes` holds what came of each draw.
fn count(device: &mut Device, plan: &Plan, outcomes: &[Outcome]) {
    let exact = device.descriptor.raster.counters == Counters::Exact;
    let mut pulled = plan.pulled.clone();
    let mut ticks = 0;
    let mut sums = Ledger {
        command_bytes: plan.command_bytes,
        ..Ledger::default()
    };
    for (draw, outcome) in plan.draws.iter().zip(outcomes) {
        let (vertices, primitives) = draw.sizes();
        sums.draws += draw.draws;
        sums.empty_draws += draw.empty_draws;
        sums.vertices += vertices;
        sums.primitives += primitives;
        // Of stages that make more than they are given, what they make.
        let set_up = primitives.max(outcome.emitted_primitives);
        let triangles = match draw.topology {
            Topology::TriangleList | Topology::LineList => set_up,
            Topology::QuadList => 2 * set_up,
        };
        let layout = draw.state.program.layout();
        let mut input_bytes = u64::from(layout.pulled_primitive_bytes) * primitives
            + u64::from(layout.pulled_vertex_bytes) * outcome.emitted_vertices;
        if let Ok((indices, inputs)) = draw.state.inputs(device, draw.source) {
            let index_count = draw.corner_count();
            input_bytes += u64::from(draw.source.index_bytes()) * index_count;
            input_bytes += inputs.map_or(0, |(_, stride)| u64::from(stride) * vertices);
            let (index_bytes, vertex_bytes) =
                fetched_bytes(draw.source, draw.submitted(), index_count, indices, inputs);
            for (bytes, buffer) in [(index_bytes, indices), (vertex_bytes, inputs.map(|i| i.0))] {
                if let (1.., Some(buffer)) = (bytes, buffer) {
                    pulled.push((buffer.label.clone(), bytes));
                }
            }
        }
        ticks += device.descriptor.card.ticks(&DrawWork {
            vertices: vertices.max(outcome.emitted_vertices),
            triangles,
            covered: outcome.work.covered,
            visible: outcome.work.visible,
            texels: outcome.work.texels,
            input_bytes,
        });
    }
    let works: Vec<raster::Work> = outcomes.iter().map(|outcome| outcome.work).collect();
    let work = raster::Work::total(&works);
    sums.visible_samples = work.visible;
    if exact {
        sums.work = Some(WorkCounts {
            covered: work.covered,
            alpha_killed: work.alpha_killed,
            hidden: work.covered - work.alpha_killed - work.visible,
            texels: work.texels,
        });
        sums.gpu_ticks = Some(ticks);
    }
    device.bus.ledger().add(&sums);
    for (label, bytes) in pulled {
        device.bus.move_bytes(Stream::Fetch, &label, FETCH, bytes);
    }
}
