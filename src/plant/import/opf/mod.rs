//! AMAP's Open Plant Format: a topology of organs, each a reference mesh and a matrix.
//!
//! ```text
//!  .ops ─scene─▶ files and their places ┐
//!  .opf ─xml─▶ tables: meshes, materials, shapes
//!          └─▶ topology: organs, what bears them, matrices ─plant─▶ cylinders: wood ─▶ skeleton, trunk mesh
//!                                                            └────▶ all else: a group of leaves a shape
//! ```
//!
//! Matrices are absolute, in centimetres with +Z up. Internodes are a reference cylinder along +x; leaves share
//! a mesh, so that a group of equal prototypes is what the file holds anyway.

mod plant;
mod scene;
mod tables;
#[cfg(test)]
mod tests;
mod topology;
mod xml;

use super::{ImportError, ImportOptions, ImportReport, Source};
use crate::math::{DMat3, DVec3};
use crate::plant::Plant;
use plant::Growing;
use tables::Tables;
use topology::Organ;

/// A file's tables and organs.
#[derive(Debug)]
struct Opf {
    tables: Tables,
    organs: Vec<Organ>,
}

/// An affine map, in 64 bits and the file's units.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    linear: DMat3,
    origin: DVec3,
}

impl Place {
    const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        origin: DVec3::ZERO,
    };

    fn point(&self, point: DVec3) -> DVec3 {
        self.linear * point + self.origin
    }

    /// The map of what lies in this place at `inner`.
    fn of(&self, inner: &Self) -> Self {
        Self {
            linear: self.linear * inner.linear,
            origin: self.point(inner.origin),
        }
    }
}

impl Opf {
    fn read(source: &Source<'_>, report: &mut ImportReport) -> Result<Self, ImportError> {
        let text = source.text()?;
        let xml = xml::Xml::parse(source, text)?;
        let tables = Tables::read(&xml, report)?;
        let organs = topology::organs(&xml, &tables, report)?;
        Ok(Self { tables, organs })
    }
}

/// Reads an `.opf` file.
///
/// Cylinders are wood; all other organs, or those whose class or shape the options name, are foliage.
///
/// # Errors
///
/// When the file is damaged or hostile, exceeds a limit, or nothing bears a name that the options hold.
pub(super) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let opf = Opf::read(source, report)?;
    let mut growing = Growing::new(source, options);
    growing.add(&opf, &Place::IDENTITY, report)?;
    growing.plant(report)
}

/// Reads an `.ops` file: all of its plants as one, with a root each.
///
/// # Errors
///
/// As [`read`], for the table and for every file that it names; these must lie beside it.
pub(super) fn read_scene(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    scene::read(source, options, report)
}
