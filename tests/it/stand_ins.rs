//! What stands in for leaves, held against them.

use spinney::gpu::{Card, Link};
use spinney::models::{Kind, Placement};
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::{
    Crossover, OutputFolder, ReportError, STAND_IN_SCHEMA, Spread, StandInHeader, StandInMeter,
    StandInReport, crossover, stand_in_json, write_stand_ins,
};
use spinney::run::{
    Leaves, SessionOptions, Silent, StandIn, StandInOptions, StandingTree, ViewScale, World,
    stand_ins,
};
use spinney::scene::ImageSize;

use crate::support::{birch_scene, random_crown};

const LEAVES: u32 = 24;

fn report(kinds: Vec<Kind>, counts: Vec<u32>) -> StandInReport {
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
    let mut meter = StandInMeter::new(StandInHeader {
        scene: "a test".to_owned(),
        plant: "random".to_owned(),
        link: Link::ALL[0],
        card: Card::ALL[0],
        height: 48,
        field_of_view: 60.0,
        scales: options.scales.clone(),
    });
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
