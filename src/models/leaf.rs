//! The programs that draw leaves.
//!
//! All share the fragment stage; they differ in the [format](LeafFormat) of records and vertices, and in
//! where a leaf's corners come from:
//!
//! - `leaf`: the input assembler names four vertices a leaf;
//! - `stamped-leaf`: corner `i` belongs to leaf record `i / 4` of a storage buffer; records that are
//!   not born yet, or gone already, are left out;
//! - `windowed-leaf`: the same, where draws begin behind what is gone of each cluster; corners of the
//!   second instance count on behind those of the first, and so on.

use fearless_simd::{Simd, SimdBase, dispatch, f32x16};

use super::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View, clip_from_plant};
use super::format::{LeafFormat, Records, VertexReader, Vertices};
use super::select_pass::crown_cluster_count;
use super::shadow::Lighting;
use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, PixelLanes, Program,
    Topology, Transform, VertexCall, Words, Wrap,
};
use crate::math::lanes::{LANES, Vec3Lanes};
use crate::math::{Mat4, Vec2, Vec3, Vec4, index_u32};

/// A program that draws leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LeafProgram {
    pub(super) source: LeafSource,
    pub(super) format: LeafFormat,
}

/// Where a leaf's corners come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LeafSource {
    /// Corners are vertex indices.
    Indexed,
    /// Corners count through stamped records.
    Stamped,
    /// Corners count through windows of records that lie cluster by cluster.
    Windowed,
}

/// The slot of the materials.
pub(super) const MATERIAL_SLOT: u32 = 2;
/// The slot of the vertices, for records that are pulled.
pub(super) const VERTEX_SLOT: u32 = 3;
/// The slot of the stamped records.
pub(super) const RECORD_SLOT: u32 = 4;
/// The slot of the counter.
pub(super) const COUNTER_SLOT: u32 = 5;
/// The slot of the clusters' thresholds.
pub(super) const THRESHOLD_SLOT: u32 = 6;

/// The slot of the clusters' first vertices, for compact records that are pulled.
pub(super) const FIRST_VERTEX_SLOT: u32 = 7;

/// The slot of the collapses done in each cluster of each instance, for windows.
pub(super) const COUNT_SLOT: u32 = 5;
/// The slot of the [crown](super::select_pass), for windows.
pub(super) const WINDOW_CROWN_SLOT: u32 = 6;
/// The slot of the clusters' first vertices, for windows of compact records.
pub(super) const WINDOW_FIRST_VERTEX_SLOT: u32 = 7;

/// Words of one pulled record: four corners, birth, cluster.
pub(super) fn stamped_words(format: LeafFormat) -> usize {
    format.record_bytes() as usize / 4 + 2
}

/// The counter that says: every cluster has a threshold of its own.
pub(super) const VARIABLE: u32 = u32::MAX;

impl Program for LeafProgram {
    fn layout(&self) -> Layout {
        let format = self.format;
        let vertex = format.vertex_bytes();
        let record = 4 * index_u32(stamped_words(format));
        let (names, vertex_stride, pulled) = match self.source {
            LeafSource::Indexed => (
                ["leaf", "compact-leaf", "quantised-leaf", "small-leaf"],
                vertex,
                [0, 0],
            ),
            LeafSource::Stamped => (
                [
                    "stamped-leaf",
                    "stamped-compact-leaf",
                    "stamped-quantised-leaf",
                    "stamped-small-leaf",
                ],
                0,
                [record, vertex],
            ),
            LeafSource::Windowed => (
                [
                    "windowed-leaf",
                    "windowed-compact-leaf",
                    "windowed-quantised-leaf",
                    "windowed-small-leaf",
                ],
                0,
                [record, vertex],
            ),
        };
        let quantised = usize::from(format.vertices == Vertices::Quantised);
        let compact = usize::from(format.records == Records::Compact);
        let keys = index_u32(quantised + compact);
        Layout {
            name: names[2 * quantised + compact],
            version: 1,
            topology: Topology::QuadList,
            blend: Blend::Opaque,
            vertex_stride,
            pulled_primitive_bytes: pulled[0],
            pulled_vertex_bytes: pulled[1],
            storage_slots: self.key_slot() + keys,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let pulled;
        // Corners as vertex numbers, and as places among the vertices at hand.
        let (leaves, places) = match self.source {
            LeafSource::Indexed => (call.corners.as_chunks().0, call.places.as_chunks().0),
            LeafSource::Stamped | LeafSource::Windowed => {
                pulled = self.standing(call);
                (&pulled[..], &pulled[..])
            }
        };
        let count = leaves.len();
        geometry.clip.reserve_exact(4 * count);
        geometry.varyings.reserve_exact(8 * count);
        geometry.vertex_ids.reserve_exact(4 * count);
        geometry.flats.reserve_exact(3 * count);
        geometry.corners.reserve_exact(4 * count);
        let stage = LeafStage::new(call.bindings, call.instance);
        let vertices = match self.source {
            LeafSource::Indexed => self.vertices(call.bindings).over(call.vertices),
            LeafSource::Stamped | LeafSource::Windowed => self.vertices(call.bindings),
        };
        dispatch!(call.instructions.level(), simd => {
            for (leaves, places) in leaves.chunks(LANES).zip(places.chunks(LANES)) {
                stage.emit(simd, leaves, places, &vertices, geometry);
            }
        });
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let materials = read_materials(bindings.storage(MATERIAL_SLOT as usize));
        let looks = materials.iter().map(|material| Look {
            texture: material.texture,
            base_color: material.base_color,
            alpha_cutoff: material.alpha_cutoff,
        });
        leaf_kernel(bindings, looks)
    }
}

/// Of all records, whether they stand or not: where leaves lie does not change with what is shown.
impl Hulls for LeafProgram {
    fn slots(&self) -> Vec<u32> {
        let pulled: &[u32] = match (self.source, self.format.records) {
            (LeafSource::Indexed, _) => &[],
            (_, Records::Wide) => &[VERTEX_SLOT, RECORD_SLOT],
            (LeafSource::Stamped, Records::Compact) => {
                &[VERTEX_SLOT, RECORD_SLOT, FIRST_VERTEX_SLOT]
            }
            (LeafSource::Windowed, Records::Compact) => {
                &[VERTEX_SLOT, RECORD_SLOT, WINDOW_FIRST_VERTEX_SLOT]
            }
        };
        let keys = self.key_slot()..self.layout().storage_slots;
        pulled.iter().copied().chain(keys).collect()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        let storage = |slot: u32| bindings.storage(slot as usize);
        let first_vertices = match self.source {
            LeafSource::Indexed => Words::default(),
            LeafSource::Stamped => storage(FIRST_VERTEX_SLOT),
            LeafSource::Windowed => storage(WINDOW_FIRST_VERTEX_SLOT),
        };
        let vertices = self.vertices(bindings);
        let (records, words) = (storage(RECORD_SLOT), stamped_words(self.format));
        let mut bounds = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        for corners in corners.as_chunks::<4>().0 {
            let corners = match self.source {
                LeafSource::Indexed => *corners,
                LeafSource::Stamped | LeafSource::Windowed => {
                    let record = match self.source {
                        LeafSource::Windowed => self.windowed(records, corners[0]),
                        LeafSource::Indexed | LeafSource::Stamped => corners[0] as usize / 4,
                    };
                    let first = words * record;
                    let cluster = || records.u32(first + words - 1);
                    self.corners(records, first, || first_vertices.u32(cluster() as usize))
                }
            };
            for point in corners.map(|corner| vertices.position(corner)) {
                bounds = [bounds[0].min(point), bounds[1].max(point)];
            }
        }
        bounds
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        clip_from_plant(bindings, instance)
    }
}

impl LeafProgram {
    /// The first slot of what the format needs beside the vertices.
    pub(super) fn key_slot(self) -> u32 {
        match (self.source, self.format.records) {
            (LeafSource::Indexed, _) => MATERIAL_SLOT + 1,
            (LeafSource::Stamped, Records::Wide) => THRESHOLD_SLOT + 1,
            (LeafSource::Stamped, Records::Compact) => FIRST_VERTEX_SLOT + 1,
            (LeafSource::Windowed, Records::Wide) => WINDOW_CROWN_SLOT + 1,
            (LeafSource::Windowed, Records::Compact) => WINDOW_FIRST_VERTEX_SLOT + 1,
        }
    }

    /// What reads the vertices.
    fn vertices<'a>(self, bindings: &Bindings<'a>) -> VertexReader<'a> {
        let storage = |slot: u32| bindings.storage(slot as usize);
        let mut slots = self.key_slot()..;
        let keys = || storage(slots.next().expect("slots do not end"));
        let vertices = match self.source {
            LeafSource::Indexed => bindings.vertices(),
            LeafSource::Stamped | LeafSource::Windowed => storage(VERTEX_SLOT),
        };
        VertexReader::new(self.format, vertices, keys)
    }

    /// How many instances' corners come before that of a corner of a window.
    fn room(self, records: Words<'_>, corner: u32) -> usize {
        let each = (records.len() / stamped_words(self.format)).max(1);
        corner as usize / 4 / each
    }

    /// The record of a corner of a window.
    fn windowed(self, records: Words<'_>, corner: u32) -> usize {
        let each = (records.len() / stamped_words(self.format)).max(1);
        corner as usize / 4 % each
    }

    /// The corners of those pulled leaves that stand.
    fn standing(self, call: &VertexCall<'_>) -> Vec<[u32; 4]> {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let (records, words) = (storage(RECORD_SLOT), stamped_words(self.format));
        let mut leaves = Vec::with_capacity(call.corners.len() / 4);
        if self.source == LeafSource::Windowed {
            let counts = storage(COUNT_SLOT);
            let first_vertices = storage(WINDOW_FIRST_VERTEX_SLOT);
            let clusters = crown_cluster_count(storage(WINDOW_CROWN_SLOT)) as usize;
            // All corners of a call are of one instance.
            let corner = call.corners.first().copied().unwrap_or(0);
            let room = self.room(records, corner);
            for corners in call.corners.as_chunks::<4>().0 {
                let first = words * self.windowed(records, corners[0]);
                let [birth, cluster] = records.u32s(first + words - 2);
                if birth <= counts.u32(room * clusters + cluster as usize) {
                    let first_vertex = || first_vertices.u32(cluster as usize);
                    leaves.push(self.corners(records, first, first_vertex));
                }
            }
            return leaves;
        }
        let thresholds = storage(THRESHOLD_SLOT);
        let counter = storage(COUNTER_SLOT).u32(0);
        for corners in call.corners.as_chunks::<4>().0 {
            let record = corners[0] as usize / 4;
            let first = words * record;
            let birth = records.u32(first + words - 2);
            let stands = if counter == VARIABLE {
                // The operands of collapse k stand at 2 k − 2 and 2 k − 1.
                let death = index_u32(record / 2) + 1;
                let threshold = thresholds.u32(records.u32(first + words - 1) as usize);
                birth <= threshold && threshold < death
            } else {
                birth <= counter
            };
            if stands {
                leaves.push(self.corners(records, first, || {
                    let cluster = records.u32(first + words - 1);
                    storage(FIRST_VERTEX_SLOT).u32(cluster as usize)
                }));
            }
        }
        leaves
    }

    /// The corners of the record that begins at a word; only compact ones ask for the first vertex.
    fn corners(
        self,
        records: Words<'_>,
        first: usize,
        first_vertex: impl FnOnce() -> u32,
    ) -> [u32; 4] {
        match self.format.records {
            Records::Wide => records.u32s(first),
            Records::Compact => {
                let ([low, high], base) = (records.u32s(first), first_vertex());
                [low & 0xffff, low >> 16, high & 0xffff, high >> 16].map(|local| local + base)
            }
        }
    }
}

/// What the vertex stage knows before it sees a leaf.
struct LeafStage {
    clip_from_world: Mat4,
    to_light: Vec3,
    placement: Placement,
    materials: Vec<LeafMaterial>,
}

impl LeafStage {
    fn new(bindings: &Bindings<'_>, instance: u32) -> Self {
        let view = View::read(bindings.storage(VIEW_SLOT as usize));
        let placements = bindings.storage(INSTANCE_SLOT as usize);
        Self {
            clip_from_world: view.clip_from_world,
            to_light: view.to_light,
            placement: Placement::from_words(placements.f32s(8 * instance as usize)),
            materials: read_materials(bindings.storage(MATERIAL_SLOT as usize)),
        }
    }

    /// Emits leaves. The normal of each is the cross product of its diagonals.
    #[inline(always)]
    fn emit<S: Simd>(
        &self,
        simd: S,
        leaves: &[[u32; 4]],
        places: &[[u32; 4]],
        vertices: &VertexReader<'_>,
        geometry: &mut Geometry,
    ) {
        let mut world = [Vec3Lanes::splat(simd, Vec3::ZERO); 4];
        let mut clip = [[[0.0_f32; LANES]; 4]; 4];
        let (scale, position) = (
            f32x16::splat(simd, self.placement.scale),
            Vec3Lanes::splat(simd, self.placement.position),
        );
        let mut at = [[[0.0_f32; LANES]; 3]; 4];
        for (lane, places) in places.iter().enumerate().take(LANES) {
            for (at, point) in at.iter_mut().zip(vertices.positions(*places)) {
                at[0][lane] = point.x;
                at[1][lane] = point.y;
                at[2][lane] = point.z;
            }
        }
        for role in 0..4 {
            let point = Vec3Lanes::new(simd, &at[role]).times(scale);
            world[role] = point.rotated(simd, self.placement.rotation).plus(position);
            let projected = world[role].projected(simd, &self.clip_from_world);
            for (axis, values) in projected.into_iter().enumerate() {
                values.store_slice(&mut clip[role][axis]);
            }
        }
        let normal = world[2].minus(world[0]).cross(world[3].minus(world[1]));
        let normal = normal.normalize_or_zero(simd);
        let mut toward = [0.0_f32; LANES];
        let towards = normal.dot(Vec3Lanes::splat(simd, self.to_light));
        towards.store_slice(&mut toward);
        for (lane, corners) in leaves.iter().enumerate().take(LANES) {
            let numbers = corners.map(|corner| vertices.number(corner));
            // Entries are few and ascending; the last one that begins at or before the corner has it.
            let group = self
                .materials
                .iter()
                .rposition(|material| material.first_vertex <= numbers[0])
                .unwrap_or(0);
            let Some(material) = self.materials.get(group) else {
                return;
            };
            let first = index_u32(geometry.clip.len());
            let at = |role: usize| {
                let [x, y, z, w] = &clip[role];
                Vec4::new(x[lane], y[lane], z[lane], w[lane])
            };
            geometry.clip.extend([at(0), at(1), at(2), at(3)]);
            let [a, b, c, d] = material.texture_corners;
            geometry
                .varyings
                .extend([a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y]);
            geometry.vertex_ids.extend(numbers);
            geometry
                .corners
                .extend([first, first + 1, first + 2, first + 3]);
            geometry.flats.extend([
                toward[lane].max(0.0),
                (-toward[lane]).max(0.0),
                f32::from_bits(index_u32(group)),
            ]);
        }
    }
}

/// One foliage group as the programs see it.
///
/// | words | field             | type      |
/// |------:|-------------------|-----------|
/// | 0     | `first_vertex`    | `u32`, the group's first vertex |
/// | 1     | `texture`         | `u32`, texture slot + 1, or 0 |
/// | 2     | `alpha_cutoff`    | `f32` |
/// | 3     | –                 | 0 |
/// | 4–7   | `base_color`      | 4 × `f32`, linear |
/// | 8–15  | `texture_corners` | 4 × 2 × `f32`, by corner role |
///
/// Little-endian, 64 bytes a group, groups ascending by first vertex. Where collapses add vertices, each
/// group that has some comes once more after all groups, with its first added one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeafMaterial {
    pub(super) first_vertex: u32,
    pub(super) texture: u32,
    pub(super) alpha_cutoff: f32,
    pub(super) base_color: Vec4,
    pub(super) texture_corners: [Vec2; 4],
}

impl LeafMaterial {
    pub(super) const WORDS: usize = 16;

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let mut words = vec![
            self.first_vertex,
            self.texture,
            self.alpha_cutoff.to_bits(),
            0,
        ];
        words.extend(self.base_color.to_array().map(f32::to_bits));
        words.extend(
            self.texture_corners
                .iter()
                .flat_map(|c| c.to_array())
                .map(f32::to_bits),
        );
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    fn read(words: Words<'_>, group: usize) -> Self {
        let first = group * Self::WORDS;
        Self {
            first_vertex: words.u32(first),
            texture: words.u32(first + 1),
            alpha_cutoff: words.f32(first + 2),
            base_color: Vec4::from_array(words.f32s(first + 4)),
            texture_corners: [0, 1, 2, 3]
                .map(|role| Vec2::from_array(words.f32s(first + 8 + 2 * role))),
        }
    }
}

/// What the fragment stage knows of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    /// Texture slot + 1, or 0.
    pub(super) texture: u32,
    pub(super) base_color: Vec4,
    pub(super) alpha_cutoff: f32,
}

/// The fragment stage of everything that is a leaf, with what its groups look like. Texture coordinates
/// are varyings; three values are flat: the light's cosine on the front, on the back, and the bits of the
/// group's number.
pub(super) fn leaf_kernel<'a>(
    bindings: &Bindings<'a>,
    looks: impl Iterator<Item = Look>,
) -> Box<dyn Kernel + 'a> {
    let surfaces = looks.map(|look| Surface {
        texture: look
            .texture
            .checked_sub(1)
            .and_then(|slot| bindings.texture(slot as usize)),
        base_color: look.base_color,
        alpha_cutoff: look.alpha_cutoff,
    });
    Box::new(LeafFragment {
        surfaces: surfaces.collect(),
        lighting: Lighting::of(bindings),
    })
}

fn read_materials(words: Words<'_>) -> Vec<LeafMaterial> {
    (0..words.len() / LeafMaterial::WORDS)
        .map(|group| LeafMaterial::read(words, group))
        .collect()
}

/// Textured, alpha-tested, lit on the side that is seen.
#[derive(Debug)]
struct LeafFragment<'a> {
    surfaces: Vec<Surface<'a>>,
    lighting: Lighting<'a>,
}

#[derive(Debug)]
struct Surface<'a> {
    texture: Option<&'a MipMap>,
    base_color: Vec4,
    alpha_cutoff: f32,
}

impl LeafFragment<'_> {
    /// A bilinear read takes four texels; leaves without a texture share the draw's figure.
    fn texels_read(&self) -> u64 {
        if self
            .surfaces
            .iter()
            .any(|surface| surface.texture.is_some())
        {
            4
        } else {
            0
        }
    }

    #[inline(always)]
    fn surface(&self, pixel: &Pixel<'_>) -> &Surface<'_> {
        // Constant over the leaf, so the bits arrive as the vertex stage wrote them.
        &self.surfaces[pixel.flats[2].to_bits() as usize]
    }
}

impl Fragment for LeafFragment<'_> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 3;
    const TESTS_ALPHA: bool = true;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let surface = self.surface(pixel);
        let alpha = surface.texture.map_or(1.0, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            texture.alpha(coordinate(pixel), level, Wrap::Clamp)
        });
        alpha * surface.base_color.w >= surface.alpha_cutoff
    }

    #[inline(always)]
    fn keeps_lanes<S: Simd>(&self, simd: S, pixels: &PixelLanes<'_, S>, wanted: u64) -> u64 {
        let surface = &self.surfaces[pixels.flats[2].to_bits() as usize];
        let Some(texture) = surface.texture else {
            return pixels.each(wanted, |pixel| self.keeps(pixel));
        };
        let levels = texture.level_for_lanes(simd, pixels.derivative_x, pixels.derivative_y);
        let at = [pixels.varyings[0], pixels.varyings[1]];
        let reach = [surface.base_color.w, surface.alpha_cutoff];
        texture.alpha_reaches_lanes(simd, at, levels, Wrap::Clamp, wanted, reach)
    }

    fn texels_tested(&self) -> u64 {
        self.texels_read()
    }

    fn texels_shaded(&self) -> u64 {
        self.texels_read() + self.lighting.texels()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let surface = self.surface(pixel);
        let texel = surface.texture.map_or(Vec4::ONE, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            texture.sample(coordinate(pixel), level, Wrap::Clamp)
        });
        let toward = pixel.flats[usize::from(!pixel.front)];
        let light = self.lighting.at(toward, pixel);
        let color = surface.base_color.truncate() * texel.truncate() * light;
        color.extend(1.0)
    }
}

fn coordinate(pixel: &Pixel<'_>) -> Vec2 {
    Vec2::new(pixel.varyings[0], pixel.varyings[1])
}
