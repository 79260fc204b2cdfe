//! Trunk and branches as one mesh: a tube along every branch of a skeleton.
//!
//! ```text
//!   node 0        node 1            tip, radius 0
//!     ○─────────────○─────────────────○
//!   ring of e     ring of e         apex
//!     └── 2 e triangles ─┘└── e triangles ─┘
//! ```
//!
//! Rings are shared by the internodes on both sides and closed without a seam: texture coordinates
//! run up and down again around a ring, so that no vertex is doubled. Frames follow the axis by
//! double reflection ([WJZL08](crate::references)): no twist, and no function beyond `√`.

use super::weber_penn::GrowError;
use super::{Material, Mesh, Node, Skeleton};
use crate::limits;
use crate::math::{Vec2, Vec3, det, index_u32, perpendicular};

/// How branches become tubes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tubes {
    /// Edges of a ring by branching level (the last for all above), 0 for no tube; used without
    /// `polygons`.
    pub edges: [u32; 4],
    /// How many triangles all tubes have together, within 5 %; thicker branches get more edges,
    /// the thinnest may get no tube at all.
    pub polygons: Option<u32>,
    /// Bulges around the trunk.
    pub lobes: u32,
    /// Their depth, as a share of the radius.
    pub lobe_depth: f32,
}

/// The fewest edges of a tube.
const LEAST_EDGES: u32 = 3;

/// The most edges of a tube when their number follows the size wanted.
const MOST_EDGES: u32 = 24;

/// How many units of texture length a branch has per metre of its axis.
const TEXTURE_PER_METRE: f32 = 1.0;

/// The mesh of all branches.
///
/// # Errors
///
/// When the wanted number of triangles cannot be met within 5 %, or is more than 2³² vertices.
pub fn trunk_mesh(
    skeleton: &Skeleton,
    tubes: &Tubes,
    material: Material,
) -> Result<Mesh, GrowError> {
    let edges = match tubes.polygons {
        Some(wanted) => edges_for(skeleton, wanted as usize)?,
        None => edges_by_level(skeleton, tubes.edges),
    };
    let found = polygons(skeleton, &edges);
    if found > limits::TRUNK_TRIANGLES {
        return Err(GrowError::TooMany {
            what: "trunk triangles",
            found,
            limit: limits::TRUNK_TRIANGLES,
        });
    }
    let lobes = (tubes.lobes as f32, tubes.lobe_depth);
    Ok(tubes_of(skeleton, &edges, Some(lobes), material))
}

/// A tube of so many edges along each branch, none for 0; `lobes` is the number and depth of bulges around
/// trunks.
pub(super) fn tubes_of(
    skeleton: &Skeleton,
    edges: &[u32],
    lobes: Option<(f32, f32)>,
    material: Material,
) -> Mesh {
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        texture_coordinates: Vec::new(),
        indices: Vec::with_capacity(3 * polygons(skeleton, edges)),
        material,
    };
    for (branch, &edges) in skeleton.branches.iter().zip(edges) {
        let nodes = skeleton.nodes_of(branch);
        if edges > 0 && nodes.len() > 1 {
            let lobes = lobes.filter(|_| branch.level == 0);
            tube(nodes, edges, lobes, &mut mesh);
        }
    }
    mesh
}

/// How many triangles a branch's tube has.
pub(super) fn branch_polygons(nodes: &[Node], edges: u32) -> usize {
    match nodes {
        // The last internode ends in an apex, or in a ring with a cap of as many triangles.
        [_, inner @ .., last] => {
            let rings = inner.len() + usize::from(last.radius > 0.0);
            (2 * rings + 1) * edges as usize
        }
        _ => 0,
    }
}

/// How many triangles tubes of so many edges along each branch have together.
pub(super) fn polygons(skeleton: &Skeleton, edges: &[u32]) -> usize {
    let sizes = skeleton.branches.iter().zip(edges);
    sizes
        .map(|(branch, &edges)| branch_polygons(skeleton.nodes_of(branch), edges))
        .sum()
}

fn edges_by_level(skeleton: &Skeleton, edges: [u32; 4]) -> Vec<u32> {
    let level = |branch: &super::Branch| (branch.level as usize).min(3);
    let branches = skeleton.branches.iter();
    branches.map(|branch| edges[level(branch)]).collect()
}

/// Edges by thickness, so that all tubes together have as nearly `wanted` triangles as possible.
///
/// A branch has `detail · √(radius / greatest radius)` edges: a ring's deviation from a circle falls
/// with the square of its edges, so twice the radius wants √2 times the edges. The sum rises with
/// `detail`; halving finds the step that passes the wanted number.
fn edges_for(skeleton: &Skeleton, wanted: usize) -> Result<Vec<u32>, GrowError> {
    let radius = |branch: &super::Branch| skeleton.nodes[branch.first_node as usize].radius;
    let greatest = skeleton.branches.iter().map(radius).fold(0.0, f32::max);
    let slimness: Vec<f32> = skeleton
        .branches
        .iter()
        .map(|branch| (radius(branch) / greatest.max(1e-9)).sqrt())
        .collect();
    let edges_at = |detail: f32| -> Vec<u32> {
        let edges = slimness
            .iter()
            .map(|slimness| whole_edges(detail * slimness));
        edges.collect()
    };
    let (mut low, mut high) = (0.0_f32, 1e6);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if polygons(skeleton, &edges_at(middle)) <= wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    let [below, above] = [low, high].map(edges_at);
    let (fewer, more) = (polygons(skeleton, &below), polygons(skeleton, &above));
    let (found, edges) = if wanted.abs_diff(fewer) <= wanted.abs_diff(more) {
        (fewer, below)
    } else {
        (more, above)
    };
    if wanted.abs_diff(found) * 20 > wanted {
        return Err(GrowError::TrunkPolygons { wanted, found });
    }
    Ok(edges)
}

/// Edges as a count: none below half the least, then at least that.
fn whole_edges(edges: f32) -> u32 {
    let mut whole = MOST_EDGES;
    while whole > LEAST_EDGES && whole as f32 > edges {
        whole -= 1;
    }
    if edges < 0.5 * LEAST_EDGES as f32 {
        0
    } else {
        whole
    }
}

/// Appends one branch's tube.
fn tube(nodes: &[Node], edges: u32, lobes: Option<(f32, f32)>, mesh: &mut Mesh) {
    let directions = directions(nodes);
    let mut side = perpendicular(directions[0]);
    let mut previous: Option<u32> = None;
    let mut along = 0.0;
    for (place, node) in nodes.iter().enumerate() {
        let direction = directions[place];
        if let Some(before) = place.checked_sub(1) {
            side = carried(
                side,
                nodes[before].position,
                directions[before],
                *node,
                direction,
            );
            along += nodes[before].position.distance(node.position);
        }
        let is_tip = place + 1 == nodes.len();
        let slope = slope(nodes, place);
        if is_tip && node.radius <= 0.0 {
            let apex = vertex(mesh, node.position, direction, Vec2::new(0.5, along));
            fan(mesh, previous, edges, apex);
            break;
        }
        let first = index_u32(mesh.positions.len());
        let other = direction.cross(side);
        for edge in 0..edges {
            let angle = std::f32::consts::TAU * edge as f32 / edges as f32;
            let (sine, cosine) = det::sin_cos(angle);
            let outwards = cosine * side + sine * other;
            let bulge = lobes.map_or(1.0, |(count, depth)| 1.0 + depth * det::sin(count * angle));
            let normal = (outwards - slope * direction).normalize_or(outwards);
            let around = (2.0 * edge as f32 / edges as f32 - 1.0).abs();
            let texture = Vec2::new(around, along * TEXTURE_PER_METRE);
            vertex(
                mesh,
                node.position + bulge * node.radius * outwards,
                normal,
                texture,
            );
        }
        if let Some(below) = previous {
            band(mesh, below, first, edges);
        }
        if is_tip {
            let cap = vertex(mesh, node.position, direction, Vec2::new(0.5, along));
            fan(mesh, Some(first), edges, cap);
        }
        previous = Some(first);
    }
}

fn vertex(mesh: &mut Mesh, position: Vec3, normal: Vec3, texture: Vec2) -> u32 {
    mesh.positions.push(position);
    mesh.normals.push(normal);
    mesh.texture_coordinates.push(texture);
    index_u32(mesh.positions.len() - 1)
}

/// Two triangles an edge between two rings, counter-clockwise seen from outside.
fn band(mesh: &mut Mesh, below: u32, above: u32, edges: u32) {
    for edge in 0..edges {
        let next = (edge + 1) % edges;
        let [a, b] = [below + edge, below + next];
        let [c, d] = [above + next, above + edge];
        mesh.indices.extend([a, b, c, a, c, d]);
    }
}

/// One triangle an edge from a ring to a point above it.
fn fan(mesh: &mut Mesh, ring: Option<u32>, edges: u32, apex: u32) {
    let Some(ring) = ring else { return };
    for edge in 0..edges {
        let next = (edge + 1) % edges;
        mesh.indices.extend([ring + edge, ring + next, apex]);
    }
}

/// The direction of the axis at every node: the mean of the internodes that meet there. Where an
/// internode has no length, the one before goes on.
fn directions(nodes: &[Node]) -> Vec<Vec3> {
    let mut along = Vec::with_capacity(nodes.len());
    let mut last = Vec3::Y;
    for ends in nodes.windows(2) {
        last = (ends[1].position - ends[0].position).normalize_or(last);
        along.push(last);
    }
    (0..nodes.len())
        .map(|node| {
            let before = along[node.saturating_sub(1)];
            let after = along[node.min(along.len() - 1)];
            (before + after).normalize_or(after)
        })
        .collect()
}

/// How fast the radius grows along the axis at a node.
fn slope(nodes: &[Node], place: usize) -> f32 {
    let (before, after) = (place.saturating_sub(1), (place + 1).min(nodes.len() - 1));
    let length = nodes[before].position.distance(nodes[place].position)
        + nodes[place].position.distance(nodes[after].position);
    if length > 1e-9 {
        (nodes[after].radius - nodes[before].radius) / length
    } else {
        0.0
    }
}

/// The side of a ring carried to the next: reflected in the plane between the nodes, then in the one
/// between the directions.
fn carried(side: Vec3, from: Vec3, direction: Vec3, to: Node, next: Vec3) -> Vec3 {
    let reflected = |vector: Vec3, normal: Vec3| {
        let square = normal.length_squared();
        if square > 1e-12 {
            vector - (2.0 / square) * normal.dot(vector) * normal
        } else {
            vector
        }
    };
    let step = (to.position - from).normalize_or_zero();
    let (side, direction) = (reflected(side, step), reflected(direction, step));
    let side = reflected(side, next - direction);
    (side - side.dot(next) * next).normalize_or(perpendicular(next))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Branch;

    /// A rod of radius 1 from the origin to (0, 2, 0), through (0, 1, 0), with a given end.
    fn rod(end_radius: f32) -> Skeleton {
        let node = |height: f32, radius: f32| Node {
            position: Vec3::new(0.0, height, 0.0),
            radius,
        };
        Skeleton {
            nodes: vec![node(0.0, 1.0), node(1.0, 1.0), node(2.0, end_radius)],
            branches: vec![Branch {
                bearer: None,
                level: 0,
                first_node: 0,
                node_count: 3,
            }],
        }
    }

    fn mesh_of(skeleton: &Skeleton, edges: u32, polygons: Option<u32>) -> Result<Mesh, GrowError> {
        let tubes = Tubes {
            edges: [edges; 4],
            polygons,
            lobes: 0,
            lobe_depth: 0.0,
        };
        trunk_mesh(skeleton, &tubes, Material::plain("bark", [0.5; 3]))
    }

    #[test]
    fn a_rod_has_bands_and_a_cap_and_a_cone_an_apex() {
        // Two bands of 8 triangles and a cap of 4; without an end ring one band and 4 to the apex.
        let capped = mesh_of(&rod(1.0), 4, None).unwrap();
        assert_eq!([capped.positions.len(), capped.indices.len()], [13, 60]);
        let cone = mesh_of(&rod(0.0), 4, None).unwrap();
        assert_eq!([cone.positions.len(), cone.indices.len()], [9, 36]);
        capped.check().unwrap();
    }

    #[test]
    fn triangles_face_outwards_and_the_rod_has_its_volume() {
        let mesh = mesh_of(&rod(1.0), 24, None).unwrap();
        // The divergence theorem; the bottom is open but lies in the plane of the origin.
        let mut volume = 0.0;
        for triangle in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|corner: usize| triangle[corner] as usize);
            let [p, q, r] = [a, b, c].map(|index| mesh.positions[index]);
            volume += p.dot(q.cross(r)) / 6.0;
            let face = (q - p).cross(r - p);
            assert!(face.dot(mesh.normals[a]) > -1e-6, "a face turned inwards");
        }
        // A prism over a 24-gon: 12 sin 15° · 2 = 6.2117.
        assert!((volume - 6.2117).abs() < 1e-3, "volume {volume}");
    }

    #[test]
    fn wanted_sizes_are_met_or_refused_with_both_numbers() {
        // Five triangles an edge: 3 to 24 edges give 15 to 120 triangles in steps of 5.
        assert_eq!(
            mesh_of(&rod(1.0), 0, Some(100)).unwrap().triangle_count(),
            100
        );
        assert_eq!(
            mesh_of(&rod(1.0), 0, Some(400)).unwrap_err(),
            GrowError::TrunkPolygons {
                wanted: 400,
                found: 120
            }
        );
        assert_eq!(mesh_of(&rod(1.0), 0, Some(0)).unwrap().triangle_count(), 0);
    }

    #[test]
    fn a_bent_tube_keeps_its_rings_round_and_untwisted() {
        // Up, then along x: every ring vertex is one radius from its node, and the frame's side
        // across the bend's plane (z) is carried unchanged.
        let mut skeleton = rod(1.0);
        skeleton.nodes[2].position = Vec3::new(1.0, 1.0, 0.0);
        let mesh = mesh_of(&skeleton, 4, None).unwrap();
        for (ring, node) in skeleton.nodes.iter().enumerate() {
            let across = mesh.positions[4 * ring + 2] - mesh.positions[4 * ring];
            assert!(
                (across.length() - 2.0).abs() < 1e-5,
                "ring {ring} is not round"
            );
            let centre = 0.5 * (mesh.positions[4 * ring + 2] + mesh.positions[4 * ring]);
            assert!(
                centre.distance(node.position) < 1e-5,
                "ring {ring} is off its node"
            );
            let first = mesh.positions[4 * ring + 1] - node.position;
            let wanted = mesh.positions[1];
            if wanted.z.abs() > 0.5 {
                assert!((first.z - wanted.z).abs() < 1e-5, "ring {ring} is twisted");
            }
        }
    }
}
