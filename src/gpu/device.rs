//! The device: its memory budget, what lives in it, and the counters.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::bus::{Bus, Recording};
use super::compute::ComputeProgram;
use super::mesh::Meshes;
use super::program::Program;
use super::reads::ReadSet;
use super::resource::{Buffer, TargetSlot, TextureSlot};
use super::{
    BufferDescriptor, BufferId, Card, ComputeProgramId, GpuError, Ledger, Link, ProgramId, Queue,
    RenderPass, Residency, TargetDescriptor, TargetId, TextureDescriptor, TextureId,
};
use crate::limits;
use crate::math::{index_u32, index_usize};
use crate::raster::{
    Image, Instructions, Key, Machine, MipMap, Options, ProbedFragment, Samples, Skips, Target,
};

/// What a device is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceDescriptor {
    /// Bytes of device memory.
    pub memory_bytes: u64,
    /// The link to the host, for modelled wire bytes and times.
    pub link: Link,
    /// The card, for modelled times.
    pub card: Card,
    /// How the rasterizer works: never changes a pixel.
    pub raster: Options,
}

/// A simulated GPU.
#[derive(Debug)]
pub struct Device {
    pub(super) descriptor: DeviceDescriptor,
    pub(super) buffers: Vec<Option<Buffer>>,
    pub(super) textures: Vec<TextureSlot>,
    pub(super) targets: Vec<Option<TargetSlot>>,
    pub(super) programs: Vec<Arc<dyn Program>>,
    pub(super) compute_programs: Vec<Arc<dyn ComputeProgram>>,
    pub(super) bus: Bus,
    pub(super) reads: Option<ReadSet>,
    resident: u64,
    peak: u64,
    /// Bytes of buffers in host memory.
    hosted: u64,
    pub(super) machine: Machine,
    pub(super) meshes: Meshes,
    pub(super) skips: Skips,
}

impl Device {
    /// An empty device.
    #[must_use]
    pub fn new(descriptor: DeviceDescriptor) -> Self {
        Self {
            descriptor,
            buffers: Vec::new(),
            textures: Vec::new(),
            targets: Vec::new(),
            programs: Vec::new(),
            compute_programs: Vec::new(),
            bus: Bus::new(descriptor.link),
            reads: None,
            resident: 0,
            peak: 0,
            hosted: 0,
            machine: Machine::THIS,
            meshes: Meshes::default(),
            skips: Skips::default(),
        }
    }

    /// The door through which bytes and commands enter.
    pub fn queue(&mut self) -> Queue<'_> {
        Queue::new(self)
    }

    /// What the rasterizer left out of the last pass, and why: no promise of any version.
    #[must_use]
    pub fn skips(&self) -> Skips {
        self.skips
    }

    /// Which instructions of this machine the rasterizer may use, the best unless set. No picture and no
    /// counter depends on it.
    pub fn limit_instructions(&mut self, instructions: Instructions) {
        self.machine.instructions = instructions;
    }

    /// About how many bytes of this machine the triangles of a pass may take that are set up ahead, 1 GiB
    /// unless set: others are set up by the parts of the target that need them, some more than once. No
    /// picture and no counter depends on it.
    pub fn limit_geometry(&mut self, bytes: u64) {
        self.machine.geometry_bytes = bytes;
    }

    /// Makes a buffer of zeros.
    ///
    /// # Errors
    ///
    /// [`GpuError::OutOfMemory`] when a device-resident buffer does not fit the budget, or any
    /// buffer not this machine; [`GpuError::OutOfHostMemory`] when all in host memory exceed
    /// [`HOST_BYTES`](limits::HOST_BYTES).
    pub fn create_buffer(
        &mut self,
        descriptor: &BufferDescriptor<'_>,
    ) -> Result<BufferId, GpuError> {
        let refused = || self.out_of_memory(descriptor.label, descriptor.size);
        let size = usize::try_from(descriptor.size).map_err(|_overflow| refused())?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).map_err(|_full| refused())?;
        match descriptor.residency {
            Residency::Device => self.allocate(descriptor.label, descriptor.size)?,
            Residency::Host => self.allocate_on_host(descriptor.label, descriptor.size)?,
        }
        bytes.resize(size, 0);
        self.buffers.push(Some(Buffer {
            label: descriptor.label.to_owned(),
            usage: descriptor.usage,
            residency: descriptor.residency,
            bytes,
            version: 0,
        }));
        Ok(BufferId(index_u32(self.buffers.len() - 1)))
    }

    /// Frees a buffer; its handle names nothing from then on.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when it names nothing already.
    pub fn destroy_buffer(&mut self, buffer: BufferId) -> Result<(), GpuError> {
        let slot = self
            .buffers
            .get_mut(buffer.0 as usize)
            .and_then(Option::take);
        let freed = slot.ok_or(GpuError::Unknown {
            what: "buffer",
            index: buffer.0,
        })?;
        let bytes = freed.bytes.len() as u64;
        match freed.residency {
            Residency::Device => self.resident -= bytes,
            Residency::Host => self.hosted -= bytes,
        }
        Ok(())
    }

    /// Makes a texture of zeros.
    ///
    /// # Errors
    ///
    /// [`GpuError::Descriptor`] when a side or the number of levels cannot be,
    /// [`GpuError::OutOfMemory`] when it does not fit the budget.
    pub fn create_texture(
        &mut self,
        descriptor: &TextureDescriptor<'_>,
    ) -> Result<TextureId, GpuError> {
        let TextureDescriptor {
            label,
            format,
            width,
            height,
            levels,
        } = *descriptor;
        for (what, side) in [("width", width), ("height", height)] {
            check(label, what, side, 1, limits::TEXTURE_SIDE)?;
        }
        check(
            label,
            "number of levels",
            levels,
            1,
            1 + width.max(height).ilog2(),
        )?;
        let side = |side: u32, level: u32| u64::from((side >> level).max(1));
        let texel_bytes = u64::from(format.texel_bytes());
        let sizes = (0..levels).map(|level| texel_bytes * side(width, level) * side(height, level));
        self.allocate(label, sizes.sum())?;
        let texels = blank_texels(descriptor);
        self.textures.push(TextureSlot {
            label: label.to_owned(),
            texels,
        });
        Ok(TextureId(index_u32(self.textures.len() - 1)))
    }

    /// Makes a render target.
    ///
    /// # Errors
    ///
    /// [`GpuError::Descriptor`] when a side is 0 or above [`IMAGE_SIDE`](limits::IMAGE_SIDE),
    /// [`GpuError::OutOfMemory`] when it does not fit the budget.
    pub fn create_target(
        &mut self,
        descriptor: &TargetDescriptor<'_>,
    ) -> Result<TargetId, GpuError> {
        self.add_target(descriptor, Target::new)
    }

    /// Makes a render target of depth alone, of 4 bytes a sample: what is drawn into it is not shaded,
    /// and what is blended leaves no trace.
    ///
    /// # Errors
    ///
    /// As [`create_target`](Self::create_target).
    pub fn create_depth_target(
        &mut self,
        descriptor: &TargetDescriptor<'_>,
    ) -> Result<TargetId, GpuError> {
        self.add_target(descriptor, Target::of_depth)
    }

    fn add_target(
        &mut self,
        descriptor: &TargetDescriptor<'_>,
        make: fn(u32, u32, Samples) -> Target,
    ) -> Result<TargetId, GpuError> {
        let TargetDescriptor {
            label,
            width,
            height,
            samples,
        } = *descriptor;
        for (what, side) in [("width", width), ("height", height)] {
            check(label, what, side, 1, limits::IMAGE_SIDE)?;
        }
        let target = make(width, height, samples);
        self.allocate(label, target_bytes(&target))?;
        self.targets.push(Some(TargetSlot {
            label: label.to_owned(),
            target,
        }));
        Ok(TargetId(index_u32(self.targets.len() - 1)))
    }

    /// Registers a program.
    pub fn create_program(&mut self, program: Arc<dyn Program>) -> ProgramId {
        self.programs.push(program);
        ProgramId(index_u32(self.programs.len() - 1))
    }

    /// Registers a compute program.
    ///
    /// # Errors
    ///
    /// [`GpuError::NoCompute`] on a card without compute passes, [`GpuError::Descriptor`] for a
    /// layout that nothing can be done with.
    pub fn create_compute_program(
        &mut self,
        program: Arc<dyn ComputeProgram>,
    ) -> Result<ComputeProgramId, GpuError> {
        self.check_computes()?;
        program.layout().check()?;
        self.compute_programs.push(program);
        Ok(ComputeProgramId(index_u32(self.compute_programs.len() - 1)))
    }

    /// Hands out what a target shows: scan-out, outside the bus.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the target does not exist, [`GpuError::Usage`] where it has no colour.
    pub fn present(&self, target: TargetId) -> Result<Image, GpuError> {
        let slot = self.target(target)?;
        slot.check_colour()?;
        Ok(slot.target.resolve())
    }

    /// What shows at a pixel (its first sample); `None` for background or outside.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the target does not exist.
    pub fn key(&self, target: TargetId, x: u32, y: u32) -> Result<Option<Key>, GpuError> {
        Ok(self.target(target)?.target.key(x, y))
    }

    /// The target itself, for layers that are looked at beside the picture.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the target does not exist.
    pub fn inspect_target(&self, target: TargetId) -> Result<&Target, GpuError> {
        Ok(&self.target(target)?.target)
    }

    /// Every fragment that a pass would have at one pixel of its target, in the order of submission:
    /// what passes, what alpha kills, what is hidden. Nothing is drawn, nothing is counted.
    ///
    /// # Errors
    ///
    /// What the pass breaks, as when it is submitted.
    pub fn probe(
        &self,
        pass: &RenderPass,
        pixel: [u32; 2],
    ) -> Result<Vec<ProbedFragment>, GpuError> {
        super::execute::probe(self, pass, pixel)
    }

    /// What was counted since the last call; counting starts anew.
    pub fn take_ledger(&mut self) -> Ledger {
        let mut ledger = std::mem::take(self.bus.ledger());
        ledger.resident_bytes = self.resident;
        ledger.peak_bytes = self.peak;
        ledger
    }

    /// Device memory in use, in bytes.
    #[must_use]
    pub fn resident_bytes(&self) -> u64 {
        self.resident
    }

    /// Device memory by label, largest first, ties by label.
    #[must_use]
    pub fn resident_by_label(&self) -> Vec<(String, u64)> {
        let mut sums = BTreeMap::<&str, u64>::new();
        for buffer in self.buffers.iter().flatten() {
            if buffer.residency == Residency::Device {
                *sums.entry(&buffer.label).or_default() += buffer.bytes.len() as u64;
            }
        }
        for texture in &self.textures {
            *sums.entry(&texture.label).or_default() += (0..texture.texels.level_count())
                .map(|level| texture.texels.level_bytes(level).len() as u64)
                .sum::<u64>();
        }
        for slot in self.targets.iter().flatten() {
            *sums.entry(&slot.label).or_default() += target_bytes(&slot.target);
        }
        let mut list: Vec<_> = sums
            .into_iter()
            .map(|(label, bytes)| (label.to_owned(), bytes))
            .collect();
        list.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        list
    }

    /// The link.
    #[must_use]
    pub fn link(&self) -> Link {
        self.bus.link()
    }

    /// Starts recording every change of device memory.
    pub fn record(&mut self) {
        self.bus.record();
    }

    /// What was recorded, if [`record`](Self::record) was called.
    #[must_use]
    pub fn recording(&self) -> Option<&Recording> {
        self.bus.recording()
    }

    /// Starts noting every byte that draws read.
    pub fn track_reads(&mut self) {
        self.reads = Some(ReadSet::default());
    }

    /// What draws have read since [`track_reads`](Self::track_reads).
    #[must_use]
    pub fn reads(&self) -> Option<&ReadSet> {
        self.reads.as_ref()
    }

    /// Looks at a buffer through the simulator's microscope: costs nothing, changes nothing.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the buffer does not exist.
    pub fn inspect_buffer(&self, buffer: BufferId) -> Result<&[u8], GpuError> {
        Ok(&self.buffer(buffer)?.bytes)
    }

    /// Looks at the bytes of a mip level through the same microscope.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] when the texture or the level does not exist.
    pub fn inspect_texture(&self, texture: TextureId, level: u32) -> Result<&[u8], GpuError> {
        let texels = &self.texture(texture)?.texels;
        if level >= texels.level_count() {
            return Err(GpuError::Unknown {
                what: "mip level",
                index: level,
            });
        }
        Ok(texels.level_bytes(level))
    }

    /// Overwrites bytes of a buffer with `filler` behind the bus's back, to prove that nobody reads
    /// them.
    ///
    /// # Errors
    ///
    /// [`GpuError::Unknown`] or [`GpuError::Bounds`].
    pub fn poison(
        &mut self,
        buffer: BufferId,
        range: Range<u64>,
        filler: u8,
    ) -> Result<(), GpuError> {
        let (start, end) = (range.start, range.end);
        let bytes = self.buffer_range_mut(buffer, start, end.saturating_sub(start), "poison")?;
        bytes.fill(filler);
        Ok(())
    }

    /// The handles of all living buffers with their labels, in order of creation.
    pub fn buffers(&self) -> impl Iterator<Item = (BufferId, &str)> {
        self.buffers.iter().enumerate().filter_map(|(index, slot)| {
            slot.as_ref()
                .map(|buffer| (BufferId(index_u32(index)), buffer.label.as_str()))
        })
    }

    /// The handles of all textures with their labels, in order of creation.
    pub fn textures(&self) -> impl Iterator<Item = (TextureId, &str)> {
        let slots = (0..).zip(&self.textures);
        slots.map(|(index, slot)| (TextureId(index), slot.label.as_str()))
    }

    pub(super) fn buffer(&self, id: BufferId) -> Result<&Buffer, GpuError> {
        let slot = self.buffers.get(id.0 as usize).and_then(Option::as_ref);
        slot.ok_or(GpuError::Unknown {
            what: "buffer",
            index: id.0,
        })
    }

    /// A buffer whose handle was checked just before.
    pub(super) fn living(&self, id: BufferId) -> &Buffer {
        self.buffer(id).expect("the handle was checked just before")
    }

    pub(super) fn texture(&self, id: TextureId) -> Result<&TextureSlot, GpuError> {
        let slot = self.textures.get(id.0 as usize);
        slot.ok_or(GpuError::Unknown {
            what: "texture",
            index: id.0,
        })
    }

    pub(super) fn target(&self, id: TargetId) -> Result<&TargetSlot, GpuError> {
        let slot = self.targets.get(id.0 as usize).and_then(Option::as_ref);
        slot.ok_or(GpuError::Unknown {
            what: "target",
            index: id.0,
        })
    }

    pub(super) fn buffer_range_mut(
        &mut self,
        id: BufferId,
        offset: u64,
        size: u64,
        what: &'static str,
    ) -> Result<&mut [u8], GpuError> {
        let range = self.buffer(id)?.range(offset, size, what)?;
        let slot = self.buffers.get_mut(id.0 as usize).and_then(Option::as_mut);
        let slot = slot.expect("the line above found it");
        slot.version += 1;
        Ok(&mut slot.bytes[range])
    }

    /// Refuses what needs a card with compute passes.
    pub(super) fn check_computes(&self) -> Result<(), GpuError> {
        let card = self.descriptor.card;
        if card.computes() {
            return Ok(());
        }
        let others = Card::ALL.iter().filter(|card| card.computes());
        let others: Vec<String> = others.map(|card| format!("{:?}", card.name())).collect();
        Err(GpuError::NoCompute {
            card: card.name().to_owned(),
            others: others.join(", "),
        })
    }

    /// The bytes of a living buffer.
    pub(super) fn bytes_mut(&mut self, id: BufferId) -> Option<&mut Vec<u8>> {
        let slot = self.buffers.get_mut(id.0 as usize)?.as_mut()?;
        slot.version += 1;
        Some(&mut slot.bytes)
    }

    fn allocate(&mut self, label: &str, bytes: u64) -> Result<(), GpuError> {
        let free = self.descriptor.memory_bytes - self.resident;
        if bytes > free {
            return Err(self.out_of_memory(label, bytes));
        }
        self.resident += bytes;
        self.peak = self.peak.max(self.resident);
        Ok(())
    }

    fn allocate_on_host(&mut self, label: &str, bytes: u64) -> Result<(), GpuError> {
        let free = limits::HOST_BYTES - self.hosted;
        if bytes > free {
            return Err(GpuError::OutOfHostMemory {
                label: label.to_owned(),
                asked: bytes,
                free,
                budget: limits::HOST_BYTES,
            });
        }
        self.hosted += bytes;
        Ok(())
    }

    fn out_of_memory(&self, label: &str, asked: u64) -> GpuError {
        let budget = self.descriptor.memory_bytes;
        GpuError::OutOfMemory {
            label: label.to_owned(),
            asked,
            free: budget - self.resident,
            budget,
        }
    }
}

impl Buffer {
    /// The range as indices, if the buffer holds it.
    pub(super) fn range(
        &self,
        offset: u64,
        size: u64,
        what: &'static str,
    ) -> Result<Range<usize>, GpuError> {
        let holds = self.bytes.len() as u64;
        match offset.checked_add(size) {
            Some(end) if end <= holds => Ok(index_usize(offset)..index_usize(end)),
            _ => Err(GpuError::Bounds {
                label: self.label.clone(),
                holds,
                what,
                from: offset,
                to: offset.saturating_add(size),
            }),
        }
    }
}

fn blank_texels(descriptor: &TextureDescriptor<'_>) -> MipMap {
    let TextureDescriptor {
        width,
        height,
        levels,
        format,
        ..
    } = *descriptor;
    MipMap::blank(format, width, height, levels).expect("sides and levels were checked")
}

fn target_bytes(target: &Target) -> u64 {
    let samples = match target.samples() {
        Samples::One => 1,
        Samples::Four => 4,
    };
    let each = if target.has_colour() { 8 } else { 4 };
    each * samples * u64::from(target.width()) * u64::from(target.height())
}

fn check(
    label: &str,
    what: &'static str,
    found: u32,
    least: u32,
    most: u32,
) -> Result<(), GpuError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(GpuError::Descriptor {
        label: label.to_owned(),
        what,
        found: u64::from(found),
        wanted: format!("{least} to {most}"),
    })
}
