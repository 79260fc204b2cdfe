//! Who owns which samples, sorted by owner: what is left to shade.

use std::ops::Range;

use crate::math::index_u32;

/// The owner of a sample that no triangle of the run has won; others are places among the winners plus one.
pub(super) const NOBODY: u32 = 0;

/// A pixel and those of its samples that one triangle owns.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Item(u32);

impl Item {
    pub(super) fn new(index: usize, mask: u32) -> Self {
        Self(index_u32(index) << 4 | mask)
    }

    #[inline]
    pub(super) fn index(self) -> usize {
        (self.0 >> 4) as usize
    }

    #[inline]
    pub(super) fn mask(self) -> u32 {
        self.0 & 15
    }
}

/// The pixels that each triangle of a run must be shaded at.
#[derive(Debug, Default)]
pub(super) struct Items {
    starts: Vec<u32>,
    pub(super) list: Vec<Item>,
}

impl Items {
    /// The places in the list of an entry's pixels.
    #[inline]
    pub(super) fn of(&self, entry: usize) -> Range<usize> {
        self.starts[entry] as usize..self.starts[entry + 1] as usize
    }

    pub(super) fn begin(&mut self, entries: usize) {
        self.starts.clear();
        self.starts.resize(entries + 2, 0);
    }

    /// Counts are kept two places on, so that filling leaves the starts in place.
    pub(super) fn count(&mut self, owner: u32) {
        self.starts[owner as usize + 1] += 1;
    }

    pub(super) fn lay_out(&mut self) {
        for at in 1..self.starts.len() {
            self.starts[at] += self.starts[at - 1];
        }
        let total = self.starts[self.starts.len() - 1] as usize;
        self.list.clear();
        self.list.resize(total, Item::default());
    }

    pub(super) fn put(&mut self, owner: u32, item: Item) {
        let next = &mut self.starts[owner as usize];
        self.list[*next as usize] = item;
        *next += 1;
    }
}

/// Hands over each distinct owner of a pixel's samples with the bits of its samples.
#[inline]
pub(super) fn each_owner<const SAMPLES: usize>(
    owners: &[u32; SAMPLES],
    mut each: impl FnMut(u32, u32),
) {
    for (sample, &owner) in owners.iter().enumerate() {
        if owner == NOBODY || owners[..sample].contains(&owner) {
            continue;
        }
        let mut mask = 0;
        for (other, &theirs) in owners.iter().enumerate() {
            mask |= u32::from(theirs == owner) << other;
        }
        each(owner, mask);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_sorted_by_owner_with_their_samples() {
        // Entries 0, 1 and 2 own samples of two pixels; the last pixel's third is nobody's.
        let pixels = [[3, 3, 1, 1], [1, 3, NOBODY, 3]];
        let mut items = Items::default();
        items.begin(3);
        for owners in &pixels {
            each_owner(owners, |owner, _| items.count(owner));
        }
        items.lay_out();
        for (owners, index) in pixels.iter().zip(10..) {
            each_owner(owners, |owner, mask| {
                items.put(owner, Item::new(index, mask));
            });
        }
        let of = |entry: usize| -> Vec<(usize, u32)> {
            let list = &items.list[items.of(entry)];
            list.iter()
                .map(|item| (item.index(), item.mask()))
                .collect()
        };
        assert_eq!(of(0), [(10, 0b1100), (11, 0b0001)]);
        assert_eq!(of(1), []);
        assert_eq!(of(2), [(10, 0b0011), (11, 0b1010)]);
    }
}
