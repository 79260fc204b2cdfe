//! Executes passes: runs vertex stages, hands geometry to the rasterizer, counts.

use rayon::prelude::{
    IntoParallelIterator as _, IntoParallelRefIterator as _, ParallelIterator as _,
};

use super::assemble::{fetched, fetched_bytes, windows};
use super::card::DrawWork;
use super::ledger::{Cause, Ledger, Stream, WorkCounts};
use super::parts::{CORNER_BYTES, Reach, parts};
use super::pass::{Corners, Load, RenderPass};
use super::plan::{Plan, corners_per_primitive, plan};
use super::program::{Bindings, VertexCall};
use super::{Device, GpuError};
use crate::raster::{
    self, Batch, Counters, Geometry, Kernel, ProbedFragment, Region, Target, Topology,
};

/// Primitives a call of a vertex stage: a constant, so that threads cannot be seen.
const PRIMITIVES_PER_CALL: usize = 2048;

/// Why bytes are pulled by draws.
const FETCH: Cause = Cause::of("draw");

/// Executes one pass, or refuses it whole.
pub(super) fn render(device: &mut Device, pass: &RenderPass) -> Result<(), GpuError> {
    device.target(pass.target)?;
    let plan = plan(device, pass)?;
    watch_reads(device, &plan);
    let mut slot = device.targets[pass.target.index() as usize]
        .take()
        .expect("checked above");
    if let Load::Clear { color, depth } = pass.load {
        slot.target.clear(color, depth);
    }
    let outcomes = draw(device, &plan, &mut slot.target);
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
    let plan = plan(device, pass)?;
    let outcomes = vec![Outcome::default(); plan.draws.len()];
    count(device, &plan, &outcomes);
    Ok(())
}

/// Draws a plan, part by part of the target if its geometry is too much at once; answers what came of
/// each draw.
fn draw(device: &Device, plan: &Plan, target: &mut Target) -> Vec<Outcome> {
    let options = device.descriptor.raster;
    let stages = Stages::of(device, plan);
    let mut outcomes = vec![Outcome::default(); plan.draws.len()];
    let corners: usize = plan.draws.iter().map(|draw| draw.corners.len()).sum();
    if CORNER_BYTES * corners as u64 <= device.geometry_bytes {
        let all: Vec<usize> = (0..stages.calls.len()).collect();
        stages.with_batches(&all, |batches| {
            let works = raster::render(target, batches, &options);
            for ((&(draw, _), work), batch) in stages.calls.iter().zip(&works).zip(batches) {
                outcomes[draw].add(work, batch.geometry.clip.len());
            }
        });
        return outcomes;
    }
    let size = [target.width(), target.height()];
    let reaches = stages.reaches(size);
    for (&(draw, _), reach) in stages.calls.iter().zip(&reaches) {
        outcomes[draw].add(&raster::Work::default(), reach.emitted_vertices);
    }
    for part in parts(size, &reaches, device.geometry_bytes) {
        stages.with_batches(&part.calls, |batches| {
            let works = raster::render_region(target, batches, &options, part.region);
            for (&call, work) in part.calls.iter().zip(&works) {
                outcomes[stages.calls[call].0].add(work, 0);
            }
        });
    }
    outcomes
}

/// Every fragment of a pass at one pixel, as if it were executed; nothing is drawn or counted.
pub(super) fn probe(
    device: &Device,
    pass: &RenderPass,
    pixel: [u32; 2],
) -> Result<Vec<ProbedFragment>, GpuError> {
    let target = &device.target(pass.target)?.target;
    let (size, samples) = ([target.width(), target.height()], target.samples());
    let plan = plan(device, pass)?;
    let stages = Stages::of(device, &plan);
    let block = Region::around(pixel);
    let reaches = stages.reaches(size);
    let reaching = (0..stages.calls.len())
        .filter(|&call| reaches[call].region.is_some_and(|found| found.meets(block)));
    Ok(
        stages.with_batches(&reaching.collect::<Vec<_>>(), |batches| {
            raster::probe(size, samples, batches, pixel)
        }),
    )
}

/// The stages of a pass with what they read, their work cut into calls.
struct Stages<'a> {
    plan: &'a Plan,
    bound: Vec<Bindings<'a>>,
    kernels: Vec<Box<dyn Kernel + 'a>>,
    /// The draw that each call of a vertex stage is part of, and its corners.
    calls: Vec<(usize, &'a [u32])>,
}

impl<'a> Stages<'a> {
    fn of(device: &'a Device, plan: &'a Plan) -> Self {
        let draws = plan.draws.iter();
        let bound: Vec<Bindings<'a>> = draws.map(|draw| draw.state.bindings(device)).collect();
        let kernels = plan
            .draws
            .iter()
            .zip(&bound)
            .map(|(draw, bindings)| draw.state.program.fragment_stage(bindings))
            .collect();
        let calls = plan.draws.iter().enumerate().flat_map(|(number, draw)| {
            let chunk = PRIMITIVES_PER_CALL * corners_per_primitive(draw.topology);
            draw.corners
                .chunks(chunk)
                .map(move |corners| (number, corners))
        });
        Self {
            plan,
            calls: calls.collect(),
            kernels,
            bound,
        }
    }

    /// What a call of a vertex stage emits.
    fn emit(&self, call: usize) -> Geometry {
        let (number, corners) = self.calls[call];
        let draw = &self.plan.draws[number];
        let mut geometry = Geometry::default();
        let call = VertexCall {
            corners,
            instance: draw.instance,
            bindings: &self.bound[number],
        };
        draw.state.program.vertex_stage(&call, &mut geometry);
        geometry
    }

    /// Where each call may show on a target of this size.
    fn reaches(&self, size: [u32; 2]) -> Vec<Reach> {
        let reach = |call: usize| {
            let geometry = self.emit(call);
            let (number, corners) = self.calls[call];
            Reach {
                region: Region::of(size, &geometry),
                blend: self.plan.draws[number].state.program.layout().blend,
                corners: corners.len(),
                emitted_vertices: geometry.clip.len(),
            }
        };
        (0..self.calls.len()).into_par_iter().map(reach).collect()
    }

    /// Runs the vertex stages of some calls, and `use_batches` on what comes of them.
    fn with_batches<R>(&self, calls: &[usize], use_batches: impl FnOnce(&[Batch<'_>]) -> R) -> R {
        let geometries: Vec<Geometry> = calls.par_iter().map(|&call| self.emit(call)).collect();
        let batches = calls.iter().zip(&geometries).map(|(&call, geometry)| {
            let number = self.calls[call].0;
            let draw = &self.plan.draws[number];
            Batch {
                geometry,
                topology: draw.topology,
                kernel: &*self.kernels[number],
                blend: draw.state.program.layout().blend,
                group: draw.group,
                instance: draw.instance,
            }
        });
        use_batches(&batches.collect::<Vec<_>>())
    }
}

/// What came of a draw.
#[derive(Debug, Clone, Copy, Default)]
struct Outcome {
    work: raster::Work,
    /// Vertices that the vertex stage emitted.
    emitted_vertices: u64,
}

impl Outcome {
    fn add(&mut self, work: &raster::Work, emitted_vertices: usize) {
        self.work = self.work.plus(work);
        self.emitted_vertices += emitted_vertices as u64;
    }
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
                let per_primitive = corners_per_primitive(draw.topology);
                let primitives = draw.corners.chunks_exact(per_primitive);
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
    let mut pulled = Vec::new();
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
        let triangles = match draw.topology {
            Topology::TriangleList | Topology::LineList => primitives,
            Topology::QuadList => 2 * primitives,
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
            vertices,
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
