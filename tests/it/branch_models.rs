//! Branches on a device: the laws of models, and the same pictures in every mode.

use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;
use spinney::document::Document;
use spinney::math::{Stream, Vec3, index_u32};
use spinney::models::{Trunk, TrunkKind, TrunkLevel};
use spinney::plant::{Foliage, LeafGroup, Material, Plant, Prototype};
use spinney::run::{Session, SessionOptions, Silent, World};
use spinney::scene::{
    BranchAlpha, BranchChoice, BranchLines, BranchShares, SceneFile, TrunkMode, TrunkName,
};
use spinney::simplify::{ErrorStep, LineNormals};
use spinney::testkit::laws::residency;
use spinney::testkit::{DeviceModel as _, Law, Tally, Violation, check_end};

use crate::branches::skeleton;
use crate::support::{OPTIONS, Stage, properties, random_mesh, trunk_stage};

const SIDE: u32 = 40;

fn kind(mode: TrunkMode) -> TrunkKind {
    TrunkKind {
        name: TrunkName::Branches,
        mode,
    }
}

fn kinds() -> impl Iterator<Item = TrunkKind> {
    TrunkName::Branches.modes().iter().map(|&mode| kind(mode))
}

/// Up to six bent branches and up to twelve needles, drawn by options that the seed chooses.
fn tree(seed: u64) -> Arc<Trunk> {
    let mut draws = Stream::new(seed, 31).draws();
    let skeleton = skeleton(&mut draws);
    let mut foliage = Foliage::default();
    let needles = draws.below(13);
    if needles > 0 {
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        let ends = (0..needles).flat_map(|_| {
            let base = vector();
            [base, base + 0.2 * vector()]
        });
        let positions = ends.collect();
        let diameter = 0.02 * draws.unit();
        foliage.groups.push(LeafGroup {
            name: "needles".to_owned(),
            prototype: Prototype::Needle { diameter },
            material: Material::plain("needle", [0.2, 0.5, 0.3]),
            positions,
            owners: vec![0; usize::try_from(needles).expect("few")],
        });
    }
    let mesh = random_mesh(seed);
    let plant = Plant::new("tree", Some(skeleton), Some(mesh), foliage).expect("sound parts");
    let pick =
        |shift: u32, all: usize| usize::try_from(seed >> shift & 0xff).expect("a byte") % all;
    let choice = BranchChoice {
        shares: BranchShares::ALL[pick(0, 2)],
        line_alpha: BranchAlpha::ALL[pick(1, 3)],
        line_normals: BranchLines::ALL[pick(3, 3)],
        most_edges: 3 + index_u32(pick(9, 14)),
        ..BranchChoice::USUAL
    };
    let trunk = Trunk::of(&Arc::new(plant), Some(0)).expect("it has a trunk");
    Arc::new(trunk.branched(choice))
}

fn stage(mode: TrunkMode, trunk: &Arc<Trunk>, level: TrunkLevel) -> Stage<TrunkLevel> {
    trunk_stage(kind(mode), OPTIONS, trunk, level, SIDE)
}

/// What a mode shows when it is asked for a level: one that `mesh` can show too.
fn shown(mode: TrunkMode, trunk: &Trunk, level: TrunkLevel) -> TrunkLevel {
    let [finest, coarsest] = trunk.branch_choice().steps();
    let step = level.step().max(finest);
    let step = match mode {
        TrunkMode::Levels => {
            let mut levels = (0..8).map(|level| finest.towards(coarsest, level, 7));
            levels.rfind(|level| *level <= step)
        }
        _ => Some(step),
    };
    TrunkLevel::Error(step.expect("the finest is one of them"))
}

/// One walk: residency, price and state at every step; image, history and ledger at the end.
fn walk(mode: TrunkMode, seed: u64, steps: &[u16], tally: &mut Tally) -> Result<(), Violation> {
    let trunk = &tree(seed);
    let levels: Vec<TrunkLevel> = steps
        .iter()
        .map(|&step| TrunkLevel::Error(ErrorStep::new(step)))
        .collect();
    let (Some((&start, levels)), Some(&last)) = (levels.split_first(), levels.last()) else {
        return Ok(());
    };
    let mut walked = stage(mode, trunk, start);
    let mut priced = stage(mode, trunk, start);
    for &level in levels {
        let price = priced.resident.price(&level);
        priced.device.take_ledger();
        priced.commit(&level);
        let sent = priced.device.take_ledger().upload.payload_bytes;
        assert_eq!(
            (sent, priced.resident.price(&level)),
            (price, 0),
            "{mode:?}"
        );
        walked.commit(&level);
        assert_eq!(
            *walked.resident.state(),
            level,
            "a resident says what it shows"
        );
        let counts = trunk.branch_counts(shown(mode, trunk, level).step());
        assert_eq!(walked.resident.primitives(), Some(counts), "{mode:?}");
        let mut fresh = stage(mode, trunk, level);
        tally.count(Law::Residency, residency(&mut walked, &mut fresh))?;
    }
    let reference = stage(TrunkMode::Mesh, trunk, shown(mode, trunk, last)).picture();
    let mut fresh = stage(mode, trunk, last);
    check_end(&mut walked, &mut fresh, reference.as_ref(), tally)
}

properties! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn all_modes_keep_the_laws_and_show_the_same(
        seed in any::<u64>(),
        steps in prop::collection::vec(0..=200_u16, 2..5),
    ) {
        let mut tally = Tally::default();
        for &mode in TrunkName::Branches.modes() {
            walk(mode, seed, &steps, &mut tally)?;
        }
    }
}

/// Storage is what lies there, host and device; a change sends a level, nothing, or 4 bytes.
#[test]
fn modes_take_what_they_say() {
    for seed in 0..8 {
        let trunk = tree(seed);
        let sequence = trunk.branches();
        for kind in kinds() {
            let model = kind.model(&trunk, OPTIONS);
            let storage = model.storage();
            assert_eq!(
                storage.host_bytes,
                model.host_bytes().len() as u64,
                "{kind:?}"
            );
            let mut stage = trunk_stage(kind, OPTIONS, &trunk, TrunkLevel::FINEST, 4);
            let on_device = stage.device.resident_by_label();
            let ours = on_device.iter();
            let ours =
                ours.filter(|(label, _)| label.starts_with("trunk ") && *label != "trunk surface");
            let held: u64 = ours.map(|(_, bytes)| bytes).sum();
            assert_eq!(
                held,
                storage.shared_bytes + storage.instance_bytes,
                "{kind:?}"
            );
            stage.device.take_ledger();
            stage.commit(&TrunkLevel::Error(ErrorStep::new(90)));
            let sent = stage.device.take_ledger().upload.payload_bytes;
            match kind.mode {
                TrunkMode::Skeleton => {
                    let nodes = sequence.skeleton().vectors.len() as u64;
                    let vectors = on_device.iter();
                    let mut vectors = vectors.filter(|(label, _)| label == "trunk skeleton");
                    let vectors = vectors.next().map(|(_, bytes)| *bytes);
                    assert_eq!((sent, vectors), (4, Some(52 * nodes)));
                }
                TrunkMode::Levels => assert_eq!(sent, 0),
                _ => {
                    let level = sequence.at(
                        ErrorStep::new(90).error(),
                        trunk.branch_choice().error_shares(),
                    );
                    let counts = level.counts();
                    let indices = 24 * counts.quads + 12 * counts.triangles + 8 * counts.lines;
                    assert!(sent >= indices && (sent - indices).is_multiple_of(4));
                }
            }
        }
    }
}

/// Three lines with a normal each are together as opaque as one.
#[test]
fn three_lines_are_as_opaque_as_one() {
    for radius in [0.0, 0.001, 0.004, 0.02] {
        let [one, three] =
            [LineNormals::One, LineNormals::Three].map(|normals| normals.alpha(radius, 0.01));
        let through = (1.0 - three) * (1.0 - three) * (1.0 - three);
        assert!((one - (1.0 - through)).abs() < 1e-6, "{radius}");
    }
}

/// Two bare hollies, one behind the other, on the ground, with shadows; the camera walks away.
const HOLLIES: &str = r##"schema = "spinney.scene/1"
size = [60, 48]
frames = 3

[[tree]]
species = "species/ilex_aquifolium.toml"

[[tree]]
species = "species/ilex_aquifolium.toml"
at = [0.3, 0.0, -1.5]
turn = 70.0
scale = 0.8

[terrain]
size = 20.0
cells = 4

[shadow]
size = 64

[camera]
path = [
    { frame = 0, eye = [0.5, 1.5, 4.0], target = [0.0, 1.0, 0.0] },
    { frame = 2, eye = [1.0, 2.5, 14.0], target = [0.0, 1.0, 0.0] },
]

[model]
name = "bare"
trunk = "branches"

[device]
card = "gtx770"
"##;

#[test]
fn forests_look_the_same_in_all_modes_and_send_what_they_say() {
    let document = Document {
        file: "hollies.toml".to_owned(),
        text: HOLLIES.to_owned(),
    };
    let mut scene = SceneFile::parse(document).expect("a sound scene").scene;
    assert_eq!(scene.model.trunk_mode, TrunkMode::Skeleton);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let world = World::build(&scene, &folder, &Silent).expect("a species of our own");
    let mut shown = Vec::new();
    for mode in [TrunkMode::Skeleton, TrunkMode::Mesh] {
        scene.model.trunk_mode = mode;
        let options = SessionOptions::exact(&scene).expect("known names");
        let mut session = Session::new(&scene, &world, &options).expect("memory suffices");
        let mut frames = Vec::new();
        for number in [0, 1, 2, 0] {
            let frame = session.frame(number).expect("its own device");
            let sent = |cause: &str| {
                let share = frame.ledger.by_cause.get(cause);
                share.map_or(0, |share| share.payload_bytes)
            };
            let is_change = !frames.is_empty();
            match mode {
                TrunkMode::Skeleton => assert_eq!(sent("branch step"), 8 * u64::from(is_change)),
                _ => assert_eq!(sent("branch mesh") > 0, is_change),
            }
            frames.push((frame.image_digest, frame.states, frame.trunk_triangles));
        }
        assert_eq!(frames[0], frames[3], "{mode:?}");
        assert!(frames[0].2 > frames[1].2 && frames[1].2 > frames[2].2);
        // The one behind is farther off.
        let [near, far] = [0, 1].map(|tree: usize| frames[0].1[tree].trunk.step());
        assert!(near < far, "{near:?} {far:?}");
        shown.push(frames);
    }
    assert_eq!(shown[0], shown[1]);
}
