//! Walking the axis of detail: every model from full detail to the coarsest in equal steps.

use super::RunError;
use super::frame::Frame;
use super::options::SessionOptions;
use super::progress::Progress;
use super::selector::Selector;
use super::session::Session;
use super::shard::{Shard, exact};
use super::world::World;
use crate::gpu::{Card, Ledger, Link, Stream, Ticks, Traffic};
use crate::math::Digest;
use crate::models::{
    Change, Gather, Kind, LeafFormat, ModelOptions, Occlusion, Records, State, TreeState,
    TrunkKind, TrunkLevel, Vertices,
};
use crate::scene::{ImageSize, Scene, Simplifier};
use crate::simplify::measure_leaves;

/// A model with the choices that change what it sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Variant {
    /// The model and mode.
    pub kind: Kind,
    /// Whether leaves are pruned, whatever the scene says; else they are simplified as it says.
    pub pruned: bool,
    /// Whether several ranges go in one transfer.
    pub gathered: bool,
    /// How leaves look as bytes.
    pub format: LeafFormat,
    /// What the device leaves out by itself.
    pub occlusion: Occlusion,
    /// The model and mode of trunks; without it that of the scene.
    pub trunk: Option<TrunkKind>,
}

/// As its label.
impl serde::Serialize for Variant {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(&self.label())
    }
}

impl<'de> serde::Deserialize<'de> for Variant {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let label = String::deserialize(from)?;
        let unknown = || serde::de::Error::custom(format!("no model is called {label:?}"));
        Self::labelled(&label).ok_or_else(unknown)
    }
}

impl Variant {
    /// Every sound model and mode, slots both ways; the papers' mode, slots and stamps also with
    /// records of 8 bytes; and those that need a card that computes.
    pub const ALL: [Self; 13] = [
        Self::usual(Kind::Full),
        Self::usual(Kind::VdfHost),
        Self::usual(Kind::VdfIndices),
        Self::usual(Kind::LodfHost),
        Self::usual(Kind::LodfCluster),
        Self::usual(Kind::LodfSlots),
        Self::usual(Kind::LodfSlots).gathered(),
        Self::usual(Kind::LodfStamps),
        Self::usual(Kind::LodfCluster).compact(),
        Self::usual(Kind::LodfSlots).compact().gathered(),
        Self::usual(Kind::LodfStamps).compact(),
        Self::usual(Kind::LodfDevice),
        Self::usual(Kind::LodfDevice).compact(),
    ];

    /// A kind as its papers have it.
    #[must_use]
    pub const fn usual(kind: Kind) -> Self {
        Self {
            kind,
            pruned: false,
            gathered: false,
            format: LeafFormat::WIDE,
            occlusion: Occlusion::None,
            trunk: None,
        }
    }

    /// The same with pruned leaves.
    #[must_use]
    pub const fn pruned(self) -> Self {
        Self {
            pruned: true,
            ..self
        }
    }

    /// The same with several ranges in one transfer.
    #[must_use]
    pub const fn gathered(self) -> Self {
        Self {
            gathered: true,
            ..self
        }
    }

    /// The same with compact records.
    #[must_use]
    pub const fn compact(self) -> Self {
        let format = LeafFormat {
            records: Records::Compact,
            vertices: self.format.vertices,
        };
        Self { format, ..self }
    }

    /// How a session walks it; what the variant leaves open is as in `usual`.
    #[must_use]
    pub fn session(self, usual: &SessionOptions) -> SessionOptions {
        let gather = match self.gathered {
            true => Gather::Regions,
            false => Gather::Single,
        };
        SessionOptions {
            kind: self.kind,
            trunk: self.trunk.unwrap_or(usual.trunk),
            model: ModelOptions {
                gather,
                format: self.format,
                occlusion: self.occlusion,
                ..usual.model
            },
            ..*usual
        }
    }

    /// What a label may end in, in this order, after the kind's.
    const ENDINGS: [&'static str; 5] = ["-pruned", "-u16", "-quantised", "-occlusion", "-gathered"];

    /// Whether it can show anything but full detail, of foliage or a trunk of its own.
    #[must_use]
    pub fn has_levels(self) -> bool {
        self.kind.has_levels() || self.trunk.is_some_and(TrunkKind::has_levels)
    }

    /// Whether a card can do it.
    #[must_use]
    pub fn runs_on(self, card: Card) -> bool {
        card.computes() || !self.kind.selects()
    }

    /// The kind's label, then `-pruned` with pruned leaves, `-u16` with compact records, `-quantised` with
    /// quantised vertices, `-occlusion` where the device leaves out what is hidden, `-gathered` where ranges
    /// are gathered, and `+` and the trunk's label where there is one:
    /// `lodf-slots-gathered+lodstrips-device`.
    #[must_use]
    pub fn label(self) -> String {
        let has = [
            self.pruned,
            self.format.records == Records::Compact,
            self.format.vertices == Vertices::Quantised,
            self.occlusion == Occlusion::TwoPhase,
            self.gathered,
        ];
        let endings = Self::ENDINGS.into_iter().zip(has).filter(|(_, has)| *has);
        let foliage = endings.fold(self.kind.label(), |label, (ending, _)| label + ending);
        match self.trunk {
            None => foliage,
            Some(trunk) => format!("{foliage}+{}", trunk.label()),
        }
    }

    /// The variant with this label.
    #[must_use]
    pub fn labelled(label: &str) -> Option<Self> {
        let (mut base, trunk) = match label.split_once('+') {
            Some((foliage, trunk)) => (foliage, Some(TrunkKind::labelled(trunk)?)),
            None => (label, None),
        };
        let [gathered, occluded, quantised, compact, pruned] =
            [4, 3, 2, 1, 0].map(|ending: usize| {
                let stripped = base.strip_suffix(Self::ENDINGS[ending]);
                base = stripped.unwrap_or(base);
                stripped.is_some()
            });
        let variant = Self {
            kind: Kind::labelled(base)?,
            pruned,
            gathered,
            occlusion: if occluded {
                Occlusion::TwoPhase
            } else {
                Occlusion::None
            },
            format: LeafFormat {
                records: if compact {
                    Records::Compact
                } else {
                    Records::Wide
                },
                vertices: if quantised {
                    Vertices::Quantised
                } else {
                    Vertices::Float
                },
            },
            trunk,
        };
        variant.is_sound().then_some(variant)
    }

    /// Whether its choices mean something: only slots, stamps, dictated states and trunks on the device
    /// ever send several ranges that could be gathered, only what has records can have compact ones, only
    /// what selects on the device can leave out what is hidden there, and only what has levels shows leaves
    /// that are left. Cards are no variants: the axis of detail is one of leaves.
    #[must_use]
    pub fn is_sound(self) -> bool {
        let trunk_gathers =
            |trunk: TrunkKind| trunk.has_levels() && trunk.mode == crate::scene::TrunkMode::Device;
        let kinds = [Kind::LodfSlots, Kind::LodfStamps, Kind::LodfDevice];
        let gathers = kinds.contains(&self.kind) || self.trunk.is_some_and(trunk_gathers);
        let has_records = self.kind != Kind::Full;
        let occlusion = self.occlusion == Occlusion::None || self.kind.selects();
        (gathers || !self.gathered)
            && self.kind.shows_leaves()
            && occlusion
            && (has_records || self.format.records == Records::Wide)
            && (self.kind.has_levels() || !self.pruned)
    }
}

/// What to walk.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepOptions {
    /// The models.
    pub variants: Vec<Variant>,
    /// How many steps there are from 0 to 1, at least 1.
    pub steps: u32,
    /// Which of them are drawn and counted; the walk goes through all.
    pub shard: Shard,
    /// Device, picture and counters; the model is each variant's.
    pub session: SessionOptions,
}

/// A walk of several models.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The models, in the order asked for.
    pub models: Vec<SweepModel>,
}

/// One model's walk.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SweepModel {
    /// The model.
    pub variant: Variant,
    /// The uploads before step 0.
    pub initial: Ledger,
    /// Device memory of the model alone, by label, largest first.
    pub resident: Vec<(String, u64)>,
    /// Steps `0..=steps`, as far as they belong to the shard.
    pub steps: Vec<SweepStep>,
}

/// One step of a walk.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SweepStep {
    /// Which step.
    pub step: u32,
    /// How many there are from 0 to 1.
    pub of: u32,
    /// Leaves shown.
    pub leaves: u64,
    /// Triangles shown.
    pub triangles: u64,
    /// Of those, the trunks'.
    pub trunk_triangles: u64,
    /// What the change of detail took of the foliage.
    pub change: Change,
    /// What it took of the trunks.
    pub trunk_change: Change,
    /// What was moved and drawn.
    pub ledger: Ledger,
    /// The picture's digest.
    pub image_digest: Digest,
    /// Pixels that show a leaf.
    pub covered_pixels: u64,
    /// The summed area of the leaves shown, in square metres.
    #[serde(with = "exact")]
    pub leaf_area: f64,
    /// Leaves shown that are folded.
    pub folded_leaves: u64,
}

impl SweepStep {
    /// Where the step stands on the axis of detail: 0 is full detail, 1 the coarsest.
    #[must_use]
    pub fn level(&self) -> f64 {
        f64::from(self.step) / f64::from(self.of.max(1))
    }

    /// Modelled time of a frame: uploads, then fetches, then the card.
    #[must_use]
    pub fn frame_ticks(&self) -> Option<Ticks> {
        let bus = self.ledger.upload.ticks + self.ledger.fetch.ticks;
        Some(bus + self.ledger.gpu_ticks?)
    }
}

impl SweepModel {
    /// Sums over all steps, without the initial uploads.
    #[must_use]
    pub fn totals(&self) -> Ledger {
        let mut sum = Ledger::default();
        for step in &self.steps {
            sum.add(&step.ledger);
        }
        sum
    }

    /// What changing the detail sent over all steps: uploads but for the view.
    #[must_use]
    pub fn changes(&self) -> Traffic {
        self.traffic_on(None, Stream::Upload)
    }

    /// The traffic of one stream over all steps on another link: the same transfers, other wire
    /// bytes and times. The view's uploads are left out.
    #[must_use]
    pub fn traffic_on(&self, link: Option<Link>, stream: Stream) -> Traffic {
        let mut sum = Traffic::default();
        for step in &self.steps {
            sum.add(&traffic_on(&step.ledger, link, stream));
        }
        sum
    }
}

/// The traffic of one stream but for the view's, on the link that modelled it or on another.
pub(super) fn traffic_on(ledger: &Ledger, link: Option<Link>, stream: Stream) -> Traffic {
    let transfers = ledger.transfers.iter();
    let mut sum = Traffic::default();
    for transfer in
        transfers.filter(|transfer| transfer.stream == stream && transfer.cause.kind != "view")
    {
        let payload_bytes = transfer.payload_bytes;
        let wire_bytes = link.map_or(transfer.wire_bytes, |link| link.wire_bytes(payload_bytes));
        let ticks = link.map_or(transfer.ticks, |link| match stream {
            Stream::Upload | Stream::Fetch => link.ticks_down(payload_bytes),
            Stream::Readback => link.ticks_up(payload_bytes),
        });
        sum.add(&Traffic {
            transfers: 1,
            payload_bytes,
            wire_bytes,
            ticks,
        });
    }
    sum
}

/// Walks every model along the axis of detail, seen from the camera of frame 0. Step `i` of `N` stands at
/// `floor(i · C / N)` collapses of each tree: of the sequence, or where the scene's detail is variable
/// spread over the clusters as its criterion says; and likewise of its trunk.
///
/// # Errors
///
/// What the device refuses, above all for lack of memory.
pub fn sweep(
    scene: &Scene,
    world: &World,
    options: &SweepOptions,
    progress: &dyn Progress,
) -> Result<Sweep, RunError> {
    sweep_seen(scene, world, options, progress, |_, _| Ok(()))
}

/// Walks as [`sweep()`] does, and shows `see` every frame that is drawn, with its step and the last one.
///
/// # Errors
///
/// As [`sweep()`], and what `see` answers.
pub fn sweep_seen<E: From<RunError>>(
    scene: &Scene,
    world: &World,
    options: &SweepOptions,
    progress: &dyn Progress,
    mut see: impl FnMut([u32; 2], &Frame) -> Result<(), E>,
) -> Result<Sweep, E> {
    let mut models = Vec::new();
    // What is measured depends on the leaves alone, which all models of a simplification share.
    let foliage = (Kind::LodfCluster, TrunkKind::FULL);
    let size = options.session.size;
    let measured = |world: &World| -> Vec<(f64, u64)> {
        let measures = (0..=options.steps).map(|step| {
            let states = states_at(scene, world, size, foliage, [step, options.steps]);
            measure(world, &states)
        });
        measures.collect()
    };
    let any_pruned = options.variants.iter().any(|variant| variant.pruned);
    let pruned = any_pruned.then(|| world.simplified_by(Simplifier::Pruning));
    let pruned = pruned.as_ref().map(|world| (world, measured(world)));
    let usual = (world, measured(world));
    for &variant in &options.variants {
        progress.begin(&variant.label(), u64::from(options.steps) + 1);
        let pruned = pruned.as_ref().filter(|_| variant.pruned);
        let (world, measures) = pruned.unwrap_or(&usual);
        let walked = Walk {
            scene,
            world,
            options,
            measures,
        };
        models.push(walked.model(variant, progress, &mut see)?);
    }
    Ok(Sweep { models })
}

/// What the models of a simplification walk through.
struct Walk<'w> {
    scene: &'w Scene,
    world: &'w World,
    options: &'w SweepOptions,
    /// Area and folded leaves at each step.
    measures: &'w [(f64, u64)],
}

impl Walk<'_> {
    fn model<E: From<RunError>>(
        &self,
        variant: Variant,
        progress: &dyn Progress,
        see: &mut impl FnMut([u32; 2], &Frame) -> Result<(), E>,
    ) -> Result<SweepModel, E> {
        let Self {
            scene,
            world,
            options,
            measures,
        } = *self;
        let session_options = variant.session(&options.session);
        let finest = finest(scene);
        let mut session = Session::new(&finest, world, &session_options)?;
        let initial = session.initial().clone();
        let resident = session.device().resident_by_label();
        let mut steps = Vec::new();
        for step in 0..=options.steps {
            let kinds = (variant.kind, session_options.trunk);
            let at = [step, options.steps];
            let states = states_at(scene, world, session_options.size, kinds, at);
            let change = session.commit_states(&states)?;
            if !options.shard.draws(step) {
                session.forget(0)?;
                continue;
            }
            let frame = session.draw(0, change)?;
            see(at, &frame)?;
            let (leaf_area, folded_leaves) = match variant.kind.has_levels() {
                true => measures[step as usize],
                false => measures[0],
            };
            steps.push(SweepStep {
                step,
                of: options.steps,
                leaves: frame.leaves,
                triangles: frame.triangles,
                trunk_triangles: frame.trunk_triangles,
                change: change.foliage,
                trunk_change: change.trunk,
                ledger: frame.ledger,
                image_digest: frame.image_digest,
                covered_pixels: session.covered_pixels(),
                leaf_area,
                folded_leaves,
            });
            progress.step();
        }
        Ok(SweepModel {
            variant,
            initial,
            resident,
            steps,
        })
    }
}

/// The scene as a walk begins: at full detail, whatever the distance.
#[must_use]
pub fn finest(scene: &Scene) -> Scene {
    let mut finest = scene.clone();
    finest.model.level = Some(0.0);
    finest.model.budget_bytes = None;
    finest.model.trunk_level = Some(0.0);
    finest
}

/// What a model's trees show at a step of so many, seen from the camera of frame 0.
pub(super) fn states_at(
    scene: &Scene,
    world: &World,
    size: ImageSize,
    (kind, trunk): (Kind, TrunkKind),
    at: [u32; 2],
) -> Vec<TreeState> {
    let selector = Selector::new(kind, &scene.model);
    let view = scene.camera.at(0, size);
    let state = |tree: &super::StandingTree| {
        let crown = &world.crowns[tree.crown];
        let model = world.trunks[tree.crown].as_ref();
        let model = model.filter(|_| trunk.has_levels());
        TreeState {
            foliage: selector.at_step(crown, tree, &view, at),
            trunk: model.map_or(TrunkLevel::FINEST, |model| trunk.level(model, at[0], at[1])),
        }
    };
    world.trees.iter().map(state).collect()
}

/// Area and folded leaves over all trees.
fn measure(world: &World, states: &[TreeState]) -> (f64, u64) {
    // Trees of a plant that show the same, as all do where detail is uniform, are measured once.
    let mut last: Vec<Option<(&State, f64, u64)>> = vec![None; world.crowns.len()];
    let trees = world
        .trees
        .iter()
        .zip(states.iter().map(|state| &state.foliage));
    trees.fold((0.0, 0), |(area, folded), (tree, state)| {
        let (_, one_area, one_folded) = match last[tree.crown] {
            Some(known) if known.0 == state => known,
            _ => {
                let crown = &world.crowns[tree.crown];
                let visible = state.visible(crown.clusters());
                let measure = measure_leaves(crown.vertices(), crown.sequence(), visible);
                (state, measure.area, u64::from(measure.folded))
            }
        };
        last[tree.crown] = Some((state, one_area, one_folded));
        let scale = f64::from(tree.placement.scale);
        (area + one_area * scale * scale, folded + one_folded)
    })
}
