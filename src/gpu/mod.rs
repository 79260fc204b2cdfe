//! The simulated GPU: explicit memory, one door, and a ledger of all that passes.
//!
//! ```text
//!             write, write_regions, read               present
//!  host ═════════════════▶ Queue ══▶ Bus ══▶ buffers      ▲
//!                            │       │ counts   textures  │
//!                          submit    ▼             │    targets
//!                            ├──▶ passes ──▶ vertex stage ──▶ raster
//!                            ├──▶ compute passes ──▶ groups, each with bytes of its own
//!                            └──▶ Ledger: upload | fetch | readback | command
//! ```
//!
//! It speaks like wgpu, synchronously. Four streams are counted apart and never added: `upload`,
//! `fetch` (what draws pull from host-resident buffers: indices, and vertices through a
//! post-transform cache of 16), `readback`, and the bytes of the command stream (table in
//! [`Command`]'s module). Payload is a fact; wire bytes and times are a model of a [`Link`].
//!
//! **Invariant.** Device memory changes only through [`Queue`], and `Queue` goes through the bus:
//! replaying the recorded changes into zeroed arrays gives what the device holds, and the lengths of
//! the writes among them add up to the ledger. What a compute pass wrote is recorded as bytes too, so
//! that replaying needs no program; it crosses no bus and is no write. (The one exception, [`Device::poison`], exists to test that.)
//!
//! This stage has never heard of a tree.

mod assemble;
mod bus;
mod card;
mod colour;
mod compute;
mod depth;
mod device;
mod dispatch;
mod error;
mod execute;
mod ledger;
mod link;
mod mesh;
mod pass;
mod plan;
mod program;
mod queue;
mod reads;
mod resource;

/// What the stages of a program are written against.
pub use crate::raster::{
    Blend, Fragment, Geometry, Instructions, Kernel, MAX_FLATS, MAX_VARYINGS, MipMap, Pixel,
    PixelLanes, TextureFormat, Topology, Wrap,
};
/// How a device rasterizes, and how often targets are sampled.
pub use crate::raster::{Counters, Options, Samples, TileSize};
/// What a pixel is asked, and what it answers.
pub use crate::raster::{Image, Key, ProbedFragment, Target, TargetLayer};
pub use bus::{Recording, RecordingEntry, ResourceId};
pub use card::{Card, DispatchWork, DrawWork};
pub use colour::ColourMap;
pub use compute::{Access, ComputeLayout, ComputeProgram, Group};
pub use depth::DepthMap;
pub use device::{Device, DeviceDescriptor};
pub use error::GpuError;
pub use ledger::{Cause, ComputeCounts, Ledger, Share, Stream, Traffic, Transfer, WorkCounts};
pub use link::{Link, TICKS_PER_NANOSECOND, Ticks, nanoseconds};
pub use pass::{
    Command, ComputePass, ComputeStep, Corners, Draw, DrawFromCounter, DrawIndirect, DrawInstanced,
    DrawInstancedIndirect, IndirectRecord, Load, RESTART, RenderPass, Step,
};
pub use program::{Bindings, Hulls, Layout, MAX_SLOTS, Program, Transform, VertexCall, Words};
pub use queue::{Queue, Region};
pub use reads::{Fetched, ReadSet};
pub use resource::{
    BufferDescriptor, BufferId, ComputeProgramId, ProgramId, Residency, TargetDescriptor, TargetId,
    TextureDescriptor, TextureId, Usage,
};
