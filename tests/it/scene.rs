//! Scene files: what is wrong is said with line, column, what was found and what would be right;
//! what is right reads back as it was written.

use std::path::Path;

use proptest::prelude::*;
use spinney::document::Document;
use spinney::math::{Digest, Vec3};
use spinney::scene::{
    Absent, KEYS, Kind, PlantSource, Projection, Scene, SceneError, SceneFile, to_toml,
};

/// The least that a scene must say: six lines.
const LEAST: &str = r#"schema = "spinney.scene/1"
[[tree]]
species = "yew.toml"
[camera]
path = [{ eye = [0, 1, 9], target = [0, 1, 0] }]
"#;

fn file(text: &str) -> Result<SceneFile, SceneError> {
    SceneFile::parse(Document {
        file: "dir/my oak.toml".to_owned(),
        text: text.to_owned(),
    })
}

fn scene(text: &str) -> Scene {
    file(text).expect("a sound scene").scene
}

fn message(text: &str) -> String {
    match file(text) {
        Ok(_) => "no error".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// The least scene with a line before its tables: line 2.
fn with(line: &str) -> String {
    LEAST.replacen('\n', &format!("\n{line}\n"), 1)
}

/// The least scene with lines at its end: from line 6.
fn ending(lines: &str) -> String {
    format!("{LEAST}{lines}\n")
}

fn assert_messages(cases: &[(String, &str)]) {
    for (text, wanted) in cases {
        assert_eq!(message(text), format!("dir/my oak.toml:{wanted}"), "{text}");
    }
}

#[test]
fn least_scene_has_the_defaults_of_the_table() {
    let scene = scene(LEAST);
    assert_eq!(scene.name, "my-oak");
    assert_eq!((scene.size.width(), scene.size.height()), (640, 480));
    assert_eq!((scene.samples.get(), scene.frames, scene.seed), (1, 1, 1));
    assert_eq!(scene.background, [0xc8, 0xd8, 0xe8]);
    assert_eq!(
        scene.trees[0].source,
        PlantSource::Species("yew.toml".to_owned())
    );
    assert_eq!((scene.trees[0].seed, scene.trees[0].scale), (1, 1.0));
    assert_eq!(
        scene.camera.projection(),
        Projection::Perspective {
            vertical_field_of_view: 45.0
        }
    );
    assert_eq!(scene.model.range.d_min(), 5.0);
    assert_eq!(scene.device.memory, 256 << 20);
    assert_eq!(scene.golden, None);
}

#[test]
fn single_values_out_of_range_are_refused() {
    assert_messages(&[
        (
            with("frames = 0"),
            "2:10: `frames`: found 0, wanted an integer from 1 to 100000",
        ),
        (
            with("frames = 2.0"),
            "2:10: `frames`: found 2.0, wanted an integer from 1 to 100000",
        ),
        (
            with("frames = 99999999999999999999999999999999999999999999"),
            "2:10: `frames`: found 99999999999999999999999999999999999999999999, wanted an integer from 1 to 100000",
        ),
        (
            with("seed = -1"),
            "2:8: `seed`: found -1, wanted an integer from 0 to 18446744073709551615",
        ),
        (
            with("seed = 18446744073709551616"),
            "2:8: `seed`: found 18446744073709551616, wanted an integer from 0 to 18446744073709551615",
        ),
        (
            with("samples = 2"),
            "2:11: `samples`: found 2, wanted 1 or 4",
        ),
        (
            with("size = [640, 0]"),
            "2:14: `size`: found 0, wanted [width, height] from 1 to 16384, at most 33554432 pixels",
        ),
        (
            with("size = [16384, 16384]"),
            "2:8: `size`: found [16384, 16384], wanted [width, height] from 1 to 16384, at most 33554432 pixels",
        ),
        (
            with("size = [640]"),
            "2:8: `size`: found [640], wanted [width, height] from 1 to 16384, at most 33554432 pixels",
        ),
        (
            with("name = \"../up\""),
            "2:8: `name`: found \"../up\", wanted a text of 1 to 64 letters, digits, `.`, `_`, `-` that begins with a letter or digit",
        ),
        (
            with("background = \"#12345\""),
            "2:14: `background`: found \"#12345\", wanted a colour \"#rrggbb\"",
        ),
        (
            with("background = [0, 0, 0]"),
            "2:14: `background`: found [0, 0, 0], wanted a colour \"#rrggbb\"",
        ),
        (
            ending("[device]\nmemory = 1024"),
            "7:10: `device.memory`: found 1024, wanted a size such as \"256 MiB\", in B, KiB, MiB or GiB, at most 4 GiB",
        ),
        (
            ending("[device]\nlink = \"\""),
            "7:8: `device.link`: found \"\", wanted a text of 1 to 400 characters",
        ),
        (
            ending("[model]\nmode = \"magic\""),
            "7:8: `model.mode`: found \"magic\", wanted \"host\", \"cluster\", \"slots\", \"stamps\", \"literal\", \"indices\", \"resident\", \"device\", \"direct\", \"indirect\", \"axial\", \"facing\", \"depth\", \"nearest\", \"fixed\", \"hemisphere\", \"sphere\" or \"ranges\"",
        ),
        (
            ending("[model]\nname = \"vdf\"\nmode = \"slots\""),
            "8:8: `model.mode`: found \"slots\", wanted a mode of \"vdf\": \"host\" or \"indices\"",
        ),
        (
            ending("[model]\nlevel = 1.5"),
            "7:9: `model.level`: found 1.5, wanted a number from 0 to 1",
        ),
        (
            ending("[model]\ncriterion = \"beauty\""),
            "7:13: `model.criterion`: found \"beauty\", wanted \"paper\", \"distance\", \"screen-error\" or \"silhouette\"",
        ),
        (
            ending("[model]\nhysteresis = 0.6"),
            "7:14: `model.hysteresis`: found 0.6, wanted a number from 0 to 0.5",
        ),
        (
            ending("[model]\nbudget_bytes = 0"),
            "7:16: `model.budget_bytes`: found 0, wanted an integer from 1 to 4294967296",
        ),
        (
            ending("[model]\nstop_leaves = 0"),
            "7:15: `model.stop_leaves`: found 0, wanted an integer from 1 to 16000000",
        ),
    ]);
}

#[test]
fn numbers_that_are_none_are_refused_everywhere() {
    assert_messages(&[
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nat = [0, nan, 0]"),
            "4:10: `tree.at`: found nan, wanted three numbers from -100000 to 100000",
        ),
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nscale = inf"),
            "4:9: `tree.scale`: found inf, wanted a number from 0.001 to 1000",
        ),
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nturn = -nan"),
            "4:8: `tree.turn`: found -nan, wanted a number from -360 to 360",
        ),
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nturn = 1e999"),
            "4:8: `tree.turn`: found 1e999, wanted a number from -360 to 360",
        ),
        (
            LEAST.replace("[0, 1, 9]", "[0, 1, -inf]"),
            "5:24: `camera.path.eye`: found -inf, wanted three numbers from -100000 to 100000",
        ),
        (
            ending("[light]\ncolor = [nan, 1, 1]"),
            "7:10: `light.color`: found nan, wanted three numbers from 0 to 100",
        ),
    ]);
    // Every numeric key of the table, wherever it stands.
    for key in KEYS {
        let bad = match key.kind {
            Kind::Number { .. } => "nan",
            Kind::Triple { .. } => "[0, 0, inf]",
            _ => continue,
        };
        let (table, name) = key.path.rsplit_once('.').expect("below a table");
        let text = match table {
            "forest[]" => {
                let forest = "[[forest]]\nspecies = [\"a.toml\"]\ncount = 1\narea = [0, 0, 9, 9]\n";
                LEAST.replace("[camera]", &format!("{forest}{name} = {bad}\n[camera]"))
            }
            "tree[]" => LEAST.replace("yew.toml\"", &format!("yew.toml\"\n{name} = {bad}")),
            "camera" => LEAST.replace("path =", &format!("{name} = {bad}\npath =")),
            "camera.path[]" if name == "eye" => LEAST.replace("[0, 1, 9]", bad),
            "camera.path[]" => LEAST.replace("[0, 1, 0]", bad),
            _ => ending(&format!("[{table}]\n{name} = {bad}")),
        };
        let message = message(&text);
        let shown = key.path.replace("[]", "");
        assert!(message.contains(&format!("`{shown}`: found ")), "{message}");
        assert!(message.ends_with(&key.kind.wanted()), "{message}");
    }
}

#[test]
fn values_that_do_not_go_together_are_refused() {
    assert_messages(&[
        (
            ending("[model]\nd_min = 9\nd_max = 9.0"),
            "8:9: `model.d_max`: found 9.0, wanted more than `d_min`, which is 9",
        ),
        (
            ending("[model]\nd_min = 60"),
            "6:1: `model.d_max`: found nothing, wanted more than `d_min`, which is 60",
        ),
        (
            ending("[cards]\ncount = 8\nlevels = [9, 4]"),
            "8:10: `cards.levels`: found [9, 4], wanted levels that begin with `count`, which is 8",
        ),
        (
            ending("[model]\nleaf_share = 0.5\nlevel = 0.5"),
            "7:14: `model.leaf_share`: found 0.5, wanted nothing, since `level` says how much detail",
        ),
        (
            ending("[model]\nleaf_budget = 9\npixel_error = 2"),
            "8:15: `model.pixel_error`: found 2, wanted nothing, since `leaf_budget` says how much detail",
        ),
        (
            LEAST.replace("path =", "near = 5\nfar = 5\npath ="),
            "6:7: `camera.far`: found 5, wanted more than `near`, which is 5",
        ),
        (
            LEAST.replace("path =", "height = 2\npath ="),
            "5:10: `camera.height`: found 2, wanted nothing, since `projection` is perspective",
        ),
        (
            LEAST.replace("path =", "projection = \"orthographic\"\npath ="),
            "4:1: `camera.height`: found nothing, wanted a height in metres, since `projection` is orthographic",
        ),
        (
            LEAST.replace(
                "path =",
                "projection = \"orthographic\"\nheight = 1\nvertical_field_of_view = 30\npath =",
            ),
            "7:26: `camera.vertical_field_of_view`: found 30, wanted nothing, since `projection` is orthographic",
        ),
        (
            LEAST.replace("[0, 1, 9]", "[0, 1, 0]"),
            "5:37: `camera.path.target`: found [0, 1, 0], wanted another point than `eye`",
        ),
        (
            LEAST.replace(
                "path = [",
                "path = [{ frame = 3, eye = [0,0,0], target = [1,0,0] },\n",
            ),
            "6:1: `camera.path.frame`: found nothing, wanted more than 3, the frame of the key before it",
        ),
        (
            LEAST.replace("species = \"yew.toml\"\n", "scale = 2\n"),
            "2:1: `tree.species`: found nothing, wanted either `species` or `file`",
        ),
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nfile = \"a.glb\""),
            "4:8: `tree.file`: found \"a.glb\", wanted nothing, since the tree has `species`",
        ),
        (
            LEAST.replace("yew.toml\"", "yew.toml\"\nfoliage = [\"a\"]"),
            "4:11: `tree.foliage`: found [\"a\"], wanted nothing, since the tree has `species`",
        ),
        (
            LEAST.replace("yew.toml", "/yew.toml"),
            "3:11: `tree.species`: found \"/yew.toml\", wanted a path relative to the scene file, with `/` between its parts",
        ),
        (
            ending("[light]\ndirection = [0, 0, 0]"),
            "7:13: `light.direction`: found [0, 0, 0], wanted a direction, which has a length",
        ),
        (
            ending("[golden]\nframes = [1]"),
            "7:10: `golden.frames`: found [1], wanted frames below 1, the scene's count",
        ),
        (
            ending("[golden]\nframes = [0, 0]"),
            "7:14: `golden.frames`: found 0, wanted 1 to 64 ascending integers from 0 to 99999",
        ),
        (
            ending("[golden]\nsize = [161, 1]"),
            "7:9: `golden.size`: found 161, wanted [width, height] from 1 to 160",
        ),
        (
            ending("[golden]\ntolerance = 1"),
            "6:1: `golden.reason`: found nothing, wanted a reason, since `tolerance` is above 0",
        ),
        (
            ending("[golden]\nreason = \"x\""),
            "7:10: `golden.reason`: found \"x\", wanted nothing, since `tolerance` is 0",
        ),
    ]);
}

#[test]
fn wrong_shapes_are_refused() {
    assert_messages(&[
        (
            String::new(),
            "1:1: `schema`: found nothing, wanted \"spinney.scene/1\"",
        ),
        (
            LEAST.replace("scene/1", "scene/2"),
            "1:10: `schema`: found \"spinney.scene/2\", wanted \"spinney.scene/1\"",
        ),
        (
            "schema = \"spinney.scene/1\"\ntree = []".to_owned(),
            "2:8: `tree`: found 0 tables, wanted 1 to 20000 tables",
        ),
        (
            "schema = \"spinney.scene/1\"\ntree = [1]".to_owned(),
            "2:9: `tree`: found 1, wanted 1 to 20000 tables",
        ),
        (
            "schema = \"spinney.scene/1\"\n[tree]\nseed = 1".to_owned(),
            "2:1: `tree`: found a table, wanted 1 to 20000 tables",
        ),
        (
            ending("[model]\nname = [{ eye = [0, 1, 9], target = [0, 1, 0] }]"),
            "7:8: `model.name`: found [{ eye = [0, 1, 9], target = [0, 1, 0] }], wanted \"lodf\", \"full\", \"vdf\", \"impostors\", \"billboard\", \"sprites\", \"crossed\", \"octahedral\", \"strokes\", \"flattened\" or \"bare\"",
        ),
        (
            with("camera = 3").replace("[camera]", "[light]"),
            "2:10: `camera`: found 3, wanted a table",
        ),
        (
            ending("[light]\npath = 3"),
            "7:1: unknown key `path` in `light`, wanted one of direction, color, ambient",
        ),
        (with("light = 3"), "2:9: `light`: found 3, wanted a table"),
        (
            with("colour = 3"),
            "2:1: unknown key `colour`, wanted one of schema, name, size, samples, frames, seed, background, tree, forest, terrain, camera, light, shadow, model, cards, branches, painting, grove, device, golden",
        ),
        (
            LEAST.replace("eye =", "eye.x ="),
            "5:11: `camera.path.eye`: found a table, wanted three numbers from -100000 to 100000",
        ),
        (
            with("frames = "),
            "2:10: string values must be quoted, expected literal string",
        ),
        (with("frames = 1\nframes = 2"), "3:1: duplicate key"),
    ]);
}

#[test]
fn deep_nesting_and_long_values_are_refused_without_harm() {
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let text = with(&format!(
            "frames = {}1{}",
            open.repeat(100_000),
            close.repeat(100_000)
        ));
        assert!(message(&text).contains("recurs"), "{}", message(&text));
    }
    let text = with(&format!("{}a = 1", "a.".repeat(100_000)));
    assert!(message(&text).contains("recurs"), "{}", message(&text));
    let text = with(&format!("name = \"{}\"", "ä".repeat(100_000)));
    assert!(message(&text).len() < 300);
}

#[test]
fn later_checks_point_into_the_file() {
    let file = file(&ending("[device]\nlink = \"isa\"")).expect("sound");
    let at = |key: &str| {
        let error = file.source.error(key, "no");
        (error.line, error.column)
    };
    assert_eq!(at("device.link"), (7, 8));
    assert_eq!(at("device.card"), (6, 1), "the table, for lack of the key");
    assert_eq!(at("tree[0].species"), (3, 11));
    assert_eq!(at("tree[0].seed"), (2, 1));
    assert_eq!(at("model.mode"), (1, 1));
    assert_eq!(
        file.source.resolve("../yew.toml"),
        Path::new("dir/../yew.toml")
    );
}

#[test]
fn missing_files_are_named() {
    let error = Scene::read(Path::new("no/such/scene.toml")).expect_err("missing");
    assert!(
        error
            .to_string()
            .starts_with("no/such/scene.toml:1:1: cannot read: "),
        "{error}"
    );
}

/// A scene that leaves nothing at its default.
const FULL: &str = r##"
golden = { size = [9, 8], frames = [1, 3], tolerance = 2, reason = "a \"quoted\" reason" }
schema = "spinney.scene/1"
name = "x-1"
size = [0x20, 1_6]
samples = 4
frames = 7
seed = 18446744073709551615
background = "#0A0b0c"
tree = [
  { species = "a/b.toml", seed = 3, at = [1e-3, -0.0, 0.1], turn = -90.5, scale = 2 },
  { file = "ü.glb", foliage = ["leaf", 'x"y'], plant_digest = "000102030405060708090a0b0c0d0e0f101112131415161718191A1B1C1D1E1F" },
]
[camera]
projection = "orthographic"
height = 3.3
near = 0.5
far = 77
path = [
  { frame = 1, eye = [0, 1, 9], target = [0, 1, 0] },
  { frame = 4, eye = [0, 1, 8], target = [0, 1, 0] },
]
[light]
direction = [0, 0, -3]
color = [1, 0.5, 0.25]
ambient = [0, 0, 0.1]
[model]
name = "lodf"
mode = "slots"
detail = "variable"
d_min = 0.1
d_max = 0.2
extraction = "single"
gather = "regions"
records = "compact"
vertices = "quantised"
simplifier = "pruning"
stop_leaves = 12
level = 0.3
[cards]
count = 9
levels = [9, 5]
texture = 64
orientation_weight = 0.5
plane_seeds = 2
depth = "relief"
transparency = "coverage"
outline = "trimmed"
sides = "front"
map = 16
layers = 3
sprites = 7
sprite_texture = 32
scale = "leaf"
[device]
memory = "1536 KiB"
link = "agp8x"
card = "gtx770"
"##;

#[test]
fn full_scene_reads_as_written() {
    let scene = scene(FULL);
    assert_eq!((scene.size.width(), scene.size.height()), (32, 16));
    assert_eq!(scene.seed, u64::MAX);
    assert_eq!(scene.background, [10, 11, 12]);
    assert_eq!(scene.trees[0].at, Vec3::new(0.001, 0.0, 0.1));
    assert_eq!(scene.trees[1].seed, u64::MAX);
    let digest = Digest(std::array::from_fn(|byte| {
        u8::try_from(byte).expect("32 bytes")
    }));
    assert_eq!(scene.trees[1].plant_digest, Some(digest));
    assert_eq!(scene.device.memory, 3 << 19);
    assert_eq!(scene.model.level, Some(0.3));
    assert_eq!(scene.cards.levels.as_slice(), [9, 5]);
    let golden = scene.golden.expect("there");
    assert_eq!((golden.frames, golden.tolerance), (vec![1, 3], 2));
}

#[test]
fn resolved_scene_reads_back_equal() {
    let spread = "criterion = \"silhouette\"\nhysteresis = 0.125\nbudget_bytes = 4096";
    let amounts = ["leaf_budget = 12", "leaf_share = 0.4", "pixel_error = 1.5"];
    let chosen = amounts.map(|amount| ending(&format!("[model]\n{spread}\n{amount}")));
    let chosen = chosen.iter().map(String::as_str);
    for text in [LEAST, FULL].into_iter().chain(chosen) {
        let scene = scene(text);
        let resolved = to_toml(&scene);
        let again = file(&resolved).expect("sound").scene;
        assert_eq!(again, scene, "{resolved}");
        assert_eq!(again.digest(), scene.digest());
        assert_eq!(to_toml(&again), resolved);
    }
}

#[test]
fn resolved_scene_leaves_nothing_to_defaults() {
    let resolved = to_toml(&scene(LEAST));
    for key in KEYS {
        if matches!(key.absent, Absent::Value("{}")) || matches!(key.absent, Absent::Rule(_)) {
            continue;
        }
        let name = key.path.rsplit('.').next().expect("not empty");
        // Tables that need not be there.
        let tables = ["golden", "forest", "terrain", "shadow", "grove"];
        let optional = tables.iter().any(|table| key.path.starts_with(table));
        assert!(
            optional || resolved.contains(name),
            "{}: {resolved}",
            key.path
        );
    }
}

#[test]
fn digest_knows_the_meaning_not_the_layout() {
    let digest = |text: &str| scene(text).digest();
    let spread = format!(
        "# A comment.\n{}",
        LEAST.replace("[0, 1, 9]", "[ 0.0, 1,\n 9e0 ]")
    );
    assert_eq!(digest(&spread), digest(LEAST));
    assert_eq!(
        digest(&with("seed = 1")),
        digest(LEAST),
        "a default, spelt out"
    );
    let mut seen = vec![digest(LEAST), digest(FULL)];
    for text in [
        with("seed = 2"),
        with("samples = 4"),
        with("name = \"other\""),
        ending("[model]\nmode = \"slots\""),
        ending("[model]\nlevel = 0"),
        ending("[model]\nrecords = \"compact\""),
        ending("[model]\nvertices = \"quantised\""),
        ending("[model]\nsimplifier = \"pruning\""),
        ending("[model]\ncriterion = \"distance\""),
        ending("[model]\nleaf_budget = 7"),
        ending("[model]\nleaf_share = 0"),
        ending("[model]\npixel_error = 7"),
        ending("[model]\nhysteresis = 0.1"),
        ending("[model]\nbudget_bytes = 7"),
        ending("[cards]\ncount = 31"),
        ending("[cards]\nlevels = [32, 16]"),
        ending("[cards]\nsides = \"front\""),
        ending("[golden]"),
        ending("[light]\nambient = [0, 0, 0]"),
        ending("[device]\nlink = \"agp1x\""),
        LEAST.replace("[0, 1, 9]", "[0, 1, 9.5]"),
        LEAST.replace("species", "file"),
    ] {
        let digest = digest(&text);
        assert!(!seen.contains(&digest), "{text}");
        seen.push(digest);
    }
    // Renew only with a new schema: other tools may store it.
    assert_eq!(
        digest(LEAST).to_string(),
        "5a0583a21629dbec0b6bfa47db21e04c352af8bb90f20fe11716f2143b533c9e"
    );
}

crate::support::properties! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Numbers survive writing and reading to the bit.
    #[test]
    fn numbers_read_back_to_the_bit(x in -1e5_f32..1e5, y in 1e-3_f32..1e3, z in -1e-30_f32..1e-30, seed in any::<u64>()) {
        let text = LEAST.replace("yew.toml\"", &format!("yew.toml\"\nat = [{x:?}, {z:?}, 0]\nscale = {y}\nseed = {seed}"));
        let read = scene(&text);
        let tree = &read.trees[0];
        prop_assert_eq!((tree.at.x, tree.at.y, tree.scale, tree.seed), (x, z + 0.0, y, seed));
        prop_assert_eq!(&scene(&to_toml(&read)), &read);
    }

    /// No text makes reading panic.
    #[test]
    fn any_text_is_read_or_refused(text in "(schema|tree|camera|path|=|\\[|\\]|\\{|\\}|\"|\n|[0-9.]|,|nan|ä| ){0,40}") {
        let _ = file(&text);
        let _ = file(&with(&text));
        let _ = file(&ending(&text));
    }
}
