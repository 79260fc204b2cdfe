//! What a model that lives on a device has to tell so that it can be tested.

use std::ops::Range;

use super::{Law, Tally, Violation, laws};
pub use crate::gpu::Residency;
use crate::models::State;
/// A picture: size, and the bytes R, G, B, A of each pixel.
pub use crate::raster::Image as Picture;

/// A model that keeps something on a device and sends what a change of detail needs.
///
/// The device may be any: real, simulated, or a few arrays in a test. The model tells what lies
/// there as bytes; what it cannot tell (a log, counters, a picture) it leaves out, and the laws that
/// need it are not checked.
///
/// Resources are numbered by their place in [`resources`](Self::resources): the same ones in the same
/// order for the model's whole life, and for every model of the same history.
///
/// `S` tells its levels of detail; foliage has [`State`]s.
pub trait DeviceModel<S = State> {
    /// Goes over to another state, sending what differs.
    fn commit(&mut self, to: &S);

    /// All that lies on the device, or is pulled from host memory by draws.
    fn resources(&self) -> Vec<Resource<'_>>;

    /// Which bytes a draw of the present state may read, and what it pulls from host memory.
    fn reads(&mut self) -> Reads;

    /// Overwrites bytes behind the back of all counters: how dead bytes are poisoned.
    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]);

    /// Every change of device memory since the model's start, in order.
    fn log(&self) -> Option<Vec<Change<'_>>> {
        None
    }

    /// What was counted since the model's start.
    fn counted(&mut self) -> Option<Counted> {
        None
    }

    /// What it draws.
    fn picture(&mut self) -> Option<Picture> {
        None
    }
}

/// Bytes that a model keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resource<'a> {
    /// A name for people.
    pub name: &'a str,
    /// Where it lies. What lies in host memory is in no log.
    pub residency: Residency,
    /// All of it, as it is now.
    pub bytes: &'a [u8],
}

/// What a draw reads.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reads {
    /// Resources with ranges of their bytes, in any order.
    pub ranges: Vec<(usize, Range<usize>)>,
    /// What it pulls from host memory, a primitive an entry, in an order that does not depend on
    /// the way to the state.
    pub fetched: Vec<Vec<u8>>,
}

/// One change of device memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change<'a> {
    /// Bytes from the host.
    Write {
        /// The number of the transfer that brought them, from 0, ascending; a gathered write has
        /// several writes of one number.
        transfer: u64,
        /// Where to.
        resource: usize,
        /// The first byte.
        at: u64,
        /// The bytes.
        bytes: &'a [u8],
    },
    /// Bytes copied within the device.
    Copy {
        /// Where from.
        source: usize,
        /// The first byte read.
        source_at: u64,
        /// Where to.
        resource: usize,
        /// The first byte written.
        at: u64,
        /// How many.
        size: u64,
    },
    /// Bytes that the device computed and wrote within itself: no traffic.
    Computed {
        /// Where.
        resource: usize,
        /// The first byte.
        at: u64,
        /// The bytes.
        bytes: &'a [u8],
    },
    /// Bytes set to zero within the device.
    Clear {
        /// Where.
        resource: usize,
        /// The first byte.
        at: u64,
        /// How many.
        size: u64,
    },
}

/// What was counted of the way to the device.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Counted {
    /// Transfers.
    pub transfers: u64,
    /// Bytes in them.
    pub payload_bytes: u64,
    /// The same, itemised in some ways (by cause, by buffer): each must give the same sums.
    pub itemised: Vec<Itemised>,
}

/// One way in which traffic is itemised.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Itemised {
    /// By what.
    pub by: &'static str,
    /// The sum of all items' transfers.
    pub transfers: u64,
    /// The sum of all items' bytes.
    pub payload_bytes: u64,
}

/// Takes a model through states and checks after each of them [residency](laws::residency), and at
/// the end [conservation](laws::conservation) and [image equality](laws::image_equality), against
/// models that `build` makes anew in a state.
///
/// # Errors
///
/// The first law that is broken, with the step.
pub fn check_device_model<S, M: DeviceModel<S>>(
    start: &S,
    states: &[S],
    build: impl Fn(&S) -> M,
    tally: &mut Tally,
) -> Result<(), Violation> {
    let mut walked = build(start);
    let mut last = start;
    for (number, state) in (1..).zip(states) {
        walked.commit(state);
        last = state;
        let law = laws::residency(&mut walked, &mut build(state));
        tally
            .count(Law::Residency, law)
            .map_err(|violation| violation.at(&format!("after step {number}")))?;
    }
    check_end(&mut walked, &mut build(last), None, tally)
        .map_err(|violation| violation.at("at the end"))
}

/// Checks [conservation](laws::conservation) and [image equality](laws::image_equality) of a model
/// at the end of a walk, against one made anew in its state and, if there is one, a picture of the
/// same leaves. The model is of no use afterwards: its dead bytes are poisoned.
///
/// # Errors
///
/// The first law that is broken.
pub fn check_end<S>(
    walked: &mut dyn DeviceModel<S>,
    fresh: &mut dyn DeviceModel<S>,
    reference: Option<&Picture>,
    tally: &mut Tally,
) -> Result<(), Violation> {
    if walked.log().is_some() {
        let law = laws::conservation(walked);
        tally.count(Law::Conservation, law)?;
    }
    if fresh.picture().is_some() {
        let law = laws::image_equality(walked, fresh, reference);
        tally.count(Law::ImageEquality, law)?;
    } else {
        laws::poison_dead_bytes(walked, &fresh.reads());
        let law = laws::residency(walked, fresh);
        tally.count(Law::Residency, law)?;
    }
    Ok(())
}
