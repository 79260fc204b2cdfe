//! The one door: bytes and commands enter the device here.

use super::bus::{Part, RecordingEntry, ResourceId};
use super::ledger::{Cause, Stream};
use super::pass::{Command, ComputeStep, RenderPass};
use super::{
    BufferId, Device, GpuError, Residency, TargetId, TargetLayer, TextureId, Usage, dispatch,
    execute,
};

/// The queue of a device.
#[derive(Debug)]
pub struct Queue<'d> {
    device: &'d mut Device,
}

/// One range of a gathered write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region<'a> {
    /// Where to.
    pub buffer: BufferId,
    /// The first byte.
    pub offset: u64,
    /// The bytes.
    pub bytes: &'a [u8],
    /// Why.
    pub cause: Cause,
}

/// Command-stream bytes of one copy or of one region of a gathered write.
pub(super) const COPY_BYTES: u64 = 24;

impl<'d> Queue<'d> {
    pub(super) fn new(device: &'d mut Device) -> Self {
        Self { device }
    }

    /// Writes one range: one transfer. Into a host-resident buffer nothing crosses the bus; of no
    /// bytes nothing happens.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] or [`GpuError::Bounds`]; then nothing is written or counted.
    pub fn write(
        &mut self,
        buffer: BufferId,
        offset: u64,
        bytes: &[u8],
        cause: Cause,
    ) -> Result<(), GpuError> {
        self.store(buffer, offset, bytes, "write")?;
        let slot = self.device.living(buffer);
        if slot.residency == Residency::Device && !bytes.is_empty() {
            let resource = ResourceId::Buffer(buffer);
            let label = slot.label.clone();
            self.device.bus.upload(&[Part {
                resource,
                label,
                offset,
                bytes,
                cause,
            }]);
        }
        Ok(())
    }

    /// Writes many ranges as one transfer: they are packed in a staging area, and each is then
    /// copied to its place by a command of its own. Of no regions nothing happens; empty regions
    /// are skipped. All buffers must be device-resident.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`], [`GpuError::Bounds`], or [`GpuError::Usage`] for a host-resident
    /// buffer; then nothing is written or counted.
    pub fn write_regions(&mut self, regions: &[Region<'_>]) -> Result<(), GpuError> {
        for region in regions {
            let slot = self.device.buffer(region.buffer)?;
            slot.range(region.offset, region.bytes.len() as u64, "write")?;
            slot.check_on_device("the target of a gathered write")?;
        }
        for region in regions {
            self.store(region.buffer, region.offset, region.bytes, "write")?;
        }
        let device = &*self.device;
        let parts: Vec<Part<'_>> = regions
            .iter()
            .filter(|region| !region.bytes.is_empty())
            .map(|region| Part {
                resource: ResourceId::Buffer(region.buffer),
                label: device.living(region.buffer).label.clone(),
                offset: region.offset,
                bytes: region.bytes,
                cause: region.cause,
            })
            .collect();
        self.device.bus.upload(&parts);
        self.device.bus.ledger().command_bytes += COPY_BYTES * parts.len() as u64;
        Ok(())
    }

    /// Writes a whole mip level of a texture: one transfer.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`], or [`GpuError::Bounds`] when `bytes` is not exactly the level.
    pub fn write_texture(
        &mut self,
        texture: TextureId,
        level: u32,
        bytes: &[u8],
        cause: Cause,
    ) -> Result<(), GpuError> {
        let slot = self.device.texture(texture)?;
        let exists = level < slot.texels.level_count();
        let holds = if exists {
            slot.texels.level_bytes(level).len() as u64
        } else {
            0
        };
        if !exists || bytes.len() as u64 != holds {
            return Err(GpuError::Bounds {
                label: slot.label.clone(),
                holds,
                what: "write",
                from: 0,
                to: bytes.len() as u64,
            });
        }
        let slot = &mut self.device.textures[texture.0 as usize];
        let written = slot.texels.write_level(level, 0, bytes);
        debug_assert!(written, "the level's length was checked");
        let resource = ResourceId::Texture(texture, level);
        let label = slot.label.clone();
        self.device.bus.upload(&[Part {
            resource,
            label,
            offset: 0,
            bytes,
            cause,
        }]);
        Ok(())
    }

    /// Reads a range back: one transfer from device to host. From a host-resident buffer nothing
    /// crosses the bus.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`], [`GpuError::Bounds`], or [`GpuError::Usage`] without
    /// [`Usage::COPY_SOURCE`].
    pub fn read(
        &mut self,
        buffer: BufferId,
        offset: u64,
        size: u64,
        cause: Cause,
    ) -> Result<Vec<u8>, GpuError> {
        let slot = self.device.buffer(buffer)?;
        let range = slot.range(offset, size, "read")?;
        slot.check_usage(Usage::COPY_SOURCE)?;
        let bytes = slot.bytes[range].to_vec();
        if slot.residency == Residency::Device && size > 0 {
            let label = slot.label.clone();
            self.device
                .bus
                .move_bytes(Stream::Readback, &label, cause, size);
        }
        Ok(bytes)
    }

    /// Reads a layer of a render target back: one transfer from device to host.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the target does not exist, [`GpuError::Usage`] for colour that it does
    /// not have.
    pub fn read_target(
        &mut self,
        target: TargetId,
        layer: TargetLayer,
        cause: Cause,
    ) -> Result<Vec<u8>, GpuError> {
        let mut bytes = Vec::new();
        self.read_target_into(target, layer, cause, &mut bytes)?;
        Ok(bytes)
    }

    /// As [`read_target`](Self::read_target), into memory that is there: many reads need not ask for more.
    ///
    /// # Errors
    ///
    /// As [`read_target`](Self::read_target); then `bytes` stays as it is.
    pub fn read_target_into(
        &mut self,
        target: TargetId,
        layer: TargetLayer,
        cause: Cause,
        bytes: &mut Vec<u8>,
    ) -> Result<(), GpuError> {
        let slot = self.device.target(target)?;
        if layer != TargetLayer::Depth {
            slot.check_colour()?;
        }
        slot.target.layer_bytes_into(layer, bytes);
        let (label, size) = (slot.label.clone(), bytes.len() as u64);
        self.device
            .bus
            .move_bytes(Stream::Readback, &label, cause, size);
        Ok(())
    }

    /// Executes commands in order, each wholly before the next.
    ///
    /// # Errors
    ///
    /// What a command breaks; it then has no effect and counts nothing, those before it stand.
    pub fn submit(&mut self, commands: &[Command]) -> Result<(), GpuError> {
        self.submit_with(commands, execute::render)
    }

    /// As [`submit`](Self::submit), but render passes are only counted: commands, draws, vertices and
    /// what they fetch, as if they were drawn; visible samples are 0, and their targets stay as they are.
    ///
    /// # Errors
    ///
    /// As [`submit`](Self::submit); and [`GpuError::Unsupported`] under exact counters, which are of
    /// samples, or for a compute pass that reads a depth, which nobody draws.
    pub fn tally(&mut self, commands: &[Command]) -> Result<(), GpuError> {
        let reads_depth = |command: &Command| match command {
            Command::Compute(pass) => {
                let mut steps = pass.steps.iter();
                steps.any(|step| matches!(step, ComputeStep::Depth { .. }))
            }
            _ => false,
        };
        if commands.iter().any(reads_depth) {
            let what = "a compute pass over a depth that is not drawn".to_owned();
            return Err(GpuError::Unsupported { what });
        }
        self.submit_with(commands, execute::tally)
    }

    fn submit_with(
        &mut self,
        commands: &[Command],
        render: fn(&mut Device, &RenderPass) -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        for command in commands {
            match command {
                Command::Render(pass) => render(self.device, pass)?,
                Command::Copy {
                    source,
                    source_offset,
                    destination,
                    destination_offset,
                    size,
                } => {
                    let slot = self.device.buffer(*source)?;
                    let range = slot.range(*source_offset, *size, "copy")?;
                    slot.check_usage(Usage::COPY_SOURCE)?;
                    slot.check_on_device("the source of a copy")?;
                    let bytes = slot.bytes[range].to_vec();
                    let target = self.device.buffer(*destination)?;
                    target.check_on_device("the destination of a copy")?;
                    self.store(*destination, *destination_offset, &bytes, "copy")?;
                    self.device.bus.ledger().command_bytes += COPY_BYTES;
                    self.device.bus.note(RecordingEntry::Copy {
                        source: *source,
                        source_offset: *source_offset,
                        destination: *destination,
                        destination_offset: *destination_offset,
                        size: *size,
                    });
                }
                Command::Clear {
                    buffer,
                    offset,
                    size,
                } => {
                    let slot = self.device.buffer(*buffer)?;
                    slot.check_on_device("the target of a clear")?;
                    self.device
                        .buffer_range_mut(*buffer, *offset, *size, "clear")?
                        .fill(0);
                    self.device.bus.ledger().command_bytes += super::pass::CLEAR_BYTES;
                    self.device.bus.note(RecordingEntry::Clear {
                        buffer: *buffer,
                        offset: *offset,
                        size: *size,
                    });
                }
                Command::Compute(pass) => dispatch::compute(self.device, pass)?,
            }
        }
        Ok(())
    }

    fn store(
        &mut self,
        buffer: BufferId,
        offset: u64,
        bytes: &[u8],
        what: &'static str,
    ) -> Result<(), GpuError> {
        let size = bytes.len() as u64;
        self.device
            .buffer_range_mut(buffer, offset, size, what)?
            .copy_from_slice(bytes);
        Ok(())
    }
}
