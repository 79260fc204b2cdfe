//! Which models of a walk nothing beats: bytes against time, memory and error.

use super::plots::milliseconds;
use crate::report::bytes::{color, dominates};
use crate::report::{Axis, Panel, Point, Scale, Scatter, SweepQuality, Thing};
use crate::run::{Sweep, SweepModel};

/// What the marks mean.
pub(super) const MARKS: &str = "Each point is a model over the whole walk; bytes are uploads, fetches and \
     commands, but for the first upload. A disc is a model that no other with levels beats: none is nowhere more \
     and somewhere less of all that is plotted. A ring is one that is beaten, or has no levels.";

/// What a walk costs, of each measure less is better.
#[derive(Debug, Clone, Copy)]
struct Cost {
    bytes: f64,
    milliseconds: f64,
    resident: f64,
    /// FLIP of the scene's picture against full detail, the mean over the levels that were looked at.
    error: Option<f64>,
}

impl Cost {
    fn of(model: &SweepModel, quality: Option<&SweepQuality>) -> Self {
        let totals = model.totals();
        let down = totals.upload.payload_bytes + totals.fetch.payload_bytes + totals.command_bytes;
        let looked_at = |quality: &SweepQuality| {
            let steps = model.steps.iter();
            let errors = steps.filter_map(|step| Some(quality.of(model, step)?.frame.flip));
            let errors: Vec<f64> = errors.collect();
            (!errors.is_empty()).then(|| errors.iter().sum::<f64>() / errors.len() as f64)
        };
        Self {
            bytes: down as f64,
            milliseconds: model.steps.iter().map(milliseconds).sum(),
            resident: model.resident.iter().map(|(_, bytes)| bytes).sum::<u64>() as f64,
            error: quality.and_then(looked_at),
        }
    }

    /// A model whose error is not known is never better by it.
    fn beats(&self, other: &Self) -> bool {
        let values = |cost: &Self| {
            let error = cost.error.unwrap_or(f64::MAX);
            [cost.bytes, cost.milliseconds, cost.resident, error]
        };
        dominates(&values(self), &values(other))
    }
}

/// The plots as one.
pub(super) fn plot(sweep: &Sweep, quality: Option<&SweepQuality>) -> Scatter {
    let costs: Vec<Cost> = sweep
        .models
        .iter()
        .map(|model| Cost::of(model, quality))
        .collect();
    let marked = |(model, cost): (&SweepModel, &Cost)| {
        let mut rivals = sweep.models.iter().zip(&costs);
        let beaten = rivals.any(|(rival, theirs)| rival.variant.has_levels() && theirs.beats(cost));
        model.variant.has_levels() && !beaten
    };
    let marks: Vec<bool> = sweep.models.iter().zip(&costs).map(marked).collect();
    let panel = |title: &str, (label, scale): (&str, Scale), up: fn(&Cost) -> f64| Panel {
        title: title.to_owned(),
        x: Axis {
            label: "down the bus, B".to_owned(),
            scale: Scale::Log,
        },
        y: Axis {
            label: label.to_owned(),
            scale,
        },
        points: costs
            .iter()
            .zip(&marks)
            .map(|(cost, &marked)| Point {
                at: [cost.bytes, up(cost)],
                marked,
            })
            .collect(),
    };
    let mut panels = vec![
        panel("Modelled time of all frames", ("ms", Scale::Log), |cost| {
            cost.milliseconds
        }),
        panel("Device memory", ("B", Scale::Linear), |cost| cost.resident),
    ];
    if quality.is_some() {
        let error = |cost: &Cost| cost.error.unwrap_or(f64::NAN);
        panels.push(panel(
            "Error: FLIP to full detail, mean",
            ("0 equal", Scale::Linear),
            error,
        ));
    }
    let thing = |model: &SweepModel| Thing {
        name: model.variant.label(),
        color: color(model.variant),
    };
    Scatter {
        title: "Which models nothing beats".to_owned(),
        things: sweep.models.iter().map(thing).collect(),
        panels,
        columns: 2,
    }
}
