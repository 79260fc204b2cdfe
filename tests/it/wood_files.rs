//! Wood that is written to text comes back from every format.

use std::fmt::Write as _;

use proptest::prelude::{ProptestConfig, any, proptest};
use spinney::math::{DVec3, Draws, Stream, Vec3};
use spinney::plant::Plant;
use spinney::plant::import::{Format, ImportOptions, Reading, import_bytes};

/// How far a point may come back from where it was, in metres.
const PRECISION: f32 = 1e-4;

/// A branch as it is written: its bearer among the points of all, and its own points, in the file's axes.
#[derive(Debug)]
struct Axis {
    bearer: Option<usize>,
    first: usize,
    points: Vec<(DVec3, f64)>,
}

/// A tree some 500 km from the survey's origin. Branches are borne by any point that another follows, and
/// half as thick as that: what goes on is the thickest.
fn random_axes(seed: u64) -> Vec<Axis> {
    let mut draws = Stream::new(seed, 0).draws();
    let mut coordinate = |size: f64| size * f64::from(draws.signed());
    let base = DVec3::new(coordinate(5e5), coordinate(5e5), coordinate(300.0));
    let mut axes = vec![axis(None, 0, (base, 0.15), &mut draws)];
    for _ in 0..draws.below(8) {
        let places = axes.iter().flat_map(|axis: &Axis| {
            let inner = axis.points.len() - 1;
            (0..inner).map(|place| (axis.first + place, axis.points[place]))
        });
        let places: Vec<_> = places.collect();
        let chosen = usize::try_from(draws.below(places.len() as u64)).expect("few");
        let (bearer, (position, radius)) = places[chosen];
        let first = axes.iter().map(|axis| axis.points.len()).sum();
        axes.push(axis(
            Some(bearer),
            first,
            (position, 0.5 * radius),
            &mut draws,
        ));
    }
    axes
}

fn axis(bearer: Option<usize>, first: usize, start: (DVec3, f64), draws: &mut Draws) -> Axis {
    let mut points = vec![start];
    for _ in 0..=draws.below(4) {
        let (position, radius) = points[points.len() - 1];
        let mut way = || f64::from(draws.signed());
        let way = DVec3::new(way(), way(), 1.2 + way()).normalize_or(DVec3::Z);
        let length = 0.4 + f64::from(draws.unit());
        points.push((position + length * way, 0.9 * radius));
    }
    Axis {
        bearer,
        first,
        points,
    }
}

/// A cylinder as it is written; numbers count from 0.
struct Cylinder {
    start: DVec3,
    end: DVec3,
    radius: f64,
    parent: Option<usize>,
    next: Option<usize>,
    axis: usize,
}

/// The cylinders of all axes.
fn cylinders(axes: &[Axis]) -> Vec<Cylinder> {
    // The number of the cylinder that ends at a point, or, at a tree's base, that starts there.
    let mut number_of = Vec::new();
    let mut count = 0;
    for axis in axes {
        let bearer = axis.bearer.map_or(0, |bearer| number_of[bearer]);
        number_of.push(bearer);
        number_of.extend(count..count + axis.points.len() - 1);
        count += axis.points.len() - 1;
    }
    let mut cylinders = Vec::new();
    for (number, axis) in axes.iter().enumerate() {
        for (place, ends) in axis.points.windows(2).enumerate() {
            let own = cylinders.len();
            let parent = match place {
                0 => axis.bearer.map(|bearer| number_of[bearer]),
                _ => Some(own - 1),
            };
            let next = (place + 2 < axis.points.len()).then_some(own + 1);
            cylinders.push(Cylinder {
                start: ends[0].0,
                end: ends[1].0,
                radius: ends[0].1,
                parent,
                next,
                axis: number,
            });
        }
    }
    cylinders
}

fn tree_qsm(axes: &[Axis]) -> String {
    let mut text = String::from(
        "radius (m)\tlength (m)\tstart_point\taxis_direction\tparent\textension\tbranch\n",
    );
    let one_based = |number: Option<usize>| number.map_or(0, |number| number + 1);
    for cylinder in cylinders(axes) {
        let Cylinder {
            start,
            end,
            radius,
            parent,
            next,
            axis,
        } = cylinder;
        let length = start.distance(end);
        let way = (end - start) / length;
        writeln!(
            text,
            "{radius}\t{length}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}",
            start.x,
            start.y,
            start.z,
            way.x,
            way.y,
            way.z,
            one_based(parent),
            one_based(next),
            axis + 1
        )
        .expect("a text");
    }
    text
}

fn simple_forest(axes: &[Axis]) -> String {
    let mut text =
        String::from("ID, parentID, startX, startY, startZ, endX, endY, endZ, radius, branchID\n");
    for (id, cylinder) in cylinders(axes).into_iter().enumerate() {
        let Cylinder {
            start,
            end,
            radius,
            parent,
            axis,
            ..
        } = cylinder;
        let parent = parent.map_or("-1".to_owned(), |parent| (3 * parent).to_string());
        writeln!(
            text,
            "{}, {parent}, {}, {}, {}, {}, {}, {}, {radius}, {axis}",
            3 * id,
            start.x,
            start.y,
            start.z,
            end.x,
            end.y,
            end.z
        )
        .expect("a text");
    }
    text
}

fn treefile(axes: &[Axis]) -> String {
    // A branch's first point is its bearer, which is written once.
    let mut node_of = Vec::new();
    let mut nodes: Vec<String> = Vec::new();
    for axis in axes {
        for (place, (position, radius)) in axis.points.iter().enumerate() {
            let parent = match (place, axis.bearer) {
                (0, Some(bearer)) => {
                    node_of.push(node_of[bearer]);
                    continue;
                }
                (0, None) => -1,
                _ => node_of[node_of.len() - 1],
            };
            node_of.push(i64::try_from(nodes.len()).expect("few"));
            let DVec3 { x, y, z } = position;
            nodes.push(format!("{x},{y},{z},{radius},{parent}"));
        }
    }
    format!("# random\nx,y,z,radius,parent_id\n{}\n", nodes.join(", "))
}

/// Whether every axis is one of the plant's branches, at its place.
fn returned(axes: &[Axis], plant: &Plant) -> Result<(), String> {
    let skeleton = plant.skeleton().ok_or("no skeleton")?;
    let (found, wanted) = (skeleton.branches.len(), axes.len());
    if found != wanted {
        return Err(format!("{found} branches, wanted {wanted}"));
    }
    let base = axes[0].points[0].0;
    let there = |point: DVec3| {
        let DVec3 { x, y, z } = point - base;
        DVec3::new(x, z, -y).as_vec3()
    };
    let all: Vec<DVec3> = axes
        .iter()
        .flat_map(|axis| axis.points.iter().map(|point| point.0))
        .collect();
    let is_near = |node: Vec3, point: DVec3| node.distance(there(point)) < PRECISION;
    for axis in axes {
        let is_it = |branch: &&spinney::plant::Branch| {
            let nodes = skeleton.nodes_of(branch);
            let bearer = branch
                .bearer
                .map(|node| skeleton.nodes[node as usize].position);
            nodes.len() == axis.points.len()
                && nodes
                    .iter()
                    .zip(&axis.points)
                    .all(|(node, point)| is_near(node.position, point.0))
                && match (bearer, axis.bearer) {
                    (Some(found), Some(wanted)) => is_near(found, all[wanted]),
                    (found, wanted) => found.is_none() && wanted.is_none(),
                }
        };
        if !skeleton.branches.iter().any(|branch| is_it(&branch)) {
            return Err(format!("no branch is {axis:?}\n{skeleton:?}"));
        }
    }
    Ok(())
}

#[test]
fn wood_returns_from_every_format() {
    let config = ProptestConfig {
        cases: 200,
        test_name: Some(concat!(module_path!(), "::wood_returns_from_every_format")),
        source_file: Some(file!()),
        ..ProptestConfig::default()
    };
    proptest!(config, |(seed in any::<u64>())| {
        let axes = random_axes(seed);
        for (format, text) in [
            (Format::TreeQsm, tree_qsm(&axes)),
            (Format::SimpleForest, simple_forest(&axes)),
            (Format::Treefile, treefile(&axes)),
        ] {
            let options = ImportOptions {
                reading: Reading { format: Some(format), ..Reading::default() },
                ..ImportOptions::default()
            };
            let imported = import_bytes("tree.txt", text.as_bytes(), None, &options);
            let imported = imported.map_err(|error| {
                proptest::test_runner::TestCaseError::fail(format!("{error}\n{text}"))
            })?;
            if let Err(message) = returned(&axes, &imported.plant) {
                return Err(proptest::test_runner::TestCaseError::fail(format!(
                    "{}: {message}\n{text}\n{}",
                    format.title(),
                    imported.report
                )));
            }
        }
    });
}
