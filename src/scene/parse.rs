//! From tables to a [`Scene`]: what no single key can say.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::document::{Document, DocumentError};
use crate::limits;
use crate::math::Digest;
use crate::plant::import::{Format, Reading, Unit, UpAxis};

use super::Shadow;
use super::card_keys;
use super::grove_keys;
use super::paint_keys;
use super::reader::{Reader, parse_tables};
use super::value::is_name;
use super::{
    Area, BranchAlpha, BranchChoice, BranchFrames, BranchLines, BranchRemoval, BranchShares,
    Camera, CameraKey, CriterionName, DetailKind, DetailRange, DeviceChoice, Extraction, Forest,
    ForestChoice, ForestSpecies, Gather, Golden, Layout, LeafAmount, Light, Mode, ModelChoice,
    ModelName, NeedleMerging, NoRoom, Occlusion, PlantSource, Projection, RecordWidth, SampleCount,
    Scene, SceneError, Simplifier, Terrain, Tree, TrunkMode, TrunkName, VertexFormat,
};

/// A scene with the file it came from.
#[derive(Debug, Clone)]
pub struct SceneFile {
    /// What the file says.
    pub scene: Scene,
    /// Where it says it.
    pub source: SceneSource,
}

impl SceneFile {
    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// As [`Scene::read`].
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        Self::parse(Document::read(path)?)
    }

    /// The scene that a document says.
    ///
    /// # Errors
    ///
    /// When it says something wrong: at which line and column, what was found and what would be
    /// right.
    pub fn parse(document: Document) -> Result<Self, SceneError> {
        let root = parse_tables(&document)?;
        let scene = scene(&Reader::new(&document, &root)?, &document.file)?;
        let mut offsets = BTreeMap::new();
        collect_offsets("", root.get_ref(), &mut offsets);
        drop(root);
        let source = SceneSource { document, offsets };
        Ok(Self { scene, source })
    }
}

/// Where a scene file says what: for checks that only a later stage can make.
#[derive(Debug, Clone)]
pub struct SceneSource {
    document: Document,
    offsets: BTreeMap<String, usize>,
}

impl SceneSource {
    /// An error at a key such as `device.link` or `tree[1].species`; where the file lacks the key,
    /// at the nearest table around it, or at the beginning.
    #[must_use]
    pub fn error(&self, key: &str, message: impl Into<String>) -> DocumentError {
        let mut path = key;
        let offset = loop {
            if let Some(offset) = self.offsets.get(path) {
                break *offset;
            }
            match path.rfind(['.', '[']) {
                Some(end) => path = &path[..end],
                None => break 0,
            }
        };
        self.document.error(offset, message)
    }

    /// A path of the scene as one that can be opened: relative to the scene file's folder.
    #[must_use]
    pub fn resolve(&self, path: &str) -> PathBuf {
        let file = Path::new(&self.document.file);
        file.parent().unwrap_or(Path::new("")).join(path)
    }
}

/// Where each value starts, by its path: `tree[1].at`. Nesting is bounded by the parser.
fn collect_offsets(prefix: &str, table: &DeTable<'_>, offsets: &mut BTreeMap<String, usize>) {
    for (key, value) in table {
        let path = match prefix {
            "" => key.get_ref().to_string(),
            _ => format!("{prefix}.{}", key.get_ref()),
        };
        match value.get_ref() {
            DeValue::Table(below) => collect_offsets(&path, below, offsets),
            DeValue::Array(entries) => {
                for (index, entry) in entries.iter().enumerate() {
                    let path = format!("{path}[{index}]");
                    if let DeValue::Table(below) = entry.get_ref() {
                        collect_offsets(&path, below, offsets);
                    }
                    offsets.insert(path, entry.span().start);
                }
            }
            _ => {}
        }
        offsets.insert(path, value.span().start);
    }
}

fn scene(root: &Reader<'_>, file: &str) -> Result<Scene, SceneError> {
    // First of all: another schema may know other keys.
    root.have::<String>("schema")?;
    let seed = root.have("seed")?;
    let frames = small(root.have("frames")?);
    let trees = root.tables("tree")?;
    let terrain = match root.table("terrain")? {
        Some(table) => Some(terrain(&table, seed)?),
        None => None,
    };
    let mut standing = trees.len();
    let mut forests = Vec::new();
    for table in root.tables("forest")? {
        let forest = forest(&table, seed, terrain.as_ref(), standing)?;
        standing += forest.tree_count();
        forests.push(forest);
    }
    if standing == 0 {
        return Err(root.refuse("tree", "a [[tree]] or a [[forest]]"));
    }
    let below = |name| -> Result<Reader<'_>, SceneError> {
        Ok(root.table(name)?.expect("required, or empty by default"))
    };
    let samples = small(root.have("samples")?);
    let model = model(&below("model")?)?;
    let shadow = match root.table("shadow")? {
        Some(_) if model.mode == Mode::Device => {
            let wanted =
                "nothing, since `model.mode` \"device\" leaves out what the camera does not see";
            return Err(root.refuse("shadow", wanted));
        }
        Some(table) => Some(shadow(&table)?),
        None => None,
    };
    let grove = grove_keys::read(root, &model, &forests)?;
    Ok(Scene {
        name: root.get("name")?.unwrap_or_else(|| name_of(file)),
        size: root.have("size")?,
        samples: SampleCount::new(samples).expect("the table of keys allows 1 and 4"),
        frames,
        seed,
        background: root.have("background")?,
        trees: trees
            .iter()
            .map(|table| tree(table, seed))
            .collect::<Result<_, _>>()?,
        forests,
        terrain,
        camera: camera(&below("camera")?)?,
        light: light(&below("light")?)?,
        shadow,
        cards: card_keys::read(&below("cards")?, &model)?,
        branches: branches(&below("branches")?, &model)?,
        painting: paint_keys::read(&below("painting")?, seed)?,
        grove,
        model,
        device: device(&below("device")?)?,
        golden: match root.table("golden")? {
            Some(table) => Some(golden(&table, frames)?),
            None => None,
        },
    })
}

/// The file's name without its ending; what a name cannot hold becomes `-`.
fn name_of(file: &str) -> String {
    let stem = Path::new(file).file_stem().unwrap_or_default();
    let name: String = stem
        .to_string_lossy()
        .chars()
        .map(|c| match c {
            '.' | '_' => c,
            _ if c.is_ascii_alphanumeric() => c,
            _ => '-',
        })
        .take(64)
        .collect();
    if is_name(&name) {
        name
    } else {
        "scene".to_owned()
    }
}

fn tree(table: &Reader<'_>, scene_seed: u64) -> Result<Tree, SceneError> {
    let source = match (table.get("species")?, table.get("file")?) {
        (Some(species), None) => PlantSource::Species(species),
        (None, Some(path)) => PlantSource::File {
            path,
            foliage: table.get("foliage")?.unwrap_or_default(),
            reading: reading(table)?,
        },
        (Some(_), Some(_)) => {
            return Err(table.refuse("file", "nothing, since the tree has `species`"));
        }
        (None, None) => return Err(table.refuse("species", "either `species` or `file`")),
    };
    if matches!(source, PlantSource::Species(_))
        && let Some(key) = FILE_KEYS.into_iter().find(|key| table.has(key))
    {
        return Err(table.refuse(key, "nothing, since the tree has `species`"));
    }
    Ok(Tree {
        source,
        seed: table.get("seed")?.unwrap_or(scene_seed),
        at: table.have("at")?,
        turn: table.have("turn")?,
        scale: table.have("scale")?,
        plant_digest: table.get("plant_digest")?,
    })
}

/// Keys that go with `file` alone.
const FILE_KEYS: [&str; 4] = ["foliage", "format", "up", "unit"];

fn reading(table: &Reader<'_>) -> Result<Reading, SceneError> {
    let name = |key: &str| table.get::<String>(key);
    Ok(Reading {
        format: name("format")?.and_then(|name| Format::from_name(&name)),
        up: name("up")?.and_then(|name| UpAxis::from_name(&name)),
        unit: name("unit")?.and_then(|name| Unit::from_name(&name)),
    })
}

/// A forest beside `standing` trees.
fn forest(
    table: &Reader<'_>,
    scene_seed: u64,
    terrain: Option<&Terrain>,
    standing: usize,
) -> Result<Forest, SceneError> {
    let paths: Vec<String> = table.have("species")?;
    let count = small(table.have("count")?);
    let most = limits::SCENE_TREES - standing;
    if paths.len() * count as usize > most {
        let wanted = format!("at most {most} trees of all species, as the scene has {standing}");
        return Err(table.refuse("count", &wanted));
    }
    let digests: Option<Vec<Digest>> = table.get("plant_digests")?;
    if let Some(digests) = digests.as_ref().filter(|list| list.len() != paths.len()) {
        let wanted = format!(
            "one digest a species: {}, not {}",
            paths.len(),
            digests.len()
        );
        return Err(table.refuse("plant_digests", &wanted));
    }
    let area: Area = table.have("area")?;
    if let Some(ground) = terrain {
        let [x0, z0, x1, z1] = area.corners();
        let rim = ground.area();
        if !rim.contains(x0, z0) || !rim.contains(x1, z1) {
            let half = 0.5 * ground.size;
            let wanted = format!("an area of the terrain, whose corners are -{half} and {half}");
            return Err(table.refuse("area", &wanted));
        }
    }
    let species = paths.into_iter().enumerate();
    let species = species.map(|(number, path)| ForestSpecies {
        path,
        plant_digest: digests.as_ref().map(|list| list[number]),
    });
    let choice = ForestChoice {
        species: species.collect(),
        plant_seed: table.get("plant_seed")?.unwrap_or(scene_seed),
        count,
        seed: table.get("seed")?.unwrap_or(scene_seed),
        layout: Layout::from_name(&table.have::<String>("layout")?)
            .expect("the table of keys allows these names only"),
        area,
        spacing: table.have("spacing")?,
        scale: table.have("scale")?,
    };
    Forest::new(choice).map_err(|NoRoom { fit, wanted }| {
        let wanted = format!("fewer: of {wanted} trees only {fit} fit at this `spacing`");
        table.refuse("count", &wanted)
    })
}

fn terrain(table: &Reader<'_>, scene_seed: u64) -> Result<Terrain, SceneError> {
    let color = table.have("color")?;
    Ok(Terrain {
        size: table.have("size")?,
        cells: small(table.have("cells")?),
        amplitude: table.have("amplitude")?,
        wavelength: table.have("wavelength")?,
        octaves: small(table.have("octaves")?),
        seed: table.get("seed")?.unwrap_or(scene_seed),
        color,
        steep_color: table.get("steep_color")?.unwrap_or(color),
    })
}

fn camera(table: &Reader<'_>) -> Result<Camera, SceneError> {
    let orthographic = table.have::<String>("projection")? == "orthographic";
    let angle = table.have("vertical_field_of_view")?;
    let projection = match (orthographic, table.get("height")?) {
        (true, _) if table.has("vertical_field_of_view") => {
            let wanted = "nothing, since `projection` is orthographic";
            return Err(table.refuse("vertical_field_of_view", wanted));
        }
        (true, Some(height)) => Projection::Orthographic { height },
        (true, None) => {
            let wanted = "a height in metres, since `projection` is orthographic";
            return Err(table.refuse("height", wanted));
        }
        (false, None) => Projection::Perspective {
            vertical_field_of_view: angle,
        },
        (false, Some(_)) => {
            return Err(table.refuse("height", "nothing, since `projection` is perspective"));
        }
    };
    let (near, far) = (table.have("near")?, table.have("far")?);
    if near >= far {
        return Err(table.refuse("far", &format!("more than `near`, which is {near}")));
    }
    let mut path: Vec<CameraKey> = Vec::new();
    for entry in table.tables("path")? {
        let key = CameraKey {
            frame: small(entry.have("frame")?),
            eye: entry.have("eye")?,
            target: entry.have("target")?,
        };
        if let Some(before) = path.last().filter(|before| before.frame >= key.frame) {
            let wanted = format!("more than {}, the frame of the key before it", before.frame);
            return Err(entry.refuse("frame", &wanted));
        }
        if (key.target - key.eye).try_normalize().is_none() {
            return Err(entry.refuse("target", "another point than `eye`"));
        }
        path.push(key);
    }
    Camera::new(projection, near, far, path)
}

fn light(table: &Reader<'_>) -> Result<Light, SceneError> {
    let light = Light {
        direction: table.have("direction")?,
        color: table.have("color")?,
        ambient: table.have("ambient")?,
    };
    if light.direction.try_normalize().is_none() {
        return Err(table.refuse("direction", "a direction, which has a length"));
    }
    Ok(light)
}

fn shadow(table: &Reader<'_>) -> Result<Shadow, SceneError> {
    Ok(Shadow {
        size: small(table.have("size")?),
        bias: table.have("bias")?,
        extent: table.get("extent")?,
    })
}

fn model(table: &Reader<'_>) -> Result<ModelChoice, SceneError> {
    /// The table of keys holds the same names as the type.
    const NAMED: &str = "the table of keys allows these names only";
    let name = |key| table.have::<String>(key);
    let (d_min, d_max) = (table.have("d_min")?, table.have("d_max")?);
    let Some(range) = DetailRange::new(d_min, d_max) else {
        return Err(table.refuse("d_max", &format!("more than `d_min`, which is {d_min}")));
    };
    let model = ModelName::from_name(&name("name")?).expect(NAMED);
    let mode = match table.get::<String>("mode")? {
        None => model.modes()[0],
        Some(mode) => Mode::from_name(&mode).expect(NAMED),
    };
    if !model.modes().contains(&mode) {
        let names: Vec<String> = model
            .modes()
            .iter()
            .map(|mode| format!("{:?}", mode.name()))
            .collect();
        let wanted = format!("a mode of {:?}: {}", model.name(), names.join(" or "));
        return Err(table.refuse("mode", &wanted));
    }
    let given: Vec<&str> = ["level", "leaf_budget", "leaf_share", "pixel_error"]
        .into_iter()
        .filter(|key| table.has(key))
        .collect();
    if let [first, second, ..] = given[..] {
        let wanted = format!("nothing, since `{first}` says how much detail");
        return Err(table.refuse(second, &wanted));
    }
    if !model.shows_leaves() {
        for key in ["leaf_budget", "leaf_share", "pixel_error"] {
            if table.has(key) {
                let wanted = format!("nothing, since {:?} shows no leaves", model.name());
                return Err(table.refuse(key, &wanted));
            }
        }
    }
    let trunk = TrunkName::from_name(&name("trunk")?).expect(NAMED);
    let trunk_mode = match table.get::<String>("trunk_mode")? {
        None => trunk.modes()[0],
        Some(mode) => TrunkMode::from_name(&mode).expect(NAMED),
    };
    if !trunk.modes().contains(&trunk_mode) {
        let names = trunk
            .modes()
            .iter()
            .map(|mode| format!("{:?}", mode.name()));
        let names: Vec<String> = names.collect();
        let wanted = format!("a mode of {:?}: {}", trunk.name(), names.join(" or "));
        return Err(table.refuse("trunk_mode", &wanted));
    }
    let budget = table.get("leaf_budget")?.map(small).map(LeafAmount::Budget);
    let share = table.get("leaf_share")?.map(LeafAmount::Share);
    let error = table.get("pixel_error")?.map(LeafAmount::PixelError);
    Ok(ModelChoice {
        name: model,
        mode,
        detail: DetailKind::from_name(&name("detail")?).expect(NAMED),
        range,
        extraction: Extraction::from_name(&name("extraction")?).expect(NAMED),
        gather: Gather::from_name(&name("gather")?).expect(NAMED),
        records: RecordWidth::from_name(&name("records")?).expect(NAMED),
        vertices: VertexFormat::from_name(&name("vertices")?).expect(NAMED),
        occlusion: Occlusion::from_name(&name("occlusion")?).expect(NAMED),
        simplifier: Simplifier::from_name(&name("simplifier")?).expect(NAMED),
        stop_leaves: table.get("stop_leaves")?.map(small),
        level: table.get("level")?,
        criterion: CriterionName::from_name(&name("criterion")?).expect(NAMED),
        amount: budget.or(share).or(error),
        hysteresis: table.have("hysteresis")?,
        budget_bytes: table.get("budget_bytes")?,
        trunk,
        trunk_mode,
        trunk_level: table.get("trunk_level")?,
        trunk_triangles: table.get("trunk_triangles")?.map(small),
    })
}

fn branches(table: &Reader<'_>, model: &ModelChoice) -> Result<BranchChoice, SceneError> {
    /// The table of keys holds the same names as the type.
    const NAMED: &str = "the table of keys allows these names only";
    let name = |key| table.have::<String>(key);
    let (finest, coarsest) = (table.have("finest")?, table.have("coarsest")?);
    if finest >= coarsest {
        let wanted = format!("more than `finest`, which is {finest}");
        return Err(table.refuse("coarsest", &wanted));
    }
    let removal = BranchRemoval::from_name(&name("removal")?).expect(NAMED);
    if removal == BranchRemoval::Volume && model.trunk_mode == TrunkMode::Skeleton {
        let wanted = "\"distance\", since the device knows no other order in mode \"skeleton\"";
        return Err(table.refuse("removal", wanted));
    }
    Ok(BranchChoice {
        error: table.get("error")?,
        pixel_error: table.have("pixel_error")?,
        finest,
        coarsest,
        shares: BranchShares::from_name(&name("shares")?).expect(NAMED),
        frames: BranchFrames::from_name(&name("frames")?).expect(NAMED),
        torsion: table.have("torsion")?,
        needles: NeedleMerging::from_name(&name("needles")?).expect(NAMED),
        most_edges: small(table.have("most_edges")?),
        line_alpha: BranchAlpha::from_name(&name("line_alpha")?).expect(NAMED),
        line_normals: BranchLines::from_name(&name("line_normals")?).expect(NAMED),
        removal,
    })
}

fn device(table: &Reader<'_>) -> Result<DeviceChoice, SceneError> {
    Ok(DeviceChoice {
        memory: table.have("memory")?,
        link: table.have("link")?,
        card: table.have("card")?,
    })
}

fn golden(table: &Reader<'_>, frames: u32) -> Result<Golden, SceneError> {
    let golden = Golden {
        size: table.have("size")?,
        frames: table
            .have::<Vec<u64>>("frames")?
            .into_iter()
            .map(small)
            .collect(),
        tolerance: u8::try_from(table.have::<u64>("tolerance")?)
            .expect("the table of keys allows 0 to 255"),
        reason: table.get("reason")?,
    };
    if golden.frames.iter().any(|frame| *frame >= frames) {
        let wanted = format!("frames below {frames}, the scene's count");
        return Err(table.refuse("frames", &wanted));
    }
    match (golden.tolerance, &golden.reason) {
        (0, Some(_)) => Err(table.refuse("reason", "nothing, since `tolerance` is 0")),
        (1.., None) => Err(table.refuse("reason", "a reason, since `tolerance` is above 0")),
        _ => Ok(golden),
    }
}

/// An integer whose key has a bound far below 2³².
pub(super) fn small(value: u64) -> u32 {
    u32::try_from(value).expect("the table of keys bounds it below 2^32")
}
