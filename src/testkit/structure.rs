//! What a collapse/split structure has to tell so that it can be tested.

use super::{History, Law, Operation, Tally, Violation, Walk, laws};
use crate::models::{Model, State};

/// A level-of-detail structure over leaves, without any device: it is built from a [`History`],
/// goes from level to level, and tells which leaves it shows.
///
/// Three functions are enough. What a structure cannot do it answers with `false`, and it is then
/// tested without.
///
/// ```
/// use spinney::testkit::{History, Structure};
///
/// /// Replays the history from the start whenever it is asked.
/// struct Replay {
///     history: History,
///     done: usize,
/// }
///
/// impl Structure for Replay {
///     fn visible(&self) -> Vec<u32> {
///         let mut leaves: Vec<u32> = (0..self.history.leaf_count()).collect();
///         for (op, old) in (0..).zip(self.history.collapses()).take(self.done) {
///             leaves.retain(|leaf| !old.contains(leaf));
///             leaves.push(self.history.leaf_count() + op);
///         }
///         leaves
///     }
///     fn collapse(&mut self) {
///         self.done += 1;
///     }
///     fn split(&mut self) {
///         self.done -= 1;
///     }
/// }
/// # let history = History::new(4, &[[0, 1], [4, 2]]).unwrap();
/// # assert_eq!(Replay { history, done: 2 }.visible(), [3, 5]);
/// ```
pub trait Structure {
    /// The leaves that it shows, in any order.
    fn visible(&self) -> Vec<u32>;

    /// Does the next collapse of the history. Called only where there is one, and only when the
    /// structure stands at a level of the whole history.
    fn collapse(&mut self);

    /// Undoes the last collapse. Called only where there is one, and only when the structure stands
    /// at a level of the whole history.
    fn split(&mut self);

    /// Goes straight to the level after the first `collapses` of the history, from wherever it
    /// stands. Returns `false` if it can only go step by step; it has then done nothing.
    fn go_to(&mut self, collapses: u32) -> bool {
        _ = collapses;
        false
    }

    /// Brings every cluster to its own number of collapses, in the order of [`History::clusters`].
    /// Returns `false` if clusters cannot stand apart; it has then done nothing. A structure that
    /// can must also be able to [`go_to`](Self::go_to) a level from there.
    fn set_clusters(&mut self, counts: &[u32]) -> bool {
        _ = counts;
        false
    }
}

/// Takes a structure from one state to another, step by step where it has to. Returns whether it can.
pub(super) fn travel(structure: &mut impl Structure, from: &State, to: &State) -> bool {
    match (from, to) {
        (_, State::Variable { counts }) => structure.set_clusters(counts),
        (_, State::Uniform { collapses }) if structure.go_to(*collapses) => true,
        (State::Uniform { collapses: from }, State::Uniform { collapses: to }) => {
            (*from..*to).for_each(|_| structure.collapse());
            (*to..*from).for_each(|_| structure.split());
            true
        }
        (State::Variable { .. } | State::Cards(_) | State::Strokes(_), State::Uniform { .. })
        | (_, State::Cards(_) | State::Strokes(_)) => false,
    }
}

/// Takes a structure through a walk and checks, after each step, every law of structures:
/// [split undoes collapse](laws::split_undoes_collapse),
/// [history independence](laws::history_independence) against one that was built anew,
/// [birth before death](laws::birth_before_death), [partition](laws::partition) and
/// [monotone detail](laws::monotone_detail).
///
/// # Errors
///
/// The first law that is broken, with the step.
pub fn check_structure<S: Structure>(
    walk: &Walk,
    build: impl Fn(&History) -> S,
    tally: &mut Tally,
) -> Result<(), Violation> {
    let history = &walk.history;
    let mut structure = build(history);
    let mut state = State::FINEST;
    let mut shown = sorted(structure.visible());
    check_shown(history, &state, &shown, tally).map_err(|v| v.at("at the start"))?;
    // What stood before the last step, if that was one collapse.
    let mut collapsed_from: Option<Vec<u32>> = None;
    for (number, operation) in (1..).zip(&walk.operations) {
        let Some(to) = operation.target(history, &state) else {
            continue;
        };
        match operation {
            Operation::Collapse => structure.collapse(),
            Operation::Split => structure.split(),
            Operation::To(to) => {
                if !travel(&mut structure, &state, to) {
                    continue;
                }
            }
        }
        let place = format!("after step {number} ({operation})");
        let now = sorted(structure.visible());
        let mut check = || -> Result<(), Violation> {
            if let (Operation::Split, Some(before)) = (operation, &collapsed_from) {
                let law = laws::split_undoes_collapse(&to, before, &now);
                tally.count(Law::SplitUndoesCollapse, law)?;
            }
            let mut fresh = build(history);
            if travel(&mut fresh, &State::FINEST, &to) {
                let law = laws::history_independence(&to, &sorted(fresh.visible()), &now);
                tally.count(Law::HistoryIndependence, law)?;
            }
            check_shown(history, &to, &now, tally)?;
            let law = laws::monotone_detail(history, (&state, &shown), (&to, &now));
            tally.count(Law::MonotoneDetail, law)
        };
        check().map_err(|violation| violation.at(&place))?;
        collapsed_from = (*operation == Operation::Collapse).then_some(shown);
        (state, shown) = (to, now);
    }
    Ok(())
}

/// The laws of what one state shows.
pub(super) fn check_shown(
    history: &History,
    state: &State,
    visible: &[u32],
    tally: &mut Tally,
) -> Result<(), Violation> {
    let law = laws::birth_before_death(history, state, visible);
    tally.count(Law::BirthBeforeDeath, law)?;
    let law = laws::partition(history, state, visible);
    tally.count(Law::Partition, law)
}

pub(super) fn sorted(mut leaves: Vec<u32>) -> Vec<u32> {
    leaves.sort_unstable();
    leaves
}

/// One of our models as a structure: what it would draw in each state.
#[derive(Debug)]
pub struct ModelStructure {
    model: Box<dyn Model>,
    state: State,
}

impl ModelStructure {
    /// A model at full detail.
    #[must_use]
    pub fn new(model: Box<dyn Model>) -> Self {
        Self {
            model,
            state: State::FINEST,
        }
    }

    fn step(&mut self, step: impl Fn(u32) -> u32) {
        if let State::Uniform { collapses } = &mut self.state {
            *collapses = step(*collapses);
        }
    }
}

impl Structure for ModelStructure {
    fn visible(&self) -> Vec<u32> {
        self.model.drawn(&self.state)
    }

    fn collapse(&mut self) {
        self.step(|collapses| collapses + 1);
    }

    fn split(&mut self) {
        self.step(|collapses| collapses - 1);
    }

    fn go_to(&mut self, collapses: u32) -> bool {
        self.state = State::Uniform { collapses };
        true
    }

    fn set_clusters(&mut self, counts: &[u32]) -> bool {
        let counts = counts.to_vec();
        self.state = State::Variable { counts };
        true
    }
}
