//! The program that draws leaves and impostors: quads of one normal, lit as the peers light them.

use fearless_simd::{Simd, SimdBase, dispatch, f32x8, u32x8};
use spinney::gpu::{
    Bindings, Blend, Fragment, Geometry, Hulls, Kernel, Layout, MipMap, Pixel, PixelLanes, Program,
    Topology, Transform, VertexCall, Words, Wrap,
};
use spinney::math::lanes::{LANES, Vec3Lanes};
use spinney::math::{Mat4, Vec2, Vec3, Vec4};

use crate::hulls;
use crate::light::{AMBIENT, DIFFUSE, towards_light};

/// The slot of the matrix from the world to clip space, 16 × `f32`, columns first.
pub(crate) const VIEW_SLOT: u32 = 0;
/// The slot of the matrices of the instances, 16 × `f32` each, columns first.
pub(crate) const INSTANCE_SLOT: u32 = 1;
/// The slot of the [`Surface`].
pub(crate) const SURFACE_SLOT: u32 = 2;
/// The slot of the tile of each quad, a `u32`; only for [`Texturing::Tiles`].
const TILE_SLOT: u32 = 3;

/// Draws quads: four vertices of 12 bytes each, whose texture coordinates follow from their role.
///
/// A quad's normal is the cross product of its diagonals, so vertices need none, and its light is
/// computed once: what the peers compute at every pixel from four equal normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LeafQuads {
    pub(crate) texturing: Texturing,
    pub(crate) blend: Blend,
}

/// Where a quad's texels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Texturing {
    /// It has none, and alpha is not tested.
    None,
    /// In the texture of slot 0, clamped.
    Whole,
    /// In one of the tiles of the texture of slot 0, clamped.
    Tiles,
}

/// What all quads of a batch share.
///
/// | words | field | |
/// |------:|---|---|
/// | 0–3   | `color` | multiplies texels |
/// | 4     | `cutoff` | the least alpha that passes |
/// | 5–6   | `tiles` | columns and rows of tiles |
/// | 7     | `tile_side` | texels a side of a tile |
/// | 8–15  | `corners` | texture coordinates by role |
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Surface {
    pub(crate) color: Vec4,
    pub(crate) cutoff: f32,
    pub(crate) tiles: Vec2,
    pub(crate) tile_side: f32,
    pub(crate) corners: [Vec2; 4],
}

impl Surface {
    pub(crate) fn words(&self) -> Vec<f32> {
        let mut words = self.color.to_array().to_vec();
        words.extend([self.cutoff, self.tiles.x, self.tiles.y, self.tile_side]);
        words.extend(self.corners.iter().flat_map(|corner| corner.to_array()));
        words
    }

    fn read(words: Words<'_>) -> Self {
        let [cutoff, columns, rows, tile_side] = words.f32s(4);
        Self {
            color: Vec4::from_array(words.f32s(0)),
            cutoff,
            tiles: Vec2::new(columns, rows),
            tile_side,
            corners: [8, 10, 12, 14].map(|word| Vec2::from_array(words.f32s(word))),
        }
    }
}

impl Program for LeafQuads {
    fn layout(&self) -> Layout {
        Layout {
            name: match self.texturing {
                Texturing::None => "peer-quads",
                Texturing::Whole => "peer-textured-quads",
                Texturing::Tiles => "peer-tiled-quads",
            },
            version: 1,
            topology: Topology::QuadList,
            blend: self.blend,
            vertex_stride: 12,
            pulled_primitive_bytes: 0,
            pulled_vertex_bytes: 0,
            storage_slots: if self.texturing == Texturing::Tiles {
                4
            } else {
                3
            },
            texture_slots: u32::from(self.texturing != Texturing::None),
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let clip_from_world = Mat4::from_cols_array(&storage(VIEW_SLOT).f32s(0));
        let placements = storage(INSTANCE_SLOT);
        let place = Mat4::from_cols_array(&placements.f32s(16 * call.instance as usize));
        let surface = Surface::read(storage(SURFACE_SLOT));
        let (vertices, tiles) = (call.vertices, storage(TILE_SLOT));
        let to_light = towards_light();
        let quads = call.corners.len() / 4;
        let textured = self.texturing != Texturing::None;
        let flats = if self.texturing == Texturing::Tiles {
            4
        } else {
            2
        };
        geometry.clip.reserve(4 * quads);
        geometry.vertex_ids.reserve(4 * quads);
        geometry.corners.reserve(4 * quads);
        geometry.flats.reserve(flats * quads);
        if textured {
            geometry.varyings.reserve(8 * quads);
        }
        let stage = Stage {
            program: *self,
            place,
            clip_from_world,
            to_light,
            surface,
            vertices,
            tiles,
        };
        dispatch!(call.instructions.level(), simd => {
            let places = call.places.as_chunks::<4>().0.chunks(LANES);
            for (quads, places) in call.corners.as_chunks::<4>().0.chunks(LANES).zip(places) {
                stage.emit(simd, quads, places, geometry);
            }
        });
    }

    fn hulls(&self) -> Option<&dyn Hulls> {
        Some(self)
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let surface = Surface::read(bindings.storage(SURFACE_SLOT as usize));
        let texture = bindings.texture(0);
        match (self.texturing, texture, self.blend) {
            (Texturing::None, ..) | (_, None, _) => Box::new(Plain(surface.color)),
            (Texturing::Whole, Some(texture), Blend::Opaque) => {
                Box::new(Textured::<false, true>::new(texture, surface))
            }
            (Texturing::Whole, Some(texture), _) => {
                Box::new(Textured::<false, false>::new(texture, surface))
            }
            (Texturing::Tiles, Some(texture), Blend::Opaque) => {
                Box::new(Textured::<true, true>::new(texture, surface))
            }
            (Texturing::Tiles, Some(texture), _) => {
                Box::new(Textured::<true, false>::new(texture, surface))
            }
        }
    }
}

/// What the vertex stage knows before it sees a quad.
struct Stage<'a> {
    program: LeafQuads,
    place: Mat4,
    clip_from_world: Mat4,
    to_light: Vec3,
    surface: Surface,
    vertices: Words<'a>,
    tiles: Words<'a>,
}

impl Stage<'_> {
    /// Emits up to [`LANES`] quads.
    #[inline(always)]
    fn emit<S: Simd>(
        &self,
        simd: S,
        quads: &[[u32; 4]],
        places: &[[u32; 4]],
        geometry: &mut Geometry,
    ) {
        let texturing = self.program.texturing;
        let mut world = [Vec3Lanes::splat(simd, Vec3::ZERO); 4];
        let mut clip = [[[0.0_f32; LANES]; 4]; 4];
        let mut at = [[[0.0_f32; LANES]; 3]; 4];
        for (lane, places) in places.iter().enumerate().take(LANES) {
            let first = places[0];
            if *places == [first, first + 1, first + 2, first + 3] {
                let all = self.vertices.f32s::<12>(3 * first as usize);
                for role in 0..4 {
                    at[role][0][lane] = all[3 * role];
                    at[role][1][lane] = all[3 * role + 1];
                    at[role][2][lane] = all[3 * role + 2];
                }
                continue;
            }
            for role in 0..4 {
                let [x, y, z] = self.vertices.f32s(3 * places[role] as usize);
                at[role][0][lane] = x;
                at[role][1][lane] = y;
                at[role][2][lane] = z;
            }
        }
        for role in 0..4 {
            world[role] = Vec3Lanes::new(simd, &at[role]).transformed(simd, &self.place);
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
        let count = geometry.clip.len();
        let first = u32::try_from(count).expect("a call has few quads");
        let more = 4 * quads.len().min(LANES);
        geometry.clip.resize(count + more, Vec4::ZERO);
        let quads_out = geometry.clip[count..].as_chunks_mut::<4>().0;
        for (lane, quad) in quads_out.iter_mut().enumerate().take(LANES) {
            for role in 0..4 {
                let [x, y, z, w] = &clip[role];
                quad[role] = Vec4::new(x[lane], y[lane], z[lane], w[lane]);
            }
        }
        geometry.vertex_ids.extend_from_slice(quads.as_flattened());
        geometry.corners.extend(first..first + more as u32);
        for (lane, corners) in quads.iter().enumerate().take(LANES) {
            if texturing != Texturing::None {
                let [a, b, c, d] = self.surface.corners;
                geometry
                    .varyings
                    .extend_from_slice(&[a.x, a.y, b.x, b.y, c.x, c.y, d.x, d.y]);
            }
            let light = [toward[lane], -toward[lane]];
            let light = light.map(|toward| AMBIENT + DIFFUSE * toward.max(0.0));
            geometry.flats.extend(light);
            if texturing == Texturing::Tiles {
                let tile = self.tiles.u32(corners[0] as usize / 4);
                let columns = self.surface.tiles.x as u32;
                let place = [tile % columns, tile / columns].map(|place| place as f32);
                geometry.flats.extend(place);
            }
        }
    }
}

impl Hulls for LeafQuads {
    fn slots(&self) -> Vec<u32> {
        Vec::new()
    }

    fn bounds(&self, corners: &[u32], bindings: &Bindings<'_>) -> [Vec3; 2] {
        hulls::bounds(corners, bindings.vertices(), 3)
    }

    fn transform(&self, bindings: &Bindings<'_>, instance: u32) -> Transform {
        hulls::transform(bindings, instance)
    }
}

/// One colour.
#[derive(Debug)]
struct Plain(Vec4);

impl Fragment for Plain {
    const VARYINGS: usize = 0;
    const FLATS: usize = 2;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _pixel: &Pixel<'_>) -> bool {
        true
    }

    #[inline]
    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let light = pixel.flats[usize::from(!pixel.front)];
        (self.0.truncate() * light).extend(1.0)
    }
}

/// Texels, of a tile or of the whole texture, and alpha tested or handed on to be blended.
#[derive(Debug)]
struct Textured<'a, const TILES: bool, const TESTED: bool> {
    texture: &'a MipMap,
    surface: Surface,
    /// The share of the texture that a tile has, across and down: powers of 2.
    share: Vec2,
    /// Half a texel of each level, as a share of a tile.
    rims: [f32; LEVELS],
}

/// The most levels of a texture, and one more.
const LEVELS: usize = 16;

impl<'a, const TILES: bool, const TESTED: bool> Textured<'a, TILES, TESTED> {
    fn new(texture: &'a MipMap, surface: Surface) -> Self {
        let texels = |level: usize| (surface.tile_side / (1_u32 << level) as f32).max(1.0);
        Self {
            texture,
            share: 1.0 / surface.tiles,
            rims: std::array::from_fn(|level| 0.5 / texels(level)),
            surface,
        }
    }

    /// Where in the texture a pixel lies, and the level.
    #[inline(always)]
    fn place(&self, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let uv = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        if !TILES {
            let level = (self.texture).level_for(pixel.derivative_x, pixel.derivative_y);
            return (uv, level);
        }
        let share = self.share;
        let level =
            (self.texture).level_for(pixel.derivative_x * share, pixel.derivative_y * share);
        // As if the tile were a texture of its own, clamped: no neighbour lends a texel.
        let rim = Vec2::splat(self.rims[level as usize % LEVELS]);
        let tile = Vec2::new(pixel.flats[2], pixel.flats[3]);
        ((tile + uv.clamp(rim, Vec2::ONE - rim)) * share, level)
    }

    /// [`place`](Self::place) of eight pixels.
    #[inline(always)]
    fn place_lanes<S: Simd>(
        &self,
        simd: S,
        pixels: &PixelLanes<'_, S>,
        wanted: u64,
    ) -> ([f32x8<S>; 2], u32x8<S>) {
        let number = |value: f32| f32x8::splat(simd, value);
        let (across, down) = (pixels.derivative_x, pixels.derivative_y);
        let [u, v] = [pixels.varyings[0], pixels.varyings[1]];
        if !TILES {
            return ([u, v], self.texture.level_for_lanes(simd, across, down));
        }
        let [column, row] = [number(self.share.x), number(self.share.y)];
        let across = [across[0] * column, across[1] * row];
        let down = [down[0] * column, down[1] * row];
        let levels = self.texture.level_for_lanes(simd, across, down);
        let rim = if let Some(level) = MipMap::one_level(simd, levels, wanted) {
            number(self.rims[level as usize % LEVELS])
        } else {
            let mut rims = [0.0; 8];
            for (lane, rim) in rims.iter_mut().enumerate() {
                *rim = self.rims[levels[lane] as usize % LEVELS];
            }
            f32x8::from_slice(simd, &rims)
        };
        let last = number(1.0) - rim;
        let at = [
            (number(pixels.flats[2]) + u.max(rim).min(last)) * column,
            (number(pixels.flats[3]) + v.max(rim).min(last)) * row,
        ];
        (at, levels)
    }
}

impl<const TILES: bool, const TESTED: bool> Fragment for Textured<'_, TILES, TESTED> {
    const VARYINGS: usize = 2;
    const FLATS: usize = if TILES { 4 } else { 2 };
    const TESTS_ALPHA: bool = TESTED;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        if !TESTED {
            return true;
        }
        let (uv, level) = self.place(pixel);
        let alpha = self.texture.alpha(uv, level, Wrap::Clamp);
        alpha * self.surface.color.w >= self.surface.cutoff
    }

    #[inline(always)]
    fn keeps_lanes<S: Simd>(&self, simd: S, pixels: &PixelLanes<'_, S>, wanted: u64) -> u64 {
        if !TESTED {
            return wanted;
        }
        let (at, levels) = self.place_lanes(simd, pixels, wanted);
        let reach = [self.surface.color.w, self.surface.cutoff];
        (self.texture).alpha_reaches_lanes(simd, at, levels, Wrap::Clamp, wanted, reach)
    }

    fn texels_tested(&self) -> u64 {
        if TESTED { 4 } else { 0 }
    }

    fn texels_shaded(&self) -> u64 {
        4
    }

    #[inline]
    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let (uv, level) = self.place(pixel);
        let color = self.surface.color * self.texture.sample(uv, level, Wrap::Clamp);
        let light = pixel.flats[usize::from(!pixel.front)];
        (color.truncate() * light).extend(if TESTED { 1.0 } else { color.w })
    }

    const SHADES_LANES: bool = true;

    #[inline(always)]
    fn shade_lanes<S: Simd>(
        &self,
        simd: S,
        pixels: &PixelLanes<'_, S>,
        wanted: u64,
    ) -> [f32x8<S>; 4] {
        let (at, levels) = self.place_lanes(simd, pixels, wanted);
        let texel = (self.texture).sample_lanes(simd, at, levels, Wrap::Clamp, wanted);
        let light = f32x8::splat(simd, pixels.flats[usize::from(!pixels.front)]);
        let color = self.surface.color;
        let number = |value: f32| f32x8::splat(simd, value);
        let alpha = if TESTED {
            number(1.0)
        } else {
            number(color.w) * texel[3]
        };
        [
            number(color.x) * texel[0] * light,
            number(color.y) * texel[1] * light,
            number(color.z) * texel[2] * light,
            alpha,
        ]
    }
}
