//! A block: few leaves that lie close together, and the cheapest pair among them.

use super::bound::Bounds;
use super::cost::Weights;
use super::shape::Shape;
use crate::math::index_u32;

/// The most leaves of a block.
///
/// A leaf looks at all others of its block, so this bounds the work of a collapse however densely the
/// leaves stand; and what a leaf misses lies beyond the border of its block, of which larger blocks
/// have less. Twice as many take two thirds more time for 500,000 leaves.
pub(super) const BLOCK_LEAVES: usize = 64;

/// Two leaves of a block become one.
///
/// Leaves are numbered within the block: those it began with from 0 on, then one new leaf a join.
#[derive(Debug, Clone, Copy)]
pub(super) struct Join {
    pub(super) old: [u32; 2],
    pub(super) cost: f32,
    /// Vertex numbers of the new leaf, by corner role.
    pub(super) corners: [u32; 4],
}

/// The leaves that are left of a block, each with the best partner that it found.
///
/// **Invariant.** For every pair of leaves that are left and may be joined for no more than `most`,
/// one of the two has an offer that costs no more than the pair: the later-born looked at all leaves when it was born, and
/// a leaf looks again when the partner in its offer is gone. So the cheapest offer whose leaves are
/// both left is the cheapest pair of all.
#[derive(Debug)]
pub(super) struct Block<'a> {
    weights: &'a Weights,
    /// The next four by slot: the leaves that are left, in no order.
    numbers: Vec<u32>,
    shapes: Vec<Shape>,
    bounds: Bounds,
    offers: Vec<Option<Offer>>,
    /// The slot of every leaf, old and new, or [`GONE`].
    slots: Vec<usize>,
    joins: Vec<Join>,
    /// Pairs that cost more are of no interest.
    most: f32,
}

/// The slot of a leaf that is no longer left.
const GONE: usize = usize::MAX;

/// What a leaf would pay for its best partner; the order is that of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Offer {
    /// The bits of the cost, which order as costs do: none is negative.
    cost: u32,
    partner: u32,
}

impl Offer {
    fn cost(self) -> f32 {
        f32::from_bits(self.cost)
    }
}

impl<'a> Block<'a> {
    /// A block in which every leaf knows its best partner, if that costs no more than `most`.
    pub(super) fn new(shapes: Vec<Shape>, weights: &'a Weights, most: f32) -> Self {
        let mut bounds = Bounds::default();
        for shape in &shapes {
            bounds.push(weights.outline(shape));
        }
        let count = shapes.len();
        let mut block = Self {
            weights,
            numbers: (0..index_u32(count)).collect(),
            offers: vec![None; count],
            slots: (0..count).collect(),
            shapes,
            bounds,
            joins: Vec::new(),
            most,
        };
        // A good offer first: it spares looking closely at most others.
        let mut least = Vec::new();
        for slot in 0..count {
            block.bounds.to(slot, weights, &mut least);
            if let Some(nearest) = nearest(&least, slot) {
                block.look(slot, nearest);
            }
        }
        for slot in 1..count {
            block.bounds.to(slot, weights, &mut least);
            for (other, &least) in least[..slot].iter().enumerate() {
                if least <= block.limit(slot).max(block.limit(other)) {
                    block.look(slot, other);
                }
            }
        }
        block
    }

    /// What each leaf offers, in no order; infinity for none.
    pub(super) fn costs(&self) -> impl Iterator<Item = f32> + '_ {
        let cost = |offer: &Option<Offer>| offer.map_or(f32::INFINITY, Offer::cost);
        self.offers.iter().map(cost)
    }

    /// Joins the cheapest pair of all that are left, again and again.
    pub(super) fn join_all(&mut self) {
        while let Some(pair) = self.cheapest() {
            self.join(pair);
        }
    }

    /// The joins, and the leaves that are left with their numbers.
    pub(super) fn finish(self) -> (Vec<Join>, Vec<(u32, Shape)>) {
        let left = self.numbers.into_iter().zip(self.shapes);
        (self.joins, left.collect())
    }

    /// The slots of the cheapest pair by (cost, lower number, higher number).
    fn cheapest(&mut self) -> Option<[usize; 2]> {
        loop {
            let offers = self.offers.iter().zip(&self.numbers).enumerate();
            let (_, _, slot) = offers
                .filter_map(|(slot, (offer, &number))| {
                    let Offer { cost, partner } = (*offer)?;
                    Some((cost, [number.min(partner), number.max(partner)], slot))
                })
                .min()?;
            let offer = self.offers[slot].expect("it was found among the offers");
            let partner = self.slots[offer.partner as usize];
            if partner != GONE {
                return Some([slot, partner]);
            }
            self.search(slot);
        }
    }

    fn join(&mut self, slots: [usize; 2]) {
        let mut old = slots.map(|slot| self.numbers[slot]);
        old.sort_unstable();
        let [first, second] = old.map(|number| self.slots[number as usize]);
        let pair = [&self.shapes[first], &self.shapes[second]];
        let (cost, candidate) = self
            .weights
            .cost(pair, f32::INFINITY)
            .expect("a pair on offer may be joined");
        let shape = candidate.shape(pair);
        self.joins.push(Join {
            old,
            cost,
            corners: shape.corners,
        });
        for number in old {
            self.remove(number);
        }
        let slot = self.numbers.len();
        self.numbers.push(index_u32(self.slots.len()));
        self.slots.push(slot);
        self.bounds.push(self.weights.outline(&shape));
        self.shapes.push(shape);
        self.offers.push(None);
        self.search(slot);
    }

    fn remove(&mut self, number: u32) {
        let slot = std::mem::replace(&mut self.slots[number as usize], GONE);
        self.numbers.swap_remove(slot);
        self.shapes.swap_remove(slot);
        self.bounds.swap_remove(slot);
        self.offers.swap_remove(slot);
        if let Some(&moved) = self.numbers.get(slot) {
            self.slots[moved as usize] = slot;
        }
    }

    /// Makes the best pair of a leaf its offer, if there is any.
    fn search(&mut self, slot: usize) {
        self.offers[slot] = None;
        let mut least = Vec::with_capacity(self.numbers.len());
        self.bounds.to(slot, self.weights, &mut least);
        let Some(nearest) = nearest(&least, slot) else {
            return;
        };
        let mut best = self.found(slot, nearest, self.most);
        let mut limit = best.map_or(self.most, Offer::cost);
        for (other, &least) in least.iter().enumerate() {
            if least > limit || other == slot || other == nearest {
                continue;
            }
            let Some(found) = self.found(slot, other, limit) else {
                continue;
            };
            if best.is_none_or(|best| found < best) {
                best = Some(found);
                limit = found.cost();
            }
        }
        self.offers[slot] = best;
    }

    /// What one leaf pays for another, unless it is more than `limit`.
    fn found(&self, slot: usize, other: usize, limit: f32) -> Option<Offer> {
        let pair = [&self.shapes[slot], &self.shapes[other]];
        let (cost, _) = self.weights.cost(pair, limit)?;
        Some(Offer {
            cost: cost.to_bits(),
            partner: self.numbers[other],
        })
    }

    /// Offers two leaves to each other.
    fn look(&mut self, slot: usize, other: usize) {
        let limit = self.limit(slot).max(self.limit(other));
        let Some(found) = self.found(slot, other, limit) else {
            return;
        };
        let back = Offer {
            partner: self.numbers[slot],
            ..found
        };
        for (slot, found) in [(slot, found), (other, back)] {
            let offer = &mut self.offers[slot];
            if offer.is_none_or(|best| found < best) {
                *offer = Some(found);
            }
        }
    }

    /// More than this a leaf need not pay.
    fn limit(&self, slot: usize) -> f32 {
        self.offers[slot].map_or(self.most, Offer::cost)
    }
}

/// The slot of the least bound, but for one.
fn nearest(least: &[f32], but: usize) -> Option<usize> {
    let mut nearest = None;
    let mut most = f32::INFINITY;
    for (slot, &least) in least.iter().enumerate() {
        if slot != but && (least < most || nearest.is_none()) {
            nearest = Some(slot);
            most = least;
        }
    }
    nearest
}
