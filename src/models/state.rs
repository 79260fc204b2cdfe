//! How much detail is shown: all that decides what a resident model holds on the device.

use serde::{Deserialize, Serialize};

use super::{Change, TrunkLevel};
use crate::math::whole_u32;
use crate::simplify::Clusters;

/// A cut through the forest of leaves: fully describes a model's resident content.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// The first `collapses` of the sequence are done.
    Uniform {
        /// How many.
        collapses: u32,
    },
    /// Every cluster has its own number of collapses done.
    Variable {
        /// How many, a cluster.
        counts: Vec<u32>,
    },
    /// No leaf shows: cards stand for all of them.
    Cards(CardLevel),
    /// No leaf shows, and no trunk: strokes stand for both.
    Strokes(StrokeCut),
}

/// Which strokes of a painting show: fully describes what is resident beside the strokes themselves.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub struct StrokeCut {
    /// The row of leaf strokes that the outer shells show, 0 the finest.
    pub row: u32,
    /// The first shell, from outside, that shows the next row instead.
    pub switch: u32,
    /// Of each branching level, from the trunk on: how many strokes its branches show.
    pub limits: Vec<u32>,
    /// How many branches show, the longest first.
    pub branches: u32,
}

impl StrokeCut {
    /// What it takes to keep: 4 bytes a number, and 4 for how many limits there are.
    #[must_use]
    pub fn host_bytes(&self) -> u64 {
        16 + 4 * self.limits.len() as u64
    }
}

/// Where a model of cards stands in its list of levels, in 1/256 of a level.
///
/// 0 is the finest level, 256 the next one; between them is where the smooth change from one to the
/// other stands. Models without levels stand at 0.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
pub struct CardLevel(pub u32);

impl CardLevel {
    /// The finest level.
    pub const FINEST: Self = Self(0);

    /// Steps from a level to the next.
    pub const STEPS: u32 = 256;

    /// The finest of so many levels at a share of 0, the coarsest at 1, linear between.
    #[must_use]
    pub fn at_share(share: f64, levels: u32) -> Self {
        let steps = Self::STEPS * levels.saturating_sub(1);
        Self(whole_u32(share.clamp(0.0, 1.0) * f64::from(steps)))
    }

    /// The finer of the levels that it stands between, and how far it is on the way to the next: from 0
    /// to [`STEPS`](Self::STEPS) − 1.
    #[must_use]
    pub fn parts(self) -> [u32; 2] {
        [self.0 / Self::STEPS, self.0 % Self::STEPS]
    }
}

/// What a whole tree shows.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct TreeState {
    /// Of its leaves.
    pub foliage: State,
    /// Of its trunk, [finest](TrunkLevel::FINEST) where it has none.
    pub trunk: TrunkLevel,
}

impl TreeState {
    /// Full detail.
    pub const FINEST: Self = Self {
        foliage: State::FINEST,
        trunk: TrunkLevel::FINEST,
    };
}

/// With the trunk at full detail.
impl From<State> for TreeState {
    fn from(foliage: State) -> Self {
        Self {
            foliage,
            ..Self::FINEST
        }
    }
}

impl State {
    /// Full detail.
    pub const FINEST: Self = Self::Uniform { collapses: 0 };

    /// The collapses done in each cluster; none where cards or strokes show.
    #[must_use]
    pub fn counts(&self, clusters: &Clusters) -> Vec<u32> {
        match self {
            Self::Uniform { collapses } => clusters.uniform(*collapses),
            Self::Variable { counts } => counts.clone(),
            Self::Cards(_) | Self::Strokes(_) => clusters.uniform(0),
        }
    }

    /// The visible leaves, cluster by cluster, in array order; none where cards or strokes show.
    #[must_use]
    pub fn visible(&self, clusters: &Clusters) -> Vec<u32> {
        if matches!(self, Self::Cards(_) | Self::Strokes(_)) {
            return Vec::new();
        }
        let counts = self.counts(clusters);
        let shown = clusters.clusters.iter().zip(&counts);
        shown
            .flat_map(|(cluster, &count)| cluster.visible(count))
            .collect()
    }

    /// How many leaves are visible.
    #[must_use]
    pub fn leaf_count(&self, clusters: &Clusters) -> u32 {
        if matches!(self, Self::Cards(_) | Self::Strokes(_)) {
            return 0;
        }
        let originals: u32 = clusters
            .clusters
            .iter()
            .map(|cluster| cluster.original_count())
            .sum();
        originals - self.collapse_count()
    }

    /// What it takes to keep: 4 bytes, and 4 a cluster where each has its own number; [a cut's](StrokeCut::host_bytes).
    #[must_use]
    pub fn host_bytes(&self) -> u64 {
        match self {
            Self::Uniform { .. } | Self::Cards(_) => 4,
            Self::Strokes(cut) => cut.host_bytes(),
            Self::Variable { counts } => 4 + 4 * counts.len() as u64,
        }
    }

    /// What going over to another state means for the clusters.
    pub(super) fn change_to(&self, to: &Self, clusters: &Clusters) -> Change {
        let mut change = Change::default();
        for (before, after) in self.counts(clusters).into_iter().zip(to.counts(clusters)) {
            change.collapses += after.saturating_sub(before);
            change.splits += before.saturating_sub(after);
            change.clusters_touched += u32::from(before != after);
        }
        change
    }

    /// How many collapses are done over all clusters.
    #[must_use]
    pub fn collapse_count(&self) -> u32 {
        match self {
            Self::Uniform { collapses } => *collapses,
            Self::Variable { counts } => counts.iter().sum(),
            Self::Cards(_) | Self::Strokes(_) => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_of_cards_go_from_the_finest_to_the_coarsest() {
        let at = |share| CardLevel::at_share(share, 3);
        assert_eq!(
            [-1.0, 0.0, 0.25, 0.5, 1.0, 2.0].map(at),
            [0, 0, 128, 256, 512, 512].map(CardLevel)
        );
        assert_eq!(
            [0, 255, 256, 512].map(|at| CardLevel(at).parts()),
            [[0, 0], [0, 255], [1, 0], [2, 0]]
        );
        assert_eq!(
            [0, 1].map(|levels| CardLevel::at_share(1.0, levels)),
            [CardLevel::FINEST; 2]
        );
    }

    #[test]
    fn states_of_cards_read_back() {
        let state = State::Cards(CardLevel(300));
        let text = serde_json::to_string(&state).unwrap();
        assert_eq!(text, r#"{"cards":300}"#);
        assert_eq!(serde_json::from_str::<State>(&text).unwrap(), state);
    }
}
