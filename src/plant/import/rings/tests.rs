//! Skeletons that come back from their tubes.

use super::*;
use crate::math::Vec3;
use crate::plant::{Branch, Material, Node, Tubes, trunk_mesh};

/// A bent trunk with a tip, a thin branch with one too, and above it a blunt one.
fn small() -> Skeleton {
    let node = |x: f32, y: f32, z: f32, radius: f32| Node {
        position: Vec3::new(x, y, z),
        radius,
    };
    let branch = |bearer: Option<u32>, level: u32, first_node: u32, node_count: u32| Branch {
        bearer,
        level,
        first_node,
        node_count,
    };
    Skeleton {
        nodes: vec![
            node(0.0, 0.0, 0.0, 0.25),
            node(0.1, 1.0, 0.0, 0.2),
            node(0.1, 2.0, 0.2, 0.125),
            node(0.0, 3.0, 0.5, 0.0),
            node(0.1, 1.0, 0.0, 0.05),
            node(-1.0, 1.25, 0.5, 0.04),
            node(-1.5, 1.75, 0.5, 0.0),
            node(0.1, 2.0, 0.2, 0.0625),
            node(1.0, 2.5, 0.25, 0.05),
        ],
        branches: vec![
            branch(None, 0, 0, 4),
            branch(Some(1), 1, 4, 3),
            branch(Some(2), 1, 7, 2),
        ],
    }
}

fn mesh(skeleton: &Skeleton, edges: [u32; 4]) -> Mesh {
    let tubes = Tubes {
        edges,
        polygons: None,
        lobes: 0,
        lobe_depth: 0.0,
    };
    trunk_mesh(skeleton, &tubes, Material::plain("bark", [0.5; 3])).expect("small")
}

fn found(mesh: &Mesh) -> Option<Skeleton> {
    let source = Source::new("tree.obj", b"", None).expect("small");
    skeleton(mesh, &source, "line 1", &mut ImportReport::default())
}

/// Whether nodes lie within a ten thousandth of the tree's size of those wanted, and are as thick.
fn assert_same(found: &Skeleton, wanted: &Skeleton) {
    assert_eq!(found.branches, wanted.branches);
    for (found, wanted) in found.nodes.iter().zip(&wanted.nodes) {
        let off = found.position.distance(wanted.position);
        assert!(off < 3e-4, "{found:?} is off {wanted:?}");
        assert!(
            (found.radius - wanted.radius).abs() < 1e-5,
            "{found:?}, {wanted:?}"
        );
    }
}

#[test]
fn our_own_tubes_give_their_skeleton_back() {
    for edges in [[3; 4], [4, 3, 3, 3], [16, 5, 3, 3]] {
        let found = found(&mesh(&small(), edges)).expect("tubes");
        assert_same(&found, &small());
    }
}

#[test]
fn caps_come_first_or_are_polygons_and_rings_may_begin_at_the_tip() {
    let rod = mesh(&small(), [4; 4]);
    // The branch: two rings, and a cap's middle after them.
    let first = 22;
    let mut branch = Mesh {
        positions: rod.positions[first..first + 9].to_vec(),
        normals: vec![Vec3::Y; 9],
        texture_coordinates: rod.texture_coordinates[first..first + 9].to_vec(),
        indices: Vec::new(),
        material: Material::plain("bark", [0.5; 3]),
    };
    let band: Vec<u32> = (0..4)
        .flat_map(|a| {
            let b = (a + 1) % 4;
            [a, b, b + 4, a, b + 4, a + 4]
        })
        .collect();
    let cap = (0..4).flat_map(|a| [4 + a, 4 + (a + 1) % 4, 8]);
    branch.indices = band.iter().copied().chain(cap).collect();
    let wanted = found(&branch).expect("a tube");
    assert_eq!(wanted.nodes.len(), 2);
    // The cap is a polygon without a middle.
    let mut polygon = branch.clone();
    polygon.indices = band.iter().copied().chain([4, 5, 6, 4, 6, 7]).collect();
    assert_same(&found(&polygon).expect("a tube"), &wanted);
    // The cap's middle comes first, then its ring, then the base.
    let mut reversed = branch.clone();
    reversed.positions.reverse();
    reversed.indices = branch.indices.iter().map(|corner| 8 - corner).collect();
    assert_same(&found(&reversed).expect("a tube"), &wanted);
    // A seam doubles a vertex of each ring.
    let mut seam = branch.clone();
    for ring in [0, 4] {
        seam.positions.push(branch.positions[ring]);
    }
    seam.indices[7] = 9;
    assert_eq!(seam.positions.len(), 11);
    assert_same(&found(&seam).expect("a tube"), &wanted);
    // A hole, or a triangle too many.
    let mut hole = branch.clone();
    hole.indices.truncate(21);
    assert_eq!(found(&hole), None);
    let mut more = branch;
    more.indices.extend([0, 1, 6]);
    assert_eq!(found(&more), None);
}

#[test]
fn wood_that_is_not_all_tubes_has_no_skeleton() {
    let mut mesh = mesh(&small(), [4; 4]);
    let count = u32::try_from(mesh.positions.len()).unwrap();
    mesh.positions.extend([Vec3::X, Vec3::Y, Vec3::Z]);
    mesh.indices.extend([count, count + 1, count + 2]);
    assert_eq!(found(&mesh), None);
    mesh.positions.clear();
    mesh.indices.clear();
    assert_eq!(found(&mesh), None);
}

#[test]
fn tubes_end_to_end_are_one_branch_and_far_ones_are_stems() {
    let rod = |from: Vec3, to: Vec3, radius: f32| {
        let ends = [from, to].map(|position| Node { position, radius });
        let branch = Branch {
            bearer: None,
            level: 0,
            first_node: 0,
            node_count: 2,
        };
        let skeleton = Skeleton {
            nodes: ends.to_vec(),
            branches: vec![branch],
        };
        mesh(&skeleton, [6; 4])
    };
    let mut all = rod(Vec3::ZERO, Vec3::Y, 0.25);
    for (from, to, radius) in [
        (Vec3::Y, 2.0 * Vec3::Y, 0.2),
        (2.0 * Vec3::Y, 3.0 * Vec3::Y, 0.15),
        (Vec3::new(9.0, 0.0, 0.0), Vec3::new(9.0, 1.0, 0.0), 0.1),
    ] {
        let next = rod(from, to, radius);
        let offset = u32::try_from(all.positions.len()).unwrap();
        all.positions.extend(next.positions);
        all.indices
            .extend(next.indices.iter().map(|corner| corner + offset));
    }
    let found = found(&all).expect("tubes");
    let branches: Vec<(Option<u32>, u32)> = found
        .branches
        .iter()
        .map(|branch| (branch.bearer, branch.node_count))
        .collect();
    assert_eq!(branches, [(None, 4), (None, 2)]);
}
