//! VDF, the papers' rival: a list of active leaves, refined and coarsened leaf by leaf
//! ([RC03](crate::references); its internals are a reconstruction from the byte counts of
//! [RRCGR](crate::references), Table II).
//!
//! Every leaf, old or new, keeps its four vertices, its parent and its two children: 28 bytes. The
//! list of active leaves is ordered: a split replaces a leaf by its two children where it stands, a
//! collapse the other way round, so the order is that of a walk through the trees and depends on
//! nothing but the cut.

use std::sync::Arc;

use super::format::LeafBytes;
use super::leaf_list::LeafList;
use super::surface::Uploaded;
use super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use crate::gpu::{Device, GpuError, Queue, Residency, Step};
use crate::math::index_u32;

/// Where VDF keeps what it draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Transfer {
    /// In host memory, as written: every draw pulls 64 bytes a visible leaf.
    Host,
    /// Vertices on the device; the list of records is sent whole when it changes.
    Indices,
}

impl Transfer {
    /// Where vertices and list lie.
    fn residency(self) -> Residency {
        match self {
            Self::Host => Residency::Host,
            Self::Indices => Residency::Device,
        }
    }
}

/// VDF.
///
/// Host memory: the vertices (for `Host`), then 28 bytes a leaf, old or new. Device memory for
/// `Indices`: the vertices once; room for a record of every original leaf and draw arguments for each
/// instance.
#[derive(Debug, Clone)]
pub(super) struct Vdf {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    transfer: Transfer,
    links: Arc<Vec<Links>>,
}

/// Where a leaf stands in its tree; [`NONE`] for no leaf.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Links {
    parent: u32,
    children: [u32; 2],
}

const NONE: u32 = u32::MAX;

impl Vdf {
    pub(super) fn new(crown: Arc<Crown>, transfer: Transfer, options: ModelOptions) -> Self {
        let sequence = crown.sequence();
        let alone = Links {
            parent: NONE,
            children: [NONE; 2],
        };
        let mut links = vec![alone; sequence.record_count() as usize];
        for (op, collapse) in (0..).zip(sequence.collapses()) {
            let new = sequence.new_leaf(op);
            links[new as usize].children = collapse.old;
            for old in collapse.old {
                links[old as usize].parent = new;
            }
        }
        Self {
            transfer,
            leaves: LeafBytes::new(&crown, options.format),
            links: Arc::new(links),
            crown,
        }
    }

    /// The active leaves of a state, in the order of the list.
    fn active(crown: &Crown, links: &[Links], state: &State) -> Vec<u32> {
        let mut visible = vec![false; links.len()];
        for leaf in state.visible(crown.clusters()) {
            visible[leaf as usize] = true;
        }
        let mut active = Vec::new();
        for cluster in &crown.clusters().clusters {
            let root = cluster
                .records
                .last()
                .expect("a cluster has at least its root")
                .leaf;
            let mut pending = vec![root];
            while let Some(leaf) = pending.pop() {
                if visible[leaf as usize] {
                    active.push(leaf);
                } else {
                    let [first, second] = links[leaf as usize].children;
                    pending.extend([second, first]);
                }
            }
        }
        active
    }
}

impl Model for Vdf {
    fn kind(&self) -> Kind {
        match self.transfer {
            Transfer::Host => Kind::VdfHost,
            Transfer::Indices => Kind::VdfIndices,
        }
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        Self::active(&self.crown, &self.links, state)
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let residency = self.transfer.residency();
        let parts = (&*self.crown, &self.leaves);
        Uploaded::send(device, environment, self.clone(), parts, residency)
    }

    fn host_bytes(&self) -> Vec<u8> {
        let mut bytes = match self.transfer {
            Transfer::Host => self.leaves.vertices(),
            Transfer::Indices => Vec::new(),
        };
        for (leaf, links) in (0..).zip(self.links.iter()) {
            bytes.extend(self.crown.record_bytes(leaf));
            let words = [links.parent, links.children[0], links.children[1]];
            bytes.extend(words.into_iter().flat_map(u32::to_le_bytes));
        }
        bytes
    }

    fn storage(&self) -> Storage {
        let (vertices, keys) = (self.leaves.vertex_size(), self.leaves.key_size());
        let records = u64::from(self.crown.sequence().record_count());
        let leaves = 28 * records;
        let list = LeafList::size(&self.crown, &self.leaves);
        let state = 4 + 4 * u64::from(self.crown.sequence().root_count());
        let links = 8 * (records + 1);
        match self.transfer {
            Transfer::Host => Storage {
                host_bytes: vertices + leaves,
                shared_bytes: keys,
                instance_bytes: 0,
                instance_host_bytes: state + links + list,
            },
            Transfer::Indices => Storage {
                host_bytes: leaves,
                shared_bytes: vertices + keys,
                instance_bytes: list,
                instance_host_bytes: state + links,
            },
        }
    }
}

impl Shared for Uploaded<Vdf> {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let (model, surface) = (&self.model, &self.surface);
        let active = Vdf::active(&model.crown, &model.links, state);
        let residency = model.transfer.residency();
        Ok(Box::new(VdfResident {
            list: LeafList::create(
                device,
                (&model.crown, &model.leaves),
                surface,
                residency,
                number,
                &active,
            )?,
            active: ActiveList::of(&active, model.links.len()),
            model: model.clone(),
            state: state.clone(),
        }))
    }
}

#[derive(Debug)]
struct VdfResident {
    model: Vdf,
    list: LeafList,
    active: ActiveList,
    state: State,
}

impl Resident for VdfResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let Vdf {
            crown,
            leaves,
            links,
            ..
        } = &self.model;
        let clusters = crown.clusters();
        // The criterion is evaluated for every active leaf, whatever changes.
        let mut change = Change {
            host_records: self.active.len() as u64,
            ..Change::default()
        };
        let counts = self
            .state
            .counts(clusters)
            .into_iter()
            .zip(to.counts(clusters));
        for (cluster, (before, after)) in clusters.clusters.iter().zip(counts) {
            let new_leaf = |op: u32| crown.sequence().new_leaf(cluster.ops[op as usize]);
            for op in before..after {
                self.active.collapse(links, new_leaf(op));
            }
            for op in (after..before).rev() {
                self.active.split(links, new_leaf(op));
            }
            change.collapses += after.saturating_sub(before);
            change.splits += before.saturating_sub(after);
            change.clusters_touched += u32::from(before != after);
        }
        // Three links are read or written for each leaf that comes or goes.
        change.host_records += 9 * u64::from(change.collapses + change.splits);
        if change.clusters_touched > 0 {
            let active: Vec<u32> = self.active.iter().collect();
            self.list.write(queue, (crown, leaves), &active)?;
        }
        self.state = to.clone();
        Ok(change)
    }

    fn price(&self, to: &State) -> u64 {
        let Vdf { crown, leaves, .. } = &self.model;
        let clusters = crown.clusters();
        match self.model.transfer {
            Transfer::Indices if self.state.counts(clusters) != to.counts(clusters) => {
                LeafList::price(crown, leaves, to.leaf_count(clusters))
            }
            Transfer::Indices | Transfer::Host => 0,
        }
    }

    /// The list is sent whole, whatever changes.
    fn cluster_price(&self, _cluster: u32, _collapses: u32) -> Option<u64> {
        match self.model.transfer {
            Transfer::Indices => None,
            Transfer::Host => Some(0),
        }
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.list.steps);
    }

    fn host_bytes(&self) -> u64 {
        let links = self.active.next.len() + self.active.previous.len();
        self.state.host_bytes() + 4 * links as u64 + self.list.host_bytes
    }
}

/// The ordered list of active leaves, doubly linked.
#[derive(Debug, Clone)]
struct ActiveList {
    /// The next leaf of each, the first at the place behind the last leaf.
    next: Vec<u32>,
    previous: Vec<u32>,
    len: usize,
}

impl ActiveList {
    fn of(active: &[u32], leaf_count: usize) -> Self {
        let end = index_u32(leaf_count);
        let mut list = Self {
            next: vec![NONE; leaf_count + 1],
            previous: vec![NONE; leaf_count + 1],
            len: 0,
        };
        let ring: Vec<u32> = [end].iter().chain(active).copied().collect();
        for (place, &leaf) in ring.iter().enumerate() {
            list.link(leaf, ring[(place + 1) % ring.len()]);
        }
        list.len = active.len();
        list
    }

    fn len(&self) -> usize {
        self.len
    }

    fn link(&mut self, first: u32, second: u32) {
        self.next[first as usize] = second;
        self.previous[second as usize] = first;
    }

    /// Replaces the two children of `new`, which stand side by side, by `new`.
    fn collapse(&mut self, links: &[Links], new: u32) {
        let [first, second] = links[new as usize].children;
        let (before, after) = (self.previous[first as usize], self.next[second as usize]);
        self.link(before, new);
        self.link(new, after);
        self.len -= 1;
    }

    /// Replaces `new` by its two children.
    fn split(&mut self, links: &[Links], new: u32) {
        let [first, second] = links[new as usize].children;
        let (before, after) = (self.previous[new as usize], self.next[new as usize]);
        self.link(before, first);
        self.link(first, second);
        self.link(second, after);
        self.len += 1;
    }

    fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        let end = index_u32(self.next.len() - 1);
        let first = self.next[end as usize];
        std::iter::successors(Some(first), |&leaf| Some(self.next[leaf as usize]))
            .take_while(move |&leaf| leaf != end)
    }
}
