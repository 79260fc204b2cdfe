//! OPS: a table of plants and where each stands.
//!
//! ```text
//! T 0 0 0 100 100 flat                                              the ground, which is no plant's
//! # scene  plant  file       x y z   scale  azimuth  inclination  twist
//! 1        1      a.opf      0 0 0   1      0        0            0
//! ```
//!
//! Positions are metres, as the programs have it that write them (files of plants are in centimetres). A
//! plant is twisted about its vertical axis, scaled, inclined, and then put in its place.

use super::plant::Growing;
use super::{Opf, Place};
use crate::limits::PLACED_PRIMITIVES;
use crate::math::{DMat3, DVec3, det};
use crate::plant::Plant;
use crate::plant::import::{
    Frame, ImportError, ImportOptions, ImportReport, ReportKind, Source, Unit, UpAxis,
};
use std::collections::BTreeMap;

/// A row of the table.
#[derive(Debug)]
struct Row {
    path: String,
    line: usize,
    position: DVec3,
    scale: f64,
    /// Azimuth and angle of the inclination, and the twist, in the file's unit.
    angles: [f64; 3],
}

/// The columns of a row: numbers stand from the fourth on.
const COLUMNS: usize = 10;

pub(super) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let rows = rows(source, report)?;
    let unit = unit_of_angles(&rows, report);
    let frame = Frame::new(options.reading, UpAxis::Z, Unit::Cm);
    let mut files: BTreeMap<&str, Opf> = BTreeMap::new();
    let mut growing = Growing::new(source, options);
    for row in &rows {
        if !files.contains_key(row.path.as_str()) {
            files.insert(&row.path, file(source, row, report)?);
        }
        let opf = files.get(row.path.as_str()).expect("it was put there");
        growing.add(opf, &row.place(unit, &frame), report)?;
    }
    report.find("plants", rows.len() as u64);
    growing.plant(report)
}

fn file(source: &Source<'_>, row: &Row, report: &mut ImportReport) -> Result<Opf, ImportError> {
    let path = row.path.replace('\\', "/");
    let bytes = source.beside(&path).map_err(|error| {
        let message = format!("the plant {path:?} is not there: {error}");
        source.error(row.line, 1, message)
    })?;
    // Errors within name the file as the table does.
    Opf::read(&Source::new(&path, &bytes, None)?, report)
}

/// The rows of the table, in order.
fn rows(source: &Source<'_>, report: &mut ImportReport) -> Result<Vec<Row>, ImportError> {
    let mut rows = Vec::new();
    for (line, text) in (1..).zip(source.text()?.lines()) {
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let place = format!("line {line}");
        // A path may hold spaces where columns are parted by tabs.
        let cells: Vec<&str> = if text.contains('\t') {
            text.split('\t').map(str::trim).collect()
        } else {
            text.split_whitespace().collect()
        };
        if cells[0] == "T" || cells[0].starts_with("T ") {
            let message = "the extent of the ground";
            report.add(ReportKind::Ignored, 1, place, message);
            continue;
        }
        if cells.len() < 7 {
            let message = format!(
                "{} columns, wanted {COLUMNS}: scene, plant, file, x, y, z, scale, azimuth, inclination, twist",
                cells.len()
            );
            return Err(source.error(line, 1, message));
        }
        let path = cells[2];
        if !path.to_lowercase().ends_with(".opf") {
            let message = "objects that are no OPF files";
            report.add(ReportKind::NotUnderstood, 1, place, message);
            continue;
        }
        let mut numbers = [0.0; 7];
        for (number, (cell, column)) in numbers.iter_mut().zip(cells[3..].iter().zip(4..)) {
            let value = cell.parse::<f64>().ok().filter(|value| value.is_finite());
            *number = value.ok_or_else(|| {
                let message = format!("column {column} is {cell:?}, wanted a finite number");
                source.error(line, 1, message)
            })?;
        }
        source.limit("plants", rows.len() as u64 + 1, PLACED_PRIMITIVES as u64)?;
        let [x, y, z, scale, angles @ ..] = numbers;
        rows.push(Row {
            path: path.to_owned(),
            line,
            position: DVec3::new(x, y, z),
            scale,
            angles,
        });
    }
    if rows.is_empty() {
        let message = "no plant in the table; each is a line that names an .opf file";
        return Err(source.error(1, 1, message));
    }
    Ok(rows)
}

/// How many radians a unit of the file's angles is: some programs write radians, others degrees. No angle
/// beyond a turn in radians means these.
fn unit_of_angles(rows: &[Row], report: &mut ImportReport) -> f64 {
    let turned = |row: &&Row| row.angles.iter().any(|&angle| angle != 0.0);
    let Some(first) = rows.iter().find(turned) else {
        return 1.0;
    };
    let angles = rows.iter().flat_map(|row| row.angles);
    let greatest = angles.map(f64::abs).fold(0.0, f64::max);
    let (name, unit) = if greatest <= std::f64::consts::TAU + 0.001 {
        ("radians", 1.0)
    } else {
        ("degrees", std::f64::consts::PI / 180.0)
    };
    let message = format!("angles are in {name}: the greatest is {greatest}");
    report.add(
        ReportKind::Guessed,
        1,
        format!("line {}", first.line),
        message,
    );
    unit
}

impl Row {
    fn place(&self, unit: f64, frame: &Frame) -> Place {
        let [azimuth, inclination, twist] = self.angles.map(|angle| angle * unit);
        let turn = rotation(DVec3::Z, twist);
        // Leans towards the azimuth, which counts from x to y.
        let (sine, cosine) = (det::sin_f64(azimuth), det::cos_f64(azimuth));
        let lean = rotation(DVec3::new(-sine, cosine, 0.0), inclination);
        Place {
            linear: lean * (turn * self.scale),
            origin: self.position * frame.per_metre(),
        }
    }
}

/// The rotation about a unit axis (Rodrigues' formula).
fn rotation(axis: DVec3, angle: f64) -> DMat3 {
    if angle == 0.0 {
        return DMat3::IDENTITY;
    }
    let (sine, cosine) = (det::sin_f64(angle), det::cos_f64(angle));
    let column = |unit: DVec3| {
        unit * cosine + axis.cross(unit) * sine + axis * (axis.dot(unit) * (1.0 - cosine))
    };
    DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z))
}
