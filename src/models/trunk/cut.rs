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
use std::sync::Arc;

use super::strips::{NO_TRIANGLE, StripPlan};
use super::surface::{TRUNK, TrunkShared, upload_trunk};
use super::writes::{Write, send_writes};
use super::{TRUNK_GROUP, Trunk, TrunkKind, TrunkLevel, TrunkMode, TrunkModel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, DrawIndirect, GpuError, IndirectRecord,
    Queue, RESTART, Step, Usage,
};
use crate::math::index_u32;
use crate::models::{Change, Environment, Gather, Resident, Shared, Storage};
use crate::simplify::VertexCollapses;

/// Why places of strips, and their number, are sent.
const CAUSES: [Cause; 2] = [Cause::of("strip"), Cause::of("strip-count")];

/// A block is full with so many places: more makes fewer draws, of 8 bytes each in the command stream,
/// but a run that is cut or put back moves all that follows it in its block.
const BLOCK_PLACES: u32 = 256;

/// LodStrips with runs cut out.
///
/// Host memory: 32 bytes a vertex (for `Host`); then the structures of [`StripPlan::host_bytes`].
/// Device memory for `Device`: 32 bytes a vertex once; 4 bytes a place and 16 bytes of draw arguments
/// a block for each instance.
#[derive(Debug, Clone)]
pub(super) struct Cut {
    trunk: Arc<Trunk>,
    mode: TrunkMode,
    gather: Gather,
    plan: Arc<StripPlan>,
    /// The strips of each block.
    blocks: Arc<Vec<Range<u32>>>,
}

impl Cut {
    pub(super) fn new(trunk: Arc<Trunk>, mode: TrunkMode, gather: Gather) -> Self {
        let plan = StripPlan::of(trunk.collapses());
        Self {
            blocks: Arc::new(blocks(&plan)),
            plan: Arc::new(plan),
            trunk,
            mode,
            gather,
        }
    }

    /// The places of a block that are drawn at a level, made of the strips of fixed length.
    fn places(&self, block: &Range<u32>, content: &[u32], level: TrunkLevel) -> Vec<u32> {
        let collapses = self.trunk.collapses();
        let mut places = Vec::new();
        for strip in block.clone() {
            let strip = self.plan.starts[strip as usize] as usize
                ..self.plan.starts[strip as usize + 1] as usize - 1;
            let triangles = &self.plan.triangles[strip.clone()];
            cut_strip(&content[strip], triangles, collapses, level, &mut places);
        }
        places
    }

    /// Where a block begins.
    fn start(&self, block: &Range<u32>) -> u32 {
        self.plan.starts[block.start as usize]
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
        triangles[place] != NO_TRIANGLE && collapses.shows(triangles[place], level.collapses)
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

impl TrunkModel for Cut {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::LodStripsCut,
            mode: self.mode,
        }
    }

    fn trunk(&self) -> &Arc<Trunk> {
        &self.trunk
    }

    fn upload(
        &self,
        device: &mut Device,
        environment: &Environment,
    ) -> Result<Box<dyn Shared<TrunkLevel>>, GpuError> {
        let model = self.clone();
        let shared = upload_trunk(device, environment, model, &self.trunk, self.mode)?;
        Ok(Box::new(shared))
    }

    fn host_bytes(&self) -> Vec<u8> {
        let vertices = self.mode.host_vertex_bytes(&self.trunk);
        [vertices, self.plan.host_bytes(self.trunk.collapses())].concat()
    }

    fn storage(&self) -> Storage {
        let arguments = IndirectRecord::STRIDE * self.blocks.len() as u64;
        let places = 4 * self.plan.finest.len() as u64;
        let host = self.plan.host_size(self.trunk.collapses());
        let finest = |block| {
            self.places(block, &self.plan.finest, TrunkLevel::FINEST)
                .len()
        };
        let drawn: usize = self.blocks.iter().map(finest).sum();
        let kept = 4 + places + 4 * drawn as u64;
        self.mode
            .storage(&self.trunk, host, places + arguments, kept)
    }
}

impl Shared<TrunkLevel> for TrunkShared<Cut> {
    fn instance(
        &self,
        device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let model = self.model.clone();
        let content = model.plan.at(model.trunk.collapses(), *level);
        let mut bytes = vec![0; 4 * content.len()];
        let mut arguments = Vec::new();
        let mut drawn = Vec::new();
        for block in model.blocks.iter() {
            let places = model.places(block, &content, *level);
            let start = model.start(block);
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
            let buffer = device.create_buffer(&BufferDescriptor {
                label,
                size: bytes.len() as u64,
                usage,
                residency: model.mode.residency(),
            })?;
            device.queue().write(buffer, 0, bytes, TRUNK)?;
            Ok(buffer)
        };
        let strips = make("trunk strips", Usage::INDEX, &bytes)?;
        let arguments = make("trunk draw arguments", Usage::INDIRECT, &arguments)?;
        let mut steps = self.surface.bind(self.vertices, strips);
        steps.push(Step::DrawIndirect(DrawIndirect {
            source: Corners::Strips,
            arguments,
            offset: 0,
            count: index_u32(drawn.len()),
            group: TRUNK_GROUP,
        }));
        Ok(Box::new(CutResident {
            model,
            strips,
            arguments,
            steps,
            level: *level,
            content,
            drawn,
        }))
    }
}

#[derive(Debug, Clone)]
struct CutResident {
    model: Cut,
    strips: BufferId,
    arguments: BufferId,
    steps: Vec<Step>,
    level: TrunkLevel,
    /// The strips of fixed length.
    content: Vec<u32>,
    /// The places of each block that are drawn: the same as in the buffer.
    drawn: Vec<Vec<u32>>,
}

impl CutResident {
    /// Goes over to a level on the host; returns what that takes, and what the buffers lack then.
    fn step(&mut self, to: TrunkLevel) -> (Change, Vec<Write>) {
        let Cut {
            trunk,
            plan,
            blocks,
            ..
        } = &self.model;
        let collapses = trunk.collapses();
        let (places, records) = plan.change(collapses, &mut self.content, self.level, to);
        let mut change = self.level.change_to(to);
        change.host_records = records;
        self.level = to;
        let block_of = |&place: &u32| {
            let strip = plan.strip_of(place);
            blocks.partition_point(|block| block.end <= strip)
        };
        let mut touched: Vec<usize> = places.iter().map(block_of).collect();
        touched.dedup();
        let mut writes: Vec<Write> = Vec::new();
        for number in touched {
            let block = &blocks[number];
            let wanted = self.model.places(block, &self.content, to);
            let held = std::mem::replace(&mut self.drawn[number], wanted);
            let wanted = &self.drawn[number];
            // Every place of the block was read, those that are drawn were written.
            let ends = [block.start, block.end].map(|strip| plan.starts[strip as usize]);
            change.host_records += u64::from(ends[1] - ends[0]) + wanted.len() as u64;
            let differs = |&place: &usize| held.get(place) != wanted.get(place);
            let mut changed = (0..wanted.len()).filter(differs);
            if let Some(first) = changed.next() {
                let last = changed.next_back().unwrap_or(first);
                let words = wanted[first..=last].iter();
                let bytes = words.flat_map(|word| word.to_le_bytes()).collect();
                let offset = 4 * (u64::from(ends[0]) + first as u64);
                writes.push(Write {
                    buffer: self.strips,
                    offset,
                    bytes,
                    cause: CAUSES[0],
                });
            }
            if held.len() != wanted.len() {
                let bytes = index_u32(wanted.len()).to_le_bytes().to_vec();
                let offset = IndirectRecord::STRIDE * number as u64;
                writes.push(Write {
                    buffer: self.arguments,
                    offset,
                    bytes,
                    cause: CAUSES[1],
                });
            }
            change.clusters_touched += 1;
        }
        (change, writes)
    }
}

impl Resident<TrunkLevel> for CutResident {
    fn state(&self) -> &TrunkLevel {
        &self.level
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
        let (change, writes) = self.step(*to);
        send_writes(queue, self.model.gather, &writes)?;
        Ok(change)
    }

    fn price(&self, to: &TrunkLevel) -> u64 {
        self.model.mode.price(&self.clone().step(*to).1)
    }

    fn host_bytes(&self) -> u64 {
        let content = 4 * self.content.len() as u64;
        let drawn: u64 = self
            .drawn
            .iter()
            .map(|places| 4 * places.len() as u64)
            .sum();
        let records = IndirectRecord::STRIDE * self.drawn.len() as u64;
        4 + content
            + drawn
            + match self.model.mode {
                TrunkMode::Host => content + records,
                TrunkMode::Device => 0,
            }
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }
}

#[cfg(test)]
mod tests {
    use super::super::strips::shown;
    use super::*;

    #[test]
    fn what_is_left_shows_the_same_and_is_never_longer() {
        let trunk = Arc::new(super::super::examples::branch(6, 5));
        let model = Cut::new(Arc::clone(&trunk), TrunkMode::Device, Gather::Single);
        let mut shorter = 0;
        for collapses in 0..=trunk.collapses().collapse_count() {
            let level = TrunkLevel { collapses };
            let content = model.plan.at(trunk.collapses(), level);
            for block in model.blocks.iter() {
                let places = model.places(block, &content, level);
                let [from, to] = [block.start, block.end]
                    .map(|strip| model.plan.starts[strip as usize] as usize);
                let whole = &content[from..to - 1];
                assert_eq!(shown(&places), shown(whole), "level {collapses}");
                assert!(places.len() <= whole.len());
                shorter += whole.len() - places.len();
            }
        }
        assert!(shorter > 0, "nothing is ever cut");
    }
}
