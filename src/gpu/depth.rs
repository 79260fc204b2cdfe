//! The depth of a target as programs read it.

use super::{Device, GpuError, Target, TargetId};
use crate::raster::Samples;

/// The depth of a target, from 0 (near) to 1 (far).
#[derive(Debug, Clone, Copy)]
pub struct DepthMap<'a>(&'a Target);

impl<'a> DepthMap<'a> {
    /// Of a target whose handle was checked before.
    pub(super) fn of(device: &'a Device, id: TargetId) -> Self {
        let slot = device.target(id).expect("checked by the plan");
        Self(&slot.target)
    }

    /// Columns and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.0.width(), self.0.height()]
    }

    /// Bytes of the depths of a pixel.
    #[must_use]
    pub fn pixel_bytes(&self) -> u64 {
        match self.0.samples() {
            Samples::One => 4,
            Samples::Four => 16,
        }
    }

    /// The depth of the first sample of a pixel; beside the target what it was cleared to.
    #[must_use]
    pub fn depth(&self, [x, y]: [u32; 2]) -> f32 {
        self.0.depth(x, y)
    }

    /// The greatest depth of the samples of a pixel; beside the target what it was cleared to.
    #[must_use]
    pub fn farthest(&self, [x, y]: [u32; 2]) -> f32 {
        self.0.farthest_depth(x, y)
    }
}

/// Refuses the depth or colour, as `wanted` says, of what a pass draws into.
pub(super) fn check_other(
    device: &Device,
    target: TargetId,
    drawn: TargetId,
    wanted: &str,
) -> Result<(), GpuError> {
    let slot = device.target(target)?;
    if target != drawn {
        return Ok(());
    }
    Err(GpuError::Usage {
        label: slot.label.clone(),
        has: "the target of the pass".to_owned(),
        wanted: format!("{wanted} that it reads"),
    })
}
