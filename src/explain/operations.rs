//! What two runs do to their devices, transfer by transfer.

use serde::Serialize;

use super::buffers::{Reader, owner_name};
use crate::gpu::{Ledger, RecordingEntry, ResourceId, Stream, Transfer};
use crate::run::{Owner, Session};

/// The first transfer that two runs do not share.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperationDifference {
    /// The frame whose change of detail or drawing it is part of; `None` for what is sent before the
    /// first frame.
    pub frame: Option<u32>,
    /// Its place among the frame's transfers, from 0.
    pub place: u64,
    /// Transfers of the frame, in A and in B.
    pub transfers: [u64; 2],
    /// Places of the frame at which the transfers differ.
    pub differing: u64,
    /// What A does there; `None` where A does no more.
    pub a: Option<OperationSide>,
    /// What B does there.
    pub b: Option<OperationSide>,
}

/// A transfer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OperationSide {
    /// `upload`, `fetch` or `readback`.
    pub stream: &'static str,
    /// The label of the resource.
    pub resource: String,
    /// What the resource belongs to: `scene`, `plant 0`, `tree 0`; `None` where bytes are not
    /// recorded.
    pub owner: Option<String>,
    /// Why.
    pub cause: String,
    /// Which of the cause's kind.
    pub id: Option<u32>,
    /// Ranges that it writes.
    pub ranges: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
    /// The first byte, in the resource, of the range in which the two first differ.
    pub offset: Option<u64>,
    /// That range's bytes.
    pub length: Option<u64>,
    /// The byte of the resource from which on they differ.
    pub differs_at: Option<u64>,
    /// What is sent from there on, at most 32 bytes, in hexadecimal digits.
    pub sent: Option<String>,
    /// The record that this byte is part of, in words.
    pub record: Option<String>,
}

/// A transfer with what it carries.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Operation {
    transfer: Transfer,
    resource: Option<ResourceId>,
    owner: Option<Owner>,
    /// Ranges as they were written: where, first byte, bytes.
    ranges: Vec<(ResourceId, u64, Vec<u8>)>,
}

/// Transfers with their bytes: the recording holds one write a range of each upload, in order.
pub(super) fn operations(ledger: &Ledger, session: &Session<'_>) -> Vec<Operation> {
    let recording = session.device().recording();
    let mut writes = recording
        .iter()
        .flat_map(|recording| &recording.entries)
        .filter_map(|entry| match entry {
            RecordingEntry::Write {
                resource,
                offset,
                bytes,
            } => Some((*resource, *offset, bytes.clone())),
            RecordingEntry::Copy { .. }
            | RecordingEntry::Computed { .. }
            | RecordingEntry::Clear { .. } => None,
        });
    let operation = |transfer: &Transfer| {
        let count = match transfer.stream {
            Stream::Upload => usize::try_from(transfer.ranges).unwrap_or(usize::MAX),
            Stream::Fetch | Stream::Readback => 0,
        };
        let ranges: Vec<_> = writes.by_ref().take(count).collect();
        let resource = ranges.first().map(|range| range.0);
        Operation {
            transfer: transfer.clone(),
            owner: resource.map(|resource| session.owner(resource)),
            resource,
            ranges,
        }
    };
    ledger.transfers.iter().map(operation).collect()
}

impl Operation {
    /// The transfer.
    pub(super) fn transfer(&self) -> &Transfer {
        &self.transfer
    }

    /// What it wrote: where, first byte, bytes.
    pub(super) fn ranges(&self) -> &[(ResourceId, u64, Vec<u8>)] {
        &self.ranges
    }

    /// Whether both do the same; modelled figures follow from links, not from what is done.
    fn same(&self, other: &Self) -> bool {
        let key = |one: &Self| {
            let transfer = &one.transfer;
            (
                transfer.stream,
                transfer.cause,
                transfer.ranges,
                transfer.payload_bytes,
            )
        };
        let ranges = || self.ranges.iter().zip(&other.ranges);
        key(self) == key(other)
            && self.transfer.resource == other.transfer.resource
            && self.owner == other.owner
            && self.ranges.len() == other.ranges.len()
            && ranges().all(|(one, other)| (one.1, &one.2) == (other.1, &other.2))
    }
}

/// Whether all transfers of a frame are the same.
pub(super) fn same_operations(a: &[Operation], b: &[Operation]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(one, other)| one.same(other))
}

/// The first place at which the transfers of a frame differ.
pub(super) fn first_difference(
    frame: Option<u32>,
    operations: [&[Operation]; 2],
    readers: [&Reader<'_>; 2],
) -> Option<OperationDifference> {
    let [a, b] = operations;
    let same = |place: usize| match (a.get(place), b.get(place)) {
        (Some(one), Some(other)) => one.same(other),
        (one, other) => one.is_none() && other.is_none(),
    };
    let differing: Vec<usize> = (0..a.len().max(b.len()))
        .filter(|&place| !same(place))
        .collect();
    let &place = differing.first()?;
    let pair = [a.get(place), b.get(place)];
    let range = pair[0].zip(pair[1]).and_then(|(one, other)| {
        let count = one.ranges.len().max(other.ranges.len());
        (0..count).find(|&range| {
            let key = |one: &Operation| {
                one.ranges
                    .get(range)
                    .map(|range| (range.1, range.2.clone()))
            };
            key(one) != key(other)
        })
    });
    let side = |side: usize| {
        let operation = pair[side]?;
        let range = range.unwrap_or(0);
        let ours = operation.ranges.get(range);
        let theirs = pair[1 - side].and_then(|other| other.ranges.get(range));
        let differs_at = ours.map(|(_, offset, bytes)| {
            let common = match theirs {
                Some((_, other, theirs)) if other == offset => {
                    let equal = bytes
                        .iter()
                        .zip(theirs)
                        .take_while(|(one, other)| one == other);
                    equal.count() as u64
                }
                _ => 0,
            };
            offset + common
        });
        let sent = ours.zip(differs_at).map(|((_, offset, bytes), at)| {
            let from = usize::try_from(at - offset).unwrap_or(bytes.len());
            hexadecimal(bytes.get(from..).unwrap_or_default())
        });
        let record = operation.resource.zip(differs_at).map(|(resource, at)| {
            let (_, offset, bytes) = ours.expect("there is a byte that differs");
            readers[side].describe(resource, at, *offset, bytes)
        });
        let transfer = &operation.transfer;
        Some(OperationSide {
            stream: transfer.stream.name(),
            resource: transfer.resource.clone(),
            owner: operation.owner.map(owner_name),
            cause: transfer.cause.kind.to_owned(),
            id: transfer.cause.id,
            ranges: transfer.ranges,
            payload_bytes: transfer.payload_bytes,
            offset: ours.map(|range| range.1),
            length: ours.map(|range| range.2.len() as u64),
            differs_at,
            sent,
            record: record.flatten(),
        })
    };
    Some(OperationDifference {
        frame,
        place: place as u64,
        transfers: [a.len() as u64, b.len() as u64],
        differing: differing.len() as u64,
        a: side(0),
        b: side(1),
    })
}

/// The first bytes, two digits each.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    const MOST: usize = 32;
    let digits = bytes.iter().take(MOST).map(|byte| format!("{byte:02x}"));
    digits.collect()
}
