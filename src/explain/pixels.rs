//! The pixels that two runs do not share.

use serde::Serialize;

use super::{ExplainError, RecordedRun};
use crate::report::{Difference, Picture};

/// A frame whose pictures differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FramePixels {
    /// Its number.
    pub frame: u32,
    /// Columns and rows of A's picture and of B's.
    pub sizes: [[u32; 2]; 2],
    /// Pixels that differ; `None` where sizes do.
    pub pixels: Option<u64>,
    /// Left, top, right, bottom of those, inclusive.
    pub bounds: Option<[u32; 4]>,
    /// The largest difference of a channel, of 255.
    pub largest: Option<u8>,
}

/// Compares the pictures of the frames that both runs have and whose digests differ.
pub(super) fn frame_pixels(
    a: &RecordedRun,
    b: &RecordedRun,
) -> Result<Vec<FramePixels>, ExplainError> {
    let mut frames = Vec::new();
    for entry in &a.ledger().frames {
        let mut others = b.ledger().frames.iter();
        let Some(other) = others.find(|other| other.frame == entry.frame) else {
            continue;
        };
        if entry.image_digest == other.image_digest {
            continue;
        }
        let frame = entry.frame.unwrap_or(0);
        let [one, other] = [picture(a, frame)?, picture(b, frame)?];
        let difference = Difference::between(&one, &other, 0).ok();
        frames.push(FramePixels {
            frame,
            sizes: [&one, &other].map(|picture| [picture.width(), picture.height()]),
            pixels: difference.map(|found| found.pixels),
            bounds: difference.and_then(|found| found.bounds),
            largest: difference.map(|found| found.largest),
        });
    }
    Ok(frames)
}

fn picture(run: &RecordedRun, frame: u32) -> Result<Picture, ExplainError> {
    let path = run.folder().join(format!("frame-{frame:04}.png"));
    Picture::read(&path).map_err(|source| ExplainError::Report {
        folder: run.folder().to_owned(),
        source,
    })
}
