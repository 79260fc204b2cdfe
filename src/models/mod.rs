//! Level-of-detail models: what each keeps on the device, and what a change of detail sends.
//!
//! ```text
//!  offline                   once a species      once an instance      every frame
//! Crown ─Kind::model─▶ Model ──upload──▶ Shared ──instance(State)──▶ Resident ─┬─ commit(State)
//!  (leaves, collapses,                                                        └─ draw ─▶ steps
//!   clusters)                                    select(view) ─▶ State
//! ```
//!
//! A [`State`] says which leaves show and fully describes what a resident model holds; `select` may
//! remember what it likes, `commit` may not. Every model and mode shows the same leaves for the
//! same state, so their pictures are equal bit for bit; they differ in what crosses the bus, which
//! each instance can tell before it is sent.
//!
//! | kind | resident on the device | what one change sends |
//! |---|---|---|
//! | [`Kind::Full`] | vertices | nothing: always full detail |
//! | [`Kind::VdfHost`] | nothing | nothing; every draw fetches 64 B a visible leaf |
//! | [`Kind::VdfIndices`] | vertices, one index list | 16 B a visible leaf, all of them |
//! | [`Kind::LodfHost`] | nothing | nothing; every draw fetches 64 B a visible leaf |
//! | [`Kind::LodfCluster`] | vertices, a block of records a cluster | 16 B an active leaf of each changed cluster, and its count (4 B) |
//! | [`Kind::LodfSlots`] | the same | at most two records (32 B) a collapse or split, and the count (4 B) a changed cluster |
//! | [`Kind::LodfStamps`] | vertices, every record once with its birth | 4 B; 4 B a changed cluster between variable states |
//! | [`Kind::LodfDevice`] | vertices, every record once with its birth, the clusters' boxes and collapses | nothing but the [`Camera`] (24 B) where that decides; else as `LodfStamps` |
//! | [`Kind::LodfLiteral`] | as `LodfCluster` | as `LodfCluster`, of the papers' static list: wrong leaves |
//! | [`Kind::Impostors`] | no leaves: textures and corners of cards, at all levels | 4 B |
//! | [`Kind::IndirectImpostors`] | no leaves: maps, pictures of a leaf, corners of cards | 4 B |
//! | [`Kind::RIVALS`] | no leaves: pictures of the whole crown | nothing |
//! | [`Kind::StrokeRanges`] | strokes of the whole plant | 8 B a run of them, and the count (4 B); a move of the eye 4 B a stroke that comes at another time |
//! | [`Kind::StrokesHost`] | no strokes: brushes alone | nothing; every draw fetches 60 B a stroke |
//!
//! Instances of one species that `LodfDevice` draws share buffers, one dispatch and one draw command, and
//! may leave out what is hidden ([`Occlusion`]): [`frame_commands`] puts a frame's passes in order.
//!
//! These are figures of wide records and float vertices; [`LeafFormat`] has smaller ones for all of them:
//! records of 8 B, vertices of 8 B. Then every cluster is a draw of its own, also of lists.
//!
//! Models simplify quads. [Leaves of several faces](FaceLeaves) are drawn beside them by every model, always
//! at full detail, at 36 B a face once a species; where a model keeps everything in host memory, so are they.
//!
//! **Invariant.** A model reaches the device only through [`Queue`], so its ledger is complete by
//! construction; no model names `raster`.
//!
//! [Cards for trees far away](crate::scene::FarCards) stand beside any model of leaves whose detail the host
//! selects: a tree then shows leaves, or [`State::Cards`], and only what shows is drawn.
//!
//! Trunks are models of the same form: [`TrunkModel`], with a [`TrunkLevel`] for a state.

mod branches;
mod cards;
mod clip_box;
mod crown;
mod environment;
mod errors;
mod expand_pass;
mod faces;
mod format;
mod frame;
mod full;
mod grove;
mod leaf;
mod leaf_list;
mod lodf;
mod near_far;
mod pyramid_pass;
mod reveal_pass;
mod select;
mod select_pass;
mod shadow;
mod state;
mod strokes;
mod surface;
mod terrain;
mod trunk;
mod vdf;
mod viewpoint;

use std::sync::Arc;

pub use branches::{BRANCH_GROUP, NEEDLE_GROUP};
pub use cards::{ImpostorMesh, LeafMapFacts, impostor_meshes};
pub use crown::Crown;
pub use environment::{Camera, Environment, Placement, View};
pub use errors::LeafErrors;
pub use faces::{FaceLeaf, FaceLeaves};
pub use format::{LeafFormat, Records, Vertices};
pub use frame::frame_commands;
pub use grove::{Grove, GroveSample, GroveView, ResidentGrove};
pub use lodf::{Extraction, Gather};
pub use select::{
    Apportionment, Band, ByDistance, ByScreenError, BySilhouette, ClusterFacts, Criterion, Extent,
    Importance, Move, Sight, Spent, apportion, gain, level, level_with, select, settle, spend,
    spread, weights, within_pixels,
};
pub use state::{CardLevel, State, StrokeCut, TreeState};
pub use strokes::Painting;
pub use surface::{CARD_GROUP, LEAF_GROUP, STROKE_GROUP, shows_foliage};
pub use terrain::{Ground, TERRAIN_GROUP};
pub use trunk::{TRUNK_GROUP, Trunk, TrunkKind, TrunkLevel, TrunkModel, TrunkSimplifier};
pub use viewpoint::Viewpoint;

use cards::RivalForm;

use crate::gpu::{Command, Device, GpuError, Key, Ledger, Queue, Step};
use crate::math::{DVec3, Vec3, index_u32};
use crate::scene::{CardOptions, PaintOptions};
use crate::simplify::PrimitiveCounts;

pub use crate::simplify::ErrorStep;

/// A level-of-detail model of one crown: immutable, made offline.
pub trait Model: Send + Sync + std::fmt::Debug {
    /// Which model this is.
    fn kind(&self) -> Kind;

    /// What it is a model of.
    fn crown(&self) -> &Arc<Crown>;

    /// The leaves that are drawn in a state, in the order of drawing.
    fn drawn(&self, state: &State) -> Vec<u32>;

    /// Sends what all instances share.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`], or [`GpuError::Unsupported`] for foliage with too many textures.
    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError>;

    /// The structures that it keeps in host memory, as bytes in the order in which they are listed
    /// in the type's documentation; their length is [`Storage::host_bytes`].
    fn host_bytes(&self) -> Vec<u8>;

    /// What it takes to keep it.
    fn storage(&self) -> Storage;

    /// What it paints, where it is a model of strokes: of the whole plant, and not only of its crown.
    fn painting(&self) -> Option<&Arc<Painting>> {
        None
    }

    /// What it cost to bake its textures on a device of its own, offline; `None` where none are baked.
    fn baked(&self) -> Option<&Ledger> {
        None
    }

    /// What its leaf distribution maps hold; `None` where there are none.
    fn leaf_maps(&self) -> Option<LeafMapFacts> {
        None
    }

    /// Where a point of what is drawn in a state under a key lies once the viewer has moved from the
    /// first place to the second, in the plant's space: `point` is where it shows at first, hidden or not
    /// then. `None` where that piece of the model is gone.
    ///
    /// Leaves stay where they are, and so does whatever does not look at the viewer.
    fn carried(
        &self,
        _state: &State,
        _key: Key,
        point: DVec3,
        _views: [&Viewpoint; 2],
    ) -> Option<DVec3> {
        Some(point)
    }
}

/// What all instances of a model share on a device, with levels of detail told by `S`.
pub trait Shared<S = State>: std::fmt::Debug {
    /// Makes an instance in a state: sends what it alone holds, as if it had always been there.
    /// `number` names its placement and is the second part of its key.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`].
    fn instance(
        &self,
        device: &mut Device,
        state: &S,
        number: u32,
    ) -> Result<Box<dyn Resident<S>>, GpuError>;
}

/// One instance on a device, with levels of detail told by `S`.
pub trait Resident<S = State>: std::fmt::Debug {
    /// What it shows.
    fn state(&self) -> &S;

    /// Goes over to another state, sending what differs.
    ///
    /// # Errors
    ///
    /// None on the device that it lives on.
    fn commit(&mut self, queue: &mut Queue<'_>, to: &S) -> Result<Change, GpuError>;

    /// The payload bytes that [`commit`](Self::commit) to a state would upload now, exactly.
    fn price(&self, to: &S) -> u64;

    /// The same for one cluster alone, to so many of its collapses, where the instance stands in a
    /// variable state and what its clusters cost adds up; else `None`, as where there are no clusters.
    fn cluster_price(&self, _cluster: u32, _collapses: u32) -> Option<u64> {
        None
    }

    /// Goes over to the state that the device selects from the [`Camera`] which it was sent: `to` is
    /// that state, as [`Camera::select`] has it. Models that do not select are sent what differs.
    ///
    /// # Errors
    ///
    /// None on the device that it lives on.
    fn follow(&mut self, queue: &mut Queue<'_>, to: &S) -> Result<Change, GpuError> {
        self.commit(queue, to)
    }

    /// Puts what is blended in order for a viewer at `eye`, in the plant's own space: called before
    /// every pass, once the state is committed.
    ///
    /// # Errors
    ///
    /// None on the device that it lives on.
    fn look_from(&mut self, _queue: &mut Queue<'_>, _eye: Vec3) -> Result<(), GpuError> {
        Ok(())
    }

    /// Adds the commands that go before every pass that draws it, after the view is sent. Where
    /// instances share what they are drawn with, the first of them adds the commands for all, and
    /// likewise below.
    fn prepare(&self, _commands: &mut Vec<Command>) {}

    /// Adds the steps that draw it.
    fn draw(&self, steps: &mut Vec<Step>);

    /// Where [`draw`](Self::draw) draws [first what was seen last](Occlusion::TwoPhase): adds the
    /// commands that find out, from what all of them have drawn, what is left to draw.
    fn reveal(&self, _commands: &mut Vec<Command>) {}

    /// Adds the steps that draw what is left.
    fn draw_revealed(&self, _steps: &mut Vec<Step>) {}

    /// Adds the steps that draw what is blended with what is behind it: after all that is opaque in the
    /// frame, trees far away before near ones. It casts no shadow.
    fn draw_lines(&self, _steps: &mut Vec<Step>) {}

    /// Of how many quads, triangles and lines its branches are, where it draws branches.
    fn primitives(&self) -> Option<PrimitiveCounts> {
        None
    }

    /// Adds the steps that draw what lies behind everything, once a frame: the ground that is painted on.
    fn draw_behind(&self, _steps: &mut Vec<Step>) {}

    /// How many strokes it draws in place of leaves and branches.
    fn strokes(&self) -> u64 {
        0
    }

    /// How many triangles of cards it draws in place of leaves.
    fn card_triangles(&self) -> u64 {
        0
    }

    /// What it alone keeps in host memory, in bytes, by the lengths of its arrays: the state and what
    /// the model needs beside it. Numbers of buffers and of the instance are not counted.
    fn host_bytes(&self) -> u64;
}

/// What a change of state took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Change {
    /// Collapses done.
    pub collapses: u32,
    /// Splits done.
    pub splits: u32,
    /// Clusters whose detail changed; of a trunk the strips, or blocks of strips, that changed.
    pub clusters_touched: u32,
    /// Records of level-of-detail structures read and written on the host.
    pub host_records: u64,
}

impl Change {
    /// Adds what another change took.
    pub fn add(&mut self, other: &Self) {
        self.collapses += other.collapses;
        self.splits += other.splits;
        self.clusters_touched += other.clusters_touched;
        self.host_records += other.host_records;
    }
}

/// What changes of state took over whole trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TreeChange {
    /// Of the foliage.
    pub foliage: Change,
    /// Of the trunks.
    pub trunk: Change,
}

/// What it takes to keep a model, in bytes, without the plant's textures and materials: textures that a
/// model makes are its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Storage {
    /// In host memory, once a species.
    pub host_bytes: u64,
    /// In device memory, once a species.
    pub shared_bytes: u64,
    /// In device memory, once an instance.
    pub instance_bytes: u64,
    /// In host memory, once an instance, where every cluster has its own number of collapses.
    pub instance_host_bytes: u64,
}

/// All models and modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// No level of detail: the yardstick.
    Full,
    /// VDF as its paper has it: everything in host memory.
    VdfHost,
    /// VDF as well as it can be done on a device: vertices there, the index list sent anew.
    VdfIndices,
    /// LoDF, "not hardware-oriented".
    LodfHost,
    /// LoDF, "hardware-oriented": changed clusters are sent whole.
    LodfCluster,
    /// LoDF with slots of which only those that change are sent.
    LodfSlots,
    /// LoDF with stamped records of which nothing is sent but a counter.
    LodfStamps,
    /// LoDF that the device refines by itself, from the camera.
    LodfDevice,
    /// LoDF with the papers' static list, which shows wrong leaves.
    LodfLiteral,
    /// Leaf cluster impostors with a texture each.
    Impostors,
    /// Leaf cluster impostors with a map of leaves each, and pictures of one leaf.
    IndirectImpostors,
    /// One picture of the crown, turned to the viewer about the vertical axis.
    AxialBillboard,
    /// The same, turned about its centre.
    FacingBillboard,
    /// The first, each texel at its own depth.
    DepthBillboard,
    /// Eight pictures from around, of which the nearest shows, turned to the viewer.
    Sprites,
    /// Two upright pictures at a right angle, which never turn.
    CrossedCards,
    /// Pictures from 64 directions from above, of which the three nearest are blended.
    HemiOctahedral,
    /// Pictures from 64 directions all around, likewise.
    Octahedral,
    /// Strokes on the device, of which runs show.
    StrokeRanges,
    /// Strokes in host memory.
    StrokesHost,
}

impl Kind {
    /// Every kind that shows the right leaves at every level.
    pub const SOUND: [Self; 8] = [
        Self::Full,
        Self::VdfHost,
        Self::VdfIndices,
        Self::LodfHost,
        Self::LodfCluster,
        Self::LodfSlots,
        Self::LodfStamps,
        Self::LodfDevice,
    ];

    /// Every kind that shows leaves.
    pub const LEAVES: [Self; 9] = [
        Self::Full,
        Self::VdfHost,
        Self::VdfIndices,
        Self::LodfHost,
        Self::LodfCluster,
        Self::LodfSlots,
        Self::LodfStamps,
        Self::LodfDevice,
        Self::LodfLiteral,
    ];

    /// Every kind that shows the whole crown as a few pictures.
    pub const RIVALS: [Self; 7] = [
        Self::AxialBillboard,
        Self::FacingBillboard,
        Self::DepthBillboard,
        Self::Sprites,
        Self::CrossedCards,
        Self::HemiOctahedral,
        Self::Octahedral,
    ];

    /// Every kind.
    pub const ALL: [Self; 20] = [
        Self::Full,
        Self::VdfHost,
        Self::VdfIndices,
        Self::LodfHost,
        Self::LodfCluster,
        Self::LodfSlots,
        Self::LodfStamps,
        Self::LodfDevice,
        Self::LodfLiteral,
        Self::Impostors,
        Self::IndirectImpostors,
        Self::AxialBillboard,
        Self::FacingBillboard,
        Self::DepthBillboard,
        Self::Sprites,
        Self::CrossedCards,
        Self::HemiOctahedral,
        Self::Octahedral,
        Self::StrokeRanges,
        Self::StrokesHost,
    ];

    /// The name of the model and the name of its mode, as in scene files.
    #[must_use]
    pub fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::Full => ("full", "resident"),
            Self::VdfHost => ("vdf", "host"),
            Self::VdfIndices => ("vdf", "indices"),
            Self::LodfHost => ("lodf", "host"),
            Self::LodfCluster => ("lodf", "cluster"),
            Self::LodfSlots => ("lodf", "slots"),
            Self::LodfStamps => ("lodf", "stamps"),
            Self::LodfDevice => ("lodf", "device"),
            Self::LodfLiteral => ("lodf", "literal"),
            Self::Impostors => ("impostors", "direct"),
            Self::IndirectImpostors => ("impostors", "indirect"),
            Self::AxialBillboard => ("billboard", "axial"),
            Self::FacingBillboard => ("billboard", "facing"),
            Self::DepthBillboard => ("billboard", "depth"),
            Self::Sprites => ("sprites", "nearest"),
            Self::CrossedCards => ("crossed", "fixed"),
            Self::HemiOctahedral => ("octahedral", "hemisphere"),
            Self::Octahedral => ("octahedral", "sphere"),
            Self::StrokeRanges => ("strokes", "ranges"),
            Self::StrokesHost => ("strokes", "host"),
        }
    }

    /// Name and mode in one word, such as `lodf-slots`.
    #[must_use]
    pub fn label(self) -> String {
        let (name, mode) = self.names();
        if self == Self::Full {
            name.to_owned()
        } else {
            format!("{name}-{mode}")
        }
    }

    /// The kind with these names.
    #[must_use]
    pub fn named(name: &str, mode: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.names() == (name, mode))
    }

    /// The kind with this label.
    #[must_use]
    pub fn labelled(label: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.label() == label)
    }

    /// Whether it paints: shows strokes in place of leaves and branches.
    #[must_use]
    pub fn paints(self) -> bool {
        matches!(self, Self::StrokeRanges | Self::StrokesHost)
    }

    /// Whether it can show anything but full detail.
    #[must_use]
    pub fn has_levels(self) -> bool {
        self != Self::Full && !Self::RIVALS.contains(&self)
    }

    /// Whether what it shows are leaves of the crown's sequence, and not cards or strokes in their place.
    #[must_use]
    pub fn shows_leaves(self) -> bool {
        Self::LEAVES.contains(&self)
    }

    /// Where it has [levels](Self::has_levels) of cards: how many. Else 1.
    #[must_use]
    pub fn card_levels(self, options: &CardOptions) -> u32 {
        match self {
            Self::Impostors | Self::IndirectImpostors => index_u32(options.levels.as_slice().len()),
            _ => 1,
        }
    }

    /// Whether it selects on the device: it needs a card that computes, and
    /// [`Environment::of_kind`].
    #[must_use]
    pub fn selects(self) -> bool {
        self == Self::LodfDevice
    }

    /// The model of this kind for a crown.
    #[must_use]
    pub fn model(self, crown: &Arc<Crown>, options: ModelOptions) -> Box<dyn Model> {
        let crown = Arc::clone(crown);
        let rival = |form| Box::new(cards::Rival::new(Arc::clone(&crown), self, form, options));
        let model: Box<dyn Model> = match self {
            Self::AxialBillboard => rival(RivalForm::AxialBillboard),
            Self::FacingBillboard => rival(RivalForm::FacingBillboard),
            Self::DepthBillboard => rival(RivalForm::DepthBillboard),
            Self::Sprites => rival(RivalForm::Sprites),
            Self::CrossedCards => rival(RivalForm::CrossedCards),
            Self::HemiOctahedral => rival(RivalForm::HemiOctahedral),
            Self::Octahedral => rival(RivalForm::Octahedral),
            Self::Full => Box::new(full::Full::new(crown, options)),
            Self::VdfHost => Box::new(vdf::Vdf::new(crown, vdf::Transfer::Host, options)),
            Self::VdfIndices => Box::new(vdf::Vdf::new(crown, vdf::Transfer::Indices, options)),
            Self::LodfHost => Box::new(lodf::Host::new(crown, options)),
            Self::LodfCluster => Box::new(lodf::Blocks::new(crown, lodf::Order::Repaired, options)),
            Self::LodfLiteral => Box::new(lodf::Blocks::new(crown, lodf::Order::Literal, options)),
            Self::LodfSlots => Box::new(lodf::Slots::new(crown, options)),
            Self::LodfStamps => Box::new(lodf::Stamps::new(crown, options)),
            Self::LodfDevice => Box::new(lodf::Refined::new(crown, options)),
            Self::Impostors => Box::new(cards::Impostors::new(crown, options)),
            Self::IndirectImpostors => Box::new(cards::IndirectImpostors::new(crown, options)),
            Self::StrokeRanges => Box::new(strokes::StrokeRanges::new(crown, options)),
            Self::StrokesHost => Box::new(strokes::HostStrokes::new(crown, options)),
        };
        if self.shows_leaves() {
            near_far::with_far_cards(faces::with_faces(model), options)
        } else {
            model
        }
    }
}

/// How models work where they have a choice; no choice changes which leaves are shown, and only
/// [quantised vertices](Vertices::Quantised) change where. How cards look is all choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelOptions {
    /// One operation at a time, or batched by cluster.
    pub extraction: Extraction,
    /// Slots as single writes or gathered.
    pub gather: Gather,
    /// How leaves look as bytes.
    pub format: LeafFormat,
    /// What the device leaves out by itself, where it [selects](Kind::selects).
    pub occlusion: Occlusion,
    /// What cards are made of.
    pub cards: CardOptions,
    /// How strokes are made and painted.
    pub painting: PaintOptions,
}

/// What a device that selects by itself leaves out beside what lies out of sight. No picture depends on
/// it, nor on what was seen before; what is submitted does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Occlusion {
    /// Nothing.
    None,
    /// Clusters that are hidden: those seen in the frame before are drawn first, then of all others
    /// those that are not behind what was drawn.
    TwoPhase,
}
