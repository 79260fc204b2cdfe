//! In which order the triangles of a run are decided.

use std::ops::Range;

use crate::math::index_u32;

/// Entries in the order in which they are decided: roughly from near to far.
#[derive(Debug, Default)]
pub(super) struct Order {
    pub(super) entries: Vec<u32>,
    slots: Vec<u8>,
}

impl Order {
    /// Sorts by depth into some slots, by counting; within a slot the order stays.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float becomes a slot by the language's saturating cast"
    )]
    pub(super) fn sort(&mut self, entries: Range<usize>, depth: impl Fn(usize) -> f32) {
        const SLOTS: usize = 64;
        let (mut nearest, mut furthest) = (1.0_f32, 0.0_f32);
        for depth in entries.clone().map(&depth) {
            nearest = if depth < nearest { depth } else { nearest };
            furthest = if depth > furthest { depth } else { furthest };
        }
        let scale = (SLOTS - 1) as f32 / (furthest - nearest).max(f32::MIN_POSITIVE);
        self.slots.clear();
        let mut next = [0_u32; SLOTS + 1];
        for entry in entries.clone() {
            let slot = ((depth(entry) - nearest) * scale) as u8 % SLOTS as u8;
            self.slots.push(slot);
            next[usize::from(slot) + 1] += 1;
        }
        for slot in 1..next.len() {
            next[slot] += next[slot - 1];
        }
        self.entries.clear();
        self.entries.resize(entries.len(), 0);
        for (entry, &slot) in entries.zip(&self.slots) {
            let place = &mut next[usize::from(slot)];
            self.entries[*place as usize] = index_u32(entry);
            *place += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_come_first_and_equals_stay_in_order() {
        let depths = [0.9, 0.1, 0.5, 0.1, 0.9];
        let mut order = Order::default();
        order.sort(0..5, |entry| depths[entry]);
        assert_eq!(order.entries, [1, 3, 2, 0, 4]);
        order.sort(3..4, |entry| depths[entry]);
        assert_eq!(order.entries, [3]);
        order.sort(0..3, |_| 1.0);
        assert_eq!(order.entries, [0, 1, 2]);
    }
}
