//! Executes compute passes: checks all of their dispatches, runs groups, counts.

use std::sync::Arc;

use rayon::prelude::{IntoParallelIterator as _, ParallelIterator as _};

use super::bus::RecordingEntry;
use super::card::DispatchWork;
use super::compute::{Access, ComputeProgram, Group, GroupSlot};
use super::ledger::ComputeCounts;
use super::pass::{BIND_BYTES, ComputePass, ComputeStep, DISPATCH_BYTES};
use super::program::{MAX_SLOTS, Words};
use super::{BufferId, DepthMap, Device, GpuError, Ledger, TargetId, Usage};
use crate::math::{index_u32, index_usize};
use crate::raster::Counters;

/// Executes one pass, or refuses it whole.
pub(super) fn compute(device: &mut Device, pass: &ComputePass) -> Result<(), GpuError> {
    let (dispatches, command_bytes) = plan(device, pass)?;
    let mut sums = Ledger {
        command_bytes,
        ..Ledger::default()
    };
    let mut ticks = 0;
    for dispatch in &dispatches {
        let bytes = run(device, dispatch);
        let groups = u64::from(dispatch.groups);
        sums.compute.add(&ComputeCounts {
            dispatches: 1,
            groups,
            bytes,
        });
        ticks += device.descriptor.card.dispatch_ticks(&DispatchWork {
            operations: groups * u64::from(dispatch.program.layout().group_operations),
            bytes,
        });
    }
    if device.descriptor.raster.counters == Counters::Exact {
        sums.gpu_ticks = Some(ticks);
    }
    device.bus.ledger().add(&sums);
    Ok(())
}

/// A dispatch with every argument checked.
struct Dispatch {
    program: Arc<dyn ComputeProgram>,
    /// What each of the program's slots has.
    bound: Vec<Bound>,
    groups: u32,
}

/// What is bound to a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Bound {
    Buffer(BufferId),
    Depth(TargetId),
}

impl Bound {
    fn buffer(self) -> Option<BufferId> {
        match self {
            Self::Buffer(id) => Some(id),
            Self::Depth(_) => None,
        }
    }
}

fn plan(device: &Device, pass: &ComputePass) -> Result<(Vec<Dispatch>, u64), GpuError> {
    let mut dispatches = Vec::new();
    let mut command_bytes = 0;
    let mut program: Option<Arc<dyn ComputeProgram>> = None;
    let mut bound = [None; MAX_SLOTS];
    for step in &pass.steps {
        match *step {
            ComputeStep::Program(id) => {
                command_bytes += BIND_BYTES;
                let found = device.compute_programs.get(id.index() as usize);
                program = Some(Arc::clone(found.ok_or(GpuError::Unknown {
                    what: "compute program",
                    index: id.index(),
                })?));
            }
            ComputeStep::Storage { slot, buffer } => {
                command_bytes += BIND_BYTES;
                device.buffer(buffer)?.check_on_device("a storage buffer")?;
                *place_mut(&mut bound, slot)? = Some(Bound::Buffer(buffer));
            }
            ComputeStep::Depth { slot, target } => {
                command_bytes += BIND_BYTES;
                device.target(target)?;
                *place_mut(&mut bound, slot)? = Some(Bound::Depth(target));
            }
            ComputeStep::Dispatch { groups } => {
                command_bytes += DISPATCH_BYTES;
                let program = program.clone().ok_or(GpuError::Unbound {
                    program: String::new(),
                    what: "compute program",
                    slot: 0,
                })?;
                dispatches.push(plan_dispatch(device, program, &bound, groups)?);
            }
        }
    }
    Ok((dispatches, command_bytes))
}

fn place_mut(
    places: &mut [Option<Bound>; MAX_SLOTS],
    slot: u32,
) -> Result<&mut Option<Bound>, GpuError> {
    places.get_mut(slot as usize).ok_or(GpuError::Unknown {
        what: "binding slot",
        index: slot,
    })
}

fn plan_dispatch(
    device: &Device,
    program: Arc<dyn ComputeProgram>,
    places: &[Option<Bound>; MAX_SLOTS],
    groups: u32,
) -> Result<Dispatch, GpuError> {
    let layout = program.layout();
    let mut bound = Vec::with_capacity(layout.slots.len());
    for (slot, (access, place)) in (0..).zip(layout.slots.iter().zip(places)) {
        let (what, fits) = match (access, place) {
            (Access::Depth, place) => ("depth", place.filter(|place| place.buffer().is_none())),
            (_, place) => (
                "storage buffer",
                place.filter(|place| place.buffer().is_some()),
            ),
        };
        let place = fits.ok_or_else(|| GpuError::Unbound {
            program: layout.name.to_owned(),
            what,
            slot,
        })?;
        if let Bound::Buffer(id) = place {
            device.buffer(id)?.check_usage(Usage::STORAGE)?;
        }
        bound.push(place);
    }
    for (access, &place) in layout.slots.iter().zip(&bound) {
        let (true, Bound::Buffer(id)) = (access.writes(), place) else {
            continue;
        };
        let slot = device.buffer(id)?;
        let group_bytes = owned_bytes(*access, slot.bytes.len() as u64, groups);
        if *access == Access::Share
            && (group_bytes * u64::from(groups) != slot.bytes.len() as u64
                || !group_bytes.is_multiple_of(4))
        {
            return Err(GpuError::Descriptor {
                label: slot.label.clone(),
                what: "size shared by groups",
                found: slot.bytes.len() as u64,
                wanted: format!("a multiple of 4 times {groups}"),
            });
        }
        if bound.iter().filter(|other| **other == place).count() > 1 {
            return Err(GpuError::Usage {
                label: slot.label.clone(),
                has: "one slot of a dispatch that writes it".to_owned(),
                wanted: "another".to_owned(),
            });
        }
        // Every group must own something, so what a dispatch does is bounded by memory.
        if let Some(last) = groups.checked_sub(1) {
            slot.range(group_bytes * u64::from(last), 4, "dispatch")?;
        }
    }
    Ok(Dispatch {
        program,
        bound,
        groups,
    })
}

/// How many bytes of a buffer a group owns, where it does.
fn owned_bytes(access: Access, size: u64, groups: u32) -> u64 {
    match access {
        Access::Own { group_bytes } => u64::from(group_bytes),
        Access::Share => size / u64::from(groups.max(1)),
        Access::Read | Access::Recall | Access::Depth => 0,
    }
}

/// Runs the groups of a dispatch; returns how many bytes they read and wrote.
fn run(device: &mut Device, dispatch: &Dispatch) -> u64 {
    let layout = dispatch.program.layout();
    let slots = || layout.slots.iter().zip(&dispatch.bound);
    if let Some(reads) = &mut device.reads {
        for id in dispatch.bound.iter().filter_map(|place| place.buffer()) {
            let bytes = device.buffers[id.index() as usize]
                .as_ref()
                .map_or(0, |buffer| buffer.bytes.len());
            reads.watch(id, bytes);
        }
    }
    // What is written is taken out of the device, so that everything else can be read meanwhile.
    let mut written: Vec<(BufferId, u32, Vec<u8>)> = Vec::new();
    for (access, &place) in slots() {
        if let (true, Bound::Buffer(id)) = (access.writes(), place) {
            let bytes = device.bytes_mut(id).map(std::mem::take).unwrap_or_default();
            let group_bytes = owned_bytes(*access, bytes.len() as u64, dispatch.groups);
            written.push((id, index_u32(index_usize(group_bytes)), bytes));
        }
    }
    let before: Vec<Vec<u8>> = match device.bus.recording() {
        Some(_) => written.iter().map(|(_, _, bytes)| bytes.clone()).collect(),
        None => Vec::new(),
    };
    let bytes = run_groups(device, dispatch, &mut written);
    for (number, (id, _, bytes)) in written.into_iter().enumerate() {
        if let Some(span) = before.get(number).and_then(|old| differing(old, &bytes)) {
            device.bus.note(RecordingEntry::Computed {
                buffer: id,
                offset: span.start as u64,
                bytes: bytes[span].to_vec(),
            });
        }
        if let Some(place) = device.bytes_mut(id) {
            *place = bytes;
        }
    }
    bytes
}

fn run_groups(
    device: &Device,
    dispatch: &Dispatch,
    written: &mut [(BufferId, u32, Vec<u8>)],
) -> u64 {
    let layout = dispatch.program.layout();
    let mut owned: Vec<_> = written
        .iter_mut()
        .map(|(id, size, bytes)| (*id, *size, bytes.chunks_mut(*size as usize)))
        .collect();
    let mut groups: Vec<Group<'_>> = Vec::with_capacity(dispatch.groups as usize);
    for number in 0..dispatch.groups {
        let mut parts = owned.iter_mut();
        let slots = layout.slots.iter().zip(&dispatch.bound);
        let slots = slots.map(|(access, &place)| match (access, place) {
            (_, Bound::Depth(id)) => GroupSlot::Depth(DepthMap::of(device, id)),
            (Access::Recall, Bound::Buffer(id)) => {
                GroupSlot::All(Words::of(id, device.living(id), None))
            }
            (Access::Read | Access::Depth, Bound::Buffer(id)) => {
                GroupSlot::All(Words::of(id, device.living(id), device.reads.as_ref()))
            }
            (Access::Own { .. } | Access::Share, Bound::Buffer(_)) => {
                let (buffer, size, chunks) = parts.next().expect("one for each slot that is owned");
                GroupSlot::Own {
                    buffer: *buffer,
                    first: index_usize(u64::from(number) * u64::from(*size)),
                    bytes: chunks.next().expect("every group owns something"),
                    reads: device.reads.as_ref(),
                }
            }
        });
        groups.push(Group {
            number,
            slots: slots.collect(),
            bytes: 0,
        });
    }
    let moved: Vec<u64> = groups
        .into_par_iter()
        .map(|mut group| {
            dispatch.program.run(&mut group);
            group.bytes
        })
        .collect();
    moved.into_iter().sum()
}

/// From the first byte that differs to the last.
fn differing(old: &[u8], new: &[u8]) -> Option<std::ops::Range<usize>> {
    let differs = |place: &usize| old[*place] != new[*place];
    let first = (0..new.len()).find(differs)?;
    let last = (0..new.len()).rfind(differs)?;
    Some(first..last + 1)
}
