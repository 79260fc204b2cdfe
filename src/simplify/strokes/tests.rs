//! The paper's tree, with the paper's numbers ([CQHCVL06](crate::references), section 6).

use std::path::Path;

use super::*;
use crate::math::{Vec3, det};
use crate::plant::{Plant, SpeciesFile};

fn ternary() -> Plant {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species/ternary.rls");
    let species = SpeciesFile::read(&path).expect("a shipped species");
    species.grow(1).expect("a shipped species grows")
}

/// Leaf strokes of the four pictures of figure 4.
const LEAVES: [u32; 4] = [8748, 4156, 2463, 761];

/// Read as the totals of rows, the numbers are met to the stroke. More than two leaves must become one
/// at once: pairs alone leave at least half.
#[test]
fn rows_have_the_papers_leaf_strokes() {
    let plant = ternary();
    let leaves = leaf_strokes(plant.foliage());
    let centers: Vec<Vec3> = leaves.iter().map(|leaf| leaf.stroke.center).collect();
    let shells = shells(&centers, ShellOptions::PUBLISHED);
    assert_eq!((shells.points.len(), shells.asked), (35, 35));
    let wanted = [(LEAVES[1], 45.0), (LEAVES[2], 60.0), (LEAVES[3], 90.0)];
    let inward = 1.0;
    let thresholds = thresholds_for(&leaves, &shells, &wanted, 4, inward);
    let grow = |pair: &[CollapseThresholds]| {
        pair[0].distance < pair[1].distance && pair[0].angle < pair[1].angle
    };
    assert!(thresholds.windows(2).all(grow), "{thresholds:?}");
    let options = LevelOptions {
        thresholds,
        most_at_once: 4,
        inward,
    };
    let levels = StrokeLevels::new(&leaves, &shells, &options);
    assert_eq!(levels.totals(), LEAVES);
    for (row, wanted) in (0_u32..).zip(LEAVES) {
        assert_eq!(extract(&levels, wanted).strokes, wanted, "row {row}");
    }
    assert!(5 * levels.implicit_bytes() < 4 * levels.copied_bytes() + levels.copied_bytes() / 10);
    let pairs = thresholds_for(&leaves, &shells, &wanted[..1], 2, inward);
    let options = LevelOptions {
        thresholds: pairs,
        most_at_once: 2,
        inward,
    };
    let halves = StrokeLevels::new(&leaves, &shells, &options).totals()[1];
    assert!(halves >= LEAVES[0] / 2, "{halves}");
}

/// Read as combinations of rows with plain thresholds, the numbers are met within half of a shell, and
/// not more nearly: the switch moves by whole shells, of some hundred strokes each.
#[test]
fn combinations_of_rows_come_near_the_papers_leaf_strokes() {
    let plant = ternary();
    let leaves = leaf_strokes(plant.foliage());
    let centers: Vec<Vec3> = leaves.iter().map(|leaf| leaf.stroke.center).collect();
    let shells = shells(&centers, ShellOptions::PUBLISHED);
    let thresholds = [(1.0, 30.0), (3.0, 60.0), (9.0, 90.0)];
    let thresholds = thresholds.map(|(distance, angle)| CollapseThresholds { distance, angle });
    let options = LevelOptions {
        thresholds: thresholds.to_vec(),
        most_at_once: 8,
        inward: 0.0,
    };
    let levels = StrokeLevels::new(&leaves, &shells, &options);
    let found = LEAVES.map(|wanted| extract(&levels, wanted).strokes);
    let misses: Vec<u32> = LEAVES
        .iter()
        .zip(found)
        .map(|(a, b)| a.abs_diff(b))
        .collect();
    assert!(
        misses.iter().all(|miss| *miss < 250),
        "{found:?} of rows {:?}",
        levels.totals()
    );
    assert_ne!(found, LEAVES);
}

/// Up to here, in metres, branches have all their strokes.
const FULL_DISTANCE: f32 = 12.0;

/// Branches that are seen shorter are pruned.
const LEAST_PIXELS: f32 = 1.5;

/// The paper's branch strokes, and from how far this tree, 9.2 m tall, has as many within a hundredth:
/// 33,664, 3,747, 1,155 and 366.
const VIEWS: [(f32, u32); 4] = [(11.65, 33_663), (110.0, 3754), (166.9, 1159), (232.6, 363)];

/// Figure 3, from the front, seen through a lens of 45 degrees on 600 rows of pixels.
#[test]
fn branches_come_near_the_papers_numbers_from_stated_distances() {
    let plant = ternary();
    let skeleton = plant.skeleton().expect("it has branches");
    let strokes = BranchStrokes::new(skeleton, BranchStrokeOptions::PUBLISHED);
    assert_eq!(strokes.strokes().len(), 34_439);
    let bounds = plant.bounds();
    let target = 0.5 * (bounds.min + bounds.max);
    let count = |distance: f32| {
        let view = BranchView {
            eye: target + distance * Vec3::Z,
            target,
            pixels: 300.0 / det::tan(22.5_f32.to_radians()),
            full_distance: FULL_DISTANCE,
            least_pixels: LEAST_PIXELS,
        };
        strokes.count(skeleton, &view)
    };
    for (distance, wanted) in VIEWS {
        let found = count(distance);
        let off = f64::from(found.abs_diff(wanted)) / f64::from(wanted);
        assert!(
            off < 0.01,
            "{found} at {distance} m, the paper's are {wanted}"
        );
    }
}
