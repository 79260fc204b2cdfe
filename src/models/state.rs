//! How much detail is shown: all that decides what a resident model holds on the device.

use serde::{Deserialize, Serialize};

use super::{Change, TrunkLevel};
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

    /// The collapses done in each cluster.
    #[must_use]
    pub fn counts(&self, clusters: &Clusters) -> Vec<u32> {
        match self {
            Self::Uniform { collapses } => clusters.uniform(*collapses),
            Self::Variable { counts } => counts.clone(),
        }
    }

    /// The visible leaves, cluster by cluster, in array order.
    #[must_use]
    pub fn visible(&self, clusters: &Clusters) -> Vec<u32> {
        let counts = self.counts(clusters);
        let shown = clusters.clusters.iter().zip(&counts);
        shown
            .flat_map(|(cluster, &count)| cluster.visible(count))
            .collect()
    }

    /// How many leaves are visible.
    #[must_use]
    pub fn leaf_count(&self, clusters: &Clusters) -> u32 {
        let originals: u32 = clusters
            .clusters
            .iter()
            .map(|cluster| cluster.original_count())
            .sum();
        originals - self.collapse_count()
    }

    /// What it takes to keep: 4 bytes, and 4 a cluster where each has its own number.
    #[must_use]
    pub fn host_bytes(&self) -> u64 {
        match self {
            Self::Uniform { .. } => 4,
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
        }
    }
}
