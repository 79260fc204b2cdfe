//! What the device refuses, with the label and the two numbers that disagree.

/// Why a request was refused; a refused request changes nothing and counts nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The memory budget would be exceeded.
    #[error(
        "{label:?} asks for {asked} bytes of device memory, but {free} of {budget} are free; \
         raise the budget or send less"
    )]
    OutOfMemory {
        /// What was to be created.
        label: String,
        /// Bytes asked for.
        asked: u64,
        /// Bytes free.
        free: u64,
        /// Bytes in all.
        budget: u64,
    },
    /// Buffers in host memory would exceed what the simulated machine has.
    #[error("{label:?} asks for {asked} bytes of host memory, but {free} of {budget} are free")]
    OutOfHostMemory {
        /// What was to be created.
        label: String,
        /// Bytes asked for.
        asked: u64,
        /// Bytes free.
        free: u64,
        /// Bytes in all.
        budget: u64,
    },
    /// A range reaches past the end of a resource.
    #[error("{label:?} holds {holds} bytes, {what} wants {from}..{to}")]
    Bounds {
        /// The resource.
        label: String,
        /// Its size in bytes.
        holds: u64,
        /// Who asks.
        what: &'static str,
        /// First byte asked for.
        from: u64,
        /// One past the last byte asked for.
        to: u64,
    },
    /// A resource is used in a way that it was not created for.
    #[error("{label:?} was created for {has}, but is used as {wanted}")]
    Usage {
        /// The resource.
        label: String,
        /// The usages it has.
        has: String,
        /// The usage asked for.
        wanted: String,
    },
    /// A handle names nothing on this device.
    #[error("{what} {index} does not exist on this device")]
    Unknown {
        /// The kind of resource.
        what: &'static str,
        /// The handle's number.
        index: u32,
    },
    /// A draw needs a binding that is not set.
    #[error("program {program:?} draws without {what} {slot}")]
    Unbound {
        /// The program.
        program: String,
        /// The kind of binding.
        what: &'static str,
        /// The slot.
        slot: u32,
    },
    /// A resource is described in a way that cannot be.
    #[error("{label:?}: {what} is {found}, wanted {wanted}")]
    Descriptor {
        /// The resource.
        label: String,
        /// Which property.
        what: &'static str,
        /// What it is.
        found: u64,
        /// What it may be.
        wanted: String,
    },
    /// A count in a draw does not fit its topology.
    #[error("a draw of program {program:?} has {corners} corners, not a multiple of {wanted}")]
    Corners {
        /// The program.
        program: String,
        /// Corners asked for.
        corners: u32,
        /// Corners a primitive.
        wanted: u32,
    },
    /// A card is asked for compute passes that has none.
    #[error("card {card:?} runs no compute passes; these do: {others}")]
    NoCompute {
        /// The card.
        card: String,
        /// The cards that do.
        others: String,
    },
    /// Part of the format, but not executed by this version.
    #[error("{what} is not supported by this version")]
    Unsupported {
        /// What was asked for.
        what: String,
    },
}
