//! Vertex collapse: what holds for any mesh, and meshes whose answer is known.

use proptest::prelude::*;
use spinney::math::{Vec2, Vec3, index_u32};
use spinney::plant::{Material, Mesh};
use spinney::simplify::{VertexCollapseOptions, VertexCollapses, collapse_vertices, strips_of};

use crate::support::{properties, random_trunk};

/// Twice the edges of a mesh by positions, each way once, minus those of the other way; those that
/// cancel left out. Empty for a mesh without holes.
fn open_edges(mesh: &Mesh) -> Vec<([[u32; 3]; 2], i32)> {
    let place = |vertex: u32| (mesh.positions[vertex as usize] + Vec3::ZERO).to_array();
    let mut edges: Vec<([[u32; 3]; 2], i32)> = Vec::new();
    for &[a, b, c] in mesh.indices.as_chunks::<3>().0 {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let [from, to] = [from, to].map(|vertex| place(vertex).map(f32::to_bits));
            if from < to {
                edges.push(([from, to], 1));
            } else if to < from {
                edges.push(([to, from], -1));
            }
        }
    }
    edges.sort_unstable();
    let same = edges.chunk_by(|a, b| a.0 == b.0);
    let sums = same.map(|same| (same[0].0, same.iter().map(|edge| edge.1).sum()));
    sums.filter(|&(_, sum): &(_, i32)| sum != 0).collect()
}

/// The places of a mesh's triangles, turned to begin with the least, in order.
fn places(mesh: &Mesh) -> Vec<[[u32; 3]; 3]> {
    let triangles = mesh.indices.as_chunks::<3>().0.iter();
    let mut places: Vec<_> = triangles
        .map(|corners| {
            let at = corners.map(|vertex| {
                let place = mesh.positions[vertex as usize] + Vec3::ZERO;
                place.to_array().map(f32::to_bits)
            });
            let least = (0..3).min_by_key(|&turn| at[turn]).expect("of three");
            [0, 1, 2].map(|turn| at[(least + turn) % 3])
        })
        .filter(|[a, b, c]| a != b && b != c && c != a)
        .collect();
    places.sort_unstable();
    places
}

properties! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// A replay that knows nothing but which vertex goes where.
    #[test]
    fn levels_are_the_mesh_with_vertices_moved(seed in any::<u64>()) {
        let trunk = random_trunk(seed);
        let (mesh, collapses) = (trunk.mesh(), trunk.collapses());
        let mut moved: Vec<u32> = (0..collapses.vertex_count()).collect();
        let renamed: Vec<u32> = {
            let mut names = vec![0; moved.len()];
            for (new, &old) in (0..).zip(collapses.order()) {
                names[old as usize] = new;
            }
            names
        };
        let counts = collapses.triangle_counts();
        let mut gone = 0;
        for level in 0..=collapses.collapse_count() {
            for vertex in gone..collapses.first_vertex(level) {
                let target = collapses.target(vertex).expect("it goes");
                prop_assert!(target > vertex);
                for place in &mut moved {
                    *place = if *place == vertex { target } else { *place };
                }
            }
            gone = collapses.first_vertex(level);
            let shown = collapses.mesh_after(mesh, level);
            let replayed = Mesh {
                indices: mesh.indices.iter().map(|&v| moved[renamed[v as usize] as usize]).collect(),
                ..shown.clone()
            };
            prop_assert_eq!(places(&shown), places(&replayed));
            prop_assert_eq!(shown.triangle_count(), counts[level as usize]);
            prop_assert!(shown.indices.iter().all(|&vertex| vertex >= gone));
        }
        let steps = collapses.steps();
        prop_assert!(steps.iter().all(|step| step.cost >= 0.0 && step.error >= 0.0));
        prop_assert!(steps.windows(2).all(|pair| pair[0].error <= pair[1].error));
    }

    /// All vertices at a position go together, so what is closed stays closed.
    #[test]
    fn closed_meshes_stay_closed(rings in 1_u32..4, edges in 3_u32..7, jitter in any::<u64>()) {
        let mesh = closed(rings, edges, jitter);
        prop_assert!(open_edges(&mesh).is_empty());
        let collapses = collapse_vertices(&mesh, ALL);
        for level in 0..=collapses.collapse_count() {
            let shown = collapses.mesh_after(&mesh, level);
            prop_assert!(open_edges(&shown).is_empty(), "level {}", level);
        }
        let counts = collapses.triangle_counts();
        prop_assert_eq!(counts.last(), Some(&0));
    }

    #[test]
    fn strips_hold_every_triangle_once(seed in any::<u64>()) {
        let trunk = random_trunk(seed);
        let collapses = trunk.collapses();
        let strips = strips_of(collapses.triangles(), |triangle| collapses.shows(triangle, 0));
        let mut held: Vec<u32> = strips.iter().flat_map(|(_, held)| held.to_vec()).collect();
        held.sort_unstable();
        let wanted: Vec<u32> = collapses.triangles_after(0).map(|(triangle, _)| triangle).collect();
        prop_assert_eq!(held, wanted);
    }
}

const ALL: VertexCollapseOptions = VertexCollapseOptions { stop_triangles: 0 };

/// Two poles and rings between them, each vertex moved a little.
fn closed(rings: u32, edges: u32, jitter: u64) -> Mesh {
    let mut draws = spinney::math::Stream::new(jitter, 5).draws();
    let mut at = |x: f32, y: f32, z: f32| {
        let moved = Vec3::new(draws.signed(), draws.signed(), draws.signed());
        Vec3::new(x, y, z) + 0.1 * moved
    };
    let mut positions = vec![at(0.0, -1.0, 0.0), at(0.0, 1.0, 0.0)];
    for ring in 0..rings {
        let height = (ring + 1) as f32 * 2.0 / (rings + 1) as f32 - 1.0;
        for edge in 0..edges {
            let angle = std::f32::consts::TAU * edge as f32 / edges as f32;
            let (sine, cosine) = spinney::math::det::sin_cos(angle);
            positions.push(at(cosine, height, sine));
        }
    }
    let vertex = |ring: u32, edge: u32| 2 + ring * edges + edge % edges;
    let mut indices = Vec::new();
    for edge in 0..edges {
        indices.extend([0, vertex(0, edge), vertex(0, edge + 1)]);
        for ring in 1..rings {
            let [a, b] = [vertex(ring - 1, edge), vertex(ring - 1, edge + 1)];
            let [c, d] = [vertex(ring, edge + 1), vertex(ring, edge)];
            indices.extend([a, d, c, a, c, b]);
        }
        indices.extend([1, vertex(rings - 1, edge + 1), vertex(rings - 1, edge)]);
    }
    mesh_of(positions, indices)
}

fn mesh_of(positions: Vec<Vec3>, indices: Vec<u32>) -> Mesh {
    Mesh {
        normals: vec![Vec3::Z; positions.len()],
        texture_coordinates: positions.iter().map(|at| Vec2::new(at.x, at.y)).collect(),
        positions,
        indices,
        material: Material::plain("bark", [0.5; 3]),
    }
}

/// A square of `side` × `side` cells, bent by `height`.
fn sheet(side: u32, height: impl Fn(f32, f32) -> f32) -> Mesh {
    let mut positions = Vec::new();
    for y in 0..=side {
        for x in 0..=side {
            let (x, y) = (x as f32, y as f32);
            positions.push(Vec3::new(x, y, height(x, y)));
        }
    }
    let mut indices = Vec::new();
    for y in 0..side {
        for x in 0..side {
            let a = y * (side + 1) + x;
            let [b, c, d] = [a + 1, a + side + 2, a + side + 1];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    mesh_of(positions, indices)
}

/// The corners that are left of a mesh.
fn corners_left(mesh: &Mesh, collapses: &VertexCollapses, level: u32) -> Vec<[f32; 3]> {
    let shown = collapses.mesh_after(mesh, level);
    let mut vertices = shown.indices.clone();
    vertices.sort_unstable();
    vertices.dedup();
    let places = vertices
        .iter()
        .map(|&v| shown.positions[v as usize].to_array());
    let mut places: Vec<_> = places.collect();
    places.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    places
}

#[test]
fn a_plane_becomes_two_triangles_for_nothing() {
    let mesh = sheet(5, |_, _| 0.0);
    let options = VertexCollapseOptions { stop_triangles: 2 };
    let collapses = collapse_vertices(&mesh, options);
    assert_eq!(collapses.collapse_count(), 36 - 4);
    let last = collapses.steps().last().expect("some");
    assert!(last.cost < 1e-18 && last.error < 1e-6, "{last:?}");
    let corners = corners_left(&mesh, &collapses, collapses.collapse_count());
    let wanted = [
        [0.0, 0.0, 0.0],
        [0.0, 5.0, 0.0],
        [5.0, 0.0, 0.0],
        [5.0, 5.0, 0.0],
    ];
    assert_eq!(corners, wanted);
}

#[test]
fn a_fold_keeps_its_edge() {
    // A roof: the ridge stands over x = 2, so its two ends and the corners stay.
    let mesh = sheet(4, |x, _| 2.0 - (x - 2.0).abs());
    let options = VertexCollapseOptions { stop_triangles: 4 };
    let collapses = collapse_vertices(&mesh, options);
    assert_eq!(*collapses.triangle_counts().last().expect("some"), 4);
    let corners = corners_left(&mesh, &collapses, collapses.collapse_count());
    for end in [
        [2.0, 0.0, 2.0],
        [2.0, 4.0, 2.0],
        [0.0, 0.0, 0.0],
        [4.0, 4.0, 0.0],
    ] {
        assert!(corners.contains(&end), "{corners:?}");
    }
    assert!(collapses.steps().last().expect("some").error < 1e-6);
}

#[test]
fn a_bump_costs_its_height() {
    // Seven places of a sheet are flat, the one in the middle stands up by a half.
    let mesh = sheet(2, |x, y| if (x, y) == (1.0, 1.0) { 0.5 } else { 0.0 });
    let options = VertexCollapseOptions { stop_triangles: 2 };
    let collapses = collapse_vertices(&mesh, options);
    let error = collapses.steps().last().expect("some").error;
    assert!((error - 0.5).abs() < 1e-6, "{error}");
}

#[test]
fn small_parts_go_before_large_ones_and_last() {
    // Two cones, one ten times the other: the last that is left is the large one, as a blade.
    let cone = |size: f32, at: f32| {
        let ring = [[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.8]];
        let base = ring.map(|[x, z]| Vec3::new(at + 0.1 * size * x, 0.0, 0.1 * size * z));
        [base[0], base[1], base[2], Vec3::new(at, size, 0.0)]
    };
    let positions = [cone(1.0, 0.0), cone(0.1, 5.0)].concat();
    let one = [[0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let indices = [one, one.map(|corners| corners.map(|vertex| vertex + 4))];
    let mesh = mesh_of(positions, indices.as_flattened().as_flattened().to_vec());
    let collapses = collapse_vertices(&mesh, ALL);
    assert_eq!(collapses.triangle_counts(), [6, 5, 3, 2, 0]);
    let blade = corners_left(&mesh, &collapses, 3);
    assert!(blade.iter().all(|place| place[0] < 1.0), "{blade:?}");
    let errors: Vec<f32> = collapses.steps().iter().map(|step| step.error).collect();
    assert!((0.1..0.2).contains(&errors[1]), "{errors:?}");
    assert!(
        (0.1..0.3).contains(&errors[2]) && errors[3] >= 1.0,
        "{errors:?}"
    );
}

#[test]
fn a_seam_is_kept_together_and_each_side_goes_to_its_own() {
    // A sheet whose middle column has two vertices a place: one for each half.
    let mut mesh = sheet(4, |_, _| 0.0);
    let first = index_u32(mesh.positions.len());
    for row in 0..5 {
        let middle = 5 * row + 2;
        mesh.positions.push(mesh.positions[middle]);
        mesh.normals.push(Vec3::Z);
        mesh.texture_coordinates.push(Vec2::new(9.0, row as f32));
    }
    let right = |corners: &[u32; 3]| corners.iter().any(|&vertex| vertex % 5 > 2);
    for corners in mesh.indices.as_chunks_mut::<3>().0 {
        if right(corners) {
            for vertex in corners.iter_mut().filter(|vertex| **vertex % 5 == 2) {
                *vertex = first + *vertex / 5;
            }
        }
    }
    let options = VertexCollapseOptions { stop_triangles: 4 };
    let collapses = collapse_vertices(&mesh, options);
    let shown = collapses.mesh_after(&mesh, collapses.collapse_count());
    assert_eq!(shown.triangle_count(), 4);
    let corners = corners_left(&mesh, &collapses, collapses.collapse_count());
    let seam = corners.iter().filter(|place| place[0] == 2.0).count();
    assert_eq!(
        (corners.len(), seam),
        (8, 4),
        "two places of two vertices: {corners:?}"
    );
    // No triangle has corners of both sides.
    let side = |vertex: u32| {
        let texture = shown.texture_coordinates[vertex as usize];
        let place = shown.positions[vertex as usize];
        place.x > 2.0 || texture.x > 8.0
    };
    for corners in shown.indices.as_chunks::<3>().0 {
        assert!(
            corners
                .iter()
                .all(|&vertex| side(vertex) == side(corners[0]))
        );
    }
}
