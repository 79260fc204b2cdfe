//! What a cell of topology says: `^<E6<<E10+F1`.

use crate::limits::WOOD_SEGMENTS;

/// How an entity goes on from the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    /// `/`: its first part, at a finer scale.
    Part,
    /// `<`: the next on its axis.
    Next,
    /// `+`: a branch.
    Branch,
}

/// One step of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Step<'t> {
    /// How it goes on.
    pub(super) relation: Relation,
    /// Whether the sign is doubled: there are entities between, up to its index.
    pub(super) skips: bool,
    /// The class.
    pub(super) symbol: &'t str,
    /// The number behind it, if it has one.
    pub(super) index: Option<u64>,
}

/// Reads a cell: whether it begins with `^`, and its steps.
///
/// # Errors
///
/// The character, from 0, at which it is not understood, and what is wanted there.
pub(super) fn steps(cell: &str) -> Result<(bool, Vec<Step<'_>>), (usize, String)> {
    let (goes_on, mut rest) = match cell.strip_prefix('^') {
        Some(rest) => (true, rest),
        None => (false, cell),
    };
    let at = |rest: &str| cell[..cell.len() - rest.len()].chars().count();
    let mut steps = Vec::new();
    while !rest.is_empty() {
        let relation = match rest.as_bytes()[0] {
            b'/' => Relation::Part,
            b'<' => Relation::Next,
            b'+' => Relation::Branch,
            _ => {
                let found: String = rest.chars().take(16).collect();
                return Err((at(rest), format!("{found:?}, wanted one of / < +")));
            }
        };
        let sign = &rest[..1];
        rest = &rest[1..];
        let skips = relation != Relation::Part && rest.starts_with(sign);
        if skips {
            rest = &rest[1..];
        }
        let end = rest.find(['/', '<', '+', '^']).unwrap_or(rest.len());
        let name = rest[..end].trim();
        let digits = name.trim_end_matches(|c: char| c.is_ascii_digit());
        let (symbol, index) = name.split_at(digits.len());
        let is_symbol = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$');
        if symbol.is_empty() || !symbol.chars().all(is_symbol) {
            let message = format!("{name:?} is no entity, wanted a class and a number, such as E1");
            return Err((at(rest), message));
        }
        if steps.len() >= WOOD_SEGMENTS {
            let message = format!("more entities than the limit of {WOOD_SEGMENTS}");
            return Err((at(rest), message));
        }
        steps.push(Step {
            relation,
            skips,
            symbol,
            index: index.parse().ok(),
        });
        rest = &rest[end..];
    }
    if steps.is_empty() {
        return Err((
            at(rest),
            "^ without an entity, wanted one of / < +".to_owned(),
        ));
    }
    Ok((goes_on, steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_read_step_by_step() {
        let step = |relation, skips, symbol, index| Step {
            relation,
            skips,
            symbol,
            index,
        };
        assert_eq!(
            steps("^/E1<<E35+Leaf++U7"),
            Ok((
                true,
                vec![
                    step(Relation::Part, false, "E", Some(1)),
                    step(Relation::Next, true, "E", Some(35)),
                    step(Relation::Branch, false, "Leaf", None),
                    step(Relation::Branch, true, "U", Some(7)),
                ]
            ))
        );
        assert_eq!(
            steps("/P1"),
            Ok((false, vec![step(Relation::Part, false, "P", Some(1))]))
        );
    }

    #[test]
    fn what_is_no_step_is_told_with_its_place() {
        for (cell, at, message) in [
            ("E1", 0, "\"E1\", wanted one of / < +"),
            ("^", 1, "^ without an entity, wanted one of / < +"),
            (
                "/é1<12",
                4,
                "\"12\" is no entity, wanted a class and a number, such as E1",
            ),
            (
                "/E1<",
                4,
                "\"\" is no entity, wanted a class and a number, such as E1",
            ),
            ("/E1^<E2", 3, "\"^<E2\", wanted one of / < +"),
            (
                "/a b",
                1,
                "\"a b\" is no entity, wanted a class and a number, such as E1",
            ),
        ] {
            assert_eq!(steps(cell), Err((at, message.to_owned())), "{cell}");
        }
    }
}
