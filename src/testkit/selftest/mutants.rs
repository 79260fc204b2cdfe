//! The mutants: what is broken in each, and how it is looked at.

use std::sync::Arc;

use super::super::device::check_end;
use super::super::laws::{Asked, detail_by_distance, error_never_rises};
use super::super::paper::{LeafCount, PaperFault, PaperLodf};
use super::super::{
    DeviceModel as _, History, Law, ModelStructure, Tally, Violation, Walk, check_device_model,
    check_structure,
};
use super::Counterexample;
use super::enumerate::{Extent, SingleSteps, first, flat_crown};
use super::tamper::{DeviceFault, Tampered};
use crate::math::{Stream, Vec3};
use crate::models::{Extraction, Gather, Kind, LeafFormat, ModelOptions, Occlusion, State};
use crate::scene::{CardOptions, PaintOptions};
use crate::simplify::{LeafSite, PlaneOptions, PlaneSolver, cluster_planes};

/// What is taken through the cases.
#[derive(Debug, Clone, Copy)]
pub(super) enum Subject {
    /// The papers' structure.
    Paper(Option<PaperFault>),
    /// What one of our models means to show.
    Shown(Kind),
    /// One of our models on its device.
    Device(Kind, Option<DeviceFault>),
    /// The number of leaves by distance.
    ByDistance(LeafCount),
    /// K-means over leaves.
    Planes(PlaneSolver),
}

/// Every mutant: its name, what is wrong, and the subject that has it.
pub(super) const MUTANTS: [(&str, &str, Subject); 26] = {
    use DeviceFault as D;
    use PaperFault as P;
    [
        (
            "literal list",
            "visible leaves by the papers' static `next` (our lodf-literal)",
            Subject::Shown(Kind::LodfLiteral),
        ),
        (
            "literal next",
            "the same in the papers' own structure",
            Subject::Paper(Some(P::LiteralList)),
        ),
        (
            "n_split with plus",
            "Algorithm 4 adds the active leaves",
            Subject::Paper(Some(P::SplitWithPlus)),
        ),
        (
            "split reads next entry",
            "Algorithm 2 splits the cluster of the next collapse",
            Subject::Paper(Some(P::SplitReadsNextEntry)),
        ),
        (
            "group loop runs on",
            "Algorithm 3 draws one group too many",
            Subject::Paper(Some(P::GroupLoopRunsOn)),
        ),
        (
            "cursor not resynchronised",
            "a level after clusters stood apart counts from the old cursor",
            Subject::Paper(Some(P::CursorNotResynchronised)),
        ),
        (
            "leaf count not updated",
            "Algorithm 2 forgets how many leaves show",
            Subject::Paper(Some(P::LeafCountNeverUpdated)),
        ),
        (
            "wrong birth",
            "a new leaf is born one collapse late",
            Subject::Paper(Some(P::BirthStampLate)),
        ),
        (
            "stored by depth",
            "arrays in the order of depth, not of consumption",
            Subject::Paper(Some(P::StoredByDepth)),
        ),
        (
            "old2 for old1",
            "a collapse consumes old2 where it should old1",
            Subject::Paper(Some(P::SecondOperandTwice)),
        ),
        (
            "init moves by one",
            "a collapse moves Init_group by one leaf",
            Subject::Paper(Some(P::InitMovesByOne)),
        ),
        (
            "leaf count to nearest",
            "leaves by distance are rounded to the nearest",
            Subject::ByDistance(LeafCount::RoundedToNearest),
        ),
        (
            "leaf count not clamped",
            "leaves by distance are a share of all",
            Subject::ByDistance(LeafCount::ShareOfAll),
        ),
        (
            "stale slot on split",
            "lodf-slots leaves the last slot as it was",
            Subject::Device(Kind::LodfSlots, Some(D::StaleSlotOnSplit)),
        ),
        (
            "missed dirty range",
            "lodf-cluster does not send the last changed cluster",
            Subject::Device(Kind::LodfCluster, Some(D::MissedRange)),
        ),
        (
            "count not sent",
            "lodf-slots does not send numbers of leaves",
            Subject::Device(Kind::LodfSlots, Some(D::CountNotSent)),
        ),
        (
            "wrong offset",
            "lodf-slots writes the last slot one further on",
            Subject::Device(Kind::LodfSlots, Some(D::WrongOffset)),
        ),
        (
            "threshold not sent",
            "lodf-stamps does not send thresholds",
            Subject::Device(Kind::LodfStamps, Some(D::ThresholdNotSent)),
        ),
        (
            "one collapse too far",
            "lodf-stamps commits another level than asked",
            Subject::Device(Kind::LodfStamps, Some(D::OneCollapseTooFar)),
        ),
        (
            "wrong birth stamp",
            "lodf-stamps uploads a stamp that is one late",
            Subject::Device(Kind::LodfStamps, Some(D::WrongBirthStamp)),
        ),
        (
            "transfer not counted",
            "the ledger lacks the last transfer",
            Subject::Device(Kind::LodfCluster, Some(D::TransferNotCounted)),
        ),
        (
            "transfer counted twice",
            "the ledger has the last transfer twice",
            Subject::Device(Kind::LodfStamps, Some(D::TransferCountedTwice)),
        ),
        (
            "byte behind the bus",
            "a dead byte changes without a write",
            Subject::Device(Kind::LodfCluster, Some(D::ByteBehindTheBus)),
        ),
        (
            "draw stops short",
            "lodf-cluster does not draw the last cluster",
            Subject::Device(Kind::LodfCluster, Some(D::StopsShort)),
        ),
        (
            "ties by slot order",
            "lodf-slots decides equal depth by slot",
            Subject::Device(Kind::LodfSlots, Some(D::TiesBySlotOrder)),
        ),
        (
            "literal eigen-solver",
            "a cluster's plane by power iteration with the inverse, as printed",
            Subject::Planes(PlaneSolver::Literal),
        ),
    ]
};

/// Every subject without a fault.
pub(super) fn sound() -> Vec<(String, Subject)> {
    let mut sound = vec![("papers, repaired".to_owned(), Subject::Paper(None))];
    let levels = Kind::SOUND.into_iter().filter(|kind| kind.has_levels());
    sound.extend(levels.map(|kind| (format!("{}, leaves", kind.label()), Subject::Shown(kind))));
    let kinds = Kind::SOUND.into_iter();
    sound.extend(kinds.map(|kind| {
        (
            format!("{}, device", kind.label()),
            Subject::Device(kind, None),
        )
    }));
    let by_distance = Subject::ByDistance(LeafCount::WholeLeavesGo);
    sound.push(("leaves by distance".to_owned(), by_distance));
    let planes = Subject::Planes(PlaneSolver::Jacobi);
    sound.push(("planes through crowns".to_owned(), planes));
    sound
}

/// All walks of up to three steps over two and three leaves, of two over four; then some by seed.
const STRUCTURES: Extent = Extent {
    steps: &[3, 3, 2],
    single_steps: SingleSteps::Too,
    seeded: 400,
};

/// All walks of up to three steps over two leaves, of two over three, of one over four; then some
/// by seed.
const DEVICES: Extent = Extent {
    steps: &[3, 2, 1],
    single_steps: SingleSteps::No,
    seeded: 60,
};

const OPTIONS: ModelOptions = ModelOptions {
    extraction: Extraction::Batched,
    gather: Gather::Single,
    format: LeafFormat::WIDE,
    occlusion: Occlusion::None,
    cards: CardOptions::USUAL,
    painting: PaintOptions::USUAL,
};

impl Subject {
    /// The first case that breaks a law; counts cases and checks.
    pub(super) fn first_failure(
        self,
        cases: &mut u64,
        tally: &mut Tally,
    ) -> Option<Counterexample> {
        match self {
            Self::Paper(fault) => first(STRUCTURES, |walk| {
                *cases += 1;
                let build = |history: &History| PaperLodf::new(history, fault);
                let law = check_structure(walk, build, tally);
                counterexample(walk, law)
            }),
            Self::Shown(kind) => first(STRUCTURES, |walk| {
                *cases += 1;
                let crown = flat_crown(&walk.history);
                let build = |_: &History| ModelStructure::new(kind.model(&crown, OPTIONS));
                counterexample(walk, check_structure(walk, build, tally))
            }),
            Self::Device(kind, fault) => first(DEVICES, |walk| {
                *cases += 1;
                counterexample(walk, check_on_device(kind, fault, walk, tally))
            }),
            Self::ByDistance(count) => by_distance(count, cases, tally),
            Self::Planes(solver) => planes(solver, cases, tally),
        }
    }
}

fn counterexample(walk: &Walk, law: Result<(), Violation>) -> Option<Counterexample> {
    law.err().map(|violation| Counterexample {
        example: walk.to_string(),
        violation,
    })
}

/// A model on its device through a walk; at the end it draws what lodf-cluster draws, which is held
/// against the replayed history.
fn check_on_device(
    kind: Kind,
    fault: Option<DeviceFault>,
    walk: &Walk,
    tally: &mut Tally,
) -> Result<(), Violation> {
    let history = Arc::new(walk.history.clone());
    let crown = flat_crown(&history);
    let states = walk.states();
    let build = |state: &State| Tampered::new(kind, &crown, &history, state, fault);
    check_device_model(&State::FINEST, &states, build, tally)?;
    let last = states.last().filter(|_| kind.has_levels());
    let last = last.unwrap_or(&State::FINEST);
    let mut reference = Tampered::new(Kind::LodfCluster, &crown, &history, last, None);
    let picture = reference.picture();
    let mut walked = build(&State::FINEST);
    for state in &states {
        walked.commit(state);
    }
    check_end(&mut walked, &mut build(last), picture.as_ref(), tally)
        .map_err(|violation| violation.at("at the end"))
}

/// Numbers of leaves at nine distances between all pairs of most and least, by the most.
fn by_distance(count: LeafCount, cases: &mut u64, tally: &mut Tally) -> Option<Counterexample> {
    for most in 1..=40 {
        for least in 1..=most {
            *cases += 1;
            let asked = Asked {
                nearest: 1.0,
                farthest: 2.0,
                most,
                least,
            };
            let steps = (0..=24).map(|step| f64::from(step) / 8.0);
            let shown: Vec<(f64, u32)> = steps.map(|at| (at, count.at(&asked, at))).collect();
            let law = detail_by_distance(&asked, &shown);
            if let Err(violation) = tally.count(Law::MonotoneDetail, law) {
                let example = format!("from {most} leaves at 1 m to {least} at 2 m");
                return Some(Counterexample { example, violation });
            }
        }
    }
    None
}

/// Crowns of two to twelve leaves at random in up to four planes, forty of each size.
fn planes(solver: PlaneSolver, cases: &mut u64, tally: &mut Tally) -> Option<Counterexample> {
    for leaves in 2..=12 {
        for count in 1..=4 {
            for seed in 0..40 {
                *cases += 1;
                let mut draws = Stream::new(seed, leaves).draws();
                let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
                let sites: Vec<LeafSite> = (0..leaves)
                    .map(|_| LeafSite {
                        centre: vector(),
                        normal: vector().normalize_or_zero(),
                    })
                    .collect();
                let options = PlaneOptions {
                    seeds: 1,
                    solver,
                    ..PlaneOptions::to(count)
                };
                let law = error_never_rises(&cluster_planes(&sites, &options).errors);
                if let Err(violation) = tally.count(Law::ErrorNeverRises, law) {
                    let example = format!("{leaves} leaves in {count} planes, seed {seed}");
                    return Some(Counterexample { example, violation });
                }
            }
        }
    }
    None
}
