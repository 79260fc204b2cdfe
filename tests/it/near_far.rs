//! Leaves near by and cards far away: the laws of what is resident, and forests in which trees come and go.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::{Just, Strategy as _, any, prop_oneof, proptest};
use spinney::models::{CardLevel, Kind, ModelOptions, Placement, State};
use spinney::run::{Session, SessionOptions, StandingTree, World};
use spinney::scene::{CardCounts, CardMode, CardOptions, DetailRange, FarCards, Scene};
use spinney::testkit::laws::residency;
use spinney::testkit::strategy::{self, WalkOptions};
use spinney::testkit::{DeviceModel as _, Law, Tally, TreeWalk, Violation, check_end};

use crate::model_contracts::{Contracts, SIDE, config};
use crate::support::{Cases, OPTIONS, Stage, StageExt as _, descriptor, parse_wood, random_crown};

/// One walk of leaves near by and cards far away, through states of both: residency and prices at every step,
/// the image and the ledger at the end; leaves look as without cards.
fn near_far_walk(
    kind: Kind,
    mode: CardMode,
    case: &TreeWalk,
    far: &[Option<u32>],
    tally: &mut Tally,
) -> Result<(), Violation> {
    let crown = case.crown();
    let options = ModelOptions {
        cards: CardOptions {
            levels: CardCounts::new(&[4, 2, 1]).expect("descending"),
            texture: 8,
            map: 8,
            layers: 64,
            sprites: 5,
            sprite_texture: 8,
            far: Some(FarCards {
                mode,
                range: DetailRange::new(10.0, 20.0).expect("ascending"),
            }),
            ..CardOptions::USUAL
        },
        ..OPTIONS
    };
    let model = kind.model(&crown, options);
    let most = 2 * CardLevel::STEPS;
    let states = case.walk.states();
    let walk = states.iter().zip(far.iter().cycle());
    let states: Vec<State> = walk
        .map(|(leaves, far)| match far {
            Some(level) => State::Cards(CardLevel(level % (most + 1))),
            None if kind.has_levels() => leaves.clone(),
            None => State::FINEST,
        })
        .collect();
    let (Some((start, states)), Some(last)) = (states.split_first(), states.last()) else {
        return Ok(());
    };
    let stage = |state: &State, side| Stage::on(descriptor(), model.as_ref(), state, side);
    let mut walked = stage(start, SIDE);
    for state in states {
        let price = walked.resident.price(state);
        walked.device.take_ledger();
        walked.commit(state);
        let sent = walked.device.take_ledger().upload.payload_bytes;
        assert_eq!(
            (sent, walked.resident.state()),
            (price, state),
            "a price and a state"
        );
        let fresh = &mut stage(state, SIDE);
        tally.count(Law::Residency, residency(&mut walked, fresh))?;
    }
    let mut walked = stage(start, SIDE);
    states.iter().for_each(|state| walked.commit(state));
    let reference = match last {
        State::Cards(_) => {
            let alone = match mode {
                CardMode::Direct => Kind::Impostors,
                CardMode::Indirect => Kind::IndirectImpostors,
            };
            Stage::at(alone, options, &crown, last, SIDE).draw()
        }
        _ => Stage::at(kind, OPTIONS, &crown, last, SIDE).draw(),
    };
    check_end(&mut walked, &mut stage(last, SIDE), Some(&reference), tally)
}

/// A model of leaves, and cards for trees far away.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearFar(pub(crate) Kind, pub(crate) CardMode);

impl Contracts for NearFar {
    fn check(self, name: &'static str) {
        let count = Cases::of(name);
        let walks = strategy::tree_walk(WalkOptions {
            leaves: 2..=19,
            roots: 1..=4,
            steps: 2..=10,
        });
        let far = || vec(prop_oneof![Just(None), any::<u32>().prop_map(Some)], 2..10);
        proptest!(config(name, 40), |(case in walks, far in far())| {
            count.one();
            let mut tally = Tally::default();
            let law = near_far_walk(self.0, self.1, &case, &far, &mut tally);
            count.checked(&tally);
            law?;
        });
    }
}

const SCENE: &str = r##"schema = "spinney.scene/1"
size = [64, 48]
frames = 9
[[tree]]
species = "a.toml"
[camera]
path = [
    { frame = 0, eye = [0, 1, 8], target = [0, 1, 0] },
    { frame = 8, eye = [0, 1, 72], target = [0, 1, 0] },
]
[model]
name = "lodf"
mode = "stamps"
d_min = 5
d_max = 30
[cards]
count = 4
texture = 8
from = 30
to = 60
"##;

/// The state of the only tree in every frame of the path, and back to the first.
fn there_and_back(scene: &Scene) -> Vec<State> {
    let crown = random_crown(3, 12, 2);
    let tree = StandingTree {
        crown: 0,
        placement: Placement::IDENTITY,
    };
    let world = World::of(vec![Arc::clone(&crown)], vec![tree]);
    let options = SessionOptions::exact(scene).expect("known names");
    let mut session = Session::new(scene, &world, &options).expect("it fits");
    let way = (0..scene.frames).chain((0..scene.frames).rev());
    way.map(|frame| {
        let shown = session.frame(frame).expect("a frame");
        let cards = matches!(shown.states[0].foliage, State::Cards(_));
        assert_eq!(cards, shown.leaves == 0, "frame {frame}");
        shown.states[0].foliage.clone()
    })
    .collect()
}

fn shows_cards(states: &[State]) -> Vec<bool> {
    let is = |state: &State| matches!(state, State::Cards(_));
    states.iter().map(is).collect()
}

/// Leaves near by, cards from where the scene says, coarser ones farther away; the same on the way back.
#[test]
fn distance_decides_between_leaves_and_cards() {
    let scene = parse_wood(SCENE).expect("a sound scene");
    let states = there_and_back(&scene);
    let shown = shows_cards(&states);
    // The eye moves by 8 metres a frame from 8 on; the crown's centre is within 2 metres of the axis.
    assert!(shown[..2].iter().all(|cards| !cards), "{shown:?}");
    assert!(shown[4..9].iter().all(|cards| *cards), "{shown:?}");
    let back: Vec<&State> = states[9..].iter().rev().collect();
    assert_eq!(back, states[..9].iter().collect::<Vec<_>>());
    let levels: Vec<CardLevel> = states[4..9]
        .iter()
        .filter_map(|state| match state {
            State::Cards(level) => Some(*level),
            _ => None,
        })
        .collect();
    assert!(levels.is_sorted() && levels[0] < levels[4], "{levels:?}");
}

/// Within the band, what stands stays: out and back switch in different frames.
#[test]
fn hysteresis_holds_what_stands() {
    let banded = SCENE.replace("d_max = 30", "d_max = 30\nhysteresis = 0.4");
    let shown = shows_cards(&there_and_back(
        &parse_wood(&banded).expect("a sound scene"),
    ));
    let out = shown[..9].iter().filter(|cards| **cards).count();
    let back = shown[9..].iter().filter(|cards| **cards).count();
    assert!(out < back, "{shown:?}");
}

#[test]
fn wrong_far_cards_are_refused() {
    let refused = |from: &str, to: &str| {
        let text = SCENE.replace(from, to);
        assert_ne!(text, SCENE);
        parse_wood(&text).expect_err("a wrong scene")
    };
    let found = refused("mode = \"stamps\"", "mode = \"device\"");
    assert!(
        found.contains("`cards.from`") && found.contains("stamps"),
        "{found}"
    );
    let found = refused("to = 60", "to = 30");
    assert!(found.contains("more than `from`, which is 30"), "{found}");
    let found = refused("from = 30\n", "");
    assert!(found.contains("unless `from` is given"), "{found}");
    let found = refused("name = \"lodf\"\nmode = \"stamps\"", "name = \"impostors\"");
    assert!(found.contains("unless `model.name`"), "{found}");
    let found = refused(
        "to = 60",
        "to = 60\nmode = \"indirect\"\ndepth = \"relief\"",
    );
    assert!(found.contains("`cards.mode` is indirect"), "{found}");
}
