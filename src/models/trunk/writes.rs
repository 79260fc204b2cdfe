//! What a change of a trunk's level writes.

use crate::gpu::{BufferId, Cause, GpuError, Queue, Region, Residency};
use crate::models::Gather;
use crate::models::lodf::send;
use crate::scene::TrunkMode;

/// Bytes for a buffer.
#[derive(Debug)]
pub(super) struct Write {
    pub(super) buffer: BufferId,
    /// The first byte written.
    pub(super) offset: u64,
    pub(super) bytes: Vec<u8>,
    pub(super) cause: Cause,
}

/// Sends them, each for itself or all at once.
pub(super) fn send_writes(
    queue: &mut Queue<'_>,
    gather: Gather,
    writes: &[Write],
) -> Result<(), GpuError> {
    let regions: Vec<Region<'_>> = writes
        .iter()
        .map(|write| Region {
            buffer: write.buffer,
            offset: write.offset,
            bytes: &write.bytes,
            cause: write.cause,
        })
        .collect();
    send(queue, gather, &regions)
}

impl TrunkMode {
    /// The payload that writes upload: nothing where the buffers lie on the host.
    pub(super) fn price(self, writes: &[Write]) -> u64 {
        match self.residency() {
            Residency::Host => 0,
            Residency::Device => writes.iter().map(|write| write.bytes.len() as u64).sum(),
        }
    }
}
