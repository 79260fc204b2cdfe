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

use super::planned::{Drawn, PlanSizes, Planned, TrunkPlan};
use super::surface::trunk_buffer;
use super::writes::Write;
use super::{TRUNK_GROUP, Trunk, TrunkLevel, TrunkName};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Corners, Device, Draw, GpuError, RESTART, Residency, Step,
    Usage,
};
use crate::math::index_u32;
use crate::models::Change;
use crate::simplify::VertexCollapses;

/// Why places of strips are sent.
const STRIP: Cause = Cause::of("strip");

/// LodStrips with strips of fixed length.
///
/// Host memory: 32 bytes a vertex (for `Host`); then the structures of [`StripPlan::host_words`].
/// Device memory for `Device`: 32 bytes a vertex once, 4 bytes a place for each instance.
pub(super) type LodStrips = Planned<StripPlan>;

/// The strips of an instance.
#[derive(Debug, Clone)]
pub(super) struct Strips {
    buffer: BufferId,
    /// The same as in the buffer.
    content: Vec<u32>,
}

impl TrunkPlan for StripPlan {
    const NAME: TrunkName = TrunkName::LodStrips;
    type Instance = Strips;

    fn of(trunk: &Trunk) -> Self {
        let mut plan = Self {
            finest: Vec::new(),
            starts: Vec::new(),
            triangles: Vec::new(),
            places: Vec::new(),
            place_starts: Vec::new(),
        };
        for (vertices, triangles) in trunk.strips().iter() {
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
        plan.list_places(trunk.collapses());
        plan
    }

    fn host_bytes(model: &Planned<Self>) -> Vec<u8> {
        model.plan.host_words(model.trunk.collapses())
    }

    fn sizes(model: &Planned<Self>) -> PlanSizes {
        let places = 4 * model.plan.finest.len() as u64;
        PlanSizes {
            host: model.plan.host_size(model.trunk.collapses()),
            instance: places,
            kept: 4 + places,
        }
    }

    fn instance(
        model: &Planned<Self>,
        device: &mut Device,
        level: TrunkLevel,
        number: u32,
    ) -> Result<Drawn<Strips>, GpuError> {
        let content = model.plan.at(model.trunk.collapses(), level);
        let places = content.iter();
        let bytes: Vec<u8> = places.flat_map(|place| place.to_le_bytes()).collect();
        let descriptor = BufferDescriptor {
            label: "trunk strips",
            size: bytes.len() as u64,
            usage: Usage::INDEX,
            residency: model.mode.residency(),
        };
        let buffer = trunk_buffer(device, &descriptor, &bytes)?;
        Ok(Drawn {
            draw: Step::Draw(Draw {
                source: Corners::Strips,
                first_corner: 0,
                corner_count: index_u32(content.len()),
                instance: number,
                group: TRUNK_GROUP,
            }),
            instance: Strips { buffer, content },
            indices: buffer,
        })
    }

    fn step(
        model: &Planned<Self>,
        strips: &mut Strips,
        [from, to]: [TrunkLevel; 2],
    ) -> (Change, Vec<Write>) {
        let Strips { buffer, content } = strips;
        let plan = &model.plan;
        let (places, host_records) = plan.change(model.trunk.collapses(), content, from, to);
        let change = Change {
            host_records,
            clusters_touched: plan.strips_of_places(&places),
            ..Change::default()
        };
        // Places side by side go together.
        let runs = places.chunk_by(|a, b| a + 1 == *b);
        let writes = runs.map(|run| {
            let words = run.iter().map(|&place| content[place as usize]);
            Write {
                buffer: *buffer,
                offset: 4 * u64::from(run[0]),
                bytes: words.flat_map(u32::to_le_bytes).collect(),
                cause: STRIP,
            }
        });
        (change, writes.collect())
    }

    fn instance_host_bytes(model: &Planned<Self>, strips: &Strips) -> u64 {
        let content = 4 * strips.content.len() as u64;
        match model.mode.residency() {
            Residency::Host => 2 * content,
            Residency::Device => content,
        }
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
        let first = collapses.first_vertex(level.collapses());
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
        let [first, end] = [from, to].map(|level| collapses.first_vertex(level.collapses()));
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
    pub(super) fn host_words(&self, collapses: &VertexCollapses) -> Vec<u8> {
        let targets = (0..collapses.vertex_count()).filter_map(|vertex| collapses.target(vertex));
        let words = targets
            .chain(self.finest.iter().copied())
            .chain(self.places.iter().copied())
            .chain(self.place_starts.iter().copied());
        words.flat_map(u32::to_le_bytes).collect()
    }

    /// The length of [`host_words`](Self::host_words).
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
        let plan = StripPlan::of(&trunk);
        let count = collapses.collapse_count();
        let level = |collapses| TrunkLevel::Collapses(collapses);
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
