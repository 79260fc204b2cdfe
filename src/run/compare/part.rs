//! The parts of a tree that have schemes of their own: leaves and wood.

use std::sync::Arc;

use super::Scheme;
use super::walk::Subject;
use crate::math::{Sphere, index_u32, index_usize};
use crate::models::{
    CardLevel, Crown, Kind, Model, State, Trunk, TrunkKind, TrunkLevel, TrunkModel,
};
use crate::run::options::SessionOptions;
use crate::run::stand_ins::sphere_of;
use crate::run::sweep::Variant;
use crate::run::world::{World, finest_planes};
use crate::scene::{Simplifier, TrunkMode};

/// How finely the axis of detail is looked through.
const STEPS: u32 = 64;

/// A part of a tree, and how each scheme shows it.
pub(super) trait Part: Sync {
    /// A scheme.
    type Kind: Copy + Ord + Send + Sync;
    /// What a scheme shows.
    type State: Clone + Send + Sync;

    /// The schemes that can be looked at, in the order in which they were asked for.
    fn kinds(&self) -> &[Self::Kind];

    /// The scheme by which to look for the levels of this one: that of all which show the same.
    fn alike(&self, kind: Self::Kind) -> Self::Kind;

    /// As which it is found.
    fn scheme(kind: Self::Kind) -> Scheme;

    /// What encloses the part.
    fn sphere(&self) -> Sphere;

    /// The part at full detail.
    fn full(&self) -> Subject<Self::State>;

    /// The part by a scheme.
    fn subject(&self, kind: Self::Kind) -> Subject<Self::State>;

    /// The last step of its axis of detail, the coarsest; none if it always shows full detail.
    fn last_step(&self, kind: Self::Kind) -> Option<u32>;

    /// What it shows at a step, 0 being the finest.
    fn state(&self, kind: Self::Kind, step: u32) -> Self::State;

    /// How much of the part shows.
    fn shown(&self, kind: Self::Kind, state: &Self::State) -> u64;
}

/// The foliage of a tree.
pub(super) struct Leaves<'w> {
    crown: &'w Arc<Crown>,
    pruned: Option<Arc<Crown>>,
    /// With the planes that all impostors share.
    planar: Option<Arc<Crown>>,
    kinds: &'w [Variant],
    session: &'w SessionOptions,
}

impl<'w> Leaves<'w> {
    /// None of a tree without leaves.
    pub(super) fn of(
        world: &'w World,
        kinds: &'w [Variant],
        session: &'w SessionOptions,
    ) -> Option<Self> {
        let crown = world.crowns.first()?;
        if crown.plant().foliage().leaf_count() == 0 {
            return None;
        }
        let pruned = kinds.iter().any(|kind| kind.pruned);
        let pruned = pruned.then(|| world.simplified_by(Simplifier::Pruning));
        let planar = kinds.iter().any(|kind| in_planes(*kind));
        let planar = planar.then(|| {
            let planes = finest_planes(crown.plant(), &session.model.cards);
            let crown = Crown::new(Arc::clone(crown.plant()), crown.sequence().clone());
            Arc::new(crown.in_planes(planes))
        });
        Some(Self {
            crown,
            pruned: pruned.and_then(|world| world.crowns.first().cloned()),
            planar,
            kinds,
            session,
        })
    }

    fn crown(&self, kind: Variant) -> &Arc<Crown> {
        let pruned = self.pruned.as_ref().filter(|_| kind.pruned);
        let planar = self.planar.as_ref().filter(|_| in_planes(kind));
        pruned.or(planar).unwrap_or(self.crown)
    }
}

/// Whether cards of a scheme stand in planes of their leaves.
fn in_planes(kind: Variant) -> bool {
    matches!(kind.kind, Kind::Impostors | Kind::IndirectImpostors)
}

impl Part for Leaves<'_> {
    type Kind = Variant;
    type State = State;

    fn kinds(&self) -> &[Variant] {
        self.kinds
    }

    fn alike(&self, kind: Variant) -> Variant {
        let usual = Variant::usual(Kind::LodfStamps);
        match (
            kind.kind.shows_leaves() && kind.kind.has_levels(),
            kind.pruned,
        ) {
            (true, true) => usual.pruned(),
            (true, false) => usual,
            (false, _) => kind,
        }
    }

    fn scheme(kind: Variant) -> Scheme {
        Scheme::Leaves(kind)
    }

    fn sphere(&self) -> Sphere {
        sphere_of(self.crown)
    }

    fn full(&self) -> Subject<State> {
        Subject::leaves(leaf_model(self.crown, self.session))
    }

    fn subject(&self, kind: Variant) -> Subject<State> {
        let options = kind.session(self.session).model;
        Subject::leaves(kind.kind.model(self.crown(kind), options))
    }

    fn last_step(&self, kind: Variant) -> Option<u32> {
        match (kind.kind.shows_leaves(), kind.kind.has_levels()) {
            (true, levels) => levels.then_some(STEPS),
            (false, true) => {
                let levels = self.session.model.cards.levels.as_slice();
                Some(index_u32(levels.len()).saturating_sub(1))
            }
            // What stands for leaves differs from them at its finest too.
            (false, false) => Some(0),
        }
    }

    fn state(&self, kind: Variant, step: u32) -> State {
        if !kind.kind.shows_leaves() {
            return State::Cards(CardLevel(step * CardLevel::STEPS));
        }
        let all = u64::from(self.crown(kind).sequence().collapse_count());
        State::Uniform {
            collapses: index_u32(index_usize(all * u64::from(step) / u64::from(STEPS))),
        }
    }

    fn shown(&self, kind: Variant, state: &State) -> u64 {
        self.crown(kind).shown_leaves(state)
    }
}

/// The model by which leaves are looked at: all that show leaves look alike.
pub(super) fn leaf_model(crown: &Arc<Crown>, session: &SessionOptions) -> Box<dyn Model> {
    let usual = Variant::usual(Kind::LodfStamps).session(session);
    Kind::LodfStamps.model(crown, usual.model)
}

/// The trunk and branches of a tree.
pub(super) struct Wood<'w> {
    trunk: &'w Arc<Trunk>,
    kinds: Vec<TrunkKind>,
    session: &'w SessionOptions,
}

impl<'w> Wood<'w> {
    /// None of a tree without wood. Branches that are known as a mesh alone have none of their schemes.
    pub(super) fn of(
        world: &'w World,
        kinds: &[TrunkKind],
        session: &'w SessionOptions,
    ) -> Option<Self> {
        let trunk = world.trunks.first()?.as_ref()?;
        let known = trunk.plant().skeleton().is_some();
        let kinds = kinds.iter().copied();
        Some(Self {
            trunk,
            kinds: kinds.filter(|kind| known || !kind.has_errors()).collect(),
            session,
        })
    }

    fn model(&self, kind: TrunkKind) -> Box<dyn TrunkModel> {
        kind.model(self.trunk, self.session.model)
    }
}

impl Part for Wood<'_> {
    type Kind = TrunkKind;
    type State = TrunkLevel;

    fn kinds(&self) -> &[TrunkKind] {
        &self.kinds
    }

    /// Meshes look alike wherever they lie, and so do branches, unless a device has only some of their levels.
    fn alike(&self, kind: TrunkKind) -> TrunkKind {
        match kind.mode == TrunkMode::Levels || !kind.has_levels() {
            true => kind,
            false => TrunkKind {
                mode: kind.name.modes()[0],
                ..kind
            },
        }
    }

    fn scheme(kind: TrunkKind) -> Scheme {
        Scheme::Wood(kind)
    }

    fn sphere(&self) -> Sphere {
        Sphere::of(&self.trunk.mesh().positions)
    }

    fn full(&self) -> Subject<TrunkLevel> {
        Subject::wood(self.model(TrunkKind::FULL))
    }

    fn subject(&self, kind: TrunkKind) -> Subject<TrunkLevel> {
        Subject::wood(self.model(kind))
    }

    fn last_step(&self, kind: TrunkKind) -> Option<u32> {
        kind.has_levels().then_some(STEPS)
    }

    fn state(&self, kind: TrunkKind, step: u32) -> TrunkLevel {
        kind.level(self.trunk, step, STEPS)
    }

    /// Triangles and lines.
    fn shown(&self, kind: TrunkKind, level: &TrunkLevel) -> u64 {
        let step = kind.shown_step(self.trunk, *level);
        let lines = step.map_or(0, |step| self.trunk.branch_counts(step).lines);
        u64::from(kind.triangle_count(self.trunk, *level)) + lines
    }
}
