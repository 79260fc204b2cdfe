//! What a scene shows, built offline: plants, their collapses, and where they stand.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::RunError;
use super::progress::Progress;
use crate::math::{Quat, det, index_u32};
use crate::models::{Crown, Placement};
use crate::plant::gltf::{ImportOptions, import};
use crate::plant::{Plant, Species, grow};
use crate::scene::{PlantSource, Scene, Tree};
use crate::simplify::{CollapseSequence, LeafCollapseOptions, collapse_leaves};

/// The plants of a scene and where they stand.
#[derive(Debug, Clone)]
pub struct World {
    /// Each plant once.
    pub crowns: Vec<Arc<Crown>>,
    /// The trees in the order of the scene.
    pub trees: Vec<StandingTree>,
    /// What importers had to say, a line each.
    pub remarks: Vec<String>,
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
    /// Grows or imports every plant of a scene once and simplifies its foliage.
    ///
    /// `folder` is where the scene's paths start.
    ///
    /// # Errors
    ///
    /// When a species or plant file cannot be read or grown, or is not the one that the scene pins.
    pub fn build(scene: &Scene, folder: &Path, progress: &dyn Progress) -> Result<Self, RunError> {
        let mut known: Vec<(&PlantSource, u64, usize)> = Vec::new();
        let mut world = Self {
            crowns: Vec::new(),
            trees: Vec::new(),
            remarks: Vec::new(),
        };
        let distinct = scene.trees.iter().enumerate().filter(|(index, tree)| {
            !scene.trees[..*index]
                .iter()
                .any(|other| same_plant(other, tree))
        });
        progress.begin("plants", distinct.count() as u64);
        for tree in &scene.trees {
            let found = known
                .iter()
                .find(|(source, seed, _)| **source == tree.source && *seed == tree.seed);
            let crown = match found {
                Some(&(_, _, crown)) => crown,
                None => {
                    let crown = build_crown(scene, tree, folder, &mut world.remarks)?;
                    world.crowns.push(Arc::new(crown));
                    known.push((&tree.source, tree.seed, world.crowns.len() - 1));
                    progress.step();
                    world.crowns.len() - 1
                }
            };
            if let Some(wanted) = tree.plant_digest {
                let found = world.crowns[crown].plant().digest();
                if found != wanted {
                    return Err(RunError::Plant {
                        name: world.crowns[crown].plant().name().to_owned(),
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
        Ok(world)
    }
}

fn same_plant(one: &Tree, other: &Tree) -> bool {
    one.source == other.source && one.seed == other.seed
}

fn build_crown(
    scene: &Scene,
    tree: &Tree,
    folder: &Path,
    remarks: &mut Vec<String>,
) -> Result<Crown, RunError> {
    let (plant, stop_leaves) = match &tree.source {
        PlantSource::Species(path) => {
            let species = Species::read(&join(folder, path))?;
            let plant = grow(&species, tree.seed).map_err(|source| RunError::Grow {
                species: path.clone(),
                source,
            })?;
            (plant, species.stop_leaves)
        }
        PlantSource::File { path, foliage } => {
            let options = ImportOptions {
                foliage: foliage.clone(),
            };
            let imported = import(&join(folder, path), &options)?;
            remarks.extend(
                imported
                    .report
                    .entries
                    .iter()
                    .map(|entry| format!("{path}: {entry}")),
            );
            (imported.plant, None)
        }
    };
    Ok(crown(plant, scene.model.stop_leaves.or(stop_leaves)))
}

/// The crown of a plant, collapsed until `stop_leaves` are left.
///
/// Without a number, 1.35 % of the leaves are left, as on average in
/// [RRCGR](crate::references), Tables II to V.
#[must_use]
pub fn crown(plant: Plant, stop_leaves: Option<u32>) -> Crown {
    let leaves = plant.foliage().quad_count();
    let usual = (135 * leaves).div_ceil(10_000);
    let stop_leaves = stop_leaves.unwrap_or(index_u32(usual));
    let sequence = if index_u32(leaves) <= stop_leaves {
        untouched(index_u32(leaves))
    } else {
        collapse_leaves(plant.foliage(), &LeafCollapseOptions::to(stop_leaves))
    };
    Crown::new(Arc::new(plant), sequence)
}

/// No collapse at all: with nothing to look for, no leaf's neighbours need be known.
fn untouched(leaves: u32) -> CollapseSequence {
    let corners = (0..leaves).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
    CollapseSequence::new(leaves, corners.collect(), Vec::new())
        .expect("a record a leaf is all that a sequence without collapses needs")
}

/// A path of a scene, relative to its folder.
fn join(folder: &Path, path: &str) -> PathBuf {
    folder.join(path)
}

fn placement(tree: &Tree) -> Placement {
    let half = f64::from(tree.turn) * (std::f64::consts::PI / 360.0);
    #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
    let (sine, cosine) = (det::sin_f64(half) as f32, det::cos_f64(half) as f32);
    Placement {
        position: tree.at,
        rotation: Quat::from_xyzw(0.0, sine, 0.0, cosine),
        scale: tree.scale,
    }
}
