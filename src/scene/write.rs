//! Scenes as text, with every default filled in, and as digest.

use crate::math::{Digest, Digester, Vec3};
use crate::plant::import::Reading;

use super::card_keys;
use super::grove_keys;
use super::paint_keys;
use super::value::BYTE_UNITS;
use super::{
    BranchChoice, Camera, CardOptions, CriterionName, Forest, ForestChoice, Golden, LeafAmount,
    ModelChoice, Occlusion, PlantSource, Projection, RecordWidth, SCHEMA, Scene, Simplifier,
    Terrain, Tree, TrunkMode, TrunkName, VertexFormat,
};

/// The scene as a file in which nothing is left to a default: `scene.resolved.toml`.
///
/// Reading it back gives an equal scene. Paths of species and trees are written as they are in the
/// scene, so they are relative to where the text is put.
#[must_use]
pub fn to_toml(scene: &Scene) -> String {
    let mut text = Text(String::new());
    text.key("schema", &quoted(SCHEMA));
    text.key("name", &quoted(&scene.name));
    text.key(
        "size",
        &format!("[{}, {}]", scene.size.width(), scene.size.height()),
    );
    text.key("samples", &scene.samples.get().to_string());
    text.key("frames", &scene.frames.to_string());
    text.key("seed", &scene.seed.to_string());
    text.key("background", &color(scene.background));
    for tree in &scene.trees {
        write_tree(&mut text, tree);
    }
    for forest in &scene.forests {
        write_forest(&mut text, forest);
    }
    if let Some(terrain) = &scene.terrain {
        write_terrain(&mut text, terrain);
    }
    write_camera(&mut text, &scene.camera);
    text.heading("[light]");
    text.key("direction", &triple(scene.light.direction));
    text.key("color", &triple(scene.light.color));
    text.key("ambient", &triple(scene.light.ambient));
    if let Some(shadow) = &scene.shadow {
        text.heading("[shadow]");
        text.key("size", &shadow.size.to_string());
        text.key("bias", &shadow.bias.to_string());
        if let Some(extent) = shadow.extent {
            text.key("extent", &extent.to_string());
        }
    }
    write_model(&mut text, &scene.model);
    card_keys::write(&mut text, &scene.cards);
    write_branches(&mut text, &scene.branches);
    paint_keys::write(&mut text, &scene.painting);
    if let Some(grove) = scene.grove {
        grove_keys::write(&mut text, grove);
    }
    text.heading("[device]");
    text.key("memory", &byte_size(scene.device.memory));
    text.key("link", &quoted(&scene.device.link));
    text.key("card", &quoted(&scene.device.card));
    if let Some(golden) = &scene.golden {
        write_golden(&mut text, golden);
    }
    text.0
}

impl Scene {
    /// The digest of what is asked for; comments, layout and the order of keys do not change it.
    ///
    /// BLAKE3 over the domain `spinney.scene/1`, then the fields in the order in which [`Scene`]
    /// and the types within declare them: integers up to 32 bits, counts and enums (by the order
    /// of their values) as `u32`, larger ones as `u64`, floats as their bits, texts and lists with
    /// their length as `u64` before them, an absent value as `0u32` and a present one after `1u32`,
    /// all little-endian. Left out is [`Tree::plant_digest`], which is an answer, not a question, and
    /// so are the places that a forest found.
    ///
    /// What came later stands at the end, after a text that names it, and only where it differs from
    /// its default: forests, terrain, cards, branches, painting, shadow, grove, and `selection` before the model's criterion, amount (by kind
    /// as `u32`), hysteresis and budget of bytes, which are not where the model is.
    /// [`ModelChoice::records`] and [`ModelChoice::vertices`] do so within their table.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut digester = Digester::new(SCHEMA);
        digester
            .text(&self.name)
            .u32(self.size.width())
            .u32(self.size.height())
            .u32(self.samples.get())
            .u32(self.frames)
            .u64(self.seed)
            .raw(&self.background)
            .u64(self.trees.len() as u64);
        for tree in &self.trees {
            digest_tree(&mut digester, tree);
        }
        digest_camera(&mut digester, &self.camera);
        digester
            .vec3(self.light.direction)
            .vec3(self.light.color)
            .vec3(self.light.ambient);
        digest_model(&mut digester, &self.model);
        digester
            .u64(self.device.memory)
            .text(&self.device.link)
            .text(&self.device.card);
        match &self.golden {
            None => _ = digester.u32(0),
            Some(golden) => digest_golden(digester.u32(1), golden),
        }
        for forest in &self.forests {
            digest_forest(digester.text("forest"), forest.asked());
        }
        if let Some(terrain) = &self.terrain {
            digest_terrain(digester.text("terrain"), terrain);
        }
        digest_selection(&mut digester, &self.model);
        digest_trunk(&mut digester, &self.model);
        if self.cards != CardOptions::USUAL {
            card_keys::digest(digester.text("cards"), &self.cards);
        }
        if self.branches != BranchChoice::USUAL {
            digest_branches(&mut digester, &self.branches);
        }
        if let Some(usual) = paint_keys::unlike_usual(&self.painting, self.seed) {
            paint_keys::digest(digester.text("painting"), usual);
        }
        if let Some(shadow) = &self.shadow {
            digester
                .text("shadow")
                .u32(shadow.size)
                .f32(shadow.bias)
                .u32(u32::from(shadow.extent.is_some()))
                .f32(shadow.extent.unwrap_or(0.0));
        }
        if let Some(grove) = self.grove {
            grove_keys::digest(digester.text("grove"), grove);
        }
        digester.finish()
    }
}

/// TOML as it grows.
pub(super) struct Text(String);

impl Text {
    pub(super) fn heading(&mut self, heading: &str) {
        self.0 += "\n";
        self.0 += heading;
        self.0 += "\n";
    }

    pub(super) fn key(&mut self, key: &str, value: &str) {
        self.0 += &format!("{key} = {value}\n");
    }
}

fn write_tree(text: &mut Text, tree: &Tree) {
    text.heading("[[tree]]");
    match &tree.source {
        PlantSource::Species(path) => text.key("species", &quoted(path)),
        PlantSource::File {
            path,
            foliage,
            reading,
        } => {
            text.key("file", &quoted(path));
            for (key, name) in told(reading) {
                text.key(key, &quoted(name));
            }
            let names: Vec<String> = foliage.iter().map(|name| quoted(name)).collect();
            text.key("foliage", &format!("[{}]", names.join(", ")));
        }
    }
    text.key("seed", &tree.seed.to_string());
    text.key("at", &triple(tree.at));
    text.key("turn", &tree.turn.to_string());
    text.key("scale", &tree.scale.to_string());
    if let Some(digest) = tree.plant_digest {
        text.key("plant_digest", &quoted(&digest.to_string()));
    }
}

/// The keys of what is said about reading a file, and their values.
fn told(reading: &Reading) -> impl Iterator<Item = (&'static str, &'static str)> {
    let format = reading.format.map(|format| ("format", format.name()));
    let up = reading.up.map(|up| ("up", up.name()));
    let unit = reading.unit.map(|unit| ("unit", unit.name()));
    format.into_iter().chain(up).chain(unit)
}

fn write_forest(text: &mut Text, forest: &Forest) {
    let asked = forest.asked();
    text.heading("[[forest]]");
    let species = asked.species.iter();
    let paths: Vec<String> = species.map(|species| quoted(&species.path)).collect();
    text.key("species", &format!("[{}]", paths.join(", ")));
    text.key("plant_seed", &asked.plant_seed.to_string());
    text.key("count", &asked.count.to_string());
    text.key("seed", &asked.seed.to_string());
    text.key("layout", &quoted(asked.layout.name()));
    let [x0, z0, x1, z1] = asked.area.corners();
    text.key("area", &format!("[{x0}, {z0}, {x1}, {z1}]"));
    text.key("spacing", &asked.spacing.to_string());
    let [least, greatest] = asked.scale;
    text.key("scale", &format!("[{least}, {greatest}]"));
    let digests = asked.species.iter().map(|species| species.plant_digest);
    if let Some(digests) = digests.collect::<Option<Vec<Digest>>>() {
        let digests = digests.iter().map(|digest| quoted(&digest.to_string()));
        let digests: Vec<String> = digests.collect();
        text.key("plant_digests", &format!("[{}]", digests.join(", ")));
    }
}

fn write_terrain(text: &mut Text, terrain: &Terrain) {
    text.heading("[terrain]");
    text.key("size", &terrain.size.to_string());
    text.key("cells", &terrain.cells.to_string());
    text.key("amplitude", &terrain.amplitude.to_string());
    text.key("wavelength", &terrain.wavelength.to_string());
    text.key("octaves", &terrain.octaves.to_string());
    text.key("seed", &terrain.seed.to_string());
    text.key("color", &color(terrain.color));
    text.key("steep_color", &color(terrain.steep_color));
}

fn write_camera(text: &mut Text, camera: &Camera) {
    text.heading("[camera]");
    match camera.projection() {
        Projection::Perspective {
            vertical_field_of_view,
        } => {
            text.key("projection", "\"perspective\"");
            text.key(
                "vertical_field_of_view",
                &vertical_field_of_view.to_string(),
            );
        }
        Projection::Orthographic { height } => {
            text.key("projection", "\"orthographic\"");
            text.key("height", &height.to_string());
        }
    }
    text.key("near", &camera.near().to_string());
    text.key("far", &camera.far().to_string());
    text.0 += "path = [\n";
    for key in camera.path() {
        text.0 += &format!(
            "  {{ frame = {}, eye = {}, target = {} }},\n",
            key.frame,
            triple(key.eye),
            triple(key.target)
        );
    }
    text.0 += "]\n";
}

fn write_model(text: &mut Text, model: &ModelChoice) {
    text.heading("[model]");
    text.key("name", &quoted(model.name.name()));
    text.key("mode", &quoted(model.mode.name()));
    text.key("detail", &quoted(model.detail.name()));
    text.key("d_min", &model.range.d_min().to_string());
    text.key("d_max", &model.range.d_max().to_string());
    text.key("extraction", &quoted(model.extraction.name()));
    text.key("gather", &quoted(model.gather.name()));
    text.key("records", &quoted(model.records.name()));
    text.key("vertices", &quoted(model.vertices.name()));
    text.key("occlusion", &quoted(model.occlusion.name()));
    text.key("simplifier", &quoted(model.simplifier.name()));
    if let Some(leaves) = model.stop_leaves {
        text.key("stop_leaves", &leaves.to_string());
    }
    if let Some(level) = model.level {
        text.key("level", &level.to_string());
    }
    text.key("criterion", &quoted(model.criterion.name()));
    match model.amount {
        None => {}
        Some(LeafAmount::Budget(leaves)) => text.key("leaf_budget", &leaves.to_string()),
        Some(LeafAmount::Share(share)) => text.key("leaf_share", &share.to_string()),
        Some(LeafAmount::PixelError(pixels)) => text.key("pixel_error", &pixels.to_string()),
    }
    text.key("hysteresis", &model.hysteresis.to_string());
    if let Some(bytes) = model.budget_bytes {
        text.key("budget_bytes", &bytes.to_string());
    }
    text.key("trunk", &quoted(model.trunk.name()));
    text.key("trunk_mode", &quoted(model.trunk_mode.name()));
    if let Some(level) = model.trunk_level {
        text.key("trunk_level", &level.to_string());
    }
    if let Some(triangles) = model.trunk_triangles {
        text.key("trunk_triangles", &triangles.to_string());
    }
}

fn write_branches(text: &mut Text, branches: &BranchChoice) {
    text.heading("[branches]");
    if let Some(error) = branches.error {
        text.key("error", &error.to_string());
    }
    text.key("pixel_error", &branches.pixel_error.to_string());
    text.key("finest", &branches.finest.to_string());
    text.key("coarsest", &branches.coarsest.to_string());
    text.key("shares", &quoted(branches.shares.name()));
    text.key("frames", &quoted(branches.frames.name()));
    text.key("torsion", &branches.torsion.to_string());
    text.key("needles", &quoted(branches.needles.name()));
    text.key("most_edges", &branches.most_edges.to_string());
    text.key("line_alpha", &quoted(branches.line_alpha.name()));
    text.key("line_normals", &quoted(branches.line_normals.name()));
    text.key("removal", &quoted(branches.removal.name()));
}

fn write_golden(text: &mut Text, golden: &Golden) {
    text.heading("[golden]");
    text.key(
        "size",
        &format!("[{}, {}]", golden.size.width(), golden.size.height()),
    );
    let frames: Vec<String> = golden.frames.iter().map(u32::to_string).collect();
    text.key("frames", &format!("[{}]", frames.join(", ")));
    text.key("tolerance", &golden.tolerance.to_string());
    if let Some(reason) = &golden.reason {
        text.key("reason", &quoted(reason));
    }
}

pub(super) fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn color([red, green, blue]: [u8; 3]) -> String {
    format!("\"#{red:02x}{green:02x}{blue:02x}\"")
}

fn triple(value: Vec3) -> String {
    format!("[{}, {}, {}]", value.x, value.y, value.z)
}

/// In the largest unit that divides it.
fn byte_size(bytes: u64) -> String {
    let (unit, factor) = BYTE_UNITS
        .into_iter()
        .find(|(_, factor)| bytes.is_multiple_of(*factor))
        .expect("every number is a whole number of bytes");
    format!("\"{} {unit}\"", bytes / factor)
}

fn digest_tree(digester: &mut Digester, tree: &Tree) {
    match &tree.source {
        PlantSource::Species(path) => _ = digester.u32(0).text(path),
        PlantSource::File {
            path,
            foliage,
            reading,
        } => {
            digester.u32(1).text(path).u64(foliage.len() as u64);
            for name in foliage {
                digester.text(name);
            }
            // As before these keys were, where none is said.
            for (key, name) in told(reading) {
                digester.text(key).text(name);
            }
        }
    }
    digester
        .u64(tree.seed)
        .vec3(tree.at)
        .f32(tree.turn)
        .f32(tree.scale);
}

fn digest_forest(digester: &mut Digester, asked: &ForestChoice) {
    digester.u64(asked.species.len() as u64);
    for species in &asked.species {
        digester.text(&species.path);
    }
    digester
        .u64(asked.plant_seed)
        .u32(asked.count)
        .u64(asked.seed)
        .u32(asked.layout as u32);
    for number in asked.area.corners() {
        digester.f32(number);
    }
    digester
        .f32(asked.spacing)
        .f32(asked.scale[0])
        .f32(asked.scale[1]);
}

fn digest_terrain(digester: &mut Digester, terrain: &Terrain) {
    digester
        .f32(terrain.size)
        .u32(terrain.cells)
        .f32(terrain.amplitude)
        .f32(terrain.wavelength)
        .u32(terrain.octaves)
        .u64(terrain.seed)
        .raw(&terrain.color)
        .raw(&terrain.steep_color);
}

fn digest_camera(digester: &mut Digester, camera: &Camera) {
    match camera.projection() {
        Projection::Perspective {
            vertical_field_of_view,
        } => _ = digester.u32(0).f32(vertical_field_of_view),
        Projection::Orthographic { height } => _ = digester.u32(1).f32(height),
    }
    digester
        .f32(camera.near())
        .f32(camera.far())
        .u64(camera.path().len() as u64);
    for key in camera.path() {
        digester.u32(key.frame).vec3(key.eye).vec3(key.target);
    }
}

fn digest_model(digester: &mut Digester, model: &ModelChoice) {
    digester
        .u32(model.name as u32)
        .u32(model.mode as u32)
        .u32(model.detail as u32)
        .f32(model.range.d_min())
        .f32(model.range.d_max())
        .u32(model.extraction as u32)
        .u32(model.gather as u32);
    match model.stop_leaves {
        None => _ = digester.u32(0),
        Some(leaves) => _ = digester.u32(1).u32(leaves),
    }
    match model.level {
        None => _ = digester.u32(0),
        Some(level) => _ = digester.u32(1).f32(level),
    }
    if model.records != RecordWidth::Wide {
        digester.text("records").u32(model.records as u32);
    }
    if model.vertices != VertexFormat::Float {
        digester.text("vertices").u32(model.vertices as u32);
    }
    if model.occlusion != Occlusion::None {
        digester.text("occlusion").u32(model.occlusion as u32);
    }
    if model.simplifier != Simplifier::LeafCollapse {
        digester.text("simplifier").u32(model.simplifier as u32);
    }
}

fn digest_selection(digester: &mut Digester, model: &ModelChoice) {
    let (criterion, amount) = (model.criterion, model.amount);
    let usual = criterion == CriterionName::Paper && amount.is_none();
    if usual && model.hysteresis == 0.0 && model.budget_bytes.is_none() {
        return;
    }
    digester.text("selection").u32(criterion as u32);
    match amount {
        None => _ = digester.u32(0),
        Some(LeafAmount::Budget(leaves)) => _ = digester.u32(1).u32(leaves),
        Some(LeafAmount::Share(share)) => _ = digester.u32(2).f32(share),
        Some(LeafAmount::PixelError(pixels)) => _ = digester.u32(3).f32(pixels),
    }
    digester.f32(model.hysteresis);
    match model.budget_bytes {
        None => _ = digester.u32(0),
        Some(bytes) => _ = digester.u32(1).u64(bytes),
    }
}

/// At the end, and only where something is asked for: scenes that are older keep their digest.
fn digest_trunk(digester: &mut Digester, model: &ModelChoice) {
    let ModelChoice {
        trunk,
        trunk_mode,
        trunk_level,
        trunk_triangles,
        ..
    } = *model;
    let usual = trunk == TrunkName::Full && trunk_mode == TrunkMode::Device;
    if usual && trunk_level.is_none() && trunk_triangles.is_none() {
        return;
    }
    digester
        .text("trunk")
        .u32(trunk as u32)
        .u32(trunk_mode as u32);
    match trunk_level {
        None => _ = digester.u32(0),
        Some(level) => _ = digester.u32(1).f32(level),
    }
    match trunk_triangles {
        None => _ = digester.u32(0),
        Some(triangles) => _ = digester.u32(1).u32(triangles),
    }
}

fn digest_branches(digester: &mut Digester, branches: &BranchChoice) {
    let error = branches.error;
    digester
        .text("branches")
        .u32(u32::from(error.is_some()))
        .f32(error.unwrap_or(0.0))
        .f32(branches.pixel_error)
        .f32(branches.finest)
        .f32(branches.coarsest)
        .u32(branches.shares as u32)
        .u32(branches.frames as u32)
        .f32(branches.torsion)
        .u32(branches.needles as u32)
        .u32(branches.most_edges)
        .u32(branches.line_alpha as u32)
        .u32(branches.line_normals as u32)
        .u32(branches.removal as u32);
}

fn digest_golden(digester: &mut Digester, golden: &Golden) {
    digester
        .u32(golden.size.width())
        .u32(golden.size.height())
        .u64(golden.frames.len() as u64);
    for frame in &golden.frames {
        digester.u32(*frame);
    }
    digester.u32(golden.tolerance.into());
    match &golden.reason {
        None => _ = digester.u32(0),
        Some(reason) => _ = digester.u32(1).text(reason),
    }
}
