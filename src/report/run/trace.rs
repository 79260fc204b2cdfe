//! `trace.json`: a run as a timeline, in the format of Chrome's tracing; opens in Perfetto.
//!
//! ```text
//! frames   │ initial ││      frame 0      ││ frame 1 …
//! upload   │ vertices││ slot │view│       ││
//! fetch                        │  draw  │
//! GPU                                   │ draw │
//! ```
//!
//! Times are modelled: within a frame uploads come first, then fetches, then the card; nothing
//! overlaps. Each frame begins at a whole nanosecond, and times within it depend on that frame
//! alone. Transfers that follow one another for the same cause into the same buffer are one event;
//! `ledger.csv` has each.

use std::collections::BTreeMap;

use serde::Serialize;

use super::RunHeader;
use super::ledger::json;
use super::rows::FrameRow;
use crate::gpu::{Ledger, Stream, TICKS_PER_NANOSECOND, Ticks, nanoseconds};

/// Writes the events of a run, frame after frame.
#[derive(Debug)]
pub(super) struct Trace {
    /// Nanoseconds at which the next frame begins.
    now: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
enum Lane {
    Frames = 1,
    Upload = 2,
    Fetch = 3,
    Readback = 4,
    Gpu = 5,
}

impl Lane {
    const ALL: [(Self, &str); 5] = [
        (Self::Frames, "frames"),
        (Self::Upload, "bus: upload"),
        (Self::Fetch, "bus: fetch"),
        (Self::Readback, "bus: readback"),
        (Self::Gpu, "GPU"),
    ];
}

/// One event; fields in the order of the file.
#[derive(Serialize)]
struct Event<'a, T> {
    name: &'a str,
    ph: &'a str,
    pid: u32,
    tid: u32,
    /// Microseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    ts: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dur: Option<f64>,
    args: T,
}

/// What is said beside the timeline.
#[derive(Serialize)]
struct OtherData<'a> {
    scene: &'a str,
    model: &'a str,
    link: &'a str,
    card: &'a str,
    times: &'a str,
    resident_bytes: BTreeMap<&'a str, u64>,
}

#[derive(Serialize)]
struct Name<'a> {
    name: &'a str,
}

#[derive(Serialize)]
struct Moved<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    resource: Option<&'a str>,
    transfers: u64,
    ranges: u64,
    payload_bytes: u64,
    wire_bytes: u64,
}

impl Trace {
    /// The beginning of the file: names, then what is sent before the first frame.
    pub(super) fn opening(header: &RunHeader, initial: &Ledger) -> (Self, String) {
        let other = OtherData {
            scene: &header.scene,
            model: &header.model,
            link: header.link.name(),
            card: header.card.name(),
            times: "modelled",
            resident_bytes: header
                .resident
                .iter()
                .map(|(l, bytes)| (l.as_str(), *bytes))
                .collect(),
        };
        let mut text = format!(
            "{{\"displayTimeUnit\":\"ns\",\"otherData\":{},\"traceEvents\":[\n",
            json(&other)
        );
        let meta = |kind, tid, name| {
            json(&Event {
                name: kind,
                ph: "M",
                pid: 1,
                tid,
                ts: None,
                dur: None,
                args: Name { name },
            })
        };
        text += &meta("process_name", 0, &header.scene);
        for (lane, name) in Lane::ALL {
            text += ",\n";
            text += &meta("thread_name", lane as u32, name);
        }
        let mut trace = Self { now: 0 };
        text += &trace.span("initial uploads", initial);
        (trace, text)
    }

    /// The events of a frame.
    pub(super) fn frame(&mut self, row: &FrameRow, ledger: &Ledger) -> String {
        let counters = [
            self.counter("leaves", &[("leaves", row.leaves)]),
            self.counter(
                "bytes",
                &[
                    ("changes", row.changes.payload_bytes),
                    ("view", row.view.payload_bytes),
                    ("fetched", row.fetch.payload_bytes),
                ],
            ),
        ];
        counters.concat() + &self.span(&format!("frame {}", row.frame), ledger)
    }

    /// The end of the file.
    pub(super) fn closing() -> &'static str {
        "\n]}\n"
    }

    /// Everything between two frames, in all lanes.
    fn span(&mut self, name: &str, ledger: &Ledger) -> String {
        let mut text = String::new();
        let mut ticks = 0;
        for (lane, stream) in [(Lane::Upload, Stream::Upload), (Lane::Fetch, Stream::Fetch)] {
            text += &self.stream(lane, stream, ledger, &mut ticks);
        }
        if let Some(gpu) = ledger.gpu_ticks {
            text += &self.event(Lane::Gpu, "draw", ticks..ticks + gpu, Name { name });
            ticks += gpu;
        }
        text += &self.stream(Lane::Readback, Stream::Readback, ledger, &mut ticks);
        // The frame ends at a whole nanosecond, at or after all that it holds.
        let end = nanoseconds(ticks);
        let whole = 0..end * TICKS_PER_NANOSECOND;
        let frame = self.event(Lane::Frames, name, whole, Name { name });
        self.now += end;
        frame + &text
    }

    /// The transfers of one stream, one after another, within an event that spans them.
    fn stream(&self, lane: Lane, stream: Stream, ledger: &Ledger, ticks: &mut Ticks) -> String {
        let start = *ticks;
        let mut text = String::new();
        let mut all = Moved {
            resource: None,
            transfers: 0,
            ranges: 0,
            payload_bytes: 0,
            wire_bytes: 0,
        };
        let transfers: Vec<_> = ledger
            .transfers
            .iter()
            .filter(|t| t.stream == stream)
            .collect();
        let runs =
            transfers.chunk_by(|a, b| (a.cause.kind, &a.resource) == (b.cause.kind, &b.resource));
        for run in runs {
            let Some(first) = run.first() else { continue };
            let moved = Moved {
                resource: Some(&first.resource),
                transfers: run.len() as u64,
                ranges: run.iter().map(|transfer| transfer.ranges).sum(),
                payload_bytes: run.iter().map(|transfer| transfer.payload_bytes).sum(),
                wire_bytes: run.iter().map(|transfer| transfer.wire_bytes).sum(),
            };
            all.transfers += moved.transfers;
            all.ranges += moved.ranges;
            all.payload_bytes += moved.payload_bytes;
            all.wire_bytes += moved.wire_bytes;
            let end = *ticks + run.iter().map(|transfer| transfer.ticks).sum::<Ticks>();
            text += &self.event(lane, first.cause.kind, *ticks..end, moved);
            *ticks = end;
        }
        match all.transfers {
            0 => text,
            _ => self.event(lane, stream.name(), start..*ticks, all) + &text,
        }
    }

    /// An event at ticks since the frame's begin, both ends rounded down: so what touches or holds
    /// another still does.
    fn event(
        &self,
        lane: Lane,
        name: &str,
        at: std::ops::Range<Ticks>,
        args: impl Serialize,
    ) -> String {
        let (start, end) = (
            at.start / TICKS_PER_NANOSECOND,
            at.end / TICKS_PER_NANOSECOND,
        );
        let event = Event {
            name,
            ph: "X",
            pid: 1,
            tid: lane as u32,
            ts: Some(microseconds(self.now + start)),
            dur: Some(microseconds(end - start)),
            args,
        };
        format!(",\n{}", json(&event))
    }

    fn counter(&self, name: &str, values: &[(&str, u64)]) -> String {
        let args: BTreeMap<&str, u64> = values.iter().copied().collect();
        let event = Event {
            name,
            ph: "C",
            pid: 1,
            tid: 0,
            ts: Some(microseconds(self.now)),
            dur: None,
            args,
        };
        format!(",\n{}", json(&event))
    }
}

/// The nearest number of microseconds: exact to the nanosecond up to 100 days.
fn microseconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1000.0
}
