//! What wood and needles look like, and the steps that draw them.

use super::parameters::{PARAMETER_SLOT, Parameters};
use super::{BRANCH_GROUP, NEEDLE_GROUP};
use crate::gpu::{BufferId, Cause, Corners, Device, Draw, GpuError, Step, Usage};
use crate::models::surface::filled;
use crate::models::trunk::Surface;
use crate::models::{Environment, Trunk};

/// Bark, the needles' material where there are any, and the species' parameters, on the device.
#[derive(Debug, Clone)]
pub(super) struct Surfaces {
    pub(super) environment: Environment,
    bark: Surface,
    needles: Option<Surface>,
    parameters: BufferId,
}

impl Surfaces {
    pub(super) fn upload(
        device: &mut Device,
        environment: &Environment,
        trunk: &Trunk,
    ) -> Result<Self, GpuError> {
        let bark = Surface::of(device, environment, &trunk.mesh().material)?;
        let needles = trunk.needle_material();
        let needles = needles
            .map(|material| Surface::of(device, environment, material))
            .transpose()?;
        let bytes = Parameters::of(trunk, environment).to_bytes();
        let cause = Cause::of("trunk");
        let parameters = filled(device, "trunk parameters", Usage::STORAGE, &bytes, cause)?;
        Ok(Self {
            environment: *environment,
            bark,
            needles,
            parameters,
        })
    }

    /// Binds a program with bark, or the needles' material, and the parameters; with the group of
    /// what is drawn.
    pub(super) fn bind(&self, part: Part, program: crate::gpu::ProgramId) -> (Vec<Step>, u32) {
        let (surface, group) = match (part, &self.needles) {
            (Part::Needles, Some(needles)) => (needles, NEEDLE_GROUP),
            (Part::Needles, None) => (&self.bark, NEEDLE_GROUP),
            (Part::Wood, _) => (&self.bark, BRANCH_GROUP),
        };
        let mut steps = surface.bind_program(program);
        steps.push(Step::Storage {
            slot: PARAMETER_SLOT,
            buffer: self.parameters,
        });
        (steps, group)
    }

    /// Draws corners from buffers.
    pub(super) fn draw_indexed(
        &self,
        (part, program): (Part, crate::gpu::ProgramId),
        [vertices, indices]: [BufferId; 2],
        corners: &std::ops::Range<u32>,
        instance: u32,
        steps: &mut Vec<Step>,
    ) {
        if corners.is_empty() {
            return;
        }
        let (bound, group) = self.bind(part, program);
        steps.extend(bound);
        steps.push(Step::Vertices(vertices));
        steps.push(Step::Indices(indices));
        steps.push(Step::Draw(Draw {
            source: Corners::Indexed,
            first_corner: corners.start,
            corner_count: corners.end - corners.start,
            instance,
            group,
        }));
    }
}

/// Wood or needles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Wood,
    Needles,
}
