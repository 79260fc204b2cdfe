//! `spinney inspect`: what a file holds.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::arguments::{InspectOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use crate::document::Document;
use crate::plant::import::{Format, ImportOptions, ImportReport, Imported, import};
use crate::plant::{LeafGroup, Plant, Prototype, SpeciesFile};
use crate::raster::Image;
use crate::report::Picture;
use crate::scene::{Forest, PlantSource, SceneFile};

/// Names and values, in the order of printing.
pub(super) type Facts = Vec<(&'static str, Value)>;

pub(super) fn inspect(
    options: &InspectOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let facts = match ending(&options.file).as_str() {
        "png" => image_facts(&options.file)?,
        "toml" => {
            let document = Document::read(&options.file)?;
            if document.text.contains("\"spinney.species/") {
                species_facts(&document)?
            } else {
                scene_facts(document)?
            }
        }
        "rls" | "xml" => species_facts(&Document::read(&options.file)?)?,
        _ => imported_facts(&options.file, &options.plant.import_options())?,
    };
    terminal.print(&show(&facts, shared.json))
}

/// Facts as text or JSON.
pub(super) fn show(facts: &Facts, json: bool) -> String {
    if json {
        let map: Map<String, Value> = facts
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone()))
            .collect();
        return format!("{:#}", Value::Object(map));
    }
    let widest = facts.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for (name, value) in facts {
        let lines: Vec<String> = match value {
            Value::Array(list) if list.iter().all(Value::is_number) => {
                let numbers: Vec<String> = list.iter().map(plain).collect();
                vec![numbers.join(" × ")]
            }
            Value::Array(list) => list.iter().map(plain).collect(),
            single => vec![plain(single)],
        };
        for (number, line) in lines.iter().enumerate() {
            let name = if number == 0 { *name } else { "" };
            text.push_str(&format!("{:widest$}  {line}\n", name.replace('_', " ")));
        }
    }
    text
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Object(map) => {
            let pairs: Vec<String> = map
                .iter()
                .map(|(name, value)| format!("{name} {}", plain(value)))
                .collect();
            pairs.join(", ")
        }
        Value::Array(list) => list.iter().map(plain).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

fn ending(path: &Path) -> String {
    path.extension()
        .map(|ending| ending.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

fn imported_facts(path: &Path, options: &ImportOptions) -> Result<Facts, CliError> {
    let Imported { plant, report } = import(path, options)?;
    let mut facts = plant_facts(&plant);
    let found = report.found.iter();
    let found: Map<String, Value> = found
        .map(|found| (found.what.to_owned(), found.count.into()))
        .collect();
    facts.insert(
        2,
        ("format", report.format.map_or("", Format::title).into()),
    );
    facts.insert(3, ("found", found.into()));
    facts.push(("own_file", report.native.into()));
    facts.push(("remarks", remarks(&report)));
    Ok(facts)
}

/// A number to its third place; nothing is never less than nothing.
fn rounded(value: f64) -> Value {
    json!((value * 1000.0).round() / 1000.0 + 0.0)
}

/// What a plant holds.
pub(super) fn plant_facts(plant: &Plant) -> Facts {
    let bounds = plant.bounds();
    let (size, center) = (bounds.size(), bounds.center());
    let metres = |value: f32| rounded(f64::from(value));
    let groups: Vec<Value> = plant
        .foliage()
        .groups
        .iter()
        .map(|group| {
            let shape = match &group.prototype {
                Prototype::Quad { .. } => "quad leaves".to_owned(),
                Prototype::Faces { triangles, .. } => {
                    format!("leaves of {} faces", triangles.len())
                }
                Prototype::Needle { .. } => "needles".to_owned(),
            };
            json!({
                "group": group.name,
                "shape": shape,
                "count": group.leaf_count(),
                "area_m2": rounded(group.area()),
            })
        })
        .collect();
    let skeleton = plant.skeleton();
    vec![
        ("kind", "plant".into()),
        ("name", plant.name().into()),
        ("leaves", plant.foliage().leaf_count().into()),
        ("quad_leaves", plant.foliage().quad_count().into()),
        ("foliage", groups.into()),
        (
            "trunk_triangles",
            plant
                .trunk()
                .map_or(0, |trunk| trunk.triangle_count())
                .into(),
        ),
        (
            "branches",
            skeleton
                .map_or(0, |skeleton| skeleton.branches.len())
                .into(),
        ),
        (
            "roots",
            skeleton
                .map_or(0, |skeleton| skeleton.roots().count())
                .into(),
        ),
        (
            "skeleton_nodes",
            skeleton.map_or(0, |skeleton| skeleton.nodes.len()).into(),
        ),
        (
            "leaf_area_m2",
            rounded(plant.foliage().groups.iter().map(LeafGroup::area).sum()),
        ),
        (
            "size_m",
            json!([metres(size.x), metres(size.y), metres(size.z)]),
        ),
        (
            "lowest_m",
            metres(if bounds.is_empty() { 0.0 } else { bounds.min.y }),
        ),
        (
            "center_m",
            json!({ "x": metres(center.x), "y": metres(center.y), "z": metres(center.z) }),
        ),
        ("plant_digest", plant.digest().to_string().into()),
    ]
}

fn image_facts(path: &Path) -> Result<Facts, CliError> {
    let picture = Picture::read(path)?;
    let image = Image {
        width: picture.width(),
        height: picture.height(),
        rgba: picture.rgba().to_vec(),
    };
    Ok(vec![
        ("kind", "image".into()),
        ("width", image.width.into()),
        ("height", image.height.into()),
        ("image_digest", image.digest().to_string().into()),
    ])
}

fn species_facts(document: &Document) -> Result<Facts, CliError> {
    let species = SpeciesFile::parse(document)?;
    let plant = species.grow(1).map_err(|source| CliError::Grow {
        file: document.file.clone(),
        source,
    })?;
    let mut facts = plant_facts(&plant);
    facts[0].1 = "species".into();
    facts.insert(2, ("latin", species.latin().into()));
    facts.push(("stop_leaves", species.stop_leaves().into()));
    facts.extend(species_remarks(&species));
    Ok(facts)
}

/// What a species file of another program has that has no counterpart here.
pub(super) fn species_remarks(species: &SpeciesFile) -> Facts {
    let report = species.report().into_iter();
    report.map(|report| ("remarks", remarks(report))).collect()
}

/// What an import has to say, entry by entry.
fn remarks(report: &ImportReport) -> Value {
    let entries = report.entries.iter();
    entries.map(|entry| entry.to_string()).collect()
}

fn scene_facts(document: Document) -> Result<Facts, CliError> {
    let file = document.file.clone();
    let SceneFile { scene, source } = SceneFile::parse(document)?;
    let mut missing: Vec<Value> = Vec::new();
    let mut look_for = |path: &str| {
        if !source.resolve(path).exists() {
            missing.push(format!("{file}: {path} does not exist").into());
        }
    };
    let single = scene.trees.iter().map(|tree| {
        let (PlantSource::Species(path) | PlantSource::File { path, .. }) = &tree.source;
        look_for(path);
        json!({ "from": path, "seed": tree.seed })
    });
    let mut trees: Vec<Value> = single.collect();
    for asked in scene.forests.iter().map(Forest::asked) {
        for species in &asked.species {
            look_for(&species.path);
            let (path, seed, count) = (&species.path, asked.plant_seed, asked.count);
            trees.push(json!({ "from": path, "seed": seed, "count": count }));
        }
    }
    Ok(vec![
        ("kind", "scene".into()),
        ("name", scene.name.clone().into()),
        ("size", json!([scene.size.width(), scene.size.height()])),
        ("samples", scene.samples.get().into()),
        ("frames", scene.frames.into()),
        ("trees", trees.into()),
        (
            "model",
            format!("{} {}", scene.model.name.name(), scene.model.mode.name()).into(),
        ),
        ("link", scene.device.link.clone().into()),
        ("card", scene.device.card.clone().into()),
        ("scene_digest", scene.digest().to_string().into()),
        ("warnings", missing.into()),
    ])
}
