//! Laws of two moments: two ways to a state, two states of more and less detail.

use super::super::operation::Shown;
use super::super::{History, Law, Violation};
use crate::models::State;

/// Split undoes collapse: after a collapse and the split that undoes it, what is visible is what
/// was. Both lists ascending.
///
/// Catches: a split that leaves a slot stale; the split loop that reads the entry of the next
/// operation, not of the last one done.
///
/// # Errors
///
/// The first leaf that is in one list only.
pub fn split_undoes_collapse(
    state: &State,
    before: &[u32],
    after: &[u32],
) -> Result<(), Violation> {
    let place = format!("in {}", Shown(state));
    same_leaves(Law::SplitUndoesCollapse, &place, before, after)
}

/// History independence: what is visible after a walk is what a structure shows that went straight
/// to the state. Both lists ascending.
///
/// Catches: a cursor that is not brought back in step after clusters stood apart.
///
/// # Errors
///
/// The first leaf that is in one list only.
pub fn history_independence(
    state: &State,
    straight: &[u32],
    walked: &[u32],
) -> Result<(), Violation> {
    let place = format!("in {}", Shown(state));
    same_leaves(Law::HistoryIndependence, &place, straight, walked)
}

fn same_leaves(law: Law, place: &str, wanted: &[u32], found: &[u32]) -> Result<(), Violation> {
    if wanted == found {
        return Ok(());
    }
    let lacks = wanted.iter().find(|leaf| !found.contains(leaf));
    let extra = found.iter().find(|leaf| !wanted.contains(leaf));
    let what = match (lacks, extra) {
        (Some(leaf), _) => format!("visible leaves (leaf {leaf} is missing)"),
        (None, Some(leaf)) => format!("visible leaves (leaf {leaf} is too much)"),
        (None, None) => "visible leaves (one shows twice)".to_owned(),
    };
    let [wanted, found] = [wanted, found].map(listed);
    Err(Violation::new(law, place, what, wanted, found))
}

/// The numbers of leaves, the first of them if there are many.
fn listed(leaves: &[u32]) -> String {
    let shown: Vec<String> = leaves.iter().take(16).map(u32::to_string).collect();
    let more = if leaves.len() > 16 { " …" } else { "" };
    format!("{}{more}", shown.join(" "))
}

/// Monotone detail: of two states, in each cluster the one with more collapses done shows as many
/// leaves fewer, and every leaf of the other stands under, or is, one of its leaves.
///
/// Catches: collapses that are applied to the wrong cluster; a leaf of coarser detail that shows
/// beside finer ones.
///
/// # Errors
///
/// The first cluster or leaf for which it does not hold.
pub fn monotone_detail(
    history: &History,
    (from, before): (&State, &[u32]),
    (to, after): (&State, &[u32]),
) -> Result<(), Violation> {
    let broken = |what: String, expected: String, found: String| {
        let place = format!("between {} and {}", Shown(from), Shown(to));
        let law = Law::MonotoneDetail;
        Err(Violation::new(law, place, what, expected, found))
    };
    let clusters = history.clusters();
    let cluster_of = |leaf: u32| clusters.cluster_of_leaf.get(leaf as usize).copied();
    let numbers = [before, after].map(|visible| {
        let mut numbers = vec![0_i64; clusters.clusters.len()];
        for cluster in visible.iter().filter_map(|&leaf| cluster_of(leaf)) {
            numbers[cluster as usize] += 1;
        }
        numbers
    });
    let [from, to] = [from, to].map(|state| state.counts(clusters));
    for (cluster, (&from, &to)) in from.iter().zip(&to).enumerate() {
        let gone = i64::from(to) - i64::from(from);
        let [before, after] = [0, 1].map(|side: usize| numbers[side][cluster]);
        if before - after != gone {
            let what = format!("leaves that cluster {cluster} loses");
            return broken(what, gone.to_string(), (before - after).to_string());
        }
    }
    // Whether each leaf is, or stands under, a visible one; for both sides.
    let covers = [before, after].map(|visible| covered(history, visible));
    let sides = [(before, &covers[1], false), (after, &covers[0], true)];
    for (leaves, cover, is_after) in sides {
        for &leaf in leaves {
            let Some(cluster) = cluster_of(leaf) else {
                continue;
            };
            let (from, to) = (from[cluster as usize], to[cluster as usize]);
            let is_finer = if is_after { to <= from } else { from <= to };
            if is_finer && !cover[leaf as usize] {
                let what = format!("what leaf {leaf} of the finer state stands under");
                let found = "no visible leaf of the coarser".to_owned();
                return broken(what, "a visible leaf of the coarser".to_owned(), found);
            }
        }
    }
    Ok(())
}

fn covered(history: &History, visible: &[u32]) -> Vec<bool> {
    let mut covered = vec![false; history.sequence().record_count() as usize];
    for &leaf in visible {
        if let Some(covered) = covered.get_mut(leaf as usize) {
            *covered = true;
        }
    }
    let originals = history.leaf_count() as usize;
    for (op, collapse) in history.sequence().collapses().iter().enumerate().rev() {
        if covered[originals + op] {
            for old in collapse.old {
                covered[old as usize] = true;
            }
        }
    }
    covered
}

/// What a criterion of distance asks for: all leaves up to one distance, the fewest from another on,
/// and between them a number that falls linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Metres; up to here all leaves are shown.
    pub nearest: f64,
    /// Metres; from here on only the fewest are, above `nearest`.
    pub farthest: f64,
    /// How many leaves there are.
    pub most: u32,
    /// How many are left at the end.
    pub least: u32,
}

/// Monotone detail by distance: what is farther never shows more leaves; up to the nearest distance
/// all are shown, from the farthest on the fewest, and between never fewer than asked for, nor one
/// more than that.
///
/// `shown` holds distances in metres with the number of leaves that were chosen there, in any order.
///
/// Catches: a number of leaves that is rounded the wrong way or not kept within its ends.
///
/// # Errors
///
/// The first distance, or pair of neighbouring distances, for which it does not hold.
pub fn detail_by_distance(asked: &Asked, shown: &[(f64, u32)]) -> Result<(), Violation> {
    let law = Law::MonotoneDetail;
    let mut shown = shown.to_vec();
    shown.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| b.1.cmp(&a.1)));
    for pair in shown.windows(2) {
        let [(near, more), (far, fewer)] = [pair[0], pair[1]];
        if fewer > more {
            let place = format!("between {near} m and {far} m");
            let what = "leaves shown at the farther distance";
            return Err(Violation::new(
                law,
                place,
                what,
                format!("at most {more}"),
                fewer,
            ));
        }
    }
    let range = f64::from(asked.most) - f64::from(asked.least);
    for (distance, leaves) in shown {
        let share = (distance - asked.nearest) / (asked.farthest - asked.nearest);
        let exact = f64::from(asked.most) - share.clamp(0.0, 1.0) * range;
        // Of an exact number, and of its neighbours that rounding may take it to.
        let slack = 1e-6 * (1.0 + range);
        let least = (exact - slack).max(f64::from(asked.least));
        let most = (exact + 1.0 + slack).min(f64::from(asked.most));
        let found = f64::from(leaves);
        let ends =
            (share <= 0.0 && leaves != asked.most) || (share >= 1.0 && leaves != asked.least);
        if ends || found < least || found > most {
            let expected = if share >= 1.0 {
                asked.least.to_string()
            } else {
                format!("at least {exact} and less than one more")
            };
            let place = format!("at {distance} m");
            return Err(Violation::new(law, place, "leaves shown", expected, leaves));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_compared_leaf_by_leaf() {
        let state = State::Uniform { collapses: 1 };
        assert_eq!(split_undoes_collapse(&state, &[1, 2], &[1, 2]), Ok(()));
        let stale = split_undoes_collapse(&state, &[1, 2], &[1, 3]).expect_err("3 for 2");
        assert_eq!(
            stale.to_string(),
            "split undoes collapse is broken in level 1: visible leaves (leaf 2 is missing): \
             expected 1 2, found 1 3"
        );
        let double = history_independence(&state, &[1, 2], &[1, 1, 2]).expect_err("1 twice");
        assert!(double.what.contains("twice"), "{double}");
    }

    #[test]
    fn less_detail_is_a_coarser_cut() {
        let history = History::new(5, &[[0, 1], [2, 3], [5, 6]]).expect("a sound history");
        let level = |collapses| State::Uniform { collapses };
        let leaves: Vec<Vec<u32>> = (0..4).map(|c| history.visible(&level(c))).collect();
        for from in 0..4 {
            for to in 0..4 {
                let pair = |c: u32| leaves[c as usize].as_slice();
                let (before, after) = (level(from), level(to));
                let law = monotone_detail(&history, (&before, pair(from)), (&after, pair(to)));
                assert_eq!(law, Ok(()), "{from} to {to}");
            }
        }
        // One leaf less, but of other leaves: 6 for 2 and 3 in place of 5 for 0 and 1.
        let finer = (&level(1), [2, 3, 4, 5].as_slice());
        let coarser = (&level(2), [0, 4, 6].as_slice());
        assert!(monotone_detail(&history, finer, coarser).is_err());
        let more = (&level(2), [2, 3, 4, 5].as_slice());
        assert!(monotone_detail(&history, finer, more).is_err());
    }

    #[test]
    fn numbers_of_leaves_follow_the_distance() {
        let asked = Asked {
            nearest: 10.0,
            farthest: 20.0,
            most: 110,
            least: 10,
        };
        let law = |shown: &[(f64, u32)]| detail_by_distance(&asked, shown);
        assert_eq!(
            law(&[(0.0, 110), (15.0, 60), (10.05, 110), (99.0, 10)]),
            Ok(())
        );
        assert!(law(&[(10.15, 108)]).is_err(), "fewer than asked for");
        assert!(law(&[(15.0, 62)]).is_err(), "more than a whole one more");
        assert!(
            law(&[(9.0, 109)]).is_err() && law(&[(20.0, 11)]).is_err(),
            "ends"
        );
        assert!(law(&[(15.2, 59), (15.21, 60)]).is_err(), "rises");
    }
}
