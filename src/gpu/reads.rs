//! Which bytes draws have read: what a comparison of device memory has to look at.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use super::BufferId;

/// Bytes read by draws and compute passes, in words of four, by buffer; and what was pulled from host
/// memory. A word that a compute pass wrote before it was read does not count: what it held when
/// tracking began makes no difference.
#[derive(Debug, Default)]
pub struct ReadSet {
    words: BTreeMap<BufferId, Vec<AtomicU64>>,
    /// Words that a compute pass wrote.
    overwritten: BTreeMap<BufferId, Vec<AtomicU64>>,
    /// What draws pulled from host-resident buffers, a primitive an entry.
    pub fetched: Vec<Fetched>,
}

/// What one primitive pulled from host memory.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fetched {
    /// First part of the primitive's key.
    pub group: u32,
    /// Second part.
    pub instance: u32,
    /// The index of its first vertex.
    pub vertex: u32,
    /// Its indices and vertices, little-endian, as far as they lie in host memory.
    pub bytes: Vec<u8>,
}

impl ReadSet {
    pub(super) fn watch(&mut self, buffer: BufferId, bytes: usize) {
        for sets in [&mut self.words, &mut self.overwritten] {
            sets.entry(buffer).or_insert_with(|| {
                (0..bytes.div_ceil(256))
                    .map(|_| AtomicU64::new(0))
                    .collect()
            });
        }
    }

    /// Notes that a compute pass wrote whole words.
    pub(super) fn overwrite(&self, buffer: BufferId, range: Range<usize>) {
        let Some(words) = self.overwritten.get(&buffer) else {
            return;
        };
        for word in range.start / 4..range.end / 4 {
            if let Some(bits) = words.get(word / 64) {
                bits.fetch_or(1 << (word % 64), Ordering::Relaxed);
            }
        }
    }

    pub(super) fn mark(&self, buffer: BufferId, range: Range<usize>) {
        let (Some(words), Some(overwritten)) =
            (self.words.get(&buffer), self.overwritten.get(&buffer))
        else {
            return;
        };
        for word in range.start / 4..range.end.div_ceil(4) {
            let (Some(bits), Some(gone)) = (words.get(word / 64), overwritten.get(word / 64))
            else {
                continue;
            };
            if gone.load(Ordering::Relaxed) >> (word % 64) & 1 == 0 {
                bits.fetch_or(1 << (word % 64), Ordering::Relaxed);
            }
        }
    }

    /// The buffers that were bound while reads were tracked.
    pub fn buffers(&self) -> impl Iterator<Item = BufferId> + '_ {
        self.words.keys().copied()
    }

    /// The byte ranges of `buffer` that were read, ascending, in multiples of four bytes.
    #[must_use]
    pub fn ranges(&self, buffer: BufferId) -> Vec<Range<u64>> {
        let mut ranges: Vec<Range<u64>> = Vec::new();
        let Some(words) = self.words.get(&buffer) else {
            return ranges;
        };
        for (block, bits) in words.iter().enumerate() {
            let bits = bits.load(Ordering::Relaxed);
            for bit in (0..64).filter(|bit| bits >> bit & 1 == 1) {
                let start = 4 * (64 * block as u64 + bit);
                match ranges.last_mut() {
                    Some(last) if last.end == start => last.end += 4,
                    _ => ranges.push(start..start + 4),
                }
            }
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_words_join() {
        let mut reads = ReadSet::default();
        let buffer = BufferId(3);
        reads.watch(buffer, 1000);
        reads.mark(buffer, 250..262);
        reads.mark(buffer, 262..264);
        reads.mark(buffer, 0..1);
        assert_eq!(reads.ranges(buffer), [0..4, 248..264]);
        assert!(reads.ranges(BufferId(4)).is_empty());
    }
}
