//! Strokes on the device: a change of level sends which runs of the list show.

use std::ops::Range;
use std::sync::Arc;

use super::order::{Order, run_words};
use super::painting::Painting;
use super::program::{ORDER_SLOT, RUN_SLOT, STROKE_SLOT, Source};
use super::record::StrokeRecord;
use super::surface::PaintSurface;
use crate::gpu::{
    BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord, Queue, Step, Usage,
};
use crate::math::Vec3;
use crate::models::surface::{STROKE_GROUP, filled};
use crate::models::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
    StrokeCut,
};

/// The model whose strokes are on the device.
///
/// Host memory: the tables that find runs, and the centres of all strokes, by which they are sorted.
/// Device memory: all strokes, 44 B each, the painting's colours, brushes and ground; an instance has
/// its runs, its order and the arguments of its draw, of which the host keeps copies of the first two.
#[derive(Debug, Clone)]
pub(in crate::models) struct StrokeRanges {
    crown: Arc<Crown>,
    painting: Arc<Painting>,
}

const RANGES: Cause = Cause::of("stroke-ranges");
const ORDER: Cause = Cause::of("stroke-order");
const COUNT: Cause = Cause::of("draw-count");

impl StrokeRanges {
    pub(in crate::models) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        let painting = Arc::new(Painting::of(crown.plant(), &options.painting));
        Self { crown, painting }
    }

    /// Words of an instance's runs.
    fn run_room(painting: &Painting) -> usize {
        1 + 2 * painting.most_runs() as usize
    }
}

impl Model for StrokeRanges {
    fn kind(&self) -> Kind {
        Kind::StrokeRanges
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
        let surface = PaintSurface::upload(device, environment, painting, Source::Ranges)?;
        let records = painting.records().iter();
        let bytes: Vec<u8> = records.flat_map(|record| record.to_bytes()).collect();
        let cause = Cause::of("strokes");
        Ok(Box::new(RangesShared {
            painting: Arc::clone(painting),
            surface,
            strokes: filled(device, "strokes", Usage::STORAGE, &bytes, cause)?,
        }))
    }

    /// The tables, then the centres, 12 B each.
    fn host_bytes(&self) -> Vec<u8> {
        let records = self.painting.records().iter();
        let centers = records.flat_map(|record| record.stroke.center.to_array());
        let mut bytes = self.painting.table_bytes();
        bytes.extend(centers.flat_map(f32::to_le_bytes));
        bytes
    }

    fn storage(&self) -> Storage {
        let painting = &self.painting;
        let strokes = painting.records().len() as u64;
        let order = 4 * u64::from(painting.most_strokes());
        let runs = 4 * Self::run_room(painting) as u64;
        Storage {
            host_bytes: painting.table_bytes().len() as u64 + 12 * strokes,
            shared_bytes: u64::from(StrokeRecord::STRIDE) * strokes + PaintSurface::size(painting),
            instance_bytes: order + runs + IndirectRecord::STRIDE,
            instance_host_bytes: painting.finest().host_bytes() + order + runs,
        }
    }
}

#[derive(Debug)]
struct RangesShared {
    painting: Arc<Painting>,
    surface: PaintSurface,
    strokes: BufferId,
}

impl Shared for RangesShared {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let painting = &self.painting;
        let cut = painting.cut_of(state);
        let order = Order::of(Arc::clone(painting), painting.runs(&cut));
        let mut held = run_words(&order.runs);
        held.resize(StrokeRanges::run_room(painting), 0);
        let runs = filled(device, "stroke runs", Usage::STORAGE, &bytes(&held), RANGES)?;
        let places = bytes(&order.places);
        let places = filled(device, "stroke order", Usage::STORAGE, &places, ORDER)?;
        let arguments = IndirectRecord {
            corner_count: 4 * order.count,
            instances: 1,
            first_corner: 0,
            instance: number,
        };
        let label = "stroke arguments";
        let arguments = filled(device, label, Usage::INDIRECT, &arguments.to_bytes(), COUNT)?;
        let own = [
            (STROKE_SLOT, self.strokes),
            (RUN_SLOT, runs),
            (ORDER_SLOT, places),
        ];
        let mut steps = self.surface.bind(&own);
        steps.push(Step::DrawIndirect(DrawIndirect {
            source: Corners::Counted,
            arguments,
            offset: 0,
            count: 1,
            group: STROKE_GROUP,
        }));
        Ok(Box::new(RangesResident {
            painting: Arc::clone(painting),
            backdrop: self.surface.backdrop().to_vec(),
            steps,
            runs,
            places,
            arguments,
            held,
            order,
            state: State::Strokes(cut),
        }))
    }
}

#[derive(Debug)]
struct RangesResident {
    painting: Arc<Painting>,
    steps: Vec<Step>,
    backdrop: Vec<Step>,
    runs: BufferId,
    places: BufferId,
    arguments: BufferId,
    /// What the buffer of runs holds, also behind those that count.
    held: Vec<u32>,
    order: Order,
    state: State,
}

impl RangesResident {
    /// The words that differ from those that are held, as a range around them.
    fn changed(&self, words: &[u32]) -> Range<usize> {
        let pairs = || words.iter().zip(&self.held);
        let Some(first) = pairs().position(|(wanted, held)| wanted != held) else {
            return 0..0;
        };
        let last = pairs().rposition(|(wanted, held)| wanted != held);
        first..last.unwrap_or(first) + 1
    }

    fn wanted(&self, to: &State) -> (StrokeCut, Vec<Range<u32>>) {
        let cut = self.painting.cut_of(to);
        let runs = self.painting.runs(&cut);
        (cut, runs)
    }
}

impl Resident for RangesResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let (cut, runs) = self.wanted(to);
        let to = State::Strokes(cut);
        if to == self.state {
            return Ok(Change::default());
        }
        let words = run_words(&runs);
        let changed = self.changed(&words);
        if !changed.is_empty() {
            let offset = 4 * changed.start as u64;
            queue.write(self.runs, offset, &bytes(&words[changed.clone()]), RANGES)?;
            self.held[changed.clone()].copy_from_slice(&words[changed.clone()]);
        }
        let before = self.order.count;
        self.order.show(runs);
        if self.order.count != before {
            let corners = 4 * self.order.count;
            queue.write(self.arguments, 0, &corners.to_le_bytes(), COUNT)?;
        }
        self.state = to;
        Ok(Change {
            host_records: changed.len() as u64,
            ..Change::default()
        })
    }

    fn price(&self, to: &State) -> u64 {
        let (cut, runs) = self.wanted(to);
        if self.state == State::Strokes(cut) {
            return 0;
        }
        let count = runs.iter().fold(0, |sum, run| sum + (run.end - run.start));
        let words = self.changed(&run_words(&runs)).len() as u64;
        4 * (words + u64::from(count != self.order.count))
    }

    fn look_from(&mut self, queue: &mut Queue<'_>, eye: Vec3) -> Result<(), GpuError> {
        let changed = self.order.look_from(eye);
        if changed.is_empty() {
            return Ok(());
        }
        let offset = 4 * changed.start as u64;
        queue.write(
            self.places,
            offset,
            &bytes(&self.order.places[changed]),
            ORDER,
        )
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
        self.state.host_bytes() + 4 * (self.held.len() + self.order.places.len()) as u64
    }
}

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
