//! Random cases for [proptest](https://docs.rs/proptest) that shrink well (feature `testkit`).
//!
//! ```text
//!  strategy::walk, tree_walk ──▶ a case ──fails?──▶ the first simpler case that fails, … ──▶ a minimal one
//!  strategy::foliage, view_path     (proptest's own values, which shrink by themselves)
//! ```
//!
//! Cases of histories shrink as [`Simpler`] says: leaves go first, whole trees keep their meaning
//! when one does, then collapses, then steps, then numbers. The usual way, shrinking the random
//! numbers that a case is drawn from, changes all collapses behind the first that changes and gets
//! stuck early.

use std::fmt;
use std::ops::RangeInclusive;

use proptest::collection::vec;
use proptest::prelude::{Strategy, any};
use proptest::strategy::{NewTree, ValueTree};
use proptest::test_runner::TestRunner;

use super::simpler::{Simpler, TreeWalk};
use super::{History, Operation, Walk};
use crate::math::{Draws, Stream, Vec2, Vec3, index_u32, index_usize};
use crate::models::State;
use crate::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Prototype, Texture};

/// How large walks are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WalkOptions {
    /// Leaves at full detail.
    pub leaves: RangeInclusive<u32>,
    /// Leaves that are left after all collapses, as far as there are so many.
    pub roots: RangeInclusive<u32>,
    /// Steps.
    pub steps: RangeInclusive<usize>,
}

/// Collapse histories.
pub fn history(
    leaves: RangeInclusive<u32>,
    roots: RangeInclusive<u32>,
) -> impl Strategy<Value = History> {
    simplest(move |draws| {
        let leaves = between(draws, &leaves);
        let roots = between(draws, &roots);
        random_history(draws, leaves, leaves, roots)
    })
}

/// Histories with walks through them: collapses, splits, levels, and clusters to their own numbers.
pub fn walk(options: WalkOptions) -> impl Strategy<Value = Walk> {
    simplest(move |draws| {
        let leaves = between(draws, &options.leaves);
        random_walk(draws, leaves, leaves, &options)
    })
}

/// Walks of models through trees: leaves in two groups of a colour each, at random in a cube from −1
/// to 1, with a disc on them; in every other tree up to three leaves of three faces between the groups.
/// Steps are states.
pub fn tree_walk(options: WalkOptions) -> impl Strategy<Value = TreeWalk> {
    simplest(move |draws| {
        let leaves = between(draws, &options.leaves);
        let split = leaves / 2;
        let mut walk = random_walk(draws, leaves, split, &options);
        let states = walk.states();
        walk.operations = states.into_iter().map(Operation::To).collect();
        let mut groups = vec![
            quads(draws, split, [0.2, 0.8, 0.1, 1.0]),
            quads(draws, leaves - split, [0.9, 0.5, 0.1, 1.0]),
        ];
        if draws.below(2) == 0 {
            let count = index_u32(1 + below(draws, 3));
            groups.insert(1, meshes(draws, count, [0.3, 0.3, 0.9, 1.0]));
        }
        let foliage = Foliage { groups };
        TreeWalk { foliage, walk }
    })
}

/// Foliage of flat quad leaves on a coarse lattice, so that ties, equal leaves and leaves without
/// area are common. Shrinks to fewer groups, fewer leaves, and leaves at the origin.
pub fn foliage(
    groups: RangeInclusive<usize>,
    leaves: RangeInclusive<usize>,
) -> impl Strategy<Value = Foliage> {
    // Three vectors a leaf: its base, one side, and what the other side leans to.
    let leaf = proptest::array::uniform3(proptest::array::uniform3(-4_i8..=4));
    vec(vec(leaf, leaves), groups).prop_map(|groups| {
        let groups = groups.into_iter().map(|leaves| {
            let positions = leaves.into_iter().flat_map(|vectors| {
                let [base, side, lean] = vectors.map(|vector| Vec3::from(vector.map(f32::from)));
                let up = 0.5 * side.cross(lean);
                [base, base + side, base + side + up, base + up]
            });
            leaf_group(
                Material::plain("leaf", [0.1, 0.4, 0.1]),
                positions.collect(),
            )
        });
        let groups = groups.collect();
        Foliage { groups }
    })
}

/// Paths of a viewer around the origin, at most `reach` metres away along each axis. Shrinks to
/// fewer places, and to the origin.
pub fn view_path(reach: f32, places: RangeInclusive<usize>) -> impl Strategy<Value = Vec<Vec3>> {
    let place = proptest::array::uniform3(-1024_i16..=1024);
    vec(place, places).prop_map(move |places| {
        let places = places.into_iter();
        let place = |place: [i16; 3]| Vec3::from(place.map(f32::from)) * (reach / 1024.0);
        places.map(place).collect()
    })
}

fn between(draws: &mut Draws, range: &RangeInclusive<u32>) -> u32 {
    let choices = u64::from(range.end().saturating_sub(*range.start())) + 1;
    range.start() + index_u32(index_usize(draws.below(choices)))
}

fn below(draws: &mut Draws, bound: usize) -> usize {
    index_usize(draws.below(bound as u64))
}

/// Collapses of leaves on the same side of `split`, until about `roots` are left.
fn random_history(draws: &mut Draws, leaves: u32, split: u32, roots: u32) -> History {
    let mut sides = [(0..split).collect::<Vec<u32>>(), (split..leaves).collect()];
    let mut collapses = Vec::new();
    while sides.iter().map(Vec::len).sum::<usize>() > roots as usize {
        let first = below(draws, 2);
        let Some(side) = [first, 1 - first]
            .into_iter()
            .find(|&side| sides[side].len() > 1)
        else {
            break;
        };
        let side = &mut sides[side];
        let mut take = || side.swap_remove(below(draws, side.len()));
        collapses.push([take(), take()]);
        side.push(leaves + index_u32(collapses.len()) - 1);
    }
    History::new(leaves, &collapses).expect("only visible leaves are paired")
}

fn random_walk(draws: &mut Draws, leaves: u32, split: u32, options: &WalkOptions) -> Walk {
    let roots = between(draws, &options.roots);
    let history = random_history(draws, leaves, split, roots);
    let most = history.most_counts();
    let more = options.steps.end().saturating_sub(*options.steps.start());
    let steps = options.steps.start() + below(draws, more + 1);
    let mut state = State::FINEST;
    let operations = (0..steps).map(|_| {
        let level = Operation::To(State::Uniform {
            collapses: between(draws, &(0..=history.collapse_count())),
        });
        let operation = match draws.below(6) {
            0 => Operation::Collapse,
            1 => Operation::Split,
            2 | 3 => level.clone(),
            _ => Operation::To(State::Variable {
                counts: most
                    .iter()
                    .map(|&most| between(draws, &(0..=most)))
                    .collect(),
            }),
        };
        // No step is wasted on what cannot be done where the walk stands.
        let taken = operation
            .target(&history, &state)
            .map(|target| (operation, target));
        let taken = taken.or_else(|| {
            let target = level.target(&history, &state)?;
            Some((level, target))
        });
        let (operation, target) = taken.expect("every level can be gone to");
        state = target;
        operation
    });
    let operations = operations.collect();
    Walk {
        history,
        operations,
    }
}

fn quads(draws: &mut Draws, count: u32, base_color: [f32; 4]) -> LeafGroup {
    let mut positions = Vec::new();
    for _ in 0..count {
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        let (center, side, up) = (vector(), 0.3 * vector(), 0.3 * vector());
        positions.extend([
            center - side,
            center + side,
            center + side + up,
            center - side + up,
        ]);
    }
    let material = Material {
        name: "leaf".to_owned(),
        base_color,
        texture: disc(),
        alpha_cutoff: 0.5,
    };
    leaf_group(material, positions)
}

/// Leaves of three faces: a quad bent along a diagonal, and a face beside.
fn meshes(draws: &mut Draws, count: u32, base_color: [f32; 4]) -> LeafGroup {
    let mut group = quads(draws, count, base_color);
    let mut positions = Vec::new();
    for corners in group.positions.chunks_exact(4) {
        let mut vector = || 0.2 * Vec3::new(draws.signed(), draws.signed(), draws.signed());
        positions.extend([corners[0], corners[1], corners[2] + vector(), corners[3]]);
        positions.push(corners[0] + vector());
    }
    let mut texture_coordinates = Prototype::WHOLE_IMAGE.to_vec();
    texture_coordinates.push(Vec2::new(0.5, 0.5));
    group.name = "meshes".to_owned();
    group.prototype = Prototype::Faces {
        texture_coordinates,
        triangles: vec![[0, 1, 2], [2, 3, 0], [4, 0, 1]],
    };
    group.positions = positions;
    group
}

fn leaf_group(material: Material, positions: Vec<Vec3>) -> LeafGroup {
    LeafGroup {
        name: "leaves".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material,
        owners: vec![NO_BRANCH; positions.len() / 4],
        positions,
    }
}

/// A disc on 8 × 8 texels.
fn disc() -> Option<Texture> {
    let texel = |index: i32| {
        let (x, y) = (2 * (index % 8) - 7, 2 * (index / 8) - 7);
        [255, 255, 255, if x * x + y * y < 60 { 255 } else { 0 }]
    };
    Texture::new(8, 8, (0..64).flat_map(texel).collect())
}

/// Cases of a generator that shrink as [`Simpler`] says. The generator draws from a stream of its
/// own, so a case is a function of one random number.
pub fn simplest<T, G>(generate: G) -> impl Strategy<Value = T>
where
    T: Simpler + Clone + fmt::Debug,
    G: Fn(&mut Draws) -> T,
{
    Simplest { generate }
}

struct Simplest<G> {
    generate: G,
}

impl<G> fmt::Debug for Simplest<G> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Simplest")
    }
}

impl<T, G> Strategy for Simplest<G>
where
    T: Simpler + Clone + fmt::Debug,
    G: Fn(&mut Draws) -> T,
{
    type Tree = SimplestTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let seed = any::<u64>().new_tree(runner)?.current();
        let case = (self.generate)(&mut Stream::new(seed, 0).draws());
        Ok(SimplestTree {
            current: case.clone(),
            failed: case,
            untried: Vec::new(),
        })
    }
}

/// A case, the simplest one that failed so far, and the ones simpler than that, best last.
struct SimplestTree<T> {
    current: T,
    failed: T,
    untried: Vec<T>,
}

impl<T: Simpler + Clone + fmt::Debug> ValueTree for SimplestTree<T> {
    type Value = T;

    fn current(&self) -> T {
        self.current.clone()
    }

    /// The present case fails: what is simpler than it is tried.
    fn simplify(&mut self) -> bool {
        self.failed = self.current.clone();
        self.untried = self.failed.simpler();
        self.untried.reverse();
        self.complicate()
    }

    /// The present case does not fail: the next one is tried, until there is none.
    fn complicate(&mut self) -> bool {
        match self.untried.pop() {
            Some(next) => {
                self.current = next;
                true
            }
            None => {
                self.current = self.failed.clone();
                false
            }
        }
    }
}
