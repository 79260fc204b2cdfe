//! What was found, for programs.
//!
//! ```text
//! { "schema": "spinney.diff/1", "kind": "images", "expected", "actual", "tolerance", "same",
//!   "look": null | LOOK,
//!   "channels": null | [ { "name", "kinds": [K, K], "windows": [[x, y, w, h], …], "samples",
//!       "differing", "bits_only", "not_finite", "largest", "largest_at": null | [x, y] } ],
//!   "only_expected": [ CHANNEL ], "only_actual": [ CHANNEL ] }
//!
//! { "schema": "spinney.diff/1", "kind": "runs", "expected", "actual", "tolerance", "same",
//!   "head": [ FIELD ], "compared", "only_expected": [ FRAME ], "only_actual": [ FRAME ],
//!   "frames": [ { "frame", "look": null | LOOK, "ledger": [ FIELD ] } ],
//!   "initial": [ FIELD ], "totals": [ FIELD ],
//!   "equal_files", "files": [ { "name", "state": "differs" | "only_expected" | "only_actual",
//!                               "detail": [ WORDS ] } ] }
//!
//! LOOK  = { "sizes": [[w, h], [w, h]], "metrics": null | { "pixels", "differing", "unequal",
//!     "largest", "largest_at": [x, y], "bounds": null | [left, top, right, bottom], "mean",
//!     "mean_square", "psnr_db": null for equal pictures, "ssim": null below 11 × 11 pixels,
//!     "flip": { "mean", "largest", "largest_at": [x, y] } } }
//! FIELD = { "name", "expected": null | value, "actual": null | value }
//! ```
//!
//! `expected` and `actual` are the paths as they were given. Lists of what differs hold all of it.

use serde_json::{Value, json};

use super::difference::size;
use super::{
    ChannelDifference, FieldDifference, FileDifference, FileState, FrameDifference,
    ImageDifference, Metrics, RunDifference, SizeMismatch,
};
use crate::report::SampleKind;

/// The value of `schema` in the JSON of a comparison.
pub const DIFF_SCHEMA: &str = "spinney.diff/1";

impl ImageDifference {
    /// What was found, as JSON; `names` are those of the files: expected, actual.
    #[must_use]
    pub fn to_json(&self, names: [&str; 2], tolerance: u8) -> String {
        let look = self.look.as_ref().map(|look| {
            let sizes = [&look.pictures[0], &look.pictures[1]].map(size);
            look_json(sizes, look.found.as_ref().ok())
        });
        let channels = self.channels.as_ref();
        let [only_expected, only_actual] = match channels {
            Some(channels) => [&channels.only_expected[..], &channels.only_actual[..]],
            None => [&[][..], &[]],
        };
        let value = json!({
            "schema": DIFF_SCHEMA,
            "kind": "images",
            "expected": names[0],
            "actual": names[1],
            "tolerance": tolerance,
            "same": self.is_within(),
            "look": look,
            "channels": channels.map(|channels| {
                channels.both.iter().map(channel_json).collect::<Vec<Value>>()
            }),
            "only_expected": only_expected,
            "only_actual": only_actual,
        });
        format!("{value:#}\n")
    }
}

impl RunDifference {
    /// What was found, as JSON; `names` are those of the folders: expected, actual.
    #[must_use]
    pub fn to_json(&self, names: [&str; 2], tolerance: u8) -> String {
        let value = json!({
            "schema": DIFF_SCHEMA,
            "kind": "runs",
            "expected": names[0],
            "actual": names[1],
            "tolerance": tolerance,
            "same": self.is_within(),
            "head": fields_json(&self.head),
            "compared": self.compared,
            "only_expected": self.only_expected,
            "only_actual": self.only_actual,
            "frames": self.frames.iter().map(frame_json).collect::<Vec<Value>>(),
            "initial": fields_json(&self.initial),
            "totals": fields_json(&self.totals),
            "equal_files": self.equal_files,
            "files": self.files.iter().map(file_json).collect::<Vec<Value>>(),
        });
        format!("{value:#}\n")
    }
}

fn look_json(sizes: [[u32; 2]; 2], metrics: Option<&Metrics>) -> Value {
    let metrics = metrics.map(|metrics| {
        let (found, flip) = (&metrics.difference, &metrics.flip);
        json!({
            "pixels": found.total(),
            "differing": found.pixels,
            "unequal": found.unequal,
            "largest": found.largest,
            "largest_at": found.largest_at,
            "bounds": found.bounds,
            "mean": found.mean,
            "mean_square": found.mean_square,
            // Infinity has no JSON.
            "psnr_db": Some(found.psnr()).filter(|psnr| psnr.is_finite()),
            "ssim": metrics.ssim,
            "flip": {
                "mean": flip.mean,
                "largest": flip.largest,
                "largest_at": flip.largest_at,
            },
        })
    });
    json!({ "sizes": sizes, "metrics": metrics })
}

fn channel_json(channel: &ChannelDifference) -> Value {
    json!({
        "name": channel.name,
        "kinds": channel.kinds.map(SampleKind::name),
        "windows": channel.windows,
        "samples": channel.samples,
        "differing": channel.differing,
        "bits_only": channel.bits_only,
        "not_finite": channel.not_finite,
        "largest": channel.largest,
        "largest_at": channel.largest_at,
    })
}

fn frame_json(frame: &FrameDifference) -> Value {
    let look = frame.look.as_ref().map(|look| match look {
        Ok(metrics) => look_json([metrics.difference.size; 2], Some(metrics)),
        Err(SizeMismatch { expected, actual }) => look_json([*expected, *actual], None),
    });
    json!({
        "frame": frame.frame,
        "look": look,
        "ledger": fields_json(&frame.ledger),
    })
}

fn fields_json(fields: &[FieldDifference]) -> Vec<Value> {
    let field = |field: &FieldDifference| {
        json!({
            "name": field.name,
            "expected": field.expected,
            "actual": field.actual,
        })
    };
    fields.iter().map(field).collect()
}

fn file_json(file: &FileDifference) -> Value {
    let state = match file.state {
        FileState::Differs => "differs",
        FileState::OnlyExpected => "only_expected",
        FileState::OnlyActual => "only_actual",
    };
    json!({ "name": file.name, "state": state, "detail": file.detail })
}
