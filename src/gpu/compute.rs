//! Compute programs: what they may read, and which bytes each of their groups owns.
//!
//! A group owns a range of every slot that its program writes: `group_bytes` bytes at
//! `number × group_bytes`, the last one cut at the buffer's end. It may read what it owns, and the
//! whole of the slots that are only read, be they buffers or the depth of a target; it never sees
//! what other groups of the same dispatch write. So no two groups can write the same byte, and the result depends neither on their order
//! nor on the number of threads. Dispatches follow one another, each wholly after the one before.

use super::program::{MAX_SLOTS, Words};
use super::reads::ReadSet;
use super::{BufferId, DepthMap, GpuError};

/// A program that turns buffers into buffers, with a stable identity. Parameters are bytes in
/// buffers.
pub trait ComputeProgram: Send + Sync + std::fmt::Debug {
    /// What the program is bound to, and what it takes.
    fn layout(&self) -> ComputeLayout;

    /// Does the work of one group.
    fn run(&self, group: &mut Group<'_>);
}

/// What a compute program is bound to, and what it takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ComputeLayout {
    /// A stable name.
    pub name: &'static str,
    /// Counts up when the program computes anything else.
    pub version: u32,
    /// How each slot is used, from 0; all of them must be bound, those that are written to buffers
    /// that no other slot has.
    pub slots: &'static [Access],
    /// Arithmetic operations of a group, at most; only the modelled time on the card depends on it.
    pub group_operations: u32,
}

/// How a slot is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Every group may read all of it.
    Read,
    /// The same of what earlier frames left, which may decide how a picture comes about and never what
    /// it shows: whatever lies there, and so no [reads](super::ReadSet) are noted.
    Recall,
    /// Every group may read the depth of all pixels of a target.
    Depth,
    /// Every group may read and write what it owns of it.
    Own {
        /// Bytes that a group owns: a multiple of 4, above 0.
        group_bytes: u32,
    },
    /// The same of an even share of the buffer: as many bytes as it has, divided by the number of groups,
    /// which must be a multiple of 4.
    Share,
}

impl Access {
    /// Whether groups write.
    pub(super) fn writes(self) -> bool {
        matches!(self, Self::Own { .. } | Self::Share)
    }
}

impl ComputeLayout {
    /// Refuses a layout that nothing can be done with.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        let refused = |what, found, wanted: &str| GpuError::Descriptor {
            label: self.name.to_owned(),
            what,
            found,
            wanted: wanted.to_owned(),
        };
        let owned = |access: &Access| match *access {
            Access::Own { group_bytes } => Some(group_bytes),
            Access::Read | Access::Recall | Access::Depth | Access::Share => None,
        };
        if self.slots.len() > MAX_SLOTS {
            let wanted = format!("at most {MAX_SLOTS}");
            return Err(refused("number of slots", self.slots.len() as u64, &wanted));
        }
        if !self.slots.iter().any(|access| access.writes()) {
            return Err(refused("number of slots that it writes", 0, "at least 1"));
        }
        let mut sizes = self.slots.iter().filter_map(owned);
        match sizes.find(|size| *size == 0 || size % 4 != 0) {
            Some(size) => Err(refused(
                "bytes that a group owns",
                u64::from(size),
                "a multiple of 4, above 0",
            )),
            None => Ok(()),
        }
    }
}

/// One group of a dispatch, with what it may read and write.
#[derive(Debug)]
pub struct Group<'a> {
    pub(super) number: u32,
    pub(super) slots: Vec<GroupSlot<'a>>,
    /// Bytes read and written so far.
    pub(super) bytes: u64,
}

/// What a group has of a slot.
#[derive(Debug)]
pub(super) enum GroupSlot<'a> {
    /// All of a buffer.
    All(Words<'a>),
    /// The depth of a target.
    Depth(DepthMap<'a>),
    /// The bytes that the group owns, and where they begin in their buffer.
    Own {
        buffer: BufferId,
        first: usize,
        bytes: &'a mut [u8],
        reads: Option<&'a ReadSet>,
    },
}

impl Group<'_> {
    /// Its number, from 0.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// How many whole words a slot has: of a slot that is written, those that the group owns.
    #[must_use]
    pub fn len(&self, slot: usize) -> usize {
        match self.slots.get(slot) {
            None | Some(GroupSlot::Depth(_)) => 0,
            Some(GroupSlot::All(words)) => words.len(),
            Some(GroupSlot::Own { bytes, .. }) => bytes.len() / 4,
        }
    }

    /// Whether a slot has no word.
    #[must_use]
    pub fn is_empty(&self, slot: usize) -> bool {
        self.len(slot) == 0
    }

    /// A word of a slot; of a slot that is written, counted from the first that the group owns.
    /// Reading past the end gives 0.
    #[must_use]
    pub fn u32(&mut self, slot: usize, index: usize) -> u32 {
        self.u32s::<1>(slot, index)[0]
    }

    /// `N` words from `index` on.
    #[must_use]
    pub fn u32s<const N: usize>(&mut self, slot: usize, index: usize) -> [u32; N] {
        self.bytes += 4 * N as u64;
        match self.slots.get(slot) {
            None | Some(GroupSlot::Depth(_)) => [0; N],
            Some(GroupSlot::All(words)) => words.u32s(index),
            Some(GroupSlot::Own {
                buffer,
                first,
                bytes,
                reads,
            }) => {
                let end = 4 * (index + N).min(bytes.len() / 4);
                if let Some(reads) = reads {
                    reads.mark(*buffer, first + (4 * index).min(end)..first + end);
                }
                let words = bytes.as_chunks::<4>().0;
                let word = |place| words.get(index + place).copied().unwrap_or_default();
                std::array::from_fn(|place| u32::from_le_bytes(word(place)))
            }
        }
    }

    /// `N` words from `index` on as floats.
    #[must_use]
    pub fn f32s<const N: usize>(&mut self, slot: usize, index: usize) -> [f32; N] {
        self.u32s(slot, index).map(f32::from_bits)
    }

    /// Columns and rows of the target whose depth a slot has; none of any other slot.
    #[must_use]
    pub fn size(&self, slot: usize) -> [u32; 2] {
        match self.slots.get(slot) {
            Some(GroupSlot::Depth(map)) => map.size(),
            _ => [0; 2],
        }
    }

    /// The greatest depth of the samples of a pixel, from 0 (near) to 1 (far): 4 bytes read a sample.
    /// Beside the target it is 0.
    #[must_use]
    pub fn farthest_depth(&mut self, slot: usize, [x, y]: [u32; 2]) -> f32 {
        let Some(GroupSlot::Depth(map)) = self.slots.get(slot) else {
            return 0.0;
        };
        let [width, height] = map.size();
        if x >= width || y >= height {
            return 0.0;
        }
        self.bytes += map.pixel_bytes();
        map.farthest([x, y])
    }

    /// Writes a word that the group owns, counted from the first; anything else is dropped.
    pub fn set(&mut self, slot: usize, index: usize, word: u32) {
        self.bytes += 4;
        let Some(GroupSlot::Own {
            buffer,
            first,
            bytes,
            reads,
        }) = self.slots.get_mut(slot)
        else {
            return;
        };
        if let Some(four) = bytes.get_mut(4 * index..4 * index + 4) {
            four.copy_from_slice(&word.to_le_bytes());
            if let Some(reads) = reads {
                let from = *first + 4 * index;
                reads.overwrite(*buffer, from..from + 4);
            }
        }
    }
}
