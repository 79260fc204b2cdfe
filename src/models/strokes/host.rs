//! Strokes in host memory: every draw pulls what it shows.

use std::sync::Arc;

use super::order::Order;
use super::painting::Painting;
use super::program::Source;
use super::record::StrokeRecord;
use super::surface::PaintSurface;
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord,
    Queue, Residency, Step, Usage,
};
use crate::math::Vec3;
use crate::models::surface::STROKE_GROUP;
use crate::models::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};

/// The model whose strokes stay on the host.
///
/// Host memory: all strokes, 44 B each, and the tables that find runs; an instance has four indices of
/// 4 B a stroke that may show, in the order of drawing, and the order itself. Device memory: the
/// painting's colours, brushes and ground. Every draw pulls 60 B a stroke: its four indices and itself.
#[derive(Debug, Clone)]
pub(in crate::models) struct HostStrokes {
    crown: Arc<Crown>,
    painting: Arc<Painting>,
}

const HOST: Cause = Cause::of("host");

/// Bytes of the indices of a stroke.
const QUAD_BYTES: u64 = 16;

impl HostStrokes {
    pub(in crate::models) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let painting = Arc::new(Painting::of(crown.plant(), &options.painting));
        Self { crown, painting }
    }
}

fn record_bytes(painting: &Painting) -> Vec<u8> {
    let records = painting.records().iter();
    records.flat_map(|record| record.to_bytes()).collect()
}

impl Model for HostStrokes {
    fn kind(&self) -> Kind {
        Kind::StrokesHost
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, _state: &State) -> Vec<u32> {
        Vec::new()
    }

    fn painting(&self) -> Option<&Arc<Painting>> {
        Some(&self.painting)
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let painting = &self.painting;
        let surface = PaintSurface::upload(device, environment, painting, Source::Host)?;
        let bytes = record_bytes(painting);
        let strokes = device.create_buffer(&BufferDescriptor {
            label: "strokes",
            size: bytes.len() as u64,
            usage: Usage::VERTEX,
            residency: Residency::Host,
        })?;
        device.queue().write(strokes, 0, &bytes, HOST)?;
        Ok(Box::new(HostShared {
            painting: Arc::clone(painting),
            surface,
            strokes,
        }))
    }

    /// All strokes, then the tables.
    fn host_bytes(&self) -> Vec<u8> {
        let mut bytes = record_bytes(&self.painting);
        bytes.extend(self.painting.table_bytes());
        bytes
    }

    fn storage(&self) -> Storage {
        let painting = &self.painting;
        let strokes = painting.records().len() as u64;
        let most = u64::from(painting.most_strokes());
        let tables = painting.table_bytes().len() as u64;
        Storage {
            host_bytes: u64::from(StrokeRecord::STRIDE) * strokes + tables,
            shared_bytes: PaintSurface::size(painting),
            instance_bytes: 0,
            instance_host_bytes: painting.finest().host_bytes()
                + (QUAD_BYTES + 4) * most
                + IndirectRecord::STRIDE,
        }
    }
}

#[derive(Debug)]
struct HostShared {
    painting: Arc<Painting>,
    surface: PaintSurface,
    strokes: BufferId,
}

impl Shared for HostShared {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let painting = &self.painting;
        let cut = painting.cut_of(state);
        let order = Order::of(Arc::clone(painting), painting.runs(&cut));
        let mut make = |label, size, usage| {
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency: Residency::Host,
            })
        };
        let room = QUAD_BYTES * u64::from(painting.most_strokes());
        let indices = make("stroke list", room, Usage::INDEX)?;
        let arguments = make("stroke arguments", IndirectRecord::STRIDE, Usage::INDIRECT)?;
        let mut steps = self.surface.bind(&[]);
        steps.push(Step::Vertices(self.strokes));
        steps.push(Step::Indices(indices));
        steps.push(Step::DrawIndirect(DrawIndirect {
            source: Corners::Indexed,
            arguments,
            offset: 0,
            count: 1,
            group: STROKE_GROUP,
        }));
        let resident = HostResident {
            painting: Arc::clone(painting),
            backdrop: self.surface.backdrop().to_vec(),
            steps,
            indices,
            arguments,
            number,
            order,
            state: State::Strokes(cut),
        };
        resident.write(&mut device.queue())?;
        Ok(Box::new(resident))
    }
}

#[derive(Debug)]
struct HostResident {
    painting: Arc<Painting>,
    steps: Vec<Step>,
    backdrop: Vec<Step>,
    indices: BufferId,
    arguments: BufferId,
    number: u32,
    order: Order,
    state: State,
}

impl HostResident {
    /// Lists the strokes that show, which costs no bus.
    fn write(&self, queue: &mut Queue<'_>) -> Result<(), GpuError> {
        let strokes = self.order.strokes().into_iter();
        let indices = strokes.flat_map(|stroke| [stroke; 4]);
        let indices: Vec<u8> = indices.flat_map(u32::to_le_bytes).collect();
        queue.write(self.indices, 0, &indices, HOST)?;
        let arguments = IndirectRecord {
            corner_count: 4 * self.order.count,
            instances: 1,
            first_corner: 0,
            instance: self.number,
        };
        queue.write(self.arguments, 0, &arguments.to_bytes(), HOST)
    }
}

impl Resident for HostResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let cut = self.painting.cut_of(to);
        let runs = self.painting.runs(&cut);
        let to = State::Strokes(cut);
        if to == self.state {
            return Ok(Change::default());
        }
        self.order.show(runs);
        self.state = to;
        self.write(queue)?;
        Ok(Change {
            host_records: self.order.count.into(),
            ..Change::default()
        })
    }

    fn price(&self, _to: &State) -> u64 {
        0
    }

    fn look_from(&mut self, queue: &mut Queue<'_>, eye: Vec3) -> Result<(), GpuError> {
        if self.order.look_from(eye).is_empty() {
            return Ok(());
        }
        self.write(queue)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn draw_behind(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.backdrop);
    }

    fn strokes(&self) -> u64 {
        self.order.count.into()
    }

    fn host_bytes(&self) -> u64 {
        let room = self.order.places.len() as u64;
        self.state.host_bytes() + (QUAD_BYTES + 4) * room + IndirectRecord::STRIDE
    }
}
