//! Two trunks, and the levels at which two runs show them.

use serde::Serialize;

use super::ExplainError;
use super::replay::RecordedRun;
use super::trunk::{BranchStory, branch_at};
use crate::math::index_u32;
use crate::models::{Trunk, TrunkLevel};
use crate::report::OpsReader;
use crate::run::World;

/// How the trunks that a tree shows differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TrunkDifference {
    /// The first tree that shows them.
    pub tree: u32,
    /// Vertices of A's trunk, and of B's; 0 for none.
    pub vertices: [u32; 2],
    /// Triangles of them.
    pub triangles: [u32; 2],
    /// The first triangle whose corners are not the same in number, place, normal and texture
    /// coordinate, or that only one of them has.
    pub first_triangle: Option<u32>,
    /// Where that is, in A, or in B where A does not have it.
    pub branch: Option<BranchStory>,
    /// Collapses of A's trunk, and of B's; `None` where no run simplifies them.
    pub collapses: Option<[u32; 2]>,
    /// The first collapse that moves another vertex, or to another, or that only one of them has.
    pub first_collapse: Option<u32>,
    /// What A does there; `None` where A has no more.
    pub a: Option<VertexCollapsePlace>,
    /// What B does there.
    pub b: Option<VertexCollapsePlace>,
}

/// A collapse of a trunk.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexCollapsePlace {
    /// The first vertex that goes, by its number in the mesh.
    pub vertex: u32,
    /// The vertex that it goes to.
    pub target: u32,
    /// What the simplifier paid: squared metres of distance times square metres of surface.
    pub cost: f64,
    /// How far the surface is from that of full detail then, in metres.
    pub error: f32,
}

/// A frame in which two runs show a trunk at two levels.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LevelDifference {
    /// The first such frame.
    pub frame: u32,
    /// The first such tree.
    pub tree: u32,
    /// Collapses done in A, and in B.
    pub collapses: [u32; 2],
    /// Triangles that show in A, and in B.
    pub triangles: [u32; 2],
    /// How many trees differ so in that frame.
    pub trees: u32,
}

/// How the trunks of two runs differ, each pair of plants once.
pub(super) fn trunk_differences(
    runs: [&RecordedRun; 2],
    worlds: &[World; 2],
) -> Vec<TrunkDifference> {
    let simplified = runs.iter().any(|run| run.options().trunk.has_levels());
    let mut known: Vec<[usize; 2]> = Vec::new();
    let mut found = Vec::new();
    let [a, b] = worlds;
    for (number, (ours, theirs)) in (0..).zip(a.trees.iter().zip(&b.trees)) {
        let plants = [ours.crown, theirs.crown];
        if !known.contains(&plants) {
            known.push(plants);
            found.extend(difference(number, worlds, plants, simplified));
        }
    }
    found
}

fn difference(
    tree: u32,
    worlds: &[World; 2],
    plants: [usize; 2],
    simplified: bool,
) -> Option<TrunkDifference> {
    let trunks = [0, 1].map(|side: usize| worlds[side].trunks[plants[side]].as_deref());
    let first_triangle = first_triangle(trunks);
    let with_it = first_triangle.and_then(|triangle| {
        let corners = |side: usize| triangles(trunks[side]).get(triangle as usize).copied();
        let side = (0..2).find(|&side| corners(side).is_some())?;
        branch_at(&worlds[side].crowns[plants[side]], corners(side)?)
    });
    let places = |side: usize| -> Vec<VertexCollapsePlace> {
        let trunk = trunks[side].filter(|_| simplified);
        trunk.map_or_else(Vec::new, collapse_places)
    };
    let [ours, theirs] = [places(0), places(1)];
    let shared = ours
        .iter()
        .zip(&theirs)
        .take_while(|(one, other)| (one.vertex, one.target) == (other.vertex, other.target));
    let first = shared.count();
    let parts = ours.get(first).is_some() || theirs.get(first).is_some();
    let same_mesh = trunks[0].map(Trunk::mesh) == trunks[1].map(Trunk::mesh);
    if same_mesh && !parts {
        return None;
    }
    Some(TrunkDifference {
        tree,
        vertices: trunks.map(|trunk| trunk.map_or(0, |t| index_u32(t.mesh().positions.len()))),
        triangles: trunks.map(|trunk| index_u32(triangles(trunk).len())),
        first_triangle,
        branch: with_it,
        collapses: simplified.then(|| [&ours, &theirs].map(|places| index_u32(places.len()))),
        first_collapse: parts.then(|| index_u32(first)),
        a: ours.get(first).cloned(),
        b: theirs.get(first).cloned(),
    })
}

/// The triangles of a mesh, if there is one.
fn triangles(trunk: Option<&Trunk>) -> &[[u32; 3]] {
    trunk.map_or(&[], |trunk| trunk.mesh().indices.as_chunks().0)
}

/// The first triangle that two meshes do not share.
fn first_triangle(trunks: [Option<&Trunk>; 2]) -> Option<u32> {
    let [ours, theirs] = trunks.map(triangles);
    let looks = |side: usize, corners: &[u32; 3]| {
        trunks[side].map(|trunk| {
            let mesh = trunk.mesh();
            corners.map(|vertex| {
                let vertex = vertex as usize;
                let (place, normal) = (mesh.positions[vertex], mesh.normals[vertex]);
                (place, normal, mesh.texture_coordinates[vertex])
            })
        })
    };
    let shared = ours
        .iter()
        .zip(theirs)
        .take_while(|(one, other)| one == other && looks(0, one) == looks(1, other));
    let shared = shared.count();
    (shared < ours.len().max(theirs.len())).then(|| index_u32(shared))
}

fn collapse_places(trunk: &Trunk) -> Vec<VertexCollapsePlace> {
    let collapses = trunk.collapses();
    let number = |vertex: u32| collapses.order()[vertex as usize];
    let steps = (0..).zip(collapses.steps());
    let places = steps.filter_map(|(collapse, step)| {
        let vertex = collapses.first_vertex(collapse);
        Some(VertexCollapsePlace {
            vertex: number(vertex),
            target: number(collapses.target(vertex)?),
            cost: step.cost,
            error: step.error,
        })
    });
    places.collect()
}

/// The first frame of both in which a tree's trunk shows at another level.
pub(super) fn level_difference(
    runs: [&RecordedRun; 2],
    worlds: &[World; 2],
) -> Result<Option<LevelDifference>, ExplainError> {
    let mut levels = Vec::new();
    for (run, world) in runs.into_iter().zip(worlds) {
        let mut reader = OpsReader::new(world);
        let mut frames: Vec<(u32, Vec<TrunkLevel>)> = Vec::new();
        for line in run.states() {
            let (frame, states) = reader.read(line).map_err(|source| run.wrong(source))?;
            frames.push((frame, states.iter().map(|state| state.trunk).collect()));
        }
        levels.push(frames);
    }
    let [Some(ours), Some(theirs)] = [levels.first(), levels.get(1)] else {
        return Ok(None);
    };
    for (frame, one) in ours {
        let Some((_, other)) = theirs.iter().find(|(known, _)| known == frame) else {
            continue;
        };
        let pairs = (0_u32..).zip(one.iter().zip(other));
        let mut differ = pairs.filter(|(_, (one, other))| one != other);
        if let Some((tree, (one, other))) = differ.next() {
            let pair = [*one, *other];
            let triangles = |side: usize| {
                let world = &worlds[side];
                let standing = world.trees.get(tree as usize)?;
                let trunk = world.trunks[standing.crown].as_ref()?;
                Some(runs[side].options().trunk.triangle_count(trunk, pair[side]))
            };
            return Ok(Some(LevelDifference {
                frame: *frame,
                tree,
                collapses: pair.map(TrunkLevel::collapses),
                triangles: [0, 1].map(|side| triangles(side).unwrap_or(0)),
                trees: 1 + index_u32(differ.count()),
            }));
        }
    }
    Ok(None)
}
