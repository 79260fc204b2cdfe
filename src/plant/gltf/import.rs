//! The way from a file to a plant.

use super::accessor::Reader;
use super::buffers::Buffers;
use super::container::split;
use super::error::Fault;
use super::material::Materials;
use super::native;
use super::record::POINTER;
use super::scan::{self, Document};
use super::scene::{Placed, known_names, place};
use super::surface::{self, QUANTIZATION, Surface};
use crate::limits::PLACED_CORNERS;
use crate::math::DVec3;
use crate::plant::import::mesh::{self, Evidence, Names};
use crate::plant::import::{
    Frame, ImportError, ImportOptions, ImportReport, Reading, ReportKind, Source, Unit, UpAxis,
    rings,
};
use crate::plant::{Foliage, Mesh, Plant};
use gltf_json::Root;

/// Reads a `.glb` or `.gltf` file.
///
/// Foliage is what the options name, or else what [`mesh::sort`] takes for leaves; the rest is wood. A file that [`export_glb`](super::export_glb) wrote, and that was not edited,
/// gives the plant that was written, without guesses.
///
/// # Errors
///
/// When the file is damaged or hostile, exceeds a limit, needs an extension that is not supported, or
/// nothing bears a name that the options hold.
pub(in crate::plant) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let file = source.file();
    let container = split(file, source.bytes(), report)?;
    let document = scan::parse(file, container.json, container.json_offset)?;
    let in_file = |fault: Fault| fault.in_file(file);
    check_version(&document.root).map_err(in_file)?;
    note_extensions(&document, report).map_err(in_file)?;
    let root = &document.root;
    note_unused(root, report);
    let mut names = Names::new(&options.foliage);
    let placed = place(root, &mut names, report).map_err(in_file)?;
    if let Some(name) = names.unknown() {
        return Err(ImportError::Name {
            file: file.to_owned(),
            name: name.to_owned(),
            known: known_names(root),
        });
    }
    let reader = Reader::new(root, Buffers::new(root, source.folder(), container.binary));
    let opened = open_all(root, &reader, placed, report).map_err(in_file)?;
    let mut materials = Materials::new(root, &reader);
    let as_it_is = Frame::new(Reading::default(), UpAxis::Y, Unit::M);
    let is_overruled =
        !options.foliage.is_empty() || Frame::new(options.reading, UpAxis::Y, Unit::M) != as_it_is;
    if !is_overruled {
        let written = native::Source {
            root,
            reader: &reader,
            placed: &opened,
        };
        if let Some(plant) = native::read(&written, &mut materials, report) {
            return Ok(plant);
        }
    }
    if is_overruled && native::has_record(root) {
        let message = if options.foliage.is_empty() {
            "the record of the plant as written, since its axis or unit is told: no skeleton"
        } else {
            "the record of the plant as written, since foliage is named: no skeleton"
        };
        report.add(ReportKind::Dropped, 1, POINTER, message);
    }
    let (trunk, foliage) =
        detect(root, &opened, options, &mut materials, report).map_err(in_file)?;
    let skeleton = trunk
        .as_ref()
        .and_then(|trunk| rings::skeleton(trunk, source, "/nodes", report));
    Plant::new(source.stem(), skeleton, trunk, foliage).map_err(|source| ImportError::Plant {
        file: file.to_owned(),
        source,
    })
}

fn check_version(root: &Root) -> Result<(), Fault> {
    let asset = &root.asset;
    let version = asset.min_version.as_ref().unwrap_or(&asset.version);
    if version.split('.').next() == Some("2") {
        return Ok(());
    }
    let message = format!("version {version:?}, wanted 2.0; convert the file");
    Err(Fault::new("/asset/version", message))
}

/// Refuses extensions without which the shape would be wrong, and lists the others.
fn note_extensions(document: &Document, report: &mut ImportReport) -> Result<(), Fault> {
    for (place, name) in document.root.extensions_required.iter().enumerate() {
        let only_looks = [
            "KHR_materials_",
            "KHR_texture_",
            "EXT_texture_",
            "KHR_lights_",
        ];
        let is_harmless = only_looks.iter().any(|prefix| name.starts_with(prefix));
        if name != QUANTIZATION && !is_harmless {
            return Err(Fault::new(
                format!("/extensionsRequired/{place}"),
                format!("{name:?} is required and not supported; export the file without it"),
            ));
        }
    }
    for (name, (count, pointer)) in &document.extensions {
        let message = format!("extension {name}");
        report.add(ReportKind::NotUnderstood, *count, pointer, message);
    }
    Ok(())
}

fn note_unused(root: &Root, report: &mut ImportReport) {
    for (count, place, message) in [
        (root.animations.len(), "/animations", "animations"),
        (root.cameras.len(), "/cameras", "cameras"),
    ] {
        report.add(ReportKind::Ignored, count as u64, place, message);
    }
}

fn open_all<'r>(
    root: &Root,
    reader: &'r Reader<'_>,
    placed: Vec<Placed>,
    report: &mut ImportReport,
) -> Result<Vec<(Placed, Surface<'r>)>, Fault> {
    let mut opened = Vec::with_capacity(placed.len());
    for placed in placed {
        let Some(surface) = surface::open(root, reader, &placed, report)? else {
            continue;
        };
        report.find("primitives", 1);
        report.find("triangles", surface.corner_count() / 3);
        opened.push((placed, surface));
    }
    Ok(opened)
}

/// The frame of a document, in which a tree that stands far away comes to the origin.
fn frame(
    opened: &[(Placed, Surface<'_>)],
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Frame {
    let visit = |take: &mut dyn FnMut(DVec3)| {
        for (placed, surface) in opened {
            surface.visit(placed, take);
        }
    };
    let frame = Frame::new(options.reading, UpAxis::Y, Unit::M);
    let base = mesh::base(&visit, options.reading.up.unwrap_or(UpAxis::Y));
    frame.with_base(base.unwrap_or(DVec3::ZERO), "/nodes", report)
}

/// Tells leaves from wood.
fn detect(
    root: &Root,
    opened: &[(Placed, Surface<'_>)],
    options: &ImportOptions,
    materials: &mut Materials<'_, '_>,
    report: &mut ImportReport,
) -> Result<(Option<Mesh>, Foliage), Fault> {
    check_corners(opened)?;
    let frame = frame(opened, options, report);
    let mut parts = Vec::with_capacity(opened.len());
    for (placed, surface) in opened {
        let part = surface.load(root, placed, &frame, report)?;
        if !part.triangles.is_empty() {
            parts.push(part);
        }
    }
    let evidence = if options.foliage.is_empty() {
        Evidence::Guess
    } else {
        Evidence::Named
    };
    let (trunk, foliage) = mesh::sort(parts, evidence, materials, report)?;
    if foliage.groups.is_empty() && report.found("triangles") > 0 {
        let names = known_names(root);
        let message = format!("no foliage found; it can be named: {names}");
        report.add(ReportKind::Missing, 1, "/materials", message);
    }
    Ok((trunk, foliage))
}

/// Refuses a scene before it takes memory: a small file can place a mesh many times.
fn check_corners(opened: &[(Placed, Surface<'_>)]) -> Result<(), Fault> {
    let mut corners = 0_u64;
    for (placed, surface) in opened {
        corners += surface.corner_count();
        if corners > PLACED_CORNERS {
            return Err(Fault::new(
                placed.pointer(),
                format!(
                    "{corners} triangle corners so far exceed the limit of {PLACED_CORNERS}; simplify \
                     the meshes or place fewer"
                ),
            ));
        }
    }
    Ok(())
}
