//! Leaf collapse and clusters: what holds for any foliage, and whether foliage keeps its mass.

use proptest::prelude::*;
use spinney::math::{Draws, Stream, Vec3};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Prototype};
use spinney::simplify::{
    Clusters, CollapseSequence, LeafCollapseOptions, LeafDistance, collapse_leaves, is_folded,
    measure_leaves,
};
use spinney::testkit::laws::{birth_before_death, partition};
use spinney::testkit::{History, State, strategy};

use crate::support::properties;

/// Foliage of one to three groups, some of them empty.
fn foliage() -> impl Strategy<Value = Foliage> {
    strategy::foliage(1..=3, 0..=14)
}

fn leaf_group(positions: Vec<Vec3>) -> LeafGroup {
    LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material::plain("leaf", [0.1, 0.4, 0.1]),
        owners: vec![NO_BRANCH; positions.len() / 4],
        positions,
    }
}

fn options() -> impl Strategy<Value = LeafCollapseOptions> {
    let distance = prop_oneof![Just(LeafDistance::Hausdorff), Just(LeafDistance::Centers)];
    let weights = prop::array::uniform4(prop_oneof![Just(0.0_f32), 0.0_f32..2.0, Just(100.0)]);
    (0_u32..20, distance, weights).prop_map(|(stop_leaves, distance, weights)| {
        let [
            distance_weight,
            coplanarity_weight,
            area_weight,
            form_weight,
        ] = weights;
        LeafCollapseOptions {
            distance,
            distance_weight,
            coplanarity_weight,
            area_weight,
            form_weight,
            ..LeafCollapseOptions::to(stop_leaves)
        }
    })
}

/// The group of every leaf, old and new.
fn groups_of(foliage: &Foliage, sequence: &CollapseSequence) -> Vec<usize> {
    let mut groups = Vec::new();
    for (number, group) in foliage.groups.iter().enumerate() {
        groups.extend(std::iter::repeat_n(number, group.leaf_count()));
    }
    for collapse in sequence.collapses() {
        groups.push(groups[collapse.old[0] as usize]);
    }
    groups
}

properties! {
    #[test]
    fn collapses_keep_groups_roles_and_counts(foliage in foliage(), options in options()) {
        let sequence = collapse_leaves(&foliage, &options);
        let count = foliage.quad_count();
        let groups = foliage.groups.iter().filter(|group| group.leaf_count() > 0).count();
        prop_assert_eq!(
            sequence.root_count() as usize,
            (options.stop_leaves as usize).max(groups).min(count)
        );
        let group_of = groups_of(&foliage, &sequence);
        for collapse in sequence.collapses() {
            let [first, second] = collapse.old;
            prop_assert!(first < second);
            prop_assert_eq!(group_of[first as usize], group_of[second as usize]);
            prop_assert!(collapse.cost.is_finite() && collapse.cost >= 0.0);
        }
        for corners in sequence.corners() {
            for (role, vertex) in (0..).zip(corners) {
                prop_assert_eq!(vertex % 4, role);
            }
        }
        let again = collapse_leaves(&foliage, &options);
        prop_assert_eq!(again.digest(), sequence.digest());
    }

    #[test]
    fn new_leaves_mix_both_and_never_fold(foliage in foliage(), options in options()) {
        let sequence = collapse_leaves(&foliage, &options);
        let vertices = foliage.quad_vertices();
        let records = sequence.corners();
        let new = &records[sequence.original_count() as usize..];
        for (collapse, corners) in sequence.collapses().iter().zip(new) {
            prop_assert!(!is_folded(&vertices, *corners));
            for old in collapse.old {
                prop_assert_ne!(&records[old as usize], corners);
            }
        }
        for ops in 0..=sequence.collapse_count() {
            let measure = measure_leaves(&vertices, &sequence, sequence.visible_after(ops));
            prop_assert_eq!(measure.leaves, sequence.original_count() - ops);
            prop_assert_eq!(measure.folded, 0);
        }
    }

    #[test]
    fn clusters_show_the_truth(foliage in foliage(), options in options()) {
        let sequence = collapse_leaves(&foliage, &options);
        let clusters = Clusters::of(&sequence);
        prop_assert_eq!(clusters.clusters.len(), sequence.root_count() as usize);
        for cluster in &clusters.clusters {
            let count = cluster.original_count() as usize;
            prop_assert_eq!(cluster.records.len(), 2 * count - 1);
            prop_assert!(cluster.ops.is_sorted());
            // Array order is the order of consumption.
            for (op, pair) in cluster.ops.iter().zip(cluster.records.chunks_exact(2)) {
                let old = sequence.collapses()[*op as usize].old;
                prop_assert_eq!(old, [pair[0].leaf, pair[1].leaf]);
            }
        }
        let history = History::of(&sequence);
        for collapses in 0..=sequence.collapse_count() {
            let state = State::Uniform { collapses };
            let shown = state.visible(&clusters);
            birth_before_death(&history, &state, &shown)?;
            partition(&history, &state, &shown)?;
            let counts = clusters.uniform(collapses);
            for (cluster, &count) in clusters.clusters.iter().zip(&counts) {
                let active = cluster.original_count() - count;
                prop_assert_eq!(cluster.visible(count).count(), active as usize);
            }
        }
    }
}

/// Leaves on short twigs in the shell of an ellipsoid.
fn crown(leaf_count: usize) -> Foliage {
    let mut draws = Stream::new(11, 0).draws();
    let direction = |draws: &mut Draws| {
        let (x, y, z) = (draws.normal(), draws.normal(), draws.normal());
        Vec3::new(x, y, z).normalize_or(Vec3::Y)
    };
    let mut positions = Vec::with_capacity(4 * leaf_count);
    while positions.len() < 4 * leaf_count {
        let outward = direction(&mut draws);
        let base = outward * (0.5 + 0.5 * draws.unit()) * Vec3::new(2.2, 3.5, 2.2);
        let twig = (outward + direction(&mut draws)).normalize_or(Vec3::Y);
        for leaf in 0..8_u8 {
            let foot = base + twig * (0.1 * f32::from(leaf));
            let along = (twig + direction(&mut draws)).normalize_or(twig);
            let across = along.cross(direction(&mut draws)).normalize_or(Vec3::X);
            let (along, across) = (0.36 * along, 0.13 * across);
            positions.extend([
                foot - across,
                foot + across,
                foot + across + along,
                foot - across + along,
            ]);
        }
    }
    Foliage {
        groups: vec![leaf_group(positions)],
    }
}

/// Pixels that leaves cover, each an ellipse in its quad, from the 26 directions of a cube's
/// faces, edges and corners: point samples of an orthographic view, the bounding sphere 90 % of the
/// side.
fn covered_pixels(vertices: &[Vec3], leaves: &[[u32; 4]]) -> usize {
    const SIDE: usize = 160;
    let half = 0.5 * SIDE as f32;
    let radius = vertices
        .iter()
        .fold(0.0, |most: f32, v| most.max(v.length()));
    let mut covered = 0;
    for direction in 0..27_u8 {
        let axis = |step: u8| f32::from(direction / step % 3) - 1.0;
        let view = Vec3::new(axis(1), axis(3), axis(9));
        if view == Vec3::ZERO {
            continue;
        }
        let (right, up) = view.normalize().any_orthonormal_pair();
        let scale = 0.9 * half / radius;
        let mut hit = vec![false; SIDE * SIDE];
        for leaf in leaves {
            let [a, b, c, d] = leaf.map(|vertex| {
                let vertex = scale * vertices[vertex as usize];
                [half + vertex.dot(right), half + vertex.dot(up)]
            });
            let texture = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            for (corners, coordinates) in [
                ([a, b, c], [texture[0], texture[1], texture[2]]),
                ([a, c, d], [texture[0], texture[2], texture[3]]),
            ] {
                fill(corners, coordinates, &mut hit, SIDE);
            }
        }
        covered += hit.iter().filter(|&&hit| hit).count();
    }
    covered
}

fn fill([a, b, c]: [[f32; 2]; 3], coordinates: [[f32; 2]; 3], hit: &mut [bool], side: usize) {
    let twice = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let area = twice(a, b, c);
    let range = |axis: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]);
        let high = a[axis].max(b[axis]).max(c[axis]);
        whole(low)..(whole(high) + 1).min(side)
    };
    for y in range(1) {
        for x in range(0) {
            let point = [x as f32 + 0.5, y as f32 + 0.5];
            let weights = [twice(point, b, c), twice(a, point, c), twice(a, b, point)];
            let weights = weights.map(|weight| weight / area);
            let inside = weights.iter().all(|&weight| weight >= 0.0);
            let [u, v] = [0, 1].map(|axis| {
                let parts = weights.iter().zip(&coordinates);
                parts.fold(0.0, |sum, (weight, at)| sum + weight * at[axis])
            });
            if inside && u * u + v * v <= 1.0 {
                hit[y * side + x] = true;
            }
        }
    }
}

/// The whole part, 0 for less.
fn whole(value: f32) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates"
    )]
    let whole = value as usize;
    whole
}

#[test]
fn foliage_keeps_its_mass() {
    let foliage = crown(3_000);
    let vertices = foliage.quad_vertices();
    let sequence = collapse_leaves(&foliage, &LeafCollapseOptions::to(40));
    let count = sequence.original_count();
    let at = |percent: u32| {
        let visible = sequence.visible_after(count - count * percent / 100);
        let leaves: Vec<[u32; 4]> = visible
            .iter()
            .map(|&leaf| sequence.corners()[leaf as usize])
            .collect();
        let measure = measure_leaves(&vertices, &sequence, visible);
        (measure, covered_pixels(&vertices, &leaves) as f64)
    };
    let (full, full_pixels) = at(100);
    for percent in [50, 25, 10] {
        let (measure, pixels) = at(percent);
        let area = measure.area / full.area;
        let pixels = pixels / full_pixels;
        assert_eq!(measure.folded, 0, "at {percent} %");
        assert!((0.95..=1.05).contains(&area), "area {area} at {percent} %");
        assert!(
            (0.9..=1.1).contains(&pixels),
            "pixels {pixels} at {percent} %"
        );
    }
}
