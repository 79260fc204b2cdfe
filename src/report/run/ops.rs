//! `ops.jsonl`: the states that every frame showed, as changes; the resolved scene and this file are
//! all that it takes to say what a pixel shows.
//!
//! ```text
//! {"frame":0,"trees":[{"tree":0,"uniform":123},{"tree":1,"variable":[[0,4],[7,1]]}]}
//! {"frame":1,"trees":[{"tree":1,"variable":[[7,2]]}]}
//! ```
//!
//! A line names the trees whose state is another than on the line before; the first names all. After
//! `uniform` stands the number of collapses done of the whole sequence. After `variable` stand pairs
//! of a cluster and the number of collapses done in it, for the clusters that changed; where the tree
//! was not variable on the line before, for those with any. After `cards` stands where a model of cards
//! stands between its levels, in 1/256. After `strokes` stands a cut of a painting. After `trunk` stands the
//! number of collapses done of the trunk's sequence, after `branches` the step of its branches' error; without
//! either, of a tree that is named, none is done.

use serde::{Deserialize, Serialize};

use super::ledger::json;
use crate::limits;
use crate::math::index_u32;
use crate::models::{CardLevel, ErrorStep, State, StrokeCut, TreeState, TrunkLevel};
use crate::report::ReportError;
use crate::run::World;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    frame: u32,
    trees: Vec<TreeLine>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TreeLine {
    tree: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    uniform: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    variable: Option<Vec<(u32, u32)>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cards: Option<CardLevel>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    strokes: Option<StrokeCut>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    trunk: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    branches: Option<ErrorStep>,
}

/// Turns states into lines.
#[derive(Debug, Default)]
pub(super) struct OpsWriter {
    previous: Vec<TreeState>,
}

impl OpsWriter {
    /// The line of a frame, with its end.
    pub(super) fn line(&mut self, frame: u32, states: &[TreeState]) -> String {
        let trees = (0..).zip(states).filter_map(|(tree, state)| {
            let before = self.previous.get(tree as usize);
            (before != Some(state)).then(|| tree_line(tree, before, state))
        });
        let trees = trees.collect();
        let line = json(&Line { frame, trees });
        self.previous = states.to_vec();
        line + "\n"
    }
}

fn tree_line(tree: u32, before: Option<&TreeState>, state: &TreeState) -> TreeLine {
    let TreeState { foliage, trunk } = state;
    let (trunk, branches) = match *trunk {
        TrunkLevel::Collapses(0) => (None, None),
        TrunkLevel::Collapses(collapses) => (Some(collapses), None),
        TrunkLevel::Error(step) => (None, Some(step)),
    };
    let line = TreeLine {
        tree,
        uniform: None,
        variable: None,
        cards: None,
        strokes: None,
        trunk,
        branches,
    };
    match foliage {
        State::Uniform { collapses } => TreeLine {
            uniform: Some(*collapses),
            ..line
        },
        State::Cards(level) => TreeLine {
            cards: Some(*level),
            ..line
        },
        State::Strokes(cut) => TreeLine {
            strokes: Some(cut.clone()),
            ..line
        },
        State::Variable { counts } => {
            let known = |cluster: usize| match before.map(|before| &before.foliage) {
                Some(State::Variable { counts }) => counts.get(cluster).copied().unwrap_or(0),
                _ => 0,
            };
            let changed = counts.iter().enumerate();
            let changed = changed.filter(|(cluster, count)| known(*cluster) != **count);
            TreeLine {
                variable: Some(changed.map(|(c, count)| (index_u32(c), *count)).collect()),
                ..line
            }
        }
    }
}

/// Turns lines back into states.
#[derive(Debug)]
pub struct OpsReader<'w> {
    world: &'w World,
    lines: usize,
    states: Vec<TreeState>,
}

impl<'w> OpsReader<'w> {
    /// A reader before the first line.
    #[must_use]
    pub fn new(world: &'w World) -> Self {
        Self {
            world,
            lines: 0,
            states: Vec::new(),
        }
    }

    /// Reads the next line: the frame and the state of every tree.
    ///
    /// # Errors
    ///
    /// When it is no such line, names a tree, cluster or number of collapses that the world does not
    /// have, or is the first and leaves a tree out.
    pub fn read(&mut self, line: &str) -> Result<(u32, &[TreeState]), ReportError> {
        self.lines += 1;
        let number = self.lines;
        let fail = |message| ReportError::Ops {
            line: number,
            message,
        };
        if line.len() > limits::OPS_LINE_BYTES {
            let (found, limit) = (line.len(), limits::OPS_LINE_BYTES);
            return Err(fail(format!("{found} bytes exceed the limit of {limit}")));
        }
        let line: Line = serde_json::from_str(line).map_err(|error| fail(error.to_string()))?;
        for change in &line.trees {
            let state = self.changed(change).map_err(fail)?;
            let tree = change.tree as usize;
            match self.states.get_mut(tree) {
                Some(known) => *known = state,
                None => self.states.push(state),
            }
        }
        let (found, wanted) = (self.states.len(), self.world.trees.len());
        if found != wanted {
            return Err(fail(format!("{found} trees, wanted all {wanted}")));
        }
        Ok((line.frame, &self.states))
    }

    /// The state that a tree changes to, or what is wrong.
    fn changed(&self, change: &TreeLine) -> Result<TreeState, String> {
        let number = change.tree as usize;
        let known = self.states.get(number);
        let next = self.states.len();
        let tree = self.world.trees.get(number);
        let Some(tree) = tree.filter(|_| known.is_some() || number == next) else {
            let trees = self.world.trees.len();
            return Err(format!("tree {number} after {next} of {trees}"));
        };
        let crown = &self.world.crowns[tree.crown];
        let check = |place: &str, count: u32, most: u32| {
            let message = || format!("tree {number}{place}: {count} collapses, at most {most}");
            (count <= most).then_some(()).ok_or_else(message)
        };
        let collapses = change.trunk.unwrap_or(0);
        if collapses > 0 {
            let trunk = self.world.trunks[tree.crown].as_ref();
            let most = trunk.map_or(0, |trunk| trunk.collapses().collapse_count());
            check(", trunk", collapses, most)?;
        }
        let trunk = match change.branches {
            None => TrunkLevel::Collapses(collapses),
            Some(step) if collapses == 0 && step <= ErrorStep::COARSEST => TrunkLevel::Error(step),
            Some(step) => {
                let (found, most) = (step.number(), ErrorStep::COARSEST.number());
                return Err(format!(
                    "tree {number}: step {found} of branches, at most {most}, and no collapses"
                ));
            }
        };
        let wanted = (change.uniform, &change.variable, change.cards);
        let foliage = match (wanted, &change.strokes) {
            // Numbers past what there is mean all of it.
            ((None, None, None), Some(cut)) => State::Strokes(cut.clone()),
            ((None, None, Some(level)), None) => {
                let levels = limits::CARD_LEVELS as u64;
                let most = u64::from(CardLevel::STEPS) * (levels - 1);
                if u64::from(level.0) > most {
                    let found = level.0;
                    return Err(format!(
                        "tree {number}: level {found} of cards, at most {most}"
                    ));
                }
                State::Cards(level)
            }
            ((Some(collapses), None, None), None) => {
                check("", collapses, crown.sequence().collapse_count())?;
                State::Uniform { collapses }
            }
            ((None, Some(changed), None), None) => {
                let clusters = &crown.clusters().clusters;
                let mut counts = match known.map(|known| &known.foliage) {
                    Some(State::Variable { counts }) => counts.clone(),
                    _ => vec![0; clusters.len()],
                };
                for &(cluster, count) in changed {
                    let found = clusters.get(cluster as usize);
                    let found = found.zip(counts.get_mut(cluster as usize));
                    let Some((held, known)) = found else {
                        let most = clusters.len();
                        return Err(format!("tree {number}: cluster {cluster} of {most}"));
                    };
                    let place = format!(", cluster {cluster}");
                    check(&place, count, held.original_count() - 1)?;
                    *known = count;
                }
                State::Variable { counts }
            }
            _ => {
                let message = format!(
                    "tree {number}: wanted one of `uniform`, `variable`, `cards`, `strokes`"
                );
                return Err(message);
            }
        };
        Ok(TreeState { foliage, trunk })
    }
}
