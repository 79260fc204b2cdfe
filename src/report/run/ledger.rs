//! `ledger.json`: what every frame of a run moved and drew.
//!
//! ```text
//! { "schema", "version", "scene", …, "frames": [ ⟨one frame a line⟩ ], "initial": …, "totals": … }
//! ```
//!
//! Counts are exact. Times are modelled, in nanoseconds, rounded up where an entry is made; so the
//! totals are the sums of what the file says of its frames, and shards can be joined exactly.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{PathEntry, RunHeader};
use crate::gpu::{Ledger, Share, Ticks, Traffic, nanoseconds};
use crate::models::{CardLevel, State};
use crate::run::{Frame, Popping};

/// The value of `schema` in `ledger.json`.
pub const LEDGER_SCHEMA: &str = "spinney.ledger/1";

/// The whole file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunLedger {
    /// What was run.
    #[serde(flatten)]
    pub head: LedgerHead,
    /// The frames, ascending.
    pub frames: Vec<LedgerEntry>,
    /// What was sent before the first frame.
    pub initial: LedgerEntry,
    /// Sums over the frames; of memory figures the greatest.
    pub totals: LedgerEntry,
    /// Detail along the frames, where there are several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<PathEntry>,
}

/// What was run, and by what it is modelled.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedgerHead {
    /// [`LEDGER_SCHEMA`].
    pub schema: String,
    /// The version of spinney.
    pub version: String,
    /// The scene's name.
    pub scene: String,
    /// The scene's digest, in hexadecimal digits.
    pub scene_digest: String,
    /// The link by which wire bytes and bus times are modelled.
    pub link: String,
    /// The card by which GPU times are modelled.
    pub card: String,
    /// Pixels of a frame: width, height.
    pub size: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
}

/// A frame, or a sum.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct LedgerEntry {
    /// The frame's number; sums have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// The picture's digest, in hexadecimal digits; sums have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image_digest: Option<String>,
    /// Leaves drawn.
    pub leaves: u64,
    /// Triangles drawn: two a leaf, and the trunks'.
    pub triangles: u64,
    /// Lines drawn.
    pub lines: u64,
    /// Strokes drawn.
    pub strokes: u64,
    /// How many instances show which level: `uniform:C` after the first `C` collapses, `variable`
    /// where every cluster has its own number, `strokes:R:S` where strokes are of row `R` up to shell `S`.
    /// Sums have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub levels: Option<BTreeMap<String, u64>>,
    /// Draws executed.
    pub draws: u64,
    /// Vertices submitted.
    pub vertices: u64,
    /// Primitives submitted.
    pub primitives: u64,
    /// Samples that show something drawn.
    pub visible_samples: u64,
    /// Device memory in use.
    pub resident_bytes: u64,
    /// The most device memory in use so far.
    pub peak_bytes: u64,
    /// Host to device.
    pub upload: TrafficEntry,
    /// Pulled by draws from host memory.
    pub fetch: TrafficEntry,
    /// Device to host.
    pub readback: TrafficEntry,
    /// Bytes of the command stream.
    pub command_bytes: u64,
    /// Collapses done.
    pub collapses: u64,
    /// Splits done.
    pub splits: u64,
    /// Clusters whose detail changed.
    pub clusters_touched: u64,
    /// With a budget of bytes a frame: clusters, or trees that change as a whole, that it held back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deferred: Option<u64>,
    /// Shares of all streams by kind of cause.
    pub by_cause: BTreeMap<String, ShareEntry>,
    /// Shares of all streams by label.
    pub by_buffer: BTreeMap<String, ShareEntry>,
    /// What compute passes did, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compute: Option<ComputeEntry>,
    /// Under exact counters: the rasterizer's work, in samples and texels.
    pub work: Option<WorkEntry>,
    /// Under exact counters: modelled time on the card.
    pub gpu_ns: Option<u64>,
    /// With `--popping`: what switches of detail alone show; none for the first frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub popping: Option<Popping>,
}

/// What crossed the bus in one stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TrafficEntry {
    /// Transfers.
    pub transfers: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
    /// Modelled: bytes on the wire.
    pub wire_bytes: u64,
    /// Modelled: time on the link.
    pub bus_ns: u64,
}

/// What one cause or buffer had of all streams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ShareEntry {
    /// Transfers.
    pub transfers: u64,
    /// Bytes asked for.
    pub payload_bytes: u64,
}

/// What compute passes did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ComputeEntry {
    /// Dispatches.
    pub dispatches: u64,
    /// Groups that ran.
    pub groups: u64,
    /// Bytes that groups read and wrote in device memory.
    pub bytes: u64,
    /// Draws that they left without a corner: what was culled.
    pub empty_draws: u64,
}

/// What the rasterizer did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct WorkEntry {
    /// Samples inside triangles.
    pub covered: u64,
    /// Of those, samples whose pixel failed the alpha test.
    pub alpha_killed: u64,
    /// Covered, kept by the alpha test, and not visible at the end.
    pub hidden: u64,
    /// Texels read.
    pub texels: u64,
}

impl LedgerHead {
    /// The head for a run.
    pub(super) fn of(header: &RunHeader) -> Self {
        Self {
            schema: LEDGER_SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: header.scene.clone(),
            scene_digest: header.scene_digest.to_string(),
            link: header.link.name().to_owned(),
            card: header.card.name().to_owned(),
            size: header.size,
            samples: header.samples,
        }
    }

    /// The beginning of the file, up to the first frame.
    pub(super) fn opening(&self) -> String {
        let head = json(self);
        let open = head.strip_suffix('}').unwrap_or(&head);
        format!("{open},\"frames\":[")
    }
}

/// The end of the file, after the last frame.
pub(super) fn closing(
    initial: &LedgerEntry,
    totals: &LedgerEntry,
    path: Option<&PathEntry>,
) -> String {
    let (initial, totals) = (json(initial), json(totals));
    let path = path.map_or(String::new(), |path| format!(",\n\"path\":{}", json(path)));
    format!("\n],\n\"initial\":{initial},\n\"totals\":{totals}{path}}}\n")
}

impl LedgerEntry {
    /// A frame's entry.
    #[must_use]
    pub fn of(frame: &Frame) -> Self {
        let mut levels = BTreeMap::new();
        for state in &frame.states {
            *levels.entry(level_name(&state.foliage)).or_default() += 1;
        }
        Self {
            frame: Some(frame.frame),
            image_digest: Some(frame.image_digest.to_string()),
            leaves: frame.leaves,
            lines: frame.lines,
            strokes: frame.strokes,
            triangles: frame.triangles,
            levels: Some(levels),
            collapses: u64::from(frame.change.collapses),
            splits: u64::from(frame.change.splits),
            clusters_touched: u64::from(frame.change.clusters_touched),
            deferred: frame.deferred,
            popping: frame.popping,
            ..Self::of_ledger(&frame.ledger)
        }
    }

    /// What a ledger counts; the rest is 0.
    #[must_use]
    pub fn of_ledger(ledger: &Ledger) -> Self {
        Self {
            draws: ledger.draws,
            vertices: ledger.vertices,
            primitives: ledger.primitives,
            visible_samples: ledger.visible_samples,
            resident_bytes: ledger.resident_bytes,
            peak_bytes: ledger.peak_bytes,
            upload: TrafficEntry::of(&ledger.upload),
            fetch: TrafficEntry::of(&ledger.fetch),
            readback: TrafficEntry::of(&ledger.readback),
            command_bytes: ledger.command_bytes,
            by_cause: shares(ledger.by_cause.iter().map(|(kind, share)| (*kind, share))),
            by_buffer: shares(
                ledger
                    .by_buffer
                    .iter()
                    .map(|(l, share)| (l.as_str(), share)),
            ),
            compute: (ledger.compute.dispatches > 0).then_some(ComputeEntry {
                dispatches: ledger.compute.dispatches,
                groups: ledger.compute.groups,
                bytes: ledger.compute.bytes,
                empty_draws: ledger.empty_draws,
            }),
            work: ledger.work.map(|work| WorkEntry {
                covered: work.covered,
                alpha_killed: work.alpha_killed,
                hidden: work.hidden,
                texels: work.texels,
            }),
            gpu_ns: ledger.gpu_ticks.map(nanoseconds),
            ..Self::default()
        }
    }

    /// Adds a frame to a sum.
    pub fn add(&mut self, frame: &Self) {
        self.leaves += frame.leaves;
        self.triangles += frame.triangles;
        self.lines += frame.lines;
        self.strokes += frame.strokes;
        self.draws += frame.draws;
        self.vertices += frame.vertices;
        self.primitives += frame.primitives;
        self.visible_samples += frame.visible_samples;
        self.resident_bytes = self.resident_bytes.max(frame.resident_bytes);
        self.peak_bytes = self.peak_bytes.max(frame.peak_bytes);
        self.upload.add(frame.upload);
        self.fetch.add(frame.fetch);
        self.readback.add(frame.readback);
        self.command_bytes += frame.command_bytes;
        self.collapses += frame.collapses;
        self.splits += frame.splits;
        self.clusters_touched += frame.clusters_touched;
        if let Some(deferred) = frame.deferred {
            *self.deferred.get_or_insert_default() += deferred;
        }
        add_shares(&mut self.by_cause, &frame.by_cause);
        add_shares(&mut self.by_buffer, &frame.by_buffer);
        if let Some(compute) = frame.compute {
            let sum = self.compute.get_or_insert_default();
            sum.dispatches += compute.dispatches;
            sum.groups += compute.groups;
            sum.bytes += compute.bytes;
            sum.empty_draws += compute.empty_draws;
        }
        if let Some(work) = frame.work {
            let sum = self.work.get_or_insert_default();
            sum.covered += work.covered;
            sum.alpha_killed += work.alpha_killed;
            sum.hidden += work.hidden;
            sum.texels += work.texels;
        }
        if let Some(time) = frame.gpu_ns {
            *self.gpu_ns.get_or_insert_default() += time;
        }
        if let Some(popping) = &frame.popping {
            self.popping.get_or_insert_default().add(popping);
        }
    }
}

impl TrafficEntry {
    /// The sums of a stream.
    #[must_use]
    pub fn of(traffic: &Traffic) -> Self {
        Self {
            transfers: traffic.transfers,
            payload_bytes: traffic.payload_bytes,
            wire_bytes: traffic.wire_bytes,
            bus_ns: nanoseconds(traffic.ticks),
        }
    }

    /// Adds another's.
    pub fn add(&mut self, other: Self) {
        self.transfers += other.transfers;
        self.payload_bytes += other.payload_bytes;
        self.wire_bytes += other.wire_bytes;
        self.bus_ns += other.bus_ns;
    }
}

/// A value as JSON on one line.
pub(in super::super) fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("keys are texts, values numbers and texts")
}

/// Modelled microseconds, for people.
pub(in super::super) fn microseconds(ticks: Ticks) -> f64 {
    nanoseconds(ticks) as f64 / 1000.0
}

fn level_name(state: &State) -> String {
    match state {
        State::Uniform { collapses } => format!("uniform:{collapses}"),
        State::Variable { .. } => "variable".to_owned(),
        State::Cards(CardLevel(level)) => format!("cards:{level}"),
        State::Strokes(cut) => format!("strokes:{}:{}", cut.row, cut.switch),
    }
}

fn shares<'a>(shares: impl Iterator<Item = (&'a str, &'a Share)>) -> BTreeMap<String, ShareEntry> {
    let entry = |(name, share): (&str, &Share)| {
        let entry = ShareEntry {
            transfers: share.transfers,
            payload_bytes: share.payload_bytes,
        };
        (name.to_owned(), entry)
    };
    shares.map(entry).collect()
}

fn add_shares(sum: &mut BTreeMap<String, ShareEntry>, shares: &BTreeMap<String, ShareEntry>) {
    for (name, share) in shares {
        let sum = sum.entry(name.clone()).or_default();
        sum.transfers += share.transfers;
        sum.payload_bytes += share.payload_bytes;
    }
}
