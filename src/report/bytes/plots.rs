//! Which models nothing beats, as plots of two measures each.

use super::ByteReport;
use super::entries::{Entry, Group, entries, together};
use super::sums::Cost;
use super::table::{groups, plant_heading, title, together_heading};
use crate::gpu::nanoseconds;
use crate::models::{Kind, TrunkKind};
use crate::report::{Axis, Panel, Point, Scale, Scatter, Thing};
use crate::run::Variant;

/// What a disc is, and what a ring.
pub(super) const MARKS: &str = "Each point is a model over a whole walk. A disc is one that no other model \
     with levels beats, on the link of the plot, in all of bytes, time, vertices and device memory together; \
     a ring is one that is beaten, or has no levels. What takes no time has no place in a plot of times.";

/// The plots with the names of their files, without `.svg`: all plants together, then each plant.
#[must_use]
pub fn bytes_plots(report: &ByteReport) -> Vec<(String, Scatter)> {
    let mut plots = Vec::new();
    for group in groups(report) {
        let (name, all) = (file_name(group), together(report, group));
        let heading = format!("{}: {}", what(group), together_heading(report));
        plots.push((name.to_owned(), plot(report, &heading, &all)));
    }
    if report.plants.len() > 1 {
        for plant in 0..report.plants.len() {
            for group in groups(report) {
                let name = format!("{}-{:02}", file_name(group), plant + 1);
                plots.push((name, plant_plot(report, plant, group)));
            }
        }
    }
    plots
}

/// The plot of one plant.
pub(super) fn plant_plot(report: &ByteReport, plant: usize, group: Group) -> Scatter {
    let heading = format!("{}: {}", what(group), plant_heading(report, plant));
    plot(
        report,
        &heading,
        &entries(report, &report.plants[plant], group),
    )
}

/// The plot of all plants together.
pub(super) fn together_plot(report: &ByteReport, group: Group) -> Scatter {
    let heading = format!("{}: {}", what(group), together_heading(report));
    plot(report, &heading, &together(report, group))
}

fn file_name(group: Group) -> &'static str {
    match group {
        Group::Foliage => "pareto",
        Group::Trunks => "pareto-trunks",
    }
}

fn what(group: Group) -> &'static str {
    match group {
        Group::Foliage => "Foliage",
        Group::Trunks => "Trunks",
    }
}

fn plot(report: &ByteReport, heading: &str, entries: &[Entry]) -> Scatter {
    let thing = |entry: &Entry| Thing {
        name: entry.variant.label(),
        color: color(entry.variant),
    };
    let axis = |label: &str, scale| Axis {
        label: label.to_owned(),
        scale,
    };
    let bytes = || axis("down the bus, B", Scale::Log);
    let mut panels = Vec::new();
    type Measure = fn(&Cost) -> f64;
    let milliseconds: Measure = |cost| nanoseconds(cost.ticks) as f64 / 1e6;
    let rows: [(Axis, Measure, Axis, Measure); 3] = [
        (
            bytes(),
            |cost| cost.bytes as f64,
            axis("on the bus, ms", Scale::Log),
            milliseconds,
        ),
        (
            axis("vertices", Scale::Linear),
            |cost| cost.vertices as f64,
            axis("on the bus, ms", Scale::Log),
            milliseconds,
        ),
        (
            bytes(),
            |cost| cost.bytes as f64,
            axis("device memory, B", Scale::Linear),
            |cost| cost.resident_bytes as f64,
        ),
    ];
    for (x, across, y, up) in &rows {
        for (number, link) in report.links.iter().enumerate() {
            let point = |entry: &Entry| {
                let cost = entry.sums.cost(number);
                Point {
                    at: [across(&cost), up(&cost)],
                    marked: is_unbeaten(entry, entries, number),
                }
            };
            panels.push(Panel {
                title: title(*link),
                x: x.clone(),
                y: y.clone(),
                points: entries.iter().map(point).collect(),
            });
        }
    }
    Scatter {
        title: heading.to_owned(),
        things: entries.iter().map(thing).collect(),
        panels,
        columns: report.links.len(),
    }
}

/// Whether no other model beats one by the sums that are shown.
fn is_unbeaten(entry: &Entry, entries: &[Entry], link: usize) -> bool {
    let cost = entry.sums.cost(link);
    let mut rivals = entries.iter().filter(|other| other.has_levels());
    entry.has_levels() && !rivals.any(|other| other.sums.cost(link).dominates(&cost))
}

/// Models of a family have a colour.
pub(in crate::report) fn color(variant: Variant) -> usize {
    if let Some(TrunkKind { name, .. }) = variant.trunk {
        return match name.name() {
            "lodstrips" => 2,
            "lodstrips-cut" => 4,
            "mom" => 0,
            _ => 5,
        };
    }
    match variant.kind {
        Kind::VdfHost | Kind::VdfIndices => 0,
        Kind::LodfHost | Kind::LodfCluster => 1,
        Kind::LodfSlots => 2,
        Kind::LodfStamps => 3,
        Kind::LodfDevice => 4,
        // One that has no levels, and cards, which are no variants.
        _ => 5,
    }
}
