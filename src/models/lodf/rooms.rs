//! What instances of a species share that the device refines: a room each in buffers of all, so that one
//! dispatch selects for all of them and one command draws them.
//!
//! | buffer | a room | who writes it |
//! |---|---|---|
//! | `detail` | 8 B, and 4 B a cluster | the host |
//! | `cluster collapses` | 4 B a cluster | `select` |
//! | `draw arguments` | 16 B a cluster | `select` |
//! | `seen clusters` | 4 B a cluster | `reveal`, for the next frame |
//! | `late draw arguments` | 16 B a cluster | `reveal` |
//!
//! The last two are there only where [hidden clusters are left out](Occlusion::TwoPhase). The instance of
//! the first room issues the commands for all; how many rooms are taken is counted here.

use std::cell::Cell;
use std::rc::Rc;

use super::super::environment::{INSTANCE_SLOT, Lens, Occluders, VIEW_SLOT};
use super::super::leaf::{COUNT_SLOT, LeafSource, WINDOW_CROWN_SLOT};
use super::super::reveal_pass::{
    DEPTH_SLOT, EARLY_ARGUMENT_SLOT, LATE_ARGUMENT_SLOT, PYRAMID_SLOT, REVEALED_SLOT,
};
use super::super::select_pass::{
    ARGUMENT_SLOT, CAMERA_SLOT, COLLAPSES_SLOT, CROWN_SLOT, DETAIL_SLOT, SEEN_SLOT, group_count,
};
use super::super::surface::{LEAF_GROUP, Surface};
use super::super::{Environment, Occlusion};
use crate::gpu::{
    BufferDescriptor, BufferId, Command, ComputePass, ComputeStep, Corners, Device, DrawIndirect,
    GpuError, IndirectRecord, Residency, Step, Usage,
};

/// What rooms are made for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lodging<'a> {
    pub(super) environment: &'a Environment,
    pub(super) lens: Lens,
    pub(super) surface: &'a Surface,
    /// What the vertex stage pulls beside, by slot.
    pub(super) pulled: &'a [(u32, BufferId)],
    pub(super) crown: BufferId,
    pub(super) clusters: u32,
    /// Records of a species.
    pub(super) records: u32,
    pub(super) occlusion: Occlusion,
}

/// Rooms for some instances.
#[derive(Debug)]
pub(super) struct Rooms {
    pub(super) detail: BufferId,
    clusters: u32,
    rooms: u32,
    taken: Cell<u32>,
    select: Vec<ComputeStep>,
    /// What draws have bound.
    bound: Vec<Step>,
    arguments: BufferId,
    revealed: Option<Revealed>,
}

/// What is drawn late.
#[derive(Debug)]
struct Revealed {
    reveal: Vec<ComputeStep>,
    arguments: BufferId,
}

/// Bytes of a room that the device fills.
pub(super) fn computed_size(clusters: u32, occlusion: Occlusion) -> u64 {
    let word_and_arguments = 4 + IndirectRecord::STRIDE;
    let buffers = match occlusion {
        Occlusion::None => 1,
        Occlusion::TwoPhase => 2,
    };
    buffers * word_and_arguments * u64::from(clusters)
}

/// Bytes of the detail of a room.
pub(super) fn detail_size(clusters: u32) -> u64 {
    8 + 4 * u64::from(clusters)
}

impl Rooms {
    /// Makes as many rooms as the environment says, or as corners can be numbered for.
    pub(super) fn new(device: &mut Device, lodging: &Lodging<'_>) -> Result<Rc<Self>, GpuError> {
        let Lodging {
            environment,
            lens,
            surface,
            pulled,
            crown,
            clusters,
            records,
            occlusion,
        } = *lodging;
        let most = u32::MAX / records.saturating_mul(4).max(1);
        let rooms = environment.rooms().min(most).max(1);
        let mut buffer = |label, size, usage| {
            device.create_buffer(&BufferDescriptor {
                label,
                size: size * u64::from(rooms),
                usage,
                residency: Residency::Device,
            })
        };
        let all = u64::from(clusters);
        let argument_usage = Usage::STORAGE | Usage::INDIRECT;
        let detail = buffer("detail", detail_size(clusters), Usage::STORAGE)?;
        let collapses = buffer("cluster collapses", 4 * all, Usage::STORAGE)?;
        let argument_size = IndirectRecord::STRIDE * all;
        let arguments = buffer("draw arguments", argument_size, argument_usage)?;
        let [view, instances] = environment.shared_buffers();
        let mut select = vec![ComputeStep::Program(lens.select(occlusion))];
        select.extend(storage(&[
            (VIEW_SLOT, view),
            (INSTANCE_SLOT, instances),
            (CAMERA_SLOT, lens.camera),
            (CROWN_SLOT, crown),
            (DETAIL_SLOT, detail),
            (COLLAPSES_SLOT, collapses),
            (ARGUMENT_SLOT, arguments),
        ]));
        let revealed = match occlusion {
            Occlusion::None => None,
            Occlusion::TwoPhase => {
                let Occluders {
                    target,
                    pyramid,
                    reveal,
                    ..
                } = environment.occluders()?;
                let seen = buffer("seen clusters", 4 * all, Usage::STORAGE)?;
                let late = buffer("late draw arguments", argument_size, argument_usage)?;
                select.extend(storage(&[(SEEN_SLOT, seen)]));
                let slot = DEPTH_SLOT;
                let mut reveal = vec![
                    ComputeStep::Program(reveal),
                    ComputeStep::Depth { slot, target },
                ];
                reveal.extend(storage(&[
                    (VIEW_SLOT, view),
                    (INSTANCE_SLOT, instances),
                    (CROWN_SLOT, crown),
                    (DETAIL_SLOT, detail),
                    (EARLY_ARGUMENT_SLOT, arguments),
                    (PYRAMID_SLOT, pyramid),
                    (REVEALED_SLOT, seen),
                    (LATE_ARGUMENT_SLOT, late),
                ]));
                Some(Revealed {
                    reveal,
                    arguments: late,
                })
            }
        };
        let mut bound = Vec::new();
        surface.bind(LeafSource::Windowed, &mut bound);
        let own = [(COUNT_SLOT, collapses), (WINDOW_CROWN_SLOT, crown)];
        for (slot, buffer) in pulled.iter().copied().chain(own) {
            bound.push(Step::Storage { slot, buffer });
        }
        Ok(Rc::new(Self {
            detail,
            clusters,
            rooms,
            taken: Cell::new(0),
            select,
            bound,
            arguments,
            revealed,
        }))
    }

    /// The number of a room that nobody had; `None` when all are taken.
    pub(super) fn take(&self) -> Option<u32> {
        let room = self.taken.get();
        (room < self.rooms).then(|| {
            self.taken.set(room + 1);
            room
        })
    }

    /// Adds the pass that selects for all.
    pub(super) fn prepare(&self, commands: &mut Vec<Command>) {
        commands.push(self.pass("select", &self.select));
    }

    /// Adds the pass that finds out what is left to draw of all.
    pub(super) fn reveal(&self, commands: &mut Vec<Command>) {
        if let Some(revealed) = &self.revealed {
            commands.push(self.pass("reveal", &revealed.reveal));
        }
    }

    /// Adds the steps that draw all.
    pub(super) fn draw(&self, steps: &mut Vec<Step>) {
        self.draw_from(self.arguments, steps);
    }

    /// Adds the steps that draw what is left of all.
    pub(super) fn draw_revealed(&self, steps: &mut Vec<Step>) {
        if let Some(revealed) = &self.revealed {
            self.draw_from(revealed.arguments, steps);
        }
    }

    /// Clusters of all rooms that are taken.
    fn count(&self) -> u32 {
        self.clusters * self.taken.get()
    }

    fn pass(&self, label: &str, steps: &[ComputeStep]) -> Command {
        let groups = group_count(self.count());
        let dispatch = [ComputeStep::Dispatch { groups }];
        Command::Compute(ComputePass {
            label: label.to_owned(),
            steps: [steps, &dispatch].concat(),
        })
    }

    fn draw_from(&self, arguments: BufferId, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.bound);
        steps.push(Step::MultiDrawIndirect(DrawIndirect {
            source: Corners::Counted,
            arguments,
            offset: 0,
            count: self.count(),
            group: LEAF_GROUP,
        }));
    }
}

fn storage(buffers: &[(u32, BufferId)]) -> impl Iterator<Item = ComputeStep> {
    let buffers = buffers.iter();
    buffers.map(|&(slot, buffer)| ComputeStep::Storage { slot, buffer })
}
