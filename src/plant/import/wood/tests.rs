//! Wood of a few segments, and the nodes that it becomes.

use super::{Grown, Segment, Wood, plant, trunk};
use crate::limits::{TRUNK_TRIANGLES, WOOD_SEGMENTS};
use crate::math::{DVec3, Vec3};
use crate::plant::import::frame::{Frame, Unit, UpAxis};
use crate::plant::import::{ImportReport, Reading, Source};
use crate::plant::{Branch, Foliage, Node, Skeleton};

/// A cylinder of constant radius.
fn cylinder(parent: Option<u32>, start: [f64; 3], end: [f64; 3], radius: f64) -> Segment {
    Segment {
        parent,
        follows: None,
        start: Some(DVec3::from_array(start)),
        end: DVec3::from_array(end),
        start_radius: Some(radius),
        end_radius: None,
        line: 1,
    }
}

/// The way from a parent to a node.
fn tip(parent: Option<u32>, end: [f64; 3], radius: f64) -> Segment {
    Segment {
        parent,
        follows: None,
        start: None,
        end: DVec3::from_array(end),
        start_radius: None,
        end_radius: Some(radius),
        line: 1,
    }
}

fn grown(segments: &[Segment]) -> (Grown, Vec<String>) {
    let source = Source::new("a.txt", b"", None).expect("no bytes");
    let mut wood = Wood::new("cylinders");
    for (segment, line) in segments.iter().zip(1..) {
        let segment = Segment { line, ..*segment };
        wood.push(segment, &source).expect("few");
    }
    let mut report = ImportReport::default();
    let frame = Frame::new(Reading::default(), UpAxis::Y, Unit::M);
    let frame = wood.stand(frame, &mut report);
    let grown = wood.grow(&frame, &mut report);
    plant(&source, grown.skeleton.clone(), None, Foliage::default()).expect("sound");
    let said = report.entries.iter().map(ToString::to_string).collect();
    (grown, said)
}

/// Bearer, level, and nodes as x, y, z, radius.
fn branches(skeleton: &Skeleton) -> Vec<(Option<u32>, u32, Vec<[f32; 4]>)> {
    let numbers = |node: &Node| {
        [
            node.position.x,
            node.position.y,
            node.position.z,
            node.radius,
        ]
    };
    let told = |branch: &Branch| {
        let nodes = skeleton.nodes_of(branch).iter().map(numbers).collect();
        (branch.bearer, branch.level, nodes)
    };
    skeleton.branches.iter().map(told).collect()
}

#[test]
fn cylinders_taper_to_the_next_and_end_blunt() {
    let (grown, said) = grown(&[
        cylinder(None, [0.0; 3], [0.0, 2.0, 0.0], 0.5),
        cylinder(Some(0), [0.0, 2.0, 0.0], [0.0, 3.0, 0.0], 0.25),
        cylinder(Some(0), [0.0, 2.0, 0.0], [1.0, 2.0, 0.0], 0.125),
    ]);
    assert_eq!(
        branches(&grown.skeleton),
        [
            (
                None,
                0,
                vec![
                    [0.0, 0.0, 0.0, 0.5],
                    [0.0, 2.0, 0.0, 0.25],
                    [0.0, 3.0, 0.0, 0.25]
                ]
            ),
            (
                Some(1),
                1,
                vec![[0.0, 2.0, 0.0, 0.125], [1.0, 2.0, 0.0, 0.125]]
            ),
        ]
    );
    assert_eq!(
        said,
        [
            "guessed: forks of which the file does not say what goes on: the thickest does, of those within a \
          tenth of its radius the straightest (at line 1)"
        ]
    );
    let places: Vec<[u32; 3]> = grown
        .places
        .iter()
        .map(|place| [place.branch, place.first, place.last])
        .collect();
    assert_eq!(places, [[0, 0, 1], [0, 1, 2], [1, 3, 4]]);
}

#[test]
fn nodes_keep_their_radii_and_the_straightest_of_equals_goes_on() {
    let (grown, said) = grown(&[
        tip(None, [5.0, 1.0, 0.0], 0.4),
        tip(Some(0), [5.0, 2.0, 0.0], 0.3),
        tip(Some(1), [6.0, 2.0, 0.0], 0.2),
        tip(Some(1), [5.0, 3.0, 0.0], 0.19),
    ]);
    assert_eq!(
        branches(&grown.skeleton),
        [
            (
                None,
                0,
                vec![
                    [0.0, 0.0, 0.0, 0.4],
                    [0.0, 1.0, 0.0, 0.3],
                    [0.0, 2.0, 0.0, 0.19]
                ]
            ),
            (Some(1), 1, vec![[0.0, 1.0, 0.0, 0.2], [1.0, 1.0, 0.0, 0.2]]),
        ]
    );
    assert_eq!(
        said[0],
        "moved: the tree is moved to the origin from 5, 1, 0 m (at line 1)"
    );
}

#[test]
fn a_branch_far_along_a_long_cylinder_gets_a_node_there() {
    // Two at the same height share it; the one near the end takes the end's.
    let on = |height: f64| cylinder(Some(0), [0.0, height, 0.0], [2.0, height, 0.0], 0.1);
    let (grown, _) = grown(&[
        cylinder(None, [0.0; 3], [0.0, 8.0, 0.0], 1.0),
        on(4.0),
        on(4.5),
        on(7.5),
        cylinder(Some(0), [0.0, 8.0, 0.0], [0.0, 9.0, 0.0], 0.5),
    ]);
    let trunk = &branches(&grown.skeleton)[0].2;
    assert_eq!(
        *trunk,
        [
            [0.0, 0.0, 0.0, 1.0],
            [0.0, 4.0, 0.0, 0.75],
            [0.0, 8.0, 0.0, 0.5],
            [0.0, 9.0, 0.0, 0.5]
        ]
    );
    let bearers: Vec<Option<u32>> = grown.skeleton.branches.iter().map(|b| b.bearer).collect();
    assert_eq!(bearers, [None, Some(1), Some(1), Some(2)]);
    assert_eq!([grown.places[0].first, grown.places[0].last], [0, 2]);
}

#[test]
fn gaps_are_bridged_or_closed_and_said() {
    let (grown, said) = grown(&[
        cylinder(None, [0.0; 3], [0.0, 1.0, 0.0], 0.25),
        // A little to the side: one node, where it starts.
        cylinder(Some(0), [0.125, 1.0, 0.0], [0.125, 2.0, 0.0], 0.25),
        // Far away: both nodes.
        cylinder(Some(1), [0.125, 4.0, 0.0], [0.125, 5.0, 0.0], 0.25),
        // A branch far beside the trunk.
        Segment {
            follows: Some(false),
            ..cylinder(Some(2), [3.0, 5.0, 0.0], [4.0, 5.0, 0.0], 0.125)
        },
    ]);
    assert_eq!(
        branches(&grown.skeleton),
        [
            (
                None,
                0,
                vec![
                    [0.0, 0.0, 0.0, 0.25],
                    [0.125, 1.0, 0.0, 0.25],
                    [0.125, 2.0, 0.0, 0.25],
                    [0.125, 4.0, 0.0, 0.25],
                    [0.125, 5.0, 0.0, 0.25]
                ]
            ),
            (
                Some(4),
                1,
                vec![
                    [0.125, 5.0, 0.0, 0.125],
                    [3.0, 5.0, 0.0, 0.125],
                    [4.0, 5.0, 0.0, 0.125]
                ]
            ),
        ]
    );
    assert_eq!(
        said,
        [
            "merged: cylinders that start up to a radius away from the end of the one before: they meet \
             where the later starts (at line 2)",
            "repaired: cylinders that start more than a radius away from the end of the one before: \
             bridged (at line 3)",
            "repaired: branches that start outside of the wood that bears them: led back to its axis (at \
             line 4)",
        ]
    );
}

#[test]
fn circles_and_several_roots_become_stems_and_zero_lengths_vanish() {
    let (grown, said) = grown(&[
        tip(Some(2), [0.0, 1.0, 0.0], 0.1),
        tip(Some(0), [0.0, 2.0, 0.0], 0.1),
        tip(Some(1), [0.0, 3.0, 0.0], 0.1),
        tip(Some(3), [7.0, 1.0, 0.0], 0.1),
        tip(Some(3), [7.0, 1.0, 0.0], 0.1),
        tip(Some(99), [9.0, 1.0, 0.0], 0.0),
    ]);
    assert_eq!(grown.skeleton.roots().count(), 3);
    assert_eq!(grown.skeleton.nodes.len(), 5);
    assert_eq!(
        said,
        [
            "moved: the tree is moved to the origin from 0, 1, 0 m (at line 1)",
            "repaired: parents that lead in a circle: one of each becomes a root (2, first at line 1)",
            "merged: stems that no other bears: one plant of several stems (3, first at line 4)",
            "merged: cylinders without length: joined with the next (at line 5)",
        ]
    );
}

#[test]
fn the_first_of_two_that_follow_goes_on() {
    let follows = |segment| Segment {
        follows: Some(true),
        ..segment
    };
    let (grown, said) = grown(&[
        tip(None, [0.0; 3], 0.1),
        follows(tip(Some(0), [1.0, 1.0, 0.0], 0.1)),
        follows(tip(Some(0), [0.0, 1.0, 0.0], 0.5)),
    ]);
    assert_eq!(branches(&grown.skeleton)[0].2[1], [1.0, 1.0, 0.0, 0.1]);
    assert_eq!(
        said,
        ["repaired: a second one that goes on along the same axis: taken as a branch (at line 3)"]
    );
}

#[test]
fn segments_are_limited() {
    let source = Source::new("a.txt", b"", None).unwrap();
    let mut wood = Wood::new("cylinders");
    let point = tip(None, [0.0; 3], 0.0);
    for _ in 0..WOOD_SEGMENTS {
        wood.push(point, &source).unwrap();
    }
    assert_eq!(
        wood.push(point, &source).unwrap_err().to_string(),
        "a.txt: 2000001 cylinders exceed the limit of 2000000; split or thin the tree"
    );
}

#[test]
fn tubes_lose_edges_and_then_branches_where_there_are_many() {
    let rods = |count: usize| Skeleton {
        nodes: (0..count)
            .flat_map(|rod| {
                let radius = if rod == 0 { 1.0 } else { 0.25 };
                [0.0, 1.0].map(|height| Node {
                    position: Vec3::new(0.0, height, 0.0),
                    radius,
                })
            })
            .collect(),
        branches: (0..u32::try_from(count).unwrap())
            .map(|rod| Branch {
                bearer: None,
                level: 0,
                first_node: 2 * rod,
                node_count: 2,
            })
            .collect(),
    };
    let said = |count: usize| {
        let mut report = ImportReport::default();
        let mesh = trunk(&rods(count), &mut report).unwrap();
        (mesh.triangle_count(), report.entries)
    };
    // A band of two triangles and a cap of one an edge: 16 edges, and 8 where the radius is a quarter.
    assert_eq!(said(2).0, 3 * (16 + 8));
    let (triangles, entries) = said(30_000);
    assert!(triangles < 400_000, "{triangles}");
    assert!(
        entries[0]
            .to_string()
            .contains("tubes of 3 to 9 edges along branches (30000,"),
        "{}",
        entries[0]
    );
    let (triangles, entries) = said(1_800_000);
    assert!(triangles as usize <= TRUNK_TRIANGLES);
    assert_eq!(
        entries[0].to_string(),
        "dropped: the tubes of the thinnest branches: all would have more triangles than the limit of \
         16000000 (22223, first at line 1)"
    );
    let mut report = ImportReport::default();
    assert_eq!(trunk(&Skeleton::default(), &mut report), None);
}
