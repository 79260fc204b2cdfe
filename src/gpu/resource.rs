//! Buffers, textures and targets: labels, usages, where they live.

use super::GpuError;
use crate::raster::{MipMap, Samples, Target, TextureFormat};

macro_rules! handles {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub(super) u32);

        impl $name {
            /// The number, in the order of creation.
            #[must_use]
            pub fn index(self) -> u32 {
                self.0
            }
        }
    )*};
}

handles! {
    /// A buffer of one device.
    BufferId;
    /// A texture of one device.
    TextureId;
    /// A render target of one device.
    TargetId;
    /// A program registered on one device.
    ProgramId;
    /// A compute program registered on one device.
    ComputeProgramId;
}

/// What a buffer may be used for; combine with `|`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Usage(u32);

impl Usage {
    /// Vertices, read by the input assembler.
    pub const VERTEX: Self = Self(1);
    /// `u32` indices, read by the input assembler.
    pub const INDEX: Self = Self(2);
    /// Read by programs.
    pub const STORAGE: Self = Self(4);
    /// Draw arguments.
    pub const INDIRECT: Self = Self(8);
    /// Source of copies and of [`Queue::read`](super::Queue::read).
    pub const COPY_SOURCE: Self = Self(16);

    /// Whether all of `wanted` is in it.
    #[must_use]
    pub fn contains(self, wanted: Self) -> bool {
        self.0 & wanted.0 == wanted.0
    }
}

impl std::ops::BitOr for Usage {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl std::fmt::Debug for Usage {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = ["VERTEX", "INDEX", "STORAGE", "INDIRECT", "COPY_SOURCE"];
        let mut list = out.debug_set();
        for (bit, name) in names.iter().enumerate() {
            if self.0 >> bit & 1 == 1 {
                list.entry(&format_args!("{name}"));
            }
        }
        list.finish()
    }
}

/// Where a buffer's bytes lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Residency {
    /// In device memory: writes cross the bus, draws read for free.
    Device,
    /// In host memory (the papers' "not hardware-oriented"): writes are free, every draw pulls what
    /// it reads over the bus, again each time. Vertices, indices and draw arguments may lie there;
    /// copies, clears and programs' storage may not, since nothing would count them.
    Host,
}

/// How to make a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferDescriptor<'a> {
    /// A name for ledgers and errors.
    pub label: &'a str,
    /// Bytes; may be 0.
    pub size: u64,
    /// What it may be used for.
    pub usage: Usage,
    /// Where it lives.
    pub residency: Residency,
}

/// How to make a texture: [`TextureFormat::texel_bytes`] a texel of each level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureDescriptor<'a> {
    /// A name for ledgers and errors.
    pub label: &'a str,
    /// What its texels are.
    pub format: TextureFormat,
    /// Texels a row of the largest level.
    pub width: u32,
    /// Rows of the largest level.
    pub height: u32,
    /// How many levels, each half the last, rounded down, at least 1.
    pub levels: u32,
}

/// How to make a render target: colour of 4 bytes and depth of 4 bytes a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TargetDescriptor<'a> {
    /// A name for ledgers and errors.
    pub label: &'a str,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel.
    pub samples: Samples,
}

#[derive(Debug)]
pub(super) struct Buffer {
    pub(super) label: String,
    pub(super) usage: Usage,
    pub(super) residency: Residency,
    pub(super) bytes: Vec<u8>,
    /// Another number whenever the bytes may have changed.
    pub(super) version: u64,
}

impl Buffer {
    pub(super) fn check_usage(&self, wanted: Usage) -> Result<(), GpuError> {
        if self.usage.contains(wanted) {
            return Ok(());
        }
        Err(GpuError::Usage {
            label: self.label.clone(),
            has: format!("{:?}", self.usage),
            wanted: format!("{wanted:?}"),
        })
    }

    /// Refuses a buffer in host memory for what would move its bytes past the bus.
    pub(super) fn check_on_device(&self, wanted: &str) -> Result<(), GpuError> {
        match self.residency {
            Residency::Device => Ok(()),
            Residency::Host => Err(GpuError::Usage {
                label: self.label.clone(),
                has: "host memory".to_owned(),
                wanted: wanted.to_owned(),
            }),
        }
    }
}

#[derive(Debug)]
pub(super) struct TextureSlot {
    pub(super) label: String,
    pub(super) texels: MipMap,
}

#[derive(Debug)]
pub(super) struct TargetSlot {
    pub(super) label: String,
    pub(super) target: Target,
}

impl TargetSlot {
    pub(super) fn check_colour(&self) -> Result<(), GpuError> {
        if self.target.has_colour() {
            return Ok(());
        }
        Err(GpuError::Usage {
            label: self.label.clone(),
            has: "depth alone".to_owned(),
            wanted: "colour".to_owned(),
        })
    }
}
