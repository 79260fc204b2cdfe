//! Leaves near by and cards far away, of one crown.
//!
//! ```text
//! State::Uniform, Variable ─▶ leaves as they stand    cards at their finest level    leaves are drawn
//! State::Cards             ─▶ leaves at their fewest  cards as they stand            cards are drawn
//! ```
//!
//! The forest walks of [RRCGR](crate::references) and [ZBMJLDC17](crate::references) end where trees are too
//! far away for either; the latter's section 9 wants another method there. Which, and from where on, is ours.
//!
//! **Invariant.** What does not show stands as the table has it, so that what is resident depends on the
//! state alone.

use std::sync::Arc;

use super::{
    CardLevel, Change, Crown, Environment, Kind, LeafMapFacts, Model, ModelOptions, Resident,
    Shared, State, Storage, Viewpoint,
};
use crate::gpu::{Command, Device, GpuError, Key, Ledger, Queue, Step};
use crate::math::{DVec3, Vec3};
use crate::scene::{CardMode, FarCards};

/// A model of leaves with cards for trees far away; the model itself where none are asked for.
pub(super) fn with_far_cards(near: Box<dyn Model>, options: ModelOptions) -> Box<dyn Model> {
    let Some(FarCards { mode, .. }) = options.cards.far else {
        return near;
    };
    let kind = match mode {
        CardMode::Direct => Kind::Impostors,
        CardMode::Indirect => Kind::IndirectImpostors,
    };
    let far = kind.model(near.crown(), options);
    Box::new(NearFar { near, far })
}

/// A model of leaves, and one of cards.
///
/// Host memory: what the leaves have, then what the cards have. Device memory: both, once a species and
/// once an instance.
#[derive(Debug)]
struct NearFar {
    near: Box<dyn Model>,
    far: Box<dyn Model>,
}

/// How leaves stand in a state, and how cards do.
fn parts(crown: &Crown, state: &State) -> (State, State) {
    match state {
        State::Cards(_) => {
            let fewest = State::Uniform {
                collapses: crown.sequence().collapse_count(),
            };
            (fewest, state.clone())
        }
        State::Uniform { .. } | State::Variable { .. } | State::Strokes(_) => {
            (state.clone(), State::Cards(CardLevel::FINEST))
        }
    }
}

fn shows_cards(state: &State) -> bool {
    matches!(state, State::Cards(_))
}

impl Model for NearFar {
    fn kind(&self) -> Kind {
        self.near.kind()
    }

    fn crown(&self) -> &Arc<Crown> {
        self.near.crown()
    }

    fn drawn(&self, state: &State) -> Vec<u32> {
        if shows_cards(state) {
            self.far.drawn(state)
        } else {
            self.near.drawn(state)
        }
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared>, GpuError> {
        Ok(Box::new(SharedNearFar {
            crown: Arc::clone(self.crown()),
            near: self.near.upload(device, environment)?,
            far: self.far.upload(device, environment)?,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        let mut bytes = self.near.host_bytes();
        bytes.extend(self.far.host_bytes());
        bytes
    }

    fn storage(&self) -> Storage {
        let (near, far) = (self.near.storage(), self.far.storage());
        Storage {
            host_bytes: near.host_bytes + far.host_bytes,
            shared_bytes: near.shared_bytes + far.shared_bytes,
            instance_bytes: near.instance_bytes + far.instance_bytes,
            instance_host_bytes: near.instance_host_bytes + far.instance_host_bytes,
        }
    }

    fn baked(&self) -> Option<&Ledger> {
        self.far.baked()
    }

    fn leaf_maps(&self) -> Option<LeafMapFacts> {
        self.far.leaf_maps()
    }

    fn carried(
        &self,
        state: &State,
        key: Key,
        point: DVec3,
        views: [&Viewpoint; 2],
    ) -> Option<DVec3> {
        let shown = if shows_cards(state) {
            &self.far
        } else {
            &self.near
        };
        shown.carried(state, key, point, views)
    }
}

#[derive(Debug)]
struct SharedNearFar {
    crown: Arc<Crown>,
    near: Box<dyn Shared>,
    far: Box<dyn Shared>,
}

impl Shared for SharedNearFar {
    fn instance(
        &self,
        device: &mut Device,
        state: &State,
        number: u32,
    ) -> Result<Box<dyn Resident>, GpuError> {
        let (near, far) = parts(&self.crown, state);
        Ok(Box::new(ResidentNearFar {
            crown: Arc::clone(&self.crown),
            near: self.near.instance(device, &near, number)?,
            far: self.far.instance(device, &far, number)?,
            shows_cards: shows_cards(state),
        }))
    }
}

#[derive(Debug)]
struct ResidentNearFar {
    crown: Arc<Crown>,
    near: Box<dyn Resident>,
    far: Box<dyn Resident>,
    shows_cards: bool,
}

impl ResidentNearFar {
    fn shown(&self) -> &dyn Resident {
        if self.shows_cards {
            &*self.far
        } else {
            &*self.near
        }
    }
}

impl Resident for ResidentNearFar {
    fn state(&self) -> &State {
        self.shown().state()
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &State) -> Result<Change, GpuError> {
        let (near, far) = parts(&self.crown, to);
        let mut change = self.near.commit(queue, &near)?;
        change.add(&self.far.commit(queue, &far)?);
        self.shows_cards = shows_cards(to);
        Ok(change)
    }

    fn price(&self, to: &State) -> u64 {
        let (near, far) = parts(&self.crown, to);
        self.near.price(&near) + self.far.price(&far)
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        if self.shows_cards {
            None
        } else {
            self.near.cluster_price(cluster, collapses)
        }
    }

    /// Both, also what does not show: an order is resident too.
    fn look_from(&mut self, queue: &mut Queue<'_>, eye: Vec3) -> Result<(), GpuError> {
        self.near.look_from(queue, eye)?;
        self.far.look_from(queue, eye)
    }

    fn prepare(&self, commands: &mut Vec<Command>) {
        self.shown().prepare(commands);
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        self.shown().draw(steps);
    }

    fn card_triangles(&self) -> u64 {
        self.shown().card_triangles()
    }

    fn host_bytes(&self) -> u64 {
        // One byte says which shows.
        self.near.host_bytes() + self.far.host_bytes() + 1
    }
}
