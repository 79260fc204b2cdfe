//! What every model of a trunk is built from.

use std::sync::{Arc, OnceLock};

use crate::math::{index_u32, index_usize};
use crate::models::TrunkLevel;
use crate::plant::{Material, Mesh, Plant, Prototype};
use crate::scene::{BranchChoice, BranchRemoval};
use crate::simplify::{
    BranchErrors, BranchLevel, BranchRelevance, BranchSequence, ErrorStep, PrimitiveCounts,
    SimplifiedMesh, Strips, VertexCollapseOptions, VertexCollapses, lowest_first, simplify_mesh,
};

/// Who simplifies trunks, where that is not simply done: one that keeps what was done before.
pub trait TrunkSimplifier: Send + Sync + std::fmt::Debug {
    /// What [`simplify_mesh`] answers.
    fn simplify(&self, mesh: &Mesh, options: VertexCollapseOptions) -> SimplifiedMesh;
}

/// The trunk of a plant, with its collapses once somebody wants them; shared by all models of it.
#[derive(Debug)]
pub struct Trunk {
    /// Has a trunk.
    plant: Arc<Plant>,
    options: VertexCollapseOptions,
    simplifier: Option<Arc<dyn TrunkSimplifier>>,
    simplified: OnceLock<SimplifiedMesh>,
    /// The triangles at each level.
    counts: OnceLock<Vec<u32>>,
    branch_choice: BranchChoice,
    branches: OnceLock<BranchSequence>,
}

impl Trunk {
    /// The trunk of a plant, if it has one, that is simplified as
    /// [usual](VertexCollapseOptions::usual), or to at most so many triangles.
    #[must_use]
    pub fn of(plant: &Arc<Plant>, stop_triangles: Option<u32>) -> Option<Self> {
        let usual = VertexCollapseOptions::usual(plant.trunk()?);
        Some(Self {
            plant: Arc::clone(plant),
            options: VertexCollapseOptions {
                stop_triangles: stop_triangles.unwrap_or(usual.stop_triangles),
            },
            simplifier: None,
            simplified: OnceLock::new(),
            counts: OnceLock::new(),
            branch_choice: BranchChoice::USUAL,
            branches: OnceLock::new(),
        })
    }

    /// The same, simplified by somebody.
    #[must_use]
    pub fn by(self, simplifier: Arc<dyn TrunkSimplifier>) -> Self {
        Self {
            simplifier: Some(simplifier),
            ..self
        }
    }

    /// The same, with branches as a scene wants them.
    #[must_use]
    pub fn branched(self, choice: BranchChoice) -> Self {
        Self {
            branch_choice: choice,
            branches: OnceLock::new(),
            ..self
        }
    }

    /// Whose it is.
    #[must_use]
    pub fn plant(&self) -> &Arc<Plant> {
        &self.plant
    }

    /// How branches are wanted.
    #[must_use]
    pub fn branch_choice(&self) -> &BranchChoice {
        &self.branch_choice
    }

    /// Its branches and the plant's needles; the first call looks for all that merges.
    #[must_use]
    pub fn branches(&self) -> &BranchSequence {
        let options = self.branch_choice.sequence_options();
        self.branches
            .get_or_init(|| BranchSequence::of(&self.plant, &options))
    }

    /// The level of branches at an error.
    #[must_use]
    pub fn branch_level(&self, step: ErrorStep) -> BranchLevel {
        let sequence = self.branches();
        let shares = self.branch_choice.error_shares();
        let level = sequence.at(step.error(), shares);
        match self.branch_choice.removal {
            BranchRemoval::Distance => level,
            BranchRemoval::Volume => {
                let [finest, _] = self.branch_choice.steps();
                // Needles are no branches: they merge as they would.
                let errors = BranchErrors {
                    needle: level.errors.needle,
                    ..sequence.errors(finest.error(), shares)
                };
                let relevance = BranchRelevance::of(sequence.skeleton());
                let most = level.counts().total();
                // As many branches as have no more primitives.
                let (mut low, mut high) = (0, relevance.order().len());
                while low < high {
                    let middle = (low + high).div_ceil(2);
                    let pruned = sequence.pruned(&relevance, middle, &errors);
                    if pruned.counts().total() <= most {
                        low = middle;
                    } else {
                        high = middle - 1;
                    }
                }
                sequence.pruned(&relevance, low, &errors)
            }
        }
    }

    /// What needles look like: as those of the first group, since groups of one plant look alike.
    #[must_use]
    pub fn needle_material(&self) -> Option<&Material> {
        let mut groups = self.plant.foliage().groups.iter();
        let needles = groups.find(|group| matches!(group.prototype, Prototype::Needle { .. }))?;
        Some(&needles.material)
    }

    /// What that level is made of.
    #[must_use]
    pub fn branch_counts(&self, step: ErrorStep) -> PrimitiveCounts {
        self.branch_level(step).counts()
    }

    /// Its full detail.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "no input reaches it")]
    pub fn mesh(&self) -> &Mesh {
        self.plant.trunk().expect("only a plant with one is kept")
    }

    /// Its collapses; the first call makes them.
    #[must_use]
    pub fn collapses(&self) -> &VertexCollapses {
        &self.simplified().collapses
    }

    /// The strips of full detail, by the numbers that the collapses give to vertices.
    pub(super) fn strips(&self) -> &Strips {
        &self.simplified().strips
    }

    fn simplified(&self) -> &SimplifiedMesh {
        self.simplified.get_or_init(|| match &self.simplifier {
            Some(simplifier) => simplifier.simplify(self.mesh(), self.options),
            None => simplify_mesh(self.mesh(), self.options),
        })
    }

    /// How many triangles there are at a level.
    ///
    /// # Panics
    ///
    /// When there are not so many collapses.
    #[must_use]
    pub fn triangle_count(&self, level: TrunkLevel) -> u32 {
        let counts = || self.collapses().triangle_counts();
        self.counts.get_or_init(counts)[level.collapses() as usize]
    }

    /// A triangle with these corners at a level, as the triangle of the mesh that has become it and the
    /// corners' numbers in the mesh; `None` if there is none.
    ///
    /// # Panics
    ///
    /// When there are not so many collapses.
    #[must_use]
    pub fn in_mesh(&self, level: TrunkLevel, corners: [u32; 3]) -> Option<(u32, [u32; 3])> {
        let collapses = self.collapses();
        let mut triangles = collapses.triangles_after(level.collapses());
        let (triangle, _) = triangles.find(|(_, found)| *found == lowest_first(corners))?;
        let number = |vertex: u32| collapses.order()[vertex as usize];
        Some((triangle, corners.map(number)))
    }

    /// The level at a point of the axis of detail that foliage has too: at `done` of `all` collapses of
    /// its leaves, the same share of the trunk's is done, rounded down. Without collapses of leaves it
    /// is full detail.
    #[must_use]
    pub fn level(&self, done: u32, all: u32) -> TrunkLevel {
        let ours = u64::from(self.collapses().collapse_count());
        let collapses = ours * u64::from(done.min(all)) / u64::from(all.max(1));
        TrunkLevel::Collapses(index_u32(index_usize(collapses)))
    }
}
