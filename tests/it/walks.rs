//! Longer walks on a real tree: the [laws](spinney::testkit::laws) at every step, and detail by distance.

use std::sync::Arc;

use proptest::prelude::{ProptestConfig, any, prop_assert, prop_assert_eq};
use spinney::math::{Vec3, index_u32};
use spinney::models::{Criterion, Crown, Extent, Kind, State, select};
use spinney::testkit::laws::{Asked, birth_before_death, detail_by_distance, partition, residency};
use spinney::testkit::{DeviceModel as _, History, Tally, check_end, strategy};

use crate::support::{
    OPTIONS, Stage, StageExt as _, birches, descriptor, properties, random_state,
};

fn crown() -> &'static Arc<Crown> {
    &birches().crowns[0]
}

/// Uniform and variable states, near and far from each other, the ends of the axis among them.
fn walk_states(crown: &Crown) -> Vec<State> {
    let all = crown.sequence().collapse_count();
    let uniform = |collapses| State::Uniform { collapses };
    let mut states = vec![
        uniform(1),
        uniform(0),
        uniform(all),
        uniform(all - 1),
        uniform(all / 2),
    ];
    states.extend((0..16).map(|choice| random_state(crown, choice)));
    // A step from a variable state, and the ends of the axis in the other guise.
    let Some(State::Variable { counts }) =
        states.iter().rfind(|s| matches!(s, State::Variable { .. }))
    else {
        unreachable!("some of the random states are variable");
    };
    let mut near = counts.clone();
    for (number, (count, cluster)) in near.iter_mut().zip(&crown.clusters().clusters).enumerate() {
        if number % 9 == 0 {
            *count = (*count + 1).min(cluster.original_count() - 1);
        }
    }
    let coarsest = crown
        .clusters()
        .clusters
        .iter()
        .map(|c| c.original_count() - 1);
    let coarsest = coarsest.collect();
    let finest = vec![0; near.len()];
    for counts in [near, coarsest, finest] {
        states.push(State::Variable { counts });
    }
    states.push(uniform(all / 3));
    states
}

fn walk(kind: Kind) {
    let crown = crown();
    let states = walk_states(crown);
    let history = History::of(crown.sequence());
    let model = kind.model(crown, OPTIONS);
    let mut walked = Stage::on(descriptor(), &*model, &State::FINEST, 128);
    for state in &states {
        walked.commit(state);
        let mut fresh = Stage::on(descriptor(), &*model, state, 8);
        residency(&mut walked, &mut fresh).expect("residency");
        if kind.has_levels() {
            let drawn = model.drawn(state);
            birth_before_death(&history, state, &drawn).expect("birth before death");
            partition(&history, state, &drawn).expect("partition");
        }
    }
    let last = states.last().filter(|_| kind.has_levels());
    let last = last.unwrap_or(&State::FINEST);
    let mut fresh = Stage::at(kind, OPTIONS, crown, last, 128);
    let reference = Stage::at(Kind::LodfCluster, OPTIONS, crown, last, 128).draw();
    check_end(
        &mut walked,
        &mut fresh,
        Some(&reference),
        &mut Tally::default(),
    )
    .expect("conservation and images");
}

macro_rules! walks {
    ($($name:ident: $kind:expr;)*) => {$(
        #[test]
        fn $name() {
            walk($kind);
        }
    )*};
}

walks! {
    full: Kind::Full;
    vdf_host: Kind::VdfHost;
    vdf_indices: Kind::VdfIndices;
    lodf_host: Kind::LodfHost;
    lodf_cluster: Kind::LodfCluster;
    lodf_slots: Kind::LodfSlots;
    lodf_stamps: Kind::LodfStamps;
}

/// Uniform, variable, and back: nothing of the way is left, not even in slots that no draw reads.
#[test]
fn back_from_variable_to_uniform_all_is_as_it_was() {
    let crown = crown();
    let all = crown.sequence().collapse_count();
    let variable: Vec<State> = (0..30)
        .map(|choice| random_state(crown, choice))
        .filter(|state| matches!(state, State::Variable { .. }))
        .take(3)
        .collect();
    for kind in Kind::SOUND.into_iter().filter(|kind| kind.has_levels()) {
        for collapses in [0, all / 4, all] {
            let uniform = State::Uniform { collapses };
            let mut stage = Stage::at(kind, OPTIONS, crown, &uniform, 48);
            let shown = stage.draw();
            let content = |stage: &Stage| {
                let buffers = stage.device.buffers();
                // Thresholds are read in variable states alone.
                let read = buffers.filter(|(_, label)| *label != "thresholds");
                let held = read.map(|(buffer, _)| stage.device.inspect_buffer(buffer));
                held.map(|bytes| bytes.expect("it lives").to_vec())
                    .collect::<Vec<_>>()
            };
            let before = content(&stage);
            for state in &variable {
                stage.commit(state);
            }
            assert!(stage.draw() != shown, "{kind:?}");
            stage.commit(&uniform);
            assert_eq!(stage.resident.state(), &uniform);
            assert!(stage.draw() == shown, "{kind:?}");
            let mut fresh = Stage::at(kind, OPTIONS, crown, &uniform, 8);
            residency(&mut stage, &mut fresh).expect("residency");
            if matches!(kind, Kind::LodfSlots | Kind::LodfStamps) {
                assert!(content(&stage) == before, "{kind:?} at {collapses}");
            }
        }
    }
}

fn criterion(nearest: f32, farthest: f32, extent: Extent) -> Criterion {
    Criterion {
        nearest,
        farthest,
        extent,
    }
}

/// How many leaves show in each cluster.
fn leaves(crown: &Crown, state: &State) -> Vec<u32> {
    let counts = state.counts(crown.clusters());
    let clusters = crown.clusters().clusters.iter().zip(counts);
    clusters
        .map(|(cluster, count)| cluster.original_count() - count)
        .collect()
}

properties! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// What is farther from the eye never shows more leaves.
    #[test]
    fn farther_never_shows_more(
        seed in any::<u64>(),
        nearest in 0.0_f32..20.0,
        width in 0.01_f32..60.0,
    ) {
        let crown = crown();
        let mut draws = spinney::math::Stream::new(seed, 0).draws();
        let mut eye = || {
            let direction = Vec3::new(draws.signed(), draws.signed(), draws.signed());
            crown.center() + direction * 90.0 * draws.unit()
        };
        let eyes = [eye(), eye()];
        let farthest = nearest + width;
        let distances = eyes.map(|eye| eye.distance(crown.center()));
        let [first, second] = eyes.map(|eye| {
            let state = select(crown, criterion(nearest, farthest, Extent::Uniform), eye);
            state.leaf_count(crown.clusters())
        });
        prop_assert!(distances[0] > distances[1] || first >= second);
        prop_assert!(distances[1] > distances[0] || second >= first);
        let [first, second] = eyes.map(|eye| {
            let state = select(crown, criterion(nearest, farthest, Extent::Variable), eye);
            leaves(crown, &state)
        });
        for (number, &center) in crown.cluster_centers().iter().enumerate() {
            let [near, far] = eyes.map(|eye| eye.distance(center));
            prop_assert!(near > far || first[number] >= second[number]);
            prop_assert!(far > near || second[number] >= first[number]);
        }
    }

    /// A variable state leaves between one and all leaves in each cluster, and has a count for each.
    #[test]
    fn variable_counts_stay_within_their_clusters(
        seed in any::<u64>(),
        nearest in 0.0_f32..20.0,
        width in 0.0001_f32..60.0,
    ) {
        let crown = crown();
        let mut draws = spinney::math::Stream::new(seed, 1).draws();
        let mut coordinate = || 80.0 * draws.signed();
        let eye = Vec3::new(coordinate(), coordinate(), coordinate());
        let farthest = nearest + width;
        let state = select(crown, criterion(nearest, farthest, Extent::Variable), eye);
        let State::Variable { counts } = &state else {
            unreachable!("asked for by cluster");
        };
        let clusters = &crown.clusters().clusters;
        prop_assert_eq!(counts.len(), clusters.len());
        for ((cluster, &count), center) in clusters.iter().zip(counts).zip(crown.cluster_centers()) {
            let most = cluster.original_count() - 1;
            prop_assert!(count <= most);
            let distance = eye.distance(*center);
            prop_assert!(distance > nearest || count == 0);
            prop_assert!(distance < farthest || count == most);
        }
    }
}

properties! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// The number of leaves keeps the law of distance along any way, over the crown and by cluster.
    #[test]
    fn detail_keeps_the_law_of_distance(
        path in strategy::view_path(80.0, 1..=12),
        nearest in 0_u8..20,
        width in 1_u8..60,
    ) {
        let crown = crown();
        let nearest = f32::from(nearest);
        let farthest = nearest + f32::from(width);
        let asked = |most, least| Asked {
            nearest: f64::from(nearest),
            farthest: f64::from(farthest),
            most,
            least,
        };
        let sequence = crown.sequence();
        let whole = path.iter().map(|&eye| {
            let state = select(crown, criterion(nearest, farthest, Extent::Uniform), eye);
            let distance = f64::from(eye.distance(crown.center()));
            (distance, state.leaf_count(crown.clusters()))
        });
        let whole: Vec<(f64, u32)> = whole.collect();
        detail_by_distance(&asked(sequence.original_count(), sequence.root_count()), &whole)?;
        let shown: Vec<Vec<u32>> = path
            .iter()
            .map(|&eye| select(crown, criterion(nearest, farthest, Extent::Variable), eye))
            .map(|state| leaves(crown, &state))
            .collect();
        let clusters = crown.clusters().clusters.iter().zip(crown.cluster_centers());
        for (number, (cluster, center)) in clusters.enumerate() {
            let places = path.iter().zip(&shown);
            let places: Vec<(f64, u32)> = places
                .map(|(eye, shown)| (f64::from(eye.distance(*center)), shown[number]))
                .collect();
            detail_by_distance(&asked(cluster.original_count(), 1), &places)?;
        }
    }
}

/// Walking straight away, from within the crown to far behind the last distance.
#[test]
fn walking_away_all_leaves_go_one_by_one() {
    let crown = crown();
    let sequence = crown.sequence();
    for extent in [Extent::Uniform, Extent::Variable] {
        let steps = 0..=4000_u16;
        let counts: Vec<u32> = steps
            .map(|step| {
                // Beyond all clusters the way leads away from each of them.
                let eye = crown.center() + Vec3::Z * (4.0 + f32::from(step) / 100.0);
                let state = select(crown, criterion(8.0, 40.0, extent), eye);
                state.leaf_count(crown.clusters())
            })
            .collect();
        assert!(counts.is_sorted_by(|near, far| near >= far), "{extent:?}");
        assert_eq!(counts[0], sequence.original_count());
        assert_eq!(counts.last(), Some(&sequence.root_count()));
        let steepest = counts.windows(2).map(|pair| pair[0] - pair[1]).max();
        // 8018 leaves over 3200 steps.
        assert!(steepest <= Some(40), "{extent:?}: {steepest:?}");
        assert!(index_u32(counts.len()) > 4000);
    }
}
