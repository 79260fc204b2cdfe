//! The way from a file to a plant.

use super::accessor::Reader;
use super::buffers::Buffers;
use super::cards::{self, Pieces};
use super::container::{read, split};
use super::error::Fault;
use super::foliage::Leaves;
use super::material::{Materials, alpha_mode};
use super::native::{self, Source};
use super::record::POINTER;
use super::report::{ImportReport, ReportKind};
use super::scan::{self, Document};
use super::scene::{Names, Placed, known_names, place};
use super::surface::{self, Part, QUANTIZATION, Surface};
use super::{ImportError, ImportOptions, Imported};
use crate::limits::PLACED_CORNERS;
use crate::plant::{Foliage, Plant};
use gltf_json::Root;
use gltf_json::material::AlphaMode;
use std::collections::BTreeMap;
use std::path::Path;

/// Imports a `.glb` or `.gltf` file; buffers and images may lie beside it.
///
/// Foliage is what the options name, or else every material that is masked or blended and most of
/// whose triangles are cards: pairs that form a quadrilateral and share no position with others.
/// The rest is wood. A file that [`export_glb`](super::export_glb) wrote, and that was not edited,
/// gives the plant that was written, without guesses.
///
/// # Errors
///
/// When the file cannot be read, is damaged or hostile, exceeds a limit of this module, needs an
/// extension that is not supported, or nothing bears a name that the options hold.
pub fn import(path: &Path, options: &ImportOptions) -> Result<Imported, ImportError> {
    let file = path.display().to_string();
    let bytes = read(path)?;
    let folder = path.parent().unwrap_or_else(|| Path::new(""));
    import_bytes(&file, &bytes, Some(folder), options)
}

/// Imports a file that is in memory already. `file` names it in errors; `folder` is where its
/// buffers and images lie, without which it has to hold them itself.
///
/// # Errors
///
/// As [`import`].
pub fn import_bytes(
    file: &str,
    bytes: &[u8],
    folder: Option<&Path>,
    options: &ImportOptions,
) -> Result<Imported, ImportError> {
    let mut report = ImportReport::default();
    let container = split(file, bytes, &mut report)?;
    let document = scan::parse(file, container.json, container.json_offset)?;
    let in_file = |fault: Fault| fault.in_file(file);
    check_version(&document.root).map_err(in_file)?;
    note_extensions(&document, &mut report).map_err(in_file)?;
    let root = &document.root;
    note_unused(root, &mut report);
    let mut names = Names::new(&options.foliage);
    let placed = place(root, &mut names, &mut report).map_err(in_file)?;
    if let Some(name) = names.unknown() {
        return Err(ImportError::Name {
            file: file.to_owned(),
            name: name.to_owned(),
            known: known_names(root),
        });
    }
    let reader = Reader::new(root, Buffers::new(root, folder, container.binary));
    let opened = open_all(root, &reader, placed, &mut report).map_err(in_file)?;
    let mut materials = Materials::new(root, &reader);
    let guess = options.foliage.is_empty();
    if guess {
        let source = Source {
            root,
            reader: &reader,
            placed: &opened,
        };
        if let Some(plant) = native::read(&source, &mut materials, &mut report) {
            return Ok(Imported { plant, report });
        }
    }
    if !guess && native::has_record(root) {
        let message = "the record of the plant as written, since foliage is named: no skeleton";
        report.add(ReportKind::Dropped, 1, POINTER, message);
    }
    let (trunk, foliage) =
        detect(root, &opened, guess, &mut materials, &mut report).map_err(in_file)?;
    let name = Path::new(file)
        .file_stem()
        .unwrap_or_default()
        .to_string_lossy();
    let plant = Plant::new(name, None, trunk, foliage).map_err(|source| ImportError::Plant {
        file: file.to_owned(),
        source,
    })?;
    Ok(Imported { plant, report })
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
        report.primitives += 1;
        report.triangles += surface.corner_count() / 3;
        opened.push((placed, surface));
    }
    Ok(opened)
}

/// Tells leaves from wood.
fn detect(
    root: &Root,
    opened: &[(Placed, Surface<'_>)],
    guess: bool,
    materials: &mut Materials<'_, '_>,
    report: &mut ImportReport,
) -> Result<(Option<crate::plant::Mesh>, Foliage), Fault> {
    check_corners(opened)?;
    let mut parts = Vec::with_capacity(opened.len());
    for (placed, surface) in opened {
        let part = surface.load(placed, report)?;
        if part.triangles.is_empty() {
            continue;
        }
        let may_be_foliage = if guess {
            has_alpha(root, placed.material)?
        } else {
            placed.named
        };
        let pieces = may_be_foliage
            .then(|| cards::split(&part.positions, &part.coordinates, &part.triangles));
        parts.push((part, pieces));
    }
    if guess {
        keep_mostly_cards(root, &mut parts, report);
    }
    let mut leaves = Leaves::default();
    let mut wood = Vec::new();
    for (part, pieces) in parts {
        match pieces {
            Some(mut pieces) => {
                pieces.loosen(&part.positions, &part.coordinates);
                leaves.add(&part, &pieces, report);
            }
            None => wood.push(part),
        }
    }
    let trunk = super::trunk::join(wood, materials, report)?;
    let foliage = leaves.into_foliage(materials, report)?;
    if foliage.groups.is_empty() && report.triangles > 0 {
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

fn has_alpha(root: &Root, material: Option<usize>) -> Result<bool, Fault> {
    match material {
        None => Ok(false),
        Some(material) => Ok(alpha_mode(root, material)? != AlphaMode::Opaque),
    }
}

/// Takes the pieces away from materials that are not mostly cards: those are wood.
fn keep_mostly_cards(root: &Root, parts: &mut [(Part, Option<Pieces>)], report: &mut ImportReport) {
    let mut counts: BTreeMap<Option<usize>, (u64, u64)> = BTreeMap::new();
    for (part, pieces) in parts.iter() {
        if let Some(pieces) = pieces {
            let others: usize = pieces.others.iter().map(Vec::len).sum();
            let count = counts.entry(part.placed.material).or_default();
            count.0 += 2 * pieces.cards.len() as u64;
            count.1 += 2 * pieces.cards.len() as u64 + others as u64;
        }
    }
    for (&material, &(cards, all)) in &counts {
        let index = material.unwrap_or_default();
        let name = root.materials[index].name.as_deref().unwrap_or_default();
        let taken = if 2 * cards > all { "foliage" } else { "wood" };
        let message = format!(
            "material {name:?} has alpha and {cards} of {all} triangles are cards: taken as {taken}"
        );
        report.add(
            ReportKind::Guessed,
            1,
            format!("/materials/{index}"),
            message,
        );
    }
    for (part, pieces) in parts {
        let counted = counts.get(&part.placed.material);
        if counted.is_some_and(|&(cards, all)| 2 * cards <= all) {
            *pieces = None;
        }
    }
}
