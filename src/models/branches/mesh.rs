//! The level itself on the device: a change sends its vertices and corners.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use super::lines::{LINE_BYTES, line_bytes};
use super::parameters::Parameters;
use super::surfaces::{Part, Surfaces};
use crate::gpu::{
    BufferDescriptor, BufferId, Cause, Device, GpuError, Queue, Residency, Step, Usage,
};
use crate::math::index_u32;
use crate::models::{
    Change, Environment, Resident, Shared, Storage, Trunk, TrunkKind, TrunkLevel, TrunkModel,
};
use crate::scene::{TrunkMode, TrunkName};
use crate::simplify::{BranchLevel, BranchMesh, ErrorStep, PrimitiveCounts};

/// Bytes of a polygon's vertex: position, normal (3 × `f32` each), texture coordinate (2 × `f32`).
const VERTEX_BYTES: u32 = 32;

/// Why what is there at first is sent.
const TRUNK: Cause = Cause::of("trunk");
/// Why levels are sent.
const MESH: Cause = Cause::of("branch mesh");

/// The mode `mesh`.
///
/// In host memory all that levels are made of: 56 B a node (skeletal vector, way from the base), 12 B a
/// merge, 16 B a branch (its nodes, its bearer's, when it goes), 36 B a needle, merged or not. On the device
/// room for the largest level, once an instance, of which a level fills the first part of each buffer.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    trunk: Arc<Trunk>,
    /// The level that was made last, for the next that asks: all instances that go over to one.
    last: Arc<Mutex<Option<Arc<MadeLevel>>>>,
}

#[derive(Debug)]
struct MadeLevel {
    step: ErrorStep,
    bytes: LevelBytes,
    ranges: Ranges,
    counts: PrimitiveCounts,
}

/// Vertices and corners as they lie in four buffers: of polygons, then of lines.
#[derive(Debug, Clone, Default)]
pub(super) struct LevelBytes {
    buffers: [Vec<u8>; 4],
}

/// Which corners of polygons and of lines are wood's and which the needles'.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Ranges {
    polygons: [Range<u32>; 2],
    lines: [Range<u32>; 2],
}

/// The labels and uses of the four buffers.
const BUFFERS: [(&str, Usage); 4] = [
    ("trunk vertices", Usage::VERTEX),
    ("trunk indices", Usage::INDEX),
    ("trunk line vertices", Usage::VERTEX),
    ("trunk line indices", Usage::INDEX),
];

impl LevelBytes {
    /// Appends a level; where its corners lie.
    pub(super) fn add(&mut self, level: &BranchLevel) -> Ranges {
        let [wood, needles] = [&level.branches, &level.needles].map(|mesh| self.add_mesh(mesh));
        let [wood_polygons, wood_lines] = wood;
        let [needle_polygons, needle_lines] = needles;
        Ranges {
            polygons: [wood_polygons, needle_polygons],
            lines: [wood_lines, needle_lines],
        }
    }

    /// The corners of polygons and of lines.
    fn add_mesh(&mut self, mesh: &BranchMesh) -> [Range<u32>; 2] {
        let mut on_line = vec![false; mesh.vertices.len()];
        for &vertex in mesh.lines.iter().flatten() {
            on_line[vertex as usize] = true;
        }
        let [vertices, indices, line_vertices, line_indices] = &mut self.buffers;
        let mut numbers = Vec::with_capacity(mesh.vertices.len());
        for (vertex, on_line) in mesh.vertices.iter().zip(on_line) {
            let (buffer, stride) = if on_line {
                (&mut *line_vertices, LINE_BYTES)
            } else {
                (&mut *vertices, VERTEX_BYTES)
            };
            numbers.push(index_u32(buffer.len()) / stride);
            let bytes = line_bytes(vertex).take(stride as usize);
            buffer.extend(bytes);
        }
        let add = |buffer: &mut Vec<u8>, vertices: &mut dyn Iterator<Item = u32>| {
            let start = index_u32(buffer.len() / 4);
            let numbers = vertices.map(|vertex| numbers[vertex as usize]);
            buffer.extend(numbers.flat_map(u32::to_le_bytes));
            start..index_u32(buffer.len() / 4)
        };
        [
            add(indices, &mut mesh.drawn_triangles().flatten()),
            add(line_indices, &mut mesh.lines.iter().copied().flatten()),
        ]
    }

    pub(super) fn size(&self) -> u64 {
        self.buffers.iter().map(|bytes| bytes.len() as u64).sum()
    }
}

/// Four buffers on the device and what is drawn from them.
#[derive(Debug, Clone)]
pub(super) struct Drawing {
    surfaces: Surfaces,
    buffers: [BufferId; 4],
}

impl Drawing {
    /// Makes buffers of these sizes.
    fn with_room(
        device: &mut Device,
        surfaces: Surfaces,
        sizes: [u64; 4],
    ) -> Result<Self, GpuError> {
        let mut buffers = Vec::with_capacity(4);
        for ((label, usage), size) in BUFFERS.into_iter().zip(sizes) {
            buffers.push(device.create_buffer(&BufferDescriptor {
                label,
                size,
                usage,
                residency: Residency::Device,
            })?);
        }
        Ok(Self {
            surfaces,
            buffers: buffers.try_into().expect("four sizes make four buffers"),
        })
    }

    /// Makes buffers and sends all they hold, under the cause `trunk`.
    pub(super) fn filled(
        device: &mut Device,
        surfaces: Surfaces,
        bytes: &LevelBytes,
    ) -> Result<Self, GpuError> {
        let sizes = bytes.buffers.each_ref().map(|bytes| bytes.len() as u64);
        let drawing = Self::with_room(device, surfaces, sizes)?;
        drawing.send(&mut device.queue(), bytes, TRUNK)?;
        Ok(drawing)
    }

    fn send(
        &self,
        queue: &mut Queue<'_>,
        bytes: &LevelBytes,
        cause: Cause,
    ) -> Result<(), GpuError> {
        for (&buffer, bytes) in self.buffers.iter().zip(&bytes.buffers) {
            queue.write(buffer, 0, bytes, cause)?;
        }
        Ok(())
    }

    /// Draws the polygons of a level.
    pub(super) fn draw(&self, ranges: &Ranges, number: u32, steps: &mut Vec<Step>) {
        let [vertices, indices, ..] = self.buffers;
        let program = self.surfaces.environment.mesh;
        for (part, corners) in [Part::Wood, Part::Needles]
            .into_iter()
            .zip(&ranges.polygons)
        {
            let draw = (part, program);
            self.surfaces
                .draw_indexed(draw, [vertices, indices], corners, number, steps);
        }
    }

    /// Draws its lines.
    pub(super) fn draw_lines(&self, ranges: &Ranges, number: u32, steps: &mut Vec<Step>) {
        let [.., vertices, indices] = self.buffers;
        let program = self.surfaces.environment.branch_lines;
        for (part, corners) in [Part::Wood, Part::Needles].into_iter().zip(&ranges.lines) {
            let draw = (part, program);
            self.surfaces
                .draw_indexed(draw, [vertices, indices], corners, number, steps);
        }
    }
}

impl Mesh {
    pub(super) fn new(trunk: Arc<Trunk>) -> Self {
        Self {
            trunk,
            last: Arc::default(),
        }
    }

    /// The step that shows.
    fn step(&self, level: TrunkLevel) -> ErrorStep {
        level.step().max(self.trunk.branch_choice().steps()[0])
    }

    fn made(&self, level: TrunkLevel) -> Arc<MadeLevel> {
        let step = self.step(level);
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some(made) if made.step == step => Arc::clone(made),
            _ => {
                let level = self.trunk.branch_level(step);
                let mut bytes = LevelBytes::default();
                let ranges = bytes.add(&level);
                let counts = level.counts();
                let made = Arc::new(MadeLevel {
                    step,
                    bytes,
                    ranges,
                    counts,
                });
                *last = Some(Arc::clone(&made));
                made
            }
        }
    }

    /// The most bytes that a level can have in each buffer.
    ///
    /// Nodes that stay have no more edges at a greater error, and the two triangles a side between two rings
    /// are as many as both have edges; so no level has more triangles than all nodes with the edges of the
    /// finest. A point has at most an apex to either side. A merged needle is always a line.
    fn room(&self) -> [u64; 4] {
        let sequence = self.trunk.branches();
        let [finest, _] = self.trunk.branch_choice().steps();
        let shares = self.trunk.branch_choice().error_shares();
        let error = sequence.errors(finest.error(), shares).polygon;
        let edges = |radius: f32| u64::from(sequence.edges_of(radius, error));
        let (mut vertices, mut triangles, mut nodes, mut lines) = (0, 0, 0, 0);
        for branch in &sequence.skeleton().branches {
            let vectors = sequence.skeleton().vectors_of(branch);
            nodes += vectors.len() as u64;
            lines += vectors.len() as u64 - 1;
            vertices += 1;
            for vector in vectors {
                let edges = edges(vector.radius);
                vertices += edges.max(2);
                triangles += 2 * edges;
            }
        }
        let originals = sequence.needles().original_count() as usize;
        for needle in &sequence.needles().needles()[..originals] {
            let edges = edges(needle.radius);
            nodes += 2;
            lines += 1;
            vertices += 2 * edges + 1;
            triangles += 3 * edges;
        }
        let normals = sequence.polygon_options().line_normals.angles().len() as u64;
        [
            u64::from(VERTEX_BYTES) * vertices,
            12 * triangles,
            u64::from(LINE_BYTES) * normals * nodes,
            8 * normals * lines,
        ]
    }
}

impl TrunkModel for Mesh {
    fn kind(&self) -> TrunkKind {
        TrunkKind {
            name: TrunkName::Branches,
            mode: TrunkMode::Mesh,
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
        Ok(Box::new(MeshShared {
            model: self.clone(),
            surfaces: Surfaces::upload(device, environment, &self.trunk)?,
        }))
    }

    fn host_bytes(&self) -> Vec<u8> {
        let sequence = self.trunk.branches();
        let skeleton = sequence.skeleton();
        let mut bytes = Vec::new();
        for (place, vector) in skeleton.vectors.iter().enumerate() {
            bytes.extend(vector.to_bytes());
            bytes.extend(skeleton.along[place].to_le_bytes());
            for merge in sequence.merges().ending_at(place) {
                bytes.extend(merge.from.to_le_bytes());
                bytes.extend(merge.skeleton.to_le_bytes());
                bytes.extend(merge.radius.to_le_bytes());
            }
        }
        let goes = sequence.topology().accumulated();
        for (branch, goes) in skeleton.branches.iter().zip(goes) {
            let bearer = branch.attachment.map_or(u32::MAX, |at| at.branch);
            let words = [branch.first, branch.count, bearer, goes.to_bits()];
            bytes.extend(words.into_iter().flat_map(u32::to_le_bytes));
        }
        let needles = sequence.needles();
        let kept = needles.needles().iter().zip(needles.errors());
        for ((needle, error), until) in kept.zip(needles.until()) {
            let [base, tip] = needle.ends.map(|end| end.to_array());
            let floats = base.into_iter().chain(tip);
            let floats = floats.chain([needle.radius, *error, *until]);
            bytes.extend(floats.flat_map(f32::to_le_bytes));
        }
        bytes
    }

    fn storage(&self) -> Storage {
        let sequence = self.trunk.branches();
        let skeleton = sequence.skeleton();
        let count = |length: usize, bytes: u64| bytes * length as u64;
        Storage {
            host_bytes: count(skeleton.vectors.len(), 56)
                + count(sequence.merges().count(), 12)
                + count(skeleton.branches.len(), 16)
                + count(sequence.needles().needles().len(), 36),
            shared_bytes: Parameters::BYTES,
            instance_bytes: self.room().iter().sum(),
            instance_host_bytes: 4,
        }
    }
}

#[derive(Debug)]
struct MeshShared {
    model: Mesh,
    surfaces: Surfaces,
}

impl Shared<TrunkLevel> for MeshShared {
    fn instance(
        &self,
        device: &mut Device,
        level: &TrunkLevel,
        number: u32,
    ) -> Result<Box<dyn Resident<TrunkLevel>>, GpuError> {
        let drawing = Drawing::with_room(device, self.surfaces.clone(), self.model.room())?;
        let made = self.model.made(*level);
        drawing.send(&mut device.queue(), &made.bytes, TRUNK)?;
        Ok(Box::new(MeshResident {
            model: self.model.clone(),
            drawing,
            number,
            level: *level,
            ranges: made.ranges.clone(),
            counts: made.counts,
        }))
    }
}

#[derive(Debug)]
struct MeshResident {
    model: Mesh,
    drawing: Drawing,
    number: u32,
    level: TrunkLevel,
    ranges: Ranges,
    counts: PrimitiveCounts,
}

impl Resident<TrunkLevel> for MeshResident {
    fn state(&self) -> &TrunkLevel {
        &self.level
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &TrunkLevel) -> Result<Change, GpuError> {
        let changed = self.model.step(*to) != self.model.step(self.level);
        self.level = *to;
        if !changed {
            return Ok(Change::default());
        }
        let made = self.model.made(*to);
        self.drawing.send(queue, &made.bytes, MESH)?;
        self.ranges = made.ranges.clone();
        self.counts = made.counts;
        // The host looks at every node, merge and needle.
        let sequence = self.model.trunk.branches();
        let looked_at = sequence.skeleton().vectors.len()
            + sequence.merges().count()
            + sequence.needles().needles().len();
        Ok(Change {
            clusters_touched: 1,
            host_records: looked_at as u64,
            ..Change::default()
        })
    }

    fn price(&self, to: &TrunkLevel) -> u64 {
        if self.model.step(*to) == self.model.step(self.level) {
            0
        } else {
            self.model.made(*to).bytes.size()
        }
    }

    fn host_bytes(&self) -> u64 {
        4
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        self.drawing.draw(&self.ranges, self.number, steps);
    }

    fn draw_lines(&self, steps: &mut Vec<Step>) {
        self.drawing.draw_lines(&self.ranges, self.number, steps);
    }

    fn primitives(&self) -> Option<PrimitiveCounts> {
        Some(self.counts)
    }
}
