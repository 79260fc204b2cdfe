//! Painting keeps the laws in both modes, shows fine strokes outside, and hardly changes from frame to frame.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, any, proptest};
use spinney::gpu::Cause;
use spinney::math::{Stream, Vec3, index_u32};
use spinney::models::{Crown, Kind, ModelOptions, Painting, State, StrokeCut};
use spinney::plant::{Branch, Node, Plant, Skeleton};
use spinney::run::crown;
use spinney::scene::{PaintLook, PaintOptions, PaintReach, PaintRows};
use spinney::simplify::strokes::extract;
use spinney::testkit::laws::{residency, same_picture};
use spinney::testkit::{DeviceModel as _, Law, Tally, Violation, check_end};

use crate::support::{Cases, OPTIONS, Stage, StageExt as _, descriptor, random_crown};

const SIDE: u32 = 32;

const KINDS: [Kind; 2] = [Kind::StrokeRanges, Kind::StrokesHost];

fn options(seed: u64) -> ModelOptions {
    ModelOptions {
        painting: PaintOptions {
            look: PaintLook::ALL[usize::from(seed & 1 == 1)],
            rows: PaintRows::new(PaintReach::Distances(&[200, 900]), &[60, 90])
                .expect("it coarsens"),
            hulls: 3,
            branch_least: 2,
            seed,
            ..PaintOptions::USUAL
        },
        ..OPTIONS
    }
}

/// Random leaves on a random skeleton of three levels.
fn plant(seed: u64, leaves: u32) -> Arc<Crown> {
    let mut draws = Stream::new(seed, 9).draws();
    let mut skeleton = Skeleton::default();
    for branch in 0..7_u32 {
        let level = [0, 1, 1, 2, 2, 2, 2][branch as usize];
        let first_node = index_u32(skeleton.nodes.len());
        let mut position = 0.5 * Vec3::new(draws.signed(), draws.signed(), draws.signed());
        for _ in 0..3 {
            let radius = 0.05 + 0.1 * draws.unit();
            skeleton.nodes.push(Node { position, radius });
            position += 0.6 * Vec3::new(draws.signed(), draws.signed(), draws.signed());
        }
        skeleton.branches.push(Branch {
            bearer: (branch > 0).then_some(0),
            level,
            first_node,
            node_count: 3,
        });
    }
    let foliage = random_crown(seed, leaves, 2).plant().foliage().clone();
    let plant = Plant::new("painted", Some(skeleton), None, foliage).expect("sound parts");
    Arc::new(crown(plant, None))
}

/// A cut by three numbers.
fn cut(painting: &Painting, [wanted, share, shortest]: [u16; 3]) -> StrokeCut {
    let part = |number: u16| f32::from(number) / f32::from(u16::MAX);
    let most = f64::from(part(wanted)) * 1.2 * f64::from(painting.levels().totals()[0]);
    painting.cut(
        spinney::math::whole_u32(most),
        part(share),
        3.0 * part(shortest),
    )
}

/// One walk through cuts: residency and prices at every step; at the end image and ledger, and the image of
/// the other mode.
fn walk(seed: u64, cuts: &[[u16; 3]], tally: &mut Tally) -> Result<(), Violation> {
    let crown = plant(seed, 20 + index_u32(usize::from(cuts[0][0] % 20)));
    let mut pictures = Vec::new();
    for kind in KINDS {
        let model = kind.model(&crown, options(seed));
        let painting = model.painting().expect("it paints");
        let states = cuts
            .iter()
            .map(|numbers| State::Strokes(cut(painting, *numbers)));
        let states: Vec<State> = states.collect();
        let (Some((start, rest)), Some(last)) = (states.split_first(), states.last()) else {
            return Ok(());
        };
        let stage = |state: &State, side| Stage::on(descriptor(), model.as_ref(), state, side);
        let mut walked = stage(start, 8);
        for state in rest {
            let price = walked.resident.price(state);
            walked.device.take_ledger();
            walked.commit(state);
            let sent = walked.device.take_ledger().upload.payload_bytes;
            assert_eq!(
                (sent, walked.resident.state()),
                (price, state),
                "what a commit sends, and where it leads"
            );
            assert!(model.drawn(state).is_empty(), "no leaf shows");
            tally.count(Law::Residency, residency(&mut walked, &mut stage(state, 8)))?;
        }
        let mut walked = stage(start, SIDE);
        rest.iter().for_each(|state| walked.commit(state));
        check_end(&mut walked, &mut stage(last, SIDE), None, tally)?;
        // Seen from somewhere, and from somewhere else, whatever was seen before.
        for eye in [Vec3::new(3.0, 1.0, 4.0), Vec3::new(-2.0, 0.0, 5.0)] {
            for look in [eye, -eye, eye] {
                let mut queue = walked.device.queue();
                walked
                    .resident
                    .look_from(&mut queue, look)
                    .expect("its own device");
            }
            let mut fresh = stage(last, SIDE);
            let mut queue = fresh.device.queue();
            fresh
                .resident
                .look_from(&mut queue, eye)
                .expect("its own device");
            let picture = fresh.draw();
            tally.count(
                Law::ImageEquality,
                same_picture("whatever was seen before", &picture, &walked.draw()),
            )?;
            pictures.push(picture);
        }
    }
    for eye in 0..2 {
        let pair = same_picture("in host memory", &pictures[eye], &pictures[eye + 2]);
        tally.count(Law::ImageEquality, pair)?;
    }
    Ok(())
}

#[test]
fn both_modes_keep_the_laws_and_show_the_same() {
    let name = concat!(
        module_path!(),
        "::both_modes_keep_the_laws_and_show_the_same"
    );
    let count = Cases::of(name);
    proptest!(ProptestConfig::with_cases(12), |(seed in any::<u64>(), cuts in vec(any::<[u16; 3]>(), 2..6))| {
        count.one();
        let mut tally = Tally::default();
        let law = walk(seed, &cuts, &mut tally);
        count.checked(&tally);
        law?;
    });
}

#[test]
fn models_take_what_they_say() {
    let crown = plant(3, 30);
    for kind in KINDS {
        let model = kind.model(&crown, options(1));
        let storage = model.storage();
        assert_eq!(
            storage.host_bytes,
            model.host_bytes().len() as u64,
            "{kind:?}"
        );
        let stage = Stage::on(descriptor(), model.as_ref(), &State::FINEST, 4);
        let held = stage.device.resident_by_label().into_iter();
        let own = ["stroke", "paint", "brushes"];
        let own = held.filter(|(label, _)| own.iter().any(|start| label.starts_with(start)));
        let held: u64 = own.map(|(_, bytes)| bytes).sum();
        assert_eq!(
            held,
            storage.shared_bytes + storage.instance_bytes,
            "{kind:?}"
        );
        assert_eq!(
            stage.resident.host_bytes(),
            storage.instance_host_bytes,
            "{kind:?}"
        );
    }
}

/// What a change of level sends are ranges, what a move of the eye sends is order; the host sends neither,
/// and pulls 60 B a stroke.
#[test]
fn bytes_are_told_apart_by_cause() {
    let crown = plant(5, 40);
    for kind in KINDS {
        let model = kind.model(&crown, options(0));
        let painting = model.painting().expect("it paints");
        let mut stage = Stage::on(descriptor(), model.as_ref(), &State::FINEST, SIDE);
        stage.device.take_ledger();
        stage.commit(&State::Strokes(painting.cut(12, 0.5, 0.0)));
        let change = stage.device.take_ledger();
        let mut queue = stage.device.queue();
        stage
            .resident
            .look_from(&mut queue, 9.0 * Vec3::Z)
            .expect("its own device");
        let look = stage.device.take_ledger();
        let strokes = stage.resident.strokes();
        stage.draw();
        let drawn = stage.device.take_ledger();
        let of = |ledger: &spinney::gpu::Ledger, cause: Cause| {
            let share = ledger.by_cause.get(cause.kind);
            share.map_or(0, |share| share.payload_bytes)
        };
        if kind == Kind::StrokesHost {
            assert_eq!(
                (change.upload.payload_bytes, look.upload.payload_bytes),
                (0, 0)
            );
            assert_eq!(drawn.fetch.payload_bytes, 60 * strokes);
            continue;
        }
        let ranges = of(&change, Cause::of("stroke-ranges"));
        assert!(ranges > 0 && ranges < 4 * strokes, "{ranges} bytes");
        assert_eq!(
            change.upload.payload_bytes,
            ranges + of(&change, Cause::of("draw-count"))
        );
        let order = of(&look, Cause::of("stroke-order"));
        assert!(order > 0 && order <= 4 * strokes, "{order} bytes");
        assert_eq!(
            (look.upload.payload_bytes, drawn.fetch.payload_bytes),
            (order, 0)
        );
    }
}

/// Shells show a row at least as fine as those within them, and the number of strokes is missed by at most
/// half of what one shell gains from the coarser of its two rows to the finer.
#[test]
fn outer_shells_are_finer_and_numbers_are_met_within_half_a_node() {
    for seed in 0..4 {
        let crown = plant(seed, 300);
        let painting = Painting::of(crown.plant(), &options(seed).painting);
        let levels = painting.levels();
        let totals = levels.totals();
        for wanted in (0..=totals[0] + 5).step_by(3) {
            let found = extract(levels, wanted);
            let rows: Vec<u32> = (0..levels.shells())
                .map(|shell| found.row_of(shell))
                .collect();
            assert!(rows.is_sorted(), "{rows:?}");
            let last = *totals.last().expect("a row");
            if wanted >= totals[0] || wanted <= last {
                let end = if wanted >= totals[0] { totals[0] } else { last };
                assert_eq!(found.strokes, end);
                continue;
            }
            let next = (found.fine_row + 1).min(levels.rows() - 1);
            let gains = (0..levels.shells()).map(|shell| {
                levels.node_count(found.fine_row, shell) - levels.node_count(next, shell)
            });
            let largest = gains.max().unwrap_or(0);
            let missed = found.strokes.abs_diff(wanted);
            assert!(
                2 * missed <= largest.max(1),
                "{missed} of {largest} at {wanted}"
            );
        }
    }
}

/// On a path away from the tree, and back, in small steps: numbers only fall, then rise the same way, and
/// a step changes at most the shells that lie between two switches.
#[test]
fn steps_of_the_camera_are_small_steps_of_the_cut() {
    let crown = plant(2, 400);
    let painting = Painting::of(crown.plant(), &options(2).painting);
    let at =
        |step: u16| painting.at_distance(12.0 + 0.05 * f32::from(step), |d| 700.0 / f64::from(d));
    let cuts: Vec<StrokeCut> = (0..400).map(at).collect();
    let place = |cut: &StrokeCut| {
        cut.row * (painting.levels().shells() + 1) + painting.levels().shells() - cut.switch
    };
    for pair in cuts.windows(2) {
        let [near, far] = [&pair[0], &pair[1]];
        let counts = [near, far].map(|cut| painting.counts(cut));
        assert!(
            counts[0][0] >= counts[1][0] && counts[0][1] >= counts[1][1],
            "{counts:?}"
        );
        let steps = place(far) - place(near);
        assert!(steps <= 2, "{near:?} to {far:?}");
        assert!(near.branches >= far.branches);
    }
    let back: Vec<StrokeCut> = (0..400).rev().map(at).collect();
    assert!(back.iter().rev().eq(&cuts), "the way does not matter");
    assert_ne!(cuts.first(), cuts.last());
}
