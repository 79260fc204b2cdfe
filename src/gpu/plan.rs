//! Resolves a pass into draws with every argument checked.

use std::ops::Range;
use std::sync::Arc;

use super::assemble::{Arguments, corners, triangles_of_strips, windows};
use super::depth::check_other;
use super::mesh::{Mesh, MeshKey, Meshes};
use super::pass::{
    BIND_BYTES, Corners, DRAW_BYTES, DrawFromCounter, DrawIndirect, DrawInstanced,
    DrawInstancedIndirect, INDIRECT_BYTES, IndirectRecord, PASS_BYTES, RESTART, RenderPass, Step,
};
use super::program::{Bindings, Layout, MAX_SLOTS, Program, Words};
use super::resource::Buffer;
use super::{
    BufferId, ColourMap, DepthMap, Device, GpuError, ProgramId, Residency, TargetId, TextureId,
    Usage,
};
use crate::math::{index_u32, index_usize};
use crate::raster::Topology;

/// A pass with every argument checked.
pub(super) struct Plan {
    pub(super) draws: Vec<PlannedDraw>,
    pub(super) command_bytes: u64,
    /// Draw arguments read from buffers.
    pub(super) argument_reads: Vec<(BufferId, Range<usize>)>,
    /// Numbers of instances pulled from host memory: the buffer's label, and how many bytes.
    pub(super) pulled: Vec<(String, u64)>,
}

/// The records of one step: drawn as one, since only their key tells them apart, and they share it.
#[derive(Debug)]
pub(super) struct PlannedDraw {
    pub(super) state: Arc<State>,
    pub(super) topology: Topology,
    pub(super) source: Corners,
    pub(super) group: u32,
    pub(super) instance: u32,
    /// How many draws the step counts for.
    pub(super) draws: u64,
    /// How many of them have no corner.
    pub(super) empty_draws: u64,
    /// The runs of corners, as `(first, count)`.
    pub(super) runs: Vec<(u32, u32)>,
    /// Its primitives.
    pub(super) mesh: Arc<Mesh>,
}

impl PlannedDraw {
    /// The corners as they were submitted.
    pub(super) fn submitted(&self) -> &[u32] {
        self.mesh.strips.as_deref().unwrap_or(&self.mesh.corners)
    }

    /// How many corners the runs have, restarts too.
    pub(super) fn corner_count(&self) -> u64 {
        self.runs.iter().map(|&(_, count)| u64::from(count)).sum()
    }

    /// How many vertices and primitives were submitted, also of triangles that are none.
    pub(super) fn sizes(&self) -> (u64, u64) {
        match &self.mesh.strips {
            None => {
                let corners = self.mesh.corners.len() as u64;
                let primitives = corners / self.topology.corners() as u64;
                (corners, primitives)
            }
            Some(strips) => {
                let vertices = strips.iter().filter(|&&corner| corner != RESTART).count();
                (vertices as u64, windows(strips).count() as u64)
            }
        }
    }
}

/// What is bound.
#[derive(Debug, Clone)]
pub(super) struct State {
    number: ProgramId,
    pub(super) program: Arc<dyn Program>,
    pub(super) vertices: Option<BufferId>,
    pub(super) indices: Option<BufferId>,
    pub(super) storage: [Option<BufferId>; MAX_SLOTS],
    textures: [Option<TextureId>; MAX_SLOTS],
    depths: [Option<TargetId>; MAX_SLOTS],
    colours: [Option<TargetId>; MAX_SLOTS],
}

impl State {
    pub(super) fn bindings<'a>(&self, device: &'a Device) -> Bindings<'a> {
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
            depths: self
                .depths
                .map(|slot| slot.map(|id| DepthMap::of(device, id))),
            colours: self
                .colours
                .map(|slot| slot.map(|id| ColourMap::of(device, id))),
        }
    }

    /// The bound buffers that the input assembler reads, for a draw of this source.
    pub(super) fn inputs<'a>(
        &self,
        device: &'a Device,
        source: Corners,
    ) -> Result<Inputs<'a>, GpuError> {
        let layout = self.program.layout();
        let unbound = |what| GpuError::Unbound {
            program: layout.name.to_owned(),
            what,
            slot: 0,
        };
        let indices = match source {
            Corners::Counted => None,
            Corners::Indexed | Corners::Short | Corners::Strips => {
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
pub(super) type Inputs<'a> = (Option<&'a Buffer>, Option<(&'a Buffer, u32)>);

/// Plans a pass; meshes that are not among `meshes` are made and join them.
pub(super) fn plan(
    device: &Device,
    meshes: &mut Meshes,
    pass: &RenderPass,
) -> Result<Plan, GpuError> {
    let mut plan = Plan {
        draws: Vec::new(),
        command_bytes: PASS_BYTES,
        argument_reads: Vec::new(),
        pulled: Vec::new(),
    };
    let mut state: Option<Arc<State>> = None;
    let mut vertices = None;
    let mut indices = None;
    let mut storage = [None; MAX_SLOTS];
    let mut textures = [None; MAX_SLOTS];
    let mut depths = [None; MAX_SLOTS];
    let mut colours = [None; MAX_SLOTS];
    let mut program: Option<(ProgramId, Arc<dyn Program>)> = None;
    meshes.begin_pass();
    for step in &pass.steps {
        let drawn = match *step {
            Step::Program(id) => {
                let found = device.programs.get(id.index() as usize);
                let index = id.index();
                let found = found.ok_or(GpuError::Unknown {
                    what: "program",
                    index,
                })?;
                program = Some((id, Arc::clone(found)));
                None
            }
            Step::Vertices(buffer) => {
                device.buffer(buffer)?;
                vertices = Some(buffer);
                None
            }
            Step::Indices(buffer) => {
                device.buffer(buffer)?;
                indices = Some(buffer);
                None
            }
            Step::Storage { slot, buffer } => {
                // Only the input assembler pulls from host memory, where it is counted.
                device.buffer(buffer)?.check_on_device("a storage buffer")?;
                *slot_mut(&mut storage, slot)? = Some(buffer);
                None
            }
            Step::Texture { slot, texture } => {
                device.texture(texture)?;
                *slot_mut(&mut textures, slot)? = Some(texture);
                None
            }
            Step::Depth { slot, target } => {
                check_other(device, target, pass.target, "depth")?;
                *slot_mut(&mut depths, slot)? = Some(target);
                None
            }
            Step::Colour { slot, target } => {
                check_other(device, target, pass.target, "colour")?;
                device.target(target)?.check_colour()?;
                *slot_mut(&mut colours, slot)? = Some(target);
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
                    first_vertex: 0,
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
            Step::MultiDrawIndirect(draw) => {
                device.check_computes()?;
                let arguments = device.buffer(draw.arguments)?;
                arguments.check_on_device("arguments that the device walks")?;
                plan.command_bytes += DRAW_BYTES;
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
            Step::DrawInstanced(draw) => {
                plan.command_bytes += BIND_BYTES + DRAW_BYTES;
                Some(plan.instances_of(device, &draw)?)
            }
            Step::DrawInstancedIndirect(draw) => {
                plan.command_bytes += BIND_BYTES + INDIRECT_BYTES;
                let (draw, range) = instanced_arguments(device, &draw)?;
                plan.argument_reads.push(range);
                Some(plan.instances_of(device, &draw)?)
            }
        };
        let is_instanced = matches!(
            step,
            Step::DrawInstanced(_) | Step::DrawInstancedIndirect(_)
        );
        let Some(drawn) = drawn else {
            plan.command_bytes += BIND_BYTES;
            state = None;
            continue;
        };
        if state.is_none() {
            let (number, program) = program.clone().ok_or(GpuError::Unbound {
                program: String::new(),
                what: "program",
                slot: 0,
            })?;
            state = Some(Arc::new(State {
                number,
                program,
                vertices,
                indices,
                storage,
                textures,
                depths,
                colours,
            }));
        }
        let state = state.as_ref().expect("set above");
        for (place, together) in (0..).zip(in_one(&drawn, is_instanced)) {
            let mut draw = plan_draw(device, meshes, state, together)?;
            if is_instanced && place > 0 {
                // The first counts for all.
                (draw.draws, draw.empty_draws) = (0, 0);
            }
            plan.draws.push(draw);
        }
    }
    Ok(plan)
}

/// Those that are drawn as one: records of the same instance; of an instanced draw each by itself.
fn in_one(drawn: &[Arguments], is_instanced: bool) -> impl Iterator<Item = &[Arguments]> {
    drawn.chunk_by(move |a, b| !is_instanced && a.instance == b.instance)
}

impl Plan {
    /// The draws of all instances; without any an empty one. The buffer of instances is read.
    fn instances_of(
        &mut self,
        device: &Device,
        draw: &DrawInstanced,
    ) -> Result<Vec<Arguments>, GpuError> {
        let buffer = device.buffer(draw.instances)?;
        buffer.check_usage(Usage::VERTEX)?;
        let [offset, size] =
            [draw.first_instance, draw.instance_count].map(|count| 4 * u64::from(count));
        let range = buffer.range(offset, size, "instanced draw")?;
        let of = |instance, corner_count| Arguments {
            source: draw.source,
            first_corner: draw.first_corner,
            corner_count,
            first_vertex: 0,
            instance,
            group: draw.group,
        };
        let numbers = buffer.bytes[range.clone()].as_chunks::<4>().0.iter();
        let mut all: Vec<Arguments> = numbers
            .map(|four| of(u32::from_le_bytes(*four), draw.corner_count))
            .collect();
        if all.is_empty() {
            all.push(of(0, 0));
        }
        if buffer.residency == Residency::Host {
            self.pulled.push((buffer.label.clone(), size));
        }
        self.argument_reads.push((draw.instances, range));
        Ok(all)
    }
}

/// The arguments of an instanced draw, and where they lie.
fn instanced_arguments(
    device: &Device,
    draw: &DrawInstancedIndirect,
) -> Result<(DrawInstanced, (BufferId, Range<usize>)), GpuError> {
    let buffer = device.buffer(draw.arguments)?;
    buffer.check_usage(Usage::INDIRECT)?;
    buffer.check_on_device("arguments of an instanced draw")?;
    let range = buffer.range(draw.offset, IndirectRecord::STRIDE, "instanced draw")?;
    let words = buffer.bytes[range.clone()].as_chunks::<4>().0;
    let word = |place: usize| {
        let bytes = words.get(place).copied().unwrap_or_default();
        u32::from_le_bytes(bytes)
    };
    let arguments = DrawInstanced {
        source: draw.source,
        corner_count: word(0),
        instance_count: word(1),
        first_corner: word(2),
        first_instance: word(3),
        instances: draw.instances,
        group: draw.group,
    };
    Ok((arguments, (draw.arguments, range)))
}

fn slot_mut<T>(slots: &mut [Option<T>; MAX_SLOTS], slot: u32) -> Result<&mut Option<T>, GpuError> {
    slots.get_mut(slot as usize).ok_or(GpuError::Unknown {
        what: "binding slot",
        index: slot,
    })
}

fn plan_draw(
    device: &Device,
    meshes: &mut Meshes,
    state: &Arc<State>,
    records: &[Arguments],
) -> Result<PlannedDraw, GpuError> {
    let layout = state.program.layout();
    let first = records[0];
    let inputs = state.inputs(device, first.source)?;
    let empty = records.iter().filter(|record| record.corner_count == 0);
    let mesh = match device.reads {
        None => {
            let key = mesh_key(device, state, records);
            let make = || {
                let mut mesh = assemble(&layout, records, inputs)?;
                mesh.cut(&*state.program, &state.bindings(device), inputs.1);
                Ok(mesh)
            };
            meshes.get(key, make, |mesh| {
                mesh.look_closer(&*state.program, &state.bindings(device));
            })?
        }
        // Every byte that may be read is to be read, seen or not.
        Some(_) => Arc::new(assemble(&layout, records, inputs)?),
    };
    Ok(PlannedDraw {
        state: Arc::clone(state),
        topology: layout.topology,
        source: first.source,
        group: first.group,
        instance: first.instance,
        draws: records.len() as u64,
        empty_draws: empty.count() as u64,
        runs: records
            .iter()
            .map(|record| (record.first_corner, record.corner_count))
            .collect(),
        mesh,
    })
}

fn mesh_key(device: &Device, state: &State, records: &[Arguments]) -> MeshKey {
    let hulls = state.program.hulls();
    let slots = hulls.map_or_else(Vec::new, super::program::Hulls::slots);
    let storage = slots
        .iter()
        .map(|&slot| state.storage.get(slot as usize).copied().flatten());
    let version = |id: BufferId| device.buffer(id).map_or(0, |buffer| buffer.version);
    MeshKey {
        program: state.number,
        source: records[0].source,
        buffers: [state.vertices, state.indices]
            .into_iter()
            .chain(storage)
            .map(|id| (id, id.map_or(0, version)))
            .collect(),
        runs: records
            .iter()
            .map(|record| {
                [
                    record.first_corner,
                    record.corner_count,
                    record.first_vertex,
                ]
            })
            .collect(),
    }
}

/// The primitives that records name.
fn assemble(
    layout: &Layout,
    records: &[Arguments],
    (indices, vertices): Inputs<'_>,
) -> Result<Mesh, GpuError> {
    if records[0].source == Corners::Strips {
        if layout.topology != Topology::TriangleList {
            let what = format!(
                "strips with program {:?}, which draws no triangles",
                layout.name
            );
            return Err(GpuError::Unsupported { what });
        }
        let mut strips = Vec::new();
        for record in records {
            strips.extend(corners(record, indices, vertices)?);
            strips.push(RESTART);
        }
        return Ok(Mesh::new(triangles_of_strips(&strips), Some(strips)));
    }
    let wanted = layout.topology.corners();
    let mut all = Vec::new();
    for record in records {
        if !(record.corner_count as usize).is_multiple_of(wanted) {
            return Err(GpuError::Corners {
                program: layout.name.to_owned(),
                corners: record.corner_count,
                wanted: index_u32(wanted),
            });
        }
        all.extend(corners(record, indices, vertices)?);
    }
    Ok(Mesh::new(all, None))
}

fn indirect_arguments(
    device: &Device,
    draw: &DrawIndirect,
) -> Result<(Vec<Arguments>, Range<usize>), GpuError> {
    let buffer = device.buffer(draw.arguments)?;
    buffer.check_usage(Usage::INDIRECT)?;
    let size = draw.source.record_bytes() * u64::from(draw.count);
    let range = buffer.range(draw.offset, size, "indirect draw")?;
    let words: Vec<u32> = buffer.bytes[range.clone()]
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes(four.try_into().expect("chunks of four bytes")))
        .collect();
    let arguments = words
        .chunks_exact(index_usize(draw.source.record_bytes() / 4))
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
                first_vertex: record.get(4).copied().unwrap_or(0),
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
        first_vertex: 0,
        instance: draw.instance,
        group: draw.group,
    };
    Ok((arguments, range))
}
