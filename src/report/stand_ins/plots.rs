//! The numbers as curves.

use super::{StandInReport, frame_ns};
use crate::math::det;
use crate::report::{Axis, Plot, Scale, Series};
use crate::run::{CURVE_VIEWS, Leaves, StandIn, StandInCost};

/// Frames a second of 32 impostors and of leaves ([GSS05](crate::references), § 3).
const PRINTED: [f64; 2] = [278.0, 40.0];

/// Where a stand-in is as fast as leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crossover {
    /// At this radius of the crown in pixels; the largest, of several.
    At(f64),
    /// Nowhere: it is faster throughout.
    Faster,
    /// Nowhere: it is slower throughout.
    Slower,
    /// Everywhere.
    Same,
    /// Nothing is known.
    Unknown,
}

/// Where a stand-in is as fast as leaves: between the points of the curves, ratios of times are taken to
/// be powers of the radius.
#[must_use]
pub fn crossover(leaves: &StandInCost, cost: &StandInCost) -> Crossover {
    let ratios = speed_ups(leaves, cost);
    let crossing = |pair: &[[f64; 2]]| {
        let logs = [pair[0], pair[1]].map(|point| point.map(det::log_f64));
        let [[near, first], [far, second]] = logs;
        let crosses = first != second && (first <= 0.0) != (second <= 0.0);
        crosses.then(|| det::exp_f64(near + (far - near) * first / (first - second)))
    };
    if !ratios.is_empty() && ratios.iter().all(|[_, ratio]| *ratio == 1.0) {
        return Crossover::Same;
    }
    match ratios.windows(2).rev().find_map(crossing) {
        Some(radius) => Crossover::At(radius),
        None => match ratios.first() {
            Some([_, ratio]) if *ratio > 1.0 => Crossover::Faster,
            Some(_) => Crossover::Slower,
            None => Crossover::Unknown,
        },
    }
}

/// Radius, and how many times as long leaves take.
fn speed_ups(leaves: &StandInCost, cost: &StandInCost) -> Vec<[f64; 2]> {
    let pairs = leaves.curve.iter().zip(&cost.curve);
    pairs
        .filter_map(|(leaves, point)| {
            let [leaves, time] = [leaves, point].map(|point| frame_ns(&point.frames, CURVE_VIEWS));
            let ratio = leaves? as f64 / time?.max(1) as f64;
            Some([f64::from(point.radius), ratio])
        })
        .collect()
}

/// The plots with the names of their files, without `.svg`.
#[must_use]
pub fn stand_in_plots(report: &StandInReport) -> Vec<(&'static str, Plot)> {
    let times = report.costs.iter().map(|cost| Series {
        name: cost.stand_in.label(),
        points: cost
            .curve
            .iter()
            .filter_map(|point| {
                let time = frame_ns(&point.frames, CURVE_VIEWS)?;
                Some([f64::from(point.radius), 1e-3 * time as f64])
            })
            .collect(),
    });
    let leaves = report
        .costs
        .iter()
        .find(|cost| cost.stand_in == StandIn::LEAVES);
    let mut speed_up: Vec<Series> = report
        .costs
        .iter()
        .filter(|cost| cost.stand_in != StandIn::LEAVES && cost.stand_in.leaves == Leaves::Original)
        .map(|cost| Series {
            name: cost.stand_in.label(),
            points: leaves.map_or_else(Vec::new, |leaves| speed_ups(leaves, cost)),
        })
        .collect();
    if let Some(curve) = leaves.map(|leaves| &leaves.curve) {
        let ends = curve.first().into_iter().chain(curve.last());
        speed_up.push(Series {
            name: "GSS05: 278 / 40".to_owned(),
            points: ends
                .map(|point| [f64::from(point.radius), PRINTED[0] / PRINTED[1]])
                .collect(),
        });
    }
    let radius = "radius of the crown, pixels";
    let log = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Log,
    };
    let of = |title: &str, x: &str, y: Axis, series: Vec<Series>| Plot {
        title: title.to_owned(),
        x: log(x),
        y,
        series,
    };
    let linear = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
    };
    vec![
        (
            "frame-time",
            of(
                "Modelled time of a frame",
                radius,
                log("µs"),
                times.collect(),
            ),
        ),
        (
            "speed-up",
            of("Speed-up over leaves", radius, log("times"), speed_up),
        ),
        (
            "flip",
            of(
                "FLIP to what is stood for, by the number of planes",
                "planes",
                linear("0 equal, 1 black and white"),
                by_planes(report, |look| look.views.flip.mean),
            ),
        ),
        (
            "ssim",
            of(
                "SSIM to what is stood for, by the number of planes",
                "planes",
                linear("1 equal"),
                by_planes(report, |look| look.views.ssim.mean),
            ),
        ),
    ]
}

/// A line of each scale and kind of what stands in planes.
fn by_planes(report: &StandInReport, value: impl Fn(&super::StandInQuality) -> f64) -> Vec<Series> {
    let mut lines: Vec<Series> = Vec::new();
    for look in &report.looks {
        let Some(planes) = look.stand_in.planes else {
            continue;
        };
        let name = StandIn {
            planes: None,
            ..look.stand_in
        };
        let scale = report.header.scales.get(look.scale);
        let name = format!("{}, {}", name.label(), scale.map_or("", |scale| scale.name));
        let point = [f64::from(planes), value(look)];
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point),
            None => lines.push(Series {
                name,
                points: vec![point],
            }),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{Ledger, TICKS_PER_NANOSECOND};
    use crate::run::CurvePoint;

    fn cost(times: &[u64]) -> StandInCost {
        let radii = [4.0, 8.0, 16.0, 32.0];
        let point = |(radius, &ns): (f32, &u64)| CurvePoint {
            radius,
            frames: Ledger {
                gpu_ticks: Some(ns * CURVE_VIEWS * TICKS_PER_NANOSECOND),
                ..Ledger::default()
            },
        };
        StandInCost {
            stand_in: StandIn::LEAVES,
            triangles: 0,
            initial: Ledger::default(),
            resident_bytes: 0,
            curve: radii.into_iter().zip(times).map(point).collect(),
        }
    }

    #[test]
    fn curves_cross_between_their_points() {
        let leaves = cost(&[1000, 1000, 1000, 1000]);
        assert_eq!(
            crossover(&leaves, &cost(&[10, 20, 30, 40])),
            Crossover::Faster
        );
        assert_eq!(crossover(&leaves, &cost(&[2000, 2000])), Crossover::Slower);
        assert_eq!(crossover(&leaves, &cost(&[])), Crossover::Unknown);
        assert_eq!(crossover(&leaves, &leaves), Crossover::Same);
        // Four times as fast at 8, four times as slow at 16: as fast half way, on a scale of ratios.
        let Crossover::At(radius) = crossover(&leaves, &cost(&[125, 250, 4000, 8000])) else {
            panic!("they cross");
        };
        assert!((radius - 8.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{radius}");
    }
}
