//! Writing traces of walks.

use std::io::{self, Write};

use super::super::structure::travel;
use super::super::{Change, DeviceModel, History, Operation, Residency, Structure, Walk};
use super::format::{Header, Hex, NamedSize, Range, SCHEMA, Step, StepCounts, TracePart, Transfer};
use crate::models::State;

/// Writes the trace of a structure that is taken through a walk: what is visible after each step.
///
/// # Errors
///
/// When `out` cannot be written.
pub fn record_structure<S: Structure>(
    out: &mut impl Write,
    walk: &Walk,
    build: impl Fn(&History) -> S,
) -> io::Result<()> {
    let history = &walk.history;
    write_line(out, &header(history, vec![TracePart::Visible], Vec::new()))?;
    let mut structure = build(history);
    let mut state = State::FINEST;
    let shown = |structure: &S, step: Step| Step {
        visible: Some(structure.visible()),
        ..step
    };
    write_line(out, &shown(&structure, to(&state)))?;
    for operation in &walk.operations {
        let Some(target) = operation.target(history, &state) else {
            continue;
        };
        let step = match operation {
            Operation::Collapse => {
                structure.collapse();
                Step {
                    collapse: Some(1),
                    ..Step::default()
                }
            }
            Operation::Split => {
                structure.split();
                Step {
                    split: Some(1),
                    ..Step::default()
                }
            }
            Operation::To(target) if travel(&mut structure, &state, target) => to(target),
            Operation::To(_) => continue,
        };
        write_line(out, &shown(&structure, step))?;
        state = target;
    }
    Ok(())
}

/// Writes the trace of a model that is taken through states, with every part that it can tell and
/// what a fresh upload would hold; `visible` says which leaves it means to show.
///
/// # Errors
///
/// When `out` cannot be written, or the model logs copies or clears within the device, for which the
/// format has no words.
pub fn record_model<M: DeviceModel>(
    out: &mut impl Write,
    history: &History,
    states: &[State],
    build: impl Fn(&State) -> M,
    visible: impl Fn(&State) -> Vec<u32>,
) -> io::Result<()> {
    let Some((start, rest)) = states.split_first() else {
        return Ok(());
    };
    let mut model = build(start);
    let mut parts = vec![TracePart::Visible, TracePart::Resident];
    parts.extend([TracePart::Reads, TracePart::Fresh]);
    let (logs, counts) = (model.log().is_some(), model.counted().is_some());
    parts.extend(logs.then_some(TracePart::Writes));
    parts.extend(counts.then_some(TracePart::Counted));
    let shows = model.picture().is_some();
    parts.extend(shows.then_some(TracePart::Image));
    let sizes = model.resources().into_iter().map(|resource| NamedSize {
        name: resource.name.to_owned(),
        bytes: resource.bytes.len() as u64,
        host: resource.residency == Residency::Host,
    });
    let sizes = sizes.collect();
    write_line(out, &header(history, parts, sizes))?;
    let mut told = Told::default();
    for (number, state) in std::iter::once(start).chain(rest).enumerate() {
        if number > 0 {
            model.commit(state);
        }
        let mut fresh = build(state);
        let (writes, computed) = told.new_writes(&model)?;
        let reads = fresh.reads().ranges;
        let reads = reads.into_iter().filter(|(_, range)| !range.is_empty());
        let step = Step {
            visible: Some(visible(state)),
            writes,
            computed,
            counted: told.new_counts(&mut model),
            resident: Some(held(&model)),
            reads: Some(
                reads
                    .map(|(resource, range)| (resource, range.start as u64, range.end as u64))
                    .collect(),
            ),
            fresh: Some(held(&fresh)),
            image: model.picture().map(|picture| picture.digest().to_string()),
            ..to(state)
        };
        write_line(out, &step)?;
    }
    Ok(())
}

/// Transfers, and ranges that were computed.
type NewWrites = (Option<Vec<Transfer>>, Option<Transfer>);

/// How much of logs and counters was told already.
#[derive(Default)]
struct Told {
    changes: usize,
    counts: StepCounts,
}

impl Told {
    /// What was sent since the last call, and what the device computed before that.
    fn new_writes(&mut self, model: &impl DeviceModel) -> io::Result<NewWrites> {
        let Some(log) = model.log() else {
            return Ok((None, None));
        };
        let mut transfers: Vec<(u64, Transfer)> = Vec::new();
        let mut computed = Vec::new();
        for change in log.iter().skip(self.changes) {
            let range = |resource, at, bytes: &[u8]| Range {
                to: resource,
                at,
                hex: Hex(bytes.to_vec()),
            };
            let (transfer, range) = match *change {
                Change::Write {
                    transfer,
                    resource,
                    at,
                    bytes,
                } => (transfer, range(resource, at, bytes)),
                Change::Computed {
                    resource,
                    at,
                    bytes,
                } => {
                    computed.push(range(resource, at, bytes));
                    continue;
                }
                Change::Copy { .. } | Change::Clear { .. } => {
                    let message = "a trace has no words for copies and clears within the device";
                    return Err(io::Error::new(io::ErrorKind::Unsupported, message));
                }
            };
            match transfers.last_mut() {
                Some((last, ranges)) if *last == transfer => ranges.0.push(range),
                _ => transfers.push((transfer, Transfer(vec![range]))),
            }
        }
        self.changes = log.len();
        let transfers = transfers.into_iter().map(|(_, transfer)| transfer);
        let computed = (!computed.is_empty()).then_some(Transfer(computed));
        Ok((Some(transfers.collect()), computed))
    }

    fn new_counts(&mut self, model: &mut impl DeviceModel) -> Option<StepCounts> {
        let counted = model.counted()?;
        let now = StepCounts {
            transfers: counted.transfers,
            bytes: counted.payload_bytes,
        };
        let before = std::mem::replace(&mut self.counts, now);
        Some(StepCounts {
            transfers: now.transfers.saturating_sub(before.transfers),
            bytes: now.bytes.saturating_sub(before.bytes),
        })
    }
}

fn held(model: &impl DeviceModel) -> Vec<Hex> {
    let resources = model.resources().into_iter();
    resources.map(|held| Hex(held.bytes.to_vec())).collect()
}

fn header(history: &History, parts: Vec<TracePart>, resources: Vec<NamedSize>) -> Header {
    Header {
        schema: SCHEMA.to_owned(),
        leaves: history.leaf_count(),
        collapses: history.collapses(),
        parts,
        resources,
    }
}

fn to(state: &State) -> Step {
    match state {
        State::Uniform { collapses } => Step {
            level: Some(*collapses),
            ..Step::default()
        },
        State::Variable { counts } => Step {
            clusters: Some(counts.clone()),
            ..Step::default()
        },
        // Structures of leaves do not go there; who reads such a step says so.
        State::Cards(_) | State::Strokes(_) => Step::default(),
    }
}

fn write_line(out: &mut impl Write, line: &impl serde::Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *out, line)?;
    out.write_all(b"\n")
}
