//! Same scene, same bits: whatever the threads, the tiles, the counters, the model and the shard.
//!
//! What is held against each other: the plant, its collapses, pictures, and ledgers with every
//! transfer in order.

use std::sync::Arc;

use spinney::gpu::{DeviceDescriptor, Ledger, WorkCounts};
use spinney::math::Digester;
use spinney::models::{Crown, Kind, State, TreeState};
use spinney::plant::{Foliage, Plant};
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::LedgerEntry;
use spinney::run::{Frame, Session, SessionOptions, World};
use spinney::scene::{SampleCount, Scene};

use crate::support::{
    OPTIONS, Stage, StageExt as _, birch_scene, birches, descriptor, grow_birches, random_crown,
    random_state,
};

const TILES: [TileSize; 2] = [TileSize::Side32, TileSize::Side64];
const COUNTERS: [Counters; 2] = [Counters::Visible, Counters::Exact];
const SAMPLES: [SampleCount; 2] = [SampleCount::One, SampleCount::Four];
const PLAIN: Options = Options {
    tile: TileSize::Side32,
    counters: Counters::Visible,
};

fn session<'w>(
    scene: &'w Scene,
    world: &'w World,
    kind: Kind,
    samples: SampleCount,
    raster: Options,
) -> Session<'w> {
    let asked = SessionOptions::of(scene, raster).expect("known names");
    let options = SessionOptions {
        kind,
        samples,
        ..asked
    };
    Session::new(scene, world, &options).expect("memory suffices")
}

/// Pictures and ledgers of some frames, those between committed but not drawn.
fn frames(session: &mut Session<'_>, drawn: &[u32]) -> Vec<Frame> {
    let last = drawn.iter().max().copied().unwrap_or(0);
    let mut frames = Vec::new();
    for frame in 0..=last {
        if drawn.contains(&frame) {
            frames.push(session.frame(frame).expect("the session's own device"));
        } else {
            session.skip(frame).expect("the session's own device");
        }
    }
    frames
}

/// A ledger without what only exact counters know.
fn architectural(ledger: &Ledger) -> Ledger {
    Ledger {
        work: None,
        gpu_ticks: None,
        ..ledger.clone()
    }
}

#[test]
fn threads_tiles_and_counters_leave_no_trace() {
    let scene = birch_scene();
    let mut plants = Vec::new();
    let kinds = [Kind::VdfHost, Kind::LodfSlots, Kind::LodfStamps];
    // By kind and samples: what is the same for all, and for all with exact counters.
    let mut seen = vec![Vec::new(); kinds.len() * SAMPLES.len()];
    let mut exact = vec![Vec::new(); seen.len()];
    for threads in [1, 2, 7] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads can be had");
        pool.install(|| {
            let world = grow_birches();
            let digests = |crown: &Arc<Crown>| (crown.plant().digest(), crown.sequence().digest());
            plants.push(world.crowns.iter().map(digests).collect::<Vec<_>>());
            let cases = kinds
                .iter()
                .flat_map(|&kind| SAMPLES.map(|samples| (kind, samples)));
            for (case, (kind, samples)) in cases.enumerate() {
                for tile in TILES {
                    for counters in COUNTERS {
                        let options = Options { tile, counters };
                        let mut session = session(&scene, &world, kind, samples, options);
                        let frames = frames(&mut session, &[0, 3]);
                        let shown = frames.iter().map(|frame| {
                            let ledger = architectural(&frame.ledger);
                            (frame.image_digest, ledger, frame.change)
                        });
                        seen[case].push((session.initial().clone(), shown.collect::<Vec<_>>()));
                        if counters == Counters::Exact {
                            let work = frames.iter().map(|f| (f.ledger.work, f.ledger.gpu_ticks));
                            exact[case].push(work.collect::<Vec<_>>());
                        }
                    }
                }
            }
        });
    }
    assert!(plants.windows(2).all(|pair| pair[0] == pair[1]));
    for runs in &seen {
        assert_eq!(runs.len(), 3 * 2 * 2);
        assert!(runs.windows(2).all(|pair| pair[0] == pair[1]));
    }
    for runs in &exact {
        assert!(
            runs[0]
                .iter()
                .all(|(work, ticks)| work.is_some() && ticks.is_some())
        );
        assert!(runs.windows(2).all(|pair| pair[0] == pair[1]), "{runs:?}");
    }
}

/// Every sound kind shows every state alike; without levels, full detail.
#[test]
fn all_models_show_the_same_pictures() {
    let (scene, world) = (birch_scene(), birches());
    let crown = &world.crowns[0];
    let all = crown.sequence().collapse_count();
    let uniform = |collapses| State::Uniform { collapses };
    let finest_variable = State::Variable {
        counts: vec![0; crown.clusters().clusters.len()],
    };
    // Full detail in two guises, the coarsest, and some between; another for each tree.
    let variable: Vec<State> = (0..40)
        .map(|choice| random_state(crown, choice))
        .filter(|state| matches!(state, State::Variable { .. }))
        .take(2)
        .collect();
    let states = [
        [State::FINEST, State::FINEST],
        [finest_variable, State::FINEST],
        [uniform(all), uniform(all)],
        [uniform(all / 2), uniform(all - 40)],
        [variable[0].clone(), uniform(all / 3)],
        [uniform(77), variable[1].clone()],
    ];
    for samples in SAMPLES {
        let mut shown: Vec<Vec<_>> = vec![Vec::new(); states.len()];
        for kind in Kind::SOUND {
            let mut session = session(&scene, world, kind, samples, PLAIN);
            for (states, shown) in states.iter().zip(&mut shown) {
                let states = states.clone().map(TreeState::from);
                let change = session.commit_states(&states).expect("its own device");
                let frame = session.draw(0, change).expect("its own device");
                let pixels = session.covered_pixels();
                shown.push((
                    kind,
                    frame.image_digest,
                    frame.ledger.visible_samples,
                    pixels,
                ));
            }
        }
        for (number, shown) in shown.iter().enumerate() {
            let same = |&(_, digest, visible, pixels): &(Kind, _, _, _)| {
                (digest, visible, pixels) == (shown[1].1, shown[1].2, shown[1].3)
            };
            let sound = shown
                .iter()
                .filter(|(kind, ..)| kind.has_levels() || number < 2);
            let others: Vec<_> = sound.filter(|one| !same(one)).collect();
            assert!(
                others.is_empty(),
                "state {number}: {others:?} for {:?}",
                shown[1]
            );
        }
        let pictures: std::collections::BTreeSet<_> = shown.iter().map(|s| s[1].1).collect();
        assert_eq!(pictures.len(), states.len() - 1, "states can be told apart");
    }
}

#[test]
fn every_sample_is_killed_hidden_or_visible() {
    let (scene, world) = (birch_scene(), birches());
    for samples in SAMPLES {
        for kind in Kind::SOUND {
            let options = Options {
                counters: Counters::Exact,
                ..PLAIN
            };
            let mut session = session(&scene, world, kind, samples, options);
            let frame = session.frame(0).expect("its own device");
            let WorkCounts {
                covered,
                alpha_killed,
                hidden,
                ..
            } = frame.ledger.work.expect("exact counters");
            let visible = frame.ledger.visible_samples;
            assert_eq!(covered, alpha_killed + hidden + visible, "{kind:?}");
            assert!(alpha_killed > 0 && hidden > 0 && visible > 0, "{kind:?}");
            let sizes = 1..=u64::from(samples.get()) * 160 * 120;
            assert!(sizes.contains(&visible), "{kind:?}");
        }
    }
}

/// With one sample each covered one is tested once and each visible one is shaded once, at four
/// texels each, where there is a texture.
#[test]
fn texels_are_four_a_test_and_four_a_colour() {
    let device = DeviceDescriptor {
        raster: Options {
            counters: Counters::Exact,
            ..PLAIN
        },
        ..descriptor()
    };
    let crown = random_crown(8, 30, 4);
    // Nothing is killed, so that textures change no coverage.
    let work = |textured: bool| {
        let mut groups = crown.plant().foliage().groups.clone();
        for group in &mut groups {
            group.material.alpha_cutoff = 0.0;
            if !textured {
                group.material.texture = None;
            }
        }
        let plant = Plant::new("textured", None, None, Foliage { groups }).expect("sound parts");
        let crown = Arc::new(Crown::new(Arc::new(plant), crown.sequence().clone()));
        let model = Kind::LodfStamps.model(&crown, OPTIONS);
        let mut stage = Stage::on(device, &*model, &State::Uniform { collapses: 9 }, 64);
        stage.draw();
        let ledger = stage.device.take_ledger();
        (ledger.work.expect("exact counters"), ledger.visible_samples)
    };
    let [(textured, visible), (plain, _)] = [true, false].map(work);
    assert_eq!(textured.texels, 4 * (textured.covered + visible));
    assert_eq!(plain.texels, 0);
}

/// A shard commits every frame and draws its own: the same frames as one run draws.
#[test]
fn shards_draw_what_one_run_draws() {
    let (scene, world) = (birch_scene(), birches());
    let all: Vec<u32> = (0..scene.frames).collect();
    for kind in Kind::SOUND {
        let open = || session(&scene, world, kind, SampleCount::One, PLAIN);
        let whole = frames(&mut open(), &all);
        for shard in 0..3 {
            let own: Vec<u32> = all.iter().copied().filter(|f| f % 3 == shard).collect();
            let drawn = frames(&mut open(), &own);
            for frame in drawn {
                let wanted = &whole[frame.frame as usize];
                assert!(frame == *wanted, "{kind:?}, frame {}", frame.frame);
            }
        }
        // Where the camera rests nothing is sent again.
        assert!(whole[5].ledger.upload.transfers == 0, "{kind:?}");
    }
}

/// What must be the same on every machine, and with every later version until someone says why not.
///
/// To renew: run this test, look at what moved and why (a failure prints the new table), put the new
/// table here in a commit of its own that says so.
const PINNED: &str = "\
plant     4ae92bd6d54fa6377c8c9c1e3501322ac399bff1d6c3c812931a0865c52e4100
collapses c6f0c14361f21a03a217156e4025235ead0cd0e18fae7fba39f2162984e969f0
pictures  f0747a0f598549edcd37fc879f9da595998e43e688fb16a53942cc52e8abc0cd
ledgers   377a372f2d30c8bed63169ec374e6afedd53257c51b49d5057e9c82583642c60
";

/// A ledger as files have it: the entry of a frame, then each transfer.
fn counted(ledger: &Ledger) -> String {
    let entry = serde_json::to_string(&LedgerEntry::of_ledger(ledger)).expect("texts and numbers");
    let transfers = ledger.transfers.iter();
    transfers.fold(entry, |text, transfer| {
        text + "\n" + &serde_json::to_string(transfer).expect("texts and numbers")
    })
}

#[test]
fn one_run_is_pinned() {
    let (scene, world) = (birch_scene(), birches());
    let crown = &world.crowns[0];
    let mut pictures = Digester::new("spinney.test.pictures");
    let mut ledgers = Digester::new("spinney.test.ledgers");
    for kind in Kind::SOUND {
        let options = Options {
            counters: Counters::Exact,
            ..PLAIN
        };
        let mut session = session(&scene, world, kind, SampleCount::Four, options);
        ledgers.text(&counted(session.initial()));
        for frame in frames(&mut session, &[0, 2, 6]) {
            pictures.bytes(&frame.image.rgba);
            let change = frame.change;
            ledgers.text(&counted(&frame.ledger));
            for count in [change.collapses, change.splits, change.clusters_touched] {
                ledgers.u32(count);
            }
            ledgers.u64(change.host_records);
        }
    }
    let found = format!(
        "plant     {}\ncollapses {}\npictures  {}\nledgers   {}\n",
        crown.plant().digest(),
        crown.sequence().digest(),
        pictures.finish(),
        ledgers.finish(),
    );
    assert!(found == PINNED, "found\n{found}wanted\n{PINNED}");
}
