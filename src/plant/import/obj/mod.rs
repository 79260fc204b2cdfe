//! Wavefront OBJ: meshes of which the file says neither the up axis nor the unit.
//!
//! ```text
//!  .obj ─text─▶ points in 64 bits, faces by object, group and material ─frame─▶ parts ─▶ leaves or wood
//!  .mtl ─material─▶ colours, pictures beside it
//! ```
//!
//! The file is fully read before anything is guessed, so that the tree's foot can come to the origin before
//! points are rounded.

mod material;
#[cfg(test)]
mod tests;
mod text;

use super::mesh::{self, Evidence, Names, Part, Visit, listed, says_leaves};
use super::{Frame, ImportError, ImportOptions, ImportReport, ReportKind, Source, UpAxis, rings};
use crate::math::{DVec3, Vec2, Vec3};
use crate::plant::{Foliage, Mesh, Plant};
use material::Library;
use std::collections::BTreeSet;
use text::{Corner, NONE, Obj, Run};

/// Reads an `.obj` file.
///
/// Foliage is what the options name, objects, groups or materials, or else what [`mesh::sort`] takes for
/// leaves; the rest is wood.
///
/// # Errors
///
/// When the file is damaged or hostile, exceeds a limit, or nothing bears a name that the options hold.
pub(super) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let obj = text::read(source, report)?;
    let named = named_runs(source, options, &obj)?;
    let mut library = Library::read(source, &obj, report);
    let visit = |take: &mut dyn FnMut(DVec3)| {
        for corner in obj
            .runs
            .iter()
            .flat_map(|run| run.triangles.iter().flatten())
        {
            take(obj.positions[corner.position as usize]);
        }
    };
    let frame = frame(&visit, options, report);
    let mut parts = Vec::with_capacity(obj.runs.len());
    let Obj {
        positions,
        coordinates,
        normals,
        runs,
        names,
        ..
    } = obj;
    let points = Points {
        source,
        frame,
        positions,
        coordinates,
        normals,
    };
    let bears = |name: u32| names.get(name as usize).map(String::as_str);
    for (run, named) in runs.into_iter().zip(named) {
        if run.triangles.is_empty() {
            continue;
        }
        let material = library.number(run.material);
        let mut part = points.part(run.triangles, run.line, report)?;
        part.named = named;
        part.material = material;
        part.has_alpha = material.is_some_and(|material| library.has_alpha(material));
        part.material_says = says_leaves(bears(run.material));
        part.name_says = says_leaves(bears(run.group)) || says_leaves(bears(run.object));
        parts.push(part);
    }
    drop(points);
    let evidence = if options.foliage.is_empty() {
        Evidence::Guess
    } else {
        Evidence::Named
    };
    let Ok((trunk, mut foliage)): Result<(Option<Mesh>, Foliage), std::convert::Infallible> =
        mesh::sort(parts, evidence, &mut library, report);
    library.color_leaves(&mut foliage);
    if foliage.groups.is_empty() && trunk.is_some() {
        let names = listed(&names.into_iter().collect());
        let message = format!("no foliage found; it can be named: {names}");
        report.add(ReportKind::Missing, 1, "line 1", message);
    }
    let skeleton = trunk
        .as_ref()
        .and_then(|trunk| rings::skeleton(trunk, source, "line 1", report));
    Plant::new(source.stem(), skeleton, trunk, foliage).map_err(|error| ImportError::Plant {
        file: source.file().to_owned(),
        source: error,
    })
}

/// Which runs bear a name that the user gave: a group may have several.
fn named_runs(
    source: &Source<'_>,
    options: &ImportOptions,
    obj: &Obj,
) -> Result<Vec<bool>, ImportError> {
    let mut names = Names::new(&options.foliage);
    let mut known = BTreeSet::new();
    let mut named = Vec::with_capacity(obj.runs.len());
    for run in &obj.runs {
        let mut is_named = false;
        for number in [run.object, run.group, run.material] {
            let Some(name) = obj.names.get(number as usize) else {
                continue;
            };
            is_named |= names.has(Some(name));
            known.insert(name.clone());
            if number == run.group && name.contains(char::is_whitespace) {
                for name in name.split_whitespace() {
                    is_named |= names.has(Some(name));
                    known.insert(name.to_owned());
                }
            }
        }
        named.push(is_named);
    }
    match names.unknown() {
        None => Ok(named),
        Some(name) => Err(ImportError::Name {
            file: source.file().to_owned(),
            name: name.to_owned(),
            known: listed(&known),
        }),
    }
}

fn frame(visit: &Visit<'_>, options: &ImportOptions, report: &mut ImportReport) -> Frame {
    let frame = mesh::guess_frame(visit, options.reading, report);
    let up = if frame.height(DVec3::Z) > 0.0 {
        UpAxis::Z
    } else {
        UpAxis::Y
    };
    let base = mesh::base(visit, up).unwrap_or(DVec3::ZERO);
    frame.with_base(base, "line 1", report)
}

/// The points of a file, and how they become a plant's.
struct Points<'a, 's> {
    source: &'a Source<'s>,
    frame: Frame,
    positions: Vec<DVec3>,
    coordinates: Vec<Vec2>,
    normals: Vec<Vec3>,
}

impl Points<'_, '_> {
    fn part(
        &self,
        triangles: Vec<[Corner; 3]>,
        line: usize,
        report: &mut ImportReport,
    ) -> Result<Part, ImportError> {
        let (corners, triangles) = mesh::compact(triangles);
        let count = corners.len();
        let mut part = Part {
            place: format!("line {line}"),
            material: None,
            named: false,
            has_alpha: false,
            material_says: false,
            name_says: false,
            positions: Vec::with_capacity(count),
            normals: Vec::with_capacity(count),
            coordinates: Vec::with_capacity(count),
            triangles,
        };
        let mut bad_normals = 0;
        for corner in &corners {
            let file = self.positions[corner.position as usize];
            let position = self.frame.point(file);
            if !position.is_finite() {
                let message = format!(
                    "vertex {} at {file} lies at {position} in metres, wanted finite numbers",
                    corner.position + 1
                );
                return Err(self.source.error(line, 1, message));
            }
            part.positions.push(position);
            let normal = match corner.normal {
                NONE => Vec3::ZERO,
                normal => {
                    let normal = self.normals[normal as usize].as_dvec3();
                    let unit = self.frame.direction(normal.normalize_or_zero());
                    bad_normals += u64::from(unit == Vec3::ZERO);
                    unit
                }
            };
            part.normals.push(normal);
            let coordinate = match corner.coordinate {
                NONE => Vec2::ZERO,
                // From the image's bottom to a plant's, from its top.
                coordinate => {
                    let Vec2 { x, y } = self.coordinates[coordinate as usize];
                    Vec2::new(x, 1.0 - y)
                }
            };
            part.coordinates.push(coordinate);
        }
        let message = "normals that are zero: computed from the triangles";
        report.add(
            ReportKind::Repaired,
            bad_normals,
            part.place.clone(),
            message,
        );
        Ok(part)
    }
}

impl Obj {
    /// The numbers of the materials that faces have, each once, in the order of meeting.
    fn materials(&self) -> Vec<u32> {
        let mut seen = BTreeSet::new();
        let used = self.runs.iter().map(|run: &Run| run.material);
        used.filter(|&material| material != NONE && seen.insert(material))
            .collect()
    }
}
