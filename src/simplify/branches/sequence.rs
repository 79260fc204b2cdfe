//! The sequence of levels: one error in, branches as polygons and lines out.

use super::frame::{FrameMethod, upright_frame};
use super::merges::MergeTable;
use super::mesh::{BranchMesh, PrimitiveCounts};
use super::needles::{Needle, NeedleOptions, NeedleRadius, NeedleSequence, NeedleUnit};
use super::polygons::{Caps, LineAlpha, LineNormals, PolygonNode, PolygonOptions, Polygonizer};
use super::polygons::{Polygons, Worst};
use super::relevance::BranchRelevance;
use super::route::{Allowed, Router};
use super::shares::{BranchErrors, Shares, permitted_error};
use super::skeletal::{BranchSkeleton, SkeletalVector};
use super::topology::TopologyOrder;
use crate::math::{Aabb, Vec3, index_u32};
use crate::plant::{Plant, Prototype, Skeleton};

/// How a plant becomes a sequence of levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchOptions {
    /// How frames go from node to node.
    pub frames: FrameMethod,
    /// `Γ`, in radians: how far both ends of a merge may lean from it together. The paper gives no
    /// value.
    pub torsion_limit: f32,
    /// How needles merge.
    pub needles: NeedleOptions,
    /// How nodes become primitives.
    pub polygons: PolygonOptions,
}

impl BranchOptions {
    /// What the paper says; where it leaves numbers open, 60° of torsion and 32 edges.
    pub const PAPER: Self = Self {
        frames: FrameMethod::Projection,
        torsion_limit: std::f32::consts::FRAC_PI_3,
        needles: NeedleOptions {
            radius: NeedleRadius::Mean,
            unit: NeedleUnit::Crown,
        },
        polygons: PolygonOptions {
            most_edges: 32,
            line_alpha: LineAlpha::Paper,
            line_normals: LineNormals::Three,
            caps: Caps::Tip,
        },
    };

    /// Frames that do not twist, lines as opaque as what they cover, needles that keep their area
    /// and merge with what is near.
    pub const SOUND: Self = Self {
        frames: FrameMethod::DoubleReflection,
        torsion_limit: std::f32::consts::FRAC_PI_3,
        needles: NeedleOptions {
            radius: NeedleRadius::Area,
            unit: NeedleUnit::Needle,
        },
        polygons: PolygonOptions {
            most_edges: 64,
            line_alpha: LineAlpha::Coverage { pixel_error: 0.5 },
            line_normals: LineNormals::One,
            caps: Caps::Tip,
        },
    };
}

/// All that levels of a plant's wood and needles are made from
/// ([ZBMJLDC17](crate::references), section 5.4).
///
/// Everything that takes looking at many nodes is computed once; [`at`](Self::at) answers any error.
/// Fewer primitives come with every greater error, never more.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchSequence {
    skeleton: BranchSkeleton,
    merges: MergeTable,
    topology: TopologyOrder,
    needles: NeedleSequence,
    polygons: Polygons,
    bounds: Aabb,
}

/// A plant's wood and needles with some error.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchLevel {
    /// The errors it was made with.
    pub errors: BranchErrors,
    /// The nodes that stayed.
    pub nodes: LevelNodes,
    /// The branches.
    pub branches: BranchMesh,
    /// The needles.
    pub needles: BranchMesh,
    /// How far it may be off.
    pub bound: LevelBound,
}

/// What is left of a skeleton.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LevelNodes {
    /// The branches that are left, in order.
    pub branches: Vec<u32>,
    /// Where the nodes of each begin in `nodes`; one more than there are branches.
    pub first: Vec<u32>,
    /// The nodes that are left, as numbers of skeletal vectors, base first.
    pub nodes: Vec<u32>,
}

impl LevelNodes {
    /// How many internodes are left: the paper's "skeleton lines".
    #[must_use]
    pub fn internode_count(&self) -> usize {
        self.nodes.len() - self.branches.len()
    }
}

/// How far a level may lie from the plant, in metres, up to rounding.
///
/// The surface of the plant is that of eq. 1 over all internodes, with discs on tips. A point inside of
/// wood that is left is covered: the foot of a branch that is removed is not missed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LevelBound {
    /// From any point of the plant's surface to the nearest of the level.
    pub to_level: f32,
    /// From any point of the level to the nearest of the plant's surface.
    pub to_plant: f32,
    /// What polygons add between their end circles, where the paper does not look: in `to_level` and
    /// `to_plant` already.
    pub between: f32,
    /// Circles that have the most edges and should have more. Their true sagitta is in the bounds, which
    /// may so be more than the errors add up to.
    pub clamped: u64,
}

impl BranchSequence {
    /// The sequence of a plant's skeleton and needles; empty where it has neither.
    #[must_use]
    pub fn of(plant: &Plant, options: &BranchOptions) -> Self {
        let none = Skeleton::default();
        let skeleton = plant.skeleton().unwrap_or(&none);
        let needles = plant.foliage().groups.iter();
        let needles = needles.filter_map(|group| match group.prototype {
            Prototype::Needle { diameter } => {
                let (ends, _) = group.positions.as_chunks::<2>();
                let radius = 0.5 * diameter;
                Some(ends.iter().map(|&ends| Needle { ends, radius }).collect())
            }
            Prototype::Quad { .. } | Prototype::Faces { .. } => None,
        });
        Self::of_parts(skeleton, &needles.collect::<Vec<_>>(), options)
    }

    /// The sequence of a skeleton as sound as a [`Plant`]'s is, and of needles in groups.
    #[must_use]
    pub fn of_parts(skeleton: &Skeleton, needles: &[Vec<Needle>], options: &BranchOptions) -> Self {
        let skeleton = BranchSkeleton::of(skeleton, options.frames);
        let around = |point: Vec3, radius: f32| [point - radius, point + radius];
        let wood = skeleton.vectors.iter();
        let wood = wood.flat_map(|vector| around(vector.position, vector.radius));
        let leaves = needles.iter().flatten();
        let leaves = leaves.flat_map(|needle| needle.ends.map(|end| around(end, needle.radius)));
        Self {
            merges: MergeTable::of(&skeleton, options.torsion_limit),
            topology: TopologyOrder::of(&skeleton),
            needles: NeedleSequence::of(needles, options.needles),
            polygons: Polygons::new(options.polygons),
            bounds: Aabb::of(wood.chain(leaves.flatten())),
            skeleton,
        }
    }

    /// The level of an error `ε`, in metres; not less than 0, and NaN counts as 0.
    #[must_use]
    pub fn at(&self, epsilon: f32, shares: Shares) -> BranchLevel {
        self.level(&self.errors(epsilon, shares))
    }

    /// The errors of [`at`](Self::at).
    #[must_use]
    pub fn errors(&self, epsilon: f32, shares: Shares) -> BranchErrors {
        shares.errors(epsilon, self.needles.original_count() > 0)
    }

    /// The error `ε` that is at most `pixel_error` pixels wherever the tree is seen from `eye`, both in
    /// the plant's space: see [`permitted_error`]. The tree's nearest point is no nearer than its box.
    #[must_use]
    pub fn error_from(&self, eye: Vec3, pixel_error: f32, focal_pixels: f32) -> f32 {
        let distance = if self.bounds.is_empty() {
            0.0
        } else {
            self.bounds.distance(eye)
        };
        permitted_error(pixel_error, focal_pixels, distance)
    }

    /// The level of errors of their own.
    #[must_use]
    pub fn level(&self, errors: &BranchErrors) -> BranchLevel {
        let mut kept = vec![true; self.skeleton.branches.len()];
        for &branch in self.topology.removed(errors.topology) {
            kept[branch as usize] = false;
        }
        self.level_of(&kept, errors)
    }

    /// The level of the `count` most relevant branches, and no other ([`BranchRelevance`]); the error
    /// `E4` is not used.
    #[must_use]
    pub fn pruned(
        &self,
        relevance: &BranchRelevance,
        count: usize,
        errors: &BranchErrors,
    ) -> BranchLevel {
        let mut kept = vec![false; self.skeleton.branches.len()];
        for &branch in relevance.order().iter().take(count) {
            kept[branch as usize] = true;
        }
        self.level_of(&kept, errors)
    }

    /// The skeleton with its frames: what a device needs that expands levels itself.
    #[must_use]
    pub fn skeleton(&self) -> &BranchSkeleton {
        &self.skeleton
    }

    /// The merges of the skeleton.
    #[must_use]
    pub fn merges(&self) -> &MergeTable {
        &self.merges
    }

    /// The order in which branches go.
    #[must_use]
    pub fn topology(&self) -> &TopologyOrder {
        &self.topology
    }

    /// The needles and what they merge into.
    #[must_use]
    pub fn needles(&self) -> &NeedleSequence {
        &self.needles
    }

    /// The box around all wood and needles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// How nodes become primitives.
    #[must_use]
    pub fn polygon_options(&self) -> &PolygonOptions {
        &self.polygons.options
    }

    /// Of every node how many nodes back the internode of a level begins that ends there; 0 where none
    /// does.
    #[must_use]
    pub fn internodes(&self, errors: &BranchErrors) -> Vec<u32> {
        let mut backs = vec![0; self.skeleton.vectors.len()];
        let removed = self.topology.removed(errors.topology);
        let mut kept = vec![true; self.skeleton.branches.len()];
        for &branch in removed {
            kept[branch as usize] = false;
        }
        let edges = self.edges(errors);
        let cost = |from: usize, to: usize| self.polygons.primitives(edges[from], edges[to]);
        let mut router = Router::default();
        let branches = self.skeleton.branches.iter().zip(kept);
        for (branch, _) in branches.filter(|(_, kept)| *kept) {
            let stops = router.stops(&self.merges, branch.run(), Allowed::of(errors), cost);
            for pair in stops.windows(2) {
                backs[pair[1].node] = index_u32(pair[1].node - pair[0].node);
            }
        }
        backs
    }

    /// The edges of a circle of this radius at an error `E3`, both in metres; 1 for a point.
    #[must_use]
    pub fn edges_of(&self, radius: f32, error: f32) -> u32 {
        self.polygons.edges.edges(radius, error).count
    }

    /// The edges of every node's circle; 1 for a point.
    fn edges(&self, errors: &BranchErrors) -> Vec<u32> {
        let table = &self.polygons.edges;
        let edges = |vector: &SkeletalVector| table.edges(vector.radius, errors.polygon).count;
        self.skeleton.vectors.iter().map(edges).collect()
    }

    /// The level of these branches; whoever is kept has a bearer that is.
    fn level_of(&self, kept: &[bool], errors: &BranchErrors) -> BranchLevel {
        let edges = self.edges(errors);
        let cost = |from: usize, to: usize| self.polygons.primitives(edges[from], edges[to]);
        let mut router = Router::default();
        let mut wood = Polygonizer::new(&self.polygons, errors.polygon, errors.epsilon);
        let mut nodes = LevelNodes::default();
        let (mut removed, mut moved) = (None, 0.0_f32);
        let mut stayed: Vec<PolygonNode> = Vec::new();
        for (number, branch) in self.skeleton.branches.iter().enumerate() {
            if !kept[number] {
                let reach = self.topology.accumulated()[number];
                removed = Some(removed.map_or(reach, |most: f32| most.max(reach)));
                continue;
            }
            let stops = router.stops(&self.merges, branch.run(), Allowed::of(errors), cost);
            nodes.branches.push(index_u32(number));
            nodes.first.push(index_u32(nodes.nodes.len()));
            stayed.clear();
            for stop in &stops {
                nodes.nodes.push(index_u32(stop.node));
                moved = moved.max(stop.skeleton);
                stayed.push(PolygonNode {
                    vector: self.skeleton.vectors[stop.node],
                    along: self.skeleton.along[stop.node],
                    merged: stop.skeleton + stop.radius,
                });
            }
            wood.add(&stayed);
        }
        nodes.first.push(index_u32(nodes.nodes.len()));
        let mut needles = Polygonizer::new(&self.polygons, errors.polygon, errors.epsilon);
        for number in self.needles.at(errors.needle) {
            needles.add(&self.needle(number));
        }
        let reach = removed.map_or(0.0, |most| most + moved);
        let bound = bound(&[wood.worst, needles.worst], reach);
        BranchLevel {
            errors: *errors,
            nodes,
            branches: wood.mesh,
            needles: needles.mesh,
            bound,
        }
    }

    /// A needle as a branch of one internode.
    fn needle(&self, number: u32) -> [PolygonNode; 2] {
        let needle = &self.needles.needles()[number as usize];
        let frame = upright_frame(needle.direction());
        let [base, tip] = needle.ends;
        let node = |position, along, merged| PolygonNode {
            vector: SkeletalVector {
                position,
                radius: needle.radius,
                frame,
            },
            along,
            merged,
        };
        let merged = self.needles.errors()[number as usize];
        [node(base, 0.0, 0.0), node(tip, needle.length(), merged)]
    }
}

/// What all meshes together may be off by, and what was removed.
fn bound(worst: &[Worst], reach: f32) -> LevelBound {
    let surface = worst
        .iter()
        .fold(0.0, |most: f32, worst| most.max(worst.surface));
    let between = worst
        .iter()
        .fold(0.0, |most: f32, worst| most.max(worst.between));
    LevelBound {
        to_level: surface.max(reach),
        to_plant: surface,
        between,
        clamped: worst.iter().map(|worst| worst.clamped).sum(),
    }
}

impl BranchLevel {
    /// How many primitives branches and needles have together.
    #[must_use]
    pub fn counts(&self) -> PrimitiveCounts {
        let [wood, needles] = [&self.branches, &self.needles].map(BranchMesh::counts);
        PrimitiveCounts {
            quads: wood.quads + needles.quads,
            triangles: wood.triangles + needles.triangles,
            lines: wood.lines + needles.lines,
        }
    }
}
