//! The simulated GPU: explicit memory, one door, and a ledger of all that passes.
//!
//! ```text
//!             write, write_regions, read               present
//!  host ═════════════════▶ Queue ══▶ Bus ══▶ buffers      ▲
//!                            │       │ counts   textures  │
//!                          submit    ▼             │    targets
//!                            └──▶ passes ──▶ vertex stage ──▶ raster
//!                                    └──▶ Ledger: upload | fetch | readback | command
//! ```
//!
//! It speaks like wgpu, synchronously. Four streams are counted apart and never added: `upload`,
//! `fetch` (what draws pull from host-resident buffers: indices, and vertices through a
//! post-transform cache of 16), `readback`, and the bytes of the command stream (table in
//! [`Command`]'s module). Payload is a fact; wire bytes and times are a model of a [`Link`].
//!
//! **Invariant.** Device memory changes only through [`Queue`], and `Queue` goes through the bus:
//! replaying the recorded writes into zeroed arrays gives what the device holds, and their lengths
//! add up to the ledger. (The one exception, [`Device::poison`], exists to test that.)
//!
//! This stage has never heard of a tree.

mod assemble;
mod bus;
mod card;
mod device;
mod error;
mod execute;
mod ledger;
mod link;
mod pass;
mod plan;
mod program;
mod queue;
mod reads;
mod resource;

/// What the stages of a program are written against.
pub use crate::raster::{
    Blend, Fragment, Geometry, Kernel, MAX_FLATS, MAX_VARYINGS, MipMap, Pixel, Topology, Wrap,
};
/// What a pixel is asked, and what it answers.
pub use crate::raster::{Image, Key, ProbedFragment, Target};
pub use bus::{Recording, RecordingEntry, ResourceId};
pub use card::{Card, DrawWork};
pub use device::{Device, DeviceDescriptor};
pub use error::GpuError;
pub use ledger::{Cause, Ledger, Share, Stream, Traffic, Transfer, WorkCounts};
pub use link::{Link, TICKS_PER_NANOSECOND, Ticks, nanoseconds};
pub use pass::{
    Command, ComputePass, Corners, Draw, DrawFromCounter, DrawIndirect, IndirectRecord, Load,
    RenderPass, Step,
};
pub use program::{Bindings, Layout, MAX_SLOTS, Program, VertexCall, Words};
pub use queue::{Queue, Region};
pub use reads::{Fetched, ReadSet};
pub use resource::{
    BufferDescriptor, BufferId, ProgramId, Residency, TargetDescriptor, TargetId,
    TextureDescriptor, TextureId, Usage,
};
