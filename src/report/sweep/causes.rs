//! What each step of a walk sends, by cause: a small plot a model and stream.

use std::collections::{BTreeMap, BTreeSet};

use crate::gpu::Ledger;
use crate::report::run::{fetch_by_cause, upload_by_cause};
use crate::report::{Axis, Scale, Stack, StackLayer};
use crate::run::{Sweep, SweepModel};

/// Bytes of a step by cause.
type ByCause = BTreeMap<String, u64>;

/// What some models send in one stream.
#[derive(PartialEq)]
struct Sent {
    stream: &'static str,
    places: Vec<f64>,
    steps: Vec<ByCause>,
}

/// The plots. Models that send the same share one; what sends nothing has none.
pub(super) fn stacks(sweep: &Sweep) -> Vec<Stack> {
    let mut known: Vec<(Sent, Vec<String>)> = Vec::new();
    for model in &sweep.models {
        for sent in [
            sent(model, "uploaded, B", upload_by_cause),
            sent(model, "fetched, B", fetch_by_cause),
        ] {
            if sent.steps.iter().all(ByCause::is_empty) {
                continue;
            }
            let label = model.variant.label();
            match known.iter_mut().find(|(other, _)| *other == sent) {
                Some((_, labels)) => labels.push(label),
                None => known.push((sent, vec![label])),
            }
        }
    }
    let steps = known.iter().flat_map(|(sent, _)| &sent.steps);
    let causes: BTreeSet<&String> = steps.flat_map(ByCause::keys).collect();
    let causes: Vec<&String> = causes.into_iter().collect();
    let stacks = known.iter();
    stacks
        .map(|(sent, labels)| stack(sent, labels, &causes))
        .collect()
}

fn sent(model: &SweepModel, stream: &'static str, bytes: fn(&Ledger) -> ByCause) -> Sent {
    Sent {
        stream,
        places: model.steps.iter().map(|step| step.level()).collect(),
        steps: model.steps.iter().map(|step| bytes(&step.ledger)).collect(),
    }
}

fn stack(sent: &Sent, labels: &[String], causes: &[&String]) -> Stack {
    let layer = |(color, cause): (usize, &&String)| {
        let bytes = |step: &ByCause| step.get(*cause).copied().unwrap_or(0) as f64;
        StackLayer {
            name: (*cause).clone(),
            color,
            values: sent.steps.iter().map(bytes).collect(),
        }
    };
    let is_there = |layer: &StackLayer| layer.values.iter().any(|value| *value > 0.0);
    Stack {
        title: match labels {
            [first, _, _, ..] => format!("{first} and {} others", labels.len() - 1),
            few => few.join(" = "),
        },
        x: Axis {
            label: "detail: 0 all leaves, 1 the fewest".to_owned(),
            scale: Scale::Linear,
        },
        label: sent.stream.to_owned(),
        places: sent.places.clone(),
        layers: causes
            .iter()
            .enumerate()
            .map(layer)
            .filter(is_there)
            .collect(),
        size: Stack::SMALL,
    }
}
