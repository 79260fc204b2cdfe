//! How detail follows the camera along a path: what switches, what switches back, what a metre costs.

use serde::{Deserialize, Serialize};

use super::rows::FrameRow;
use crate::math::Vec3;
use crate::models::TreeState;
use crate::report::{decimal, grouped};
use crate::run::Frame;

/// Detail along the frames of a run, each against the one before it; `path` in `ledger.json`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PathEntry {
    /// How far the camera went, in millimetres, rounded at the end.
    pub travelled_mm: u64,
    /// How often an instance's state was another than in the frame before.
    pub switches: u64,
    /// How many of these went back to the state that the instance had left at most
    /// [`PING_PONG_FRAMES`] frames earlier.
    pub ping_pongs: u64,
    /// Payload of uploads, but for the view's.
    pub changes_bytes: u64,
}

/// Within so many frames a detail that comes back was not worth leaving.
pub const PING_PONG_FRAMES: u32 = 8;

impl PathEntry {
    /// What it says, as a sentence.
    #[must_use]
    pub fn note(&self) -> String {
        let metres = self.travelled_mm as f64 / 1000.0;
        let each = match self.travelled_mm {
            0 => String::new(),
            _ => {
                let each = decimal(self.changes_bytes as f64 / metres, 1);
                format!("; changes of detail sent {each} B a metre")
            }
        };
        format!(
            "Along the path of {} m: {} switches of detail, {} of them ping-pongs (back within \
             {PING_PONG_FRAMES} frames){each}.",
            decimal(metres, 1),
            grouped(self.switches, ","),
            grouped(self.ping_pongs, ","),
        )
    }
}

/// Adds up a path frame by frame.
#[derive(Debug, Default)]
pub(super) struct PathSum {
    frames: u64,
    eye: Vec3,
    metres: f64,
    trees: Vec<Trail>,
    entry: PathEntry,
}

/// The states of one instance, as far back as matters.
#[derive(Debug)]
struct Trail {
    now: TreeState,
    /// The state before, and the last frame that showed it.
    before: Option<(TreeState, u32)>,
    /// The last frame that was added.
    frame: u32,
}

impl PathSum {
    /// Adds the next frame, of which `row` tells what it cost.
    pub(super) fn add(&mut self, frame: &Frame, row: &FrameRow) {
        if self.frames > 0 {
            let way = (frame.eye - self.eye).as_dvec3();
            self.metres += way.length();
            self.entry.changes_bytes += row.changes.payload_bytes;
        }
        self.frames += 1;
        self.eye = frame.eye;
        for (number, state) in frame.states.iter().enumerate() {
            match self.trees.get_mut(number) {
                Some(trail) => trail.add(state, frame.frame, &mut self.entry),
                None => self.trees.push(Trail {
                    now: state.clone(),
                    before: None,
                    frame: frame.frame,
                }),
            }
        }
    }

    /// The sums; `None` where there is no frame after another.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a length becomes whole millimetres by the language's saturating cast"
    )]
    pub(super) fn entry(&self) -> Option<PathEntry> {
        let travelled_mm = (self.metres * 1000.0).round() as u64;
        (self.frames > 1).then_some(PathEntry {
            travelled_mm,
            ..self.entry
        })
    }
}

impl Trail {
    fn add(&mut self, state: &TreeState, frame: u32, entry: &mut PathEntry) {
        if *state != self.now {
            entry.switches += 1;
            let back = self.before.as_ref().is_some_and(|(before, left)| {
                before == state && frame.saturating_sub(*left) <= PING_PONG_FRAMES
            });
            entry.ping_pongs += u64::from(back);
            let left = std::mem::replace(&mut self.now, state.clone());
            self.before = Some((left, self.frame));
        }
        self.frame = frame;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Traffic;
    use crate::models::State;

    fn frame(number: u32, x: f32, levels: [u32; 2]) -> Frame {
        Frame {
            frame: number,
            eye: Vec3::new(x, 2.0, 0.0),
            states: levels
                .map(|collapses| State::Uniform { collapses }.into())
                .to_vec(),
            ..Frame::blank()
        }
    }

    #[test]
    fn switches_and_those_back_are_counted() {
        let row = FrameRow {
            changes: Traffic {
                payload_bytes: 100,
                ..Traffic::default()
            },
            ..FrameRow::default()
        };
        let mut sum = PathSum::default();
        // The first tree: 0 1 0 0 2 0, where the last return comes ten frames after leaving. The
        // second: 5 6 7 5 5 5, which is no way back to where it was just before.
        let levels = [[0, 5], [1, 6], [0, 7], [0, 5], [2, 5], [0, 5]];
        let numbers = [0, 1, 2, 3, 4, 13];
        for (step, (number, levels)) in numbers.into_iter().zip(levels).enumerate() {
            if step == 1 {
                assert_eq!(sum.entry(), None, "one frame is no path");
            }
            sum.add(&frame(number, 0.5 * step as f32, levels), &row);
        }
        let found = sum.entry().unwrap();
        let wanted = PathEntry {
            travelled_mm: 2500,
            switches: 7,
            ping_pongs: 1,
            changes_bytes: 500,
        };
        assert_eq!(found, wanted);
        assert_eq!(
            found.note(),
            "Along the path of 2.5 m: 7 switches of detail, 1 of them ping-pongs (back within 8 \
             frames); changes of detail sent 200 B a metre."
        );
    }
}
