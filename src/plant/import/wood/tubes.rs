//! Tubes along a skeleton that has no mesh.

use super::Skeleton;
use crate::limits::TRUNK_TRIANGLES;
use crate::plant::import::{ImportReport, ReportKind};
use crate::plant::texture::linear_of_srgb;
use crate::plant::tube::{branch_polygons, polygons, tubes_of};
use crate::plant::{Branch, Material, Mesh};

/// The colour of bark of which nothing is known, sRGB.
const BARK: [u8; 3] = [0x6b, 0x5d, 0x4d];

/// Edges of the thickest branch's tube, where triangles are few.
const MOST_EDGES: u32 = 16;

/// The fewest edges of a tube.
const LEAST_EDGES: u32 = 3;

/// Triangles up to which tubes are as round as they get: a tree of 40,000 cylinders.
const ROUND_TRIANGLES: usize = 400_000;

/// The mesh of a skeleton's branches; `None` where none has a length.
///
/// A branch has edges in proportion to the root of its radius, 3 to 16. Where that makes more than
/// [`ROUND_TRIANGLES`], all get fewer; where three each still make more than [`TRUNK_TRIANGLES`], the thinnest
/// branches get no tube.
pub(in crate::plant) fn trunk(skeleton: &Skeleton, report: &mut ImportReport) -> Option<Mesh> {
    let radius = |branch: &Branch| skeleton.nodes[branch.first_node as usize].radius;
    let radii: Vec<f32> = skeleton.branches.iter().map(radius).collect();
    let greatest = radii.iter().copied().fold(1e-9, f32::max);
    let edges_at = |most: u32| -> Vec<u32> {
        let edges = |radius: &f32| {
            let wanted = most as f32 * (radius / greatest).sqrt();
            (LEAST_EDGES..=most)
                .rev()
                .find(|&edges| edges as f32 <= wanted)
                .unwrap_or(LEAST_EDGES)
        };
        radii.iter().map(edges).collect()
    };
    let mut most = MOST_EDGES;
    let mut edges = edges_at(most);
    while most > LEAST_EDGES && polygons(skeleton, &edges) > ROUND_TRIANGLES {
        most -= 1;
        edges = edges_at(most);
    }
    leave_thinnest(skeleton, &radii, &mut edges, report);
    let bark = Material::plain("bark", BARK.map(linear_of_srgb));
    let mesh = tubes_of(skeleton, &edges, None, bark);
    if mesh.indices.is_empty() {
        return None;
    }
    report.trunk_triangles += u64::from(mesh.triangle_count());
    let count = edges.iter().filter(|&&edges| edges > 0).count() as u64;
    let message = format!(
        "a mesh of the wood, which the file does not hold: tubes of {LEAST_EDGES} to {most} edges along \
         branches"
    );
    report.add(ReportKind::Guessed, count, "line 1", message);
    Some(mesh)
}

/// Takes the tubes of the thinnest branches away until the limit is met.
fn leave_thinnest(
    skeleton: &Skeleton,
    radii: &[f32],
    edges: &mut [u32],
    report: &mut ImportReport,
) {
    let mut found = polygons(skeleton, edges);
    if found <= TRUNK_TRIANGLES {
        return;
    }
    let mut order: Vec<usize> = (0..radii.len()).collect();
    order.sort_by(|&a, &b| radii[a].total_cmp(&radii[b]));
    let mut left = 0;
    for branch in order {
        if found <= TRUNK_TRIANGLES {
            break;
        }
        let nodes = skeleton.nodes_of(&skeleton.branches[branch]);
        found -= branch_polygons(nodes, edges[branch]);
        edges[branch] = 0;
        left += 1;
    }
    let message = format!(
        "the tubes of the thinnest branches: all would have more triangles than the limit of \
         {TRUNK_TRIANGLES}"
    );
    report.add(ReportKind::Dropped, left, "line 1", message);
}
