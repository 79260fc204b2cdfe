use super::super::{Clusters, leaf_area, literal_visible, measure_leaves};
use super::*;
use crate::math::{Draws, Stream, Vec3, index_u32};
use crate::plant::{LeafGroup, Material, NO_BRANCH, Prototype};

fn foliage(groups: &[Vec<Vec3>]) -> Foliage {
    let group = |positions: &Vec<Vec3>| LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material::plain("leaf", [0.1, 0.4, 0.1]),
        owners: vec![NO_BRANCH; positions.len() / 4],
        positions: positions.clone(),
    };
    Foliage {
        groups: groups.iter().map(group).collect(),
    }
}

/// Leaning rectangles of random place and size in a long box.
fn scattered(count: usize, seed: u64) -> Vec<Vec3> {
    let mut draws = Stream::new(seed, 0).draws();
    let vector = |draws: &mut Draws| {
        let (x, y, z) = (draws.signed(), draws.signed(), draws.signed());
        Vec3::new(x, y, z)
    };
    (0..count)
        .flat_map(|_| {
            let base = Vec3::new(9.0, 2.0, 1.0) * vector(&mut draws);
            let across = 0.1 * vector(&mut draws);
            let along = 0.2 * across.cross(vector(&mut draws)).normalize_or(Vec3::Y);
            [base, base + across, base + across + along, base + along]
        })
        .collect()
}

/// ```text
///            3────2
///  3─2  3─2  │    │
///  │A│  │B│  │ A' │
///  0─1  0─1  │    │
///            0────1
/// ```
#[test]
fn a_leaf_that_stays_takes_over_the_area_about_its_middle() {
    let square = |x: f32, side: f32| {
        [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)].map(|(u, v)| Vec3::new(x + u, v, 5.0))
    };
    let leaves = foliage(&[[square(0.0, 2.0), square(7.0, 2.0 * 3.0_f32.sqrt())].concat()]);
    let sequence = hand_on_areas(&leaves, &[[0, 1]], None).expect("both are there");
    assert_eq!(sequence.corners()[2], [8, 9, 10, 11]);
    assert!((sequence.collapses()[0].cost - 4.0).abs() < 1e-6);
    // Four times the area: twice as long.
    let wanted = square(-1.0, 4.0).map(|corner| corner - Vec3::Y);
    for (found, wanted) in sequence.added_vertices().iter().zip(wanted) {
        assert!((*found - wanted).length() < 1e-6, "{found}");
    }
    assert_eq!(sequence.original_of_vertex(9), 0);
    // Capped, and the other way round.
    let sequence = hand_on_areas(&leaves, &[[1, 0]], Some(1.21)).expect("both are there");
    assert!((sequence.collapses()[0].cost - 1.21).abs() < 1e-6);
    let width = sequence.added_vertices()[1].x - sequence.added_vertices()[0].x;
    assert!((width - 1.1 * 2.0 * 3.0_f32.sqrt()).abs() < 1e-5);
    assert_eq!(sequence.original_of_vertex(9), 1);
    for cap in [0.0, f32::NAN, -1.0] {
        assert!(hand_on_areas(&leaves, &[[1, 0]], Some(cap)).is_ok());
    }
    assert!(hand_on_areas(&leaves, &[[0, 0]], None).is_err());
    assert!(hand_on_areas(&leaves, &[[0, 2]], None).is_err());
}

#[test]
fn area_stays_and_vertices_come_by_group() {
    let leaves = foliage(&[
        scattered(61, 1),
        Vec::new(),
        scattered(90, 2),
        scattered(1, 3),
    ]);
    for seed in 0..4 {
        let options = PruningOptions {
            seed,
            ..PruningOptions::to(12)
        };
        let sequence = prune_leaves(&leaves, &options);
        assert_eq!(sequence.root_count(), 12);
        let added = sequence.added_vertices();
        let vertices = [&leaves.quad_vertices()[..], added].concat();
        let of = |level| {
            let visible = sequence.visible_after(level);
            measure_leaves(&vertices, &sequence, visible).area
        };
        let full = of(0);
        for level in 1..=sequence.collapse_count() {
            assert!((of(level) / full - 1.0).abs() < 1e-6, "level {level}");
        }
        let first_added = 4 * sequence.original_count();
        let vertices = first_added..first_added + index_u32(added.len());
        let originals = vertices.map(|vertex| sequence.original_of_vertex(vertex));
        let groups: Vec<usize> = originals
            .map(|original| usize::from(original >= 61) + usize::from(original >= 151))
            .collect();
        assert!(groups.is_sorted());
        let crossing = |old: &[u32; 2]| (old[0] < 61) != (old[1] < 61);
        let first = sequence.collapses().iter().map(|collapse| collapse.old);
        let mut of_originals = first.filter(|old| old.iter().all(|&leaf| leaf < 152));
        assert!(!of_originals.any(|old| crossing(&old)));
        if seed > 0 {
            assert_ne!(sequence, prune_leaves(&leaves, &PruningOptions::to(12)));
        }
    }
}

#[test]
fn clusters_are_as_many_as_asked_and_nearly_equal() {
    let leaves = foliage(&[scattered(40, 1), scattered(7, 2)]);
    for (stop, wanted) in [
        (0, 2),
        (1, 2),
        (2, 2),
        (9, 9),
        (46, 46),
        (47, 47),
        (u32::MAX, 47),
    ] {
        let sequence = prune_leaves(&leaves, &PruningOptions::to(stop));
        assert_eq!(sequence.root_count(), wanted, "stop {stop}");
        let clusters = Clusters::of(&sequence).clusters;
        let sizes = clusters.iter().map(super::super::Cluster::original_count);
        let (least, most) = (sizes.clone().min().unwrap(), sizes.max().unwrap());
        let spread = if stop < 3 { 33 } else { most / 2 + 1 };
        assert!(most - least <= spread, "stop {stop}: {least} to {most}");
    }
    assert_eq!(
        prune_leaves(&Foliage::default(), &PruningOptions::to(1)).record_count(),
        0
    );
}

#[test]
fn leaves_go_first_in_first_out_and_stand_for_nearly_as_many() {
    for count in 1..80 {
        let leaves = foliage(&[scattered(count, 7)]);
        let sequence = prune_leaves(&leaves, &PruningOptions::to(1));
        let clusters = Clusters::of(&sequence);
        let [cluster] = &clusters.clusters[..] else {
            panic!("one cluster");
        };
        let births = cluster.records.iter().map(|record| record.birth);
        assert!(births.is_sorted(), "{count} leaves");
        let mut stands_for = vec![1; count];
        for collapse in sequence.collapses() {
            let [one, other] = collapse.old.map(|old| stands_for[old as usize]);
            stands_for.push(one + other);
        }
        for level in 0..=sequence.collapse_count() {
            // The papers' static list is right.
            let truth: Vec<u32> = cluster.visible(level).collect();
            assert_eq!(literal_visible(cluster, level), truth);
            let each = truth.iter().map(|&leaf| stands_for[leaf as usize]);
            let (least, most) = (each.clone().min().unwrap(), each.max().unwrap());
            let power_of_two = count.is_power_of_two();
            assert!(
                most <= if power_of_two { 2 } else { 4 } * least,
                "{count} leaves"
            );
        }
    }
}

#[test]
fn all_clusters_shrink_at_the_same_rate() {
    let leaves = foliage(&[scattered(512, 5)]);
    let sequence = prune_leaves(&leaves, &PruningOptions::to(8));
    let clusters = Clusters::of(&sequence);
    for level in 0..=sequence.collapse_count() {
        let counts = clusters.uniform(level);
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(most - least <= 2, "level {level}: {counts:?}");
    }
}

#[test]
fn leaves_without_area_and_huge_ones_do() {
    let mut positions = scattered(12, 6);
    for position in &mut positions[..16] {
        *position = Vec3::ONE;
    }
    for position in &mut positions[16..24] {
        *position *= f32::MAX / 16.0;
    }
    let leaves = foliage(&[positions]);
    let sequence = prune_leaves(&leaves, &PruningOptions::to(1));
    assert_eq!(sequence.root_count(), 1);
    let costs = sequence.collapses().iter().map(|collapse| collapse.cost);
    assert!(costs.clone().all(|cost| cost.is_finite() && cost >= 1.0));
    let points = foliage(&[vec![Vec3::ONE; 16]]);
    let sequence = prune_leaves(&points, &PruningOptions::to(1));
    assert!(sequence.added_vertices().iter().all(|at| *at == Vec3::ONE));
    let area = leaf_area(sequence.added_vertices(), [0, 1, 2, 3]);
    assert_eq!(area.to_bits(), 0.0_f64.to_bits());
}
