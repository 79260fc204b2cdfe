//! How leaf records and vertices look as bytes, wide or small.
//!
//! | | wide | small |
//! |---|---|---|
//! | record | [`Records::Wide`]: 4 × `u32` vertex indices, 16 B | [`Records::Compact`]: 4 × `u16` counted from the cluster's first vertex, 8 B |
//! | vertex | [`Vertices::Float`]: 3 × `f32`, 12 B | [`Vertices::Quantised`]: 3 × `u16` steps in the crown's box, then 0: 8 B |
//!
//! For compact records vertices are sorted by cluster, within one as they were, and every cluster is
//! drawn with its first vertex. Ties of depth are broken by the vertex numbers of all other modes, so
//! for each four vertices of a leaf their number is kept beside them, 4 B: pictures are the same to the
//! bit. (A card would not need it.) Only original leaves have vertices of their own, unless
//! [collapses add some](crate::simplify::CollapseSequence::added_vertices). A cluster with more than
//! 16,384 leaves that have their own vertices, which `u16` cannot number, is refused.
//!
//! Quantised vertices are displaced by half a step at most along each axis: 1/131,070 of the crown's
//! box, 0.15 mm for 20 m. Pictures differ from those of float vertices, and are the same in all modes
//! with quantised ones.

use std::sync::Arc;

use super::Crown;
use crate::gpu::{Corners, GpuError, IndirectRecord, Words};
use crate::math::{Vec3, index_u32};

/// How wide a leaf record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Records {
    /// 16 bytes: four vertex numbers.
    Wide,
    /// 8 bytes: four numbers of vertices within the cluster.
    Compact,
}

/// How wide a vertex is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Vertices {
    /// 12 bytes: three floats.
    Float,
    /// 8 bytes: three steps of the crown's box in 65,535.
    Quantised,
}

/// How leaves look as bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LeafFormat {
    /// The records; models that have none do not care.
    pub records: Records,
    /// The vertices.
    pub vertices: Vertices,
}

impl Vertices {
    /// Where the vertices of a crown lie for programs that read them so.
    #[must_use]
    pub fn positions(self, crown: &Crown) -> Vec<Vec3> {
        let all = crown.vertices().iter();
        match self {
            Self::Float => all.copied().collect(),
            Self::Quantised => {
                let grid = Grid::around(crown);
                let steps = all.map(|vertex| grid.steps(*vertex));
                steps.map(|[x, y, z, _]| grid.point([x, y, z])).collect()
            }
        }
    }
}

impl LeafFormat {
    /// As in the papers.
    pub const WIDE: Self = Self {
        records: Records::Wide,
        vertices: Vertices::Float,
    };

    /// Every format.
    pub const ALL: [Self; 4] = [
        Self::WIDE,
        Self {
            records: Records::Compact,
            vertices: Vertices::Float,
        },
        Self {
            records: Records::Wide,
            vertices: Vertices::Quantised,
        },
        Self {
            records: Records::Compact,
            vertices: Vertices::Quantised,
        },
    ];

    /// Bytes a vertex.
    #[must_use]
    pub fn vertex_bytes(self) -> u32 {
        match self.vertices {
            Vertices::Float => 12,
            Vertices::Quantised => 8,
        }
    }

    /// Bytes a leaf record.
    #[must_use]
    pub fn record_bytes(self) -> u32 {
        match self.records {
            Records::Wide => 16,
            Records::Compact => 8,
        }
    }

    /// How draws read records.
    pub(super) fn source(self) -> Corners {
        match self.records {
            Records::Wide => Corners::Indexed,
            Records::Compact => Corners::Short,
        }
    }
}

/// The most leaves of a cluster with vertices of their own that `u16` can number.
const COMPACT_LEAVES: usize = 1 << 14;

/// Writes the leaves of a crown in a format.
#[derive(Debug, Clone)]
pub(super) struct LeafBytes {
    pub(super) format: LeafFormat,
    crown: Arc<Crown>,
    /// How many of the crown's vertices there are: all, or those of the original leaves.
    vertex_count: usize,
    /// For compact records.
    by_cluster: Option<Arc<ByCluster>>,
}

/// The vertices sorted by cluster, within one ascending, in blocks of the four of a leaf: block `b`
/// holds vertices `4 b .. 4 b + 4`, those of original leaf `b` if there is one.
#[derive(Debug)]
struct ByCluster {
    blocks: Vec<u32>,
    /// Where each block stands there.
    places: Vec<u32>,
    /// The first vertex of each cluster.
    first_vertices: Vec<u32>,
}

impl ByCluster {
    fn of(crown: &Crown) -> Self {
        let cluster_of_leaf = &crown.clusters().cluster_of_leaf;
        let cluster_of_block = |block: u32| {
            let leaf = crown.sequence().leaf_of_vertex(4 * block);
            cluster_of_leaf[leaf as usize]
        };
        let mut blocks: Vec<u32> = (0..index_u32(crown.vertices().len() / 4)).collect();
        // Stable: within a cluster blocks stay ascending.
        blocks.sort_by_key(|&block| cluster_of_block(block));
        let mut places = vec![0; blocks.len()];
        let mut first_vertices = Vec::with_capacity(crown.clusters().clusters.len());
        for (place, &block) in (0..).zip(&blocks) {
            places[block as usize] = place;
            if cluster_of_block(block) as usize == first_vertices.len() {
                first_vertices.push(4 * place);
            }
        }
        Self {
            blocks,
            places,
            first_vertices,
        }
    }

    /// How many leaves of each cluster have vertices of their own.
    fn sizes(&self) -> impl Iterator<Item = usize> {
        let ends = self
            .first_vertices
            .iter()
            .skip(1)
            .map(|&first| first as usize / 4);
        let ends = ends.chain([self.blocks.len()]);
        let firsts = self.first_vertices.iter().map(|&first| first as usize / 4);
        firsts.zip(ends).map(|(first, end)| end - first)
    }
}

impl LeafBytes {
    pub(super) fn new(crown: &Arc<Crown>, format: LeafFormat) -> Self {
        let compact = format.records == Records::Compact;
        Self {
            format,
            crown: Arc::clone(crown),
            vertex_count: crown.vertices().len(),
            by_cluster: compact.then(|| Arc::new(ByCluster::of(crown))),
        }
    }

    /// Of the original leaves alone, which need no records.
    pub(super) fn of_originals(crown: &Arc<Crown>, vertices: Vertices) -> Self {
        let format = LeafFormat {
            records: Records::Wide,
            vertices,
        };
        Self {
            vertex_count: crown.original_vertices().len(),
            ..Self::new(crown, format)
        }
    }

    /// Refuses a crown that does not fit the format.
    pub(super) fn check(&self) -> Result<(), GpuError> {
        let mut sizes = self.by_cluster.iter().flat_map(|sorted| sorted.sizes());
        match sizes.find(|size| *size > COMPACT_LEAVES) {
            None => Ok(()),
            Some(size) => Err(GpuError::Unsupported {
                what: format!(
                    "a cluster of {size} leaves in compact records (at most {COMPACT_LEAVES} fit)"
                ),
            }),
        }
    }

    /// Adds one leaf's record.
    pub(super) fn push_record(&self, leaf: u32, bytes: &mut Vec<u8>) {
        let Some(by_cluster) = &self.by_cluster else {
            bytes.extend(self.crown.record_bytes(leaf));
            return;
        };
        let cluster = self.crown.clusters().cluster_of_leaf[leaf as usize];
        let first = by_cluster.first_vertices[cluster as usize];
        for vertex in self.crown.sequence().corners()[leaf as usize] {
            let sorted = 4 * by_cluster.places[vertex as usize / 4] + vertex % 4;
            let local = u16::try_from(sorted - first);
            bytes.extend(local.expect("upload refuses larger clusters").to_le_bytes());
        }
    }

    /// The record of one leaf.
    pub(super) fn record(&self, leaf: u32) -> Vec<u8> {
        self.records([leaf])
    }

    /// The records of several leaves, one after another.
    pub(super) fn records(&self, leaves: impl IntoIterator<Item = u32>) -> Vec<u8> {
        let mut bytes = Vec::new();
        for leaf in leaves {
            self.push_record(leaf, &mut bytes);
        }
        bytes
    }

    /// Bytes a record.
    pub(super) fn stride(&self) -> u64 {
        self.format.record_bytes().into()
    }

    /// The vertex to which a cluster's compact records count; 0 for wide ones.
    pub(super) fn first_vertex(&self, cluster: u32) -> u32 {
        let first = self.by_cluster.as_ref();
        first.map_or(0, |sorted| sorted.first_vertices[cluster as usize])
    }

    /// The arguments of a draw, as [`Corners::record_bytes`] says.
    pub(super) fn argument_bytes(&self, record: IndirectRecord, cluster: u32) -> Vec<u8> {
        let mut bytes = record.to_bytes().to_vec();
        if self.by_cluster.is_some() {
            bytes.extend(self.first_vertex(cluster).to_le_bytes());
        }
        bytes
    }

    /// Bytes of a draw's arguments.
    pub(super) fn argument_stride(&self) -> u64 {
        self.format.source().record_bytes()
    }

    /// How many vertex bytes there are.
    pub(super) fn vertex_size(&self) -> u64 {
        u64::from(self.format.vertex_bytes()) * self.vertex_count as u64
    }

    /// How many vertices there are.
    pub(super) fn vertex_count(&self) -> u32 {
        index_u32(self.vertex_count)
    }

    /// All vertices, in the order that records count in.
    pub(super) fn vertices(&self) -> Vec<u8> {
        let all = &self.crown.vertices()[..self.vertex_count];
        let sorted: Vec<Vec3> = match &self.by_cluster {
            None => all.to_vec(),
            Some(sorted) => sorted
                .blocks
                .iter()
                .flat_map(|&block| &all[4 * block as usize..][..4])
                .copied()
                .collect(),
        };
        match self.format.vertices {
            Vertices::Float => sorted
                .iter()
                .flat_map(|vertex| vertex.to_array())
                .flat_map(f32::to_le_bytes)
                .collect(),
            Vertices::Quantised => {
                let grid = Grid::around(&self.crown);
                let steps = sorted.iter().flat_map(|vertex| grid.steps(*vertex));
                steps.flat_map(u16::to_le_bytes).collect()
            }
        }
    }

    /// How far vertices may be displaced along each axis, at most; twice what quantising does.
    pub(super) fn grid_step(&self) -> Vec3 {
        match self.format.vertices {
            Vertices::Float => Vec3::ZERO,
            Vertices::Quantised => Grid::around(&self.crown).step,
        }
    }

    /// What programs need to read vertices, with a label each: the number of each four vertices
    /// (4 bytes; that of an original leaf, or more) for compact records, the [`Grid`] (24 bytes) for quantised vertices.
    pub(super) fn keys(&self) -> Vec<(&'static str, Vec<u8>)> {
        let mut keys = Vec::new();
        if let Some(sorted) = &self.by_cluster {
            let numbers = sorted.blocks.iter().flat_map(|block| block.to_le_bytes());
            keys.push(("leaf numbers", numbers.collect()));
        }
        if self.format.vertices == Vertices::Quantised {
            keys.push(("vertex grid", Grid::around(&self.crown).to_bytes()));
        }
        keys
    }

    /// How many bytes these are.
    pub(super) fn key_size(&self) -> u64 {
        self.keys()
            .iter()
            .map(|(_, bytes)| bytes.len() as u64)
            .sum()
    }
}

/// Where quantised vertices may lie: `origin + step · (x, y, z)`.
///
/// On the device: `origin`, then `step`, 3 × `f32` each: 24 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    origin: Vec3,
    step: Vec3,
}

impl Grid {
    fn around(crown: &Crown) -> Self {
        let bounds = crown.bounds();
        Self {
            origin: bounds.min,
            step: bounds.size() / 65_535.0,
        }
    }

    fn to_bytes(self) -> Vec<u8> {
        let floats = [self.origin.to_array(), self.step.to_array()];
        floats
            .iter()
            .flatten()
            .flat_map(|float| float.to_le_bytes())
            .collect()
    }

    fn read(words: Words<'_>) -> Self {
        Self {
            origin: Vec3::from_array(words.f32s(0)),
            step: Vec3::from_array(words.f32s(3)),
        }
    }

    /// The steps to the nearest point of the grid, and a 0.
    fn steps(&self, vertex: Vec3) -> [u16; 4] {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let (from, step) = (f64::from(self.origin[axis]), f64::from(self.step[axis]));
            if step > 0.0 {
                nearest((f64::from(vertex[axis]) - from) / step)
            } else {
                0
            }
        });
        [x, y, z, 0]
    }

    fn point(&self, [x, y, z]: [u16; 3]) -> Vec3 {
        self.origin + self.step * Vec3::new(f32::from(x), f32::from(y), f32::from(z))
    }
}

/// The nearest whole number that `u16` holds.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "kept within the type's range first"
)]
fn nearest(steps: f64) -> u16 {
    (steps + 0.5).floor().clamp(0.0, 65_535.0) as u16
}

/// Reads vertices in a format.
#[derive(Debug, Clone, Copy)]
pub(super) struct VertexReader<'a> {
    vertices: Words<'a>,
    numbers: Option<Words<'a>>,
    grid: Option<Grid>,
}

impl<'a> VertexReader<'a> {
    /// Over bound vertices, and what [`LeafBytes::keys`] made.
    pub(super) fn new(
        format: LeafFormat,
        vertices: Words<'a>,
        mut key: impl FnMut() -> Words<'a>,
    ) -> Self {
        let compact = format.records == Records::Compact;
        let quantised = format.vertices == Vertices::Quantised;
        Self {
            vertices,
            numbers: compact.then(&mut key),
            grid: quantised.then(|| Grid::read(key())),
        }
    }

    /// The same over other vertices.
    pub(super) fn over(self, vertices: Words<'a>) -> Self {
        Self { vertices, ..self }
    }

    /// Where a vertex lies, in the plant's space.
    #[inline(always)]
    pub(super) fn position(&self, vertex: u32) -> Vec3 {
        let vertex = vertex as usize;
        match self.grid {
            None => Vec3::from_array(self.vertices.f32s(3 * vertex)),
            Some(grid) => {
                let [first, second] = self.vertices.u32s(2 * vertex);
                let [a, b, c, d] = first.to_le_bytes();
                let [e, f, ..] = second.to_le_bytes();
                grid.point([[a, b], [c, d], [e, f]].map(u16::from_le_bytes))
            }
        }
    }

    /// Where the corners of a leaf lie.
    #[inline(always)]
    pub(super) fn positions(&self, leaf: [u32; 4]) -> [Vec3; 4] {
        let first = leaf[0];
        if self.grid.is_none()
            && (1..)
                .zip(&leaf[1..])
                .all(|(k, &corner)| corner.wrapping_sub(first) == k)
        {
            let all = self.vertices.f32s::<12>(3 * first as usize);
            return [0, 3, 6, 9].map(|at| Vec3::new(all[at], all[at + 1], all[at + 2]));
        }
        leaf.map(|vertex| self.position(vertex))
    }

    /// The number that a vertex has in all modes.
    #[inline(always)]
    pub(super) fn number(&self, vertex: u32) -> u32 {
        self.numbers.map_or(vertex, |numbers| {
            4 * numbers.u32(vertex as usize / 4) + vertex % 4
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantised_points_lie_within_half_a_step() {
        let grid = Grid {
            origin: Vec3::new(-3.0, 0.0, 7.0),
            step: Vec3::new(20.0, 9.5, 0.0) / 65_535.0,
        };
        for number in 0..1000_u16 {
            let share = f32::from(number) / 999.0;
            let vertex = Vec3::new(-3.0 + 20.0 * share, 9.5 * share * share, 7.0);
            let [x, y, z, rest] = grid.steps(vertex);
            let moved = (grid.point([x, y, z]) - vertex).abs();
            // Half a step, and what `f32` rounds at 20 m.
            assert!(moved.x <= 0.5 * grid.step.x + 2e-6, "{moved} at {share}");
            assert!(moved.y <= 0.5 * grid.step.y + 2e-6, "{moved} at {share}");
            assert_eq!((z, rest, moved.z), (0, 0, 0.0));
        }
        let most = grid.steps(Vec3::new(17.0, 9.5, 7.0));
        assert_eq!(most[..2], [65_535; 2]);
    }
}
