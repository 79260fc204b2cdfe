//! Trees whose trunk has levels too: one axis for both, the same pictures whatever is resident.

use spinney::models::{Gather, Kind, ModelOptions, TrunkKind, TrunkLevel};
use spinney::run::{Session, SessionOptions, Shard, Silent, SweepOptions, Variant, sweep};
use spinney::scene::{ImageSize, TrunkMode, TrunkName};

use crate::support::{OPTIONS, birch_scene, birches, random_trunk, trunk_stage};

#[test]
fn trunks_follow_the_foliage_and_look_the_same_in_all_kinds() {
    let world = birches();
    let mut scene = birch_scene();
    scene.size = ImageSize::new(80, 60).expect("small");
    let trunk = world.trunks[0].as_ref().expect("a birch has one");
    let all = trunk.collapses().collapse_count();
    let mut shown = Vec::new();
    for kind in TrunkKind::all().filter(|kind| kind.has_levels() && !kind.has_errors()) {
        scene.model.trunk = kind.name;
        scene.model.trunk_mode = kind.mode;
        let options = SessionOptions::exact(&scene).expect("known names");
        assert_eq!(options.trunk, kind);
        let mut session = Session::new(&scene, world, &options).expect("memory suffices");
        let mut frames = Vec::new();
        for frame in [0, 3, 6, 0] {
            let frame = session.frame(frame).expect("its own device");
            for (state, tree) in frame.states.iter().zip(&world.trees) {
                let crown = &world.crowns[tree.crown];
                let done = state.foliage.collapse_count();
                let wanted = trunk.level(done, crown.sequence().collapse_count());
                assert_eq!(state.trunk, wanted);
            }
            let triangles =
                |state: &spinney::models::TreeState| u64::from(trunk.triangle_count(state.trunk));
            let wanted: u64 = frame.states.iter().map(triangles).sum();
            assert_eq!(frame.trunk_triangles, wanted);
            assert_eq!(frame.triangles, wanted + 2 * frame.leaves);
            let strips = frame.ledger.by_cause.contains_key("strip");
            let sends = kind.mode == TrunkMode::Device && kind.name != TrunkName::Mom;
            assert_eq!(strips, sends && frame.trunk_change.host_records > 0);
            frames.push((frame.image_digest, frame.states, frame.trunk_triangles));
        }
        assert_eq!(frames[0], frames[3], "{kind:?}");
        assert!(frames[0].2 > frames[1].2 && frames[1].2 > frames[2].2);
        assert!(frames[2].1[0].trunk.collapses() > all / 2);
        shown.push(frames);
    }
    assert!(shown.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn sweeps_take_the_trunk_that_a_variant_names() {
    let world = birches();
    let mut scene = birch_scene();
    scene.size = ImageSize::new(40, 30).expect("small");
    let labels = [
        "lodf-stamps",
        "lodf-stamps-gathered+lodstrips-device",
        "vdf-host+mom-host",
    ];
    let variants = labels.map(|label| Variant::labelled(label).expect("a label"));
    assert_eq!(variants.map(Variant::label), labels);
    let options = SweepOptions {
        variants: variants.to_vec(),
        steps: 2,
        shard: Shard::WHOLE,
        session: SessionOptions::exact(&scene).expect("known names"),
    };
    let sweep = sweep(&scene, world, &options, &Silent).expect("memory suffices");
    let trunk = world.trunks[0].as_ref().expect("a birch has one");
    for model in &sweep.models {
        for step in &model.steps {
            let level = match model.variant.trunk {
                Some(_) => trunk.level(step.step, 2),
                None => TrunkLevel::FINEST,
            };
            let kind = model.variant.trunk.unwrap_or(TrunkKind::FULL);
            let wanted = 2 * u64::from(kind.triangle_count(trunk, level));
            assert_eq!(step.trunk_triangles, wanted);
            let moved = step.step > 0 && model.variant.trunk.is_some();
            assert_eq!(step.trunk_change.collapses > 0, moved);
            assert_eq!(step.change.collapses > 0, step.step > 0);
        }
    }
    let both = |model: usize| &sweep.models[model].steps[2];
    assert_eq!(both(1).image_digest, both(2).image_digest);
}

#[test]
fn labels_name_every_pair_and_nothing_else() {
    for kind in Kind::LEAVES {
        for trunk in TrunkKind::all() {
            for [gathered, pruned] in [[false, false], [true, false], [false, true], [true, true]] {
                let variant = Variant {
                    gathered,
                    pruned,
                    trunk: Some(trunk),
                    ..Variant::usual(kind)
                };
                let found = Variant::labelled(&variant.label());
                let unsound = (gathered || (pruned && !kind.has_levels())) && found.is_none();
                assert!(found == Some(variant) || unsound);
            }
        }
    }
    for label in [
        "lodf-slots+",
        "+mom-host",
        "lodf-slots+mom",
        "lodf-cluster-gathered+mom-host",
        "lodf-cluster-u16-pruned",
        "full-pruned",
    ] {
        assert_eq!(Variant::labelled(label), None, "{label}");
    }
}

/// The price of a change of a trunk is what the ledger then has, for every kind and both ways to send.
#[test]
fn prices_of_trunks_are_what_the_ledger_says() {
    for seed in 0..12 {
        let trunk = random_trunk(seed);
        let last = trunk.collapses().collapse_count();
        for (kind, gather) in TrunkKind::all()
            .filter(|kind| !kind.has_errors())
            .flat_map(|kind| [Gather::Single, Gather::Regions].map(|gather| (kind, gather)))
        {
            let options = ModelOptions { gather, ..OPTIONS };
            let mut stage = trunk_stage(kind, options, &trunk, TrunkLevel::FINEST, 1);
            stage.device.take_ledger();
            for collapses in [last / 2, last, last / 3, 0] {
                let to = TrunkLevel::Collapses(collapses);
                let price = stage.resident.price(&to);
                crate::support::DeviceModel::commit(&mut stage, &to);
                let ledger = stage.device.take_ledger();
                assert_eq!(ledger.upload.payload_bytes, price, "{kind:?}");
                assert_eq!(stage.resident.price(&to), 0, "{kind:?}");
            }
        }
    }
}
