//! LoDF that the device refines by itself: a compute pass turns the camera into what is drawn.
//!
//! ```text
//!  camera (32 B a frame) ─┐
//!  view, placement ───────┼─▶ select ─┬─▶ collapses done in each cluster ─▶ vertex stage
//!  crown (once) ──────────┤           └─▶ draw arguments of each cluster ─▶ draws
//!  detail (by state) ─────┘
//! ```
//!
//! Records lie cluster by cluster in the order of consumption, each with its birth in the cluster. After
//! `c` collapses of a cluster of `m` originals the window from record `2 c` to `2 m − 1` is drawn, and
//! the vertex stage leaves out what is born later: fewer than twice as many records are looked at as
//! show. One draw command walks the arguments of all clusters.
//!
//! What is drawn comes from one of two sources. From the *camera* ([`Resident::follow`]): the papers'
//! criterion, by the same function that the host selects with ([`collapses_at`]); then nothing but the
//! camera crosses the bus, whatever changes. From the *state* ([`Resident::commit`]), for an application
//! that dictates it: a uniform one sends how far the sequence has gone (4 B), a variable one the count of
//! every cluster that differs from the last variable one (4 B each), as stamps do.
//!
//! Clusters whose box lies outside of the view are not drawn, nor, [if asked for](Occlusion::TwoPhase),
//! those that are [hidden](super::super::reveal_pass). The tests leave more room than `f32` rounds away, so
//! no picture depends on them.
//!
//! All instances of a species lie in [rooms](super::rooms) of the same buffers: one dispatch selects for
//! all, one command draws all, however many there are.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::super::environment::Lens;
use super::super::expand_pass::{
    EXPANDED_CROWN_SLOT, EXPANDED_RECORD_SLOT, LEAF_NUMBER_SLOT, MASK_SLOT, OPERAND_SLOT,
    collapse_bytes, collapse_sizes, expand_groups, expands,
};
use super::super::format::LeafBytes;
use super::super::leaf::{RECORD_SLOT, VERTEX_SLOT, WINDOW_FIRST_VERTEX_SLOT, stamped_words};
use super::super::select_pass::{CAMERA, VARIABLE, crown_bytes, crown_size};
use super::super::surface::{Surface, Uploaded, filled};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Occlusion, Records, Resident, Shared,
    State, Storage,
};
use super::rooms::{Lodging, Rooms, computed_size, detail_size};
use super::slots::send;
use super::{Gather, first_vertex_bytes, host_bytes, host_size};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Command, ComputePass, ComputeStep, Device, GpuError, Queue,
    Region, Residency, Step, Usage,
};
use crate::math::index_u32;

/// Why what an instance or the model begins with is sent.
const RECORDS: Cause = Cause::of("records");

/// LoDF refined by the device.
///
/// Host memory: the structures of [`host_bytes`]. Device memory: the vertices, each leaf's record with
/// birth and cluster (24 bytes; 16 with a compact record), and the [crown](super::super::select_pass), once;
/// with compact records also the first vertex of each cluster (4 bytes), and what they were
/// [expanded](super::super::expand_pass) from (8½ bytes a collapse), which is sent in their place unless
/// collapses add vertices; for each instance its detail (8 bytes, and 4 a cluster), and what the device computes: 4 bytes and 16 bytes of
/// draw arguments a cluster, twice where what is hidden is left out.
#[derive(Debug, Clone)]
pub(in super::super) struct Refined {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    gather: Gather,
    occlusion: Occlusion,
}

impl Refined {
    pub(in super::super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        Self {
            leaves: LeafBytes::new(&crown, options.format),
            crown,
            gather: options.gather,
            occlusion: options.occlusion,
        }
    }

    /// Sends the collapses, and has the device make compact records of them.
    fn expand(
        &self,
        device: &mut Device,
        lens: Lens,
        crown: BufferId,
        numbers: BufferId,
    ) -> Result<BufferId, GpuError> {
        let [operands, masks] = collapse_bytes(&self.crown)?;
        let mut buffer =
            |label, bytes: &[u8]| filled(device, label, Usage::STORAGE, bytes, RECORDS);
        let operands = buffer("collapse operands", &operands)?;
        let masks = buffer("collapse masks", &masks)?;
        let records = device.create_buffer(&BufferDescriptor {
            label: "windowed records",
            size: self.record_size(),
            usage: Usage::STORAGE,
            residency: Residency::Device,
        })?;
        let mut steps = vec![ComputeStep::Program(lens.expand)];
        for (slot, buffer) in [
            (EXPANDED_CROWN_SLOT, crown),
            (OPERAND_SLOT, operands),
            (MASK_SLOT, masks),
            (LEAF_NUMBER_SLOT, numbers),
            (EXPANDED_RECORD_SLOT, records),
        ] {
            steps.push(ComputeStep::Storage { slot, buffer });
        }
        let groups = expand_groups(self.crown.sequence().record_count());
        steps.push(ComputeStep::Dispatch { groups });
        let label = "expand".to_owned();
        let pass = Command::Compute(ComputePass { label, steps });
        device.queue().submit(&[pass])?;
        Ok(records)
    }

    /// Bytes of all records.
    fn record_size(&self) -> u64 {
        let words = stamped_words(self.leaves.format) as u64;
        4 * words * u64::from(self.crown.sequence().record_count())
    }

    /// All records, as they are sent where they are not expanded.
    fn record_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (number, cluster) in (0_u32..).zip(&self.crown.clusters().clusters) {
            for record in &cluster.records {
                self.leaves.push_record(record.leaf, &mut bytes);
                bytes.extend(record.birth.to_le_bytes());
                bytes.extend(number.to_le_bytes());
            }
        }
        bytes
    }
}

impl Model for Refined {
    fn kind(&self) -> Kind {
        Kind::LodfDevice
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        state.visible(self.crown.clusters())
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let lens = environment.lens()?;
        let (crown, leaves) = (&self.crown, &self.leaves);
        let surface = Surface::upload(device, environment, crown, leaves, Residency::Device)?;
        let mut buffer =
            |label, bytes: &[u8]| filled(device, label, Usage::STORAGE, bytes, RECORDS);
        let crown_buffer = buffer("crown", &crown_bytes(crown, leaves.grid_step()))?;
        let numbers = surface.leaf_numbers().filter(|_| expands(crown));
        let records = match numbers {
            None => filled(
                device,
                "windowed records",
                Usage::STORAGE,
                &self.record_bytes(),
                RECORDS,
            )?,
            Some(numbers) => self.expand(device, lens, crown_buffer, numbers)?,
        };
        let mut buffer =
            |label, bytes: &[u8]| filled(device, label, Usage::STORAGE, bytes, RECORDS);
        let mut pulled = vec![(VERTEX_SLOT, surface.vertices), (RECORD_SLOT, records)];
        if let Some(bytes) = first_vertex_bytes(crown, leaves) {
            pulled.push((WINDOW_FIRST_VERTEX_SLOT, buffer("first vertices", &bytes)?));
        }
        let model = self.clone();
        Ok(Box::new(RefinedShared {
            environment: *environment,
            lens,
            uploaded: Uploaded { model, surface },
            pulled,
            crown: crown_buffer,
            rooms: RefCell::new(None),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        host_bytes(&self.crown)
    }

    fn storage(&self) -> Storage {
        let roots = self.crown.sequence().root_count();
        let compact = match self.leaves.format.records {
            Records::Wide => 0,
            Records::Compact => {
                let first_vertices = 4 * u64::from(roots);
                let expanded = expands(&self.crown).then(|| collapse_sizes(&self.crown));
                first_vertices + expanded.iter().flatten().sum::<u64>()
            }
        };
        Storage {
            host_bytes: host_size(&self.crown),
            shared_bytes: self.leaves.vertex_size()
                + self.leaves.key_size()
                + self.record_size()
                + compact
                + crown_size(&self.crown),
            instance_bytes: detail_size(roots) + computed_size(roots, self.occlusion),
            // Of a variable state, beside what the device holds while it follows the camera.
            instance_host_bytes: 8 + 8 * u64::from(roots),
        }
    }
}

#[derive(Debug)]
struct RefinedShared {
    environment: Environment,
    lens: Lens,
    uploaded: Uploaded<Refined>,
    /// What the vertex stage pulls, by slot.
    pulled: Vec<(u32, BufferId)>,
    crown: BufferId,
    /// Those that were made last.
    rooms: RefCell<Option<Rc<Rooms>>>,
}

impl RefinedShared {
    /// A room for an instance, in new rooms where all are taken.
    fn room(&self, device: &mut Device) -> Result<(Rc<Rooms>, u32), GpuError> {
        let present = self.rooms.borrow().clone();
        if let Some(rooms) = present
            && let Some(room) = rooms.take()
        {
            return Ok((rooms, room));
        }
        let Uploaded { model, surface } = &self.uploaded;
        let sequence = model.crown.sequence();
        let rooms = Rooms::new(
            device,
            &Lodging {
                environment: &self.environment,
                lens: self.lens,
                surface,
                pulled: &self.pulled,
                crown: self.crown,
                clusters: sequence.root_count(),
                records: sequence.record_count(),
                occlusion: model.occlusion,
            },
        )?;
        let room = rooms.take().expect("there is at least one, and it is new");
        *self.rooms.borrow_mut() = Some(Rc::clone(&rooms));
        Ok((rooms, room))
    }
}

impl Shared for RefinedShared {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let model = &self.uploaded.model;
        let roots = model.crown.sequence().root_count();
        let (source, wanted) = match state {
            State::Uniform { collapses } => (*collapses, vec![0; roots as usize]),
            State::Variable { counts } => (VARIABLE, counts.clone()),
            State::Cards(_) | State::Strokes(_) => (0, vec![0; roots as usize]),
        };
        let (rooms, room) = self.room(device)?;
        let resident = RefinedResident {
            model: model.clone(),
            rooms,
            room,
            state: state.clone(),
            source,
            wanted,
        };
        let detail = [&[source, number], &resident.wanted[..]].concat();
        let detail: Vec<u8> = detail.into_iter().flat_map(u32::to_le_bytes).collect();
        let (buffer, at) = (resident.rooms.detail, resident.detail_at(0));
        device.queue().write(buffer, at, &detail, RECORDS)?;
        Ok(Box::new(resident))
    }
}

#[derive(Debug)]
struct RefinedResident {
    model: Refined,
    rooms: Rc<Rooms>,
    /// The first one issues the commands for all.
    room: u32,
    state: State,
    /// What the detail holds, also where the present source does not read it.
    source: u32,
    wanted: Vec<u32>,
}

impl Resident for RefinedResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let mut words: Vec<(u64, [u8; 4], Cause)> = Vec::new();
        let source = match to {
            State::Uniform { collapses } => *collapses,
            State::Cards(_) | State::Strokes(_) => 0,
            State::Variable { counts } => {
                for (cluster, (wanted, held)) in counts.iter().zip(&mut self.wanted).enumerate() {
                    if wanted != held {
                        let cause = Cause::numbered("threshold", index_u32(cluster));
                        words.push((8 + 4 * cluster as u64, wanted.to_le_bytes(), cause));
                        *held = *wanted;
                    }
                }
                VARIABLE
            }
        };
        self.go_over(queue, to, source, words)
    }

    fn follow(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        self.go_over(queue, to, CAMERA, Vec::new())
    }

    fn prepare(&self, commands: &mut Vec<Command>) {
        if self.room == 0 {
            self.rooms.prepare(commands);
        }
    }

    fn price(&self, to: &State) -> u64 {
        match to {
            State::Uniform { collapses } => 4 * u64::from(*collapses != self.source),
            State::Cards(_) | State::Strokes(_) => 4 * u64::from(self.source != 0),
            State::Variable { counts } => {
                let words = counts.iter().zip(&self.wanted);
                let differ = words.filter(|(wanted, held)| wanted != held).count() as u64;
                4 * (u64::from(self.source != VARIABLE) + differ)
            }
        }
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        let dictated = self.source == VARIABLE && matches!(self.state, State::Variable { .. });
        dictated.then(|| 4 * u64::from(self.wanted[cluster as usize] != collapses))
    }

    fn host_bytes(&self) -> u64 {
        4 + self.state.host_bytes() + 4 * self.wanted.len() as u64
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        if self.room == 0 {
            self.rooms.draw(steps);
        }
    }

    fn reveal(&self, commands: &mut Vec<Command>) {
        if self.room == 0 {
            self.rooms.reveal(commands);
        }
    }

    fn draw_revealed(&self, steps: &mut Vec<Step>) {
        if self.room == 0 {
            self.rooms.draw_revealed(steps);
        }
    }
}

impl RefinedResident {
    /// Where a byte of its detail lies.
    fn detail_at(&self, byte: u64) -> u64 {
        let size = detail_size(self.model.crown.sequence().root_count());
        size * u64::from(self.room) + byte
    }

    fn go_over(
        &mut self,
        queue: &mut Queue<'_>,
        to: &State,
        source: u32,
        mut words: Vec<(u64, [u8; 4], Cause)>,
    ) -> Result<Change, GpuError> {
        if source != self.source {
            words.push((0, source.to_le_bytes(), Cause::of("counter")));
            self.source = source;
        }
        let regions: Vec<Region<'_>> = words
            .iter()
            .map(|(offset, bytes, cause)| Region {
                buffer: self.rooms.detail,
                offset: self.detail_at(*offset),
                bytes,
                cause: *cause,
            })
            .collect();
        send(queue, self.model.gather, &regions)?;
        let mut change = self.state.change_to(to, self.model.crown.clusters());
        change.host_records = words.len() as u64;
        self.state = to.clone();
        Ok(change)
    }
}
