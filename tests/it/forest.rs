//! Forests and ground: where trees stand, what is sent once a species, and that nothing tells a
//! forest from the same trees one by one.

use std::path::Path;

use spinney::models::Placement;
use spinney::run::{Frame, Session, SessionOptions, Silent, World};
use spinney::scene::{PlantSource, Scene, to_toml};

use crate::support::parse_wood;

/// Three species, four trees of each, and one tree beside them.
const SCENE: &str = r##"schema = "spinney.scene/1"
size = [200, 130]
samples = 4
frames = 3
seed = 3

[[tree]]
species = "a.toml"
at = [1.0, 2.0, 3.0]

[[forest]]
species = ["a.toml", "b.toml", "c.toml"]
count = 4
area = [-12, -14.5, 12, 9]
spacing = 3.5
scale = [0.8, 1.2]

[terrain]
size = 30
cells = 10
amplitude = 1.5
wavelength = 11
steep_color = "#907860"

[camera]
path = [
    { frame = 0, eye = [0, 5, 14], target = [0, 2, 0] },
    { frame = 2, eye = [0, 6, 40], target = [0, 2, 0] },
]

[model]
d_min = 4.0
d_max = 45.0
"##;

fn scene() -> Scene {
    parse_wood(SCENE).expect("a sound scene")
}

/// The scene's species as files.
fn species() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a place for files");
    for (name, leaves) in [("a", 40), ("b", 60), ("c", 90)] {
        let text = format!(
            "schema = \"spinney.species/1\"\nname = \"{name}\"\nleaf_count = {leaves}\n\
             stop_leaves = 5\n[crown]\nlevels = 2\nscale = 4.0\n[[foliage]]\n\
             silhouette = \"pinnate_entire\"\nlength = 0.5\n"
        );
        std::fs::write(folder.path().join(format!("{name}.toml")), text).expect("a file");
    }
    folder
}

fn world(scene: &Scene, folder: &Path) -> World {
    World::build(scene, folder, &Silent).expect("species of our own")
}

/// All frames, their geometry within so many bytes.
fn frames(scene: &Scene, world: &World, geometry_bytes: u64) -> Vec<Frame> {
    let options = SessionOptions::exact(scene).expect("names that are known");
    let mut session = Session::new(scene, world, &options).expect("memory suffices");
    session.limit_geometry(geometry_bytes);
    let numbers = 0..scene.frames;
    numbers
        .map(|number| session.frame(number).expect("it draws"))
        .collect()
}

#[test]
fn a_forest_is_the_same_trees_one_by_one() {
    let folder = species();
    let forest = scene();
    let mut single = forest.clone();
    single.trees = forest.standing_trees();
    single.forests.clear();
    assert_eq!(single.trees.len(), 13);
    let ground = forest.terrain.expect("there is one");
    for tree in &single.trees[1..] {
        assert_eq!(tree.at.y, ground.height(tree.at.x, tree.at.z));
    }
    let (one, other) = (world(&forest, folder.path()), world(&single, folder.path()));
    assert_eq!(one.crowns.len(), 3, "each plant once");
    assert_eq!(one.trees, other.trees);
    let drawn = frames(&forest, &one, u64::MAX);
    assert_eq!(drawn, frames(&single, &other, u64::MAX));
    // However little may be held at once.
    assert_eq!(drawn, frames(&forest, &one, 50_000));
    assert_eq!(drawn, frames(&forest, &one, 0));
}

#[test]
fn a_resolved_forest_reads_back_equal() {
    let folder = species();
    let mut forest = scene();
    assert_eq!(parse_wood(&to_toml(&forest)), Ok(forest.clone()));
    let built = world(&forest, folder.path());
    let digests: Vec<_> = built.crowns.iter().map(|c| c.plant().digest()).collect();
    let question = forest.digest();
    forest.pin_plants(|tree| Some(digests[built.trees[tree].crown]));
    assert_eq!(forest.digest(), question, "plants are an answer");
    let again = parse_wood(&to_toml(&forest)).expect("sound");
    assert_eq!(again, forest);
    for (tree, standing) in again.standing_trees().iter().zip(&built.trees) {
        assert_eq!(tree.plant_digest, Some(digests[standing.crown]));
    }
    // A pinned plant must be the one that grows.
    let PlantSource::Species(path) = &forest.standing_trees()[12].source else {
        panic!("a species")
    };
    assert_eq!(path, "c.toml");
    std::fs::copy(folder.path().join("a.toml"), folder.path().join(path)).expect("a file");
    assert!(World::build(&again, folder.path(), &Silent).is_err());
    // What is asked for is in the digest.
    for (from, to) in [
        ("count = 4", "count = 3"),
        ("spacing = 3.5", "spacing = 3.4"),
        ("cells = 10", "cells = 9"),
        ("\"c.toml\"]", "\"d.toml\"]"),
    ] {
        let changed = parse_wood(&SCENE.replace(from, to)).expect("sound");
        assert_ne!(changed.digest(), question, "{to}");
    }
}

#[test]
fn what_a_species_shares_is_sent_once() {
    let folder = species();
    let scene = scene();
    let world = world(&scene, folder.path());
    let options = SessionOptions::exact(&scene).expect("names that are known");
    let session = Session::new(&scene, &world, &options).expect("memory suffices");
    let sent = |cause| session.initial().by_cause[cause].payload_bytes;
    let leaves = |crown: usize| u64::from(world.crowns[crown].sequence().original_count());
    let clusters = |crown: usize| u64::from(world.crowns[crown].sequence().root_count());
    assert_eq!(sent("vertices"), 48 * (leaves(0) + leaves(1) + leaves(2)));
    // A block and its draw arguments a tree: of the first species five, of the others four.
    let instance = |crown| 16 * leaves(crown) + 16 * clusters(crown);
    let records = 5 * instance(0) + 4 * instance(1) + 4 * instance(2);
    assert_eq!(sent("records"), records);
    assert_eq!(sent("placement"), (13 + 1) * Placement::STRIDE);
    // 11 × 11 corners, 10 × 10 cells, a colour, two texels and their mean.
    assert_eq!(sent("terrain"), 32 * 121 + 24 * 100 + 16 + 12);
}

#[test]
fn forests_that_cannot_be_are_refused_where_it_stands() {
    for (from, to, message) in [
        (
            "spacing = 3.5",
            "spacing = 20",
            "wood.toml:13:9: `forest.count`: found 4, wanted fewer: of 12 trees only",
        ),
        (
            "count = 4",
            "count = 6667",
            "13:9: `forest.count`: found 6667, wanted at most 19999 trees of all species, as the \
             scene has 1",
        ),
        (
            "[-12, -14.5, 12, 9]",
            "[-12, -15.5, 12, 9]",
            "14:8: `forest.area`: found [-12, -15.5, 12, 9], wanted an area of the terrain, whose \
             corners are -15 and 15",
        ),
        (
            "[-12, -14.5, 12, 9]",
            "[-12, 9, 12, 9]",
            "14:8: `forest.area`: found [-12, 9, 12, 9], wanted [x0, z0, x1, z1], numbers from \
             -100000 to 100000, x0 below x1 and z0 below z1",
        ),
        (
            "scale = [0.8, 1.2]",
            "scale = [1.2, 0.8]",
            "16:15: `forest.scale`: found 0.8, wanted [least, greatest], numbers from 0.001 to \
             1000, not descending",
        ),
        (
            "[\"a.toml\", \"b.toml\", \"c.toml\"]",
            "[]",
            "12:11: `forest.species`: found [], wanted a path relative to the scene file, with `/` \
             between its parts, or a list of at most 64",
        ),
        (
            "spacing = 3.5",
            "plant_digests = []",
            "15:17: `forest.plant_digests`: found [], wanted one digest a species: 3, not 0",
        ),
        (
            "cells = 10",
            "cells = 1025",
            "20:9: `terrain.cells`: found 1025, wanted an integer from 1 to 1024",
        ),
    ] {
        let found = parse_wood(&SCENE.replace(from, to)).expect_err(to);
        assert!(found.contains(message), "{found}");
    }
    let nobody = "schema = \"spinney.scene/1\"\n[camera]\npath = []\n";
    let found = parse_wood(nobody).expect_err("no tree");
    assert!(
        found.contains("`tree`: found nothing, wanted a [[tree]] or a [[forest]]"),
        "{found}"
    );
    // One species needs no list.
    let alone = parse_wood(&SCENE.replace("[\"a.toml\", \"b.toml\", \"c.toml\"]", "\"a.toml\""));
    assert_eq!(alone.expect("sound").standing_trees().len(), 5);
}
