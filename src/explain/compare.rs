//! Where two runs part, from what was asked to the pixels.

use serde::Serialize;

use super::asked::{AskedDifference, PlantFileDifference, asked, plant_files};
use super::buffers::{BufferDifference, Reader, buffer_differences};
use super::leaves::{PlantDifference, match_leaves, plant_difference};
use super::operations::{OperationDifference, first_difference, operations, same_operations};
use super::pixels::{FramePixels, frame_pixels};
use super::replay::{RecordedRun, Replay, ReplayedFrame};
use super::sequences::{LeafNames, SequenceDifference, sequence_difference};
use super::trunks::{LevelDifference, TrunkDifference, level_difference, trunk_differences};
use super::{EXPLAIN_SCHEMA, ExplainError, bounded};
use crate::run::{Progress, World};

/// Where two runs part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunsReport {
    /// [`EXPLAIN_SCHEMA`].
    pub schema: &'static str,
    /// `runs`.
    pub kind: &'static str,
    /// Whether the runs are the same: asked, plants, states, transfers and pictures.
    pub same: bool,
    /// All of it in one sentence.
    pub summary: String,
    /// The one run.
    pub a: SideReport,
    /// The other.
    pub b: SideReport,
    /// How many keys differ in what was asked.
    pub asked_count: u64,
    /// The first of them.
    pub asked: Vec<AskedDifference>,
    /// The plants' files that differ.
    pub plant_files: Vec<PlantFileDifference>,
    /// The plants that differ, by the first tree that shows them.
    pub plants: Vec<PlantDifference>,
    /// The collapse sequences that differ.
    pub sequences: Vec<SequenceDifference>,
    /// The trunks that differ, in their mesh or in how it is simplified.
    pub trunks: Vec<TrunkDifference>,
    /// The first frame that shows a trunk at another level, or by a model without levels.
    pub levels: Option<LevelDifference>,
    /// The first lines that differ in the runs' own records.
    pub records: Vec<FirstDifference>,
    /// The first transfer that they do not share, as they are played again.
    pub operation: Option<OperationDifference>,
    /// How many buffers differ once the frame of that transfer is drawn.
    pub buffer_count: u64,
    /// The first of them, by owner and label.
    pub buffers: Vec<BufferDifference>,
    /// The frames whose pictures differ.
    pub frames: Vec<FramePixels>,
    /// How many frames both have.
    pub common_frames: u64,
}

/// One of two runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SideReport {
    /// The scene's name.
    pub scene: String,
    /// Model and mode in one word.
    pub model: String,
    /// The version of spinney that made it.
    pub version: String,
    /// Frames drawn.
    pub frames: u64,
    /// Bytes uploaded, before the first frame and with the frames.
    pub upload_bytes: u64,
    /// Bytes fetched by draws.
    pub fetch_bytes: u64,
    /// Frames that were drawn again here; they are the ledger's where they say so.
    pub replayed: Vec<ReplayedFrame>,
}

/// The first line that differs in a file that both runs have.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FirstDifference {
    /// The file.
    pub file: &'static str,
    /// The line, from 1.
    pub line: u64,
    /// A's line, at most 160 characters; `None` where A has no more.
    pub a: Option<String>,
    /// B's line.
    pub b: Option<String>,
}

/// Tells where two runs part.
///
/// # Errors
///
/// When one of them cannot be played again or a picture cannot be read.
pub fn explain_runs(
    a: &RecordedRun,
    b: &RecordedRun,
    progress: &dyn Progress,
) -> Result<RunsReport, ExplainError> {
    let (asked_count, asked) = bounded(asked(a, b));
    let records = first_lines(a, b);
    let frames_of_b = b.frames();
    let common: Vec<u32> = a
        .frames()
        .into_iter()
        .filter(|frame| frames_of_b.binary_search(frame).is_ok())
        .collect();
    let digests = |run: &RecordedRun| {
        let trees = run.scene().standing_trees();
        trees
            .iter()
            .map(|tree| tree.plant_digest)
            .collect::<Vec<_>>()
    };
    let pinned = digests(a).iter().all(Option::is_some);
    let mut report = RunsReport {
        schema: EXPLAIN_SCHEMA,
        kind: "runs",
        same: false,
        summary: String::new(),
        a: side(a),
        b: side(b),
        asked_count,
        asked,
        plant_files: plant_files(a, b),
        plants: Vec::new(),
        sequences: Vec::new(),
        trunks: Vec::new(),
        levels: None,
        records,
        operation: None,
        buffer_count: 0,
        buffers: Vec::new(),
        frames: frame_pixels(a, b)?,
        common_frames: common.len() as u64,
    };
    let same_so_far = report.asked.is_empty() && report.records.is_empty();
    if same_so_far && pinned && digests(a) == digests(b) && a.ledger() == b.ledger() {
        report.same = true;
        report.summary = super::summary::of(&report);
        return Ok(report);
    }
    let worlds = [a.world(progress)?, b.world(progress)?];
    compare_plants(&worlds, &mut report);
    report.trunks = trunk_differences([a, b], &worlds);
    report.levels = level_difference([a, b], &worlds)?;
    play(a, b, &worlds, &common, progress, &mut report)?;
    report.summary = super::summary::of(&report);
    Ok(report)
}

fn side(run: &RecordedRun) -> SideReport {
    let (initial, totals) = (&run.ledger().initial, &run.ledger().totals);
    SideReport {
        scene: run.scene().name.clone(),
        model: run.kind().label(),
        version: run.ledger().head.version.clone(),
        frames: run.ledger().frames.len() as u64,
        upload_bytes: initial.upload.payload_bytes + totals.upload.payload_bytes,
        fetch_bytes: initial.fetch.payload_bytes + totals.fetch.payload_bytes,
        replayed: Vec::new(),
    }
}

/// Compares the plants of each tree, each pair of plants once.
fn compare_plants(worlds: &[World; 2], report: &mut RunsReport) {
    let [a, b] = worlds;
    let mut known: Vec<[usize; 2]> = Vec::new();
    for (number, (ours, theirs)) in (0..).zip(a.trees.iter().zip(&b.trees)) {
        let plants = [ours.crown, theirs.crown];
        if known.contains(&plants) {
            continue;
        }
        known.push(plants);
        let (one, other) = (&a.crowns[plants[0]], &b.crowns[plants[1]]);
        let matched = match_leaves(one, other);
        report
            .plants
            .extend(plant_difference(number, plants, one, other, &matched));
        let names = LeafNames::new(one, other, &matched);
        report
            .sequences
            .extend(sequence_difference(number, one, other, &names));
    }
}

/// Plays both runs frame by frame until they part.
fn play(
    a: &RecordedRun,
    b: &RecordedRun,
    worlds: &[World; 2],
    common: &[u32],
    progress: &dyn Progress,
    report: &mut RunsReport,
) -> Result<(), ExplainError> {
    let mut replays = [Replay::new(a, &worlds[0])?, Replay::new(b, &worlds[1])?];
    progress.begin("frames", common.len() as u64);
    for frame in std::iter::once(None).chain(common.iter().copied().map(Some)) {
        let mut done = Vec::new();
        for (side, replay) in replays.iter_mut().enumerate() {
            let Some(number) = frame else {
                done.push(operations(replay.session().initial(), replay.session()));
                continue;
            };
            while let Some((drawn, replayed)) = replay.draw_next()? {
                let reached = drawn.frame == number;
                let list = if side == 0 {
                    &mut report.a
                } else {
                    &mut report.b
                };
                list.replayed.push(replayed);
                if reached {
                    done.push(operations(&drawn.ledger, replay.session()));
                    break;
                }
            }
        }
        progress.step();
        let [Some(ours), Some(theirs)] = [done.first(), done.get(1)] else {
            break;
        };
        if same_operations(ours, theirs) {
            continue;
        }
        let readers = [0, 1].map(|side| Reader::new(replays[side].session(), &worlds[side]));
        let pair = [&readers[0], &readers[1]];
        report.operation = first_difference(frame, [ours, theirs], pair);
        let (count, buffers) = bounded(buffer_differences(pair));
        (report.buffer_count, report.buffers) = (count, buffers);
        break;
    }
    if report.a.replayed.is_empty() {
        // They part before anything is drawn: still see whether the runs are what they say.
        for (side, replay) in replays.iter_mut().enumerate() {
            let list = if side == 0 {
                &mut report.a
            } else {
                &mut report.b
            };
            list.replayed
                .extend(replay.draw_next()?.map(|(_, replayed)| replayed));
        }
    }
    Ok(())
}

/// The first differing line of each file that tells what was done.
fn first_lines(a: &RecordedRun, b: &RecordedRun) -> Vec<FirstDifference> {
    let mut found = Vec::new();
    for file in ["ops.jsonl", "ledger.csv"] {
        let texts = [a, b].map(|run| run.text(file).unwrap_or_default());
        if texts[0] == texts[1] {
            continue;
        }
        let [mut ours, mut theirs] = [texts[0].lines(), texts[1].lines()];
        let mut line = 0;
        loop {
            line += 1;
            match (ours.next(), theirs.next()) {
                (None, None) => break,
                (one, other) if one == other => {}
                (one, other) => {
                    let cut = |line: &str| line.chars().take(160).collect::<String>();
                    found.push(FirstDifference {
                        file,
                        line,
                        a: one.map(cut),
                        b: other.map(cut),
                    });
                    break;
                }
            }
        }
    }
    found
}
