//! Which transfer brought what lies somewhere on the device.

use std::ops::Range;

use serde::Serialize;

use super::buffers::owner_name;
use super::operations::Operation;
use crate::gpu::{BufferId, ResourceId};
use crate::run::{Owner, Session};

/// Bytes on the device, and the transfer that wrote them last.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct UploadStory {
    /// The label of the buffer.
    pub buffer: String,
    /// What it belongs to: `plant 0`, `tree 0`.
    pub owner: String,
    /// The first byte of the triangle's corners there.
    pub start: u64,
    /// One past the last.
    pub end: u64,
    /// The frame with which one of these bytes was sent last; `None` for before the first frame.
    pub frame: Option<u32>,
    /// Why; `None` where the bytes lie in host memory, from where each draw pulls them.
    pub cause: Option<String>,
    /// Which of the cause's kind.
    pub id: Option<u32>,
    /// Bytes of that transfer.
    pub payload_bytes: Option<u64>,
}

/// A range that was written.
#[derive(Debug, Clone)]
struct Written {
    buffer: BufferId,
    range: Range<u64>,
    frame: Option<u32>,
    cause: &'static str,
    id: Option<u32>,
    payload_bytes: u64,
}

/// All ranges that were written of trunks' corners, in order.
#[derive(Debug, Default)]
pub(super) struct Uploads(Vec<Written>);

/// Labels of the buffers that hold the corners of trunks, and how many corners a record has: a strip
/// makes a triangle of every place and the two before it.
const CORNERS: [(&str, usize); 3] = [
    ("trunk strips", 1),
    ("trunk triangles", 3),
    ("trunk indices", 3),
];

impl Uploads {
    /// Adds what a frame sent, or what was sent before the first.
    pub(super) fn add(
        &mut self,
        frame: Option<u32>,
        operations: &[Operation],
        session: &Session<'_>,
    ) {
        let corners: Vec<BufferId> = session
            .device()
            .buffers()
            .filter(|(_, label)| CORNERS.iter().any(|(known, _)| known == label))
            .map(|(buffer, _)| buffer)
            .collect();
        for operation in operations {
            let transfer = operation.transfer();
            for (resource, offset, bytes) in operation.ranges() {
                let ResourceId::Buffer(buffer) = *resource else {
                    continue;
                };
                if corners.contains(&buffer) {
                    self.0.push(Written {
                        buffer,
                        range: *offset..offset + bytes.len() as u64,
                        frame,
                        cause: transfer.cause.kind,
                        id: transfer.cause.id,
                        payload_bytes: transfer.payload_bytes,
                    });
                }
            }
        }
    }

    /// Where the corners of a tree's triangle lie, and which transfer wrote some of them last; `None` if
    /// they lie nowhere.
    pub(super) fn of_triangle(
        &self,
        session: &Session<'_>,
        owners: [Owner; 2],
        corners: [u32; 3],
    ) -> Option<UploadStory> {
        let mut buffers = session.device().buffers();
        let (buffer, label, range) = buffers.find_map(|(buffer, label)| {
            let (_, step) = CORNERS.iter().find(|(known, _)| *known == label)?;
            let owner = session.owner(ResourceId::Buffer(buffer));
            if !owners.contains(&owner) {
                return None;
            }
            let bytes = session.device().inspect_buffer(buffer).ok()?;
            Some((buffer, label, place_of(bytes, *step, corners)?))
        })?;
        let last = self.0.iter().rev().find(|written| {
            let shared = written.range.start < range.end && range.start < written.range.end;
            written.buffer == buffer && shared
        });
        Some(UploadStory {
            buffer: label.to_owned(),
            owner: owner_name(session.owner(ResourceId::Buffer(buffer))),
            start: range.start,
            end: range.end,
            frame: last.and_then(|written| written.frame),
            cause: last.map(|written| written.cause.to_owned()),
            id: last.and_then(|written| written.id),
            payload_bytes: last.map(|written| written.payload_bytes),
        })
    }
}

/// The first three words in a row, at steps of so many, that are these corners in any turn. What is drawn
/// lies before what is dead, in blocks too: a triangle is in one of them only.
fn place_of(bytes: &[u8], step: usize, corners: [u32; 3]) -> Option<Range<u64>> {
    let (words, _) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let sorted = |mut corners: [u32; 3]| {
        corners.sort_unstable();
        corners
    };
    let wanted = sorted(corners);
    let mut windows = words.windows(3).enumerate().step_by(step);
    let (place, _) = windows.find(|(_, three)| sorted([three[0], three[1], three[2]]) == wanted)?;
    let start = 4 * place as u64;
    Some(start..start + 12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_found_in_strips_and_in_lists() {
        let words = [4_u32, 5, 6, 7, 8, 5, 6, 7];
        let bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
        // In a strip every second triangle is turned.
        assert_eq!(place_of(&bytes, 1, [7, 6, 5]), Some(4..16));
        assert_eq!(place_of(&bytes, 3, [5, 7, 8]), Some(12..24));
        assert_eq!(place_of(&bytes, 3, [5, 6, 7]), None);
        assert_eq!(place_of(&bytes, 1, [4, 5, 7]), None);
    }
}
