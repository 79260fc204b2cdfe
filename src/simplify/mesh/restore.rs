//! Collapses and strips that were found before, checked before anybody relies on them.

use super::collapses::{NEVER, VertexCollapse, VertexCollapses, lowest_first};
use super::strips::Strips;
use super::surface::{first_removal, weld};
use super::{VertexCollapseOptions, collapse_vertices, strips_of};
use crate::math::index_u32;
use crate::plant::Mesh;

/// A mesh with everything that models of it need.
#[derive(Debug, Clone, PartialEq)]
pub struct SimplifiedMesh {
    /// Its collapses.
    pub collapses: VertexCollapses,
    /// Strips of all triangles that are there at full detail.
    pub strips: Strips,
}

/// All that a [`SimplifiedMesh`] cannot be told without its mesh: what is kept of it elsewhere.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SimplifiedParts {
    /// As [`VertexCollapses::order`].
    pub order: Vec<u32>,
    /// The [target](VertexCollapses::target) of every vertex that goes.
    pub targets: Vec<u32>,
    /// [`VertexCollapses::first_vertex`] at every level.
    pub starts: Vec<u32>,
    /// Cost and error of every collapse.
    pub steps: Vec<(f64, f32)>,
    /// The vertices of all strips.
    pub strip_vertices: Vec<u32>,
    /// Where each strip begins, and the end of the last.
    pub strip_starts: Vec<u32>,
    /// The triangles in the order of the strips.
    pub strip_triangles: Vec<u32>,
}

/// Collapses the points of a mesh and joins its triangles to strips.
#[must_use]
pub fn simplify_mesh(mesh: &Mesh, options: VertexCollapseOptions) -> SimplifiedMesh {
    let collapses = collapse_vertices(mesh, options);
    let strips = strips_of(collapses.triangles(), |triangle| {
        collapses.shows(triangle, 0)
    });
    SimplifiedMesh { collapses, strips }
}

impl SimplifiedMesh {
    /// What tells it, with its mesh.
    #[must_use]
    pub fn parts(&self) -> SimplifiedParts {
        let collapses = &self.collapses;
        let steps = collapses.steps.iter().map(|step| (step.cost, step.error));
        SimplifiedParts {
            order: collapses.order.clone(),
            targets: collapses.target.clone(),
            starts: collapses.starts.clone(),
            steps: steps.collect(),
            strip_vertices: self.strips.vertices.clone(),
            strip_starts: self.strips.starts.clone(),
            strip_triangles: self.strips.triangles.clone(),
        }
    }

    /// What the parts tell of a mesh; `None` unless every collapse moves one point with all its
    /// vertices to another that stays longer, costs are finite and errors rise, and the strips hold
    /// each triangle that is there once, turned as it is. That the collapses are the cheapest is not
    /// looked at.
    #[must_use]
    pub fn restored(mesh: &Mesh, parts: SimplifiedParts) -> Option<Self> {
        let collapses = collapses(mesh, &parts)?;
        let strips = Strips {
            vertices: parts.strip_vertices,
            starts: parts.strip_starts,
            triangles: parts.strip_triangles,
        };
        is_whole(&strips, &collapses).then_some(Self { collapses, strips })
    }
}

fn collapses(mesh: &Mesh, parts: &SimplifiedParts) -> Option<VertexCollapses> {
    let vertices = mesh.positions.len();
    let number = inverse(&parts.order, vertices)?;
    let ends = [parts.starts.first()?, parts.starts.last()?].map(|&end| end as usize);
    let fits = ends == [0, parts.targets.len()]
        && parts.targets.len() <= vertices
        && parts.starts.len() == parts.steps.len() + 1
        && parts.starts.is_sorted();
    if !fits {
        return None;
    }
    let (point_of, positions) = weld(&mesh.positions);
    let mut sizes = vec![0_usize; positions.len()];
    for &point in &point_of {
        sizes[point as usize] += 1;
    }
    let point = |vertex: u32| point_of[parts.order[vertex as usize] as usize];
    // Where each point goes to, and by which collapse.
    let mut goes = vec![None; positions.len()];
    for (collapse, ends) in (0_u32..).zip(parts.starts.windows(2)) {
        let (first, others) = (ends[0], ends[0]..ends[1]);
        // All of its vertices, and no others, go to vertices of one point that is still there.
        let target = *parts.targets.get(first as usize)?;
        let from_to = |vertex: u32| {
            let target = parts.targets[vertex as usize];
            let later = target >= ends[1] && (target as usize) < vertices;
            later.then(|| [point(vertex), point(target)])
        };
        let pair = (target as usize) < vertices && sizes[point(first) as usize] == others.len();
        let pair = pair.then(|| [point(first), point(target)])?;
        if !others
            .into_iter()
            .all(|vertex| from_to(vertex) == Some(pair))
        {
            return None;
        }
        goes[pair[0] as usize] = Some((collapse, pair[1]));
    }
    let corners = mesh.indices.as_chunks::<3>().0;
    let removal: Vec<u32> = corners
        .iter()
        .map(|corners| removal(corners.map(|vertex| point_of[vertex as usize]), &goes))
        .collect();
    let mut steps: Vec<VertexCollapse> = parts
        .steps
        .iter()
        .map(|&(cost, error)| VertexCollapse {
            cost,
            error,
            triangles: 0,
        })
        .collect();
    for &level in removal.iter().filter(|&&level| level != NEVER && level > 0) {
        steps[level as usize - 1].triangles += 1;
    }
    let costs = steps
        .iter()
        .all(|step| step.cost.is_finite() && step.cost >= 0.0);
    let errors = steps.iter().all(|step| step.error >= 0.0)
        && steps.is_sorted_by(|one, next| one.error <= next.error);
    let triangles = corners.iter();
    let renamed = triangles.map(|corners| corners.map(|vertex| number[vertex as usize]));
    (costs && errors).then(|| VertexCollapses {
        order: parts.order.clone(),
        target: parts.targets.clone(),
        starts: parts.starts.clone(),
        triangles: renamed.map(lowest_first).collect(),
        removal,
        steps,
    })
}

/// The place of each number in `order`, if that holds all numbers below `count` once.
fn inverse(order: &[u32], count: usize) -> Option<Vec<u32>> {
    let mut places = vec![u32::MAX; count];
    for (place, &number) in (0..).zip(order) {
        let known = places.get_mut(number as usize)?;
        if *known != u32::MAX {
            return None;
        }
        *known = place;
    }
    (order.len() == count).then_some(places)
}

/// The first level at which a triangle of three points is gone.
fn removal(points: [u32; 3], goes: &[Option<(u32, u32)>]) -> u32 {
    let [a, b, c] = points;
    let pairs = [[a, b], [b, c], [c, a]];
    let joined = pairs.map(|pair| joined(pair, goes));
    joined.into_iter().fold(first_removal(points), u32::min)
}

/// The first level at which two points are one. Of two, the one that goes first moves.
fn joined(mut pair: [u32; 2], goes: &[Option<(u32, u32)>]) -> u32 {
    let mut level = 0;
    while pair[0] != pair[1] {
        let next = pair.map(|point| goes[point as usize]);
        let (side, (collapse, target)) = match next {
            [Some(one), Some(other)] if other.0 < one.0 => (1, other),
            [Some(one), _] => (0, one),
            [None, Some(other)] => (1, other),
            [None, None] => return NEVER,
        };
        pair[side] = target;
        level = collapse + 1;
    }
    level
}

/// Whether strips hold each triangle that is there at full detail once, turned as it is.
fn is_whole(strips: &Strips, collapses: &VertexCollapses) -> bool {
    let ends = || strips.starts.windows(2);
    let fits = strips.starts.first() == Some(&0)
        && strips.starts.last() == Some(&index_u32(strips.vertices.len()))
        && ends().all(|ends| ends[0] < ends[1] && ends[1] - ends[0] >= 3)
        && strips.vertices.len() == strips.triangles.len() + 2 * ends().len();
    if !fits {
        return false;
    }
    let mut missing: Vec<bool> = (0..index_u32(collapses.triangles.len()))
        .map(|triangle| collapses.shows(triangle, 0))
        .collect();
    for (vertices, triangles) in strips.iter() {
        let windows = vertices.windows(3).filter_map(<[u32]>::first_chunk);
        for (place, (&[a, b, c], &triangle)) in windows.zip(triangles).enumerate() {
            let turned = if place % 2 == 0 { [a, b, c] } else { [b, a, c] };
            let Some(missing) = missing.get_mut(triangle as usize).filter(|held| **held) else {
                return false;
            };
            *missing = false;
            if lowest_first(turned) != collapses.triangles[triangle as usize] {
                return false;
            }
        }
    }
    !missing.contains(&true)
}
