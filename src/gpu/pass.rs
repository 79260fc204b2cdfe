//! Commands as plain data: they can be printed, compared and replayed.
//!
//! What each costs in the command stream:
//!
//! | command | bytes |
//! |---|---:|
//! | bind a program, buffer, texture or depth | 8 |
//! | draw, or draw from a counter | 20 |
//! | instanced draw, with the buffer of its instances | 28 |
//! | the same with arguments from a buffer | 16 |
//! | indirect draw, each record | 8 |
//! | indirect draw whose records the device walks by itself | 20 |
//! | begin a pass: target, load operation, clear values | 24 |
//! | copy, or one region of a gathered write | 24 |
//! | clear a buffer | 24 |
//! | dispatch | 16 |

use super::{BufferId, ComputeProgramId, ProgramId, TargetId, TextureId};
use crate::math::Vec4;

/// A command of the device.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// Draws into a target.
    Render(RenderPass),
    /// Copies within the device; both buffers must be device-resident.
    Copy {
        /// Where from.
        source: BufferId,
        /// The first byte read.
        source_offset: u64,
        /// Where to.
        destination: BufferId,
        /// The first byte written.
        destination_offset: u64,
        /// How many bytes.
        size: u64,
    },
    /// Sets bytes to zero within the device; the buffer must be device-resident.
    Clear {
        /// Where.
        buffer: BufferId,
        /// The first byte.
        offset: u64,
        /// How many bytes.
        size: u64,
    },
    /// Runs compute programs over buffers.
    Compute(ComputePass),
}

/// Draws into one target.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderPass {
    /// A name for reports.
    pub label: String,
    /// Where to.
    pub target: TargetId,
    /// What is there at the start.
    pub load: Load,
    /// What to do, in order; bindings hold until they are replaced.
    pub steps: Vec<Step>,
}

/// What a target holds when a pass begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// What the last pass left.
    Keep,
    /// One linear colour and one depth everywhere.
    Clear {
        /// Linear colour.
        color: Vec4,
        /// Depth from 0 (near) to 1 (far).
        depth: f32,
    },
}

/// A step of a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Chooses the program.
    Program(ProgramId),
    /// Sets the buffer that vertices come from.
    Vertices(BufferId),
    /// Sets the buffer that indices come from.
    Indices(BufferId),
    /// Sets a buffer that the program reads; it must be device-resident.
    Storage {
        /// The program's slot.
        slot: u32,
        /// The buffer.
        buffer: BufferId,
    },
    /// Sets a texture that the program reads.
    Texture {
        /// The program's slot.
        slot: u32,
        /// The texture.
        texture: TextureId,
    },
    /// Sets a target whose depth the fragment stage reads, another than the pass draws into.
    Depth {
        /// The program's slot, counted apart from those of textures.
        slot: u32,
        /// The target.
        target: TargetId,
    },
    /// Sets a target whose colour the fragment stage reads, another than the pass draws into.
    Colour {
        /// The program's slot, counted apart from those of textures and depths.
        slot: u32,
        /// The target.
        target: TargetId,
    },
    /// Leaves a texture slot empty.
    NoTexture {
        /// The program's slot.
        slot: u32,
    },
    /// Draws.
    Draw(Draw),
    /// Draws with arguments from a buffer.
    DrawIndirect(DrawIndirect),
    /// The same as one command, whose records the device walks by itself: on cards that compute.
    MultiDrawIndirect(DrawIndirect),
    /// Draws what a counter in a buffer leaves.
    DrawFromCounter(DrawFromCounter),
    /// Draws the same for several instances.
    DrawInstanced(DrawInstanced),
    /// Draws the same for several instances, with arguments from a buffer.
    DrawInstancedIndirect(DrawInstancedIndirect),
}

/// A draw whose arguments are in the command; they carry no state of a model. To short indices it
/// adds nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    /// Whether corners are indices from the bound index buffer, and how wide, or count up from the
    /// first.
    pub source: Corners,
    /// The first corner.
    pub first_corner: u32,
    /// How many corners.
    pub corner_count: u32,
    /// The instance; second part of the key that breaks ties of depth.
    pub instance: u32,
    /// First part of the key.
    pub group: u32,
}

/// A draw that is done once for each of several instances, in their order, whose numbers lie in a buffer: one
/// draw for the command stream, vertices and primitives of each for all else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawInstanced {
    /// Whether corners are indices or count up.
    pub source: Corners,
    /// The first corner.
    pub first_corner: u32,
    /// How many corners each has.
    pub corner_count: u32,
    /// The buffer of instances, a little-endian `u32` each, with [`Usage::VERTEX`](super::Usage::VERTEX):
    /// second parts of keys. From host memory each draw pulls them.
    pub instances: BufferId,
    /// The place of the first in it.
    pub first_instance: u32,
    /// How many there are.
    pub instance_count: u32,
    /// First part of the key.
    pub group: u32,
}

/// The same with its first corner, both counts and the first instance in a buffer: an [`IndirectRecord`], of
/// which `instance` is a place in the buffer of instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawInstancedIndirect {
    /// Whether corners are indices or count up.
    pub source: Corners,
    /// The buffer of the record, on the device.
    pub arguments: BufferId,
    /// The record's first byte.
    pub offset: u64,
    /// The buffer of instances, as [`DrawInstanced`] has it.
    pub instances: BufferId,
    /// First part of the key.
    pub group: u32,
}

/// Where the corners of primitives come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Corners {
    /// `u32` indices in the bound index buffer.
    Indexed,
    /// `u16` indices in the bound index buffer, to each of which the draw adds its first vertex.
    Short,
    /// `u32` indices in the bound index buffer as triangle strips, each ended by [`RESTART`] or the
    /// last corner, for programs that draw lists of triangles: the input assembler hands them whole
    /// triangles, the lowest index first, and leaves out those that name a vertex twice.
    Strips,
    /// The numbers from the first corner on.
    Counted,
}

impl Corners {
    /// Bytes of one index; 0 where there are none.
    #[must_use]
    pub fn index_bytes(self) -> u32 {
        match self {
            Self::Indexed | Self::Strips => 4,
            Self::Short => 2,
            Self::Counted => 0,
        }
    }

    /// Bytes of the arguments of one indirect draw: an [`IndirectRecord`], behind which short indices
    /// have what is added to them, a `u32`.
    #[must_use]
    pub fn record_bytes(self) -> u64 {
        match self {
            Self::Indexed | Self::Strips | Self::Counted => IndirectRecord::STRIDE,
            Self::Short => IndirectRecord::STRIDE + 4,
        }
    }
}

/// Draws whose arguments lie in a buffer: `count` records of
/// [`record_bytes`](Corners::record_bytes) each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawIndirect {
    /// Whether corners are indices or count up.
    pub source: Corners,
    /// The buffer.
    pub arguments: BufferId,
    /// The first byte of the first record.
    pub offset: u64,
    /// How many records.
    pub count: u32,
    /// First part of the key that breaks ties of depth.
    pub group: u32,
}

/// A draw whose first corner the device derives from a counter in a buffer, as stream-output draws
/// derive their count: corners `scale × counter .. end`. A counter of `u32::MAX` draws `0 .. end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawFromCounter {
    /// Whether corners are indices or count up.
    pub source: Corners,
    /// The buffer that holds the counter, a little-endian `u32`.
    pub counter: BufferId,
    /// The counter's first byte.
    pub offset: u64,
    /// Corners a count.
    pub scale: u32,
    /// One past the last corner.
    pub end: u32,
    /// The instance; second part of the key that breaks ties of depth.
    pub instance: u32,
    /// First part of the key.
    pub group: u32,
}

/// The arguments of one indirect draw.
///
/// | bytes | field          | type  | meaning |
/// |------:|----------------|-------|---------|
/// | 0–3   | `corner_count` | `u32` | corners to draw |
/// | 4–7   | `instances`    | `u32` | 1, or 0 to draw nothing; more for instanced draws |
/// | 8–11  | `first_corner` | `u32` | the first corner |
/// | 12–15 | `instance`     | `u32` | second part of the key; of instanced draws the place of the first instance |
///
/// Little-endian and unpadded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IndirectRecord {
    /// Corners to draw.
    pub corner_count: u32,
    /// 1, or 0 to draw nothing; [instanced draws](DrawInstancedIndirect) take more.
    pub instances: u32,
    /// The first corner.
    pub first_corner: u32,
    /// Second part of the key; of instanced draws the place of the first instance.
    pub instance: u32,
}

impl IndirectRecord {
    /// Bytes a record.
    pub const STRIDE: u64 = 16;

    /// The record's bytes.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 16] {
        let words = [
            self.corner_count,
            self.instances,
            self.first_corner,
            self.instance,
        ];
        let mut bytes = [0; 16];
        for (four, word) in bytes.chunks_exact_mut(4).zip(words) {
            four.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }
}

/// Runs compute programs over buffers and depths, on cards that can.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComputePass {
    /// A name for reports.
    pub label: String,
    /// What to do, in order; bindings hold until they are replaced.
    pub steps: Vec<ComputeStep>,
}

/// A step of a compute pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ComputeStep {
    /// Chooses the program.
    Program(ComputeProgramId),
    /// Sets a buffer that the program reads or writes; it must be device-resident.
    Storage {
        /// The program's slot.
        slot: u32,
        /// The buffer.
        buffer: BufferId,
    },
    /// Sets a target whose depth the program reads.
    Depth {
        /// The program's slot.
        slot: u32,
        /// The target.
        target: TargetId,
    },
    /// Runs the program.
    Dispatch {
        /// How many groups, each of which must own something of every slot that is written.
        groups: u32,
    },
}

/// The index that ends a strip.
pub const RESTART: u32 = u32::MAX;

pub(super) const BIND_BYTES: u64 = 8;
pub(super) const DRAW_BYTES: u64 = 20;
pub(super) const INDIRECT_BYTES: u64 = 8;
pub(super) const PASS_BYTES: u64 = 24;
pub(super) const DISPATCH_BYTES: u64 = 16;
pub(super) const CLEAR_BYTES: u64 = 24;
