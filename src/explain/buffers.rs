//! What two devices hold, record by record.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::MAX_LISTED;
use super::operations::hexadecimal;
use crate::gpu::{BufferId, RESTART, ResourceId};
use crate::models::Crown;
use crate::run::{Owner, Session, World};

/// A buffer that two devices do not hold the same in.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BufferDifference {
    /// Its label.
    pub label: String,
    /// What it belongs to: `scene`, `plant 0`, `tree 0`.
    pub owner: String,
    /// Its bytes in A and in B; `None` where a device has no such buffer.
    pub bytes: [Option<u64>; 2],
    /// Bytes of one record.
    pub stride: u64,
    /// Where only one of the two holds something and the rest is the same: that range of it.
    pub inserted: Option<Insertion>,
    /// Records of the common length that differ, place by place.
    pub differing_records: u64,
    /// How many ranges they form.
    pub range_count: u64,
    /// The first of them, ascending.
    pub ranges: Vec<RecordDifference>,
}

/// Bytes that one of two buffers has more, in one piece.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Insertion {
    /// `a` or `b`: which of them.
    pub side: &'static str,
    /// The first byte, in that one.
    pub start: u64,
    /// One past the last.
    pub end: u64,
    /// The first record of it, in words.
    pub record: String,
}

/// A range of whole records that differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RecordDifference {
    /// The first byte.
    pub start: u64,
    /// One past the last.
    pub end: u64,
    /// The first record's number.
    pub record: u64,
    /// What A holds there, in words.
    pub a: String,
    /// What B holds there.
    pub b: String,
}

/// An owner in words.
pub(super) fn owner_name(owner: Owner) -> String {
    match owner {
        Owner::Scene => "scene".to_owned(),
        Owner::Plant(plant) => format!("plant {plant}"),
        Owner::Tree(tree) => format!("tree {tree}"),
    }
}

/// Understands the bytes of one session's buffers.
#[derive(Debug)]
pub(super) struct Reader<'s> {
    session: &'s Session<'s>,
    world: &'s World,
    /// The leaves of each plant by their corners; of equal ones the first.
    leaves: Vec<BTreeMap<[u32; 4], u32>>,
}

impl<'s> Reader<'s> {
    pub(super) fn new(session: &'s Session<'s>, world: &'s World) -> Self {
        let leaves = world.crowns.iter().map(|crown| {
            let mut leaves = BTreeMap::new();
            for (leaf, corners) in (0..).zip(crown.sequence().corners()) {
                leaves.entry(*corners).or_insert(leaf);
            }
            leaves
        });
        Self {
            leaves: leaves.collect(),
            session,
            world,
        }
    }

    /// The plant that a resource belongs to, or that its tree is.
    fn plant(&self, owner: Owner) -> Option<(usize, &Arc<Crown>)> {
        let plant = match owner {
            Owner::Scene => return None,
            Owner::Plant(plant) => plant,
            Owner::Tree(tree) => self.world.trees.get(tree as usize)?.crown,
        };
        Some((plant, self.world.crowns.get(plant)?))
    }

    /// The record of a buffer that has the byte `at`, in words; `bytes` begin at `offset`, and do not
    /// hold the record where they begin or end within it.
    pub(super) fn describe(
        &self,
        resource: ResourceId,
        at: u64,
        offset: u64,
        bytes: &[u8],
    ) -> Option<String> {
        let ResourceId::Buffer(buffer) = resource else {
            return None;
        };
        let mut buffers = self.session.device().buffers();
        let (_, label) = buffers.find(|(id, _)| *id == buffer)?;
        let stride = stride(label);
        let number = at / stride;
        let from = usize::try_from((number * stride).checked_sub(offset)?).ok()?;
        let whole = usize::try_from(stride).ok()?;
        let record = bytes.get(from..from.checked_add(whole)?)?;
        Some(self.record(self.session.owner(resource), label, number, record))
    }

    /// A record in words.
    fn record(&self, owner: Owner, label: &str, number: u64, bytes: &[u8]) -> String {
        let words: Vec<u32> = bytes
            .chunks_exact(4)
            .map(|four| u32::from_le_bytes(four.try_into().expect("chunks of four bytes")))
            .collect();
        let plant = self.plant(owner);
        let leaf = |corners: [u32; 4]| {
            let known = plant.and_then(|(plant, _)| self.leaves.get(plant)?.get(&corners));
            match known {
                Some(leaf) => format!("leaf {leaf}"),
                None if corners == [0; 4] => "empty".to_owned(),
                None => format!("no leaf, corners {corners:?}"),
            }
        };
        let floats = |words: &[u32]| {
            let numbers = words.iter().map(|word| f32::from_bits(*word).to_string());
            numbers.collect::<Vec<_>>().join(" ")
        };
        match (label, words.as_slice()) {
            ("leaf records" | "leaf list", &[a, b, c, d]) => {
                format!("slot {number}: {}", leaf([a, b, c, d]))
            }
            ("stamped records", &[a, b, c, d, birth, cluster]) => {
                let leaf = leaf([a, b, c, d]);
                format!("record {number}: {leaf}, born by {birth}, cluster {cluster}")
            }
            ("leaf vertices", &[_, _, _]) => {
                let sequence = plant.map(|(_, crown)| crown.sequence());
                let leaf = sequence.zip(u32::try_from(number).ok());
                let leaf = leaf.map_or(number / 4, |(sequence, vertex)| {
                    sequence.leaf_of_vertex(vertex).into()
                });
                let (role, at) = (number % 4, floats(&words));
                format!("vertex {number} (leaf {leaf}, corner {role}): {at}")
            }
            ("draw arguments" | "leaf list arguments", &[corners, ..]) => {
                format!("draw {number}: {} leaves", corners / 4)
            }
            ("thresholds", &[stamp]) => format!("cluster {number}: stamp {stamp}"),
            ("counter", &[u32::MAX]) => "variable".to_owned(),
            ("counter", &[count]) => format!("{count} collapses"),
            ("placements", _) => format!("tree {number}: {}", floats(&words)),
            ("trunk vertices", &[x, y, z, ..]) => {
                format!("vertex {number}: {}", floats(&[x, y, z]))
            }
            ("trunk indices", &[a, b, c]) => format!("triangle {number}: {a} {b} {c}"),
            ("trunk triangles", &[a, b, c]) => format!("slot {number}: {a} {b} {c}"),
            ("trunk strips", &[RESTART]) => format!("place {number}: a new strip begins"),
            ("trunk strips", &[vertex]) => format!("place {number}: vertex {vertex}"),
            ("trunk draw arguments", &[corners, ..]) => format!("draw {number}: {corners} corners"),
            _ => format!("record {number}: {}", hexadecimal(bytes)),
        }
    }
}

/// Bytes of a record of a buffer with this label.
fn stride(label: &str) -> u64 {
    match label {
        "leaf records"
        | "leaf list"
        | "draw arguments"
        | "leaf list arguments"
        | "trunk draw arguments" => 16,
        "stamped records" => 24,
        "leaf vertices" | "trunk indices" | "trunk triangles" => 12,
        "placements" | "trunk vertices" => 32,
        "leaf materials" => 64,
        "view" => 100,
        _ => 4,
    }
}

/// The buffers that differ, by owner and label.
pub(super) fn buffer_differences(readers: [&Reader<'_>; 2]) -> Vec<BufferDifference> {
    let mut pairs: BTreeMap<(Owner, String, u32), [Option<BufferId>; 2]> = BTreeMap::new();
    for (side, reader) in readers.iter().enumerate() {
        let mut counts: BTreeMap<(Owner, String), u32> = BTreeMap::new();
        for (buffer, label) in reader.session.device().buffers() {
            let owner = reader.session.owner(ResourceId::Buffer(buffer));
            let count = counts.entry((owner, label.to_owned())).or_default();
            pairs.entry((owner, label.to_owned(), *count)).or_default()[side] = Some(buffer);
            *count += 1;
        }
    }
    let differs = |((owner, label, _), buffers): (_, [Option<BufferId>; 2])| {
        let held = [0, 1].map(|side| {
            let reader: &Reader<'_> = readers[side];
            buffers[side].and_then(|buffer| reader.session.device().inspect_buffer(buffer).ok())
        });
        compare(owner, label, held, readers)
    };
    pairs.into_iter().filter_map(differs).collect()
}

fn compare(
    owner: Owner,
    label: String,
    held: [Option<&[u8]>; 2],
    readers: [&Reader<'_>; 2],
) -> Option<BufferDifference> {
    if held[0] == held[1] {
        return None;
    }
    let stride = stride(&label);
    let size = usize::try_from(stride).expect("records are small");
    let mut difference = BufferDifference {
        label,
        owner: owner_name(owner),
        bytes: held.map(|bytes| bytes.map(|bytes| bytes.len() as u64)),
        stride,
        inserted: None,
        differing_records: 0,
        range_count: 0,
        ranges: Vec::new(),
    };
    let [Some(a), Some(b)] = held else {
        return Some(difference);
    };
    let words = |side: usize, number: u64, record: &[u8]| {
        readers[side].record(owner, &difference.label, number, record)
    };
    if let Some((side, start, end)) = insertion(a, b, size) {
        let longer = if side == 0 { a } else { b };
        let record = longer.get(start..start + size).unwrap_or_default();
        difference.inserted = Some(Insertion {
            side: ["a", "b"][side],
            start: start as u64,
            end: end as u64,
            record: words(side, start as u64 / stride, record),
        });
    }
    let mut open: Option<RecordDifference> = None;
    let (mut records, mut ranges, mut list) = (0, 0, Vec::new());
    let mut close = |open: &mut Option<RecordDifference>| {
        if let Some(range) = open.take() {
            ranges += 1;
            if list.len() < MAX_LISTED {
                list.push(range);
            }
        }
    };
    for (number, (one, other)) in (0_u64..).zip(a.chunks(size).zip(b.chunks(size))) {
        if one == other {
            close(&mut open);
            continue;
        }
        records += 1;
        let end = number * stride + one.len().min(other.len()) as u64;
        match &mut open {
            Some(range) => range.end = end,
            None => {
                open = Some(RecordDifference {
                    start: number * stride,
                    end,
                    record: number,
                    a: words(0, number, one),
                    b: words(1, number, other),
                });
            }
        }
    }
    close(&mut open);
    (difference.differing_records, difference.range_count) = (records, ranges);
    difference.ranges = list;
    Some(difference)
}

/// The whole records that the longer of two has more, if taking them out gives the other: which one
/// is longer, and the range of bytes in it.
fn insertion(a: &[u8], b: &[u8], size: usize) -> Option<(usize, usize, usize)> {
    let (side, longer, shorter) = match a.len().cmp(&b.len()) {
        std::cmp::Ordering::Equal => return None,
        std::cmp::Ordering::Greater => (0, a, b),
        std::cmp::Ordering::Less => (1, b, a),
    };
    let more = longer.len() - shorter.len();
    let common = longer
        .iter()
        .zip(shorter)
        .take_while(|(one, other)| one == other);
    let start = common.count() / size * size;
    let rest_is_same = longer.get(start + more..) == shorter.get(start..);
    (more.is_multiple_of(size) && rest_is_same).then_some((side, start, start + more))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_has_more_is_found_in_whole_records() {
        let a = [0, 0, 1, 1, 1, 2, 3, 3];
        let b = [0, 0, 1, 1, 3, 3];
        assert_eq!(insertion(&a, &b, 2), Some((0, 4, 6)));
        assert_eq!(insertion(&b, &a, 2), Some((1, 4, 6)));
        assert_eq!(insertion(&a, &b, 4), None, "half a record");
        assert_eq!(insertion(&a, &[9, 0, 1, 1, 3, 3], 2), None);
        assert_eq!(insertion(&a, &a, 2), None);
        assert_eq!(insertion(&[7, 7], &[], 2), Some((0, 0, 2)));
    }
}
