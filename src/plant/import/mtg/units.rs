//! How long a unit is, and what diameters and areas are measured in.

use super::entities::Entities;
use super::table::Feature;
use crate::plant::import::frame::{Frame, Unit, UpAxis};
use crate::plant::import::{ImportReport, Reading, ReportKind};

/// The largest number that a plant's extent is believed to be in metres, and a hundred times as much in
/// centimetres: few trees are higher than 40 m.
const PLAUSIBLE_HEIGHT: f64 = 40.0;

/// A trunk is at most so thick, as a share of the plant's height.
const PLAUSIBLE_DIAMETER: f64 = 0.1;

/// A node bears at most so much leaf area, in square metres.
const PLAUSIBLE_AREA: f64 = 2.0;

/// What a file measures in.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units {
    /// From the file's space to the plant's; its base is the origin.
    pub(super) frame: Frame,
    /// Diameters in units of length.
    pub(super) diameter: f64,
    /// Areas in square metres.
    pub(super) area: f64,
    /// The greatest extent of all positions, in the file's unit.
    pub(super) size: f64,
}

impl Units {
    /// Guesses what is not told, and says so.
    pub(super) fn of(entities: &Entities, reading: Reading, report: &mut ImportReport) -> Self {
        let numbers = || 0..crate::math::index_u32(entities.all.len());
        let greatest = |feature: Feature| {
            let values = numbers().filter_map(|entity| entities.value(entity, feature));
            values.fold(0.0, f64::max)
        };
        let extent = |feature: Feature| {
            let values = || numbers().filter_map(|entity| entities.value(entity, feature));
            let [least, most] = [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ];
            (most - least).max(0.0)
        };
        let size = [Feature::X, Feature::Y, Feature::Z]
            .map(extent)
            .into_iter()
            .fold(0.0, f64::max);
        let unit = if size <= PLAUSIBLE_HEIGHT {
            Unit::M
        } else if size <= 100.0 * PLAUSIBLE_HEIGHT {
            Unit::Cm
        } else {
            Unit::Mm
        };
        if reading.unit.is_none() {
            let message = format!(
                "the unit {}, of a plant that measures {size:.4} of them; tell it, if that is wrong",
                unit.name()
            );
            report.add(ReportKind::Guessed, 1, "line 1", message);
        }
        let frame = Frame::new(reading, UpAxis::Z, unit);
        let metre = 1.0 / frame.per_metre();
        let diameter = diameter_unit(greatest(Feature::Diameter), size, report);
        let area = area_unit(greatest(Feature::LeafArea), metre, report);
        Self {
            frame,
            diameter,
            area,
            size,
        }
    }
}

/// Diameters are often told in finer units than lengths: millimetres beside centimetres, or tenths of
/// millimetres beside millimetres.
fn diameter_unit(greatest: f64, size: f64, report: &mut ImportReport) -> f64 {
    let units = [1.0, 10.0, 100.0, 1000.0];
    let is_plausible = |unit: &f64| greatest / unit <= PLAUSIBLE_DIAMETER * size;
    let unit = units.into_iter().find(is_plausible).unwrap_or(1.0);
    if unit > 1.0 {
        let message = format!(
            "diameters up to {greatest} of a plant that measures {size:.4}: taken as 1/{unit} of the unit of \
             lengths"
        );
        report.add(ReportKind::Guessed, 1, "line 1", message);
    }
    1.0 / unit
}

/// The first of the file's own square unit, cm² and mm² in which no node bears too much.
fn area_unit(greatest: f64, metre: f64, report: &mut ImportReport) -> f64 {
    if greatest <= 0.0 {
        return metre * metre;
    }
    let units = [metre * metre, 1e-4, 1e-6];
    let is_plausible = |unit: &f64| greatest * unit <= PLAUSIBLE_AREA;
    let unit = units.into_iter().find(is_plausible).unwrap_or(1e-6);
    let message = format!("leaf areas up to {greatest}: taken as {unit:e} m² each");
    report.add(ReportKind::Guessed, 1, "line 1", message);
    unit
}
