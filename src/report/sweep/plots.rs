//! The curves of a walk along the axis of detail.

use super::changes;
use crate::gpu::nanoseconds;
use crate::report::{Axis, Plot, Scale, Series};
use crate::run::{Sweep, SweepModel, SweepStep};

/// The plots with the names of their files, without `.svg`.
///
/// Uploads and fetches are lines of their own. Lines that are the same for several models are drawn
/// once.
#[must_use]
pub fn sweep_plots(sweep: &Sweep) -> Vec<(&'static str, Plot)> {
    vec![
        (
            "payload",
            plot(
                "Payload of each step: changes of detail, and fetches",
                "payload, B",
                Scale::Log,
                distinct(lines(sweep, moved)),
            ),
        ),
        (
            "cumulated",
            plot(
                "Payload so far, with the first upload",
                "payload, B",
                Scale::Log,
                distinct(lines(sweep, cumulated)),
            ),
        ),
        (
            "frame-time",
            plot(
                "Modelled time of a frame: bus, then card",
                "ms",
                Scale::Log,
                distinct(by_step(sweep, milliseconds)),
            ),
        ),
        (
            "extraction",
            plot(
                "Extraction: records read and written on the host for each step",
                "records",
                Scale::Log,
                distinct(by_step(sweep, |step| records(step) as f64)),
            ),
        ),
        (
            "leaves",
            plot(
                "Leaves shown",
                "leaves",
                Scale::Linear,
                distinct(by_step(sweep, |step| step.leaves as f64)),
            ),
        ),
        (
            "covered",
            plot(
                "Pixels that show a leaf",
                "pixels",
                Scale::Linear,
                distinct(by_step(sweep, |step| step.covered_pixels as f64)),
            ),
        ),
    ]
}

/// Bus and, where it is modelled, card.
pub(super) fn milliseconds(step: &SweepStep) -> f64 {
    let bus = step.ledger.upload.ticks + step.ledger.fetch.ticks;
    nanoseconds(step.frame_ticks().unwrap_or(bus)) as f64 / 1e6
}

/// What a change of detail reads and writes on the host, of foliage and trunk.
pub(super) fn records(step: &SweepStep) -> u64 {
    step.change.host_records + step.trunk_change.host_records
}

/// What a model uploads and what its draws fetch, a number a step.
type Streams = [Vec<u64>; 2];

/// Two lines a model, what it uploads and what its draws fetch; those with nothing are left out.
fn lines(sweep: &Sweep, values: impl Fn(&SweepModel) -> Streams) -> Vec<Series> {
    let of_model = |model: &SweepModel| {
        let label = model.variant.label();
        let names = [label.clone(), format!("{label}, fetched")];
        let line = |(name, values): (String, Vec<u64>)| {
            let steps = model.steps.iter().zip(values);
            Series {
                name,
                points: steps
                    .map(|(step, value)| [step.level(), value as f64])
                    .collect(),
            }
        };
        let has_any = |(_, values): &(String, Vec<u64>)| values.iter().any(|value| *value > 0);
        let named = names.into_iter().zip(values(model)).filter(has_any);
        named.map(line).collect::<Vec<Series>>()
    };
    sweep.models.iter().flat_map(of_model).collect()
}

/// Bytes of each step.
fn moved(model: &SweepModel) -> Streams {
    let fetched = model
        .steps
        .iter()
        .map(|step| step.ledger.fetch.payload_bytes);
    [model.steps.iter().map(changes).collect(), fetched.collect()]
}

/// Bytes so far; uploads begin with what was sent before step 0.
fn cumulated(model: &SweepModel) -> Streams {
    let mut streams = moved(model);
    for (values, begin) in streams
        .iter_mut()
        .zip([model.initial.upload.payload_bytes, 0])
    {
        let mut sum = begin;
        for value in values {
            sum += *value;
            *value = sum;
        }
    }
    streams
}

/// One line a model.
fn by_step(sweep: &Sweep, value: impl Fn(&SweepStep) -> f64) -> Vec<Series> {
    let line = |model: &SweepModel| {
        let point = |step: &SweepStep| [step.level(), value(step)];
        Series {
            name: model.variant.label(),
            points: model.steps.iter().map(point).collect(),
        }
    };
    sweep.models.iter().map(line).collect()
}

/// Each line once, named by the models that have it: by both of two, else by the first and how many
/// others there are.
fn distinct(lines: Vec<Series>) -> Vec<Series> {
    let mut kept: Vec<(Vec<String>, Vec<[f64; 2]>)> = Vec::new();
    for Series { name, points } in lines {
        match kept.iter_mut().find(|(_, known)| *known == points) {
            Some((names, _)) => names.push(name),
            None => kept.push((vec![name], points)),
        }
    }
    let named = |(names, points): (Vec<String>, Vec<[f64; 2]>)| {
        let name = match &names[..] {
            [first, others @ ..] if others.len() > 1 => {
                format!("{first} and {} others", others.len())
            }
            _ => names.join(" = "),
        };
        Series { name, points }
    };
    kept.into_iter().map(named).collect()
}

pub(super) fn plot(title: &str, label: &str, scale: Scale, series: Vec<Series>) -> Plot {
    Plot {
        title: title.to_owned(),
        x: Axis {
            label: "detail: 0 all leaves, 1 the fewest".to_owned(),
            scale: Scale::Linear,
        },
        y: Axis {
            label: label.to_owned(),
            scale,
        },
        series,
    }
}
