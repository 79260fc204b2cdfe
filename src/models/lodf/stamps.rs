//! LoDF with stamped records: everything is on the device from the start, and a change of level
//! sends how far the sequence has gone.
//!
//! Records lie in the global order of consumption: the operands of collapse `k` (from 1) at
//! `2 k − 2` and `2 k − 1`, the roots at the end. After `c` collapses those before `2 c` are gone, so
//! the device draws the window `2 c ..` and the vertex stage leaves out what is born later than `c`.
//! It looks at `L + C − 2 c` records to show `L − c`: always fewer than twice as many.
//!
//! Where every cluster has a number of its own, the counter says so (`u32::MAX`), everything is
//! looked at, and a leaf shows if its cluster's threshold, the stamp of the last collapse done
//! there, lies between its birth and its death.

use std::sync::Arc;

use super::super::format::LeafBytes;
use super::super::leaf::{
    COUNTER_SLOT, FIRST_VERTEX_SLOT, LeafSource, RECORD_SLOT, THRESHOLD_SLOT, VARIABLE,
    VERTEX_SLOT, stamped_words,
};
use super::super::surface::{LEAF_GROUP, Surface, Uploaded, filled};
use super::super::{
    Change, Crown, Environment, Kind, Model, ModelOptions, Resident, Shared, State, Storage,
};
use super::slots::send;
use super::{Gather, first_vertex_bytes, host_bytes, host_size, instance_host_size};
use crate::gpu::{
    BufferId, Cause, Corners, Device, DrawFromCounter, GpuError, Queue, Region, Residency, Step,
    Usage,
};
use crate::math::index_u32;
use crate::simplify::Clusters;

/// Why what an instance or the model begins with is sent.
const RECORDS: Cause = Cause::of("records");

/// LoDF with stamps.
///
/// Host memory: the structures of [`host_bytes`]. Device memory: the vertices, and for each leaf, old or
/// new, its record with its birth and cluster (24 bytes; 16 with a compact record, and then the first
/// vertex of each cluster, 4 bytes), once; a counter and a threshold a cluster (4 bytes each) for each
/// instance.
#[derive(Debug, Clone)]
pub(in super::super) struct Stamps {
    crown: Arc<Crown>,
    leaves: LeafBytes,
    gather: Gather,
}

impl Stamps {
    pub(in super::super) fn new(crown: Arc<Crown>, options: ModelOptions) -> Self {
        Self {
            leaves: LeafBytes::new(&crown, options.format),
            crown,
            gather: options.gather,
        }
    }

    /// All leaves in the order of their records.
    fn order(&self) -> Vec<u32> {
        let sequence = self.crown.sequence();
        let operands = sequence
            .collapses()
            .iter()
            .flat_map(|collapse| collapse.old);
        let roots = self.crown.clusters().clusters.iter().map(|cluster| {
            cluster
                .records
                .last()
                .expect("a cluster has at least its root")
                .leaf
        });
        operands.chain(roots).collect()
    }

    fn record_bytes(&self) -> Vec<u8> {
        let originals = self.crown.sequence().original_count();
        let cluster = &self.crown.clusters().cluster_of_leaf;
        let mut bytes = Vec::new();
        for leaf in self.order() {
            self.leaves.push_record(leaf, &mut bytes);
            let birth = (leaf + 1).saturating_sub(originals);
            bytes.extend(birth.to_le_bytes());
            bytes.extend(cluster[leaf as usize].to_le_bytes());
        }
        bytes
    }
}

impl Model for Stamps {
    fn kind(&self) -> Kind {
        Kind::LodfStamps
    }

    fn crown(&self) -> &Arc<Crown> {
        &self.crown
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        let mut shown = vec![false; self.crown.sequence().record_count() as usize];
        for leaf in state.visible(self.crown.clusters()) {
            shown[leaf as usize] = true;
        }
        self.order()
            .into_iter()
            .filter(|&leaf| shown[leaf as usize])
            .collect()
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        let (crown, leaves) = (&self.crown, &self.leaves);
        let surface = Surface::upload(device, environment, crown, leaves, Residency::Device)?;
        let bytes = self.record_bytes();
        let records = filled(device, "stamped records", Usage::STORAGE, &bytes, RECORDS)?;
        let mut pulled = vec![(VERTEX_SLOT, surface.vertices), (RECORD_SLOT, records)];
        if let Some(bytes) = first_vertex_bytes(crown, leaves) {
            let buffer = filled(device, "first vertices", Usage::STORAGE, &bytes, RECORDS)?;
            pulled.push((FIRST_VERTEX_SLOT, buffer));
        }
        let model = self.clone();
        Ok(Box::new(StampsShared {
            uploaded: Uploaded { model, surface },
            pulled,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        host_bytes(&self.crown)
    }

    fn storage(&self) -> Storage {
        let record_bytes = 4 * stamped_words(self.leaves.format) as u64;
        let first_vertices =
            first_vertex_bytes(&self.crown, &self.leaves).map_or(0, |bytes| bytes.len() as u64);
        Storage {
            host_bytes: host_size(&self.crown),
            shared_bytes: self.leaves.vertex_size()
                + self.leaves.key_size()
                + first_vertices
                + record_bytes * u64::from(self.crown.sequence().record_count()),
            instance_bytes: 4 + 4 * u64::from(self.crown.sequence().root_count()),
            instance_host_bytes: instance_host_size(&self.crown),
        }
    }
}

#[derive(Debug)]
struct StampsShared {
    uploaded: Uploaded<Stamps>,
    /// What the vertex stage pulls, by slot.
    pulled: Vec<(u32, BufferId)>,
}

impl Shared for StampsShared {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let Uploaded { model, surface } = &self.uploaded;
        let clusters = model.crown.clusters();
        let thresholds_words = match state {
            State::Uniform { .. } | State::Cards(_) | State::Strokes(_) => {
                vec![0; clusters.clusters.len()]
            }
            State::Variable { counts } => thresholds(clusters, counts),
        };
        let mut buffer = |label, words: &[u32], usage| {
            let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            filled(device, label, usage, &bytes, RECORDS)
        };
        let counter = buffer(
            "counter",
            &[counter_word(state)],
            Usage::STORAGE | Usage::INDIRECT,
        )?;
        let threshold_buffer = buffer("thresholds", &thresholds_words, Usage::STORAGE)?;
        let mut steps = Vec::new();
        surface.bind(LeafSource::Stamped, &mut steps);
        let own = [(COUNTER_SLOT, counter), (THRESHOLD_SLOT, threshold_buffer)];
        for (slot, buffer) in self.pulled.iter().copied().chain(own) {
            steps.push(Step::Storage { slot, buffer });
        }
        steps.push(Step::DrawFromCounter(DrawFromCounter {
            source: Corners::Counted,
            counter,
            offset: 0,
            scale: 8,
            end: 4 * model.crown.sequence().record_count(),
            instance: number,
            group: LEAF_GROUP,
        }));
        Ok(Box::new(StampsResident {
            model: model.clone(),
            counter,
            threshold_buffer,
            steps,
            state: state.clone(),
            stale: match state {
                State::Uniform { .. } | State::Cards(_) | State::Strokes(_) => thresholds_words,
                State::Variable { .. } => Vec::new(),
            },
        }))
    }
}

/// What the counter says in a state.
fn counter_word(state: &State) -> u32 {
    match state {
        State::Uniform { collapses } => *collapses,
        State::Variable { .. } => VARIABLE,
        State::Cards(_) | State::Strokes(_) => 0,
    }
}

/// The stamp of the last collapse done in each cluster, 0 for none.
fn thresholds(clusters: &Clusters, counts: &[u32]) -> Vec<u32> {
    let stamp = |(cluster, &count): (&crate::simplify::Cluster, &u32)| {
        count
            .checked_sub(1)
            .map_or(0, |last| cluster.ops[last as usize] + 1)
    };
    clusters.clusters.iter().zip(counts).map(stamp).collect()
}

#[derive(Debug)]
struct StampsResident {
    model: Stamps,
    counter: BufferId,
    threshold_buffer: BufferId,
    steps: Vec<Step>,
    state: State,
    /// The thresholds on the device while a uniform state does not read them; those of a variable
    /// state follow from it.
    stale: Vec<u32>,
}

impl Resident for StampsResident {
    fn state(&self) -> &State {
        &self.state
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let crown = Arc::clone(&self.model.crown);
        let clusters = crown.clusters();
        let change = self.state.change_to(to, clusters);
        let mut words: Vec<(BufferId, u64, [u8; 4], Cause)> = Vec::new();
        let held = match &self.state {
            State::Uniform { .. } | State::Cards(_) | State::Strokes(_) => {
                std::mem::take(&mut self.stale)
            }
            State::Variable { counts } => thresholds(clusters, counts),
        };
        if let State::Variable { counts } = to {
            let wanted = thresholds(clusters, counts);
            for (cluster, (word, held)) in wanted.iter().zip(&held).enumerate() {
                if word != held {
                    let cause = Cause::numbered("threshold", index_u32(cluster));
                    let bytes = word.to_le_bytes();
                    words.push((self.threshold_buffer, 4 * cluster as u64, bytes, cause));
                }
            }
        } else {
            self.stale = held;
        }
        let wanted = counter_word(to);
        if wanted != counter_word(&self.state) {
            words.push((self.counter, 0, wanted.to_le_bytes(), Cause::of("counter")));
        }
        let regions: Vec<Region<'_>> = words
            .iter()
            .map(|(buffer, offset, bytes, cause)| Region {
                buffer: *buffer,
                offset: *offset,
                bytes,
                cause: *cause,
            })
            .collect();
        send(queue, self.model.gather, &regions)?;
        self.state = to.clone();
        Ok(Change {
            host_records: words.len() as u64,
            ..change
        })
    }

    fn price(&self, to: &State) -> u64 {
        let clusters = self.model.crown.clusters();
        let differ = |wanted: Vec<u32>, held: &[u32]| {
            wanted.iter().zip(held).filter(|(a, b)| a != b).count() as u64
        };
        let changed = match (to, &self.state) {
            (State::Uniform { .. } | State::Cards(_) | State::Strokes(_), _) => 0,
            (
                State::Variable { counts },
                State::Uniform { .. } | State::Cards(_) | State::Strokes(_),
            ) => differ(thresholds(clusters, counts), &self.stale),
            (State::Variable { counts }, State::Variable { counts: present }) => {
                differ(thresholds(clusters, counts), &thresholds(clusters, present))
            }
        };
        4 * (u64::from(counter_word(to) != counter_word(&self.state)) + changed)
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        match &self.state {
            State::Uniform { .. } | State::Cards(_) | State::Strokes(_) => None,
            State::Variable { counts } => {
                Some(4 * u64::from(counts[cluster as usize] != collapses))
            }
        }
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }

    fn host_bytes(&self) -> u64 {
        self.state.host_bytes() + 4 * self.stale.len() as u64
    }
}
