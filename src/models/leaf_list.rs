//! A list of visible leaf records, drawn as one.

use super::Crown;
use super::surface::Surface;
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, IndirectRecord, Queue, Residency, Step,
    Usage,
};
use crate::math::index_u32;

/// The records that an instance shows, 16 bytes each, and how many they are.
///
/// In host memory writing it costs no bus, and every draw pulls it; on the device a change sends the
/// whole list and its length, 4 bytes.
#[derive(Debug)]
pub(super) struct LeafList {
    records: BufferId,
    arguments: BufferId,
    causes: [Cause; 2],
    pub(super) steps: Vec<Step>,
}

impl LeafList {
    /// Makes the list of an instance with its first leaves.
    pub(super) fn create(
        device: &mut Device,
        crown: &Crown,
        surface: &Surface,
        residency: Residency,
        number: u32,
        leaves: &[u32],
    ) -> Result<Self, GpuError> {
        let mut buffer = |label, size, usage| {
            device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency,
            })
        };
        let (label, first, causes) = match residency {
            Residency::Host => {
                let host = Cause::of("host");
                ("leaf list arguments", host, [host; 2])
            }
            Residency::Device => {
                let causes = [Cause::of("index-list"), Cause::of("draw-count")];
                ("draw arguments", Cause::of("records"), causes)
            }
        };
        let size = 16 * u64::from(crown.sequence().original_count());
        let records = buffer("leaf list", size, Usage::INDEX)?;
        let arguments = buffer(label, IndirectRecord::STRIDE, Usage::INDIRECT)?;
        let record = IndirectRecord {
            corner_count: 4 * index_u32(leaves.len()),
            instances: 1,
            first_corner: 0,
            instance: number,
        };
        let bytes = crown.records_bytes(leaves.iter().copied());
        let mut queue = device.queue();
        queue.write(records, 0, &bytes, first)?;
        queue.write(arguments, 0, &record.to_bytes(), first)?;
        Ok(Self {
            records,
            arguments,
            causes,
            steps: surface.draw_records(records, arguments, 1),
        })
    }

    /// Replaces the leaves.
    pub(super) fn write(
        &self,
        queue: &mut Queue<'_>,
        crown: &Crown,
        leaves: &[u32],
    ) -> Result<(), GpuError> {
        let bytes = crown.records_bytes(leaves.iter().copied());
        queue.write(self.records, 0, &bytes, self.causes[0])?;
        let count = (4 * index_u32(leaves.len())).to_le_bytes();
        queue.write(self.arguments, 0, &count, self.causes[1])
    }
}
