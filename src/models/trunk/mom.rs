//! MOM, multiresolution ordered meshes, the papers' rival ([RLBRC01](crate::references)).
//!
//! Known of it: lists that can be arrays, a mesh stored in the order of its simplification, a level
//! extracted in time linear in its triangles; trees in [RRCGR](crate::references) have it for trunks
//! beside VDF for foliage, "not hardware-oriented". The rest is reconstruction: every triangle that
//! there is at any level is stored once, with the levels at which it is there, ordered by the first.
//!
//! `Host` extracts as written: it reads the triangles in their order up to those of later levels, and
//! every draw pulls what it found. `Device` is as well as it can be done: the list of triangles lies
//! on the device, and a change writes the slots that differ. A triangle that changes keeps its slot;
//! into the slot of one that goes comes the last one. So slots are a pure function of the level.

use super::planned::{Drawn, PlanSizes, Planned, TrunkPlan};
use super::surface::trunk_buffer;
use super::writes::Write;
use super::{TRUNK_GROUP, Trunk, TrunkLevel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord,
    Residency, Step, Usage,
};
use crate::math::index_u32;
use crate::models::Change;
use crate::simplify::lowest_first;

/// Why triangles, and their number, are sent.
const CAUSES: [Cause; 2] = [Cause::of("triangle"), Cause::of("triangle-count")];

/// MOM.
///
/// Host memory: 32 bytes a vertex (for `Host`); then 20 bytes a triangle of any level: three vertices,
/// the first level at which it is there, and the first at which it is gone. For `Device` then every
/// slot that a collapse changes, with the triangle before and after (12 bytes), and where the slots
/// of each collapse begin (4 bytes, and the end). Device memory for `Device`: 32 bytes a vertex once;
/// 12 bytes a triangle of full detail and 16 bytes of draw arguments for each instance.
pub(super) type Mom = Planned<MomPlan>;

/// The triangles of an instance.
#[derive(Debug, Clone)]
pub(super) struct MomTriangles {
    triangles: BufferId,
    arguments: BufferId,
    /// The records in the buffer.
    content: Vec<u32>,
}

/// A triangle with the levels at which it is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Record {
    vertices: [u32; 3],
    birth: u32,
    death: u32,
}

/// All triangles of any level, and the slots that they have on the device.
#[derive(Debug, Clone)]
pub(super) struct MomPlan {
    /// By birth.
    records: Vec<Record>,
    /// `[slot, record before, record after]`, collapse by collapse.
    slots: Vec<[u32; 3]>,
    starts: Vec<u32>,
    /// How many triangles there are at each level.
    counts: Vec<u32>,
}

impl TrunkPlan for MomPlan {
    const NAME: TrunkName = TrunkName::Mom;
    type Instance = MomTriangles;

    fn of(trunk: &Trunk) -> Self {
        let collapses = trunk.collapses();
        let levels = collapses.collapse_count();
        let mut records: Vec<Record> = Vec::new();
        // The record, slot and vertices of every triangle of the mesh.
        let mut now = vec![(0, 0, [0; 3]); collapses.triangles().len()];
        let mut in_slot = Vec::new();
        let mut around = vec![Vec::new(); collapses.vertex_count() as usize];
        for (triangle, vertices) in collapses.triangles_after(0) {
            let number = index_u32(records.len());
            now[triangle as usize] = (number, number, vertices);
            in_slot.push(triangle);
            for vertex in vertices {
                around[vertex as usize].push(triangle);
            }
            records.push(Record {
                vertices,
                birth: 0,
                death: u32::MAX,
            });
        }
        let mut slots = Vec::new();
        let mut starts = vec![0];
        for level in 1..=levels {
            let vertices = collapses.first_vertex(level - 1)..collapses.first_vertex(level);
            let mut going = Vec::new();
            for vertex in vertices {
                let target = collapses.target(vertex);
                let target = target.expect("a vertex that goes has a target");
                for triangle in std::mem::take(&mut around[vertex as usize]) {
                    let (record, slot, corners) = now[triangle as usize];
                    if !collapses.shows(triangle, level - 1) {
                        continue;
                    }
                    if !collapses.shows(triangle, level) {
                        going.push(triangle);
                        continue;
                    }
                    let moved =
                        corners.map(|corner| if corner == vertex { target } else { corner });
                    around[target as usize].push(triangle);
                    let number = index_u32(records.len());
                    records[record as usize].death = level;
                    records.push(Record {
                        vertices: lowest_first(moved),
                        birth: level,
                        death: u32::MAX,
                    });
                    slots.push([slot, record, number]);
                    now[triangle as usize] = (number, slot, moved);
                }
            }
            going.sort_unstable();
            going.dedup();
            for triangle in going {
                let (record, slot, _) = now[triangle as usize];
                records[record as usize].death = level;
                let last = in_slot.pop().expect("a triangle that goes has a slot");
                if last != triangle {
                    in_slot[slot as usize] = last;
                    slots.push([slot, record, now[last as usize].0]);
                    now[last as usize].1 = slot;
                }
            }
            starts.push(index_u32(slots.len()));
        }
        Self {
            records,
            slots,
            starts,
            counts: collapses.triangle_counts(),
        }
    }

    fn host_bytes(model: &Planned<Self>) -> Vec<u8> {
        let plan = &model.plan;
        let records = plan.records.iter().flat_map(|record| {
            let [a, b, c] = record.vertices;
            [a, b, c, record.birth, record.death]
        });
        let mut words: Vec<u32> = records.collect();
        if model.mode.residency() == Residency::Device {
            words.extend(plan.slots.iter().flatten().chain(&plan.starts));
        }
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    fn sizes(model: &Planned<Self>) -> PlanSizes {
        let plan = &model.plan;
        let slots = 12 * plan.slots.len() as u64 + 4 * plan.starts.len() as u64;
        let triangles = u64::from(plan.counts[0]);
        PlanSizes {
            host: 20 * plan.records.len() as u64
                + match model.mode.residency() {
                    Residency::Host => 0,
                    Residency::Device => slots,
                },
            instance: 12 * triangles + IndirectRecord::STRIDE,
            kept: 4 + 4 * triangles,
        }
    }

    fn instance(
        model: &Planned<Self>,
        device: &mut Device,
        level: TrunkLevel,
        number: u32,
    ) -> Result<Drawn<MomTriangles>, GpuError> {
        let plan = &model.plan;
        let content = match model.mode.residency() {
            Residency::Host => plan.scan(level).0,
            Residency::Device => plan.slots_at(level),
        };
        let arguments = IndirectRecord {
            corner_count: 3 * plan.counts[level.collapses() as usize],
            instances: 1,
            first_corner: 0,
            instance: number,
        };
        let bytes = plan.bytes_of(&content);
        let mut make = |label, size, usage, bytes: &[u8]| {
            let descriptor = BufferDescriptor {
                label,
                size,
                usage,
                residency: model.mode.residency(),
            };
            trunk_buffer(device, &descriptor, bytes)
        };
        let size = 12 * u64::from(plan.counts[0]);
        let triangles = make("trunk triangles", size, Usage::INDEX, &bytes)?;
        let record = arguments.to_bytes();
        let size = IndirectRecord::STRIDE;
        let arguments = make("trunk draw arguments", size, Usage::INDIRECT, &record)?;
        Ok(Drawn {
            indices: triangles,
            draw: Step::DrawIndirect(DrawIndirect {
                source: Corners::Indexed,
                arguments,
                offset: 0,
                count: 1,
                group: TRUNK_GROUP,
            }),
            instance: MomTriangles {
                triangles,
                arguments,
                content,
            },
        })
    }

    fn step(
        model: &Planned<Self>,
        held: &mut MomTriangles,
        [from, to]: [TrunkLevel; 2],
    ) -> (Change, Vec<Write>) {
        let plan = &model.plan;
        let mut change = Change::default();
        let mut writes: Vec<Write> = Vec::new();
        if from == to {
            return (change, writes);
        }
        let write = |slot: u32, bytes| Write {
            buffer: held.triangles,
            offset: 12 * u64::from(slot),
            bytes,
            cause: CAUSES[0],
        };
        match model.mode.residency() {
            Residency::Host => {
                let (content, read) = plan.scan(to);
                change.host_records = read + content.len() as u64;
                writes.push(write(0, plan.bytes_of(&content)));
                held.content = content;
            }
            Residency::Device => {
                let (slots, read) = plan.move_slots(&mut held.content, from, to);
                change.host_records = read + slots.len() as u64;
                let content = &held.content;
                let bytes = |slot: u32| plan.bytes_of(&content[slot as usize..][..1]);
                writes.extend(slots.into_iter().map(|slot| write(slot, bytes(slot))));
            }
        }
        let [before, after] = [from, to].map(|level| plan.counts[level.collapses() as usize]);
        if before != after {
            writes.push(Write {
                buffer: held.arguments,
                offset: 0,
                bytes: (3 * after).to_le_bytes().to_vec(),
                cause: CAUSES[1],
            });
        }
        (change, writes)
    }

    fn instance_host_bytes(model: &Planned<Self>, held: &MomTriangles) -> u64 {
        4 * held.content.len() as u64
            + match model.mode.residency() {
                Residency::Host => 12 * u64::from(model.plan.counts[0]) + IndirectRecord::STRIDE,
                Residency::Device => 0,
            }
    }
}

impl MomPlan {
    fn slots_of(&self, collapse: u32) -> &[[u32; 3]] {
        let ends = &self.starts[collapse as usize..collapse as usize + 2];
        &self.slots[ends[0] as usize..ends[1] as usize]
    }

    /// The record in every slot, dead ones too.
    fn slots_at(&self, level: TrunkLevel) -> Vec<u32> {
        let mut content: Vec<u32> = (0..self.counts[0]).collect();
        for collapse in 0..level.collapses() {
            for &[slot, _, after] in self.slots_of(collapse) {
                content[slot as usize] = after;
            }
        }
        content
    }

    /// The records of a level in their order, and how many were read to find them.
    fn scan(&self, level: TrunkLevel) -> (Vec<u32>, u64) {
        let born = self
            .records
            .partition_point(|record| record.birth <= level.collapses());
        let there = (0..).zip(&self.records[..born]);
        let there = there.filter(|(_, record)| level.collapses() < record.death);
        (
            there.map(|(number, _): (u32, _)| number).collect(),
            born as u64,
        )
    }

    /// The triangles of some records, as they lie on the device.
    fn bytes_of(&self, records: &[u32]) -> Vec<u8> {
        let vertices = records.iter();
        let vertices = vertices.flat_map(|&record| self.records[record as usize].vertices);
        vertices.flat_map(u32::to_le_bytes).collect()
    }

    /// Takes the slots from one level to another; returns those that differ, ascending, and how many
    /// records were read.
    fn move_slots(&self, content: &mut [u32], from: TrunkLevel, to: TrunkLevel) -> (Vec<u32>, u64) {
        let mut before: Vec<(u32, u32)> = Vec::new();
        let mut put = |slot: u32, record: u32| {
            let held = std::mem::replace(&mut content[slot as usize], record);
            before.push((slot, held));
        };
        for collapse in from.collapses()..to.collapses() {
            for &[slot, _, after] in self.slots_of(collapse) {
                put(slot, after);
            }
        }
        for collapse in (to.collapses()..from.collapses()).rev() {
            for &[slot, held, _] in self.slots_of(collapse).iter().rev() {
                put(slot, held);
            }
        }
        let read = before.len() as u64;
        // Of several records the first is what the slot held; the sort is stable.
        before.sort_by_key(|&(slot, _)| slot);
        before.dedup_by_key(|&mut (slot, _)| slot);
        let differ = before.into_iter();
        let differ = differ.filter(|&(slot, held)| content[slot as usize] != held);
        (differ.map(|(slot, _)| slot).collect(), read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_and_slots_are_the_mesh_at_every_level() {
        let trunk = super::super::examples::branch(6, 5);
        let collapses = trunk.collapses();
        let plan = MomPlan::of(&trunk);
        let sorted = |records: &[u32]| {
            let vertices = records
                .iter()
                .map(|&record| plan.records[record as usize].vertices);
            let mut vertices: Vec<_> = vertices.collect();
            vertices.sort_unstable();
            vertices
        };
        for level in 0..=collapses.collapse_count() {
            let mut wanted: Vec<_> = collapses.triangles_after(level).map(|(_, t)| t).collect();
            wanted.sort_unstable();
            let at = TrunkLevel::Collapses(level);
            assert_eq!(sorted(&plan.scan(at).0), wanted, "level {level}");
            let count = plan.counts[level as usize] as usize;
            assert_eq!(sorted(&plan.slots_at(at)[..count]), wanted, "level {level}");
        }
    }
}
