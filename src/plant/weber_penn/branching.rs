//! All stems of a plant: each level on the one before, depth first.

use super::GrowError;
use super::formulas::{
    alternate, down_angle, flare_factor, shape_ratio, stem_length, stem_radius, taper_radius,
};
use super::frame::Frame;
use super::stem::{Axis, Effort, Site, Stem, grow_stem, streams};
use crate::limits;
use crate::math::{Stream, Vec3, index_u32};
use crate::plant::{Branch, Node, Shape, Skeleton, Species};

/// Stems shorter than this, in metres, do not grow.
const SHORTEST_STEM: f32 = 1e-3;

/// The golden angle in degrees: how trunks of a clump and successive roots are spread.
const GOLDEN_ANGLE: f32 = 137.507_77;

/// The skeleton, and what leaves need to know of it.
#[derive(Debug, Default)]
pub(super) struct Wood {
    pub(super) skeleton: Skeleton,
    /// One a node: the frame of the segment that begins there.
    pub(super) frames: Vec<Frame>,
    /// One a node: the distance from the stem's base, in metres.
    pub(super) along: Vec<f32>,
    /// The axes that bear leaves, in order.
    pub(super) bearers: Vec<Bearer>,
}

/// An axis of the last level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bearer {
    pub(super) branch: u32,
    /// How many leaves it has at the species' own density; not rounded.
    pub(super) leaves: f32,
    pub(super) stream: Stream,
}

/// Grows all wood.
///
/// # Errors
///
/// When there would be too many branches or nodes.
pub(super) fn grow_wood(species: &Species, stream: Stream) -> Result<Wood, GrowError> {
    let crown = &species.crown;
    let draws = stream.child(streams::SHAPE);
    let stretch = crown.vertical_scale + draws.signed(0) * crown.vertical_scale_v;
    let mut forester = Forester {
        species,
        wood: Wood::default(),
        effort: Effort::default(),
        site: Site {
            crown,
            height: crown.scale + draws.signed(1) * crown.scale_v,
            base_splits: species.wood.base_splits,
            flare: species.wood.flare,
        },
    };
    for trunk in 0..species.clump.count {
        let stream = stream.child(streams::CHILDREN).child(u64::from(trunk));
        forester.grow_trunk(trunk, stream)?;
    }
    let mut wood = forester.wood;
    for node in &mut wood.skeleton.nodes {
        node.position.y *= stretch;
    }
    Ok(wood)
}

struct Forester<'a> {
    species: &'a Species,
    wood: Wood,
    effort: Effort,
    site: Site<'a>,
}

/// A stem that has grown: what its children need.
#[derive(Clone, Copy)]
struct Grown {
    stem: Stem,
    /// After pruning.
    length: f32,
    /// The bare part at its base, in metres.
    base: f32,
    /// The children's length as a share of this one's, before their place is considered.
    child_share: f32,
    /// How many children there are on all of its length; not rounded.
    children: f32,
}

impl Forester<'_> {
    fn grow_trunk(&mut self, trunk: u32, stream: Stream) -> Result<(), GrowError> {
        let (clump, wood, level) = (
            &self.species.clump,
            &self.species.wood,
            &self.species.stems[0],
        );
        let draws = stream.child(streams::SHAPE);
        let share = level.length + draws.signed(1) * level.length_v;
        let length = share * self.site.height;
        let scale = wood.trunk_scale + draws.signed(2) * wood.trunk_scale_v;
        // A sunflower's order fills the disc evenly; one trunk alone stands in the middle.
        let around = GOLDEN_ANGLE * trunk as f32;
        let place = match clump.count {
            1 => 0.0,
            count => ((trunk as f32 + 0.5) / count as f32).sqrt(),
        };
        let outwards = Frame::UPRIGHT.about(Vec3::Y, around);
        let stem = Stem {
            level: 0,
            position: clump.radius * place * outwards.normal(),
            frame: outwards
                .pitch(clump.lean * place + level.down_angle + draws.signed(4) * level.down_angle_v)
                .roll(360.0 * draws.unit(3)),
            length,
            radius: length * wood.ratio * scale,
            offset: 0.0,
            share: 1.0,
            stream,
        };
        self.grow(None, stem)
    }

    /// Grows a stem with all that it bears.
    fn grow(&mut self, parent_node: Option<u32>, stem: Stem) -> Result<(), GrowError> {
        let too_short = |length: f32| length.is_nan() || length < SHORTEST_STEM;
        if too_short(stem.length) {
            return Ok(());
        }
        let level = &self.species.stems[stem.level];
        let (axes, length) = grow_stem(&self.site, level, &stem, &mut self.effort)?;
        if too_short(length) {
            return Ok(());
        }
        let grown = self.grown(stem, length);
        let mut branches = Vec::with_capacity(axes.len());
        for axis in &axes {
            let bearer = match axis.split_from {
                None => parent_node,
                Some((from, node)) => {
                    let from: u32 = branches[from];
                    let first = self.wood.skeleton.branches[from as usize].first_node;
                    Some(first + index_u32(node))
                }
            };
            branches.push(self.emit(axis, bearer, &grown)?);
        }
        let last_level = stem.level + 1 == self.species.crown.levels as usize;
        for (axis, branch) in axes.iter().zip(branches) {
            if last_level {
                self.bear_leaves(axis, branch, &grown);
            } else {
                self.bear_stems(axis, branch, &grown)?;
            }
        }
        Ok(())
    }

    /// What children need to know ([WP95](crate::references), section 4.3).
    fn grown(&self, stem: Stem, length: f32) -> Grown {
        let base = match stem.level {
            0 => (self.species.crown.base_size * self.site.height).min(0.95 * length),
            _ => 0.0,
        };
        let Some(next) = self.species.stems.get(stem.level + 1) else {
            return Grown {
                stem,
                length,
                base,
                child_share: 0.0,
                children: 0.0,
            };
        };
        let draws = stem.stream.child(streams::SHAPE);
        let longest = self.species.stems[stem.level].length.max(1e-6);
        let children = match stem.level {
            0 => next.branches,
            1 => next.branches * (0.2 + 0.8 * (stem.share / longest).min(1.0)),
            _ => next.branches * (1.0 - 0.5 * stem.offset),
        };
        Grown {
            stem,
            length,
            base,
            child_share: next.length + draws.signed(5) * next.length_v,
            children: children * length / stem.length,
        }
    }

    /// Writes an axis into the skeleton.
    fn emit(&mut self, axis: &Axis, bearer: Option<u32>, grown: &Grown) -> Result<u32, GrowError> {
        let wood = &mut self.wood;
        let counts = [
            (
                "branches",
                wood.skeleton.branches.len() + 1,
                limits::GROWN_BRANCHES,
            ),
            (
                "nodes",
                wood.frames.len() + axis.points.len(),
                limits::GROWN_NODES,
            ),
        ];
        for (what, found, limit) in counts {
            if found > limit {
                return Err(GrowError::TooMany { what, found, limit });
            }
        }
        let stem = &grown.stem;
        let taper = self.species.stems[stem.level].taper;
        let branch = index_u32(wood.skeleton.branches.len());
        wood.skeleton.branches.push(Branch {
            bearer,
            level: index_u32(stem.level),
            first_node: index_u32(wood.skeleton.nodes.len()),
            node_count: index_u32(axis.points.len()),
        });
        for point in &axis.points {
            let z = (point.along / grown.length).clamp(0.0, 1.0);
            let mut radius = taper_radius(taper, z, stem.radius, grown.length);
            if stem.level == 0 {
                radius *= flare_factor(self.species.wood.flare, z);
            }
            wood.skeleton.nodes.push(Node {
                position: point.position,
                radius,
            });
            wood.frames.push(point.frame);
            wood.along.push(point.along);
        }
        Ok(branch)
    }

    fn bear_stems(&mut self, axis: &Axis, branch: u32, grown: &Grown) -> Result<(), GrowError> {
        let species = self.species;
        let (stem, length) = (&grown.stem, grown.length);
        let level = stem.level + 1;
        let next = &species.stems[level];
        let from = grown.base.max(axis.points[0].along);
        // Children per metre of the whole stem.
        let density = grown.children / (length - grown.base).max(SHORTEST_STEM);
        let children = axis.stream.child(streams::CHILDREN);
        let draws = axis.stream.child(streams::SHAPE);
        let mut around = 360.0 * draws.unit(7);
        let total = axis.part_above(from);
        // The fraction of a child that is left over grows as often as it is large.
        let count = (density * total + draws.unit(6)).floor();
        let mut child = 0_u16;
        while f32::from(child) < count {
            let stream = children.child(u64::from(child));
            let draws = stream.child(streams::SHAPE);
            let jitter = 0.4 * draws.signed(8);
            let along = axis.along_at(from, total * (f32::from(child) + 0.5 + jitter) / count);
            let z = (along - grown.base) / (length - grown.base).max(SHORTEST_STEM);
            let variation = draws.signed(9) * next.rotate_v;
            if next.rotate >= 0.0 {
                around += next.rotate + variation;
            } else {
                around = alternate(child.is_multiple_of(2), next.rotate + variation);
            }
            let (node, position, frame) = self.wood.place(branch, along);
            let reach = stem_length(
                &species.crown,
                level,
                grown.child_share,
                length,
                along,
                grown.base,
            );
            let share = reach / length;
            let here = taper_radius(
                species.stems[stem.level].taper,
                along / length,
                stem.radius,
                length,
            );
            let radius = stem_radius(stem.radius, share, species.wood.ratio_power).min(here);
            let frame = frame
                .roll(around)
                .pitch(down_angle(next, draws.signed(10), z));
            self.grow(
                Some(node),
                Stem {
                    level,
                    position,
                    frame,
                    length: reach,
                    radius,
                    offset: along / length,
                    share,
                    stream,
                },
            )?;
            child += 1;
        }
        Ok(())
    }

    fn bear_leaves(&mut self, axis: &Axis, branch: u32, grown: &Grown) {
        let stem = &grown.stem;
        let pruning = &self.species.crown.pruning;
        let fullness = shape_ratio(Shape::TaperedCylindrical, stem.offset, pruning);
        // A clone has its part of the stem's leaves, and pruning takes leaves too.
        let part = axis.part_above(0.0) / stem.length;
        let leaves = self.species.leaves.per_stem.abs() * fullness * part;
        self.wood.bearers.push(Bearer {
            branch,
            leaves,
            stream: axis.stream.child(streams::LEAVES),
        });
    }
}

impl Axis {
    /// The length above `from`, each metre weighed by its part of the stem's children.
    fn part_above(&self, from: f32) -> f32 {
        self.points.windows(2).fold(0.0, |sum, ends| {
            sum + ends[0].part * (ends[1].along - ends[0].along.max(from)).max(0.0)
        })
    }

    /// Where [`part_above`](Self::part_above) `from` has grown to `wanted`.
    fn along_at(&self, from: f32, wanted: f32) -> f32 {
        let mut left = wanted;
        for ends in self.points.windows(2) {
            let start = ends[0].along.max(from);
            let step = ends[0].part * (ends[1].along - start).max(0.0);
            if step > 0.0 && left <= step {
                return start + left / ends[0].part;
            }
            left -= step;
        }
        self.points.last().map_or(from, |tip| tip.along)
    }
}

impl Wood {
    /// The node at or below a place on a branch, the place itself, and the frame there.
    pub(super) fn place(&self, branch: u32, along: f32) -> (u32, Vec3, Frame) {
        let branch = &self.skeleton.branches[branch as usize];
        let first = branch.first_node as usize;
        let last = first + branch.node_count as usize - 1;
        let above = self.along[first..=last].partition_point(|&node| node <= along);
        let node = (first + above.max(1) - 1).min(last);
        if node == last {
            return (
                index_u32(last),
                self.skeleton.nodes[last].position,
                self.frames[last],
            );
        }
        let (start, end) = (
            self.skeleton.nodes[node].position,
            self.skeleton.nodes[node + 1].position,
        );
        let step = self.along[node + 1] - self.along[node];
        let share = ((along - self.along[node]) / step.max(1e-9)).clamp(0.0, 1.0);
        (
            index_u32(node),
            start + share * (end - start),
            self.frames[node],
        )
    }
}
