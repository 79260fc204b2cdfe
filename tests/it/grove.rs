//! Woods of patches: what is culled and sent, that the order of drawing matters as far as it must, and that
//! trees stand where they would one by one.

use std::path::Path;

use spinney::gpu::Stream;
use spinney::math::{Mat4, Vec3};
use spinney::models::GroveView;
use spinney::raster::Image;
use spinney::run::{Frame, Session, SessionOptions, Silent, World};
use spinney::scene::{GroveBlend, GroveChoice, GroveOrder, GrovePacking, Scene, to_toml};

use crate::support::parse_wood;

const SCENE: &str = r##"schema = "spinney.scene/1"
size = [96, 64]
frames = 3
seed = 5

[[forest]]
species = ["a.toml", "b.toml", "c.toml"]
count = 12
layout = "patches"
area = [-16, -40, 16, 8]
spacing = 4
scale = [0.8, 1.2]

[terrain]
size = 100
cells = 6
amplitude = 0.5

[camera]
path = [
    { frame = 0, eye = [0, 4, 22], target = [0, 2, -20] },
    { frame = 2, eye = [6, 5, 4], target = [-3, 2, -20] },
]

[model]
name = "bare"
trunk = "branches"

[branches]
finest = 0.01

[grove]
levels = 4

[device]
card = "gtx770"
"##;

pub(super) fn scene() -> Scene {
    parse_wood(SCENE).expect("a sound scene")
}

pub(super) fn world(scene: &Scene) -> World {
    let folder = tempfile::tempdir().expect("a place for files");
    for (name, seed) in [("a", 1), ("b", 2), ("c", 3)] {
        let text = format!(
            "schema = \"spinney.species/1\"\nname = \"{name}{seed}\"\nleaf_count = 40\n\
             stop_leaves = 5\n[crown]\nlevels = 2\nscale = 4.0\n[[foliage]]\n\
             silhouette = \"pinnate_entire\"\nlength = 0.5\n"
        );
        std::fs::write(folder.path().join(format!("{name}.toml")), text).expect("a file");
    }
    grow(scene, folder.path())
}

fn grow(scene: &Scene, folder: &Path) -> World {
    World::build(scene, folder, &Silent).expect("species of our own")
}

pub(super) fn frames(scene: &Scene, world: &World) -> Vec<Frame> {
    let options = SessionOptions::exact(scene).expect("names that are known");
    let mut session = Session::new(scene, world, &options).expect("memory suffices");
    let frames = (0..scene.frames).map(|frame| session.frame(frame).expect("a sound frame"));
    frames.collect()
}

pub(super) fn with(choice: GroveChoice) -> Scene {
    Scene {
        grove: Some(choice),
        ..scene()
    }
}

fn pictures(frames: &[Frame]) -> Vec<&Image> {
    frames.iter().map(|frame| &frame.image).collect()
}

/// Sorted by fragment, nothing tells how the wood was packed, listed or passed over.
#[test]
fn the_truth_does_not_depend_on_the_order_of_drawing() {
    let world = world(&scene());
    let truth = GroveChoice {
        levels: 4,
        ..GroveChoice::TRUTH
    };
    let wanted = frames(&with(truth), &world);
    for (packing, order, levels_a_pass) in [
        (GrovePacking::Samples, GroveOrder::None, 4),
        (GrovePacking::Samples, GroveOrder::Device, 1),
        (GrovePacking::Patches, GroveOrder::Host, 2),
    ] {
        let found = frames(
            &with(GroveChoice {
                packing,
                order,
                levels_a_pass,
                ..truth
            }),
            &world,
        );
        assert_eq!(pictures(&found), pictures(&wanted), "{packing:?} {order:?}");
    }
}

/// Host and device sort alike; the host's way crosses the bus, by as much as is in view.
#[test]
fn lists_that_the_host_sorts_cross_the_bus_twice() {
    let world = world(&scene());
    let paper = GroveChoice {
        levels: 4,
        ..GroveChoice::PAPER
    };
    let on_host = frames(&with(paper), &world);
    let on_device = frames(
        &with(GroveChoice {
            order: GroveOrder::Device,
            ..paper
        }),
        &world,
    );
    assert_eq!(pictures(&on_host), pictures(&on_device));
    let naive = frames(
        &with(GroveChoice {
            levels: 4,
            ..GroveChoice::NAIVE
        }),
        &world,
    );
    assert_ne!(pictures(&on_host), pictures(&naive));
    let payload = |frame: &Frame, stream| frame.ledger.stream(stream).payload_bytes;
    let mut shown = 0;
    for (host, device) in on_host.iter().zip(&on_device).skip(1) {
        let sorted = payload(host, Stream::Upload) - payload(device, Stream::Upload);
        // Four records are looked at; each list that is sorted comes and goes.
        assert_eq!(payload(host, Stream::Readback), 4 * 16 + sorted);
        assert_eq!(payload(device, Stream::Readback), 0);
        assert_eq!(host.triangles, device.triangles);
        shown += sorted / 4;
    }
    assert!(shown > 4, "{shown} patches");
}

/// One draw a level for polygons and one for lines, however many patches there are; three times as many
/// where samples are drawn one by one. Polygons, which are opaque, are the same.
#[test]
fn draws_are_counted_by_level_and_part() {
    let world = world(&scene());
    let draws = |choice: GroveChoice| {
        let frames = frames(
            &with(GroveChoice {
                levels: 4,
                ..choice
            }),
            &world,
        );
        (frames[0].ledger.draws, frames[0].ledger.vertices)
    };
    let (packed, vertices) = draws(GroveChoice::PAPER);
    let (single, same) = draws(GroveChoice::NAIVE);
    // The ground is a draw of its own.
    assert_eq!([packed, single], [1 + 2 * 4, 1 + 2 * 4 * 3]);
    assert_eq!(vertices, same);
}

/// A patch shows at the coarsest level whose error is not seen, and not at all out of sight.
#[test]
fn levels_follow_the_distance() {
    let scene = scene();
    let world = world(&scene);
    let options = SessionOptions::exact(&scene).expect("names that are known");
    let session = Session::new(&scene, &world, &options).expect("memory suffices");
    let grove = session.groves()[0].grove();
    assert_eq!([grove.patch_count(), grove.sample_count()], [12, 3]);
    let mut last = 0;
    for away in [0.0, 20.0, 200.0, 2000.0] {
        let size = scene.size;
        let seen = scene.camera.at(0, size);
        let clip = Mat4::from_translation(Vec3::Z * 0.5) * Mat4::from_scale(Vec3::splat(1e-6));
        let view = GroveView {
            clip_from_world: clip,
            eye: Vec3::new(0.0, 0.0, away + 8.0),
            focal_pixels: seen.pixels_per_metre_at_1m,
        };
        let shown = grove.shown(&view);
        let patches: u32 = shown.iter().map(|(patches, _)| patches).sum();
        assert_eq!(patches, 12);
        let mean: u32 = (0..)
            .zip(&shown)
            .map(|(level, (patches, _))| level * patches)
            .sum();
        assert!(mean >= last, "{away} m: {shown:?}");
        last = mean;
        let counts: Vec<u64> = shown.iter().map(|(_, counts)| counts.total()).collect();
        assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
    }
    assert!(last > 0, "far patches are coarse");
    let aside = GroveView {
        clip_from_world: Mat4::from_translation(Vec3::splat(9.0))
            * Mat4::from_scale(Vec3::splat(1e-6)),
        eye: Vec3::ZERO,
        focal_pixels: 100.0,
    };
    assert!(grove.shown(&aside).iter().all(|(patches, _)| *patches == 0));
}

/// The trees of patches stand where they would one by one, and a scene says both.
#[test]
fn trees_of_patches_stand_alone_too() {
    let scene = scene();
    let text = to_toml(&scene);
    assert_eq!(parse_wood(&text).as_ref(), Ok(&scene));
    let alone = Scene {
        grove: None,
        ..scene.clone()
    };
    assert_ne!(alone.digest(), scene.digest());
    let trees = scene.standing_trees();
    assert_eq!(trees.len(), 36);
    for (one, other) in trees.iter().zip(&trees[3..]) {
        assert_eq!((one.scale, &one.source), (other.scale, &other.source));
    }
    let world = world(&scene);
    for (number, tree) in world.trees.iter().enumerate() {
        assert!(world.is_in_grove(number));
        let grove = &world.groves[0];
        let (place, sample) = (&grove.places[number / 3], &grove.samples[number % 3]);
        let found = place.to_world(sample.placement.position);
        let away = found.distance(tree.placement.position);
        assert!(
            away < 1e-4,
            "tree {number} stands {away} m beside its patch"
        );
    }
}

#[test]
fn wrong_groves_are_refused() {
    let refused = |from: &str, to: &str| {
        let text = SCENE.replace(from, to);
        assert_ne!(text, SCENE);
        parse_wood(&text).expect_err("a wrong scene")
    };
    let found = refused("trunk = \"branches\"", "trunk = \"full\"");
    assert!(found.contains("`model.trunk` is \"branches\""), "{found}");
    let found = refused("layout = \"patches\"", "layout = \"grid\"");
    assert!(found.contains("\"patches\""), "{found}");
    let found = refused("count = 12", "count = 30");
    assert!(found.contains("of 90 trees only 72 fit"), "{found}");
    let found = refused("levels = 4", "levels = 4\nlayers = 3");
    assert!(found.contains("`blend` is \"peeled\""), "{found}");
    let found = refused("levels = 4", "levels = 9");
    assert!(found.contains("levels"), "{found}");
}

/// Into the frame each level's lines are drawn once, whatever becomes of them; into other targets as often as
/// these need, and a quad for each that is then shown.
#[test]
fn every_way_to_blend_draws_the_same_primitives() {
    let world = world(&scene());
    let lines = |blend| {
        let choice = GroveChoice {
            levels: 4,
            blend,
            ..GroveChoice::PAPER
        };
        let frames = frames(&with(choice), &world);
        let ledger = &frames[0].ledger;
        (ledger.draws, ledger.primitives)
    };
    let (_, once) = lines(GroveBlend::Sorted);
    let (_, twice) = lines(GroveBlend::Weighted);
    let of_lines = twice - 1 - once;
    assert!(of_lines > 0);
    for &blend in GroveBlend::ALL {
        let layers = u64::from(GroveChoice::LAYERS);
        let (passes, quads) = match blend {
            GroveBlend::WritesDepth
            | GroveBlend::KeepsDepth
            | GroveBlend::Sorted
            | GroveBlend::Hashed
            | GroveBlend::Coverage => (1, 0),
            GroveBlend::Peeled => (layers, layers),
            GroveBlend::Weighted => (2, 1),
            GroveBlend::Moments => (3, 1),
        };
        let (draws, primitives) = lines(blend);
        // The ground, four levels of polygons, four of lines each pass.
        assert_eq!(draws, 1 + 4 + 4 * passes + quads, "{blend:?}");
        let wanted = once + (passes - 1) * of_lines + quads;
        assert_eq!(primitives, wanted, "{blend:?}");
    }
}

/// Lines are told apart from triangles, as many as were submitted.
#[test]
fn frames_tell_how_many_lines_they_have() {
    let world = world(&scene());
    let choice = GroveChoice {
        levels: 4,
        ..GroveChoice::PAPER
    };
    let whole = frames(&with(choice), &world);
    let alone = Scene {
        grove: None,
        ..scene()
    };
    let one_by_one = frames(&alone, &world);
    for frame in whole.iter().chain(&one_by_one) {
        assert!(frame.lines > 0, "frame {}", frame.frame);
        assert!(frame.ledger.primitives >= frame.lines, "{}", frame.lines);
    }
    for frame in &whole {
        assert_eq!(frame.ledger.primitives, frame.triangles + frame.lines);
    }
}
