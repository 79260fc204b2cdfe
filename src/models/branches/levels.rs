//! A few discrete levels, all of them on the device: a change sends nothing.

use std::sync::{Arc, OnceLock};

use super::mesh::{Drawing, LevelBytes, Ranges};
use super::parameters::Parameters;
use super::surfaces::Surfaces;
use crate::gpu::{Device, GpuError, Queue, Step};
use crate::models::{
    Change, Environment, Resident, Shared, Storage, Trunk, TrunkKind, TrunkLevel, TrunkModel,
};
use crate::scene::{TrunkMode, TrunkName};
use crate::simplify::{ErrorStep, PrimitiveCounts};

/// The most levels: as many as the paper has ([ZBMJLDC17](crate::references), section 6).
const LEVELS: u32 = 8;

/// The mode `levels`.
///
/// Once a species the vertices of polygons (32 B) and of lines (36 B) and 4 B a corner, of all levels.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    trunk: Arc<Trunk>,
    made: Arc<OnceLock<Made>>,
}

/// All levels one behind the other.
#[derive(Debug)]
struct Made {
    bytes: LevelBytes,
    levels: Vec<(ErrorStep, Ranges, PrimitiveCounts)>,
}

impl Levels {
    pub(super) fn new(trunk: Arc<Trunk>) -> Self {
        Self {
            trunk,
            made: Arc::default(),
        }
    }

    fn made(&self) -> &Made {
        self.made.get_or_init(|| {
            let mut bytes = LevelBytes::default();
            let level = |step: ErrorStep| {
                let level = self.trunk.branch_level(step);
                (step, bytes.add(&level), level.counts())
            };
            let levels = discrete_steps(&self.trunk).into_iter().map(level);
            let levels = levels.collect();
            Made { bytes, levels }
        })
    }
}

/// The steps of the levels: evenly from the finest to the coarsest, so that errors grow by one factor.
pub(super) fn discrete_steps(trunk: &Trunk) -> Vec<ErrorStep> {
    let [finest, coarsest] = trunk.branch_choice().steps();
    let mut steps: Vec<ErrorStep> = (0..LEVELS)
        .map(|level| finest.towards(coarsest, level, LEVELS - 1))
        .collect();
    steps.dedup();
    steps
}

impl TrunkModel for Levels {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::Branches,
            mode: TrunkMode::Levels,
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
        let surfaces = Surfaces::upload(device, environment, &self.trunk)?;
        let made = self.made();
        Ok(Box::new(LevelsShared {
            model: self.clone(),
            drawing: Drawing::filled(device, surfaces, &made.bytes)?,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        Vec::new()
    }

    fn storage(&self) -> Storage {
        Storage {
            shared_bytes: Parameters::BYTES + self.made().bytes.size(),
            ..Storage::default()
        }
    }
}

#[derive(Debug)]
struct LevelsShared {
    model: Levels,
    drawing: Drawing,
}

impl Shared<TrunkLevel> for LevelsShared {
    fn instance(
        &self,
        _device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        Ok(Box::new(LevelsResident {
            model: self.model.clone(),
            drawing: self.drawing.clone(),
            number,
            level: *level,
        }))
    }
}

#[derive(Debug)]
struct LevelsResident {
    model: Levels,
    drawing: Drawing,
    number: u32,
    level: TrunkLevel,
}

impl LevelsResident {
    /// The coarsest level that is not off by more than the state says, or the finest.
    fn place(&self, level: TrunkLevel) -> usize {
        let levels = &self.model.made().levels;
        let fine = levels.partition_point(|(step, ..)| *step <= level.step());
        fine.saturating_sub(1)
    }
}

impl Resident<TrunkLevel> for LevelsResident {
    fn state(&self) -> &TrunkLevel {
        &self.level
    }

    fn commit(&mut self, _queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
        let changed = self.place(self.level) != self.place(*to);
        self.level = *to;
        Ok(Change {
            clusters_touched: u32::from(changed),
            ..Change::default()
        })
    }

    fn price(&self, _to: &TrunkLevel) -> u64 {
        0
    }

    fn host_bytes(&self) -> u64 {
        4
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        let (_, ranges, _) = &self.model.made().levels[self.place(self.level)];
        self.drawing.draw(ranges, self.number, steps);
    }

    fn draw_lines(&self, steps: &mut Vec<Step>) {
        let (_, ranges, _) = &self.model.made().levels[self.place(self.level)];
        self.drawing.draw_lines(ranges, self.number, steps);
    }

    fn primitives(&self) -> Option<PrimitiveCounts> {
        let (_, _, counts) = self.model.made().levels[self.place(self.level)];
        Some(counts)
    }
}
