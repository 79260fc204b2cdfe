//! Executes passes: runs vertex stages, hands geometry to the rasterizer, counts.

use rayon::prelude::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::assemble::{fetched, fetched_bytes};
use super::card::DrawWork;
use super::ledger::{Cause, Ledger, Stream, WorkCounts};
use super::pass::{Load, RenderPass};
use super::plan::{Plan, corners_per_primitive, plan};
use super::program::{Bindings, VertexCall};
use super::{Device, GpuError};
use crate::raster::{self, Batch, Counters, Geometry, Kernel, ProbedFragment, Topology};

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
    let options = device.descriptor.raster;
    let outcomes = with_batches(device, &plan, |geometry| {
        let of_batch = raster::render(&mut slot.target, &geometry.batches, &options);
        let mut of_draw = vec![Outcome::default(); plan.draws.len()];
        for ((&draw, work), batch) in geometry.draws.iter().zip(&of_batch).zip(&geometry.batches) {
            let outcome = &mut of_draw[draw];
            outcome.work = outcome.work.plus(work);
            outcome.emitted_vertices += batch.geometry.clip.len() as u64;
        }
        of_draw
    });
    device.targets[pass.target.index() as usize] = Some(slot);
    count(device, &plan, &outcomes);
    Ok(())
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
    Ok(with_batches(device, &plan, |geometry| {
        raster::probe(size, samples, &geometry.batches, pixel)
    }))
}

/// What the vertex stages of a pass hand to the rasterizer.
struct PassGeometry<'a> {
    batches: Vec<Batch<'a>>,
    /// The draw that each batch is part of.
    draws: Vec<usize>,
}

/// Runs the vertex stages of a pass, and `use_batches` on what comes of them.
fn with_batches<R>(
    device: &Device,
    plan: &Plan,
    use_batches: impl FnOnce(&PassGeometry<'_>) -> R,
) -> R {
    let bound: Vec<Bindings<'_>> = plan
        .draws
        .iter()
        .map(|draw| draw.state.bindings(device))
        .collect();
    let kernels: Vec<Box<dyn Kernel + '_>> = plan
        .draws
        .iter()
        .zip(&bound)
        .map(|(draw, bindings)| draw.state.program.fragment_stage(bindings))
        .collect();
    let calls: Vec<(usize, &[u32])> = plan
        .draws
        .iter()
        .enumerate()
        .flat_map(|(number, draw)| {
            let chunk = PRIMITIVES_PER_CALL * corners_per_primitive(draw.topology);
            draw.corners
                .chunks(chunk)
                .map(move |corners| (number, corners))
        })
        .collect();
    let geometries: Vec<Geometry> = calls
        .par_iter()
        .map(|&(number, corners)| {
            let draw = &plan.draws[number];
            let mut geometry = Geometry::default();
            let instance = draw.instance;
            let call = VertexCall {
                corners,
                instance,
                bindings: &bound[number],
            };
            draw.state.program.vertex_stage(&call, &mut geometry);
            geometry
        })
        .collect();
    let batches = calls
        .iter()
        .zip(&geometries)
        .map(|(&(number, _), geometry)| {
            let draw = &plan.draws[number];
            Batch {
                geometry,
                topology: draw.topology,
                kernel: &*kernels[number],
                blend: draw.state.program.layout().blend,
                group: draw.group,
                instance: draw.instance,
            }
        });
    use_batches(&PassGeometry {
        batches: batches.collect(),
        draws: calls.iter().map(|&(number, _)| number).collect(),
    })
}

/// What came of a draw.
#[derive(Debug, Clone, Copy, Default)]
struct Outcome {
    work: raster::Work,
    /// Vertices that the vertex stage emitted.
    emitted_vertices: u64,
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
            let per_primitive = corners_per_primitive(draw.topology);
            let key = (draw.group, draw.instance);
            reads.fetched.extend(fetched(
                key,
                &draw.corners,
                per_primitive,
                indices,
                vertices,
            ));
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
        let vertices = draw.corners.len() as u64;
        let primitives = vertices / corners_per_primitive(draw.topology) as u64;
        sums.draws += draw.draws;
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
            input_bytes += u64::from(draw.source.index_bytes()) * vertices;
            input_bytes += inputs.map_or(0, |(_, stride)| u64::from(stride) * vertices);
            let (index_bytes, vertex_bytes) =
                fetched_bytes(draw.source, &draw.corners, indices, inputs);
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
