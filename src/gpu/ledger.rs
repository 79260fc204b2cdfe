//! What was moved and drawn: the ledger of a frame.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Deserializer, Serialize};

use super::Ticks;
use crate::limits;

/// Why bytes were moved; opaque to the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct Cause {
    /// The kind, such as `"slot"`.
    pub kind: &'static str,
    /// Which one of its kind, such as a cluster's number.
    pub id: Option<u32>,
}

impl Cause {
    /// A cause without a number.
    #[must_use]
    pub const fn of(kind: &'static str) -> Self {
        Self { kind, id: None }
    }

    /// A numbered cause.
    #[must_use]
    pub const fn numbered(kind: &'static str, id: u32) -> Self {
        Self { kind, id: Some(id) }
    }
}

/// A direction over the bus; the streams are never added to one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stream {
    /// Host to device, by [`Queue::write`](super::Queue::write) and its kin.
    Upload,
    /// What draws pull from host-resident buffers.
    Fetch,
    /// Device to host, by [`Queue::read`](super::Queue::read).
    Readback,
}

impl Stream {
    /// The stream's name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Upload => "upload",
            Self::Fetch => "fetch",
            Self::Readback => "readback",
        }
    }
}

/// One transfer over the bus.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Transfer {
    /// The direction.
    pub stream: Stream,
    /// The label of the resource; of the first one, where a gathered write has several.
    pub resource: String,
    /// Why; the first region's, where a gathered write has several.
    pub cause: Cause,
    /// How many separate ranges it fills or reads.
    pub ranges: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
    /// Modelled: bytes on the wire.
    pub wire_bytes: u64,
    /// Modelled: time on the link.
    pub ticks: Ticks,
}

/// Sums over the transfers of one stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Traffic {
    /// How many transfers.
    pub transfers: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
    /// Modelled: bytes on the wire.
    pub wire_bytes: u64,
    /// Modelled: time on the link.
    pub ticks: Ticks,
}

impl Traffic {
    /// Adds what `other` counted.
    pub fn add(&mut self, other: &Self) {
        self.transfers += other.transfers;
        self.payload_bytes += other.payload_bytes;
        self.wire_bytes += other.wire_bytes;
        self.ticks += other.ticks;
    }
}

/// Transfers and payload of one cause or buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Share {
    /// How many transfers.
    pub transfers: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
}

/// Order-free counts of the rasterizer's work, under exact counters only.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WorkCounts {
    /// Samples inside triangles.
    pub covered: u64,
    /// Of those, samples whose pixel failed the alpha test.
    pub alpha_killed: u64,
    /// Covered, kept by the alpha test, and not visible at the end.
    pub hidden: u64,
    /// Texels read.
    pub texels: u64,
}

/// What compute passes did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ComputeCounts {
    /// Dispatches.
    pub dispatches: u64,
    /// Groups that ran.
    pub groups: u64,
    /// Bytes that groups read and wrote in device memory.
    pub bytes: u64,
}

impl ComputeCounts {
    /// Adds what others did.
    pub fn add(&mut self, other: &Self) {
        self.dispatches += other.dispatches;
        self.groups += other.groups;
        self.bytes += other.bytes;
    }
}

/// Everything counted between two calls of
/// [`Device::take_ledger`](super::Device::take_ledger).
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Ledger {
    /// Host to device.
    pub upload: Traffic,
    /// Pulled by draws from host memory.
    pub fetch: Traffic,
    /// Device to host.
    pub readback: Traffic,
    /// Bytes of the command stream, by the table in [`gpu`](super).
    pub command_bytes: u64,
    /// Draws executed, each record of an indirect one counted.
    pub draws: u64,
    /// Those of them without a corner, such as what the device culled.
    pub empty_draws: u64,
    /// Vertices submitted.
    pub vertices: u64,
    /// Primitives submitted: triangles, quads or lines.
    pub primitives: u64,
    /// Samples that show something drawn by these passes.
    pub visible_samples: u64,
    /// What compute passes did: the same for any number of threads.
    pub compute: ComputeCounts,
    /// Device memory in use when the ledger was taken.
    pub resident_bytes: u64,
    /// The most device memory in use so far.
    pub peak_bytes: u64,
    /// Shares of all streams by kind of cause.
    #[serde(deserialize_with = "by_cause")]
    pub by_cause: BTreeMap<&'static str, Share>,
    /// Shares of all streams by label.
    pub by_buffer: BTreeMap<String, Share>,
    /// Under exact counters: the rasterizer's work.
    pub work: Option<WorkCounts>,
    /// Under exact counters: modelled time on the card.
    pub gpu_ticks: Option<Ticks>,
    /// Every transfer, in order.
    pub transfers: Vec<Transfer>,
}

impl Ledger {
    /// The modelled time of what was drawn: uploads, fetches, then the card; `None` where the card's was not
    /// modelled. What was read back comes on top.
    #[must_use]
    pub fn frame_ticks(&self) -> Option<Ticks> {
        Some(self.upload.ticks + self.fetch.ticks + self.gpu_ticks?)
    }

    /// The sums of one stream.
    #[must_use]
    pub fn stream(&self, stream: Stream) -> &Traffic {
        match stream {
            Stream::Upload => &self.upload,
            Stream::Fetch => &self.fetch,
            Stream::Readback => &self.readback,
        }
    }

    pub(super) fn stream_mut(&mut self, stream: Stream) -> &mut Traffic {
        match stream {
            Stream::Upload => &mut self.upload,
            Stream::Fetch => &mut self.fetch,
            Stream::Readback => &mut self.readback,
        }
    }

    /// Adds what `other` counted; its transfers are left out, memory figures are the greater ones.
    pub fn add(&mut self, other: &Self) {
        self.upload.add(&other.upload);
        self.fetch.add(&other.fetch);
        self.readback.add(&other.readback);
        self.command_bytes += other.command_bytes;
        self.draws += other.draws;
        self.empty_draws += other.empty_draws;
        self.vertices += other.vertices;
        self.primitives += other.primitives;
        self.visible_samples += other.visible_samples;
        self.compute.add(&other.compute);
        self.resident_bytes = self.resident_bytes.max(other.resident_bytes);
        self.peak_bytes = self.peak_bytes.max(other.peak_bytes);
        for (cause, share) in &other.by_cause {
            add_share(self.by_cause.entry(cause).or_default(), *share);
        }
        for (label, share) in &other.by_buffer {
            add_share(self.by_buffer.entry(label.clone()).or_default(), *share);
        }
        if let Some(other) = other.work {
            let work = self.work.get_or_insert_default();
            work.covered += other.covered;
            work.alpha_killed += other.alpha_killed;
            work.hidden += other.hidden;
            work.texels += other.texels;
        }
        if let Some(ticks) = other.gpu_ticks {
            *self.gpu_ticks.get_or_insert_default() += ticks;
        }
    }
}

fn add_share(sum: &mut Share, share: Share) {
    sum.transfers += share.transfers;
    sum.payload_bytes += share.payload_bytes;
}

/// Kinds of causes that were read from files. They live as long as the program, so few are let in.
static KINDS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());

impl<'de> Deserialize<'de> for Cause {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Read {
            kind: String,
            id: Option<u32>,
        }
        let Read { kind, id } = Read::deserialize(from)?;
        let kind = known_kind(&kind).map_err(serde::de::Error::custom)?;
        Ok(Self { kind, id })
    }
}

fn by_cause<'de, D: Deserializer<'de>>(from: D) -> Result<BTreeMap<&'static str, Share>, D::Error> {
    let shares = BTreeMap::<String, Share>::deserialize(from)?;
    let known = |(kind, share): (String, Share)| Ok((known_kind(&kind)?, share));
    let shares: Result<_, String> = shares.into_iter().map(known).collect();
    shares.map_err(serde::de::Error::custom)
}

fn known_kind(text: &str) -> Result<&'static str, String> {
    let mut kinds = KINDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(kind) = kinds.iter().find(|kind| **kind == text) {
        return Ok(kind);
    }
    let (most, longest) = (limits::READ_CAUSES, limits::READ_CAUSE_BYTES);
    if kinds.len() >= most || text.len() > longest {
        return Err(format!(
            "cause of {} bytes, {} others known: at most {most} of at most {longest} bytes",
            text.len(),
            kinds.len()
        ));
    }
    let kind: &'static str = String::leak(text.to_owned());
    kinds.push(kind);
    Ok(kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_reads_back_equal() {
        let transfer = Transfer {
            stream: Stream::Fetch,
            resource: "leaf \"records\"".to_owned(),
            cause: Cause::numbered("slot", 7),
            ranges: 2,
            payload_bytes: u64::MAX,
            wire_bytes: 40,
            ticks: 1 << 60,
        };
        let share = Share {
            transfers: 1,
            payload_bytes: 32,
        };
        let ledger = Ledger {
            by_cause: [("slot", share)].into(),
            by_buffer: [("records".to_owned(), share)].into(),
            work: Some(WorkCounts::default()),
            gpu_ticks: Some(3),
            transfers: vec![transfer],
            ..Ledger::default()
        };
        let text = serde_json::to_string(&ledger).unwrap();
        assert_eq!(serde_json::from_str::<Ledger>(&text).unwrap(), ledger);
    }

    #[test]
    fn long_kinds_are_refused() {
        let long = format!("{{\"kind\":\"{}\",\"id\":null}}", "x".repeat(65));
        let error = serde_json::from_str::<Cause>(&long).unwrap_err();
        assert!(error.to_string().contains("of at most 64 bytes"), "{error}");
    }
}
