//! The rivals: what each makes of foliage with so many leaves, or triangles for two.

use meshopt::{SimplifyOptions, VertexDataAdapter};
use spinney::math::{Stream, Vec3};
use spinney::plant::{Foliage, LeafGroup, NO_BRANCH, Prototype};

use crate::triangles::{by_group, leaves, triangles};

/// Who is held against leaf collapses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rival {
    /// meshoptimizer's edge collapses.
    Simplify,
    /// meshoptimizer's vertex clustering.
    Sloppy,
    /// Stochastic pruning with area scaling.
    Pruning,
}

/// Any error is permitted, in shares of the mesh's extent: only the count decides.
const ANY_ERROR: f32 = 1e6;

/// Options of [`Rival::Simplify`], tried in turn; the weight is that of texture coordinates.
///
/// Leaves are isolated quads, all of whose edges are borders: a collapse makes a triangle of a quad, and
/// nothing of a triangle. `Prune` removes what is isolated and small, and with `LockBorder` whole leaves
/// or nothing.
const SIMPLIFY: [(&str, SimplifyOptions, f32); 5] = [
    ("none", SimplifyOptions::None, 0.0),
    ("Prune", SimplifyOptions::Prune, 0.0),
    ("Prune, UV 0.1", SimplifyOptions::Prune, 0.1),
    ("Prune, UV 1", SimplifyOptions::Prune, 1.0),
    (
        "Prune, LockBorder",
        SimplifyOptions::Prune.union(SimplifyOptions::LockBorder),
        0.0,
    ),
];

impl Rival {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Simplify, Self::Sloppy, Self::Pruning];

    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Simplify => "simplify",
            Self::Sloppy => "simplify_sloppy",
            Self::Pruning => "pruning",
        }
    }

    /// Foliage with at most two triangles for each of so many leaves, once for each choice of
    /// options, which is named.
    pub fn simplify(self, foliage: &Foliage, count: u32) -> Vec<(&'static str, Foliage)> {
        match self {
            Self::Simplify => {
                let with = |(name, options, weight)| {
                    let groups = |group: &LeafGroup, count| {
                        leaves(group, &edge_collapsed(group, count, options, weight))
                    };
                    (name, by_group(foliage, count, groups))
                };
                SIMPLIFY.into_iter().map(with).collect()
            }
            Self::Sloppy => {
                let groups = |group: &LeafGroup, count| leaves(group, &clustered(group, count));
                vec![("", by_group(foliage, count, groups))]
            }
            Self::Pruning => {
                let groups = |group: &LeafGroup, count| vec![pruned(group, count)];
                vec![("area scaled", by_group(foliage, count, groups))]
            }
        }
    }
}

fn position_bytes(group: &LeafGroup) -> Vec<u8> {
    let numbers = group.positions.iter().flat_map(|point| point.to_array());
    numbers.flat_map(f32::to_ne_bytes).collect()
}

fn adapter(bytes: &[u8]) -> VertexDataAdapter<'_> {
    VertexDataAdapter::new(bytes, 12, 0).expect("three numbers a vertex")
}

fn edge_collapsed(
    group: &LeafGroup,
    count: u32,
    options: SimplifyOptions,
    weight: f32,
) -> Vec<u32> {
    let (indices, bytes) = (triangles(group), position_bytes(group));
    let (vertices, target) = (adapter(&bytes), 6 * count as usize);
    if weight == 0.0 {
        return meshopt::simplify(&indices, &vertices, target, ANY_ERROR, options, None);
    }
    let Prototype::Quad { texture_corners } = &group.prototype else {
        panic!("only quads are simplified");
    };
    let of_vertex = |vertex: usize| texture_corners[vertex % 4].to_array();
    let coordinates: Vec<f32> = (0..group.positions.len()).flat_map(of_vertex).collect();
    meshopt::simplify_with_attributes_and_locks(
        &indices,
        &vertices,
        &coordinates,
        &[weight; 2],
        8,
        &vec![false; group.positions.len()],
        target,
        ANY_ERROR,
        options,
        None,
    )
}

fn clustered(group: &LeafGroup, count: u32) -> Vec<u32> {
    let bytes = position_bytes(group);
    let target = 6 * count as usize;
    meshopt::simplify_sloppy(&triangles(group), &adapter(&bytes), target, ANY_ERROR, None)
}

/// Keeps `count` leaves of a random order that does not depend on it, and scales each about its middle
/// so that the area stays, as Cook, Halstead, Planck and Ryu, Stochastic Simplification of Aggregate
/// Detail, 2007, section 3.2, without their correction of contrast.
fn pruned(group: &LeafGroup, count: u32) -> LeafGroup {
    let order = Stream::new(1, 0x70_7275_6e65);
    let mut kept: Vec<usize> = (0..group.leaf_count()).collect();
    kept.sort_by_key(|&leaf| (order.u64(leaf as u64), leaf));
    kept.truncate(count as usize);
    kept.sort_unstable();
    let scale = (group.leaf_count() as f32 / kept.len().max(1) as f32).sqrt();
    let scaled = |&leaf: &usize| {
        let corners = group.leaf(leaf);
        let middle = corners.iter().copied().sum::<Vec3>() / 4.0;
        corners
            .iter()
            .map(move |corner| middle + (*corner - middle) * scale)
    };
    LeafGroup {
        positions: kept.iter().flat_map(scaled).collect(),
        // There is no skeleton that they could name.
        owners: vec![NO_BRANCH; kept.len()],
        ..group.clone()
    }
}
