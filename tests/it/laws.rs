//! The laws that every model and mode keeps.
//!
//! Each law names the seeded bug that it was seen to catch; `model_contracts` plants it.

use std::collections::BTreeMap;

use proptest::prelude::{prop_assert, prop_assert_eq};
use proptest::test_runner::TestCaseError;
use spinney::gpu::{BufferId, Device, RecordingEntry, ResourceId};
use spinney::math::{index_u32, index_usize};
use spinney::models::{Crown, State};

use crate::support::Stage;

/// Law 1, residency: after any walk, every byte that a draw of the state can read equals a fresh
/// upload of that state; what draws pull from the host is the same, primitive by primitive.
///
/// Caught: a resident that commits a state of one collapse more than it says.
pub(crate) fn check_residency(walked: &mut Stage, fresh: &mut Stage) -> Result<(), TestCaseError> {
    fresh.device.track_reads();
    fresh.draw();
    let reads = fresh.device.reads().expect("just tracked");
    for buffer in reads.buffers() {
        let (wanted, found) = (bytes(fresh, buffer), bytes(walked, buffer));
        prop_assert_eq!(wanted.len(), found.len());
        for range in reads.ranges(buffer) {
            let range = index_usize(range.start)..index_usize(range.end).min(wanted.len());
            prop_assert_eq!(
                &wanted[range.clone()],
                &found[range.clone()],
                "{:?} bytes {:?}",
                buffer,
                range
            );
        }
    }
    if !reads.fetched.is_empty() {
        walked.device.track_reads();
        walked.draw();
        let sorted = |stage: &Stage| {
            let mut fetched = stage.device.reads().expect("tracked").fetched.clone();
            fetched.sort();
            fetched
        };
        prop_assert_eq!(sorted(fresh), sorted(walked));
    }
    Ok(())
}

pub(crate) fn bytes(stage: &Stage, buffer: BufferId) -> Vec<u8> {
    stage
        .device
        .inspect_buffer(buffer)
        .expect("both devices made the same buffers")
        .to_vec()
}

/// Law 2, images: the same leaves give the same picture, bit for bit, in all models and modes, and
/// bytes that no draw reads do not matter.
///
/// Caught: a resident with the right bytes whose draw stops short of the last ones.
pub(crate) fn check_image(
    walked: &mut Stage,
    fresh: &mut Stage,
    reference: &mut Stage,
) -> Result<(), TestCaseError> {
    fresh.device.track_reads();
    let wanted = reference.draw();
    prop_assert_eq!(
        &fresh.draw(),
        &wanted,
        "a fresh upload draws what the reference draws"
    );
    let reads = fresh.device.reads().expect("just tracked");
    for buffer in reads.buffers() {
        let size = bytes(walked, buffer).len() as u64;
        let mut from = 0;
        let end = std::iter::once(size..size);
        for range in reads.ranges(buffer).into_iter().chain(end) {
            let gap = from..range.start.min(size);
            if gap.start < gap.end && reads.fetched.is_empty() {
                walked
                    .device
                    .poison(buffer, gap, 0xa5)
                    .expect("within the buffer");
            }
            from = range.end;
        }
    }
    prop_assert_eq!(&walked.draw(), &wanted, "poisoned bytes are seen");
    Ok(())
}

/// Law 3, conservation: the recorded changes, replayed into zeroed arrays, give what the device
/// holds, textures too, and the lengths of the writes add up to the ledger.
///
/// Caught: a byte that was changed behind the bus's back.
pub(crate) fn check_conservation(device: &Device, payload: u64) -> Result<(), TestCaseError> {
    let recording = device.recording().expect("recorded from the start");
    let mut memory: BTreeMap<ResourceId, Vec<u8>> = BTreeMap::new();
    let mut sum = 0;
    for entry in &recording.entries {
        if let RecordingEntry::Write { bytes, .. } = entry {
            sum += bytes.len() as u64;
        }
        replay(device, &mut memory, entry);
    }
    prop_assert_eq!(sum, payload, "lengths add up to the ledger");
    for (resource, replayed) in &memory {
        prop_assert_eq!(&replayed[..], held(device, *resource), "{:?}", resource);
    }
    // What lies on the device and was never written is as it was created.
    let resident = device.resident_by_label();
    for (buffer, label) in device.buffers() {
        let written = memory.contains_key(&ResourceId::Buffer(buffer));
        if !written && resident.iter().any(|(known, _)| known == label) {
            let zero = held(device, ResourceId::Buffer(buffer))
                .iter()
                .all(|&byte| byte == 0);
            prop_assert!(zero, "{:?} was never written", label);
        }
    }
    Ok(())
}

fn held(device: &Device, resource: ResourceId) -> &[u8] {
    let held = match resource {
        ResourceId::Buffer(buffer) => device.inspect_buffer(buffer),
        ResourceId::Texture(texture, level) => device.inspect_texture(texture, level),
    };
    held.expect("what was written exists")
}

/// Does one recorded change to arrays that begin as zeros.
fn replay(device: &Device, memory: &mut BTreeMap<ResourceId, Vec<u8>>, entry: &RecordingEntry) {
    let zeros = |resource| vec![0; held(device, resource).len()];
    let (to, offset, bytes) = match entry {
        RecordingEntry::Write {
            resource,
            offset,
            bytes,
        } => (*resource, *offset, bytes.clone()),
        RecordingEntry::Copy {
            source,
            source_offset,
            destination,
            destination_offset,
            size,
        } => {
            let source = ResourceId::Buffer(*source);
            let from = memory.entry(source).or_insert_with(|| zeros(source));
            let bytes = from[index_usize(*source_offset)..][..index_usize(*size)].to_vec();
            (ResourceId::Buffer(*destination), *destination_offset, bytes)
        }
        RecordingEntry::Clear {
            buffer,
            offset,
            size,
        } => (
            ResourceId::Buffer(*buffer),
            *offset,
            vec![0; index_usize(*size)],
        ),
    };
    let array = memory.entry(to).or_insert_with(|| zeros(to));
    array[index_usize(offset)..][..bytes.len()].copy_from_slice(&bytes);
}

/// Law 4, partition: the visible leaves are one cut of each tree, each original under exactly one
/// of them.
///
/// Caught: the papers' static list.
pub(crate) fn check_partition(
    crown: &Crown,
    drawn: &[u32],
    state: &State,
) -> Result<(), TestCaseError> {
    let sequence = crown.sequence();
    let originals = sequence.original_count();
    let mut covered = vec![0_u32; originals as usize];
    for &leaf in drawn {
        let mut below = vec![leaf];
        while let Some(leaf) = below.pop() {
            match leaf.checked_sub(originals) {
                None => covered[leaf as usize] += 1,
                Some(op) => below.extend(sequence.collapses()[op as usize].old),
            }
        }
    }
    prop_assert_eq!(covered, vec![1; originals as usize], "in {:?}", state);
    prop_assert_eq!(index_u32(drawn.len()), state.leaf_count(crown.clusters()));
    if let State::Uniform { collapses } = state {
        let mut drawn = drawn.to_vec();
        drawn.sort_unstable();
        prop_assert_eq!(drawn, sequence.visible_after(*collapses));
    }
    Ok(())
}
