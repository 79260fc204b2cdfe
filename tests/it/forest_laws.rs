//! The [laws](spinney::testkit::laws) for forests, where a state is the vector of all trees' states:
//! dictated, selected within a budget of bytes, and selected by the device.

use std::cell::Cell;

use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, any, proptest};
use spinney::document::Document;
use spinney::math::{Quat, Stream, Vec3, index_u32, index_usize};
use spinney::models::{Kind, Placement, State, TreeState, TrunkKind, TrunkLevel};
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Frame, SessionOptions, StandingTree, World};
use spinney::scene::{DetailKind, Scene, SceneFile, TrunkMode, TrunkName};
use spinney::testkit::laws::{
    birth_before_death, conservation, partition, residency, same_picture,
};
use spinney::testkit::{DeviceModel as _, ForestStage, History, Law, Tally, Violation, check_end};

use crate::model_contracts::{options, reference_options};
use crate::support::{Cases, OPTIONS, random_state, random_tree};

/// Trees of two species by turns.
pub(crate) const TREES: usize = 4;

pub(crate) const FINEST: [TreeState; TREES] = [TreeState::FINEST; TREES];

/// The camera goes away, and rests at its last frame. What trees stand is not read here.
const SCENE: &str = r#"schema = "spinney.scene/1"
size = [32, 24]
frames = 5

[[tree]]
species = "none.toml"

[camera]
path = [
    { frame = 0, eye = [0.5, 0.5, 2.5], target = [0, 0, 0] },
    { frame = 3, eye = [2, 1, 6], target = [0, 0, 0] },
    { frame = 4, eye = [0, 0, 4], target = [0, 0, 0] },
]

[model]
d_min = 1.5
d_max = 6.0

[device]
card = "gtx770"
"#;

pub(crate) fn scene() -> Scene {
    let document = Document {
        file: "forest.toml".to_owned(),
        text: SCENE.to_owned(),
    };
    SceneFile::parse(document).expect("a sound scene").scene
}

/// A forest of small random trees, each with a trunk.
pub(crate) fn world(seed: u64) -> World {
    let mut draws = Stream::new(seed, 11).draws();
    let trees = (0..TREES).map(|tree| {
        let mut coordinate = || draws.signed();
        let position = Vec3::new(coordinate(), 0.3 * coordinate(), coordinate());
        let [y, w] = [[0.0, 1.0], [0.6, 0.8]][tree / 2];
        StandingTree {
            crown: tree % 2,
            placement: Placement {
                position,
                rotation: Quat::from_array([0.0, y, 0.0, w]),
                scale: 0.5 + draws.unit(),
            },
        }
    });
    let trees = trees.collect();
    let mut species = || {
        let [leaves, roots] = [2 + draws.below(10), 1 + draws.below(3)];
        let [leaves, roots] = [leaves, roots].map(|count| index_u32(index_usize(count)));
        random_tree(draws.below(1 << 32), leaves, roots)
    };
    let (crowns, trunks): (Vec<_>, Vec<_>) = [species(), species()].into_iter().unzip();
    let mut world = World::of(crowns, trees);
    world.trunks = trunks.into_iter().map(Some).collect();
    world
}

/// What is resident, and how it is sent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Models {
    pub(crate) kind: Kind,
    pub(crate) trunk: TrunkKind,
    pub(crate) seed: u64,
}

impl Models {
    /// A kind of foliage with a random one of trunks.
    fn of(kind: Kind, seed: u64) -> Self {
        // Plants of these worlds have no skeletons.
        let trunks = TrunkKind::all().filter(|kind| !kind.has_errors());
        let trunks: Vec<TrunkKind> = trunks.collect();
        let trunk = trunks[index_usize((seed >> 8) % trunks.len() as u64)];
        Self { kind, trunk, seed }
    }

    fn options(self, scene: &Scene) -> SessionOptions {
        let raster = Options {
            tile: TileSize::Side32,
            counters: Counters::Visible,
        };
        SessionOptions {
            kind: self.kind,
            trunk: self.trunk,
            model: options(self.seed),
            ..SessionOptions::of(scene, raster).expect("known names")
        }
    }

    /// What these models show where they are asked for states.
    fn shown(self, states: &[TreeState]) -> Vec<TreeState> {
        let mut shown = states.to_vec();
        for state in &mut shown {
            if !self.kind.has_levels() {
                state.foliage = State::FINEST;
            }
            if !self.trunk.has_levels() {
                state.trunk = TrunkLevel::FINEST;
            }
        }
        shown
    }

    /// A forest that stands in some states, made anew, as a frame's camera sees it.
    pub(crate) fn anew<'w>(
        self,
        (scene, world): (&'w Scene, &'w World),
        states: &[TreeState],
        frame: u32,
    ) -> ForestStage<'w> {
        let options = self.options(scene);
        ForestStage::new((scene, world), &options, states, frame).expect("memory suffices")
    }

    /// The same leaves and triangles by other models: whole blocks, and strips of fixed length.
    fn others<'w>(
        self,
        (scene, world): (&'w Scene, &'w World),
        states: &[TreeState],
        frame: u32,
    ) -> ForestStage<'w> {
        let name = match self.trunk.name {
            // Its vertices have an order of their own.
            TrunkName::Full => TrunkName::Full,
            _ => TrunkName::LodStrips,
        };
        let options = SessionOptions {
            kind: Kind::LodfCluster,
            trunk: TrunkKind {
                name,
                mode: TrunkMode::Device,
            },
            model: reference_options(options(self.seed)),
            ..self.options(scene)
        };
        let states = self.shown(states);
        ForestStage::new((scene, world), &options, &states, frame).expect("memory suffices")
    }
}

/// A random state of every tree.
pub(crate) fn vector(world: &World, choices: [u64; TREES]) -> Vec<TreeState> {
    let state = |(tree, choice): (&StandingTree, u64)| {
        let trunk = world.trunks[tree.crown].as_ref().expect("each has one");
        let most = u64::from(trunk.collapses().collapse_count());
        let collapses = Stream::new(choice, 12).draws().below(most + 1);
        TreeState {
            foliage: random_state(&world.crowns[tree.crown], choice),
            trunk: TrunkLevel::Collapses(index_u32(index_usize(collapses))),
        }
    };
    world.trees.iter().zip(choices).map(state).collect()
}

/// In every tree each original stands under one leaf that is drawn.
pub(crate) fn partitions(
    kind: Kind,
    world: &World,
    states: &[TreeState],
    tally: &mut Tally,
) -> Result<(), Violation> {
    for (tree, state) in world.trees.iter().zip(states) {
        let crown = &world.crowns[tree.crown];
        let history = History::of(crown.sequence());
        let drawn = kind.model(crown, OPTIONS).drawn(&state.foliage);
        let law = birth_before_death(&history, &state.foliage, &drawn);
        tally.count(Law::BirthBeforeDeath, law)?;
        tally.count(Law::Partition, partition(&history, &state.foliage, &drawn))?;
    }
    Ok(())
}

/// One walk through dictated vectors: residency at every step, images and the ledger at the end.
fn dictated(models: Models, walk: &[[u64; TREES]], tally: &mut Tally) -> Result<(), Violation> {
    let (scene, world) = (scene(), world(models.seed));
    let place = (&scene, &world);
    let walk: Vec<_> = walk
        .iter()
        .map(|&choices| vector(&world, choices))
        .collect();
    let (Some((start, steps)), Some(last)) = (walk.split_first(), walk.last()) else {
        return Ok(());
    };
    let mut walked = models.anew(place, start, 0);
    for states in steps {
        walked.commit(states);
        let stands = walked.session().states() == models.shown(states);
        assert!(stands, "a session says what it shows");
        let law = residency(&mut walked, &mut models.anew(place, states, 0));
        tally.count(Law::Residency, law)?;
        if models.kind.has_levels() {
            partitions(models.kind, &world, states, tally)?;
        }
    }
    let reference = models.others(place, last, 0).picture();
    let mut fresh = models.anew(place, last, 0);
    check_end(&mut walked, &mut fresh, reference.as_ref(), tally)
}

/// What a frame uploaded for its change of detail: all but the view.
fn spent(frame: &Frame) -> u64 {
    let view = frame.ledger.by_cause.get("view");
    frame.ledger.upload.payload_bytes - view.map_or(0, |share| share.payload_bytes)
}

/// The scene with detail of one or the other kind, and so many bytes a frame.
pub(crate) fn scene_of(seed: u64, budget: Option<u64>) -> Scene {
    let mut scene = scene();
    scene.model.budget_bytes = budget;
    scene.model.detail = match seed >> 16 & 1 {
        0 => DetailKind::Uniform,
        _ => DetailKind::Variable,
    };
    scene
}

/// The states of a frame as nothing holds them back.
pub(crate) fn wanted(models: Models, world: &World, frame: u32) -> Vec<TreeState> {
    let scene = scene_of(models.seed, None);
    let stage = models.anew((&scene, world), &FINEST, frame);
    stage.session().select(frame)
}

/// What the dearest change of one trunk or one tree's foliage takes between two vectors.
pub(crate) fn dearest(models: Models, world: &World, from: &[TreeState], to: &[TreeState]) -> u64 {
    let scene = scene();
    let mut stage = models.anew((&scene, world), from, 0);
    let mut payload = |states: &[TreeState]| {
        let sent = |stage: &mut ForestStage<'_>| {
            let counted = stage.counted().expect("our device counts");
            counted.payload_bytes
        };
        stage.commit(&from.to_vec());
        let before = sent(&mut stage);
        stage.commit(&states.to_vec());
        sent(&mut stage) - before
    };
    let mut dearest = 0;
    for tree in 0..TREES {
        let mut states = from.to_vec();
        states[tree].trunk = to[tree].trunk;
        dearest = dearest.max(payload(&states));
        states[tree] = TreeState {
            foliage: to[tree].foliage.clone(),
            trunk: from[tree].trunk,
        };
        dearest = dearest.max(payload(&states));
    }
    dearest
}

/// Goes over to a frame; answers how many changes it put off, or `None` if it spent too much.
pub(crate) fn frame_within(budget: u64, stage: &mut ForestStage<'_>, frame: u32) -> Option<u64> {
    let frame = stage.frame(frame).expect("its own device");
    let kept = spent(&frame) <= budget;
    kept.then(|| frame.deferred.unwrap_or(0))
}

/// Whether all that was put off comes where the camera rests.
pub(crate) fn catches_up(stage: &mut ForestStage<'_>, budget: u64, frame: u32) -> bool {
    // Frames go by, as many as there could be clusters and trunks.
    (0..60).any(|_| frame_within(budget, stage, frame) == Some(0))
}

/// One walk by camera within a budget: no frame exceeds it, what the device holds follows from what
/// stands whichever way it came, and where the camera rests, all that was put off comes. Answers how
/// often something was put off.
fn budgeted(models: Models, tally: &mut Tally) -> Result<u64, Violation> {
    let world = world(models.seed);
    let vectors: Vec<_> = (0..5).map(|frame| wanted(models, &world, frame)).collect();
    let mut put_off = 0;
    // A walk that little is sent for; then one step to where the camera rests, with twice what its
    // dearest part takes, since parts of it may come first.
    let little = models.seed >> 20 & 0xff;
    let enough = 2 * dearest(models, &world, &vectors[0], &vectors[4]);
    for (budget, frames, rests) in [(little, 1..5, false), (enough, 4..5, true)] {
        let scene = scene_of(models.seed, Some(budget));
        let place = (&scene, &world);
        let mut walked = models.anew(place, &vectors[0], 0);
        for number in frames {
            let late = frame_within(budget, &mut walked, number);
            let late = late.expect("no frame spends more than it may");
            put_off += late;
            let stands = walked.session().states();
            let arrived = stands == vectors[number as usize];
            assert_eq!(arrived, late == 0, "what is late is told");
            let mut fresh = models.anew(place, &stands, number);
            tally.count(Law::Residency, residency(&mut walked, &mut fresh))?;
        }
        if rests {
            assert!(catches_up(&mut walked, budget, 4), "{budget} B a frame");
            let arrived = walked.session().states() == vectors[4];
            assert!(arrived, "nothing is late");
        }
        let stands = walked.session().states();
        let reference = models.others(place, &stands, 4).picture();
        let mut fresh = models.anew(place, &stands, 4);
        check_end(&mut walked, &mut fresh, reference.as_ref(), tally)?;
    }
    Ok(put_off)
}

/// One walk in which the device selects: nothing but the camera is sent for leaves, and what it
/// draws is what the host selects.
fn by_camera(seed: u64, tally: &mut Tally) -> Result<(), Violation> {
    let models = Models::of(Kind::LodfDevice, seed);
    let (scene, world) = (scene_of(seed, None), world(seed));
    let place = (&scene, &world);
    let mut walked = models.anew(place, &FINEST, 0);
    // From dictated states, so that the first frame says by what to select from now on.
    walked.frame(2).expect("its own device");
    for number in [3, 0, 1, 4, 2] {
        let frame = walked.frame(number).expect("its own device");
        let mut causes = frame.ledger.by_cause.keys();
        // Trunks that lie on the host are pulled by draws.
        let of_trunks = ["strip", "strip-count", "triangle", "triangle-count", "draw"];
        let known = |cause: &&str| ["view", "camera"].contains(cause) || of_trunks.contains(cause);
        assert!(
            causes.all(|cause| known(&&**cause)),
            "{:?}",
            frame.ledger.by_cause
        );
        let sent = frame.ledger.by_cause["camera"].payload_bytes;
        assert_eq!(sent, 24, "the camera, whatever changes");
        let stands = walked.session().states();
        let wanted = wanted(models, &world, number);
        assert_eq!(stands, wanted, "a session says what it shows");
        let mut fresh = models.anew(place, &FINEST, number);
        fresh.frame(number).expect("its own device");
        tally.count(Law::Residency, residency(&mut walked, &mut fresh))?;
        let reference = models.others(place, &stands, number).picture();
        let reference = reference.expect("it draws");
        let law = same_picture("by camera", &reference, &frame.image);
        tally.count(Law::ImageEquality, law)?;
        partitions(models.kind, &world, &stands, tally)?;
    }
    tally.count(Law::Conservation, conservation(&mut walked))
}

fn config(name: &'static str, cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        test_name: Some(name),
        source_file: Some(file!()),
        ..ProptestConfig::default()
    }
}

/// Dictated and budgeted walks of one kind of foliage, with all kinds of trunks.
fn check(kind: Kind, name: &'static str) {
    let count = Cases::of(name);
    let walks = || vec(any::<[u64; TREES]>(), 2..6);
    proptest!(config(name, 60), |(seed in any::<u64>(), walk in walks())| {
        count.one();
        let mut tally = Tally::default();
        let law = dictated(Models::of(kind, seed), &walk, &mut tally);
        count.checked(&tally);
        law?;
    });
    let late = Cell::new(0);
    proptest!(config(name, 24), |(seed in any::<u64>())| {
        count.one();
        let mut tally = Tally::default();
        let law = budgeted(Models::of(kind, seed), &mut tally);
        count.checked(&tally);
        late.set(late.get() + law?);
    });
    // Of what lies in host memory nothing is sent, so nothing is put off but of trunks.
    assert!(late.get() > 20, "only {} changes were put off", late.get());
}

macro_rules! forests {
    ($($name:ident: $kind:expr;)*) => {$(
        #[test]
        fn $name() {
            check($kind, concat!(module_path!(), "::", stringify!($name)));
        }
    )*};
}

forests! {
    full: Kind::Full;
    vdf_host: Kind::VdfHost;
    vdf_indices: Kind::VdfIndices;
    lodf_host: Kind::LodfHost;
    lodf_cluster: Kind::LodfCluster;
    lodf_slots: Kind::LodfSlots;
    lodf_stamps: Kind::LodfStamps;
    lodf_device: Kind::LodfDevice;
}

#[test]
fn lodf_device_by_camera() {
    let name = concat!(module_path!(), "::lodf_device_by_camera");
    let count = Cases::of(name);
    proptest!(config(name, 24), |(seed in any::<u64>())| {
        count.one();
        let mut tally = Tally::default();
        let law = by_camera(seed, &mut tally);
        count.checked(&tally);
        law?;
    });
}
