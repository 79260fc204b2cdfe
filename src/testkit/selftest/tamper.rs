//! Faults of device models, put into our own sound ones.

use std::sync::Arc;

use super::super::device::{Change, Counted, DeviceModel, Picture, Reads, Resource};
use super::super::{History, Meddled, Meddling, Stage};
use crate::gpu::{Corners, Draw, DrawFromCounter, DrawIndirect, Step};
use crate::models::{
    Crown, Extraction, Gather, Kind, LEAF_GROUP, LeafFormat, ModelOptions, Occlusion, State,
};
use crate::scene::{CardOptions, PaintOptions};

/// What is wrong in a device model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DeviceFault {
    /// After a split, the last slot that was sent holds what it held before.
    StaleSlotOnSplit,
    /// The last range of records that changed is not sent.
    MissedRange,
    /// Numbers of visible leaves are not sent.
    CountNotSent,
    /// The last range of records is written one record further on.
    WrongOffset,
    /// Thresholds of clusters are not sent.
    ThresholdNotSent,
    /// The stamp of the first new leaf is that of the collapse after its own.
    WrongBirthStamp,
    /// The last transfer is not counted.
    TransferNotCounted,
    /// The last transfer is counted twice.
    TransferCountedTwice,
    /// A byte that no draw reads changes behind the bus's back.
    ByteBehindTheBus,
    /// A commit goes one collapse too far.
    OneCollapseTooFar,
    /// Every slot is drawn as a group of its own, so that ties of depth go by slot.
    TiesBySlotOrder,
    /// The last leaf is not drawn.
    StopsShort,
}

/// One of our models on its device, with a fault or without.
pub(super) struct Tampered {
    stage: Stage,
    fault: Option<DeviceFault>,
    history: Arc<History>,
    state: State,
}

pub(super) const SIDE: u32 = 16;

const OPTIONS: ModelOptions = ModelOptions {
    extraction: Extraction::Batched,
    gather: Gather::Single,
    format: LeafFormat::WIDE,
    occlusion: Occlusion::None,
    cards: CardOptions::USUAL,
    painting: PaintOptions::USUAL,
};

impl Tampered {
    pub(super) fn new(
        kind: Kind,
        crown: &Arc<Crown>,
        history: &Arc<History>,
        state: &State,
        fault: Option<DeviceFault>,
    ) -> Self {
        let model = kind.model(crown, OPTIONS);
        let mut stage = Stage::new(Stage::descriptor(), model.as_ref(), state, SIDE)
            .expect("a few leaves fit any device");
        let mut meddling = Meddling::none();
        match fault {
            Some(DeviceFault::TiesBySlotOrder) => {
                let crown = Arc::clone(crown);
                let slots = move |state: &State, step| match step {
                    Step::DrawIndirect(_) => slot_by_slot(&crown, state),
                    step => vec![step],
                };
                meddling.drawn = Box::new(move |state, steps| {
                    let steps = steps.into_iter();
                    steps.flat_map(|step| slots(state, step)).collect()
                });
            }
            Some(DeviceFault::StopsShort) => {
                meddling.drawn = Box::new(|_, steps| steps.into_iter().filter_map(short).collect());
            }
            _ => {}
        }
        stage = stage.wrapped(|inner| Box::new(Meddled::new(inner, meddling)));
        let mut tampered = Self {
            stage,
            fault,
            history: Arc::clone(history),
            state: state.clone(),
        };
        if fault == Some(DeviceFault::WrongBirthStamp) {
            tampered.spoil_a_stamp();
        }
        tampered
    }

    /// The words of a stamped record: four corners, birth, cluster.
    fn spoil_a_stamp(&mut self) {
        let resources = self.stage.resources();
        let records = resources.iter().position(|r| r.name == "stamped records");
        let Some(number) = records else { return };
        let births = resources[number].bytes.chunks(24).map(|record| record[16]);
        let Some((record, birth)) = births.enumerate().find(|&(_, birth)| birth == 1) else {
            return;
        };
        self.stage.overwrite(number, 24 * record + 16, &[birth + 1]);
    }

    /// What each resource holds.
    fn held(&self) -> Vec<Vec<u8>> {
        let resources = self.stage.resources();
        resources.iter().map(|held| held.bytes.to_vec()).collect()
    }

    fn number_of(&self, name: &str) -> Option<usize> {
        let resources = self.stage.resources();
        resources.iter().position(|resource| resource.name == name)
    }

    /// The ranges of a resource that were written since the log had `known` entries.
    fn written(&self, known: usize, name: &str) -> Vec<(usize, usize, usize)> {
        let Some(wanted) = self.number_of(name) else {
            return Vec::new();
        };
        let log = self.stage.log().unwrap_or_default();
        let writes = log.iter().skip(known).filter_map(|change| match change {
            Change::Write {
                resource,
                at,
                bytes,
                ..
            } if *resource == wanted => Some((wanted, usize::try_from(*at).ok()?, bytes.len())),
            _ => None,
        });
        writes.collect()
    }

    /// Puts back what a range held before.
    fn restore(&mut self, before: &[Vec<u8>], (resource, at, size): (usize, usize, usize)) {
        let bytes = before[resource][at..at + size].to_vec();
        self.stage.overwrite(resource, at, &bytes);
    }

    /// Does what the fault does after a sound commit that found the log with `known` entries.
    fn spoil(&mut self, before: &[Vec<u8>], known: usize, is_split: bool) {
        let records = self.written(known, "leaf records");
        match self.fault {
            Some(DeviceFault::StaleSlotOnSplit) if is_split => {
                if let Some(&last) = records.last() {
                    self.restore(before, last);
                }
            }
            Some(DeviceFault::MissedRange) => {
                if let Some(&last) = records.last() {
                    self.restore(before, last);
                }
            }
            Some(DeviceFault::CountNotSent) => {
                for range in self.written(known, "draw arguments") {
                    self.restore(before, range);
                }
            }
            Some(DeviceFault::ThresholdNotSent) => {
                for range in self.written(known, "thresholds") {
                    self.restore(before, range);
                }
            }
            Some(DeviceFault::WrongOffset) => {
                let Some(&(number, at, size)) = records.last() else {
                    return;
                };
                let bytes = self.held().swap_remove(number);
                self.restore(before, (number, at, size));
                let further = if at + 16 + size <= bytes.len() {
                    at + 16
                } else {
                    at.saturating_sub(16)
                };
                self.stage.overwrite(number, further, &bytes[at..at + size]);
            }
            Some(DeviceFault::ByteBehindTheBus) => self.change_a_dead_byte(),
            _ => {}
        }
    }

    fn change_a_dead_byte(&mut self) {
        let Some(number) = self.number_of("leaf records") else {
            return;
        };
        let reads = self.stage.reads().ranges;
        let held = self.held().swap_remove(number);
        let read = |at: usize| {
            let mut own = reads.iter().filter(|(resource, _)| *resource == number);
            own.any(|(_, range)| range.contains(&at))
        };
        if let Some(dead) = (0..held.len()).find(|&at| !read(at)) {
            self.stage.overwrite(number, dead, &[!held[dead]]);
        }
    }
}

impl DeviceModel for Tampered {
    fn commit(&mut self, to: &State) {
        let (before, known) = (self.held(), self.stage.log().map_or(0, |log| log.len()));
        let done = |state: &State| match state {
            State::Uniform { collapses } => *collapses,
            State::Variable { counts } => counts.iter().sum(),
            State::Cards(_) | State::Strokes(_) => 0,
        };
        let is_split = done(to) < done(&self.state);
        let mut asked = to.clone();
        if let (Some(DeviceFault::OneCollapseTooFar), State::Uniform { collapses }) =
            (self.fault, to)
        {
            let collapses = (collapses + 1).min(self.history.collapse_count());
            asked = State::Uniform { collapses };
        }
        DeviceModel::commit(&mut self.stage, &asked);
        self.state = to.clone();
        self.spoil(&before, known, is_split);
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        self.stage.resources()
    }

    fn reads(&mut self) -> Reads {
        self.stage.reads()
    }

    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]) {
        self.stage.overwrite(resource, at, bytes);
    }

    fn log(&self) -> Option<Vec<Change<'_>>> {
        // The stamp was spoilt past the log, which says what it should be.
        let logs = self.fault != Some(DeviceFault::WrongBirthStamp);
        self.stage.log().filter(|_| logs)
    }

    fn counted(&mut self) -> Option<Counted> {
        let mut counted = self.stage.counted()?;
        let log = self.stage.log()?;
        let last = log.iter().rev().find_map(|change| match change {
            Change::Write { bytes, .. } => Some(bytes.len() as u64),
            _ => None,
        });
        let bytes = last.unwrap_or(0);
        match self.fault {
            Some(DeviceFault::TransferNotCounted) => {
                counted.transfers -= 1;
                counted.payload_bytes -= bytes;
            }
            Some(DeviceFault::TransferCountedTwice) => {
                counted.transfers += 1;
                counted.payload_bytes += bytes;
            }
            _ => {}
        }
        Some(counted)
    }

    fn picture(&mut self) -> Option<Picture> {
        self.stage.picture()
    }
}

/// The visible slots of all clusters, each drawn by itself and with a group of its own.
fn slot_by_slot(crown: &Crown, state: &State) -> Vec<Step> {
    let clusters = crown.clusters();
    let counts = state.counts(clusters);
    let mut draws = Vec::new();
    let mut start = 0;
    for (cluster, count) in clusters.clusters.iter().zip(counts) {
        let slots = start..start + cluster.original_count() - count;
        draws.extend(slots.map(|slot| {
            Step::Draw(Draw {
                source: Corners::Indexed,
                first_corner: 4 * slot,
                corner_count: 4,
                instance: 0,
                group: LEAF_GROUP + slot,
            })
        }));
        start += cluster.original_count();
    }
    draws
}

/// A step that draws less.
fn short(step: Step) -> Option<Step> {
    Some(match step {
        Step::Draw(draw) => Step::Draw(Draw {
            corner_count: draw.corner_count - 4,
            ..draw
        }),
        Step::DrawIndirect(draw) => Step::DrawIndirect(DrawIndirect {
            count: draw.count.checked_sub(1)?,
            ..draw
        }),
        Step::DrawFromCounter(draw) => Step::DrawFromCounter(DrawFromCounter {
            end: draw.end - 4,
            ..draw
        }),
        other => other,
    })
}
