//! Skeletal vectors on the device, which makes any level of them: a change sends a number.

use std::sync::{Arc, OnceLock};

use super::parameters::Parameters;
use super::skeleton_program::{
    ALONG_SLOT, FIRST_SLOT, NODE_SLOT, Of, ROUTE_SLOT, STEP_SLOT, TIP_BIT,
};
use super::surfaces::{Part, Surfaces};
use crate::gpu::{BufferId, Cause, Corners, Device, Draw, GpuError, Queue, Step, Usage};
use crate::math::index_u32;
use crate::models::surface::filled;
use crate::models::{
    Change, Environment, Resident, Shared, Storage, Trunk, TrunkKind, TrunkLevel, TrunkModel,
};
use crate::scene::{TrunkMode, TrunkName};
use crate::simplify::{BranchRoutes, ErrorStep, PrimitiveCounts, SkeletalVector};

/// Why what is there at first is sent.
const TRUNK: Cause = Cause::of("trunk");
/// Why steps are sent.
const STEP: Cause = Cause::of("branch step");

/// The mode `skeleton`.
///
/// Once a species 52 B a skeletal vector and 4 B for its way from the base, 4 B a node and 4 B a change of
/// its route ([`BranchRoutes`]), 32 B a needle, merged or not, and 20 B of parameters; once an instance the
/// step, 4 B. Every draw looks at all nodes and needles.
#[derive(Debug, Clone)]
pub(super) struct Skeleton {
    trunk: Arc<Trunk>,
    tables: Arc<OnceLock<Tables>>,
}

/// What lies on the device.
#[derive(Debug)]
struct Tables {
    vectors: Vec<u8>,
    along: Vec<u8>,
    first: Vec<u8>,
    routes: Vec<u8>,
    needles: Vec<u8>,
    nodes: u32,
    needle_count: u32,
}

impl Tables {
    fn of(trunk: &Trunk) -> Self {
        let sequence = trunk.branches();
        let skeleton = sequence.skeleton();
        let shares = trunk.branch_choice().error_shares();
        let routes = BranchRoutes::of(sequence, shares);
        let mut first = routes.first().to_vec();
        for branch in &skeleton.branches {
            first[branch.run().end - 1] |= TIP_BIT;
        }
        let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect();
        let changes = routes.changes().iter();
        let changes: Vec<u32> = changes.map(|change| change.to_word()).collect();
        let errors: Vec<f32> = (0..=ErrorStep::COARSEST.number())
            .map(|number| {
                let error = ErrorStep::new(number).error();
                sequence.errors(error, shares).needle
            })
            .collect();
        // The first step whose error is at least so much.
        let step = |error: f32| index_u32(errors.partition_point(|known| *known < error));
        let all = sequence.needles();
        let lives = all.errors().iter().zip(all.until());
        let needles = all.needles().iter().zip(lives);
        let needles = needles.flat_map(|(needle, (own, until))| {
            let [base, tip] = needle.ends.map(|end| end.to_array());
            let floats = base.into_iter().chain(tip).chain([needle.radius]);
            let life = step(*own) << 16 | step(*until);
            floats.map(f32::to_bits).chain([life])
        });
        Self {
            vectors: skeleton
                .vectors
                .iter()
                .flat_map(SkeletalVector::to_bytes)
                .collect(),
            along: skeleton
                .along
                .iter()
                .flat_map(|way| way.to_le_bytes())
                .collect(),
            first: words(&first),
            routes: words(&changes),
            needles: needles.flat_map(u32::to_le_bytes).collect(),
            nodes: index_u32(skeleton.vectors.len()),
            needle_count: index_u32(all.needles().len()),
        }
    }

    fn size(&self) -> u64 {
        let buffers = [
            &self.vectors,
            &self.along,
            &self.first,
            &self.routes,
            &self.needles,
        ];
        buffers.iter().map(|bytes| bytes.len() as u64).sum()
    }
}

impl Skeleton {
    pub(super) fn new(trunk: Arc<Trunk>) -> Self {
        Self {
            trunk,
            tables: Arc::default(),
        }
    }

    fn tables(&self) -> &Tables {
        self.tables.get_or_init(|| Tables::of(&self.trunk))
    }

    /// The step that is sent.
    fn step(&self, level: TrunkLevel) -> ErrorStep {
        level.step().max(self.trunk.branch_choice().steps()[0])
    }
}

impl TrunkModel for Skeleton {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::Branches,
            mode: TrunkMode::Skeleton,
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
        let tables = self.tables();
        let mut send = |label, bytes: &[u8]| filled(device, label, Usage::STORAGE, bytes, TRUNK);
        Ok(Box::new(SkeletonShared {
            vectors: send("trunk skeleton", &tables.vectors)?,
            along: send("trunk ways", &tables.along)?,
            first: send("trunk route places", &tables.first)?,
            routes: send("trunk routes", &tables.routes)?,
            needles: send("trunk needles", &tables.needles)?,
            surfaces: Surfaces::upload(device, environment, &self.trunk)?,
            model: self.clone(),
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        Storage {
            shared_bytes: Parameters::BYTES + self.tables().size(),
            instance_bytes: 4,
            instance_host_bytes: 4,
            ..Storage::default()
        }
    }
}

#[derive(Debug, Clone)]
struct SkeletonShared {
    model: Skeleton,
    surfaces: Surfaces,
    vectors: BufferId,
    along: BufferId,
    first: BufferId,
    routes: BufferId,
    needles: BufferId,
}

impl SkeletonShared {
    fn draw(&self, of: Of, step: BufferId, number: u32, steps: &mut Vec<Step>) {
        let tables = self.model.tables();
        let (part, count, nodes) = match of {
            Of::WoodPolygons | Of::WoodLines => (Part::Wood, tables.nodes, self.vectors),
            Of::NeedlePolygons | Of::NeedleLines => {
                (Part::Needles, tables.needle_count, self.needles)
            }
        };
        if count == 0 {
            return;
        }
        let program = self.surfaces.environment.skeleton[of as usize];
        let (bound, group) = self.surfaces.bind(part, program);
        steps.extend(bound);
        let bind = |(slot, buffer)| Step::Storage { slot, buffer };
        steps.extend([(STEP_SLOT, step), (NODE_SLOT, nodes)].map(bind));
        if part == Part::Wood {
            let tables = [
                (ALONG_SLOT, self.along),
                (FIRST_SLOT, self.first),
                (ROUTE_SLOT, self.routes),
            ];
            steps.extend(tables.map(bind));
        }
        steps.push(Step::Draw(Draw {
            source: Corners::Counted,
            first_corner: 0,
            corner_count: of.corners() * count,
            instance: number,
            group,
        }));
    }
}

impl Shared<TrunkLevel> for SkeletonShared {
    fn instance(
        &self,
        device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let bytes = u32::from(self.model.step(*level).number()).to_le_bytes();
        let step = filled(device, "trunk step", Usage::STORAGE, &bytes, TRUNK)?;
        Ok(Box::new(SkeletonResident {
            shared: self.clone(),
            step,
            number,
            level: *level,
        }))
    }
}

#[derive(Debug)]
struct SkeletonResident {
    shared: SkeletonShared,
    step: BufferId,
    number: u32,
    level: TrunkLevel,
}

impl Resident<TrunkLevel> for SkeletonResident {
    fn state(&self) -> &TrunkLevel {
        &self.level
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
        let step = self.shared.model.step(*to);
        let changed = step != self.shared.model.step(self.level);
        self.level = *to;
        if changed {
            let bytes = u32::from(step.number()).to_le_bytes();
            queue.write(self.step, 0, &bytes, STEP)?;
        }
        Ok(Change {
            clusters_touched: u32::from(changed),
            ..Change::default()
        })
    }

    fn price(&self, to: &TrunkLevel) -> u64 {
        let model = &self.shared.model;
        if model.step(*to) == model.step(self.level) {
            0
        } else {
            4
        }
    }

    fn host_bytes(&self) -> u64 {
        4
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        for of in [Of::WoodPolygons, Of::NeedlePolygons] {
            self.shared.draw(of, self.step, self.number, steps);
        }
    }

    fn draw_lines(&self, steps: &mut Vec<Step>) {
        for of in [Of::WoodLines, Of::NeedleLines] {
            self.shared.draw(of, self.step, self.number, steps);
        }
    }

    fn primitives(&self) -> Option<PrimitiveCounts> {
        let trunk = &self.shared.model.trunk;
        Some(trunk.branch_counts(self.shared.model.step(self.level)))
    }
}
