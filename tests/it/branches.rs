//! Branches at any error: how far off they may be, and what they are made of.

use std::collections::BTreeMap;
use std::f32::consts::TAU;

use proptest::prelude::*;
use spinney::math::{Draws, Stream, Vec3, index_u32};
use spinney::plant::{Branch, Node, Skeleton};
use spinney::simplify::{
    BranchLevel, BranchMesh, BranchOptions, BranchSequence, BranchSkeleton, Caps, FrameMethod,
    Internode, LineNormals, Needle, PolygonOptions, Shares, merge_deviation,
};

use crate::support::properties;

/// A trunk and up to five branches on it and on each other: bent, of uneven radii, some to a point.
pub(crate) fn skeleton(draws: &mut Draws) -> Skeleton {
    let mut all = Skeleton::default();
    for number in 0..=draws.below(6) {
        let bearer = (number > 0).then(|| {
            let nodes = all.nodes.len() as u64;
            index_u32(usize::try_from(draws.below(nodes)).expect("below a length"))
        });
        let vector = |draws: &mut Draws| Vec3::new(draws.signed(), draws.signed(), draws.signed());
        let mut position = bearer.map_or(Vec3::ZERO, |node| all.nodes[node as usize].position);
        let mut direction = vector(draws).normalize_or(Vec3::Y);
        let bend = 0.7 * draws.unit();
        let length = if number == 0 { 1.0 } else { 0.3 };
        let thickness = 0.1 * draws.unit() * length;
        let internodes = 1 + draws.below(8);
        let is_pointed = draws.below(2) == 0;
        all.branches.push(Branch {
            bearer,
            level: u32::from(number > 0),
            first_node: index_u32(all.nodes.len()),
            node_count: u32::try_from(internodes).expect("few") + 1,
        });
        for internode in 0..=internodes {
            let is_tip = internode == internodes && is_pointed;
            let radius = thickness * (0.5 + draws.unit());
            all.nodes.push(Node {
                position,
                radius: if is_tip { 0.0 } else { radius },
            });
            direction = (direction + bend * vector(draws)).normalize_or(direction);
            position += (0.2 + draws.unit()) * length * direction;
        }
    }
    all
}

/// Errors from far below a radius to the whole tree's size.
fn error(draws: &mut Draws) -> f32 {
    let mut error = 1e-4;
    for _ in 0..draws.below(14) {
        error *= 2.0;
    }
    error * (1.0 + draws.unit())
}

fn options(draws: &mut Draws) -> BranchOptions {
    let mut pick = || draws.below(2) == 0;
    let options = if pick() {
        BranchOptions::PAPER
    } else {
        BranchOptions::SOUND
    };
    BranchOptions {
        torsion_limit: if pick() { 3.0 } else { options.torsion_limit },
        polygons: PolygonOptions {
            most_edges: if pick() { 32 } else { 5 },
            caps: if pick() { Caps::Tip } else { Caps::Both },
            ..options.polygons
        },
        ..options
    }
}

fn shares(draws: &mut Draws) -> Shares {
    if draws.below(2) == 0 {
        Shares::Equal
    } else {
        Shares::Honest
    }
}

fn needles(draws: &mut Draws) -> Vec<Needle> {
    let vector = |draws: &mut Draws| Vec3::new(draws.signed(), draws.signed(), draws.signed());
    let thickness = error(draws);
    (0..12)
        .map(|_| {
            let base = vector(draws);
            Needle {
                ends: [base, base + 0.1 * vector(draws)],
                radius: thickness * (0.5 + draws.unit()),
            }
        })
        .collect()
}

properties! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn levels_are_no_farther_off_than_they_say(seed in any::<u64>()) {
        let mut draws = Stream::new(seed, 0).draws();
        let tree = skeleton(&mut draws);
        let options = BranchOptions {
            polygons: PolygonOptions { caps: Caps::Tip, ..BranchOptions::SOUND.polygons },
            ..options(&mut draws)
        };
        let sequence = BranchSequence::of_parts(&tree, &[], &options);
        let (epsilon, shares) = (error(&mut draws), shares(&mut draws));
        let level = sequence.at(epsilon, shares);
        let rounding = 1e-4;
        let shown = Shown::of(&sequence, &level);
        let full = Full::of(sequence.skeleton());
        let mut is_left = vec![false; tree.branches.len()];
        for &branch in &level.nodes.branches {
            is_left[branch as usize] = true;
        }
        for (branch, point) in full.samples() {
            // What is gone may lie inside of what is left, which is around its axis.
            let distance = if is_left[branch] {
                shown.surface_distance(point)
            } else {
                shown.surface_distance(point).min(shown.axis_distance(point))
            };
            prop_assert!(
                distance <= level.bound.to_level + rounding,
                "{point} of branch {branch}: {distance}, {:?}", level.bound
            );
        }
        for point in shown.samples() {
            let distance = full.distance(point);
            prop_assert!(
                distance <= level.bound.to_plant + rounding,
                "{point}: {distance}, {:?}", level.bound
            );
        }
        if level.bound.clamped == 0 {
            let errors = level.errors;
            let surface = errors.skeleton + errors.radius + errors.polygon + level.bound.between;
            let most = surface.max(errors.skeleton + errors.topology);
            prop_assert!(level.bound.to_plant <= surface + rounding);
            prop_assert!(level.bound.to_level <= most + rounding);
        }
    }

    #[test]
    fn fewer_primitives_come_with_greater_errors(seed in any::<u64>()) {
        let mut draws = Stream::new(seed, 1).draws();
        let (tree, options) = (skeleton(&mut draws), options(&mut draws));
        let needles = needles(&mut draws);
        let sequence = BranchSequence::of_parts(&tree, &[needles], &options);
        let shares = shares(&mut draws);
        let mut last = u64::MAX;
        let mut nodes = usize::MAX;
        let mut epsilon = 1e-4;
        while epsilon < 4.0 {
            let level = sequence.at(epsilon, shares);
            let total = level.counts().total();
            prop_assert!(total <= last, "{epsilon}: {total} after {last}");
            prop_assert!(level.nodes.branches.len() <= nodes);
            (last, nodes) = (total, level.nodes.branches.len());
            epsilon *= 1.3;
        }
        let roots = tree.branches.iter().filter(|branch| branch.bearer.is_none()).count();
        prop_assert_eq!(sequence.at(f32::INFINITY, shares).nodes.branches.len(), roots);
    }

    #[test]
    fn meshes_are_sound_and_closed(seed in any::<u64>()) {
        let mut draws = Stream::new(seed, 2).draws();
        let tree = skeleton(&mut draws);
        let mut options = options(&mut draws);
        options.polygons.caps = Caps::Both;
        let needles = needles(&mut draws);
        let sequence = BranchSequence::of_parts(&tree, &[needles], &options);
        let level = sequence.at(0.2 * error(&mut draws), shares(&mut draws));
        for mesh in [&level.branches, &level.needles] {
            let count = mesh.vertices.len();
            for vertex in &mesh.vertices {
                prop_assert!(vertex.position.is_finite() && vertex.texture.is_finite());
                prop_assert!((vertex.normal.length() - 1.0).abs() < 1e-4);
                prop_assert!((0.0..=1.0).contains(&vertex.alpha));
            }
            prop_assert!(mesh.lines.iter().flatten().all(|&end| (end as usize) < count));
            // Every edge is used once in each direction.
            let mut edges = BTreeMap::new();
            for triangle in mesh.drawn_triangles() {
                let [a, b, c] = triangle.map(|corner| mesh.vertices[corner as usize]);
                let across = (b.position - a.position).cross(c.position - a.position);
                prop_assert!(across.length() > 0.0, "no area: {triangle:?}");
                prop_assert!([a, b, c].iter().all(|corner| corner.alpha == 1.0));
                for (from, to) in [(0, 1), (1, 2), (2, 0)] {
                    let edge = (triangle[from], triangle[to]);
                    prop_assert!(edges.insert(edge, ()).is_none(), "twice: {edge:?}");
                }
            }
            for &(from, to) in edges.keys() {
                prop_assert!(edges.contains_key(&(to, from)), "open: {from} {to}");
            }
        }
        let lines = level.branches.lines.len();
        if options.polygons.line_normals == LineNormals::Three {
            prop_assert!(lines.is_multiple_of(3));
        }
    }

    #[test]
    fn merging_deviates_by_what_the_closed_form_says(seed in any::<u64>()) {
        let mut draws = Stream::new(seed, 3).draws();
        let tree = skeleton(&mut draws);
        let all = BranchSkeleton::of(&tree, FrameMethod::DoubleReflection);
        for branch in &all.branches {
            let (vectors, along) = (all.vectors_of(branch), &all.along[branch.run()]);
            let (axis, around) = merge_deviation(vectors, along);
            let [start, end] = [vectors[0], vectors[vectors.len() - 1]];
            let merged = Internode { start, end };
            let length = along[along.len() - 1];
            let (mut on_axis, mut on_surface) = (0.0_f32, 0.0_f32);
            for (ends, places) in vectors.windows(2).zip(along.windows(2)) {
                let internode = Internode { start: ends[0], end: ends[1] };
                for step in 0..=4_u8 {
                    let u = f32::from(step) / 4.0;
                    let t = (places[0] + u * (places[1] - places[0])) / length;
                    on_axis = on_axis.max(internode.axis(u).distance(merged.axis(t)));
                    for turn in 0..16_u8 {
                        let theta = TAU * f32::from(turn) / 16.0;
                        let moved = internode.point(u, theta).distance(merged.point(t, theta));
                        on_surface = on_surface.max(moved);
                    }
                }
            }
            prop_assert!((on_axis - axis).abs() < 1e-5, "{on_axis} {axis}");
            prop_assert!(on_surface <= axis + around + 1e-5);
        }
    }
}

/// The plant's own surface.
struct Full {
    internodes: Vec<(usize, Internode)>,
    /// Tips that are discs.
    discs: Vec<(usize, Internode)>,
}

impl Full {
    fn of(skeleton: &BranchSkeleton) -> Self {
        let mut full = Self {
            internodes: Vec::new(),
            discs: Vec::new(),
        };
        for (number, branch) in skeleton.branches.iter().enumerate() {
            let vectors = skeleton.vectors_of(branch);
            let internodes = vectors.windows(2).map(|ends| Internode {
                start: ends[0],
                end: ends[1],
            });
            full.internodes
                .extend(internodes.map(|internode| (number, internode)));
            full.discs.extend(full.internodes.last().copied());
        }
        full
    }

    fn samples(&self) -> impl Iterator<Item = (usize, Vec3)> {
        let sides = self.internodes.iter().flat_map(|&(branch, internode)| {
            (0..5 * 16_u8).map(move |sample| {
                let (step, turn) = (sample / 16, sample % 16);
                // Off the corners of polygons.
                let theta = TAU * (f32::from(turn) + 0.37) / 16.0;
                (branch, internode.point(f32::from(step) / 4.0, theta))
            })
        });
        let tips = self
            .discs
            .iter()
            .map(|&(branch, tip)| (branch, tip.end.position));
        sides.chain(tips)
    }

    /// From a point to the nearest of a grid over every internode, and from there downhill.
    fn distance(&self, point: Vec3) -> f32 {
        let mut best = f32::INFINITY;
        for (_, internode) in &self.internodes {
            let at = |u: f32, theta: f32| internode.point(u.clamp(0.0, 1.0), theta).distance(point);
            let (mut u, mut theta, mut least) = (0.0, 0.0, f32::INFINITY);
            for sample in 0..5 * 12_u8 {
                let try_u = f32::from(sample / 12) / 4.0;
                let try_theta = TAU * f32::from(sample % 12) / 12.0;
                if at(try_u, try_theta) < least {
                    (u, theta, least) = (try_u, try_theta, at(try_u, try_theta));
                }
            }
            // No nearer than a grid's step below the best so far: not worth the way down.
            let length = internode.start.position.distance(internode.end.position);
            let radius = internode.start.radius.max(internode.end.radius);
            if least - length / 8.0 - TAU * radius / 24.0 > best {
                continue;
            }
            let mut step = 0.5;
            while step > 0.004 {
                let (du, dt) = (step / 4.0, TAU * step / 12.0);
                let ways = [(du, 0.0), (-du, 0.0), (0.0, dt), (0.0, -dt)];
                let tried = ways.map(|(du, dt)| (at(u + du, theta + dt), u + du, theta + dt));
                let down = tried.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
                match down {
                    Some((found, new_u, new_theta)) if found < least => {
                        (u, theta, least) = (new_u.clamp(0.0, 1.0), new_theta, found);
                    }
                    _ => step *= 0.5,
                }
            }
            best = best.min(least);
        }
        for (_, tip) in &self.discs {
            let (way, normal) = (point - tip.end.position, tip.end.frame.tangent);
            let above = way.dot(normal);
            let beside = ((way - above * normal).length() - tip.end.radius).max(0.0);
            best = best.min((above * above + beside * beside).sqrt());
        }
        best
    }
}

/// What a level shows.
struct Shown {
    triangles: Vec<[Vec3; 3]>,
    lines: Vec<[Vec3; 2]>,
    axes: Vec<[Vec3; 2]>,
}

impl Shown {
    fn of(sequence: &BranchSequence, level: &BranchLevel) -> Self {
        let BranchMesh { vertices, .. } = &level.branches;
        let at = |vertex: u32| vertices[vertex as usize].position;
        let node = |node: u32| sequence.skeleton().vectors[node as usize].position;
        let runs = level.nodes.first.windows(2);
        let axes = runs.flat_map(|run| {
            let nodes = &level.nodes.nodes[run[0] as usize..run[1] as usize];
            nodes.windows(2).map(|ends| [node(ends[0]), node(ends[1])])
        });
        Self {
            axes: axes.collect(),
            lines: level
                .branches
                .lines
                .iter()
                .map(|line| line.map(at))
                .collect(),
            triangles: level
                .branches
                .drawn_triangles()
                .map(|triangle| triangle.map(at))
                .collect(),
        }
    }

    fn samples(&self) -> impl Iterator<Item = Vec3> {
        let triangles = self.triangles.iter().flat_map(|&[a, b, c]| {
            let weights = [(0.5, 0.5), (0.5, 0.0), (0.0, 0.5), (0.33, 0.34), (0.0, 0.0)];
            weights.map(|(first, second)| a + first * (b - a) + second * (c - a))
        });
        let lines = self.lines.iter();
        let lines = lines.flat_map(|&[a, b]| [0.0, 0.3, 0.7, 1.0].map(|share| a + share * (b - a)));
        triangles.chain(lines)
    }

    fn surface_distance(&self, point: Vec3) -> f32 {
        let triangles = self.triangles.iter();
        let triangles = triangles.map(|triangle| triangle_distance(point, triangle));
        let lines = self.lines.iter().map(|line| segment_distance(point, *line));
        triangles.chain(lines).fold(f32::INFINITY, f32::min)
    }

    fn axis_distance(&self, point: Vec3) -> f32 {
        let axes = self.axes.iter().map(|axis| segment_distance(point, *axis));
        axes.fold(f32::INFINITY, f32::min)
    }
}

fn segment_distance(point: Vec3, [start, end]: [Vec3; 2]) -> f32 {
    let way = end - start;
    let share = (point - start).dot(way) / way.length_squared().max(f32::MIN_POSITIVE);
    point.distance(start + share.clamp(0.0, 1.0) * way)
}

fn triangle_distance(point: Vec3, &[a, b, c]: &[Vec3; 3]) -> f32 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let edges = [[a, b], [b, c], [c, a]];
    let inside = |&[from, to]: &[Vec3; 2]| normal.cross(to - from).dot(point - from) >= 0.0;
    if normal != Vec3::ZERO && edges.iter().all(inside) {
        return (point - a).dot(normal).abs();
    }
    edges
        .map(|edge| segment_distance(point, edge))
        .into_iter()
        .fold(f32::INFINITY, f32::min)
}
