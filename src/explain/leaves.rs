//! Two plants, leaf by leaf: leaves are known by what they are, not by their numbers, so that one
//! that is gone does not make all that follow differ.

use std::collections::BTreeMap;

use serde::Serialize;

use super::bounded;
use super::leaf::branch_of;
use crate::math::{Vec3, index_u32};
use crate::models::Crown;

/// How two plants differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlantDifference {
    /// The first tree that shows them.
    pub tree: u32,
    /// The plants' numbers in A and in B.
    pub plants: [u32; 2],
    /// Their digests.
    pub digests: [String; 2],
    /// Leaves of A's plant, and of B's.
    pub leaves: [u64; 2],
    /// How many leaves only A has.
    pub only_a_count: u64,
    /// The first of them.
    pub only_a: Vec<LeafPlace>,
    /// How many leaves only B has.
    pub only_b_count: u64,
    /// The first of them.
    pub only_b: Vec<LeafPlace>,
    /// How many leaves of A without an equal in B have one on the same branch.
    pub moved_count: u64,
    /// The first of them.
    pub moved: Vec<MovedLeaf>,
    /// Leaves that both have, under another number.
    pub renumbered: u64,
    /// What else differs: `skeleton`, `trunk`, `materials`, `other foliage`.
    pub parts: Vec<&'static str>,
}

/// An original leaf and where it is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeafPlace {
    /// Its number in its plant.
    pub leaf: u32,
    /// The branch that bears it, where it is known.
    pub branch: Option<u32>,
    /// The name of its foliage group.
    pub group: String,
    /// The mean of its corners in the plant's space, in metres.
    pub centre: [f32; 3],
}

/// A leaf of A and the leaf of B that is nearest to it on its branch.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovedLeaf {
    /// In A.
    pub a: LeafPlace,
    /// In B.
    pub b: LeafPlace,
    /// Between their centres, in metres.
    pub distance: f32,
}

/// Which leaf of B each leaf of A is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LeafMatch {
    /// By A's original leaves.
    pub(super) b_of_a: Vec<Option<u32>>,
    /// By B's.
    pub(super) a_of_b: Vec<Option<u32>>,
}

/// All that makes a leaf what it is: group, owner, corners as bits.
type Content = (u32, u32, [[u32; 3]; 4]);

/// Groups by name, in the order in which the two plants name them.
#[derive(Debug, Default)]
struct GroupNames(Vec<String>);

impl GroupNames {
    fn number(&mut self, name: &str) -> u32 {
        let known = self.0.iter().position(|known| known == name);
        let number = known.unwrap_or_else(|| {
            self.0.push(name.to_owned());
            self.0.len() - 1
        });
        index_u32(number)
    }

    /// The content of every leaf.
    fn contents(&mut self, crown: &Crown) -> Vec<Content> {
        let mut contents = Vec::new();
        for (group, _) in crown.plant().foliage().quad_groups() {
            let number = self.number(&group.name);
            for (leaf, &owner) in group.owners.iter().enumerate() {
                let corner = |role: usize| group.positions[4 * leaf + role].to_array();
                let corners = [0, 1, 2, 3].map(|role| corner(role).map(f32::to_bits));
                contents.push((number, owner, corners));
            }
        }
        contents
    }
}

/// Matches the leaves of two plants by content; of equal ones the first with the first.
pub(super) fn match_leaves(a: &Crown, b: &Crown) -> LeafMatch {
    let mut names = GroupNames::default();
    let [ours, theirs] = [a, b].map(|crown| {
        let contents = names.contents(crown);
        let mut order: Vec<(Content, u32)> = contents.into_iter().zip(0..).collect();
        order.sort_unstable();
        order
    });
    let mut found = LeafMatch {
        b_of_a: vec![None; ours.len()],
        a_of_b: vec![None; theirs.len()],
    };
    let (mut i, mut j) = (0, 0);
    while let (Some(one), Some(other)) = (ours.get(i), theirs.get(j)) {
        match one.0.cmp(&other.0) {
            std::cmp::Ordering::Less => i += 1,
            std::cmp::Ordering::Greater => j += 1,
            std::cmp::Ordering::Equal => {
                found.b_of_a[one.1 as usize] = Some(other.1);
                found.a_of_b[other.1 as usize] = Some(one.1);
                (i, j) = (i + 1, j + 1);
            }
        }
    }
    found
}

/// How the plants that a tree shows differ; `None` if they are one.
pub(super) fn plant_difference(
    tree: u32,
    [number_a, number_b]: [usize; 2],
    a: &Crown,
    b: &Crown,
    matched: &LeafMatch,
) -> Option<PlantDifference> {
    let digests = [a, b].map(|crown| crown.plant().digest());
    if digests[0] == digests[1] {
        return None;
    }
    let rest = |of: &[Option<u32>]| -> Vec<u32> {
        let unmatched = (0..).zip(of).filter(|(_, other)| other.is_none());
        unmatched.map(|(leaf, _)| leaf).collect()
    };
    let (moved, only_a, only_b) = pair(a, b, &rest(&matched.b_of_a), &rest(&matched.a_of_b));
    let renumbered = (0..).zip(&matched.b_of_a);
    let renumbered = renumbered.filter(|(leaf, other)| other.is_some_and(|other| other != *leaf));
    let renumbered = renumbered.count() as u64;
    let (ours, theirs) = (a.plant(), b.plant());
    let materials = [a, b].map(|crown| {
        let groups = crown.plant().foliage().quad_groups();
        groups
            .map(|(group, corners)| (group.name.clone(), group.material.clone(), *corners))
            .collect::<Vec<_>>()
    });
    let others = [a, b].map(|crown| {
        let foliage = crown.plant().foliage();
        let groups = foliage.groups.iter();
        let others = groups.filter(|group| {
            !foliage
                .quad_groups()
                .any(|(quads, _)| std::ptr::eq(quads, *group))
        });
        others.cloned().collect::<Vec<_>>()
    });
    let parts = [
        ("skeleton", ours.skeleton() == theirs.skeleton()),
        ("trunk", ours.trunk() == theirs.trunk()),
        ("materials", materials[0] == materials[1]),
        ("other foliage", others[0] == others[1]),
    ];
    let (only_a_count, only_a) = bounded(only_a);
    let (only_b_count, only_b) = bounded(only_b);
    let (moved_count, moved) = bounded(moved);
    Some(PlantDifference {
        tree,
        plants: [index_u32(number_a), index_u32(number_b)],
        digests: digests.map(|digest| digest.to_string()),
        leaves: [matched.b_of_a.len() as u64, matched.a_of_b.len() as u64],
        only_a_count,
        only_a,
        only_b_count,
        only_b,
        moved_count,
        moved,
        renumbered,
        parts: parts
            .into_iter()
            .filter(|(_, same)| !same)
            .map(|(part, _)| part)
            .collect(),
    })
}

/// The most pairs of leaves of one branch that are measured; where there are more, leaves are paired
/// in their order.
const MOST_MEASURED: usize = 1 << 20;

/// Pairs leaves that are left over by branch and group, each of A with the nearest of B.
fn pair(
    a: &Crown,
    b: &Crown,
    rest_a: &[u32],
    rest_b: &[u32],
) -> (Vec<MovedLeaf>, Vec<LeafPlace>, Vec<LeafPlace>) {
    let mut homes: BTreeMap<(String, Option<u32>), [Vec<LeafPlace>; 2]> = BTreeMap::new();
    for (side, (crown, rest)) in [(a, rest_a), (b, rest_b)].into_iter().enumerate() {
        for &leaf in rest {
            let place = leaf_place(crown, leaf);
            let home = homes
                .entry((place.group.clone(), place.branch))
                .or_default();
            home[side].push(place);
        }
    }
    let (mut moved, mut only_a, mut only_b) = (Vec::new(), Vec::new(), Vec::new());
    for [ours, mut theirs] in homes.into_values() {
        let measured = ours.len() * theirs.len() <= MOST_MEASURED;
        if !measured {
            theirs.reverse();
        }
        for place in ours {
            let nearest = if measured {
                let distances = theirs.iter().map(|other| distance(&place, other));
                distances
                    .enumerate()
                    .min_by(|one, other| one.1.total_cmp(&other.1))
                    .map(|(index, _)| index)
            } else {
                theirs.len().checked_sub(1)
            };
            match nearest {
                Some(nearest) => {
                    let other = theirs.remove(nearest);
                    moved.push(MovedLeaf {
                        distance: distance(&place, &other),
                        a: place,
                        b: other,
                    });
                }
                None => only_a.push(place),
            }
        }
        only_b.extend(theirs);
    }
    moved.sort_by_key(|moved| moved.a.leaf);
    only_a.sort_by_key(|place| place.leaf);
    only_b.sort_by_key(|place| place.leaf);
    (moved, only_a, only_b)
}

fn distance(one: &LeafPlace, other: &LeafPlace) -> f32 {
    Vec3::from_array(one.centre).distance(Vec3::from_array(other.centre))
}

/// Where an original leaf is.
pub(super) fn leaf_place(crown: &Crown, leaf: u32) -> LeafPlace {
    let first = 4 * leaf as usize;
    let corners = &crown.vertices()[first..first + 4];
    let centre = ((corners[0] + corners[1]) + (corners[2] + corners[3])) * 0.25;
    let mut rest = leaf as usize;
    let mut name = String::new();
    for (group, _) in crown.plant().foliage().quad_groups() {
        if rest < group.owners.len() {
            name.clone_from(&group.name);
            break;
        }
        rest -= group.owners.len();
    }
    LeafPlace {
        leaf,
        branch: branch_of(crown, leaf),
        group: name,
        centre: centre.to_array(),
    }
}
