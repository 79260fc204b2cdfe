//! Laws of what one state shows.

use super::super::operation::Shown;
use super::super::{History, Law, Violation};
use crate::math::index_u32;
use crate::models::State;

/// Partition: the visible leaves are one cut of each tree, so that every original leaf stands under
/// exactly one of them.
///
/// Catches: the papers' static list, which misses leaves and shows others; the loop over clusters
/// that runs one too many, which shows a cluster twice; a slot left stale on a split.
///
/// # Errors
///
/// The first original leaf that stands under none or several, or a number that is no leaf.
pub fn partition(history: &History, state: &State, visible: &[u32]) -> Result<(), Violation> {
    let broken = |what: String, expected: String, found: String| {
        let place = format!("in {}", Shown(state));
        Err(Violation::new(Law::Partition, place, what, expected, found))
    };
    let mut covered = vec![0_u32; history.sequence().record_count() as usize];
    for &leaf in visible {
        match covered.get_mut(leaf as usize) {
            Some(count) => *count = count.saturating_add(1),
            None => return no_leaf(Law::Partition, history, state, leaf),
        }
    }
    // A new leaf has a greater number than its operands, so one pass from the end is enough.
    let originals = history.leaf_count() as usize;
    for (op, collapse) in history.sequence().collapses().iter().enumerate().rev() {
        let above = covered[originals + op];
        for old in collapse.old {
            let count = &mut covered[old as usize];
            *count = count.saturating_add(above);
        }
    }
    if let Some(leaf) = covered[..originals].iter().position(|&count| count != 1) {
        let what = format!("visible leaves that original leaf {leaf} stands under");
        return broken(what, "1".to_owned(), covered[leaf].to_string());
    }
    let wanted = history.leaf_count() - done(state);
    if index_u32(visible.len()) != wanted {
        let what = "visible leaves".to_owned();
        return broken(what, wanted.to_string(), visible.len().to_string());
    }
    Ok(())
}

fn done(state: &State) -> u32 {
    match state {
        State::Uniform { collapses } => *collapses,
        State::Variable { counts } => counts.iter().sum(),
        State::Cards(_) | State::Strokes(_) => 0,
    }
}

fn no_leaf(law: Law, history: &History, state: &State, leaf: u32) -> Result<(), Violation> {
    let records = history.sequence().record_count();
    Err(Violation::new(
        law,
        format!("in {}", Shown(state)),
        "the number of a visible leaf",
        format!("below {records}"),
        leaf,
    ))
}

/// Birth before death: a leaf is visible only from the collapse that makes it to the collapse that
/// consumes it.
///
/// Catches: the papers' static list, which shows leaves that are consumed already; a wrong birth
/// stamp; a split loop that reads the entry of the next operation.
///
/// # Errors
///
/// The first visible leaf that is not made yet or gone already, or a number that is no leaf.
pub fn birth_before_death(
    history: &History,
    state: &State,
    visible: &[u32],
) -> Result<(), Violation> {
    let broken = |what: String, expected: &str, found: &str| {
        let place = format!("in {}", Shown(state));
        let law = Law::BirthBeforeDeath;
        Err(Violation::new(law, place, what, expected, found))
    };
    for &leaf in visible {
        if leaf >= history.sequence().record_count() {
            return no_leaf(Law::BirthBeforeDeath, history, state, leaf);
        }
        if let Some(birth) = history
            .birth(leaf)
            .filter(|&op| !history.is_done(op, state))
        {
            let what = format!("visible leaf {leaf}, which collapse {birth} makes");
            return broken(what, "made", "not made yet");
        }
        if let Some(death) = history.death(leaf).filter(|&op| history.is_done(op, state)) {
            let what = format!("visible leaf {leaf}, which collapse {death} consumes");
            return broken(what, "there", "gone already");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history() -> History {
        History::new(4, &[[0, 1], [4, 2]]).expect("a sound history")
    }

    const ONE: State = State::Uniform { collapses: 1 };

    #[test]
    fn cuts_are_told_from_what_is_none() {
        let history = history();
        assert_eq!(partition(&history, &ONE, &[2, 3, 4]), Ok(()));
        let missing = partition(&history, &ONE, &[2, 4]).expect_err("leaf 3 is missing");
        assert_eq!(
            missing.to_string(),
            "partition is broken in level 1: visible leaves that original leaf 3 stands under: \
             expected 1, found 0"
        );
        let twice = partition(&history, &ONE, &[0, 2, 3, 4]).expect_err("leaf 0 shows twice");
        assert_eq!((twice.expected.as_str(), twice.found.as_str()), ("1", "2"));
        // A cut of the trees, but of another level.
        assert!(partition(&history, &ONE, &[0, 1, 2, 3]).is_err());
        assert!(partition(&history, &ONE, &[2, 3, 4, 9]).is_err());
    }

    #[test]
    fn leaves_show_between_birth_and_death() {
        let history = history();
        assert_eq!(birth_before_death(&history, &ONE, &[2, 3, 4]), Ok(()));
        let early = birth_before_death(&history, &ONE, &[3, 5]).expect_err("5 is not made yet");
        assert_eq!(early.found, "not made yet");
        let late = birth_before_death(&history, &ONE, &[0, 2, 3]).expect_err("0 is gone");
        assert_eq!(
            late.to_string(),
            "birth before death is broken in level 1: visible leaf 0, which collapse 0 consumes: \
             expected there, found gone already"
        );
        assert!(birth_before_death(&history, &ONE, &[6]).is_err());
    }
}
