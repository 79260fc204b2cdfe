//! Executes passes: resolves draws, runs vertex stages, hands geometry to the rasterizer.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::{IntoParallelRefIterator as _, ParallelIterator as _};

use super::assemble::{Arguments, corners, fetched, fetched_bytes};
use super::card::DrawWork;
use super::ledger::{Cause, Ledger, Stream, WorkCounts};
use super::pass::{
    BIND_BYTES, Corners, DRAW_BYTES, DrawFromCounter, DrawIndirect, INDIRECT_BYTES, Load,
    PASS_BYTES, RenderPass, Step,
};
use super::program::{Bindings, MAX_SLOTS, Program, VertexCall, Words};
use super::resource::Buffer;
use super::{BufferId, Device, GpuError, IndirectRecord, Residency, TextureId, Usage};
use crate::math::index_u32;
use crate::raster::{self, Batch, Counters, Geometry, Kernel, Topology};

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
    let work = {
        let device: &Device = device;
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
                let instance = draw.arguments.instance;
                let call = VertexCall {
                    corners,
                    instance,
                    bindings: &bound[number],
                };
                draw.state.program.vertex_stage(&call, &mut geometry);
                geometry
            })
            .collect();
        let batches: Vec<Batch<'_>> = calls
            .iter()
            .zip(&geometries)
            .map(|(&(number, _), geometry)| {
                let draw = &plan.draws[number];
                Batch {
                    geometry,
                    topology: draw.topology,
                    kernel: &*kernels[number],
                    blend: draw.state.program.layout().blend,
                    group: draw.arguments.group,
                    instance: draw.arguments.instance,
                }
            })
            .collect();
        raster::render(&mut slot.target, &batches, &device.descriptor.raster)
    };
    device.targets[pass.target.index() as usize] = Some(slot);
    count(device, &plan, &work);
    Ok(())
}

/// A pass with every argument checked.
struct Plan {
    draws: Vec<PlannedDraw>,
    command_bytes: u64,
    /// Draw arguments read from buffers.
    argument_reads: Vec<(BufferId, Range<usize>)>,
}

struct PlannedDraw {
    state: Arc<State>,
    topology: Topology,
    arguments: Arguments,
    corners: Vec<u32>,
}

/// What is bound.
#[derive(Clone)]
struct State {
    program: Arc<dyn Program>,
    vertices: Option<BufferId>,
    indices: Option<BufferId>,
    storage: [Option<BufferId>; MAX_SLOTS],
    textures: [Option<TextureId>; MAX_SLOTS],
}

impl State {
    fn bindings<'a>(&self, device: &'a Device) -> Bindings<'a> {
        let words = |id: BufferId| {
            let buffer = device.buffer(id).expect("checked by the plan");
            Words::of(id, buffer, device.reads.as_ref())
        };
        Bindings {
            vertices: self.vertices.map_or_else(Words::default, words),
            storage: self.storage.map(|slot| slot.map(words)),
            textures: self.textures.map(|slot| {
                slot.map(|id| &device.texture(id).expect("checked by the plan").texels)
            }),
        }
    }

    /// The bound buffers that the input assembler reads, for a draw of this source.
    fn inputs<'a>(&self, device: &'a Device, source: Corners) -> Result<Inputs<'a>, GpuError> {
        let layout = self.program.layout();
        let unbound = |what| GpuError::Unbound {
            program: layout.name.to_owned(),
            what,
            slot: 0,
        };
        let indices = match source {
            Corners::Counted => None,
            Corners::Indexed => {
                let buffer = device.buffer(self.indices.ok_or_else(|| unbound("index buffer"))?)?;
                buffer.check_usage(Usage::INDEX)?;
                Some(buffer)
            }
        };
        let vertices = match layout.vertex_stride {
            0 => None,
            stride => {
                let id = self.vertices.ok_or_else(|| unbound("vertex buffer"))?;
                let buffer = device.buffer(id)?;
                buffer.check_usage(Usage::VERTEX)?;
                Some((buffer, stride))
            }
        };
        for slot in 0..layout.storage_slots {
            let missing = || GpuError::Unbound {
                program: layout.name.to_owned(),
                what: "storage buffer",
                slot,
            };
            let id = self
                .storage
                .get(slot as usize)
                .copied()
                .flatten()
                .ok_or_else(missing)?;
            device.buffer(id)?.check_usage(Usage::STORAGE)?;
        }
        for slot in 0..layout.texture_slots {
            let missing = || GpuError::Unbound {
                program: layout.name.to_owned(),
                what: "texture",
                slot,
            };
            let id = self
                .textures
                .get(slot as usize)
                .copied()
                .flatten()
                .ok_or_else(missing)?;
            device.texture(id)?;
        }
        Ok((indices, vertices))
    }
}

/// The index buffer, and the vertex buffer with its stride, as far as a draw reads them.
type Inputs<'a> = (Option<&'a Buffer>, Option<(&'a Buffer, u32)>);

fn corners_per_primitive(topology: Topology) -> usize {
    match topology {
        Topology::TriangleList => 3,
        Topology::QuadList => 4,
        Topology::LineList => 2,
    }
}

fn plan(device: &Device, pass: &RenderPass) -> Result<Plan, GpuError> {
    let mut plan = Plan {
        draws: Vec::new(),
        command_bytes: PASS_BYTES,
        argument_reads: Vec::new(),
    };
    let mut state: Option<Arc<State>> = None;
    let mut vertices = None;
    let mut indices = None;
    let mut storage = [None; MAX_SLOTS];
    let mut textures = [None; MAX_SLOTS];
    let mut program: Option<Arc<dyn Program>> = None;
    for step in &pass.steps {
        let drawn = match *step {
            Step::Program(id) => {
                let found = device.programs.get(id.index() as usize);
                let index = id.index();
                program = Some(
                    found
                        .ok_or(GpuError::Unknown {
                            what: "program",
                            index,
                        })?
                        .clone(),
                );
                None
            }
            Step::Vertices(buffer) => {
                vertices = Some(buffer);
                None
            }
            Step::Indices(buffer) => {
                indices = Some(buffer);
                None
            }
            Step::Storage { slot, buffer } => {
                device.buffer(buffer)?;
                *slot_mut(&mut storage, slot)? = Some(buffer);
                None
            }
            Step::Texture { slot, texture } => {
                device.texture(texture)?;
                *slot_mut(&mut textures, slot)? = Some(texture);
                None
            }
            Step::NoTexture { slot } => {
                *slot_mut(&mut textures, slot)? = None;
                None
            }
            Step::Draw(draw) => {
                plan.command_bytes += DRAW_BYTES;
                Some(vec![Arguments {
                    source: draw.source,
                    first_corner: draw.first_corner,
                    corner_count: draw.corner_count,
                    instance: draw.instance,
                    group: draw.group,
                }])
            }
            Step::DrawIndirect(draw) => {
                // Arguments in host memory go into the command stream as plain draws.
                let each = match device.buffer(draw.arguments)?.residency {
                    Residency::Device => INDIRECT_BYTES,
                    Residency::Host => DRAW_BYTES,
                };
                plan.command_bytes += each * u64::from(draw.count);
                let (arguments, range) = indirect_arguments(device, &draw)?;
                plan.argument_reads.push((draw.arguments, range));
                Some(arguments)
            }
            Step::DrawFromCounter(draw) => {
                plan.command_bytes += DRAW_BYTES;
                let (arguments, range) = counter_arguments(device, &draw)?;
                plan.argument_reads.push((draw.counter, range));
                Some(vec![arguments])
            }
        };
        let Some(drawn) = drawn else {
            plan.command_bytes += BIND_BYTES;
            state = None;
            continue;
        };
        if state.is_none() {
            let program = program.clone().ok_or(GpuError::Unbound {
                program: String::new(),
                what: "program",
                slot: 0,
            })?;
            state = Some(Arc::new(State {
                program,
                vertices,
                indices,
                storage,
                textures,
            }));
        }
        let state = state.as_ref().expect("set above");
        for arguments in drawn {
            plan.draws.push(plan_draw(device, state, arguments)?);
        }
    }
    Ok(plan)
}

fn slot_mut<T>(slots: &mut [Option<T>; MAX_SLOTS], slot: u32) -> Result<&mut Option<T>, GpuError> {
    slots.get_mut(slot as usize).ok_or(GpuError::Unknown {
        what: "binding slot",
        index: slot,
    })
}

fn plan_draw(
    device: &Device,
    state: &Arc<State>,
    arguments: Arguments,
) -> Result<PlannedDraw, GpuError> {
    let layout = state.program.layout();
    let wanted = corners_per_primitive(layout.topology);
    if layout.topology == Topology::LineList {
        return Err(GpuError::Unsupported {
            what: format!("{:?}", layout.topology),
        });
    }
    if !(arguments.corner_count as usize).is_multiple_of(wanted) {
        return Err(GpuError::Corners {
            program: layout.name.to_owned(),
            corners: arguments.corner_count,
            wanted: index_u32(wanted),
        });
    }
    let (indices, vertices) = state.inputs(device, arguments.source)?;
    let corners = corners(&arguments, indices, vertices)?;
    Ok(PlannedDraw {
        state: Arc::clone(state),
        topology: layout.topology,
        arguments,
        corners,
    })
}

fn indirect_arguments(
    device: &Device,
    draw: &DrawIndirect,
) -> Result<(Vec<Arguments>, Range<usize>), GpuError> {
    let buffer = device.buffer(draw.arguments)?;
    buffer.check_usage(Usage::INDIRECT)?;
    let size = IndirectRecord::STRIDE * u64::from(draw.count);
    let range = buffer.range(draw.offset, size, "indirect draw")?;
    let words: Vec<u32> = buffer.bytes[range.clone()]
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes(four.try_into().expect("chunks of four bytes")))
        .collect();
    let arguments = words
        .chunks_exact(4)
        .map(|record| {
            if record[1] > 1 {
                return Err(GpuError::Unsupported {
                    what: format!("{} instances", record[1]),
                });
            }
            Ok(Arguments {
                source: draw.source,
                first_corner: record[2],
                corner_count: record[0] * record[1],
                instance: record[3],
                group: draw.group,
            })
        })
        .collect::<Result<_, _>>()?;
    Ok((arguments, range))
}

fn counter_arguments(
    device: &Device,
    draw: &DrawFromCounter,
) -> Result<(Arguments, Range<usize>), GpuError> {
    let buffer = device.buffer(draw.counter)?;
    buffer.check_usage(Usage::INDIRECT)?;
    let range = buffer.range(draw.offset, 4, "draw from a counter")?;
    let four = buffer.bytes[range.clone()]
        .try_into()
        .expect("a range of four bytes");
    let first = match u32::from_le_bytes(four) {
        u32::MAX => 0,
        counter => counter.saturating_mul(draw.scale).min(draw.end),
    };
    let arguments = Arguments {
        source: draw.source,
        first_corner: first,
        corner_count: draw.end - first,
        instance: draw.instance,
        group: draw.group,
    };
    Ok((arguments, range))
}

impl Buffer {
    pub(super) fn check_usage(&self, wanted: Usage) -> Result<(), GpuError> {
        if self.usage.contains(wanted) {
            return Ok(());
        }
        Err(GpuError::Usage {
            label: self.label.clone(),
            has: format!("{:?}", self.usage),
            wanted: format!("{wanted:?}"),
        })
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
        if let (Corners::Indexed, Some(id)) = (draw.arguments.source, state.indices) {
            let first = 4 * draw.arguments.first_corner as usize;
            reads.mark(id, first..first + 4 * draw.corners.len());
        }
        if let Ok((indices, vertices)) = state.inputs(device, draw.arguments.source) {
            let per_primitive = corners_per_primitive(draw.topology);
            let list = fetched(
                &draw.arguments,
                &draw.corners,
                per_primitive,
                indices,
                vertices,
            );
            reads.fetched.extend(list);
        }
    }
    device.reads = Some(reads);
}

/// Enters a pass into the ledger.
fn count(device: &mut Device, plan: &Plan, work: &raster::Work) {
    let mut pulled = Vec::new();
    let mut total = DrawWork::default();
    let mut sums = Ledger {
        command_bytes: plan.command_bytes,
        ..Ledger::default()
    };
    for draw in &plan.draws {
        let per_primitive = corners_per_primitive(draw.topology) as u64;
        let vertices = draw.corners.len() as u64;
        let primitives = vertices / per_primitive;
        sums.draws += 1;
        sums.vertices += vertices;
        sums.primitives += primitives;
        total.triangles += if draw.topology == Topology::QuadList {
            2
        } else {
            1
        } * primitives;
        if let Ok((indices, inputs)) = draw.state.inputs(device, draw.arguments.source) {
            total.input_bytes += if indices.is_some() { 4 * vertices } else { 0 };
            total.input_bytes += inputs.map_or(0, |(_, stride)| u64::from(stride) * vertices);
            let (index_bytes, vertex_bytes) = fetched_bytes(&draw.corners, indices, inputs);
            for (bytes, buffer) in [(index_bytes, indices), (vertex_bytes, inputs.map(|i| i.0))] {
                if let (1.., Some(buffer)) = (bytes, buffer) {
                    pulled.push((buffer.label.clone(), bytes));
                }
            }
        }
    }
    total.vertices = sums.vertices;
    total.covered = work.covered;
    total.visible = work.visible;
    total.texels = work.texels;
    sums.visible_samples = work.visible;
    if device.descriptor.raster.counters == Counters::Exact {
        sums.work = Some(WorkCounts {
            covered: work.covered,
            alpha_killed: work.alpha_killed,
            hidden: work.covered - work.alpha_killed - work.visible,
            texels: work.texels,
        });
        sums.gpu_ticks = Some(device.descriptor.card.ticks(&total));
    }
    device.bus.ledger().add(&sums);
    for (label, bytes) in pulled {
        device.bus.move_bytes(Stream::Fetch, &label, FETCH, bytes);
    }
}
