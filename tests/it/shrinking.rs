//! What the strategies draw is sound, and a planted bug shrinks to a smallest example.

use std::sync::Arc;

use proptest::test_runner::{Config, RngAlgorithm, TestError, TestRng, TestRunner};
use spinney::math::Vec3;
use spinney::models::{Crown, Kind};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use spinney::testkit::strategy::{self, WalkOptions};
use spinney::testkit::{
    History, Law, ModelStructure, PaperFault, PaperLodf, Stage, State, Tally, TreeWalk, Walk,
    check_device_model, check_structure,
};

use crate::support::{OPTIONS, StageExt as _, properties};

#[path = "../../examples/naive_structure.rs"]
mod naive_structure;

fn large() -> WalkOptions {
    WalkOptions {
        leaves: 12..=40,
        roots: 1..=4,
        steps: 10..=40,
    }
}

properties! {
    #[test]
    fn walks_are_sound(walk in strategy::walk(large())) {
        let states = walk.states();
        assert!(states.iter().all(|state| walk.history.fits(state)), "{walk}");
        assert!((12..=40).contains(&walk.history.leaf_count()), "{walk}");
        assert!((10..=40).contains(&walk.operations.len()), "{walk}");
        let build = |history: &History| PaperLodf::new(history, None);
        check_structure(&walk, build, &mut Tally::default())?;
    }

    #[test]
    fn trees_have_a_leaf_for_each_of_the_history(case in strategy::tree_walk(large())) {
        let split = case.foliage.groups[0].leaf_count();
        let crown = case.crown();
        // Collapses stay within a group.
        let clusters = crown.clusters();
        let first = |leaf: usize| clusters.cluster_of_leaf[leaf];
        let count = case.walk.history.leaf_count() as usize;
        for left in 0..split {
            assert!((split..count).all(|right| first(left) != first(right)), "{case:?}");
        }
    }
}

/// Draws the same every time: what is found last depends on where it begins.
fn runner() -> TestRunner {
    let config = Config {
        failure_persistence: None,
        ..Config::with_cases(500)
    };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// The smallest failing walk, and how it fails, by proptest.
fn smallest_walk(fails: impl Fn(&Walk) -> bool) -> Walk {
    let mut runner = runner();
    let result = runner.run(&strategy::walk(large()), |walk| {
        proptest::prop_assert!(!fails(&walk));
        Ok(())
    });
    match result {
        Err(TestError::Fail(_, walk)) => walk,
        other => unreachable!("not found: {other:?}"),
    }
}

#[test]
fn faults_in_a_structure_shrink_to_a_few_leaves_and_steps() {
    // The fault, and the most leaves and steps of a smallest example.
    let faults = [
        (PaperFault::LiteralList, 4, 1),
        (PaperFault::SplitWithPlus, 2, 2),
        (PaperFault::SplitReadsNextEntry, 2, 2),
        (PaperFault::GroupLoopRunsOn, 1, 0),
        (PaperFault::CursorNotResynchronised, 2, 2),
        (PaperFault::LeafCountNeverUpdated, 2, 2),
        (PaperFault::BirthStampLate, 2, 1),
        (PaperFault::StoredByDepth, 4, 2),
        (PaperFault::SecondOperandTwice, 2, 0),
        (PaperFault::InitMovesByOne, 2, 1),
    ];
    for (fault, leaves, steps) in faults {
        let fails = |walk: &Walk| {
            let build = |history: &History| PaperLodf::new(history, Some(fault));
            check_structure(walk, build, &mut Tally::default()).is_err()
        };
        let walk = smallest_walk(fails);
        assert!(fails(&walk), "{fault:?}: {walk}");
        assert!(walk.history.leaf_count() <= leaves, "{fault:?}: {walk}");
        assert!(walk.operations.len() <= steps, "{fault:?}: {walk}");
    }
}

/// A plant of so many leaves, all alike.
fn plant(leaves: u32) -> Arc<Plant> {
    let corner = [Vec3::ZERO, Vec3::X, Vec3::ONE, Vec3::Y];
    let group = LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material::plain("leaf", [0.1, 0.4, 0.1]),
        owners: vec![NO_BRANCH; leaves as usize],
        positions: (0..leaves).flat_map(|_| corner).collect(),
    };
    let foliage = Foliage {
        groups: vec![group],
    };
    Arc::new(Plant::new("alike", None, None, foliage).expect("sound parts"))
}

#[test]
fn the_papers_list_shrinks_in_our_own_model() {
    let fails = |walk: &Walk| {
        let crown = Crown::new(
            plant(walk.history.leaf_count()),
            walk.history.sequence().clone(),
        );
        let crown = Arc::new(crown);
        let build = |_: &History| ModelStructure::new(Kind::LodfLiteral.model(&crown, OPTIONS));
        check_structure(walk, build, &mut Tally::default()).is_err()
    };
    let walk = smallest_walk(fails);
    assert!(
        walk.history.leaf_count() <= 4 && walk.operations.len() <= 1,
        "{walk}"
    );
}

/// A device model that goes one collapse too far; what it draws shrinks with it.
#[test]
fn a_fault_on_a_device_shrinks_too() {
    let mut runner = runner();
    let check = |case: &TreeWalk| {
        let crown = case.crown();
        let last = case.walk.history.collapse_count();
        let wrong = |state: &State| match state {
            State::Uniform { collapses } if *collapses < last => State::Uniform {
                collapses: collapses + 1,
            },
            other => other.clone(),
        };
        let states: Vec<State> = case.walk.states();
        let build = |state: &State| Stage::at(Kind::LodfSlots, OPTIONS, &crown, state, 8);
        // What is asked for, and what is done instead.
        let done: Vec<State> = states.iter().map(wrong).collect();
        states.iter().zip(&done).try_for_each(|(asked, done)| {
            let mut walked = build(&State::FINEST);
            spinney::testkit::DeviceModel::commit(&mut walked, done);
            spinney::testkit::laws::residency(&mut walked, &mut build(asked))
        })?;
        check_device_model(&State::FINEST, &states, build, &mut Tally::default())
    };
    let result = runner.run(&strategy::tree_walk(large()), |case| Ok(check(&case)?));
    let Err(TestError::Fail(_, case)) = result else {
        unreachable!("not found: {result:?}");
    };
    let violation = check(&case).expect_err("the smallest example fails");
    assert_eq!(violation.law, Law::Residency, "{violation}");
    // Two leaves and `to level 0`, or three and `collapse`: neither is one step from the other.
    let leaves = case.walk.history.leaf_count();
    assert!(leaves <= 3 && case.walk.operations.len() <= 1, "{case:?}");
    assert_eq!(case.foliage.leaf_count(), leaves as usize, "{case:?}");
}

#[test]
fn the_example_finds_its_bug() {
    let (walk, reason) = naive_structure::counterexample().expect("the bug is there");
    assert_eq!(
        walk.to_string(),
        "2 leaves, collapses (1 0); walk: collapse, split"
    );
    assert_eq!(
        reason,
        "split undoes collapse is broken after step 2 (split), in level 0: visible leaves (leaf 1 is \
         missing): expected 0 1, found 0 2"
    );
}
