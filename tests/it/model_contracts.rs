//! Every model and mode keeps the [laws](spinney::testkit::laws), on random crowns and random walks through
//! states; a test at the end plants the bugs that the laws name.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_oneof, proptest};
use spinney::math::{Draws, Quat, Stream, Vec3, index_u32, index_usize};
use spinney::models::{
    Camera, Criterion, Crown, Extent, Extraction, Gather, Kind, LeafFormat, ModelOptions,
    Placement, Records, State, TrunkKind, TrunkLevel, View,
};
use spinney::scene::{TrunkMode, TrunkName};
use spinney::testkit::laws::{
    birth_before_death, conservation, image_equality, partition, residency, same_picture,
};
use spinney::testkit::strategy::{self, WalkOptions};
use spinney::testkit::{
    DeviceModel as _, History, Law, ModelStructure, Tally, TreeWalk, Violation, check_end,
    check_structure,
};

use crate::laws::check_conservation;
use crate::support::{
    Cases, OPTIONS, Stage, StageExt as _, random_crown, random_trunk, trunk_picture, trunk_stage,
};

const SIDE: u32 = 48;
const TRUNK_SIDE: u32 = 24;

/// Both ways to extract and to send, and all formats, by a number.
fn options(choice: u64) -> ModelOptions {
    ModelOptions {
        extraction: if choice & 1 == 0 {
            Extraction::Single
        } else {
            Extraction::Batched
        },
        gather: if choice & 2 == 0 {
            Gather::Single
        } else {
            Gather::Regions
        },
        format: LeafFormat::ALL[index_usize(choice >> 2 & 3)],
    }
}

/// How the same leaves look to everyone else: vertices are where they are.
fn reference_options(options: ModelOptions) -> ModelOptions {
    ModelOptions {
        format: LeafFormat {
            records: Records::Wide,
            ..options.format
        },
        ..OPTIONS
    }
}

/// One walk: all laws at every step, images at the end and at one step between.
fn walk(kind: Kind, seed: u64, case: &TreeWalk, tally: &mut Tally) -> Result<(), Violation> {
    let (crown, options) = (&case.crown(), options(seed));
    let history = &case.walk.history;
    let states = case.walk.states();
    // The first state is the start.
    let Some((start, states)) = states.split_first() else {
        return Ok(());
    };
    let mut walked = Stage::at(kind, options, crown, start, 8);
    let model = kind.model(crown, options);
    let looked_at = [
        states.len(),
        1 + index_usize((seed >> 8) % states.len().max(1) as u64),
    ];
    for (step, state) in (1..).zip(states) {
        walked.commit(state);
        let stands = walked.resident.state() == state || !kind.has_levels();
        assert!(stands, "a resident says what it shows");
        let mut fresh = Stage::at(kind, options, crown, state, 8);
        tally.count(Law::Residency, residency(&mut walked, &mut fresh))?;
        if kind.has_levels() {
            let drawn = model.drawn(state);
            let law = birth_before_death(history, state, &drawn);
            tally.count(Law::BirthBeforeDeath, law)?;
            tally.count(Law::Partition, partition(history, state, &drawn))?;
        }
        if looked_at.contains(&step) {
            let shown = if kind.has_levels() {
                state
            } else {
                &State::FINEST
            };
            let mut walked = Stage::at(kind, options, crown, start, SIDE);
            states[..step].iter().for_each(|state| walked.commit(state));
            let mut fresh = Stage::at(kind, options, crown, state, SIDE);
            let others = reference_options(options);
            let reference = Stage::at(Kind::LodfCluster, others, crown, shown, SIDE).draw();
            check_end(&mut walked, &mut fresh, Some(&reference), tally)?;
        }
    }
    Ok(())
}

fn cases() -> impl Strategy<Value = TreeWalk> {
    strategy::tree_walk(WalkOptions {
        leaves: 2..=19,
        roots: 1..=4,
        // The start, and up to 59 steps.
        steps: 2..=60,
    })
}

/// One walk of a trunk: residency at every step, images and the ledger at the end. All kinds but the
/// full one draw what the plain list of the level's triangles draws.
fn trunk_walk(
    kind: TrunkKind,
    seed: u64,
    levels: &[u32],
    tally: &mut Tally,
) -> Result<(), Violation> {
    let (trunk, options) = (&random_trunk(seed), options(seed));
    let most = u64::from(trunk.collapses().collapse_count());
    let level = |&share: &u32| TrunkLevel {
        collapses: index_u32(index_usize(u64::from(share) * most / u64::from(u32::MAX))),
    };
    let levels: Vec<TrunkLevel> = levels.iter().map(level).collect();
    let (Some((&start, levels)), Some(&last)) = (levels.split_first(), levels.last()) else {
        return Ok(());
    };
    let mut walked = trunk_stage(kind, options, trunk, start, TRUNK_SIDE);
    for &level in levels {
        walked.commit(&level);
        let stands = *walked.resident.state() == level || !kind.has_levels();
        assert!(stands, "a resident says what it shows");
        let mut fresh = trunk_stage(kind, options, trunk, level, TRUNK_SIDE);
        tally.count(Law::Residency, residency(&mut walked, &mut fresh))?;
    }
    let mut fresh = trunk_stage(kind, options, trunk, last, TRUNK_SIDE);
    let has_levels = kind.has_levels();
    let reference = has_levels.then(|| trunk_picture(trunk, last, TRUNK_SIDE));
    check_end(&mut walked, &mut fresh, reference.as_ref(), tally)
}

/// What has contracts.
trait Contracts: Copy {
    /// Checks some walks.
    fn check(self, name: &'static str);
}

impl Contracts for Kind {
    fn check(self, name: &'static str) {
        let count = Cases::of(name);
        proptest!(config(name, 2000), |(seed in any::<u64>(), case in cases())| {
            count.one();
            let mut tally = Tally::default();
            let law = walk(self, seed, &case, &mut tally);
            count.checked(&tally);
            law?;
        });
    }
}

impl Contracts for TrunkKind {
    fn check(self, name: &'static str) {
        let count = Cases::of(name);
        let levels = || {
            vec(
                prop_oneof![4 => any::<u32>(), 1 => Just(0), 1 => Just(u32::MAX)],
                2..8,
            )
        };
        proptest!(config(name, 400), |(seed in any::<u64>(), levels in levels())| {
            count.one();
            let mut tally = Tally::default();
            let law = trunk_walk(self, seed, &levels, &mut tally);
            count.checked(&tally);
            law?;
        });
    }
}

fn config(name: &'static str, cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        test_name: Some(name),
        source_file: Some(file!()),
        ..ProptestConfig::default()
    }
}

const fn trunk(name: TrunkName, mode: TrunkMode) -> TrunkKind {
    TrunkKind { name, mode }
}

macro_rules! contracts {
    ($($name:ident: $kind:expr;)*) => {$(
        #[test]
        fn $name() {
            $kind.check(concat!(module_path!(), "::", stringify!($name)));
        }
    )*};
}

contracts! {
    full: Kind::Full;
    vdf_host: Kind::VdfHost;
    vdf_indices: Kind::VdfIndices;
    lodf_host: Kind::LodfHost;
    lodf_cluster: Kind::LodfCluster;
    lodf_slots: Kind::LodfSlots;
    lodf_stamps: Kind::LodfStamps;
    lodf_device: Kind::LodfDevice;
    trunk_full: trunk(TrunkName::Full, TrunkMode::Device);
    trunk_full_host: trunk(TrunkName::Full, TrunkMode::Host);
    trunk_lodstrips: trunk(TrunkName::LodStrips, TrunkMode::Device);
    trunk_lodstrips_host: trunk(TrunkName::LodStrips, TrunkMode::Host);
    trunk_lodstrips_cut: trunk(TrunkName::LodStripsCut, TrunkMode::Device);
    trunk_lodstrips_cut_host: trunk(TrunkName::LodStripsCut, TrunkMode::Host);
    trunk_mom: trunk(TrunkName::Mom, TrunkMode::Device);
    trunk_mom_host: trunk(TrunkName::Mom, TrunkMode::Host);
}

/// Storage is what lies there, host and device.
#[test]
fn trunks_take_what_they_say() {
    for seed in 0..12 {
        let trunk = random_trunk(seed);
        for kind in TrunkKind::all() {
            let model = kind.model(&trunk, OPTIONS);
            let storage = model.storage();
            assert_eq!(
                storage.host_bytes,
                model.host_bytes().len() as u64,
                "{kind:?}"
            );
            let stage = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, 4);
            let on_device = stage.device.resident_by_label();
            let trunks = on_device
                .iter()
                .filter(|(label, _)| label.starts_with("trunk ") && label != "trunk surface");
            let held: u64 = trunks.map(|(_, bytes)| bytes).sum();
            assert_eq!(
                held,
                storage.shared_bytes + storage.instance_bytes,
                "{kind:?}"
            );
        }
    }
}

/// The same laws where nobody sends a state: the device selects by the camera, and what it selects is
/// what the host would.
#[test]
fn lodf_device_by_camera() {
    let name = concat!(module_path!(), "::lodf_device_by_camera");
    let count = Cases::of(name);
    let config = ProptestConfig {
        cases: 300,
        test_name: Some(name),
        source_file: Some(file!()),
        ..ProptestConfig::default()
    };
    proptest!(config, |(seed in any::<u64>(), case in cases())| {
        count.one();
        let mut tally = Tally::default();
        let law = by_camera(seed, &case.crown(), &mut tally);
        count.checked(&tally);
        law?;
    });
}

/// A camera about the stage, near or far, now uniform, now variable.
fn random_camera(draws: &mut Draws) -> Camera {
    let mut coordinate = || 6.0 * draws.signed();
    let eye = Vec3::new(coordinate(), coordinate(), coordinate());
    let nearest = 3.0 * draws.unit();
    Camera {
        eye,
        criterion: Criterion {
            nearest,
            farthest: nearest + 0.5 + 6.0 * draws.unit(),
            extent: if draws.below(2) == 0 {
                Extent::Uniform
            } else {
                Extent::Variable
            },
        },
    }
}

fn by_camera(seed: u64, crown: &Arc<Crown>, tally: &mut Tally) -> Result<(), Violation> {
    let options = options(seed);
    let kind = Kind::LodfDevice;
    let mut draws = Stream::new(seed, 9).draws();
    // Wherever the tree stands: distances are judged in the world.
    let placement = Placement {
        position: 0.3 * Vec3::new(draws.signed(), draws.signed(), draws.signed()),
        rotation: Quat::from_array([0.0, 0.6, 0.0, 0.8]),
        scale: 0.5 + draws.unit(),
    };
    let fresh = |camera: &Camera, side| {
        let start = Stage::at(kind, options, crown, &State::FINEST, side);
        looking(start, crown, &placement, camera)
    };
    let mut walked = fresh(&random_camera(&mut draws), SIDE);
    walked.device.take_ledger();
    for step in 0..12 {
        // Now and then the application dictates a state between two cameras.
        if draws.below(4) == 0 {
            let all = u64::from(crown.sequence().collapse_count());
            let collapses = index_u32(index_usize(draws.below(all + 1)));
            walked.commit(&State::Uniform { collapses });
            walked.device.take_ledger();
            let mut back = looking(walked, crown, &placement, &random_camera(&mut draws));
            let sent = back.device.take_ledger().by_cause["counter"].payload_bytes;
            assert_eq!(sent, 4, "the source changes");
            walked = back;
        }
        let camera = random_camera(&mut draws);
        walked = looking(walked, crown, &placement, &camera);
        let ledger = walked.device.take_ledger();
        let causes: Vec<_> = ledger.by_cause.iter().collect();
        assert!(
            causes
                .iter()
                .all(|(cause, _)| **cause == "camera" || **cause == "placement"),
            "only the camera is sent: {causes:?}"
        );
        let sent = ledger.by_cause["camera"].payload_bytes;
        assert_eq!(sent, 24, "the camera, whatever changes");
        tally.count(
            Law::Residency,
            residency(&mut walked, &mut fresh(&camera, 8)),
        )?;
        let state = camera.select(crown, &placement);
        assert!(
            walked.resident.state() == &state,
            "a resident says what it shows"
        );
        if step % 4 == 3 {
            let others = reference_options(options);
            let mut reference = Stage::at(Kind::LodfCluster, others, crown, &state, SIDE);
            let queue = &mut reference.device.queue();
            let placed = reference.environment.place(queue, 0, &placement);
            placed.expect("there is room");
            let reference = reference.draw();
            let law = image_equality(
                &mut fresh(&camera, SIDE),
                &mut fresh(&camera, SIDE),
                Some(&reference),
            );
            tally.count(Law::ImageEquality, law)?;
            let law = same_picture("after the walk", &reference, &walked.draw());
            tally.count(Law::ImageEquality, law)?;
        }
    }
    tally.count(
        Law::Conservation,
        conservation(&mut fresh(&random_camera(&mut draws), 8)),
    )?;
    Ok(())
}

/// The stage with its tree standing there and seen by a camera.
fn looking(mut stage: Stage, crown: &Crown, placement: &Placement, camera: &Camera) -> Stage {
    let environment = stage.environment;
    let mut queue = stage.device.queue();
    let sent = environment
        .place(&mut queue, 0, placement)
        .and_then(|()| environment.set_camera(&mut queue, camera))
        .and_then(|()| {
            let state = camera.select(crown, placement);
            stage.resident.follow(&mut queue, &state)
        });
    sent.expect("the stage's own device");
    stage
}

/// Clusters out of sight are not drawn, and the picture is that of all leaves.
#[test]
fn what_lies_out_of_sight_is_culled_and_nothing_shows_it() {
    let count = Cases::of(concat!(
        module_path!(),
        "::what_lies_out_of_sight_is_culled"
    ));
    let mut culled = 0;
    for seed in 0..120 {
        count.one();
        let crown = random_crown(seed, 24, 19);
        let options = options(seed << 2);
        let others = reference_options(options);
        let mut draws = Stream::new(seed, 10).draws();
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        let (eye, target) = (2.5 * vector(), vector());
        let direction = (target - eye).normalize_or(Vec3::NEG_Z);
        let perspective = glam::camera::rh::proj::directx::perspective(1.2, 1.0, 0.05, 50.0);
        let view = View {
            clip_from_world: perspective
                * glam::camera::rh::view::look_to_mat4(eye, direction, Vec3::Y),
            to_light: Vec3::Y,
            light: Vec3::ONE,
            ambient: Vec3::ONE,
        };
        let shown = |kind: Kind, options| {
            let state = State::Uniform { collapses: 3 };
            let mut stage = Stage::at(kind, options, &crown, &state, SIDE);
            let sent = stage.environment.set_view(&mut stage.device.queue(), &view);
            sent.expect("the stage's own device");
            let picture = stage.draw();
            (picture, stage.device.take_ledger().empty_draws)
        };
        let (picture, empty) = shown(Kind::LodfDevice, options);
        let (reference, _) = shown(Kind::LodfCluster, others);
        assert!(picture == reference, "seed {seed}");
        culled += empty;
    }
    assert!(culled > 100, "only {culled} clusters were culled");
}

/// What each model means to show, step by step.
#[test]
fn models_are_sound_structures() {
    let count = Cases::of(concat!(module_path!(), "::models_are_sound_structures"));
    let options = WalkOptions {
        leaves: 1..=24,
        roots: 1..=5,
        steps: 1..=20,
    };
    proptest!(ProptestConfig::with_cases(500), |(case in strategy::tree_walk(options))| {
        count.one();
        let crown = case.crown();
        for kind in Kind::SOUND.into_iter().filter(|kind| kind.has_levels()) {
            let mut tally = Tally::default();
            let build = |_: &History| ModelStructure::new(kind.model(&crown, OPTIONS));
            let law = check_structure(&case.walk, build, &mut tally);
            count.checked(&tally);
            law?;
        }
    });
}

mod seeded {
    //! Broken residents, each of which one law must catch.

    use spinney::gpu::{Command, Draw, DrawFromCounter, DrawIndirect, GpuError, Queue, Step};
    use spinney::models::{Change, Resident};

    use super::*;

    /// A sound resident with one fault.
    #[derive(Debug)]
    struct Faulty {
        inner: Box<dyn Resident>,
        shown: State,
        fault: Fault,
    }

    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Fault {
        /// Commits one collapse more than asked for.
        OffByOne,
        /// Draws less than what is resident.
        StopsShort,
    }

    impl Resident for Faulty {
        fn state(&self) -> &State {
            &self.shown
        }

        fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
            self.shown = to.clone();
            match (self.fault, to) {
                (Fault::OffByOne, State::Uniform { collapses }) => self.inner.commit(
                    queue,
                    &State::Uniform {
                        collapses: collapses + 1,
                    },
                ),
                _ => self.inner.commit(queue, to),
            }
        }

        fn price(&self, to: &State) -> u64 {
            self.inner.price(to)
        }

        fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
            self.inner.cluster_price(cluster, collapses)
        }

        fn host_bytes(&self) -> u64 {
            self.inner.host_bytes()
        }

        fn prepare(&self, commands: &mut Vec<Command>) {
            self.inner.prepare(commands);
        }

        fn draw(&self, steps: &mut Vec<Step>) {
            self.inner.draw(steps);
            if self.fault == Fault::StopsShort {
                for step in steps {
                    match step {
                        Step::Draw(Draw { corner_count, .. }) => *corner_count -= 4,
                        Step::DrawIndirect(DrawIndirect { count, .. })
                        | Step::MultiDrawIndirect(DrawIndirect { count, .. }) => *count -= 1,
                        Step::DrawFromCounter(DrawFromCounter { end, .. }) => *end -= 40,
                        _ => {}
                    }
                }
            }
        }
    }

    fn faulty(kind: Kind, crown: &Arc<Crown>, to: &State, fault: Fault) -> Stage {
        let mut stage = Stage::at(kind, OPTIONS, crown, &State::FINEST, SIDE);
        let empty = Stage::at(Kind::Full, OPTIONS, crown, &State::FINEST, 1).resident;
        let inner = std::mem::replace(&mut stage.resident, empty);
        stage.resident = Box::new(Faulty {
            inner,
            shown: State::FINEST,
            fault,
        });
        stage.commit(to);
        stage
    }

    const HALF: State = State::Uniform { collapses: 4 };

    #[test]
    fn residency_catches_a_commit_of_another_state() {
        let crown = random_crown(5, 12, 2);
        for kind in Kind::SOUND.into_iter().filter(|kind| kind.has_levels()) {
            let mut walked = faulty(kind, &crown, &HALF, Fault::OffByOne);
            let mut fresh = Stage::at(kind, OPTIONS, &crown, &HALF, SIDE);
            assert!(residency(&mut walked, &mut fresh).is_err(), "{kind:?}");
        }
    }

    #[test]
    fn images_catch_a_draw_that_stops_short_and_residency_does_not() {
        let crown = random_crown(5, 12, 2);
        let reference = Stage::at(Kind::LodfCluster, OPTIONS, &crown, &HALF, SIDE).picture();
        for kind in Kind::SOUND.into_iter().filter(|kind| kind.has_levels()) {
            let mut fresh = Stage::at(kind, OPTIONS, &crown, &HALF, SIDE);
            let mut sound = Stage::at(kind, OPTIONS, &crown, &HALF, SIDE);
            assert!(
                image_equality(&mut sound, &mut fresh, reference.as_ref()).is_ok(),
                "{kind:?}"
            );
            let mut short = faulty(kind, &crown, &HALF, Fault::StopsShort);
            assert!(
                image_equality(&mut short, &mut fresh, reference.as_ref()).is_err(),
                "{kind:?}"
            );
        }
    }

    /// A sound trunk with one fault.
    #[derive(Debug)]
    struct FaultyTrunk {
        inner: Box<dyn Resident<TrunkLevel>>,
        shown: TrunkLevel,
        fault: Fault,
    }

    impl Resident<TrunkLevel> for FaultyTrunk {
        fn state(&self) -> &TrunkLevel {
            &self.shown
        }

        fn commit(&mut self, queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
            self.shown = *to;
            let further = u32::from(self.fault == Fault::OffByOne);
            let to = TrunkLevel {
                collapses: to.collapses + further,
            };
            self.inner.commit(queue, &to)
        }

        fn price(&self, to: &TrunkLevel) -> u64 {
            self.inner.price(to)
        }

        fn host_bytes(&self) -> u64 {
            self.inner.host_bytes()
        }

        fn draw(&self, steps: &mut Vec<Step>) {
            self.inner.draw(steps);
            if self.fault == Fault::StopsShort {
                for step in steps {
                    match step {
                        Step::Draw(Draw { corner_count, .. }) => *corner_count /= 2,
                        Step::DrawIndirect(DrawIndirect { count, .. }) => *count -= 1,
                        _ => {}
                    }
                }
            }
        }
    }

    /// Of the trunks with these seeds, how often a fault is caught at half detail.
    fn caught(kind: TrunkKind, fault: Fault) -> u32 {
        let mut caught = 0;
        for seed in 0..10 {
            let trunk = random_trunk(seed);
            let half = TrunkLevel {
                collapses: trunk.collapses().collapse_count() / 2,
            };
            let mut walked = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, TRUNK_SIDE);
            let other = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, 4).resident;
            walked.resident = Box::new(FaultyTrunk {
                inner: std::mem::replace(&mut walked.resident, other),
                shown: TrunkLevel::FINEST,
                fault,
            });
            walked.commit(&half);
            let mut fresh = trunk_stage(kind, OPTIONS, &trunk, half, TRUNK_SIDE);
            let reference = trunk_picture(&trunk, half, TRUNK_SIDE);
            let law = match fault {
                Fault::OffByOne => residency(&mut walked, &mut fresh),
                Fault::StopsShort => image_equality(&mut walked, &mut fresh, Some(&reference)),
            };
            caught += u32::from(law.is_err());
        }
        caught
    }

    #[test]
    fn faults_of_trunks_are_caught() {
        for kind in TrunkKind::all().filter(|kind| kind.has_levels()) {
            assert!(caught(kind, Fault::OffByOne) >= 9, "{kind:?}");
            assert!(caught(kind, Fault::StopsShort) >= 5, "{kind:?}");
        }
    }

    #[test]
    fn conservation_catches_a_byte_changed_behind_the_bus() {
        let crown = random_crown(5, 12, 2);
        let mut stage = Stage::at(Kind::LodfSlots, OPTIONS, &crown, &State::FINEST, SIDE);
        stage.commit(&HALF);
        let payload = stage.device.take_ledger().upload.payload_bytes;
        assert!(check_conservation(&stage.device, payload).is_ok());
        assert!(check_conservation(&stage.device, payload + 1).is_err());
        let named = |label: &str| {
            let found = stage.device.buffers().find(|(_, name)| *name == label);
            found.expect("slots keep records").0
        };
        let records = named("leaf records");
        let held = stage.device.inspect_buffer(records).expect("it lives");
        let byte = !held[3];
        stage
            .device
            .poison(records, 3..4, byte)
            .expect("within the buffer");
        assert!(check_conservation(&stage.device, payload).is_err());
    }

    #[test]
    fn partition_catches_the_papers_list() {
        let mut wrong = 0;
        for seed in 0..20 {
            let crown = random_crown(seed, 14, 2);
            let history = History::of(crown.sequence());
            let literal = Kind::LodfLiteral.model(&crown, OPTIONS);
            for collapses in 0..=crown.sequence().collapse_count() {
                let state = State::Uniform { collapses };
                wrong += u32::from(partition(&history, &state, &literal.drawn(&state)).is_err());
            }
        }
        assert!(wrong > 100, "only {wrong} states were caught");
    }
}
