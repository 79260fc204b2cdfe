//! What crosses the bus, in closed form from the list of collapses alone: nothing here asks the
//! library which leaves a state shows, or where they lie.

use std::collections::BTreeMap;

use spinney::gpu::{Ledger, Share, Stream};
use spinney::math::index_u32;
use spinney::models::{Crown, Kind, LeafFormat, Records, State, Vertices};

/// The trees of a forest of collapses, by their least original leaf.
pub(crate) struct Forest {
    pub(crate) trees: Vec<Tree>,
    /// How many leaves there are at first (`L`).
    pub(crate) originals: u64,
    /// How many collapses (`C`).
    pub(crate) collapses: u64,
}

/// One tree: its original leaves, ascending, and its collapses in order.
pub(crate) struct Tree {
    originals: Vec<u32>,
    steps: Vec<Step>,
}

#[derive(Clone, Copy)]
struct Step {
    op: u32,
    old: [u32; 2],
    new: u32,
}

impl Forest {
    pub(crate) fn of(crown: &Crown) -> Self {
        let sequence = crown.sequence();
        let originals = sequence.original_count();
        let alone = |leaf| Tree {
            originals: vec![leaf],
            steps: Vec::new(),
        };
        let mut growing: BTreeMap<u32, Tree> =
            (0..originals).map(|leaf| (leaf, alone(leaf))).collect();
        for (op, collapse) in (0..).zip(sequence.collapses()) {
            let [mut first, second] = collapse
                .old
                .map(|leaf| growing.remove(&leaf).expect("both stand"));
            let (old, new) = (collapse.old, originals + op);
            first.originals.extend(second.originals);
            first.steps.extend(second.steps);
            first.steps.push(Step { op, old, new });
            growing.insert(new, first);
        }
        let mut trees: Vec<Tree> = growing.into_values().collect();
        for tree in &mut trees {
            tree.originals.sort_unstable();
            tree.steps.sort_by_key(|step| step.op);
        }
        trees.sort_by_key(|tree| tree.originals[0]);
        Self {
            trees,
            originals: u64::from(originals),
            collapses: sequence.collapses().len() as u64,
        }
    }

    /// The collapses done in each tree.
    pub(crate) fn counts(&self, state: &State) -> Vec<usize> {
        match state {
            State::Uniform { collapses } => {
                let done = |tree: &Tree| tree.steps.iter().filter(|s| s.op < *collapses).count();
                self.trees.iter().map(done).collect()
            }
            State::Variable { counts } => counts.iter().map(|&count| count as usize).collect(),
            State::Cards(_) | State::Strokes(_) => vec![0; self.trees.len()],
        }
    }

    /// How many leaves show.
    pub(crate) fn visible(&self, state: &State) -> u64 {
        self.originals - self.counts(state).iter().sum::<usize>() as u64
    }

    /// What a cluster's threshold holds in a variable state: one more than the number of the last
    /// collapse done there.
    fn thresholds(&self, state: &State) -> Vec<u32> {
        let threshold = |(tree, count): (&Tree, usize)| {
            count
                .checked_sub(1)
                .map_or(0, |last| tree.steps[last].op + 1)
        };
        self.trees
            .iter()
            .zip(self.counts(state))
            .map(threshold)
            .collect()
    }
}

impl Tree {
    fn visible(&self, collapses: usize) -> u64 {
        (self.originals.len() - collapses) as u64
    }

    /// The block after some collapses: each puts the new leaf into old1's slot, then the last
    /// visible slot's leaf into old2's; the slot that falls dead keeps what it held.
    fn slots(&self, collapses: usize) -> Vec<u32> {
        let mut block = self.originals.clone();
        for (done, step) in self.steps[..collapses].iter().enumerate() {
            let last = block.len() - done - 1;
            let [first, second] = step.old.map(|leaf| {
                let found = block[..=last].iter().position(|&held| held == leaf);
                found.expect("an operand shows until it is consumed")
            });
            let dying = block[last];
            block[first] = step.new;
            block[second] = block[last];
            block[last] = dying;
        }
        block
    }

    /// In how many slots the blocks of two states differ.
    fn slots_changed(&self, from: usize, to: usize) -> usize {
        let (before, after) = (self.slots(from), self.slots(to));
        before.iter().zip(&after).filter(|(a, b)| a != b).count()
    }
}

/// A transfer: cause, its number, label, bytes.
pub(crate) type Sent = (&'static str, Option<u32>, &'static str, u64);

/// An instance of a model as far as the bus can tell.
pub(crate) struct Expected<'f> {
    forest: &'f Forest,
    kind: Kind,
    compact: bool,
    quantised: bool,
    state: State,
    /// What the device of `stamps` holds.
    counter: u32,
    thresholds: Vec<u32>,
}

/// Cards have contracts of their own.
const LEAVES_ONLY: &str = "only kinds that show leaves are asked";

impl<'f> Expected<'f> {
    pub(crate) fn at(forest: &'f Forest, kind: Kind, format: LeafFormat, state: &State) -> Self {
        let (counter, thresholds) = match state {
            State::Cards(_) | State::Strokes(_) => (0, vec![0; forest.trees.len()]),
            State::Uniform { collapses } => (*collapses, vec![0; forest.trees.len()]),
            State::Variable { .. } => (u32::MAX, thresholds_of(forest, kind, state)),
        };
        Self {
            forest,
            kind,
            // What has no records has none to make smaller.
            compact: format.records == Records::Compact && kind != Kind::Full,
            quantised: format.vertices == Vertices::Quantised,
            state: state.clone(),
            counter,
            thresholds,
        }
    }

    /// What an instance and what it shares send at first, without textures and materials.
    pub(crate) fn initial(&self) -> Vec<Sent> {
        let Forest {
            originals,
            collapses,
            trees,
        } = self.forest;
        let (roots, visible) = (trees.len() as u64, self.forest.visible(&self.state));
        let (record, argument) = (self.record(), self.argument());
        let records = |label, bytes| ("records", None, label, bytes);
        let mut sent = match self.kind {
            Kind::Full | Kind::VdfHost | Kind::LodfHost => Vec::new(),
            Kind::VdfIndices => vec![
                records("leaf list", record * visible),
                records("draw arguments", argument * self.lists()),
            ],
            Kind::LodfCluster | Kind::LodfSlots | Kind::LodfLiteral => vec![
                records("leaf records", record * originals),
                records("draw arguments", argument * roots),
            ],
            Kind::LodfStamps => vec![
                records("stamped records", (record + 8) * (originals + collapses)),
                records("counter", 4),
                records("thresholds", 4 * roots),
            ],
            Kind::LodfDevice if self.compact => vec![
                records("collapse operands", 8 * collapses),
                records("collapse masks", 4 * collapses.div_ceil(8)),
                records("crown", 4 * (8 + 8 * roots + collapses)),
                records("detail", 8 + 4 * roots),
            ],
            Kind::LodfDevice => vec![
                records("windowed records", (record + 8) * (originals + collapses)),
                records("crown", 4 * (8 + 8 * roots + collapses)),
                records("detail", 8 + 4 * roots),
            ],
            _ => unreachable!("{LEAVES_ONLY}"),
        };
        if self.compact && matches!(self.kind, Kind::LodfStamps | Kind::LodfDevice) {
            sent.push(records("first vertices", 4 * roots));
        }
        let mut vertices = |label, bytes| sent.push(("vertices", None, label, bytes));
        if !self.on_host() {
            vertices("leaf vertices", self.vertex() * 4 * originals);
        }
        if self.compact {
            vertices("leaf numbers", 4 * originals);
        }
        if self.quantised {
            vertices("vertex grid", 24);
        }
        sent.retain(|(.., bytes)| *bytes > 0);
        sent
    }

    /// Bytes of a leaf record.
    fn record(&self) -> u64 {
        if self.compact { 8 } else { 16 }
    }

    /// Bytes of the arguments of a draw: short indices have their first vertex there.
    fn argument(&self) -> u64 {
        if self.compact { 20 } else { 16 }
    }

    /// Bytes of a vertex.
    fn vertex(&self) -> u64 {
        if self.quantised { 8 } else { 12 }
    }

    /// How many draws a list is: compact ones count in their cluster.
    fn lists(&self) -> u64 {
        if self.compact {
            self.forest.trees.len() as u64
        } else {
            1
        }
    }

    fn on_host(&self) -> bool {
        matches!(self.kind, Kind::VdfHost | Kind::LodfHost)
    }

    /// What going over to another state sends, a range an entry.
    pub(crate) fn commit(&mut self, to: &State) -> Vec<Sent> {
        let (before, after) = (self.forest.counts(&self.state), self.forest.counts(to));
        let same = before == after;
        self.state = to.clone();
        let trees = (0..)
            .zip(&self.forest.trees)
            .zip(before.into_iter().zip(after));
        let changed = trees.filter(|(_, (before, after))| before != after);
        let draw_count = |id| ("draw-count", Some(id), "draw arguments", 4);
        let record = self.record();
        match self.kind {
            Kind::Full | Kind::VdfHost | Kind::LodfHost | Kind::LodfLiteral => Vec::new(),
            Kind::VdfIndices if same => Vec::new(),
            Kind::VdfIndices => vec![
                (
                    "index-list",
                    None,
                    "leaf list",
                    record * self.forest.visible(to),
                ),
                // Of one list its length alone.
                (
                    "draw-count",
                    None,
                    "draw arguments",
                    if self.compact { 20 * self.lists() } else { 4 },
                ),
            ],
            Kind::LodfCluster => changed
                .flat_map(|((id, tree), (_, after))| {
                    let bytes = record * tree.visible(after);
                    [("cluster", Some(id), "leaf records", bytes), draw_count(id)]
                })
                .collect(),
            Kind::LodfSlots => changed
                .flat_map(|((id, tree), (before, after))| {
                    let slots = tree.slots_changed(before, after);
                    assert!(slots <= 2 * before.abs_diff(after), "two a step at most");
                    let slot = ("slot", Some(id), "leaf records", record);
                    std::iter::repeat_n(slot, slots).chain([draw_count(id)])
                })
                .collect(),
            Kind::LodfStamps => self.stamps(to, "counter", "thresholds"),
            // Dictated states, counts in place of stamps; by the camera nothing is sent.
            Kind::LodfDevice => self.stamps(to, "detail", "detail"),
            _ => unreachable!("{LEAVES_ONLY}"),
        }
    }

    fn stamps(
        &mut self,
        to: &State,
        counters: &'static str,
        thresholds: &'static str,
    ) -> Vec<Sent> {
        let mut sent = Vec::new();
        let counter = match to {
            State::Uniform { collapses } => *collapses,
            State::Cards(_) | State::Strokes(_) => 0,
            State::Variable { .. } => {
                let wanted = thresholds_of(self.forest, self.kind, to);
                let held = std::mem::replace(&mut self.thresholds, wanted);
                let pairs = (0..).zip(held.iter().zip(&self.thresholds));
                let differing = pairs.filter(|(_, (held, wanted))| held != wanted);
                sent.extend(differing.map(|(id, _)| ("threshold", Some(id), thresholds, 4)));
                u32::MAX
            }
        };
        if std::mem::replace(&mut self.counter, counter) != counter {
            sent.push(("counter", None, counters, 4));
        }
        sent
    }

    /// What one draw pulls from the host.
    pub(crate) fn fetched(&self) -> Vec<Sent> {
        let visible = self.forest.visible(&self.state);
        if self.on_host() {
            vec![
                ("draw", None, "leaf list", self.record() * visible),
                ("draw", None, "leaf vertices", 4 * self.vertex() * visible),
            ]
        } else {
            Vec::new()
        }
    }

    /// How many draws there are, and how many vertices they look at.
    pub(crate) fn draws_and_vertices(&self) -> (u64, u64) {
        let visible = self.forest.visible(&self.state);
        let roots = self.forest.trees.len() as u64;
        let all = self.forest.originals + self.forest.collapses;
        match (self.kind, &self.state) {
            (Kind::Full, _) => (1, 4 * self.forest.originals),
            (Kind::LodfCluster | Kind::LodfSlots | Kind::LodfLiteral, _) => (roots, 4 * visible),
            (Kind::LodfStamps, State::Uniform { collapses }) => {
                let window = 4 * (all - 2 * u64::from(*collapses));
                assert!(window < 2 * 4 * visible, "fewer than twice the visible");
                (1, window)
            }
            (Kind::LodfStamps, State::Variable { .. } | State::Cards(_) | State::Strokes(_)) => {
                (1, 4 * all)
            }
            // A window a cluster, whatever the state.
            (Kind::LodfDevice, _) => {
                let collapses = self.forest.originals - visible;
                let windows = 4 * (all - 2 * collapses);
                assert!(windows < 2 * 4 * visible, "fewer than twice the visible");
                (roots, windows)
            }
            (Kind::VdfHost | Kind::VdfIndices | Kind::LodfHost, _) => (self.lists(), 4 * visible),
            _ => unreachable!("{LEAVES_ONLY}"),
        }
    }

    /// Bytes of the command stream of the first uploads: what is expanded is a compute pass of a
    /// program, five buffers and a dispatch.
    pub(crate) fn initial_command_bytes(&self) -> u64 {
        if self.compact && self.kind == Kind::LodfDevice {
            8 * (1 + 5) + 16
        } else {
            0
        }
    }

    /// Bytes of the command stream of a pass that draws one instance: the pass, what is bound
    /// (program, view, placements, materials, textures, then what the kind needs), the draws.
    pub(crate) fn command_bytes(&self, textures: u64) -> u64 {
        let (bound, draws) = match self.kind {
            Kind::Full => (1, 20),
            Kind::VdfHost | Kind::LodfHost => (2, 20 * self.lists()),
            Kind::VdfIndices => (2, 8 * self.lists()),
            Kind::LodfCluster | Kind::LodfSlots | Kind::LodfLiteral => {
                (2, 8 * self.forest.trees.len() as u64)
            }
            Kind::LodfStamps => (4 + u64::from(self.compact), 20),
            // One command for all clusters; before it a compute pass: program, seven buffers, dispatch.
            Kind::LodfDevice => (4 + u64::from(self.compact), 20 + 8 * (1 + 7) + 16),
            _ => unreachable!("{LEAVES_ONLY}"),
        };
        let bound = bound + u64::from(self.compact) + u64::from(self.quantised);
        24 + 8 * (4 + textures + bound) + draws
    }
}

/// What the device holds of each cluster in a variable state: the stamp of its last collapse, or how
/// many are done.
fn thresholds_of(forest: &Forest, kind: Kind, state: &State) -> Vec<u32> {
    if kind == Kind::LodfDevice {
        let counts = forest.counts(state).into_iter();
        counts.map(index_u32).collect()
    } else {
        forest.thresholds(state)
    }
}

/// The transfers of a stream as a ledger has them, in an order of their own.
pub(crate) fn transfers(ledger: &Ledger, stream: Stream) -> Vec<(&str, Option<u32>, &str, u64)> {
    let listed = ledger.transfers.iter().filter(|t| t.stream == stream);
    let mut list: Vec<_> = listed
        .map(|t| (t.cause.kind, t.cause.id, &*t.resource, t.payload_bytes))
        .collect();
    list.sort_unstable();
    list
}

/// The bytes by cause.
pub(crate) fn by_cause<'s>(
    sent: impl IntoIterator<Item = &'s Sent>,
) -> BTreeMap<&'static str, Share> {
    let mut shares = BTreeMap::<_, Share>::new();
    for (cause, _, _, bytes) in sent {
        let share = shares.entry(*cause).or_default();
        share.transfers += 1;
        share.payload_bytes += bytes;
    }
    shares
}
