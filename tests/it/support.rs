//! Small random crowns, devices and walks for the contracts; property tests that tell how many
//! cases they tried.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use spinney::document::Document;
use spinney::gpu::DeviceDescriptor;
use spinney::math::{Draws, Stream, Vec2, Vec3, det, index_u32, index_usize};
use spinney::models::{
    Crown, Extraction, Gather, Kind, LeafFormat, Model, ModelOptions, Occlusion, State, Trunk,
    TrunkKind, TrunkLevel,
};
use spinney::plant::{Foliage, LeafGroup, Material, Mesh, NO_BRANCH, Plant, Prototype, Texture};
use spinney::raster::Image;
use spinney::run::{Silent, World};
use spinney::scene::{CardOptions, PaintOptions, Scene, SceneFile};
use spinney::simplify::{Collapse, CollapseSequence, hand_on_areas};
use spinney::testkit::Tally;
pub(crate) use spinney::testkit::{DeviceModel, Stage};

/// Counts what a property test tried, and says so at its end on standard error, past the test
/// harness, which would swallow it.
#[derive(Debug)]
pub(crate) struct Cases {
    name: &'static str,
    cases: Cell<u64>,
    tally: Cell<Tally>,
}

impl Cases {
    pub(crate) fn of(name: &'static str) -> Self {
        Self {
            name,
            cases: Cell::default(),
            tally: Cell::default(),
        }
    }

    pub(crate) fn one(&self) {
        self.cases.set(self.cases.get() + 1);
    }

    /// Adds checks of laws.
    pub(crate) fn checked(&self, tally: &Tally) {
        let mut sum = self.tally.get();
        sum.add(tally);
        self.tally.set(sum);
    }
}

impl Drop for Cases {
    fn drop(&mut self) {
        let (name, cases, tally) = (self.name, self.cases.get(), self.tally.get());
        let laws = if tally == Tally::default() {
            String::new()
        } else {
            format!("; checks: {tally}")
        };
        // Nobody is left to be told if this fails.
        _ = writeln!(std::io::stderr(), "{name}: {cases} cases{laws}");
    }
}

/// `proptest!`, each test of which says at its end how many cases it tried.
macro_rules! properties {
    (
        #![proptest_config($config:expr)]
        $($(#[$meta:meta])* fn $name:ident($($case:pat in $strategy:expr),+ $(,)?) $body:block)*
    ) => {$(
        $(#[$meta])*
        fn $name() {
            let name = concat!(module_path!(), "::", stringify!($name));
            let cases = $crate::support::Cases::of(name);
            let config = proptest::test_runner::Config {
                test_name: Some(name),
                ..$config
            };
            proptest::proptest!(config, |($($case in $strategy),+)| {
                $body
                // Here come neither cases that fail nor those that an assumption refused.
                cases.one();
            });
        }
    )*};
    ($($(#[$meta:meta])* fn $name:ident($($case:tt)+) $body:block)*) => {
        $crate::support::properties! {
            #![proptest_config(proptest::test_runner::Config::default())]
            $($(#[$meta])* fn $name($($case)+) $body)*
        }
    };
}
pub(crate) use properties;

/// A crown of `leaves` random quads in two groups with a random history of collapses that leaves
/// about `roots` of them.
pub(crate) fn random_crown(seed: u64, leaves: u32, roots: u32) -> Arc<Crown> {
    let plant = Plant::new("random", None, None, random_foliage(seed, leaves));
    let sequence = random_sequence(seed, leaves, leaves / 2, roots);
    Arc::new(Crown::new(Arc::new(plant.expect("sound parts")), sequence))
}

/// The same with a group of four leaves of three faces between the groups of quads.
pub(crate) fn with_faces(crown: &Crown) -> Arc<Crown> {
    let mut foliage = crown.plant().foliage().clone();
    let mut draws = Stream::new(u64::from(crown.sequence().original_count()), 5).draws();
    let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
    let mut positions = Vec::new();
    for _ in 0..4 {
        let center = 0.7 * vector();
        positions.extend((0..5).map(|_| center + 0.4 * vector()));
    }
    let mut texture_coordinates = Prototype::WHOLE_IMAGE.to_vec();
    texture_coordinates.push(Vec2::new(0.5, 0.5));
    let group = LeafGroup {
        name: "meshes".to_owned(),
        prototype: Prototype::Faces {
            texture_coordinates,
            triangles: vec![[0, 1, 2], [2, 3, 0], [4, 0, 1]],
        },
        positions,
        owners: vec![NO_BRANCH; 4],
        ..foliage.groups[0].clone()
    };
    foliage.groups.insert(1, group);
    let plant = Plant::new("mixed", None, None, foliage).expect("sound parts");
    Arc::new(Crown::new(Arc::new(plant), crown.sequence().clone()))
}

/// The same with a [random trunk](random_trunk), all of which may go.
pub(crate) fn random_tree(seed: u64, leaves: u32, roots: u32) -> (Arc<Crown>, Arc<Trunk>) {
    let (mesh, foliage) = (random_mesh(seed), random_foliage(seed, leaves));
    let plant = Plant::new("tree", None, Some(mesh), foliage).expect("sound parts");
    let plant = Arc::new(plant);
    let trunk = Trunk::of(&plant, Some(0)).expect("it has a trunk");
    let sequence = random_sequence(seed, leaves, leaves / 2, roots);
    (Arc::new(Crown::new(plant, sequence)), Arc::new(trunk))
}

/// Random quads in two groups.
fn random_foliage(seed: u64, leaves: u32) -> Foliage {
    let mut draws = Stream::new(seed, 1).draws();
    let split = leaves / 2;
    let group = |count: u32, color: [f32; 4], draws: &mut Draws| {
        let mut positions = Vec::new();
        for _ in 0..count {
            let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
            let (center, side, up) = (vector(), 0.3 * vector(), 0.3 * vector());
            positions.extend([
                center - side,
                center + side,
                center + side + up,
                center - side + up,
            ]);
        }
        LeafGroup {
            name: "leaves".to_owned(),
            prototype: Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            material: Material {
                name: "leaf".to_owned(),
                base_color: color,
                texture: Some(disc_texture()),
                alpha_cutoff: 0.5,
            },
            positions,
            owners: vec![NO_BRANCH; count as usize],
        }
    };
    let groups = vec![
        group(split, [0.2, 0.8, 0.1, 1.0], &mut draws),
        group(leaves - split, [0.9, 0.5, 0.1, 1.0], &mut draws),
    ];
    Foliage { groups }
}

/// The same leaves along the same collapses, which take one leaf away each and let the other grow.
pub(crate) fn pruned(crown: &Crown) -> Arc<Crown> {
    let collapses = crown.sequence().collapses().iter();
    let pairs: Vec<[u32; 2]> = collapses.map(|collapse| collapse.old).collect();
    let sequence = hand_on_areas(crown.plant().foliage(), &pairs, None).expect("a sound history");
    Arc::new(Crown::new(Arc::clone(crown.plant()), sequence))
}

/// Random collapses of leaves of the same group, each new leaf with random corners of the two.
pub(crate) fn random_sequence(seed: u64, leaves: u32, split: u32, roots: u32) -> CollapseSequence {
    let mut draws = Stream::new(seed, 2).draws();
    let mut corners: Vec<[u32; 4]> = (0..leaves)
        .map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role))
        .collect();
    let mut visible = [(0..split).collect::<Vec<u32>>(), (split..leaves).collect()];
    let mut collapses = Vec::new();
    while visible.iter().map(Vec::len).sum::<usize>() > roots as usize {
        let side = usize::from(draws.below(2) == 1);
        let side = if visible[side].len() > 1 {
            side
        } else {
            1 - side
        };
        let list = &mut visible[side];
        if list.len() < 2 {
            break;
        }
        let mut take = || list.swap_remove(index_usize(draws.below(list.len() as u64)));
        let old = [take(), take()];
        let choice = 1 + draws.below(14);
        let pair = old.map(|leaf| corners[leaf as usize]);
        let new = [0, 1, 2, 3].map(|role| pair[(choice >> role & 1) as usize][role]);
        list.push(index_u32(corners.len()));
        corners.push(new);
        collapses.push(Collapse { old, cost: 0.0 });
    }
    CollapseSequence::new(leaves, corners, collapses).expect("a sound history")
}

/// A disc on 8 × 8 texels.
fn disc_texture() -> Texture {
    let texel = |index: i32| {
        let (x, y) = (2 * (index % 8) - 7, 2 * (index / 8) - 7);
        [255, 255, 255, if x * x + y * y < 60 { 255 } else { 0 }]
    };
    Texture::new(8, 8, (0..64).flat_map(texel).collect()).expect("64 texels")
}

/// A trunk of up to three parts, tubes and patches, all of which may go. Corners lie on a lattice, so
/// that triangles touch, cross, tie and lose their area; some positions have two vertices.
pub(crate) fn random_trunk(seed: u64) -> Arc<Trunk> {
    let mesh = random_mesh(seed);
    let plant = Plant::new("trunk", None, Some(mesh), Foliage::default()).expect("sound parts");
    Arc::new(Trunk::of(&Arc::new(plant), Some(0)).expect("it has a trunk"))
}

pub(crate) fn random_mesh(seed: u64) -> Mesh {
    let mut draws = Stream::new(seed, 4).draws();
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        texture_coordinates: Vec::new(),
        indices: Vec::new(),
        material: Material {
            name: "bark".to_owned(),
            base_color: [0.9, 0.7, 0.5, 1.0],
            texture: None,
            alpha_cutoff: 0.0,
        },
    };
    for _ in 0..1 + draws.below(3) {
        let tube = draws.below(2) == 0;
        random_part(&mut mesh, tube, &mut draws);
    }
    mesh
}

/// Rows of vertices; a tube closes each row, and its last row with a fan.
fn random_part(mesh: &mut Mesh, tube: bool, draws: &mut Draws) {
    let (rows, columns) = (2 + draws.below(3), 3 + draws.below(3));
    // Every sixth of a unit, or every thousandth.
    let cells = if draws.below(2) == 0 { 6.0 } else { 1000.0 };
    let at = Vec3::new(draws.signed(), draws.signed(), draws.signed()) * 0.6;
    let first = index_u32(mesh.positions.len());
    let mut vertex = |mesh: &mut Mesh, place: Vec3| {
        let normal = Vec3::new(draws.signed(), draws.signed(), draws.signed());
        mesh.positions.push((place * cells).round() / cells);
        mesh.normals.push(normal.normalize_or(Vec3::Y));
        mesh.texture_coordinates
            .push(Vec2::new(draws.unit(), draws.unit()));
    };
    // A patch has its columns side by side; a tube with a seam has its first column twice.
    for row in 0..rows {
        for column in 0..columns {
            let share = column as f32 / columns as f32;
            let height = row as f32 / 3.0 - 0.4;
            let (sine, cosine) = det::sin_cos(std::f32::consts::TAU * share);
            let across = if tube {
                Vec3::new(0.4 * cosine, height, 0.4 * sine)
            } else {
                Vec3::new(share - 0.4, height, 0.3 * sine)
            };
            vertex(mesh, at + across);
        }
    }
    let [rows, columns] = [rows, columns].map(|count| index_u32(index_usize(count)));
    let number = |row: u32, column: u32| first + row * columns + column % columns;
    let closed = if tube { columns } else { columns - 1 };
    for row in 1..rows {
        for column in 0..closed {
            let [a, b] = [column, column + 1].map(|column| number(row - 1, column));
            let [c, d] = [column + 1, column].map(|column| number(row, column));
            mesh.indices.extend([a, d, c, a, c, b]);
        }
    }
    if tube {
        let tip = index_u32(mesh.positions.len());
        vertex(mesh, at + Vec3::new(0.0, rows as f32 / 3.0 - 0.4, 0.0));
        for column in 0..columns {
            mesh.indices
                .extend([number(rows - 1, column), tip, number(rows - 1, column + 1)]);
        }
    }
    // A seam: some triangles use a vertex of their own at the same position.
    for corner in (0..mesh.indices.len()).step_by(7) {
        let old = mesh.indices[corner] as usize;
        if draws.below(3) == 0 && old >= first as usize {
            mesh.positions.push(mesh.positions[old]);
            mesh.normals.push(mesh.normals[old]);
            let moved = mesh.texture_coordinates[old] + Vec2::splat(0.5);
            mesh.texture_coordinates.push(moved);
            mesh.indices[corner] = index_u32(mesh.positions.len() - 1);
        }
    }
}

/// A fresh device with an instance of a trunk at a level.
pub(crate) fn trunk_stage(
    kind: TrunkKind,
    options: ModelOptions,
    trunk: &Arc<Trunk>,
    level: TrunkLevel,
    side: u32,
) -> Stage<TrunkLevel> {
    let model = kind.model(trunk, options);
    let stage = Stage::of_trunk(descriptor(), model.as_ref(), level, side);
    stage.expect("memory suffices")
}

/// A picture of a trunk at a level as a plain list of its triangles.
pub(crate) fn trunk_picture(trunk: &Trunk, level: TrunkLevel, side: u32) -> Image {
    let mesh = trunk
        .collapses()
        .mesh_after(trunk.mesh(), level.collapses());
    let plant = Plant::new("list", None, Some(mesh), Foliage::default()).expect("sound parts");
    let list = Arc::new(Trunk::of(&Arc::new(plant), None).expect("it has a trunk"));
    let mut stage = trunk_stage(TrunkKind::FULL, OPTIONS, &list, TrunkLevel::FINEST, side);
    stage.picture().expect("our device draws")
}

/// A random state; `choice` decides kind and detail.
pub(crate) fn random_state(crown: &Crown, choice: u64) -> State {
    let mut draws = Stream::new(choice, 3).draws();
    if draws.below(2) == 0 {
        let all = u64::from(crown.sequence().collapse_count());
        State::Uniform {
            collapses: index_u32(index_usize(draws.below(all + 1))),
        }
    } else {
        let counts = crown.clusters().clusters.iter();
        let counts = counts
            .map(|c| index_u32(index_usize(draws.below(u64::from(c.original_count())))))
            .collect();
        State::Variable { counts }
    }
}

/// A device with what all tests of models stand on.
pub(crate) fn descriptor() -> DeviceDescriptor {
    Stage::descriptor()
}

pub(crate) const OPTIONS: ModelOptions = ModelOptions {
    extraction: Extraction::Batched,
    gather: Gather::Single,
    format: LeafFormat::WIDE,
    occlusion: Occlusion::None,
    cards: CardOptions::USUAL,
    painting: PaintOptions::USUAL,
};

/// Stages where memory suffices.
pub(crate) trait StageExt {
    /// A fresh device with an instance in `state`; writes are recorded.
    fn at(kind: Kind, options: ModelOptions, crown: &Arc<Crown>, state: &State, side: u32) -> Self;

    /// The same on a device of choice.
    fn on(descriptor: DeviceDescriptor, model: &dyn Model, state: &State, side: u32) -> Self;

    /// Draws.
    fn draw(&mut self) -> Image;
}

impl StageExt for Stage {
    fn at(kind: Kind, options: ModelOptions, crown: &Arc<Crown>, state: &State, side: u32) -> Self {
        let model = kind.model(crown, options);
        Self::on(descriptor(), model.as_ref(), state, side)
    }

    fn on(descriptor: DeviceDescriptor, model: &dyn Model, state: &State, side: u32) -> Self {
        Self::new(descriptor, model, state, side).expect("memory suffices")
    }

    fn draw(&mut self) -> Image {
        self.picture().expect("our device draws")
    }
}

/// Two grey birches and a camera that walks away from them, resting at frame 5.
const BIRCHES: &str = r#"schema = "spinney.scene/1"
size = [160, 120]
frames = 7
seed = 1

[[tree]]
species = "species/betula_populifolia.toml"

[[tree]]
species = "species/betula_populifolia.toml"
at = [2.5, 0.0, -1.5]
turn = 70.0
scale = 0.8

[camera]
path = [
    { frame = 0, eye = [0.5, 3.5, 9.0], target = [0.8, 3.6, 0.0] },
    { frame = 4, eye = [5.0, 5.0, 24.0], target = [0.8, 3.6, 0.0] },
    { frame = 5, eye = [5.0, 5.0, 24.0], target = [0.8, 3.6, 0.0] },
    { frame = 6, eye = [6.0, 5.0, 28.0], target = [0.8, 3.6, 0.0] },
]

[model]
detail = "variable"
d_min = 7.0
d_max = 32.0

[device]
card = "gtx770"
"#;

/// A scene by its text, as if it stood in `wood.toml`; else what is wrong with it.
pub(crate) fn parse_wood(text: &str) -> Result<Scene, String> {
    let document = Document {
        file: "wood.toml".to_owned(),
        text: text.to_owned(),
    };
    let read = SceneFile::parse(document).map(|file| file.scene);
    read.map_err(|error| error.to_string())
}

/// The scene of two birches.
pub(crate) fn birch_scene() -> Scene {
    let document = Document {
        file: "birches.toml".to_owned(),
        text: BIRCHES.to_owned(),
    };
    SceneFile::parse(document).expect("a sound scene").scene
}

/// Its plants, grown and simplified anew.
pub(crate) fn grow_birches() -> World {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    World::build(&birch_scene(), &folder, &Silent).expect("a species of our own")
}

/// Its plants, grown and simplified once.
pub(crate) fn birches() -> &'static World {
    static WORLD: OnceLock<World> = OnceLock::new();
    WORLD.get_or_init(grow_birches)
}

/// Every file below a folder with what it holds, and every folder.
pub(crate) fn contents(folder: &Path, prefix: &str, found: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        let name = path.file_name().expect("named").to_string_lossy();
        let name = format!("{prefix}{name}");
        if path.is_dir() {
            contents(&path, &format!("{name}/"), found);
            found.insert(name + "/", Vec::new());
        } else {
            found.insert(name, std::fs::read(path).expect("readable"));
        }
    }
}
