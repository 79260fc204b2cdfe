//! What there is to tell of a leaf: where it comes from, what becomes of it, and where it is.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::models::{Crown, Kind, ModelOptions, Placement, State};

/// A leaf record, by its number in the crown's sequence: originals first, then the new leaf of each
/// collapse; equal in all models and modes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeafStory {
    /// Its number.
    pub leaf: u32,
    /// The collapse that made it; an original has none.
    pub made_by: Option<CollapseStory>,
    /// The collapse that consumes it; the root of a cluster has none.
    pub consumed_by: Option<CollapseStory>,
    /// How many original leaves it stands for.
    pub stands_for: u32,
    /// The cluster that it is in.
    pub cluster: ClusterStory,
    /// The branch that bears it, where it is an original and that is known.
    pub branch: Option<u32>,
    /// Its corners, in the order of roles.
    pub vertices: Vec<VertexStory>,
    /// What it looks like.
    pub material: MaterialStory,
}

/// A collapse.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CollapseStory {
    /// Its number in the sequence, from 0.
    pub collapse: u32,
    /// What the simplifier paid, in its own unit.
    pub cost: f32,
    /// The two leaves that it joins.
    pub old: [u32; 2],
    /// The leaf that it makes.
    pub new: u32,
    /// Whether it is done in the frame's state.
    pub done: bool,
}

/// A cluster in the state of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClusterStory {
    /// Its number.
    pub cluster: u32,
    /// Leaves at full detail.
    pub originals: u32,
    /// Collapses done, of one less than originals.
    pub collapses: u32,
    /// Leaves that are visible now.
    pub visible: u32,
}

/// A corner of a leaf.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VertexStory {
    /// Which corner: 0 and 1 at the base, 2 and 3 at the tip.
    pub role: u32,
    /// Its number in the vertex buffer.
    pub vertex: u32,
    /// Where it is in the plant's space, in metres.
    pub plant: [f32; 3],
    /// Where it is in the world, in metres.
    pub world: [f32; 3],
    /// The original leaf that it comes from.
    pub leaf: u32,
    /// The branch that bears that leaf, where it is known.
    pub branch: Option<u32>,
}

/// What a leaf looks like.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialStory {
    /// The foliage group, among those of quad leaves; of a leaf of several faces, among all.
    pub group: u32,
    /// The group's name.
    pub name: String,
    /// Linear colour that multiplies the texture's, with alpha.
    pub base_color: [f32; 4],
    /// Texels of the texture, if there is one.
    pub texture: Option<[u32; 2]>,
    /// Texels with alpha below this are not there.
    pub alpha_cutoff: f32,
}

/// All that it takes to tell of the leaves of one tree.
#[derive(Debug)]
pub(super) struct LeafBook<'c> {
    crown: &'c Crown,
    /// The collapses done in each cluster.
    counts: Vec<u32>,
    /// The collapse that consumes each leaf.
    consumed_by: Vec<Option<u32>>,
    /// How many originals each leaf stands for.
    stands_for: Vec<u32>,
    /// The leaves that are drawn, by their corners.
    drawn: BTreeMap<[u32; 4], u32>,
}

impl<'c> LeafBook<'c> {
    pub(super) fn new(
        crown: &'c std::sync::Arc<Crown>,
        state: &State,
        kind: Kind,
        options: ModelOptions,
    ) -> Self {
        let sequence = crown.sequence();
        let mut consumed_by = vec![None; sequence.corners().len()];
        let mut stands_for = vec![1; sequence.original_count() as usize];
        for (number, collapse) in (0..).zip(sequence.collapses()) {
            let mut sum = 0;
            for old in collapse.old {
                consumed_by[old as usize] = Some(number);
                sum += stands_for[old as usize];
            }
            stands_for.push(sum);
        }
        let mut drawn = BTreeMap::new();
        for leaf in kind.model(crown, options).drawn(state) {
            // Where a broken mode draws two of the same corners, the one that is drawn first.
            drawn
                .entry(sequence.corners()[leaf as usize])
                .or_insert(leaf);
        }
        Self {
            crown,
            counts: state.counts(crown.clusters()),
            consumed_by,
            stands_for,
            drawn,
        }
    }

    /// The drawn leaf that has these corners.
    pub(super) fn leaf_with(&self, corners: [u32; 4]) -> Option<u32> {
        self.drawn.get(&corners).copied()
    }

    /// The cluster of a leaf.
    pub(super) fn cluster_of(&self, leaf: u32) -> u32 {
        self.crown.clusters().cluster_of_leaf[leaf as usize]
    }

    /// The story of a leaf of a tree that stands there.
    pub(super) fn story(&self, leaf: u32, placement: &Placement) -> LeafStory {
        let crown = self.crown;
        let originals = crown.sequence().original_count();
        let corners = crown.sequence().corners()[leaf as usize];
        let cluster = self.cluster_of(leaf);
        let size = crown.clusters().clusters[cluster as usize].original_count();
        let collapses = self.counts[cluster as usize];
        let vertices = (0..).zip(corners).map(|(role, vertex)| {
            let plant = crown.vertices()[vertex as usize];
            VertexStory {
                role,
                vertex,
                plant: plant.to_array(),
                world: placement.to_world(plant).to_array(),
                leaf: crown.sequence().original_of_vertex(vertex),
                branch: branch_of(crown, crown.sequence().original_of_vertex(vertex)),
            }
        });
        LeafStory {
            leaf,
            made_by: leaf
                .checked_sub(originals)
                .map(|collapse| self.collapse(collapse)),
            consumed_by: self.consumed_by[leaf as usize].map(|collapse| self.collapse(collapse)),
            stands_for: self.stands_for[leaf as usize],
            cluster: ClusterStory {
                cluster,
                originals: size,
                collapses,
                visible: size - collapses,
            },
            branch: (leaf < originals).then(|| branch_of(crown, leaf)).flatten(),
            vertices: vertices.collect(),
            material: material_of(crown, crown.sequence().original_of_vertex(corners[0])),
        }
    }

    fn collapse(&self, collapse: u32) -> CollapseStory {
        let sequence = self.crown.sequence();
        let entry = sequence.collapses()[collapse as usize];
        let new = sequence.new_leaf(collapse);
        let cluster = self.cluster_of(new) as usize;
        let before = self.crown.clusters().clusters[cluster].collapses_after(collapse);
        CollapseStory {
            collapse,
            cost: entry.cost,
            old: entry.old,
            new,
            done: self.counts[cluster] > before,
        }
    }
}

/// The branch that bears an original leaf; `None` where no branch is known.
pub(super) fn branch_of(crown: &Crown, leaf: u32) -> Option<u32> {
    let mut rest = leaf as usize;
    let branches = crown.plant().skeleton()?.branches.len();
    for (group, _) in crown.plant().foliage().quad_groups() {
        match group.owners.get(rest) {
            Some(&owner) => return Some(owner).filter(|&owner| (owner as usize) < branches),
            None => rest -= group.owners.len(),
        }
    }
    None
}

impl MaterialStory {
    /// Of a group by its place among all, told by another number.
    pub(super) fn of(crown: &Crown, place: usize, number: u32) -> Option<Self> {
        let group = crown.plant().foliage().groups.get(place)?;
        let material = &group.material;
        Some(Self {
            group: number,
            name: group.name.clone(),
            base_color: material.base_color,
            texture: material
                .texture
                .as_ref()
                .map(|texture| [texture.width(), texture.height()]),
            alpha_cutoff: material.alpha_cutoff,
        })
    }
}

/// What an original leaf looks like.
fn material_of(crown: &Crown, leaf: u32) -> MaterialStory {
    let foliage = crown.plant().foliage();
    let mut rest = leaf as usize;
    let mut found = None;
    for (number, (group, _)) in (0..).zip(foliage.quad_groups()) {
        found = Some((number, group));
        if rest < group.owners.len() {
            break;
        }
        rest -= group.owners.len();
    }
    let (number, group) = found.expect("a leaf is one of some group");
    let place = foliage
        .groups
        .iter()
        .position(|known| std::ptr::eq(known, group));
    let story = place.and_then(|place| MaterialStory::of(crown, place, number));
    story.expect("its group is one of the plant's")
}
