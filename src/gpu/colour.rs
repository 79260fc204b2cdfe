//! The colour of a target as programs read it.

use super::{Device, Target, TargetId};
use crate::math::Vec4;

/// The colour of a target: linear, with whatever alpha was blended into it.
#[derive(Debug, Clone, Copy)]
pub struct ColourMap<'a>(&'a Target);

impl<'a> ColourMap<'a> {
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

    /// The colour of a pixel, the mean of its samples; beside the target what it was cleared to.
    #[must_use]
    pub fn colour(&self, [x, y]: [u32; 2]) -> Vec4 {
        self.0.colour(x, y)
    }
}
