//! What all models of trunks with levels have in common: a trunk, where it lies, and a plan of how its
//! triangles lie and change.

use std::fmt::Debug;
use std::sync::Arc;

use super::surface::{TrunkShared, upload_trunk};
use super::writes::{Write, send_writes};
use super::{Trunk, TrunkKind, TrunkLevel, TrunkMode, TrunkModel, TrunkName};
use crate::gpu::{BufferId, Device, GpuError, Queue, Step};
use crate::models::{Change, Environment, Gather, Resident, Shared, Storage};

/// A model that follows a plan.
#[derive(Debug, Clone)]
pub(super) struct Planned<P> {
    pub(super) trunk: Arc<Trunk>,
    pub(super) mode: TrunkMode,
    gather: Gather,
    pub(super) plan: Arc<P>,
}

/// How a trunk's triangles lie, and how they change from level to level.
pub(super) trait TrunkPlan: Debug + Clone + Send + Sync + Sized + 'static {
    /// The model's name.
    const NAME: TrunkName;

    /// An instance's buffers, and what the host keeps beside them.
    type Instance: Debug + Clone;

    /// The plan for a trunk.
    fn of(trunk: &Trunk) -> Self;

    /// What the host keeps once a species beside the vertices, as bytes.
    fn host_bytes(model: &Planned<Self>) -> Vec<u8>;

    /// What it all takes.
    fn sizes(model: &Planned<Self>) -> PlanSizes;

    /// Makes an instance at a level, sent under the cause `trunk`.
    fn instance(
        model: &Planned<Self>,
        device: &mut Device,
        level: TrunkLevel,
        number: u32,
    ) -> Result<Drawn<Self::Instance>, GpuError>;

    /// Takes an instance from one level to another on the host; returns what that takes but for
    /// collapses and splits, and what the buffers lack then.
    fn step(
        model: &Planned<Self>,
        instance: &mut Self::Instance,
        levels: [TrunkLevel; 2],
    ) -> (Change, Vec<Write>);

    /// What the host keeps of an instance beside its level, in bytes.
    fn instance_host_bytes(model: &Planned<Self>, instance: &Self::Instance) -> u64;
}

/// What a plan takes, in bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlanSizes {
    /// Of [`TrunkPlan::host_bytes`].
    pub(super) host: u64,
    /// Once an instance, where its triangles lie.
    pub(super) instance: u64,
    /// Once an instance on the host, so that it can be changed.
    pub(super) kept: u64,
}

/// An instance and how it is drawn.
#[derive(Debug)]
pub(super) struct Drawn<I> {
    pub(super) instance: I,
    /// Its corners.
    pub(super) indices: BufferId,
    /// What draws them.
    pub(super) draw: Step,
}

impl<P: TrunkPlan> Planned<P> {
    pub(super) fn new(trunk: Arc<Trunk>, mode: TrunkMode, gather: Gather) -> Self {
        Self {
            plan: Arc::new(P::of(&trunk)),
            trunk,
            mode,
            gather,
        }
    }
}

impl<P: TrunkPlan> TrunkModel for Planned<P> {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: P::NAME,
            mode: self.mode,
        }
    }

    fn trunk(&self) -> &Arc<Trunk> {
        &self.trunk
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared<TrunkLevel>>, GpuError> {
        let model = self.clone();
        let shared = upload_trunk(device, environment, model, &self.trunk, self.mode)?;
        Ok(Box::new(shared))
    }

    fn host_bytes(&self) -> Vec<u8> {
        let vertices = self.mode.host_vertex_bytes(&self.trunk);
        [vertices, P::host_bytes(self)].concat()
    }

    fn storage(&self) -> Storage {
        let sizes = P::sizes(self);
        self.mode
            .storage(&self.trunk, sizes.host, sizes.instance, sizes.kept)
    }
}

impl<P: TrunkPlan> Shared<TrunkLevel> for TrunkShared<Planned<P>> {
    fn instance(
        &self,
        device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let drawn = P::instance(&self.model, device, *level, number)?;
        let mut steps = self.surface.bind(self.vertices, drawn.indices);
        steps.push(drawn.draw);
        Ok(Box::new(PlannedResident {
            model: self.model.clone(),
            instance: drawn.instance,
            steps,
            level: *level,
        }))
    }
}

#[derive(Debug)]
struct PlannedResident<P: TrunkPlan> {
    model: Planned<P>,
    instance: P::Instance,
    steps: Vec<Step>,
    level: TrunkLevel,
}

impl<P: TrunkPlan> Resident<TrunkLevel> for PlannedResident<P> {
    fn state(&self) -> &TrunkLevel {
        &self.level
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
        let levels = [self.level, *to];
        let (change, writes) = P::step(&self.model, &mut self.instance, levels);
        self.level = *to;
        send_writes(queue, self.model.gather, &writes)?;
        let [from, to] = levels;
        Ok(Change {
            collapses: to.collapses().saturating_sub(from.collapses()),
            splits: from.collapses().saturating_sub(to.collapses()),
            ..change
        })
    }

    fn price(&self, to: &TrunkLevel) -> u64 {
        let mut instance = self.instance.clone();
        let (_, writes) = P::step(&self.model, &mut instance, [self.level, *to]);
        self.model.mode.price(&writes)
    }

    fn host_bytes(&self) -> u64 {
        4 + P::instance_host_bytes(&self.model, &self.instance)
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }
}
