//! What a frame draws, as files: the same triangles come back, where they stood.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use spinney::document::Document;
use spinney::math::{Mat4, Quat, Vec3, Vec4};
use spinney::models::{Placement, TreeState};
use spinney::plant::import::{ImportOptions, import_bytes};
use spinney::plant::{Plant, Prototype};
use spinney::run::{FrameExport, Session, SessionOptions, Silent, World, export_frame};
use spinney::scene::{Scene, SceneFile};

/// A scene of one small shrub, at a level of its leaves and another of its trunk.
fn text(model: &str) -> String {
    format!(
        r#"schema = "spinney.scene/1"
name = "shrub"
size = [64, 48]
frames = 3
[[tree]]
species = "shrub.toml"
[camera]
path = [{{ frame = 0, eye = [0.3, 1.0, 6.0], target = [0.0, 1.0, 0.0] }}]
[model]
{model}
"#
    )
}

fn scene(model: &str) -> Scene {
    let (file, text) = ("scene.toml".to_owned(), text(model));
    let read = SceneFile::parse(Document { file, text });
    read.expect("a sound scene").scene
}

/// A folder with a shrub of 300 leaves.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let species = Path::new(env!("CARGO_MANIFEST_DIR"));
    let species = species.join("scenes/species/pistacia_lentiscus.toml");
    let species = std::fs::read_to_string(species).expect("the shipped species");
    let fewer = species
        .replace("leaf_count = 5594", "leaf_count = 300")
        .replace("stop_leaves = 90", "stop_leaves = 9");
    std::fs::write(folder.path().join("shrub.toml"), fewer).expect("writable");
    folder
}

/// The plant of [`scene`], and what a session of it draws first.
fn exported(scene: &Scene, change: impl Fn(&mut World)) -> (World, Vec<TreeState>, FrameExport) {
    let folder = folder();
    let mut world = World::build(scene, folder.path(), &Silent).expect("a sound species");
    change(&mut world);
    let options = SessionOptions::exact(scene).expect("known names");
    let session = Session::new(scene, &world, &options).expect("memory suffices");
    let (states, view) = (session.states(), scene.camera.at(0, scene.size));
    let export = export_frame("shrub", &world, &options, &view, &states).expect("small");
    drop(session);
    (world, states, export)
}

/// The bits of a triangle's corners, the least first; its sense of rotation is kept.
fn canonical(corners: [Vec3; 3]) -> [[u32; 3]; 3] {
    let mut bits = corners.map(|corner| corner.to_array().map(f32::to_bits));
    let least = (0..3).min_by_key(|&corner| bits[corner]);
    bits.rotate_left(least.unwrap_or(0));
    bits
}

/// All triangles of a plant, sorted.
fn triangles(plant: &Plant) -> Vec<[[u32; 3]; 3]> {
    let mut all = Vec::new();
    for group in &plant.foliage().groups {
        for leaf in group.positions.chunks(group.prototype.vertices_per_leaf()) {
            let triangles = match &group.prototype {
                Prototype::Faces { triangles, .. } => triangles.clone(),
                Prototype::Quad { .. } | Prototype::Needle { .. } => vec![[0, 1, 2], [0, 2, 3]],
            };
            let corners = triangles.iter();
            all.extend(corners.map(|three| canonical(three.map(|corner| leaf[corner as usize]))));
        }
    }
    if let Some(trunk) = plant.trunk() {
        let three = trunk.indices.as_chunks::<3>().0.iter();
        all.extend(three.map(|three| canonical(three.map(|at| trunk.positions[at as usize]))));
    }
    all.sort_unstable();
    all
}

/// All triangles of the only tree of a world in its state, sorted.
fn drawn(world: &World, state: &TreeState) -> Vec<[[u32; 3]; 3]> {
    let crown = &world.crowns[0];
    let mut all = Vec::new();
    for leaf in state.foliage.visible(crown.clusters()) {
        let quad = crown.sequence().corners()[leaf as usize];
        let [a, b, c, d] = quad.map(|corner| crown.vertices()[corner as usize]);
        all.extend([canonical([a, b, c]), canonical([a, c, d])]);
    }
    let trunk = world.trunks[0].as_ref().expect("it has a trunk");
    let (positions, order) = (&trunk.mesh().positions, trunk.collapses().order());
    for (_, three) in trunk.collapses().triangles_after(state.trunk.collapses()) {
        let three = three.map(|corner| positions[order[corner as usize] as usize]);
        all.push(canonical(three));
    }
    all.sort_unstable();
    all
}

/// The document of a binary glTF file, and its binary chunk.
fn document(glb: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes"));
    let end = 20 + word(12) as usize;
    let document = serde_json::from_slice(&glb[20..end]).expect("JSON");
    (document, &glb[end + 8..])
}

/// A number of a document; 0 where there is none.
fn number(value: &Value) -> usize {
    let number = value.as_u64().unwrap_or_default();
    usize::try_from(number).expect("small files")
}

/// The floats of an accessor.
fn floats(document: &Value, binary: &[u8], accessor: &Value) -> Vec<f32> {
    let accessor = &document["accessors"][number(accessor)];
    assert_eq!(accessor["componentType"], 5126, "the number of `f32`");
    let view = &document["bufferViews"][number(&accessor["bufferView"])];
    let bytes = &binary[number(&view["byteOffset"])..][..number(&view["byteLength"])];
    let words = bytes.as_chunks::<4>().0.iter();
    words.map(|word| f32::from_le_bytes(*word)).collect()
}

#[test]
fn the_triangles_that_a_frame_draws_come_back() {
    let level = "mode = \"slots\"\nlevel = 0.6\ntrunk = \"lodstrips\"\ntrunk_level = 0.4";
    let (world, states, export) = exported(&scene(level), |_world| {});
    assert!(states[0].trunk.collapses() > 0, "{states:?}");
    let (document, _) = document(&export.glb);
    let names = document["nodes"].as_array().unwrap().iter();
    let names = names.map(|node| node["name"].as_str().expect("a name").to_owned());
    let options = ImportOptions {
        foliage: names.filter(|name| !name.ends_with("trunk")).collect(),
        ..ImportOptions::default()
    };
    let imported = import_bytes("frame.glb", &export.glb, None, &options).expect("sound");
    let wanted = drawn(&world, &states[0]);
    let leaves = states[0].foliage.leaf_count(world.crowns[0].clusters());
    assert!(
        wanted.len() > 2 * leaves as usize && leaves < 200,
        "{leaves} leaves"
    );
    assert_eq!(triangles(&imported.plant), wanted);
    let material = &imported.plant.foliage().groups[0].material;
    let group = &world.crowns[0].plant().foliage().groups[0];
    assert_eq!(
        material.texture, group.material.texture,
        "the mask to the byte"
    );
    assert_eq!(material.alpha_cutoff, group.material.alpha_cutoff);
}

#[test]
fn trees_that_show_the_same_share_a_mesh() {
    let places = [0.0, 3.5, -2.0].map(|x| Placement {
        position: Vec3::new(x, 0.25, 1.0 / 3.0),
        rotation: Quat::from_array([0.0, 0.6, 0.0, 0.8]),
        scale: 0.9 + 0.1 * x.abs(),
    });
    let (world, _, export) = exported(&scene("name = \"full\"\nmode = \"resident\""), |world| {
        let tree = world.trees[0];
        let standing = places
            .iter()
            .map(|&placement| spinney::run::StandingTree { placement, ..tree });
        world.trees = standing.collect();
    });
    let (document, binary) = document(&export.glb);
    let parts = 1 + world.crowns[0].plant().foliage().groups.len();
    assert_eq!(document["meshes"].as_array().unwrap().len(), parts);
    assert_eq!(document["extensionsUsed"][0], "EXT_mesh_gpu_instancing");
    for node in document["nodes"].as_array().unwrap() {
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        let read = |name: &str| floats(&document, binary, &attributes[name]);
        let positions: Vec<f32> = places
            .iter()
            .flat_map(|place| place.position.to_array())
            .collect();
        let rotations: Vec<f32> = places
            .iter()
            .flat_map(|place| place.rotation.to_array())
            .collect();
        let scales: Vec<f32> = places.iter().flat_map(|place| [place.scale; 3]).collect();
        assert_eq!(read("TRANSLATION"), positions);
        assert_eq!(read("ROTATION"), rotations);
        assert_eq!(read("SCALE"), scales);
    }
}

#[test]
fn the_camera_has_the_depth_of_opengl() {
    let scene = scene("mode = \"slots\"");
    let (_, _, export) = exported(&scene, |_world| {});
    let camera: Value = serde_json::from_str(&export.camera).expect("JSON");
    assert_eq!([&camera["width"], &camera["height"]], [64, 48]);
    let matrix = |key: &str| {
        let numbers = camera[key].as_array().expect("a list").iter();
        let numbers: Vec<f32> = numbers
            .map(|number| number.to_string().parse().expect("a number"))
            .collect();
        Mat4::from_cols_array(numbers.as_slice().try_into().expect("16 numbers"))
    };
    let view = scene.camera.at(0, scene.size);
    assert_eq!(matrix("view"), view.view_from_world);
    let point = Vec4::new(0.4, -0.3, -5.0, 1.0);
    let (ours, theirs) = (view.clip_from_view * point, matrix("proj") * point);
    assert_eq!(ours.truncate().truncate(), theirs.truncate().truncate());
    assert_eq!(ours.w, theirs.w);
    assert!(
        (theirs.z - (2.0 * ours.z - ours.w)).abs() < 1e-5,
        "{ours} {theirs}"
    );
}

/// Runs `spinney run scene.toml` with more arguments; answers its exit code.
fn run(folder: &Path, arguments: &str) -> Option<i32> {
    let mut program = Command::new(env!("CARGO_BIN_EXE_spinney"));
    program.env_remove("XDG_CACHE_HOME").env_remove("HOME");
    program.args("run scene.toml --quiet".split(' '));
    program
        .args(arguments.split_whitespace())
        .current_dir(folder);
    let output = program.output().expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("panicked"), "{said}");
    output.status.code()
}

#[test]
fn the_folder_is_whole_or_not_there() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("scene.toml"), text("mode = \"slots\"")).expect("writable");
    let listing = |name: &str| {
        let entries = std::fs::read_dir(at(name)).expect("a folder");
        let mut names: Vec<_> = entries
            .map(|entry| {
                entry
                    .expect("readable")
                    .file_name()
                    .into_string()
                    .expect("UTF-8")
            })
            .collect();
        names.sort();
        names
    };
    // Beside the run, twice; frames that are not drawn are not written.
    for _ in 0..2 {
        assert_eq!(
            run(folder.path(), "--export-frame frames --frames 1..3"),
            Some(0)
        );
        let wanted = [
            ".spinney",
            "frame-0001.camera.json",
            "frame-0001.glb",
            "frame-0002.camera.json",
            "frame-0002.glb",
        ];
        assert_eq!(listing("frames"), wanted);
    }
    for mixed in ["out/shrub", "out", "out/shrub/frames"] {
        let arguments = format!("--export-frame {mixed}");
        assert_eq!(run(folder.path(), &arguments), Some(2), "{mixed}");
    }
    std::fs::write(at("frames/notes.txt"), "mine").expect("writable");
    assert_eq!(run(folder.path(), "--export-frame frames"), Some(4));
    assert_eq!(listing("frames").len(), 6);
    let hidden = listing(".")
        .into_iter()
        .filter(|name| name.starts_with('.'));
    assert_eq!(hidden.collect::<Vec<_>>(), [""; 0]);
}
