//! Hysteresis: what was wanted a little differently stays as it is.

use super::super::{Crown, State};

/// What may stay, though it is not what is wanted.
#[derive(Debug, Clone, PartialEq)]
pub enum Band {
    /// What lies between the states that would be wanted a little nearer and a little farther, or
    /// for a little less and more error; each cluster by itself, where detail is variable.
    ///
    /// A band in whole leaves would not do: in a cluster of two leaves, there is nothing between.
    Between {
        /// Wanted with more demand: nowhere more collapses than wanted.
        finer: State,
        /// Wanted with less.
        coarser: State,
    },
    /// What differs by at most this share of all the crown's collapses, added over its clusters.
    ///
    /// All or none: so a budget of leaves stays exact.
    Share(f32),
}

/// What stands after `wanted` was asked for while `present` stood: what the band lets stay, and the
/// rest as wanted.
///
/// So a wish that goes to and fro within the band changes nothing, and what stands never lies further
/// from the wish than the band. Between uniform and variable states it goes over at once.
///
/// ```
/// # use spinney::models::{Band, Crown, State, settle};
/// # fn of(crown: &Crown) {
/// let at = |collapses| State::Uniform { collapses };
/// let band = Band::Between { finer: at(90), coarser: at(110) };
/// assert_eq!(settle(crown, &at(95), at(100), &band), at(95));
/// assert_eq!(settle(crown, &at(85), at(100), &band), at(100));
/// # }
/// ```
#[must_use]
pub fn settle(crown: &Crown, present: &State, wanted: State, band: &Band) -> State {
    match (present, &wanted) {
        (State::Uniform { .. }, State::Uniform { .. })
        | (State::Variable { .. }, State::Variable { .. }) => {}
        _ => return wanted,
    }
    match band {
        Band::Share(share) => {
            let moved: u64 = match (present, &wanted) {
                (State::Uniform { collapses: from }, State::Uniform { collapses: to }) => {
                    u64::from(from.abs_diff(*to))
                }
                _ => {
                    let clusters = crown.clusters();
                    let pairs = present
                        .counts(clusters)
                        .into_iter()
                        .zip(wanted.counts(clusters));
                    pairs.map(|(from, to)| u64::from(from.abs_diff(to))).sum()
                }
            };
            let all = f64::from(crown.sequence().collapse_count());
            if moved as f64 > f64::from(*share) * all {
                wanted
            } else {
                present.clone()
            }
        }
        Band::Between { finer, coarser } => match (present, wanted, finer, coarser) {
            (
                State::Uniform { collapses: from },
                State::Uniform { collapses: to },
                State::Uniform { collapses: least },
                State::Uniform { collapses: most },
            ) => State::Uniform {
                collapses: stays_or(*from, to, [*least, *most]),
            },
            (
                State::Variable { counts: from },
                State::Variable { counts: to },
                State::Variable { counts: least },
                State::Variable { counts: most },
            ) => State::Variable {
                counts: (from.iter().zip(to))
                    .zip(least.iter().zip(most))
                    .map(|((&from, to), (&least, &most))| stays_or(from, to, [least, most]))
                    .collect(),
            },
            (_, wanted, _, _) => wanted,
        },
    }
}

fn stays_or(present: u32, wanted: u32, [least, most]: [u32; 2]) -> u32 {
    if (least..=most).contains(&present) {
        present
    } else {
        wanted
    }
}
