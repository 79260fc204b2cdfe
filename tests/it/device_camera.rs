//! Mode device where nobody sends a state: the laws, what is sent, and what is culled.

use std::sync::Arc;

use proptest::prelude::{ProptestConfig, any, proptest};
use spinney::math::{Draws, Quat, Stream, Vec3, index_u32, index_usize};
use spinney::models::{Camera, Criterion, Crown, Extent, Kind, Placement, State, View};
use spinney::testkit::laws::{conservation, image_equality, residency, same_picture};
use spinney::testkit::{DeviceModel as _, Law, Tally, Violation};

use crate::model_contracts::{SIDE, cases, options, reference_options};
use crate::support::{Cases, Stage, StageExt as _, random_crown};

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
