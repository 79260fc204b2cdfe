//! Levels whose counts and numbers are known in closed form.

use super::*;
use crate::math::{Vec3, det, index_u32};
use crate::plant::{Branch, Node, Skeleton};

/// A branch of places and radii.
pub(super) fn branch(points: &[(Vec3, f32)]) -> Skeleton {
    let nodes = points
        .iter()
        .map(|&(position, radius)| Node { position, radius });
    Skeleton {
        nodes: nodes.collect(),
        branches: vec![Branch {
            bearer: None,
            level: 0,
            first_node: 0,
            node_count: index_u32(points.len()),
        }],
    }
}

fn sequence(skeleton: &Skeleton, polygons: PolygonOptions) -> BranchSequence {
    let options = BranchOptions {
        polygons,
        ..BranchOptions::SOUND
    };
    BranchSequence::of_parts(skeleton, &[], &options)
}

const PLAIN: PolygonOptions = PolygonOptions {
    most_edges: 32,
    line_alpha: LineAlpha::Paper,
    line_normals: LineNormals::One,
    caps: Caps::Tip,
};

/// Errors of polygons and nothing else.
fn polygons_only(error: f32) -> BranchErrors {
    BranchErrors {
        polygon: error,
        ..Shares::Equal.errors(0.0, false)
    }
}

fn counts(level: &BranchLevel) -> [u64; 3] {
    let counts = level.counts();
    [counts.quads, counts.triangles, counts.lines]
}

/// Figure 7 of the paper: a helix whose prisms have 12, 6, 4, 3 and 3 edges, the last with fewer
/// internodes.
#[test]
fn a_helix_has_prisms_of_12_6_4_3_and_3_edges() {
    let helix: Vec<(Vec3, f32)> = (0_u8..=48)
        .map(|step| {
            let angle = std::f32::consts::TAU * f32::from(step) / 16.0;
            let (sine, cosine) = det::sin_cos(angle);
            (Vec3::new(cosine, 0.3 * angle, sine), 0.25)
        })
        .collect();
    let sequence = sequence(&branch(&helix), PLAIN);
    for (share, edges) in [(0.035, 12), (0.134, 6), (0.293, 4), (0.5, 3)] {
        let level = sequence.level(&polygons_only(0.25 * share));
        assert_eq!(counts(&level), [48 * edges, edges, 0], "{edges} edges");
        assert_eq!(level.bound.clamped, 0);
    }
    let level = sequence.at(0.25 * 0.6, Shares::Equal);
    let [quads, triangles, lines] = counts(&level);
    assert!(quads < 3 * 48 && quads.is_multiple_of(3) && triangles == 3 && lines == 0);
    assert_eq!(quads, 3 * level.nodes.internode_count() as u64);
}

/// ```text
///   ══════╤═════╤──────╤── · · · a rod that thins: a prism, a prismoid, an apex, a line
/// ```
#[test]
fn ends_are_joined_as_their_edges_say() {
    let rod = branch(&[
        (Vec3::ZERO, 1.0),
        (Vec3::X, 1.0),
        (Vec3::X * 2.0, 0.5),
        (Vec3::X * 3.0, 0.05),
        (Vec3::X * 4.0, 0.0),
    ]);
    // 0.14: 6 edges, 6, then 5 (0.28), a point, a point.
    let level = sequence(&rod, PLAIN).level(&polygons_only(0.14));
    assert_eq!(counts(&level), [6 + 5, 1 + 5, 1]);
    // Sagitta, radius of the point where the apex is, and a prismoid's own.
    assert!(level.bound.between > 0.0 && level.bound.to_plant < 0.14 + level.bound.between);
    let [line] = level.branches.lines[..] else {
        panic!("one line");
    };
    let alphas = line.map(|end| level.branches.vertices[end as usize].alpha);
    assert!((alphas[0] - 0.1 / 0.14).abs() < 1e-6 && alphas[1] == 0.0);
    // Finer: the tip is an apex. Coarser: all is one line.
    let level = sequence(&rod, PLAIN).level(&polygons_only(0.04));
    assert_eq!(
        (level.counts().lines, level.nodes.internode_count()),
        (0, 4)
    );
    let level = sequence(&rod, PLAIN).at(2.0, Shares::Equal);
    assert_eq!(counts(&level), [0, 0, 1]);
    // Both ends closed, and a thick end.
    let stump = branch(&[(Vec3::ZERO, 1.0), (Vec3::X, 1.0)]);
    let both = PolygonOptions {
        caps: Caps::Both,
        ..PLAIN
    };
    assert_eq!(
        counts(&sequence(&stump, both).level(&polygons_only(0.3))),
        [4, 8, 0]
    );
    let tip = sequence(&stump, PLAIN).level(&polygons_only(0.3));
    assert_eq!(counts(&tip), [4, 4, 0]);
    assert_eq!(tip.bound.between, 0.0);
    // The most edges are not enough.
    let clamped = sequence(&stump, PLAIN).level(&polygons_only(0.001));
    assert_eq!((counts(&clamped), clamped.bound.clamped), ([32, 32, 0], 2));
    assert!(clamped.bound.to_plant > 0.001);
}

#[test]
fn lines_cover_as_much_as_their_wood() {
    let rod = branch(&[(Vec3::ZERO, 0.125), (Vec3::X, 0.125)]);
    let alpha = |line_alpha, line_normals| {
        let options = PolygonOptions {
            line_alpha,
            line_normals,
            ..PLAIN
        };
        let level = sequence(&rod, options).at(1.0, Shares::Equal);
        (level.branches.lines.len(), level.branches.vertices[0].alpha)
    };
    assert_eq!(alpha(LineAlpha::Paper, LineNormals::One), (1, 0.25));
    // Of a pixel of 2 m, half of which is the error.
    let coverage = LineAlpha::Coverage { pixel_error: 0.5 };
    assert_eq!(alpha(coverage, LineNormals::One), (1, 0.125));
    let (lines, each) = alpha(LineAlpha::Paper, LineNormals::Three);
    let through = 1.0 - each;
    assert_eq!(lines, 3);
    assert!(
        (1.0 - through * through * through - 0.25).abs() < 1e-6,
        "{each}"
    );
    // Wider than a pixel: opaque.
    let wide = LineAlpha::Coverage { pixel_error: 10.0 };
    assert_eq!(alpha(wide, LineNormals::One).1, 1.0);
}

#[test]
fn faces_and_normals_look_outwards() {
    let bow: Vec<(Vec3, f32)> = (0_u8..=12)
        .map(|step| {
            let (sine, cosine) = det::sin_cos(0.12 * f32::from(step));
            let radius = 0.2 - 0.015 * f32::from(step);
            (
                Vec3::new(2.0 * cosine, 2.0 * sine, 0.1 * f32::from(step)),
                radius,
            )
        })
        .collect();
    for caps in [Caps::Tip, Caps::Both] {
        let sequence = sequence(&branch(&bow), PolygonOptions { caps, ..PLAIN });
        for error in [0.001, 0.01, 0.05, 0.09] {
            let level = sequence.level(&polygons_only(error));
            let vertices = &level.branches.vertices;
            for triangle in level.branches.drawn_triangles() {
                let corners = triangle.map(|corner| vertices[corner as usize]);
                let [a, b, c] = corners.map(|corner| corner.position);
                let face = (b - a).cross(c - a).normalize_or_zero();
                // An apex's and a cap's are along the axis, a ring's across it; their mean is outwards.
                let mean = corners
                    .iter()
                    .fold(Vec3::ZERO, |sum, corner| sum + corner.normal);
                assert!(face.dot(mean) > 0.0, "{error}: {corners:?}");
            }
        }
    }
}

#[test]
fn nothing_is_made_of_nothing() {
    let empty = BranchSequence::of_parts(&Skeleton::default(), &[], &BranchOptions::PAPER);
    let level = empty.at(1.0, Shares::Honest);
    assert_eq!((counts(&level), level.nodes.internode_count()), ([0; 3], 0));
    assert_eq!(level.bound, LevelBound::default());
    assert_eq!(empty.error_from(Vec3::X, 0.5, 1000.0), 0.0);
    // A branch of one node has no wood; a branch without length does no harm.
    for points in [
        &[(Vec3::ONE, 0.5)][..],
        &[(Vec3::ONE, 0.5), (Vec3::ONE, 0.0)],
    ] {
        let sequence = sequence(&branch(points), PLAIN);
        for epsilon in [0.0, 0.1, f32::INFINITY, f32::NAN, -1.0] {
            for shares in [Shares::Equal, Shares::Honest] {
                let level = sequence.at(epsilon, shares);
                let vertices = &level.branches.vertices;
                assert!(vertices.iter().all(|vertex| vertex.normal.is_finite()));
                assert!(vertices.iter().all(|vertex| vertex.alpha.is_finite()));
            }
        }
    }
}

#[test]
fn the_nearest_point_decides_how_fine_a_tree_is() {
    let rod = branch(&[(Vec3::ZERO, 0.5), (Vec3::Y * 10.0, 0.5)]);
    let sequence = sequence(&rod, PLAIN);
    let error = sequence.error_from(Vec3::new(20.5, 5.0, 0.0), 0.5, 1000.0);
    assert!((error - 0.01).abs() < 1e-6, "{error}");
    assert_eq!(sequence.error_from(Vec3::Y, 0.5, 1000.0), 0.0);
}

#[test]
fn pruning_keeps_the_most_relevant() {
    let mut skeleton = branch(&[(Vec3::ZERO, 0.5), (Vec3::Y, 0.5)]);
    for (length, radius) in [(5.0, 0.01), (1.0, 0.2)] {
        skeleton.branches.push(Branch {
            bearer: Some(0),
            level: 1,
            first_node: index_u32(skeleton.nodes.len()),
            node_count: 2,
        });
        skeleton.nodes.extend([0.0, length].map(|x| Node {
            position: Vec3::X * x,
            radius,
        }));
    }
    let sequence = sequence(&skeleton, PLAIN);
    let relevance = BranchRelevance::of(sequence.skeleton());
    let errors = Shares::Equal.errors(0.05, false);
    // By volume the long thin branch goes first, by how far it reaches the short one does.
    assert_eq!(
        sequence.pruned(&relevance, 2, &errors).nodes.branches,
        [0, 2]
    );
    let level = sequence.at(1.3, Shares::Equal);
    assert_eq!(level.nodes.branches, [0, 1]);
}
