//! An own tree's levels of detail, for other programs.
//!
//! ```text
//! Crown, Trunk ─┬─ collapsed leaves, collapsed wood ─▶ leaves     ┐
//!               ├─ branches at an error ─────────────▶ branches   ├─▶ Rung, …: parts and counts
//!               ├─ leaf cluster impostors ───────────▶ impostors  ┘
//!               └─ the sequence itself ──────────────▶ bytes, see collapse_file
//! ```

use std::sync::Arc;

use rayon::prelude::*;

use super::RunError;
use super::collapse_file::collapse_file;
use super::compare::{Judge, WalkAway, coarsest_unseen};
use super::export::{branch_meshes, face_meshes, leaf_meshes, trunk_mesh};
use super::progress::Progress;
use super::views::SPHERE_SHARE;
use crate::math::{Aabb, Sphere, Vec3};
use crate::models::{Crown, Trunk, impostor_meshes};
use crate::plant::gltf::{ChainLevel, ChainPart, Sides, TextureRim, export_chain, export_glb};
use crate::plant::{Material, Mesh, Plant};
use crate::scene::{CardOptions, CardSides};
use crate::simplify::{BranchLevel, BranchMesh, ErrorStep};

/// How many levels are made, and of what.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainOptions {
    /// The most levels of leaves, and of branches, at least 1.
    pub levels: u32,
    /// What impostors are like.
    pub cards: CardOptions,
    /// How levels of leaves are looked at, to find at which size nobody tells them from full detail; of
    /// no variants.
    pub looks: WalkAway,
}

/// The levels of a tree.
#[derive(Debug, Clone, PartialEq)]
pub struct LodChain {
    /// Leaves collapse to half as many from level to level, and the trunk, if there is one, with them.
    pub leaves: Vec<Rung>,
    /// The branches of a skeleton, at errors that grow evenly; empty without one.
    pub branches: Vec<Rung>,
    /// Leaf cluster impostors, with the trunk as coarse as the leaves' last level; empty without leaves.
    pub impostors: Vec<Rung>,
    /// The collapses of all leaves, as of [`collapse_file`].
    pub collapses: Vec<u8>,
}

/// A level of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// What shows.
    pub level: ChainLevel,
    /// Leaves, or impostors.
    pub leaves: u32,
    /// Triangles of everything.
    pub triangles: u64,
    /// Lines.
    pub lines: u64,
    /// How far what shows may lie from the tree, in metres, where that is known: of leaves, or of branches.
    pub error: Option<f32>,
}

impl LodChain {
    /// The chains by name, those that are empty left out.
    pub fn chains(&self) -> impl Iterator<Item = (&'static str, &[Rung])> {
        let all = [
            ("leaves", &self.leaves),
            ("branches", &self.branches),
            ("impostors", &self.impostors),
        ];
        let all = all
            .into_iter()
            .map(|(name, rungs)| (name, rungs.as_slice()));
        all.filter(|(_, rungs)| !rungs.is_empty())
    }

    /// The files that hold it, by name: `tree.glb`, the plant as it was understood; of each chain all levels in
    /// one, `leaves.glb`, and each in its own, `leaves-0.glb`; and `collapses.bin`.
    ///
    /// # Errors
    ///
    /// When one would be larger than what can be read again.
    pub fn files(&self, plant: &Plant) -> Result<Vec<(String, Vec<u8>)>, RunError> {
        let mut chains: Vec<(&str, &[Rung])> = Vec::new();
        for (chain, rungs) in self.chains() {
            chains.push((chain, rungs));
            let levels = rungs.iter().map(std::slice::from_ref);
            chains.extend(
                levels
                    .zip(rungs)
                    .map(|(level, rung)| (rung.level.name.as_str(), level)),
            );
        }
        let file = |&(name, rungs): &(&str, &[Rung])| -> Result<_, RunError> {
            let levels: Vec<&ChainLevel> = rungs.iter().map(|rung| &rung.level).collect();
            Ok((format!("{name}.glb"), export_chain(plant.name(), &levels)?))
        };
        let (tree, chains) = rayon::join(
            || export_glb(plant),
            || chains.par_iter().map(file).collect::<Result<Vec<_>, _>>(),
        );
        let mut files = vec![("tree.glb".to_owned(), tree?)];
        files.extend(chains?);
        files.push(("collapses.bin".to_owned(), self.collapses.clone()));
        Ok(files)
    }
}

/// The rows of a picture in which an error of a pixel decides between levels.
const ROWS: f32 = 1080.0;

/// The levels of a tree, by its crown and its trunk.
///
/// # Errors
///
/// When impostors do not fit the device on which they are baked, and what `judge` answers.
pub fn lod_chain<E: From<RunError> + Send>(
    crown: &Arc<Crown>,
    trunk: Option<&Trunk>,
    options: &ChainOptions,
    progress: &dyn Progress,
    judge: &Judge<'_, E>,
) -> Result<LodChain, E> {
    progress.begin("levels", 4);
    let most = options.levels.max(1);
    let leaves = || -> Result<Vec<Rung>, E> {
        let mut leaves = leaf_rungs(crown, trunk, most);
        let all = crown.sequence().original_count() + crown.faces().leaf_count();
        let collapses: Vec<u32> = leaves.iter().map(|rung| all - rung.leaves).collect();
        let unseen = coarsest_unseen(crown, &collapses, &options.looks, judge)?;
        show_unseen(&mut leaves, &unseen);
        progress.step();
        Ok(leaves)
    };
    let others = || -> Result<_, RunError> {
        let branches = trunk.map_or_else(Vec::new, |trunk| branch_rungs(trunk, most));
        progress.step();
        let impostors = impostor_rungs(crown, trunk, &options.cards)?;
        progress.step();
        Ok((branches, impostors))
    };
    let (leaves, others) = rayon::join(leaves, others);
    let (leaves, (branches, impostors)) = (leaves?, others?);
    let collapses = collapse_file(crown);
    progress.step();
    let sphere = sphere(crown.plant().bounds());
    Ok(LodChain {
        leaves,
        branches: covered(branches, sphere),
        impostors: covered(impostors, sphere),
        collapses,
    })
}

fn sphere(bounds: Aabb) -> Sphere {
    Sphere {
        center: bounds.center(),
        radius: 0.5 * bounds.size().length(),
    }
}

/// Says from which size on levels of leaves will do: a coarser one shows from the largest picture on in which
/// it was unseen, and where it never was, at half the size of the one before.
fn show_unseen(rungs: &mut [Rung], unseen: &[(u32, u32)]) {
    let mut side = f64::from(unseen.first().map_or(0, |(side, _)| *side));
    let last = rungs.len().saturating_sub(1);
    for (number, rung) in (1_u32..).zip(&mut rungs[..last]) {
        let mut fits = unseen.iter().filter(|(_, step)| *step >= number);
        side = match fits.next() {
            Some((largest, _)) => f64::from(*largest).min(side),
            None => 0.5 * side,
        };
        rung.level.coverage = share_of_height(side);
    }
}

/// The share of a picture's height that a sphere takes, which takes most of a side of so many pixels.
#[expect(clippy::cast_possible_truncation, reason = "a share, rounded once")]
fn share_of_height(side: f64) -> f32 {
    (side * f64::from(SPHERE_SHARE) / f64::from(ROWS)) as f32
}

/// Says from which size on each level will do: where the error of the next finer is less than a pixel, nobody
/// sees that one.
fn covered(mut rungs: Vec<Rung>, sphere: Sphere) -> Vec<Rung> {
    let errors: Vec<Option<f32>> = rungs.iter().map(|rung| rung.error).collect();
    let count = rungs.len();
    for (number, rung) in rungs.iter_mut().enumerate() {
        let next = errors.get(number + 1).copied().flatten();
        rung.level.coverage = match next {
            Some(error) if error > 0.0 => (2.0 * sphere.radius / (error * ROWS)).min(1.0),
            // Without a known error, half the size of the level before.
            _ if number + 1 < count => (0..=number).fold(1.0, |share: f32, _| 0.5 * share),
            _ => 0.0,
        };
    }
    rungs
}

fn leaf_rungs(crown: &Crown, trunk: Option<&Trunk>, most: u32) -> Vec<Rung> {
    let sequence = crown.sequence();
    let (all, last) = (sequence.original_count(), sequence.root_count());
    let errors = crown.errors().of_collapses();
    let mut counts: Vec<u32> = (0..most).map(|level| all >> level.min(31)).collect();
    counts.retain(|&count| count > last);
    if counts.len() < most as usize {
        counts.push(last);
    }
    let vertices = crown.vertices();
    let mut greatest = 0.0_f32;
    let mut done = 0_usize;
    let rungs = counts.into_iter().enumerate().map(|(number, count)| {
        let collapses = all - count;
        for &error in &errors[done..collapses as usize] {
            greatest = greatest.max(error);
        }
        done = collapses as usize;
        let visible = sequence.visible_after(collapses);
        let quads = leaf_meshes(crown, vertices, &visible);
        let mut meshes: Vec<(String, Mesh, TextureRim)> = quads
            .chain(face_meshes(crown))
            .map(|(name, mesh)| (name, mesh, TextureRim::Clamp))
            .collect();
        if let Some(trunk) = trunk {
            let level = trunk.level(collapses, sequence.collapse_count());
            let mesh = trunk_mesh(trunk, Some(level));
            meshes.push(("trunk".to_owned(), mesh, TextureRim::Repeat));
        }
        Rung {
            leaves: count + crown.faces().leaf_count(),
            error: Some(greatest),
            ..rung(format!("leaves-{number}"), meshes)
        }
    });
    rungs.collect()
}

fn branch_rungs(trunk: &Trunk, most: u32) -> Vec<Rung> {
    if trunk.plant().skeleton().is_none() {
        return Vec::new();
    }
    let [finest, coarsest] = trunk.branch_choice().steps();
    let mut rungs = Vec::new();
    for number in 0..most {
        let step = finest.towards(coarsest, number, most.saturating_sub(1).max(1));
        rungs.push(branch_rung(trunk, step, number));
    }
    rungs
}

fn branch_rung(trunk: &Trunk, step: ErrorStep, number: u32) -> Rung {
    let level = trunk.branch_level(step);
    let meshes = branch_meshes(trunk, &level).into_iter();
    let meshes = meshes.map(|(name, mesh)| (name.to_owned(), mesh, TextureRim::Repeat));
    let mut rung = rung(format!("branches-{number}"), meshes.collect());
    rung.error = Some(step.error());
    let lines = line_parts(trunk, &level);
    let ends = |part: &ChainPart| match part {
        ChainPart::Lines { ends, .. } => ends.len() as u64 / 2,
        ChainPart::Mesh { .. } => 0,
    };
    rung.lines = lines.iter().map(ends).sum();
    rung.level.parts.extend(lines);
    rung
}

/// The lines of branches and of needles.
fn line_parts(trunk: &Trunk, level: &BranchLevel) -> Vec<ChainPart> {
    let bark = &trunk.mesh().material;
    let needles = trunk.needle_material().unwrap_or(bark);
    let parts = [
        ("branches as lines", &level.branches, bark),
        ("needles as lines", &level.needles, needles),
    ];
    let part = |(name, mesh, material): (&str, &BranchMesh, &Material)| {
        let ends = || {
            mesh.lines
                .iter()
                .flatten()
                .map(|&end| mesh.vertices[end as usize])
        };
        let positions: Vec<Vec3> = ends().map(|vertex| vertex.position).collect();
        (!positions.is_empty()).then(|| ChainPart::Lines {
            name: name.to_owned(),
            ends: positions,
            alphas: ends().map(|vertex| vertex.alpha).collect(),
            material: material.clone(),
        })
    };
    parts.into_iter().filter_map(part).collect()
}

fn impostor_rungs(
    crown: &Crown,
    trunk: Option<&Trunk>,
    cards: &CardOptions,
) -> Result<Vec<Rung>, RunError> {
    let found = impostor_meshes(crown, cards)?;
    let rungs = found.into_iter().enumerate().map(|(number, found)| {
        let name = format!("impostors-{number}");
        let sides = match found.sides {
            CardSides::Both => Sides::Front,
            CardSides::Front => Sides::Both,
        };
        let mut rung = rung(name, Vec::new());
        rung.leaves = found.impostors;
        rung.add("impostors", found.mesh, TextureRim::Clamp, sides);
        if let Some(trunk) = trunk {
            let mesh = trunk_mesh(trunk, Some(trunk.level(1, 1)));
            rung.add("trunk", mesh, TextureRim::Repeat, Sides::Both);
        }
        rung
    });
    Ok(rungs.collect())
}

fn rung(name: String, meshes: Vec<(String, Mesh, TextureRim)>) -> Rung {
    let mut rung = Rung {
        level: ChainLevel {
            name,
            parts: Vec::new(),
            coverage: 0.0,
        },
        leaves: 0,
        triangles: 0,
        lines: 0,
        error: None,
    };
    for (name, mesh, rim) in meshes {
        rung.add(&name, mesh, rim, Sides::Both);
    }
    rung
}

impl Rung {
    fn add(&mut self, name: &str, mesh: Mesh, rim: TextureRim, sides: Sides) {
        self.triangles += u64::from(mesh.triangle_count());
        self.level.parts.push(ChainPart::Mesh {
            name: name.to_owned(),
            mesh,
            rim,
            sides,
        });
    }
}
