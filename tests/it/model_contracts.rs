//! Every model and mode keeps the [laws](spinney::testkit::laws), on random crowns and random walks through
//! states; a test at the end plants the bugs that the laws name.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop_oneof, proptest};
use spinney::math::{index_u32, index_usize};
use spinney::models::{
    CardLevel, Crown, Extraction, Gather, Kind, LeafFormat, ModelOptions, Occlusion, Records,
    State, TrunkKind, TrunkLevel,
};
use spinney::scene::{
    CardCounts, CardMode, CardOptions, CardOutline, CardSides, PaintOptions, SpriteScale,
    TrunkMode, TrunkName,
};
use spinney::testkit::laws::{birth_before_death, image_equality, partition, residency};
use spinney::testkit::strategy::{self, WalkOptions};
use spinney::testkit::{
    DeviceModel as _, History, Law, ModelStructure, Tally, TreeWalk, Violation, check_end,
    check_structure,
};

use crate::laws::check_conservation;
use crate::near_far::NearFar;
use crate::support::{
    Cases, OPTIONS, Stage, StageExt as _, descriptor, random_crown, random_trunk, trunk_picture,
    trunk_stage,
};

pub(crate) const SIDE: u32 = 48;
const TRUNK_SIDE: u32 = 24;

/// Both ways to extract and to send, and all formats, by a number.
pub(crate) fn options(choice: u64) -> ModelOptions {
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
        occlusion: if choice & 16 == 0 {
            Occlusion::None
        } else {
            Occlusion::TwoPhase
        },
        cards: CardOptions::USUAL,
        painting: PaintOptions::USUAL,
    }
}

/// How the same leaves look to everyone else: vertices are where they are.
pub(crate) fn reference_options(options: ModelOptions) -> ModelOptions {
    ModelOptions {
        format: LeafFormat {
            records: Records::Wide,
            ..options.format
        },
        ..OPTIONS
    }
}

/// One walk: all laws at every step, images at the end and at one step between. In every other one
/// collapses add vertices.
fn walk(kind: Kind, seed: u64, case: &TreeWalk, tally: &mut Tally) -> Result<(), Violation> {
    let case = if seed >> 4 & 1 == 0 {
        case
    } else {
        &case.pruned()
    };
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

pub(crate) fn cases() -> impl Strategy<Value = TreeWalk> {
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
    let level = |&share: &u32| {
        TrunkLevel::Collapses(index_u32(index_usize(
            u64::from(share) * most / u64::from(u32::MAX),
        )))
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

/// One walk of cards that stand for a few leaves, from level to level: residency and prices at every
/// step, the image and the ledger at the end.
fn card_walk(kind: Kind, seed: u64, levels: &[u32], tally: &mut Tally) -> Result<(), Violation> {
    let crown = random_crown(seed, 3 + index_u32(index_usize(seed >> 8 & 15)), 2);
    let mut options = options(seed);
    options.cards = CardOptions {
        levels: CardCounts::new(&[4, 2, 1]).expect("descending"),
        texture: 8,
        map: 8,
        layers: 64,
        sprites: 5,
        sprite_texture: 8,
        scale: SpriteScale::ALL[index_usize(seed >> 7 & 1)],
        outline: CardOutline::ALL[index_usize(seed >> 5 & 1)],
        sides: CardSides::ALL[index_usize(seed >> 6 & 1)],
        ..CardOptions::USUAL
    };
    let model = kind.model(&crown, options);
    let most = CardLevel::STEPS * (kind.card_levels(&options.cards) - 1);
    let state = |&level: &u32| State::Cards(CardLevel(level % (most + 1)));
    let states: Vec<State> = levels.iter().map(state).collect();
    let (Some((start, states)), Some(last)) = (states.split_first(), states.last()) else {
        return Ok(());
    };
    let stage = |state: &State, side| Stage::on(descriptor(), model.as_ref(), state, side);
    let mut walked = stage(start, SIDE);
    for state in states {
        let price = walked.resident.price(state);
        let before = walked.device.take_ledger().upload.payload_bytes;
        walked.commit(state);
        let sent = walked.device.take_ledger().upload.payload_bytes;
        assert_eq!(
            (sent, walked.resident.state()),
            (price, state),
            "after {before} bytes"
        );
        assert!(model.drawn(state).is_empty(), "no leaf shows");
        tally.count(
            Law::Residency,
            residency(&mut walked, &mut stage(state, SIDE)),
        )?;
    }
    let mut walked = stage(start, SIDE);
    states.iter().for_each(|state| walked.commit(state));
    check_end(&mut walked, &mut stage(last, SIDE), None, tally)
}

/// A model of cards.
#[derive(Debug, Clone, Copy)]
struct Cards(Kind);

impl Contracts for Cards {
    fn check(self, name: &'static str) {
        let count = Cases::of(name);
        proptest!(config(name, 60), |(seed in any::<u64>(), levels in vec(any::<u32>(), 2..8))| {
            count.one();
            let mut tally = Tally::default();
            let law = card_walk(self.0, seed, &levels, &mut tally);
            count.checked(&tally);
            law?;
        });
    }
}

/// What has contracts.
pub(crate) trait Contracts: Copy {
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

pub(crate) fn config(name: &'static str, cases: u32) -> ProptestConfig {
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
    impostors: Cards(Kind::Impostors);
    impostors_indirect: Cards(Kind::IndirectImpostors);
    billboard_axial: Cards(Kind::AxialBillboard);
    billboard_facing: Cards(Kind::FacingBillboard);
    billboard_depth: Cards(Kind::DepthBillboard);
    sprites: Cards(Kind::Sprites);
    crossed_cards: Cards(Kind::CrossedCards);
    octahedral_hemisphere: Cards(Kind::HemiOctahedral);
    octahedral_sphere: Cards(Kind::Octahedral);
    full_far: NearFar(Kind::Full, CardMode::Direct);
    vdf_indices_far: NearFar(Kind::VdfIndices, CardMode::Direct);
    lodf_host_far: NearFar(Kind::LodfHost, CardMode::Direct);
    lodf_cluster_far: NearFar(Kind::LodfCluster, CardMode::Direct);
    lodf_slots_far: NearFar(Kind::LodfSlots, CardMode::Direct);
    lodf_stamps_far: NearFar(Kind::LodfStamps, CardMode::Direct);
    lodf_stamps_far_indirect: NearFar(Kind::LodfStamps, CardMode::Indirect);
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
        for kind in TrunkKind::all().filter(|kind| !kind.has_errors()) {
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

    use spinney::gpu::{Draw, DrawFromCounter, DrawIndirect, Step};
    use spinney::testkit::{Meddled, Meddling};

    use super::*;

    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    enum Fault {
        /// Commits one collapse more than asked for.
        OffByOne,
        /// Draws less than what is resident.
        StopsShort,
    }

    impl Fault {
        /// The fault put into a sound stage: how a state of one collapse more is told, and how many
        /// corners are left of so many.
        fn put<S: Clone + std::fmt::Debug + 'static>(
            self,
            stage: &mut Stage<S>,
            unused: Stage<S>,
            further: fn(&S) -> S,
            fewer: fn(u32) -> u32,
        ) {
            let mut meddling = Meddling::none();
            match self {
                Self::OffByOne => meddling.committed = Box::new(further),
                Self::StopsShort => {
                    meddling.drawn = Box::new(move |_, mut steps| {
                        for step in &mut steps {
                            match step {
                                Step::Draw(Draw { corner_count, .. }) => {
                                    *corner_count = fewer(*corner_count);
                                }
                                Step::DrawIndirect(DrawIndirect { count, .. })
                                | Step::MultiDrawIndirect(DrawIndirect { count, .. }) => {
                                    *count -= 1;
                                }
                                Step::DrawFromCounter(DrawFromCounter { end, .. }) => *end -= 40,
                                _ => {}
                            }
                        }
                        steps
                    });
                }
            }
            let inner = std::mem::replace(&mut stage.resident, unused.resident);
            stage.resident = Box::new(Meddled::new(inner, meddling));
        }
    }

    fn faulty(kind: Kind, crown: &Arc<Crown>, to: &State, fault: Fault) -> Stage {
        let mut stage = Stage::at(kind, OPTIONS, crown, &State::FINEST, SIDE);
        let unused = Stage::at(Kind::Full, OPTIONS, crown, &State::FINEST, 1);
        let further = |state: &State| match state {
            State::Uniform { collapses } => State::Uniform {
                collapses: collapses + 1,
            },
            other @ (State::Variable { .. } | State::Cards(_) | State::Strokes(_)) => other.clone(),
        };
        fault.put(&mut stage, unused, further, |corners| corners - 4);
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

    /// Of the trunks with these seeds, how often a fault is caught at half detail.
    fn caught(kind: TrunkKind, fault: Fault) -> u32 {
        let mut caught = 0;
        for seed in 0..10 {
            let trunk = random_trunk(seed);
            let half = TrunkLevel::Collapses(trunk.collapses().collapse_count() / 2);
            let mut walked = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, TRUNK_SIDE);
            let unused = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, 4);
            let further = |level: &TrunkLevel| TrunkLevel::Collapses(level.collapses() + 1);
            fault.put(&mut walked, unused, further, |corners| corners / 2);
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
        for kind in TrunkKind::all().filter(|kind| kind.has_levels() && !kind.has_errors()) {
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
