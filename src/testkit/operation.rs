//! Walks: operations on a structure, one after another.

use std::fmt;

use super::History;
use crate::models::{CardLevel, State};

/// One step of a walk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Operation {
    /// The next collapse of the history.
    Collapse,
    /// Undoes the last collapse.
    Split,
    /// Straight to a state: uniform, or every cluster to its own number of collapses.
    To(State),
}

impl Operation {
    /// Every step that there is in a history: single ones, levels, and clusters to any numbers, of
    /// which there may be many.
    #[must_use]
    pub fn every(history: &History) -> Vec<Self> {
        let mut steps = vec![Self::Collapse, Self::Split];
        let levels = (0..=history.collapse_count()).map(|collapses| State::Uniform { collapses });
        steps.extend(levels.map(Self::To));
        let most = history.most_counts();
        let mut counts = vec![0; most.len()];
        loop {
            steps.push(Self::To(State::Variable {
                counts: counts.clone(),
            }));
            // The next numbers, the first cluster's fastest.
            let Some(cluster) = counts
                .iter()
                .zip(&most)
                .position(|(count, most)| count < most)
            else {
                return steps;
            };
            counts[..cluster].fill(0);
            counts[cluster] += 1;
        }
    }

    /// The state that a step leads to; `None` for a step that cannot be taken: a collapse or split
    /// out of a variable state, or past an end.
    #[must_use]
    pub fn target(&self, history: &History, from: &State) -> Option<State> {
        let collapses = match (self, from) {
            (Self::To(state), _) => return history.fits(state).then(|| state.clone()),
            (Self::Collapse, State::Uniform { collapses }) => collapses.checked_add(1)?,
            (Self::Split, State::Uniform { collapses }) => collapses.checked_sub(1)?,
            (
                Self::Collapse | Self::Split,
                State::Variable { .. } | State::Cards(_) | State::Strokes(_),
            ) => {
                return None;
            }
        };
        let state = State::Uniform { collapses };
        history.fits(&state).then_some(state)
    }
}

impl fmt::Display for Operation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Collapse => write!(out, "collapse"),
            Self::Split => write!(out, "split"),
            Self::To(state) => write!(out, "to {}", Shown(state)),
        }
    }
}

/// A history and a walk through its states, from full detail.
#[derive(Clone, PartialEq)]
pub struct Walk {
    /// What the structure is built from.
    pub history: History,
    /// The steps; those that cannot be taken where they stand are passed over.
    pub operations: Vec<Operation>,
}

impl Walk {
    /// The states that it leads through, without its start.
    #[must_use]
    pub fn states(&self) -> Vec<State> {
        let mut state = State::FINEST;
        let mut states = Vec::with_capacity(self.operations.len());
        for operation in &self.operations {
            if let Some(target) = operation.target(&self.history, &state) {
                states.push(target.clone());
                state = target;
            }
        }
        states
    }
}

/// As in "4 leaves, collapses (0 1) (4 2); walk: collapse, split, to clusters 1 0".
impl fmt::Display for Walk {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}; walk:", self.history)?;
        for (number, operation) in self.operations.iter().enumerate() {
            let comma = if number == 0 { "" } else { "," };
            write!(out, "{comma} {operation}")?;
        }
        if self.operations.is_empty() {
            write!(out, " none")?;
        }
        Ok(())
    }
}

/// As it is displayed, for counter-examples.
impl fmt::Debug for Walk {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Walk({self})")
    }
}

/// A state as people read it: "level 3", or "clusters 1 0 2".
pub(super) struct Shown<'a>(pub(super) &'a State);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            State::Uniform { collapses } => write!(out, "level {collapses}"),
            State::Cards(CardLevel(level)) => write!(out, "cards {level}"),
            State::Strokes(cut) => {
                write!(out, "strokes of row {} to shell {}", cut.row, cut.switch)
            }
            State::Variable { counts } => {
                write!(out, "clusters")?;
                let shown = 16;
                for count in counts.iter().take(shown) {
                    write!(out, " {count}")?;
                }
                if counts.len() > shown {
                    write!(out, " …")?;
                }
                Ok(())
            }
        }
    }
}
