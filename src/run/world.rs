//! What a scene shows, built offline: plants, their collapses, and where they stand.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use super::RunError;
use super::cache::ModelCache;
use super::crowns::CrownStore;
use super::progress::Progress;
use crate::limits;
use crate::math::{Quat, Vec3, det, index_u32};
use crate::models::{Crown, Placement, Trunk};
use crate::plant::{Foliage, Mesh, Plant, Prototype};
use crate::scene::{BranchChoice, CardOptions, ModelName, PlantSource, Scene, Simplifier, Tree};
use crate::simplify::{
    CollapseSequence, LeafCollapseOptions, LeafSite, PlaneClusters, PlaneHierarchy, PlaneLevel,
    PlaneOptions, PlaneSolver, PruningOptions, cluster_planes, collapse_leaves, flattened,
    leaf_sites, prune_leaves,
};

/// The plants of a scene and where they stand.
#[derive(Debug, Clone)]
pub struct World {
    /// Each plant once.
    pub crowns: Vec<Arc<Crown>>,
    /// The plant of each crown as it was grown or imported, which is what scenes pin; the crown's own is
    /// another where leaves were [moved](Self::flattened).
    pub plants: Vec<Arc<Plant>>,
    /// The trunk of each plant that has one; simplified once a model of it wants levels.
    pub trunks: Vec<Option<Arc<Trunk>>>,
    /// The trees in the order of the scene.
    pub trees: Vec<StandingTree>,
    /// The forests of patches, whose wood is drawn at once where the scene says so.
    pub groves: Vec<StandingGrove>,
    /// The ground, if the scene has one.
    pub ground: Option<Arc<Mesh>>,
    /// What importers had to say, a line each.
    pub remarks: Vec<String>,
}

/// A forest of patches in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct StandingGrove {
    /// Which of the trees are its, patch by patch.
    pub trees: Range<usize>,
    /// The trees of a patch: which of the plants each is, and where it stands in the patch.
    pub samples: Vec<StandingTree>,
    /// Where the patches stand.
    pub places: Vec<Placement>,
}

/// A tree in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingTree {
    /// Which of the plants it is.
    pub crown: usize,
    /// Where it stands.
    pub placement: Placement,
}

impl World {
    /// Plants that are there already, with trunks that are simplified as usual.
    #[must_use]
    pub fn of(crowns: Vec<Arc<Crown>>, trees: Vec<StandingTree>) -> Self {
        let trunk = |crown: &Arc<Crown>| Trunk::of(crown.plant(), None).map(Arc::new);
        Self {
            trunks: crowns.iter().map(trunk).collect(),
            plants: crowns
                .iter()
                .map(|crown| Arc::clone(crown.plant()))
                .collect(),
            crowns,
            trees,
            groves: Vec::new(),
            ground: None,
            remarks: Vec::new(),
        }
    }

    /// Whether a tree stands in a forest of patches that is drawn at once.
    #[must_use]
    pub fn is_in_grove(&self, tree: usize) -> bool {
        self.groves.iter().any(|grove| grove.trees.contains(&tree))
    }

    /// One of the plants alone, where its first tree stands.
    pub(super) fn plant_alone(&self, number: usize) -> Self {
        let mut trees = self.trees.iter().filter(|tree| tree.crown == number);
        let placement = trees.next().map(|tree| tree.placement);
        Self {
            crowns: vec![Arc::clone(&self.crowns[number])],
            plants: vec![Arc::clone(&self.plants[number])],
            trunks: vec![self.trunks[number].clone()],
            trees: vec![StandingTree {
                crown: 0,
                placement: placement.unwrap_or(Placement::IDENTITY),
            }],
            groves: Vec::new(),
            ground: None,
            remarks: Vec::new(),
        }
    }

    /// Grows or imports every plant of a scene once and simplifies its foliage.
    ///
    /// `folder` is where the scene's paths start.
    ///
    /// # Errors
    ///
    /// When a species or plant file cannot be read or grown, or is not the one that the scene pins.
    pub fn build(scene: &Scene, folder: &Path, progress: &dyn Progress) -> Result<Self, RunError> {
        Self::build_from(scene, folder, &CrownStore::default(), progress)
    }

    /// As [`build`](Self::build), with crowns that `store` keeps from other scenes.
    ///
    /// # Errors
    ///
    /// As [`build`](Self::build).
    pub fn build_from(
        scene: &Scene,
        folder: &Path,
        store: &CrownStore,
        progress: &dyn Progress,
    ) -> Result<Self, RunError> {
        let mut known: Vec<(&PlantSource, u64, usize)> = Vec::new();
        let mut world = Self::of(Vec::new(), Vec::new());
        world.ground = scene.terrain.map(|terrain| Arc::new(terrain.mesh()));
        let trees = scene.standing_trees();
        progress.begin("plants", distinct_plants(&trees));
        let mut size = Size::default();
        let mut digests = Vec::new();
        for (number, tree) in trees.iter().enumerate() {
            let found = known
                .iter()
                .find(|(source, seed, _)| **source == tree.source && *seed == tree.seed);
            let crown = match found {
                Some(&(_, _, crown)) => crown,
                None => {
                    let wanted = Wanted {
                        simplifier: scene.model.simplifier,
                        // Leaves that go need not be simplified.
                        stop_leaves: match scene.model.name {
                            ModelName::Bare => Some(u32::MAX),
                            _ => scene.model.stop_leaves,
                        },
                    };
                    // Before it is simplified, which takes far longer than to grow it.
                    let fits = |plant: &Plant| size.with_plant(number, plant).map(drop);
                    let remarks = &mut world.remarks;
                    let crown = store.crown(tree, folder, wanted, &fits, remarks)?;
                    size = size.with_plant(number, crown.plant())?;
                    let trunk = store.trunk(crown.plant(), scene.model.trunk_triangles);
                    world
                        .trunks
                        .push(trunk.map(|trunk| Arc::new(trunk.branched(scene.branches))));
                    world.plants.push(Arc::clone(crown.plant()));
                    world.crowns.push(crown);
                    digests.push(None);
                    known.push((&tree.source, tree.seed, world.crowns.len() - 1));
                    progress.step();
                    world.crowns.len() - 1
                }
            };
            let plant = world.crowns[crown].plant();
            size = size.with_tree(number, plant)?;
            if let Some(wanted) = tree.plant_digest {
                // Once a plant: a forest pins the same one at every tree.
                let found = *digests[crown].get_or_insert_with(|| plant.digest());
                if found != wanted {
                    return Err(RunError::Plant {
                        name: plant.name().to_owned(),
                        found,
                        wanted,
                    });
                }
            }
            world.trees.push(StandingTree {
                crown,
                placement: placement(tree),
            });
        }
        if scene.grove.is_some() {
            world.groves = groves(scene, &world.trees);
        }
        Ok(match scene.model.name {
            ModelName::Flattened => world.flattened(&scene.cards),
            ModelName::Bare => world.bare(),
            _ => world,
        })
    }

    /// The same plants at the same places with every leaf moved into the plane of its cluster, as many
    /// as the finest level of cards has; none of their leaves collapse.
    #[must_use]
    pub fn flattened(&self, cards: &CardOptions) -> Self {
        self.flattened_into(|plant| finest_planes(plant, cards))
    }

    /// The same for another level of cards, 0 being the finest, or the coarsest that there is.
    #[must_use]
    pub fn flattened_at(&self, cards: &CardOptions, level: usize) -> Self {
        let counts = cards.levels.as_slice();
        match counts.get(level).or(counts.last()) {
            Some(&count) if level > 0 => self.flattened_into(|plant| {
                let sites = leaf_sites(plant.foliage());
                let finest = finest_clusters(&sites, cards);
                PlaneHierarchy::of(&sites, &finest, cards.orientation_weight).level(count)
            }),
            _ => self.flattened(cards),
        }
    }

    fn flattened_into(&self, planes: impl Fn(&Plant) -> PlaneLevel) -> Self {
        let crown = |crown: &Arc<Crown>| {
            let plant = crown.plant();
            let level = planes(plant);
            let flat = with_foliage(plant, flattened(plant.foliage(), &level));
            Arc::new(flat.in_planes(level))
        };
        Self {
            crowns: self.crowns.iter().map(crown).collect(),
            ..self.clone()
        }
    }

    /// The same plants at the same places without leaves that have a surface: needles stay.
    #[must_use]
    pub fn bare(&self) -> Self {
        let crown = |crown: &Arc<Crown>| {
            let plant = crown.plant();
            let groups = plant.foliage().groups.iter();
            let needles =
                groups.filter(|group| matches!(group.prototype, Prototype::Needle { .. }));
            let groups = needles.cloned().collect();
            Arc::new(with_foliage(plant, Foliage { groups }))
        };
        Self {
            crowns: self.crowns.iter().map(crown).collect(),
            ..self.clone()
        }
    }

    /// The same plants at the same places with branches as they are wanted.
    #[must_use]
    pub fn branched(&self, choice: &BranchChoice) -> Self {
        let trunk = |trunk: &Arc<Trunk>| {
            let plain = Trunk::of(trunk.plant(), None);
            plain.map(|plain| Arc::new(plain.branched(*choice)))
        };
        let trunks = self.trunks.iter();
        Self {
            trunks: trunks.map(|known| known.as_ref().and_then(trunk)).collect(),
            ..self.clone()
        }
    }

    /// The same plants at the same places, simplified by `simplifier` to as many leaves each as now.
    #[must_use]
    pub fn simplified_by(&self, simplifier: Simplifier) -> Self {
        let crown = |crown: &Arc<Crown>| {
            let wanted = Wanted {
                simplifier,
                stop_leaves: Some(crown.sequence().root_count()),
            };
            Arc::new(crown_from(Arc::clone(crown.plant()), wanted, None))
        };
        Self {
            crowns: self.crowns.iter().map(crown).collect(),
            ..self.clone()
        }
    }
}

/// The planes that cards of a plant stand in at their finest level.
pub(super) fn finest_planes(plant: &Plant, cards: &CardOptions) -> PlaneLevel {
    finest_clusters(&leaf_sites(plant.foliage()), cards).into()
}

fn finest_clusters(sites: &[LeafSite], cards: &CardOptions) -> PlaneClusters {
    let options = PlaneOptions {
        count: cards.levels.as_slice()[0],
        orientation_weight: cards.orientation_weight,
        seeds: cards.plane_seeds,
        solver: PlaneSolver::Jacobi,
    };
    cluster_planes(sites, &options)
}

/// The crown of a plant with other leaves, none of which collapse.
pub(super) fn with_foliage(plant: &Plant, foliage: Foliage) -> Crown {
    let (skeleton, trunk) = (plant.skeleton().cloned(), plant.trunk().cloned());
    let plant = Plant::new(plant.name(), skeleton, trunk, foliage)
        .expect("leaves are those of a plant, where they are finite");
    let leaves = index_u32(plant.foliage().quad_count());
    Crown::new(Arc::new(plant), untouched(leaves))
}

fn distinct_plants(trees: &[Tree]) -> u64 {
    let mut known: Vec<(&PlantSource, u64)> = Vec::new();
    for tree in trees {
        let plant = (&tree.source, tree.seed);
        if !known.contains(&plant) {
            known.push(plant);
        }
    }
    known.len() as u64
}

/// How much a world holds.
#[derive(Debug, Clone, Copy, Default)]
struct Size {
    leaves: u64,
    triangles: u64,
    standing: u64,
}

impl Size {
    /// With a plant that no tree before was.
    fn with_plant(mut self, tree: usize, plant: &Plant) -> Result<Self, RunError> {
        self.leaves += plant.foliage().leaf_count() as u64;
        let triangles = plant.trunk().map_or(0, |trunk| trunk.triangle_count());
        self.triangles += u64::from(triangles) + plant.foliage().face_count() as u64;
        within("leaves of plants", tree, self.leaves, limits::WORLD_LEAVES)?;
        let limit = limits::WORLD_TRIANGLES;
        within(
            "triangles of trunks and leaves of plants",
            tree,
            self.triangles,
            limit,
        )?;
        Ok(self)
    }

    /// With a tree that stands.
    fn with_tree(mut self, tree: usize, plant: &Plant) -> Result<Self, RunError> {
        // Every two faces of leaves of several faces count as a leaf, which has two.
        let foliage = plant.foliage();
        self.standing += (foliage.leaf_count() + foliage.face_count() / 2) as u64;
        let limit = limits::STANDING_LEAVES;
        within("leaves of trees", tree, self.standing, limit)?;
        Ok(self)
    }
}

fn within(what: &'static str, tree: usize, found: u64, limit: u64) -> Result<(), RunError> {
    if found <= limit {
        return Ok(());
    }
    Err(RunError::TooMany {
        what,
        tree,
        found,
        limit,
    })
}

/// The crown of a plant, collapsed until `stop_leaves` are left.
///
/// Without a number, 1.35 % of the leaves are left, as on average in
/// [RRCGR](crate::references), Tables II to V.
#[must_use]
pub fn crown(plant: Plant, stop_leaves: Option<u32>) -> Crown {
    let wanted = Wanted {
        simplifier: Simplifier::LeafCollapse,
        stop_leaves,
    };
    crown_from(Arc::new(plant), wanted, None)
}

/// What is wanted of the simplification of a plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Wanted {
    pub(super) simplifier: Simplifier,
    /// Without a number as [`crown`] says.
    pub(super) stop_leaves: Option<u32>,
}

/// The crown of a plant as it is wanted, with leaf collapses that a cache keeps. Pruning is done anew each
/// time: it takes hardly longer than to read it.
pub(super) fn crown_from(plant: Arc<Plant>, wanted: Wanted, cache: Option<&ModelCache>) -> Crown {
    let foliage = plant.foliage();
    let leaves = foliage.quad_count();
    let usual = (135 * leaves).div_ceil(10_000);
    let stop_leaves = wanted.stop_leaves.unwrap_or(index_u32(usual));
    let sequence = match wanted.simplifier {
        _ if index_u32(leaves) <= stop_leaves => untouched(index_u32(leaves)),
        Simplifier::Pruning => prune_leaves(foliage, &PruningOptions::to(stop_leaves)),
        Simplifier::LeafCollapse => {
            let options = LeafCollapseOptions::to(stop_leaves);
            match cache {
                Some(cache) => cache.collapse_leaves(foliage, &options),
                None => collapse_leaves(foliage, &options),
            }
        }
    };
    Crown::new(plant, sequence)
}

/// No collapse at all: with nothing to look for, no leaf's neighbours need be known.
fn untouched(leaves: u32) -> CollapseSequence {
    let corners = (0..leaves).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
    CollapseSequence::new(leaves, corners.collect(), Vec::new())
        .expect("a record a leaf is all that a sequence without collapses needs")
}

/// The forests of a scene that stand in patches.
fn groves(scene: &Scene, trees: &[StandingTree]) -> Vec<StandingGrove> {
    let mut first = scene.trees.len();
    let mut groves = Vec::new();
    for forest in &scene.forests {
        let of_forest = first..first + forest.tree_count();
        first = of_forest.end;
        let Some(patches) = forest.patches() else {
            continue;
        };
        let height = |[x, z]: [f32; 2]| {
            let ground = scene.terrain.as_ref();
            ground.map_or(0.0, |ground| ground.height(x, z))
        };
        let places = patches.places.iter().map(|&([x, z], turn)| Placement {
            position: Vec3::new(x, height([x, z]), z),
            rotation: turned(turn),
            scale: 1.0,
        });
        let samples = patches.samples.iter().zip(&trees[of_forest.clone()]);
        let samples = samples.map(|(sample, tree)| StandingTree {
            crown: tree.crown,
            placement: Placement {
                position: Vec3::new(sample.offset[0], 0.0, sample.offset[1]),
                rotation: turned(sample.turn),
                scale: sample.scale,
            },
        });
        groves.push(StandingGrove {
            samples: samples.collect(),
            places: places.collect(),
            trees: of_forest,
        });
    }
    groves
}

fn placement(tree: &Tree) -> Placement {
    Placement {
        position: tree.at,
        rotation: turned(tree.turn),
        scale: tree.scale,
    }
}

/// So many degrees about +Y.
fn turned(degrees: f32) -> Quat {
    let half = f64::from(degrees) * (std::f64::consts::PI / 360.0);
    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    let (sine, cosine) = (det::sin_f64(half) as f32, det::cos_f64(half) as f32);
    Quat::from_xyzw(0.0, sine, 0.0, cosine)
}
