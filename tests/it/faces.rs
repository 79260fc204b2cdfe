//! Leaves of several faces: every model draws them, whatever the level, beside the quads that it simplifies.

use std::sync::Arc;

use spinney::document::Document;
use spinney::math::Vec3;
use spinney::models::{Crown, Kind, LEAF_GROUP, Placement, State, TreeChange, TreeState};
use spinney::plant::{Foliage, LeafGroup, Plant, Prototype};
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::frame_layers;
use spinney::report::{Layer, LayerSamples};
use spinney::run::{Session, SessionOptions, StandingTree, World, crown, mass};
use spinney::scene::{Scene, SceneFile};
use spinney::testkit::DeviceModel as _;

use crate::model_contracts::{SIDE, options};
use crate::support::{OPTIONS, Stage, StageExt as _, random_crown, with_faces};

/// The plant's leaves of several faces alone.
fn faces_only(crown: &Crown) -> Foliage {
    let groups = crown.plant().foliage().groups.iter();
    let faces = groups.filter(|group| matches!(group.prototype, Prototype::Faces { .. }));
    Foliage {
        groups: faces.cloned().collect(),
    }
}

fn plant(foliage: Foliage) -> Plant {
    Plant::new("tree", None, None, foliage).expect("sound parts")
}

/// Every quad as a leaf of two faces.
fn as_faces(foliage: &Foliage) -> Foliage {
    let group = |group: &LeafGroup| {
        let mut group = group.clone();
        if let Prototype::Quad { texture_corners } = &group.prototype {
            group.prototype = Prototype::Faces {
                texture_coordinates: texture_corners.to_vec(),
                triangles: vec![[0, 1, 2], [0, 2, 3]],
            };
        }
        group
    };
    Foliage {
        groups: foliage.groups.iter().map(group).collect(),
    }
}

#[test]
fn a_plant_without_quads_works_in_every_model() {
    let mixed = with_faces(&random_crown(3, 12, 3));
    let alone = Arc::new(crown(plant(faces_only(&mixed)), None));
    let mut pictures = Vec::new();
    for kind in Kind::LEAVES {
        for choice in [0, 12, 30] {
            let states = [State::FINEST, State::Variable { counts: Vec::new() }];
            let mut stage = Stage::at(kind, options(choice), &alone, &State::FINEST, SIDE);
            states.iter().for_each(|state| stage.commit(state));
            pictures.push(stage.draw());
            let bytes = kind.model(&alone, options(choice)).host_bytes();
            let storage = kind.model(&alone, options(choice)).storage();
            assert_eq!(bytes.len() as u64, storage.host_bytes, "{}", kind.label());
            let kept = storage.host_bytes + storage.shared_bytes;
            assert!(kept >= 36 * u64::from(alone.faces().face_count()));
        }
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
    let background = &pictures[0].rgba[..4];
    assert!(pictures[0].rgba.chunks(4).any(|pixel| pixel != background));
    // What judges levels finds one, which keeps everything.
    let masses = mass(&alone, &[State::FINEST]).expect("memory without bounds");
    assert_eq!(masses[0].leaves, alone.faces().leaf_count());
    assert!(masses[0].area > 0.0 && masses[0].mean_covered() > 0.0);
}

/// A flat leaf of two faces is the quad: not in a single bit does the picture differ.
#[test]
fn faces_are_lit_and_cut_as_quads_are() {
    for seed in 0..4 {
        let flat = random_crown(seed, 9, 9);
        // The random leaves are parallelograms: both of their triangles have the quad's normal, but
        // for what `f32` rounds, so leaves that lie along the axes are taken.
        let mut foliage = flat.plant().foliage().clone();
        for group in &mut foliage.groups {
            for corners in group.positions.chunks_exact_mut(4) {
                let [a, .., d] = [corners[0], corners[1], corners[2], corners[3]];
                let at = (a * 16.0).round() / 16.0;
                let up = ((d - a).length() * 16.0).ceil() / 16.0;
                let side = Vec3::new(0.5, 0.0, 0.0);
                let up = Vec3::new(0.0, up, 0.0);
                corners.copy_from_slice(&[at, at + side, at + side + up, at + up]);
            }
        }
        let quads = Arc::new(crown(plant(foliage.clone()), None));
        let faces = Arc::new(crown(plant(as_faces(&foliage)), None));
        assert_eq!(quads.faces().face_count(), 0);
        assert_eq!(faces.faces().face_count(), 18);
        let picture = |crown| Stage::at(Kind::Full, OPTIONS, crown, &State::FINEST, SIDE).draw();
        assert_eq!(picture(&quads), picture(&faces), "seed {seed}");
    }
}

/// One tree in front of a camera.
fn scene() -> Scene {
    let text = r#"schema = "spinney.scene/1"
size = [64, 64]
frames = 1
[[tree]]
species = "none.toml"
[camera]
path = [{ eye = [0.0, 0.0, 5.0], target = [0.0, 0.0, 0.0] }]
[device]
card = "gtx770"
"#;
    let (file, text) = ("one.toml".to_owned(), text.to_owned());
    SceneFile::parse(Document { file, text })
        .expect("a sound scene")
        .scene
}

fn numbers(layers: &[Layer], name: &str) -> Vec<u32> {
    let layer = layers.iter().find(|layer| layer.name == name);
    match &layer.expect("a layer of frames").samples {
        LayerSamples::U32(numbers) => numbers.clone(),
        LayerSamples::F32(_) => panic!("{name} holds floats"),
    }
}

#[test]
fn faces_are_counted_and_known_by_site() {
    let crown = with_faces(&random_crown(8, 10, 2));
    let (quads, faces) = (10, crown.faces());
    assert_eq!((faces.leaf_count(), faces.face_count()), (4, 12));
    let trees = vec![StandingTree {
        crown: 0,
        placement: Placement::IDENTITY,
    }];
    let (world, scene) = (World::of(vec![Arc::clone(&crown)], trees), scene());
    let raster = Options {
        tile: TileSize::Side32,
        counters: Counters::Visible,
    };
    let mut seen = Vec::new();
    for kind in Kind::SOUND {
        let asked = SessionOptions::of(&scene, raster).expect("known names");
        let asked = SessionOptions { kind, ..asked };
        let mut session = Session::new(&scene, &world, &asked).expect("memory suffices");
        let all = TreeState::from(State::Uniform { collapses: 0 });
        session.commit_states(&[all]).expect("its own device");
        let frame = session
            .draw(0, TreeChange::default())
            .expect("its own device");
        assert_eq!((frame.leaves, frame.triangles), (quads + 4, 2 * quads + 12));
        let target = session
            .device()
            .inspect_target(session.target())
            .expect("its target");
        let keys = (0..64).flat_map(|y| (0..64).map(move |x| target.key(x, y)));
        let keys: Vec<_> = keys.collect();
        let covered = keys.iter().flatten().filter(|key| key.group == LEAF_GROUP);
        assert_eq!(covered.count() as u64, session.covered_pixels());
        let layers = frame_layers(&session, &world, kind, asked.model, &frame);
        let leaves = numbers(&layers, "leaf");
        let mut shown = 0;
        for (key, leaf) in keys.iter().zip(&leaves) {
            let face = key.and_then(|key| faces.of_vertex(key.vertex));
            if let Some(face) = face {
                // The group of faces stands between those of 5 quads each.
                assert_eq!((face.group, face.site), (1, 5 + face.leaf));
                assert_eq!(*leaf, crown.sequence().record_count() + face.leaf);
                shown += 1;
            }
        }
        assert!(shown > 20, "{shown} pixels show leaves of several faces");
        // Whatever the level of the quads, the faces stay.
        let coarsest = State::Uniform {
            collapses: crown.sequence().collapse_count(),
        };
        if kind.has_levels() {
            let to = [TreeState::from(coarsest)];
            let change = session.commit_states(&to).expect("its own device");
            let frame = session.draw(0, change).expect("its own device");
            assert_eq!((frame.leaves, frame.triangles), (2 + 4, 4 + 12));
        }
        seen.push((frame.image_digest, leaves));
    }
    assert!(seen.iter().all(|one| *one == seen[0]));
}
