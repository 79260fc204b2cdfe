//! Bytes that are counted without pictures are those that pictures cost.

use std::process::Command;

use spinney::gpu::{Link, Stream};
use spinney::run::{
    ByteOptions, SessionOptions, Shard, Silent, StepTraffic, SweepOptions, Variant, bytes, sweep,
};
use spinney::scene::ImageSize;

use crate::support::{birch_scene, birches};

#[test]
fn a_plant_alone_costs_what_a_walk_with_pictures_counts() {
    let mut world = birches().clone();
    // Two trees of one plant: bytes are of the first alone.
    let mut scene = birch_scene();
    scene.size = ImageSize::new(40, 30).expect("small");
    let session = SessionOptions::exact(&scene).expect("known names");
    let labels = [
        "full",
        "vdf-indices",
        "lodf-cluster-pruned-u16",
        "lodf-slots-gathered",
        "lodf-device",
        "lodf-host-quantised+lodstrips-device",
    ];
    let variants = labels.map(|label| Variant::labelled(label).expect("a label"));
    let links = ["agp8x", "pcie5x16"].map(|name| Link::named(name).expect("a link"));
    let options = ByteOptions {
        variants: variants.to_vec(),
        steps: 3,
        links: links.to_vec(),
        session,
    };
    let found = bytes(&scene, &world, &options, &Silent).expect("memory suffices");
    assert_eq!(found.len(), 1);

    world.trees.truncate(1);
    let walk = SweepOptions {
        variants: variants.to_vec(),
        steps: 3,
        shard: Shard::WHOLE,
        session,
    };
    let drawn = sweep(&scene, &world, &walk, &Silent).expect("memory suffices");
    let frame_bytes: u64 = {
        let labels = &drawn.models[0].resident;
        let frame = labels.iter().find(|(label, _)| label == "frame");
        frame.expect("a target").1
    };
    for (plain, with_pictures) in found[0].models.iter().zip(&drawn.models) {
        let label = plain.variant.label();
        assert_eq!(plain.variant, with_pictures.variant);
        assert_eq!(
            plain.resident_bytes + frame_bytes,
            with_pictures.initial.resident_bytes,
            "{label}"
        );
        let mut sums = [StepTraffic::default(); 2];
        for (step, pictured) in plain.steps.iter().zip(&with_pictures.steps) {
            let ledger = &pictured.ledger;
            assert_eq!(step.leaves, pictured.leaves, "{label}");
            assert_eq!(step.command_bytes, ledger.command_bytes, "{label}");
            assert_eq!(step.vertices, ledger.vertices, "{label}");
            for (sum, traffic) in sums.iter_mut().zip(&step.traffic) {
                sum.add(traffic);
            }
        }
        for (sum, link) in sums.iter().zip(links) {
            let traffic = |stream| with_pictures.traffic_on(Some(link), stream);
            assert_eq!(sum.upload, traffic(Stream::Upload), "{label}");
            assert_eq!(sum.fetch, traffic(Stream::Fetch), "{label}");
        }
        let first = with_pictures.initial.upload.payload_bytes;
        assert_eq!(plain.initial[0].payload_bytes, first, "{label}");
        assert!(plain.initial[0].ticks != plain.initial[1].ticks, "{label}");
    }
}

#[test]
fn drawing_makes_no_sense_where_nothing_is_drawn() {
    for flag in [
        "--quality",
        "--size 9x9",
        "--samples 4",
        "--frames 0..1",
        "--shard 0/2",
    ] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_spinney"));
        let flags = flag.split(' ');
        program.args(["sweep", "scene.toml", "--bytes"]).args(flags);
        let output = program.output().expect("the program starts");
        assert_eq!(output.status.code(), Some(2), "{flag}");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains("cannot be used with"), "{said}");
    }
}
