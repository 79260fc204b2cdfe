//! What stands in for leaves, held against them.

use std::sync::Arc;

use spinney::gpu::{Card, Link};
use spinney::math::{Stream, Vec3};
use spinney::models::{Crown, Kind, Placement};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::{
    Crossover, EqualDirect, OutputFolder, ReportError, STAND_IN_SCHEMA, Spread, StandInHeader,
    StandInMeter, StandInReport, crossover, equal_direct, stand_in_json, texture_table,
    write_stand_ins,
};
use spinney::run::{
    Leaves, SessionOptions, Silent, StandIn, StandInOptions, StandingTree, TextureSetting,
    ViewScale, World, crown, level_switches, stand_ins, switched_levels, texture_looks,
};
use spinney::scene::{CardCounts, ImageSize, SpriteScale};

use crate::support::{birch_scene, random_crown};

const LEAVES: u32 = 24;

/// A crown, and how it is looked at.
fn asked(kinds: Vec<Kind>, counts: Vec<u32>) -> (World, StandInOptions) {
    let tree = StandingTree {
        crown: 0,
        placement: Placement::IDENTITY,
    };
    let world = World::of(vec![random_crown(3, LEAVES, 2)], vec![tree]);
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Exact,
    };
    let mut session = SessionOptions::of(&birch_scene(), raster).expect("known names");
    session.size = ImageSize::new(48, 48).expect("small");
    let scales = ["near", "far"].into_iter().zip([2.0, 20.0]);
    let options = StandInOptions {
        kinds,
        counts,
        scales: scales
            .map(|(name, before)| ViewScale { name, before })
            .collect(),
        radii: [6.0, 24.0],
        session,
        field_of_view: 60.0,
    };
    (world, options)
}

fn meter(options: &StandInOptions) -> StandInMeter {
    StandInMeter::new(StandInHeader {
        scene: "a test".to_owned(),
        plant: "random".to_owned(),
        link: Link::ALL[0],
        card: Card::ALL[0],
        height: 48,
        field_of_view: 60.0,
        scales: options.scales.clone(),
    })
}

#[derive(Debug)]
#[expect(dead_code, reason = "shown when a test fails")]
enum Fault {
    Run(spinney::run::RunError),
    Report(ReportError),
}

impl From<spinney::run::RunError> for Fault {
    fn from(error: spinney::run::RunError) -> Self {
        Self::Run(error)
    }
}

fn report(kinds: Vec<Kind>, counts: Vec<u32>) -> StandInReport {
    let (world, options) = asked(kinds, counts);
    let mut meter = meter(&options);
    stand_ins(&world, &options, &Silent, |found| {
        meter.add(found).map_err(Fault::Report)
    })
    .expect("memory suffices");
    meter.finish()
}

/// As many planes as leaves: every leaf lies in its own, and so where it was.
#[test]
fn leaves_in_planes_of_their_own_look_like_leaves() {
    let report = report(Vec::new(), vec![LEAVES, 1]);
    let looks: Vec<_> = report
        .looks
        .iter()
        .map(|look| (look.stand_in.label(), look.scale, look.views))
        .collect();
    let names: Vec<&str> = looks.iter().map(|(name, ..)| name.as_str()).collect();
    let wanted = ["leaves", "flattened-24", "flattened-1"].map(|name| [name; 2]);
    assert_eq!(names, wanted.as_flattened());
    for (name, scale, views) in &looks[..4] {
        // Moved by rounding alone, which an edge of a leaf may see.
        assert!(views.flip.worst < 0.01, "{name} {scale}: {views:?}");
        assert!(views.silhouette.worst < 0.02, "{name} {scale}: {views:?}");
    }
    let equal = Spread {
        mean: 0.0,
        worst: 0.0,
    };
    assert_eq!([looks[0].2.flip, looks[1].2.flip], [equal; 2]);
    // A single plane hides most of what is seen along it.
    assert!(looks[4].2.covered.worst < 0.7, "{looks:?}");
    assert!(looks[4].2.flip.mean > 0.02, "{looks:?}");
}

#[test]
fn leaves_in_host_memory_take_longer_and_nothing_crosses() {
    let report = report(vec![Kind::LodfHost], vec![2]);
    let labels: Vec<String> = report
        .costs
        .iter()
        .map(|cost| cost.stand_in.label())
        .collect();
    assert_eq!(labels, ["leaves", "flattened-2", "lodf-host"]);
    let [leaves, flat, host] = &report.costs[..] else {
        panic!("three");
    };
    let radii: Vec<f32> = leaves.curve.iter().map(|point| point.radius).collect();
    assert_eq!(radii, [6.0, 12.0, 24.0]);
    for cost in [leaves, flat, host] {
        assert_eq!(cost.triangles, 2 * u64::from(LEAVES));
    }
    assert_eq!(leaves.resident_bytes, flat.resident_bytes);
    assert!(
        leaves
            .curve
            .iter()
            .all(|point| point.frames.fetch.payload_bytes == 0)
    );
    // Each frame pulls every leaf's four vertices over the bus, at least.
    let pulled = host.curve[0].frames.fetch.payload_bytes;
    assert!(pulled >= 4 * 4 * 12 * u64::from(LEAVES), "{pulled}");
    assert_eq!(crossover(leaves, host), Crossover::Slower);
}

/// Each is held against what it stands for, which came before it.
#[test]
fn cards_of_flattened_leaves_are_held_against_those() {
    let flat = StandIn {
        kind: Kind::Impostors,
        planes: Some(4),
        leaves: Leaves::Flattened,
    };
    assert_eq!(flat.label(), "impostors-direct-4 of flattened");
    assert_eq!(flat.reference().label(), "flattened-4");
    assert_eq!(flat.reference().reference(), StandIn::LEAVES);
    let report = report(vec![Kind::Impostors], vec![4]);
    let of = |label: &str| {
        let mut looks = report.looks.iter();
        let look = looks.find(|look| look.stand_in.label() == label && look.scale == 0);
        look.expect("it was looked at").views
    };
    let [all, planes, textures] = [
        "impostors-direct-4",
        "flattened-4",
        "impostors-direct-4 of flattened",
    ]
    .map(of);
    assert!(textures.flip.mean < all.flip.mean, "{textures:?} {all:?}");
    assert!(
        textures.flip.mean < planes.flip.mean,
        "{textures:?} {planes:?}"
    );
    // What stands for flattened leaves is looked at, not counted.
    assert_eq!(report.costs.len(), 3);
}

/// Long leaves of one shape and size, turned all ways, of two colours, so that which of two is nearer
/// shows.
fn equal_leaves(count: u32) -> Arc<Crown> {
    let mut draws = Stream::new(7, 7).draws();
    let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
    let mut group = |name: &str, color: [f32; 3]| {
        let mut positions = Vec::new();
        for _ in 0..count / 2 {
            let (centre, along) = (0.8 * vector(), vector().normalize_or(Vec3::X));
            let across = along.cross(vector()).normalize_or(Vec3::Y);
            let (along, across) = (0.3 * along, 0.12 * across);
            positions.extend([
                centre - along - across,
                centre + along - across,
                centre + along + across,
                centre - along + across,
            ]);
        }
        LeafGroup {
            name: name.to_owned(),
            prototype: Prototype::Quad {
                texture_corners: Prototype::WHOLE_IMAGE,
            },
            material: Material::plain("leaf", color),
            owners: vec![NO_BRANCH; positions.len() / 4],
            positions,
        }
    };
    let groups = vec![
        group("green", [0.1, 0.5, 0.1]),
        group("red", [0.7, 0.1, 0.1]),
    ];
    let plant = Plant::new("equal", None, None, Foliage { groups }).expect("sound parts");
    Arc::new(crown(plant, None))
}

/// At the end of the way impostors lie where those of the next level do, so that swapping them shows
/// less than going over at once.
#[test]
fn a_switch_alone_changes_less_than_a_level_does() {
    let (world, mut options) = asked(Vec::new(), Vec::new());
    options.session.model.cards.levels = CardCounts::new(&[8, 4, 2]).expect("descending");
    options.session.model.cards.texture = 128;
    // From where a crown of six pixels is seen, one pixel more or less decides.
    options.scales[1].before = 6.0;
    assert_eq!(
        switched_levels(&options.session.model.cards).as_slice(),
        [8, 4, 2]
    );
    let mut meter = meter(&options);
    let take = |look| meter.add_switch(look).map_err(Fault::Report);
    level_switches(&world, &options, &Silent, take).expect("memory suffices");
    let report = meter.finish();
    let found: Vec<_> = report
        .switches
        .iter()
        .map(|switch| (switch.scale, switch.counts))
        .collect();
    assert_eq!(found, [(0, [8, 4]), (0, [4, 2]), (1, [8, 4]), (1, [4, 2])]);
    for switch in &report.switches {
        let [alone, step, whole] = [&switch.switch, &switch.step, &switch.whole];
        assert!(alone.share() < whole.share(), "{switch:?}");
        assert!(alone.flip().mean < 0.9 * whole.flip().mean, "{switch:?}");
        assert!(step.flip().mean < 0.2 * whole.flip().mean, "{switch:?}");
    }
    let json: serde_json::Value = serde_json::from_str(&stand_in_json(&report)).expect("JSON");
    assert_eq!(json["switches"].as_array().map(Vec::len), Some(4));
}

/// Where leaves lie in the impostors' planes, nothing but textures is amiss, and less with more texels; a
/// texture of the front alone shows leaves in the wrong order from behind.
#[test]
fn textures_are_held_against_leaves_in_their_planes() {
    let (mut world, mut options) = asked(Vec::new(), Vec::new());
    world.crowns = vec![equal_leaves(48)];
    options.scales.truncate(1);
    // So large that a texel of the coarsest texture spans many pixels.
    options.session.size = ImageSize::new(192, 192).expect("small");
    options.session.model.cards.levels = CardCounts::new(&[4]).expect("one level");
    let direct = |side| TextureSetting::Direct { side };
    let indirect = TextureSetting::Indirect {
        map: 8,
        sprite: 32,
        turns: 64,
        scale: SpriteScale::Leaf,
    };
    let settings = [
        direct(16),
        direct(64),
        direct(256),
        TextureSetting::FrontAlone { side: 256 },
        indirect,
    ];
    let mut meter = meter(&options);
    let take = |found| meter.add_textures(found).map_err(Fault::Report);
    texture_looks(&world, &settings, &options, &Silent, take).expect("memory suffices");
    let found = meter.finish().textures;
    assert!(found.refused.is_empty(), "{found:?}");
    let flip: Vec<f64> = found
        .settings
        .iter()
        .map(|one| one.flip[0].1.mean)
        .collect();
    let [coarse, middle, fine, front, sprites] = flip[..] else {
        panic!("five settings: {flip:?}");
    };
    assert!(coarse > 1.5 * middle && middle > fine, "{flip:?}");
    assert!(front > 1.1 * fine && sprites > fine, "{flip:?}");
    let cost = &found.settings[4].cost;
    let maps = cost.maps.expect("it has maps");
    // Half of a 64th of a turn.
    assert!(
        maps.greatest_turn <= 2.813 && maps.most_leaves >= 2,
        "{maps:?}"
    );
    let equal = equal_direct(&found, settings[3], 0).expect("three were looked at");
    let EqualDirect::Between { side, bytes } = equal else {
        panic!("{equal:?}: {flip:?}");
    };
    let sizes = [0, 2].map(|one: usize| found.settings[one].cost.resident_bytes as f64);
    assert!(16.0 < side && side < 256.0 && sizes[0] < bytes && bytes < sizes[1]);
    assert_eq!(texture_table(&found, &options.scales).rows.len(), 5);
}

#[test]
fn a_report_is_a_folder_of_files() {
    let report = report(Vec::new(), vec![2]);
    let json: serde_json::Value = serde_json::from_str(&stand_in_json(&report)).expect("JSON");
    assert_eq!(json["schema"], STAND_IN_SCHEMA);
    assert_eq!(json["looks"].as_array().map(Vec::len), Some(4));
    let here = tempfile::tempdir().expect("a folder");
    let target = here.path().join("report");
    let folder = OutputFolder::create(&target).expect("a new folder");
    write_stand_ins(&folder, &report).expect("it can be written");
    folder.commit().expect("it can be written");
    for name in [
        "stand-ins.json",
        "looks.csv",
        "costs.csv",
        "sheet.png",
        "report.html",
        "plots/speed-up.svg",
        "pictures/flattened-2.png",
    ] {
        assert!(target.join(name).is_file(), "{name}");
    }
}
