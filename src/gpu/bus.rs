//! Moves bytes between host and device, and alone counts them.

use super::ledger::{Cause, Ledger, Share, Stream, Transfer};
use super::{BufferId, Link, TextureId};

/// The bus: a link, the counters of everything that crossed it, and the recording.
#[derive(Debug)]
pub(super) struct Bus {
    link: Link,
    ledger: Ledger,
    recording: Option<Recording>,
}

/// A resource that can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ResourceId {
    /// A buffer.
    Buffer(BufferId),
    /// A mip level of a texture.
    Texture(TextureId, u32),
}

/// Everything that changed device memory, in order: replayed into zeroed arrays it gives what the
/// device holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Recording {
    /// The changes.
    pub entries: Vec<RecordingEntry>,
}

/// One change of device memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingEntry {
    /// Bytes that crossed the bus.
    Write {
        /// Where to.
        resource: ResourceId,
        /// The first byte.
        offset: u64,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// Bytes copied within the device.
    Copy {
        /// Where from.
        source: BufferId,
        /// The first byte read.
        source_offset: u64,
        /// Where to.
        destination: BufferId,
        /// The first byte written.
        destination_offset: u64,
        /// How many.
        size: u64,
    },
    /// Bytes that a compute pass wrote, from the first that it changed to the last: a change within
    /// the device that crosses no bus.
    Computed {
        /// Where.
        buffer: BufferId,
        /// The first byte.
        offset: u64,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// Bytes set to zero within the device.
    Clear {
        /// Where.
        buffer: BufferId,
        /// The first byte.
        offset: u64,
        /// How many.
        size: u64,
    },
}

/// One range of a gathered write.
#[derive(Debug, Clone)]
pub(super) struct Part<'a> {
    pub(super) resource: ResourceId,
    pub(super) label: String,
    pub(super) offset: u64,
    pub(super) bytes: &'a [u8],
    pub(super) cause: Cause,
}

impl Bus {
    pub(super) fn new(link: Link) -> Self {
        Self {
            link,
            ledger: Ledger::default(),
            recording: None,
        }
    }

    pub(super) fn ledger(&mut self) -> &mut Ledger {
        &mut self.ledger
    }

    pub(super) fn link(&self) -> Link {
        self.link
    }

    pub(super) fn record(&mut self) {
        self.recording = Some(Recording::default());
    }

    pub(super) fn recording(&self) -> Option<&Recording> {
        self.recording.as_ref()
    }

    pub(super) fn note(&mut self, entry: RecordingEntry) {
        if let Some(recording) = &mut self.recording {
            recording.entries.push(entry);
        }
    }

    /// Counts one upload of all `parts` in one transfer and records them. Empty parts never come
    /// here. The transfer itself is attributed to the first part's cause and buffer, the bytes to
    /// each part's own.
    pub(super) fn upload(&mut self, parts: &[Part<'_>]) {
        let Some(first) = parts.first() else { return };
        let payload = parts.iter().map(|part| part.bytes.len() as u64).sum();
        let ranges = parts.len() as u64;
        self.count(Stream::Upload, &first.label, first.cause, ranges, payload);
        for (number, part) in parts.iter().enumerate() {
            let share = Share {
                transfers: u64::from(number == 0),
                payload_bytes: part.bytes.len() as u64,
            };
            self.attribute(&part.label, part.cause, share);
            self.note(RecordingEntry::Write {
                resource: part.resource,
                offset: part.offset,
                bytes: if self.recording.is_some() {
                    part.bytes.to_vec()
                } else {
                    Vec::new()
                },
            });
        }
    }

    /// Counts one transfer of another stream.
    pub(super) fn move_bytes(&mut self, stream: Stream, label: &str, cause: Cause, payload: u64) {
        self.count(stream, label, cause, 1, payload);
        self.attribute(
            label,
            cause,
            Share {
                transfers: 1,
                payload_bytes: payload,
            },
        );
    }

    fn count(&mut self, stream: Stream, label: &str, cause: Cause, ranges: u64, payload: u64) {
        let wire_bytes = self.link.wire_bytes(payload);
        let ticks = match stream {
            Stream::Upload | Stream::Fetch => self.link.ticks_down(payload),
            Stream::Readback => self.link.ticks_up(payload),
        };
        let sum = self.ledger.stream_mut(stream);
        sum.transfers += 1;
        sum.payload_bytes += payload;
        sum.wire_bytes += wire_bytes;
        sum.ticks += ticks;
        self.ledger.transfers.push(Transfer {
            stream,
            resource: label.to_owned(),
            cause,
            ranges,
            payload_bytes: payload,
            wire_bytes,
            ticks,
        });
    }

    fn attribute(&mut self, label: &str, cause: Cause, share: Share) {
        let by_cause = self.ledger.by_cause.entry(cause.kind).or_default();
        by_cause.transfers += share.transfers;
        by_cause.payload_bytes += share.payload_bytes;
        let by_buffer = match self.ledger.by_buffer.get_mut(label) {
            Some(by_buffer) => by_buffer,
            None => self.ledger.by_buffer.entry(label.to_owned()).or_default(),
        };
        by_buffer.transfers += share.transfers;
        by_buffer.payload_bytes += share.payload_bytes;
    }
}
