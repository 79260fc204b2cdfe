//! LodStrips: multiresolution triangle strips ([RC04](crate::references)).
//!
//! Known of it ([RRCGR](crate::references), section III): strips that are storage and drawing
//! primitive in one, vertices that each know which they collapse to, and for every level a record of
//! how the strips change. The rest is reconstruction: vertices are numbered in the order of their
//! collapses; the record of a level is the list of places in the strips that hold the vertex which
//! goes; going coarser writes its target there, going finer the vertex itself.
//!
//! Strips keep their length here: places of triangles that are gone stay, and are assembled to
//! triangles that name a vertex twice, which no pixel sees. [`Cut`](super::cut::Cut) takes them out.

use std::sync::Arc;

use super::surface::{TRUNK, TrunkShared, upload_trunk};
use super::writes::{Write, send_writes};
use super::{TRUNK_GROUP, Trunk, TrunkKind, TrunkLevel, TrunkMode, TrunkModel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, Draw, GpuError, Queue, RESTART, Step, Usage,
};
use crate::math::index_u32;
use crate::models::{Change, Environment, Gather, Resident, Shared, Storage};
use crate::simplify::{VertexCollapses, strips_of};

/// Why places of strips are sent.
const STRIP: Cause = Cause::of("strip");

/// LodStrips with strips of fixed length.
///
/// Host memory: 32 bytes a vertex (for `Host`); then the structures of [`StripPlan::host_bytes`].
/// Device memory for `Device`: 32 bytes a vertex once, 4 bytes a place for each instance.
#[derive(Debug, Clone)]
pub(super) struct LodStrips {
    trunk: Arc<Trunk>,
    mode: TrunkMode,
    gather: Gather,
    plan: Arc<StripPlan>,
}

impl LodStrips {
    pub(super) fn new(trunk: Arc<Trunk>, mode: TrunkMode, gather: Gather) -> Self {
        Self {
            plan: Arc::new(StripPlan::of(trunk.collapses())),
            trunk,
            mode,
            gather,
        }
    }
}

impl TrunkModel for LodStrips {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::LodStrips,
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
        let places = 4 * self.plan.finest.len() as u64;
        let host = self.plan.host_size(self.trunk.collapses());
        self.mode.storage(&self.trunk, host, places, 4 + places)
    }
}

impl Shared<TrunkLevel> for TrunkShared<LodStrips> {
    fn instance(
        &self,
        device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let model = self.model.clone();
        let content = model.plan.at(model.trunk.collapses(), *level);
        let bytes: Vec<u8> = content
            .iter()
            .flat_map(|place| place.to_le_bytes())
            .collect();
        let strips = device.create_buffer(&BufferDescriptor {
            label: "trunk strips",
            size: bytes.len() as u64,
            usage: Usage::INDEX,
            residency: model.mode.residency(),
        })?;
        device.queue().write(strips, 0, &bytes, TRUNK)?;
        let mut steps = self.surface.bind(self.vertices, strips);
        steps.push(Step::Draw(Draw {
            source: Corners::Strips,
            first_corner: 0,
            corner_count: index_u32(content.len()),
            instance: number,
            group: TRUNK_GROUP,
        }));
        Ok(Box::new(StripsResident {
            model,
            strips,
            steps,
            level: *level,
            content,
        }))
    }
}

#[derive(Debug, Clone)]
struct StripsResident {
    model: LodStrips,
    strips: BufferId,
    steps: Vec<Step>,
    level: TrunkLevel,
    /// The same as in the buffer.
    content: Vec<u32>,
}

impl StripsResident {
    /// Goes over to a level on the host; returns what that takes, and what the buffer lacks then.
    fn step(&mut self, to: TrunkLevel) -> (Change, Vec<Write>) {
        let LodStrips { trunk, plan, .. } = &self.model;
        let collapses = trunk.collapses();
        let content = &mut self.content;
        let (places, records) = plan.change(collapses, content, self.level, to);
        let mut change = self.level.change_to(to);
        change.host_records = records;
        change.clusters_touched = plan.strips_of_places(&places);
        self.level = to;
        // Places side by side go together.
        let runs = places.chunk_by(|a, b| a + 1 == *b);
        let writes = runs.map(|run| {
            let words = run.iter().map(|&place| content[place as usize]);
            Write {
                buffer: self.strips,
                offset: 4 * u64::from(run[0]),
                bytes: words.flat_map(u32::to_le_bytes).collect(),
                cause: STRIP,
            }
        });
        (change, writes.collect())
    }
}

impl Resident<TrunkLevel> for StripsResident {
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
        4 + match self.model.mode {
            TrunkMode::Host => 2 * content,
            TrunkMode::Device => content,
        }
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        steps.extend_from_slice(&self.steps);
    }
}

/// The strips of a trunk and how they change from level to level.
#[derive(Debug, Clone)]
pub(super) struct StripPlan {
    /// The strips at full detail, one after another with a restart between two.
    pub(super) finest: Vec<u32>,
    /// Where each strip begins, and one past the last place.
    pub(super) starts: Vec<u32>,
    /// The triangle that a place makes with the two before it.
    pub(super) triangles: Vec<u32>,
    /// The places that hold each vertex when it goes, one vertex after another.
    places: Vec<u32>,
    /// Where each vertex's places begin, and their end.
    place_starts: Vec<u32>,
}

/// At places that make no triangle.
pub(super) const NO_TRIANGLE: u32 = u32::MAX;

impl StripPlan {
    pub(super) fn of(collapses: &VertexCollapses) -> Self {
        let strips = strips_of(collapses.triangles(), |triangle| {
            collapses.shows(triangle, 0)
        });
        let mut plan = Self {
            finest: Vec::new(),
            starts: Vec::new(),
            triangles: Vec::new(),
            places: Vec::new(),
            place_starts: Vec::new(),
        };
        for (vertices, triangles) in strips.iter() {
            if !plan.finest.is_empty() {
                plan.finest.push(RESTART);
                plan.triangles.push(NO_TRIANGLE);
            }
            plan.starts.push(index_u32(plan.finest.len()));
            plan.finest.extend_from_slice(vertices);
            plan.triangles.extend([NO_TRIANGLE; 2]);
            plan.triangles.extend_from_slice(triangles);
        }
        // As if a restart stood at the end.
        plan.starts.push(index_u32(plan.finest.len()) + 1);
        plan.list_places(collapses);
        plan
    }

    /// Every place holds a vertex until it goes, then that vertex's target, and so on.
    fn list_places(&mut self, collapses: &VertexCollapses) {
        let gone = collapses.first_vertex(collapses.collapse_count());
        let mut held: Vec<(u32, u32)> = Vec::new();
        for (place, &finest) in (0..).zip(&self.finest) {
            let mut vertex = finest;
            while let Some(target) = collapses.target(vertex) {
                held.push((vertex, place));
                vertex = target;
            }
        }
        held.sort_unstable();
        self.place_starts = (0..=gone)
            .map(|vertex| index_u32(held.partition_point(|&(other, _)| other < vertex)))
            .collect();
        self.places = held.into_iter().map(|(_, place)| place).collect();
    }

    /// All places at a level.
    pub(super) fn at(&self, collapses: &VertexCollapses, level: TrunkLevel) -> Vec<u32> {
        let first = collapses.first_vertex(level.collapses);
        let mut moved: Vec<u32> = (0..collapses.vertex_count()).collect();
        for vertex in (0..first).rev() {
            if let Some(target) = collapses.target(vertex) {
                moved[vertex as usize] = moved[target as usize];
            }
        }
        let at = |&vertex: &u32| match vertex {
            RESTART => RESTART,
            vertex => moved[vertex as usize],
        };
        self.finest.iter().map(at).collect()
    }

    /// Takes all places from one level to another; returns those that differ, ascending, and how many
    /// records were read and written: for every place of a vertex on the way its record and the
    /// place, and the vertex's target.
    pub(super) fn change(
        &self,
        collapses: &VertexCollapses,
        content: &mut [u32],
        from: TrunkLevel,
        to: TrunkLevel,
    ) -> (Vec<u32>, u64) {
        let [first, end] = [from, to].map(|level| collapses.first_vertex(level.collapses));
        let mut before: Vec<(u32, u32)> = Vec::new();
        let mut put = |vertex: u32, value: u32| {
            let ends = &self.place_starts[vertex as usize..vertex as usize + 2];
            for &place in &self.places[ends[0] as usize..ends[1] as usize] {
                let held = &mut content[place as usize];
                before.push((place, std::mem::replace(held, value)));
            }
        };
        for vertex in first..end {
            let target = collapses.target(vertex);
            put(vertex, target.expect("a vertex that goes has a target"));
        }
        for vertex in (end..first).rev() {
            put(vertex, vertex);
        }
        let records = 2 * before.len() as u64 + u64::from(first.abs_diff(end));
        // Of several values the first is what the place held; the sort is stable.
        before.sort_by_key(|&(place, _)| place);
        before.dedup_by_key(|&mut (place, _)| place);
        let differ = before
            .into_iter()
            .filter(|&(place, held)| content[place as usize] != held);
        (differ.map(|(place, _)| place).collect(), records)
    }

    /// The strip that a place is in.
    pub(super) fn strip_of(&self, place: u32) -> u32 {
        index_u32(self.starts.partition_point(|&start| start <= place)) - 1
    }

    /// How many strips some ascending places are in.
    fn strips_of_places(&self, places: &[u32]) -> u32 {
        let strips = places.iter().map(|&place| self.strip_of(place));
        let mut strips: Vec<u32> = strips.collect();
        strips.dedup();
        index_u32(strips.len())
    }

    /// As bytes, little-endian: the target of every vertex that goes; the strips; the places of each
    /// vertex that goes, and where they begin (4 bytes each).
    pub(super) fn host_bytes(&self, collapses: &VertexCollapses) -> Vec<u8> {
        let targets = (0..collapses.vertex_count()).filter_map(|vertex| collapses.target(vertex));
        let words = targets
            .chain(self.finest.iter().copied())
            .chain(self.places.iter().copied())
            .chain(self.place_starts.iter().copied());
        words.flat_map(u32::to_le_bytes).collect()
    }

    /// The length of [`host_bytes`](Self::host_bytes).
    pub(super) fn host_size(&self, collapses: &VertexCollapses) -> u64 {
        let gone = u64::from(collapses.first_vertex(collapses.collapse_count()));
        4 * (2 * gone + 1 + (self.finest.len() + self.places.len()) as u64)
    }
}

/// The triangles that strips show, without those that name a vertex twice.
#[cfg(test)]
pub(super) fn shown(strips: &[u32]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for strip in strips.split(|&place| place == RESTART) {
        let windows = strip.windows(3).filter_map(<[u32]>::first_chunk);
        for (number, &[a, b, c]) in windows.enumerate() {
            if a != b && b != c && c != a {
                let turned = if number % 2 == 0 {
                    [a, b, c]
                } else {
                    [b, a, c]
                };
                triangles.push(crate::simplify::lowest_first(turned));
            }
        }
    }
    triangles.sort_unstable();
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_show_the_mesh_at_every_level_whichever_way_they_came() {
        let trunk = super::super::examples::branch(6, 5);
        let collapses = trunk.collapses();
        let plan = StripPlan::of(collapses);
        let count = collapses.collapse_count();
        let level = |collapses| TrunkLevel { collapses };
        let mut content = plan.finest.clone();
        let mut at = level(0);
        for next in (0..=count)
            .chain((0..count).rev())
            .chain([count, 3, count / 2, 0])
        {
            plan.change(collapses, &mut content, at, level(next));
            at = level(next);
            assert_eq!(content, plan.at(collapses, at));
            let mut wanted: Vec<_> = collapses.triangles_after(next).map(|(_, t)| t).collect();
            wanted.sort_unstable();
            assert_eq!(shown(&content), wanted, "level {next}");
        }
    }
}
