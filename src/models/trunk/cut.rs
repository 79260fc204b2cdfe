//! LodStrips with runs of places cut out where they make no triangles.
//!
//! The papers cut such runs, record where and how long they were, and put them back on the way to
//! finer levels. Here what is cut follows from the level alone, so that nothing need be recorded: the
//! host keeps the strips of fixed length, as [`LodStrips`](super::strips::LodStrips) does, and each
//! level's short strips are made of them:
//!
//! ```text
//! a b c d d d d c e f      the run of d makes no triangle
//! a b c d ↺ d c e f        cut: a new strip begins, where that is shorter than to go through
//! ```
//!
//! Strips lie in blocks, [`BLOCK_PLACES`] or more places each. A block's short strips stand at its
//! beginning, restarts between them; how many places are drawn is in its draw arguments. What lies
//! beyond is dead.

use std::ops::Range;

use super::planned::{Drawn, PlanSizes, Planned, TrunkPlan};
use super::strips::{NO_TRIANGLE, StripPlan};
use super::surface::trunk_buffer;
use super::writes::Write;
use super::{TRUNK_GROUP, Trunk, TrunkLevel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord,
    RESTART, Residency, Step, Usage,
};
use crate::math::index_u32;
use crate::models::Change;
use crate::simplify::VertexCollapses;

/// Why places of strips, and their number, are sent.
const CAUSES: [Cause; 2] = [Cause::of("strip"), Cause::of("strip-count")];

/// A block is full with so many places: more makes fewer draws, of 8 bytes each in the command stream,
/// but a run that is cut or put back moves all that follows it in its block.
const BLOCK_PLACES: u32 = 256;

/// LodStrips with runs cut out.
///
/// Host memory: 32 bytes a vertex (for `Host`); then the structures of [`StripPlan::host_words`].
/// Device memory for `Device`: 32 bytes a vertex once; 4 bytes a place and 16 bytes of draw arguments
/// a block for each instance.
pub(super) type Cut = Planned<CutPlan>;

/// Strips of fixed length, and what blocks they lie in.
#[derive(Debug, Clone)]
pub(super) struct CutPlan {
    strips: StripPlan,
    /// The strips of each block.
    blocks: Vec<Range<u32>>,
}

/// The short strips of an instance.
#[derive(Debug, Clone)]
pub(super) struct CutStrips {
    strips: BufferId,
    arguments: BufferId,
    /// The strips of fixed length.
    content: Vec<u32>,
    /// The places of each block that are drawn: the same as in the buffer.
    drawn: Vec<Vec<u32>>,
}

impl TrunkPlan for CutPlan {
    const NAME: TrunkName = TrunkName::LodStripsCut;
    type Instance = CutStrips;

    fn of(trunk: &Trunk) -> Self {
        let strips = StripPlan::of(trunk);
        Self {
            blocks: blocks(&strips),
            strips,
        }
    }

    fn host_bytes(model: &Planned<Self>) -> Vec<u8> {
        model.plan.strips.host_words(model.trunk.collapses())
    }

    fn sizes(model: &Planned<Self>) -> PlanSizes {
        let (plan, collapses) = (&model.plan, model.trunk.collapses());
        let arguments = IndirectRecord::STRIDE * plan.blocks.len() as u64;
        let places = 4 * plan.strips.finest.len() as u64;
        let finest = |block| {
            let content = &plan.strips.finest;
            plan.places(collapses, block, content, TrunkLevel::FINEST)
                .len()
        };
        let drawn: usize = plan.blocks.iter().map(finest).sum();
        PlanSizes {
            host: plan.strips.host_size(collapses),
            instance: places + arguments,
            kept: 4 + places + 4 * drawn as u64,
        }
    }

    fn instance(
        model: &Planned<Self>,
        device: &mut Device,
        level: TrunkLevel,
        number: u32,
    ) -> Result<Drawn<CutStrips>, GpuError> {
        let (plan, collapses) = (&model.plan, model.trunk.collapses());
        let content = plan.strips.at(collapses, level);
        let mut bytes = vec![0; 4 * content.len()];
        let mut arguments = Vec::new();
        let mut drawn = Vec::new();
        for block in &plan.blocks {
            let places = plan.places(collapses, block, &content, level);
            let start = plan.strips.starts[block.start as usize];
            let words = places.iter().flat_map(|place| place.to_le_bytes());
            for (byte, word) in bytes[4 * start as usize..].iter_mut().zip(words) {
                *byte = word;
            }
            let record = IndirectRecord {
                corner_count: index_u32(places.len()),
                instances: 1,
                first_corner: start,
                instance: number,
            };
            arguments.extend(record.to_bytes());
            drawn.push(places);
        }
        let mut make = |label, usage, bytes: &[u8]| {
            let descriptor = BufferDescriptor {
                label,
                size: bytes.len() as u64,
                usage,
                residency: model.mode.residency(),
            };
            trunk_buffer(device, &descriptor, bytes)
        };
        let strips = make("trunk strips", Usage::INDEX, &bytes)?;
        let arguments = make("trunk draw arguments", Usage::INDIRECT, &arguments)?;
        Ok(Drawn {
            indices: strips,
            draw: Step::DrawIndirect(DrawIndirect {
                source: Corners::Strips,
                arguments,
                offset: 0,
                count: index_u32(drawn.len()),
                group: TRUNK_GROUP,
            }),
            instance: CutStrips {
                strips,
                arguments,
                content,
                drawn,
            },
        })
    }

    fn step(
        model: &Planned<Self>,
        cut: &mut CutStrips,
        [from, to]: [TrunkLevel; 2],
    ) -> (Change, Vec<Write>) {
        let Self { strips, blocks } = &*model.plan;
        let collapses = model.trunk.collapses();
        let (places, host_records) = strips.change(collapses, &mut cut.content, from, to);
        let mut change = Change {
            host_records,
            ..Change::default()
        };
        let block_of = |&place: &u32| {
            let strip = strips.strip_of(place);
            blocks.partition_point(|block| block.end <= strip)
        };
        let mut touched: Vec<usize> = places.iter().map(block_of).collect();
        touched.dedup();
        let mut writes: Vec<Write> = Vec::new();
        for number in touched {
            let block = &blocks[number];
            let wanted = model.plan.places(collapses, block, &cut.content, to);
            let held = std::mem::replace(&mut cut.drawn[number], wanted);
            let wanted = &cut.drawn[number];
            // Every place of the block was read, those that are drawn were written.
            let ends = [block.start, block.end].map(|strip| strips.starts[strip as usize]);
            change.host_records += u64::from(ends[1] - ends[0]) + wanted.len() as u64;
            let differs = |&place: &usize| held.get(place) != wanted.get(place);
            let mut changed = (0..wanted.len()).filter(differs);
            if let Some(first) = changed.next() {
                let last = changed.next_back().unwrap_or(first);
                let words = wanted[first..=last].iter();
                let bytes = words.flat_map(|word| word.to_le_bytes()).collect();
                let offset = 4 * (u64::from(ends[0]) + first as u64);
                writes.push(Write {
                    buffer: cut.strips,
                    offset,
                    bytes,
                    cause: CAUSES[0],
                });
            }
            if held.len() != wanted.len() {
                let bytes = index_u32(wanted.len()).to_le_bytes().to_vec();
                let offset = IndirectRecord::STRIDE * number as u64;
                writes.push(Write {
                    buffer: cut.arguments,
                    offset,
                    bytes,
                    cause: CAUSES[1],
                });
            }
            change.clusters_touched += 1;
        }
        (change, writes)
    }

    fn instance_host_bytes(model: &Planned<Self>, cut: &CutStrips) -> u64 {
        let content = 4 * cut.content.len() as u64;
        let drawn = cut.drawn.iter().map(|places| 4 * places.len() as u64);
        let records = IndirectRecord::STRIDE * cut.drawn.len() as u64;
        content
            + drawn.sum::<u64>()
            + match model.mode.residency() {
                Residency::Host => content + records,
                Residency::Device => 0,
            }
    }
}

impl CutPlan {
    /// The places of a block that are drawn at a level, made of the strips of fixed length.
    fn places(
        &self,
        collapses: &VertexCollapses,
        block: &Range<u32>,
        content: &[u32],
        level: TrunkLevel,
    ) -> Vec<u32> {
        let mut places = Vec::new();
        for strip in block.clone() {
            let strip = self.strips.starts[strip as usize] as usize
                ..self.strips.starts[strip as usize + 1] as usize - 1;
            let triangles = &self.strips.triangles[strip.clone()];
            cut_strip(&content[strip], triangles, collapses, level, &mut places);
        }
        places
    }
}

/// Strips in a row, [`BLOCK_PLACES`] or more places each but the last.
fn blocks(plan: &StripPlan) -> Vec<Range<u32>> {
    let strips = index_u32(plan.starts.len() - 1);
    let mut blocks = Vec::new();
    let mut first = 0;
    for strip in 0..strips {
        let places = plan.starts[strip as usize + 1] - plan.starts[first as usize];
        if places >= BLOCK_PLACES || strip + 1 == strips {
            blocks.push(first..strip + 1);
            first = strip + 1;
        }
    }
    blocks
}

/// Adds what is left of a strip: the same triangles in the same order, turned the same way.
///
/// `triangles` names the triangle of each place. To the next triangle leads the shortest of: one more
/// place, where the last two are the right ones already; the places between; a new strip. The first
/// two keep each place's parity, and a new strip at an odd place begins with its first vertex twice,
/// so no triangle is turned over. Never longer than the strip.
fn cut_strip(
    strip: &[u32],
    triangles: &[u32],
    collapses: &VertexCollapses,
    level: TrunkLevel,
    places: &mut Vec<u32>,
) {
    let shows = |&place: &usize| {
        triangles[place] != NO_TRIANGLE && collapses.shows(triangles[place], level.collapses())
    };
    // Where the present strip begins, and the last place that is in it.
    let mut present: Option<(usize, usize)> = None;
    for place in (0..strip.len()).filter(shows) {
        let [a, b, c] = [strip[place - 2], strip[place - 1], strip[place]];
        let odd = (place - 2) % 2;
        let begin = match present {
            Some((begin, _))
                if places.ends_with(&[a, b]) && (places.len() - begin) % 2 == place % 2 =>
            {
                places.push(c);
                begin
            }
            Some((begin, last)) if place - last <= 4 + odd => {
                places.extend_from_slice(&strip[last + 1..=place]);
                begin
            }
            _ => {
                if !places.is_empty() {
                    places.push(RESTART);
                }
                let begin = places.len();
                places.extend_from_slice(&[a; 2][..odd]);
                places.extend([a, b, c]);
                begin
            }
        };
        present = Some((begin, place));
    }
}

#[cfg(test)]
mod tests {
    use super::super::strips::shown;
    use super::*;

    #[test]
    fn what_is_left_shows_the_same_and_is_never_longer() {
        let trunk = super::super::examples::branch(6, 5);
        let plan = CutPlan::of(&trunk);
        let mut shorter = 0;
        for collapses in 0..=trunk.collapses().collapse_count() {
            let level = TrunkLevel::Collapses(collapses);
            let content = plan.strips.at(trunk.collapses(), level);
            for block in &plan.blocks {
                let places = plan.places(trunk.collapses(), block, &content, level);
                let [from, to] = [block.start, block.end]
                    .map(|strip| plan.strips.starts[strip as usize] as usize);
                let whole = &content[from..to - 1];
                assert_eq!(shown(&places), shown(whole), "level {collapses}");
                assert!(places.len() <= whole.len());
                shorter += whole.len() - places.len();
            }
        }
        assert!(shorter > 0, "nothing is ever cut");
    }
}
