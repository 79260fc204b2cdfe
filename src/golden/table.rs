//! The ledger of a frame as a table in plain text: `NAME-FRAME.txt`.
//!
//! Numbers are whole and written without separators, a fact a line, so that a difference of two
//! tables reads as what became more or less.

use std::fmt::Write as _;

use crate::gpu::{Ledger, Share, Stream, Traffic, nanoseconds};
use crate::math::{Digest, Digester};
use crate::run::Frame;
use crate::scene::{ImageSize, SampleCount};

/// What a table tells beside its frame.
#[derive(Debug)]
pub(super) struct Context {
    /// Pixels of the frame.
    pub(super) size: ImageSize,
    /// Samples a pixel.
    pub(super) samples: SampleCount,
    /// What was sent before the first frame.
    pub(super) initial: Ledger,
}

/// The table of a frame.
pub(super) fn table(frame: &Frame, context: &Context) -> String {
    let ledger = &frame.ledger;
    let (width, height) = (context.size.width(), context.size.height());
    let mut text = format!(
        "frame             {:>10}  {width} x {height}, samples {}\npicture           {}\ntransfers         {}\n",
        frame.frame,
        context.samples.get(),
        frame.image_digest,
        transfers_digest(ledger),
    );
    let change = &frame.change;
    for (name, count) in [
        ("leaves", frame.leaves),
        ("triangles", frame.triangles),
        ("collapses", change.collapses.into()),
        ("splits", change.splits.into()),
        ("clusters touched", change.clusters_touched.into()),
        ("host records", change.host_records),
        ("draws", ledger.draws),
        ("vertices", ledger.vertices),
        ("primitives", ledger.primitives),
        ("visible samples", ledger.visible_samples),
        ("command bytes", ledger.command_bytes),
        ("resident bytes", ledger.resident_bytes),
        ("peak bytes", ledger.peak_bytes),
    ] {
        line(&mut text, name, &[count]);
    }
    let compute = ledger.compute;
    if compute.dispatches > 0 {
        for (name, count) in [
            ("dispatches", compute.dispatches),
            ("compute groups", compute.groups),
            ("compute bytes", compute.bytes),
            ("empty draws", ledger.empty_draws),
        ] {
            line(&mut text, name, &[count]);
        }
    }
    if let (Some(work), Some(ticks)) = (ledger.work, ledger.gpu_ticks) {
        for (name, count) in [
            ("covered samples", work.covered),
            ("alpha killed", work.alpha_killed),
            ("hidden samples", work.hidden),
            ("texels", work.texels),
            ("gpu ns", nanoseconds(ticks)),
        ] {
            line(&mut text, name, &[count]);
        }
    }
    text += "\nstream            transfers     payload        wire      bus ns\n";
    line(&mut text, "initial upload", &sums(&context.initial.upload));
    for stream in [Stream::Upload, Stream::Fetch, Stream::Readback] {
        line(&mut text, stream.name(), &sums(ledger.stream(stream)));
    }
    let causes = ledger.by_cause.iter().map(|(name, share)| (*name, share));
    shares(&mut text, "cause", causes);
    let buffers = ledger.by_buffer.iter();
    shares(
        &mut text,
        "buffer",
        buffers.map(|(name, share)| (name.as_str(), share)),
    );
    text
}

fn shares<'a>(text: &mut String, what: &str, shares: impl Iterator<Item = (&'a str, &'a Share)>) {
    _ = writeln!(text, "\n{what:16}  transfers     payload");
    for (name, share) in shares {
        line(text, name, &[share.transfers, share.payload_bytes]);
    }
}

fn sums(traffic: &Traffic) -> [u64; 4] {
    [
        traffic.transfers,
        traffic.payload_bytes,
        traffic.wire_bytes,
        nanoseconds(traffic.ticks),
    ]
}

fn line(text: &mut String, name: &str, counts: &[u64]) {
    *text += &format!("{name:16}");
    for count in counts {
        *text += &format!("  {count:>10}");
    }
    text.push('\n');
}

/// The digest of every transfer in order: BLAKE3 over the domain `golden.transfers/1`, then stream,
/// resource, kind of cause as texts, its number (`u32::MAX` for none), and four `u64`: ranges,
/// payload, wire, ticks.
fn transfers_digest(ledger: &Ledger) -> Digest {
    let mut digester = Digester::new("golden.transfers/1");
    for transfer in &ledger.transfers {
        digester
            .text(transfer.stream.name())
            .text(&transfer.resource)
            .text(transfer.cause.kind)
            .u32(transfer.cause.id.unwrap_or(u32::MAX))
            .u64(transfer.ranges)
            .u64(transfer.payload_bytes)
            .u64(transfer.wire_bytes)
            .u64(transfer.ticks);
    }
    digester.finish()
}
