//! The program that draws leaves and impostors: quads of one normal, lit as the peers light them.

use spinney::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, MipMap, Pixel, Program, Topology,
    VertexCall, Words, Wrap,
};
use spinney::math::{Mat4, Vec2, Vec3, Vec4};

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
        let (vertices, tiles) = (call.bindings.vertices(), storage(TILE_SLOT));
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
        for corners in call.corners.as_chunks::<4>().0 {
            let world = corners.map(|corner| {
                place.transform_point3(Vec3::from_array(vertices.f32s(3 * corner as usize)))
            });
            let normal = (world[2] - world[0]).cross(world[3] - world[1]);
            let toward = normal.normalize_or_zero().dot(to_light);
            let first = u32::try_from(geometry.clip.len()).expect("a call has few quads");
            for (role, (corner, point)) in (0..).zip(corners.iter().zip(world)) {
                geometry.clip.push(clip_from_world * point.extend(1.0));
                geometry.vertex_ids.push(*corner);
                geometry.corners.push(first + role);
                if textured {
                    let uv = surface.corners[role as usize];
                    geometry.varyings.extend([uv.x, uv.y]);
                }
            }
            let light = [toward, -toward].map(|toward| AMBIENT + DIFFUSE * toward.max(0.0));
            geometry.flats.extend(light);
            if self.texturing == Texturing::Tiles {
                let tile = tiles.u32(corners[0] as usize / 4);
                let columns = surface.tiles.x as u32;
                let place = [tile % columns, tile / columns].map(|place| place as f32);
                geometry.flats.extend(place);
            }
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let surface = Surface::read(bindings.storage(SURFACE_SLOT as usize));
        let texture = bindings.texture(0);
        match (self.texturing, texture, self.blend) {
            (Texturing::None, ..) | (_, None, _) => Box::new(Plain(surface.color)),
            (Texturing::Whole, Some(texture), Blend::Opaque) => {
                Box::new(Textured::<false, true> { texture, surface })
            }
            (Texturing::Whole, Some(texture), Blend::Alpha) => {
                Box::new(Textured::<false, false> { texture, surface })
            }
            (Texturing::Tiles, Some(texture), Blend::Opaque) => {
                Box::new(Textured::<true, true> { texture, surface })
            }
            (Texturing::Tiles, Some(texture), Blend::Alpha) => {
                Box::new(Textured::<true, false> { texture, surface })
            }
        }
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
}

impl<const TILES: bool, const TESTED: bool> Textured<'_, TILES, TESTED> {
    /// Where in the texture a pixel lies, and the level.
    #[inline(always)]
    fn place(&self, pixel: &Pixel<'_>) -> (Vec2, u32) {
        let uv = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
        if !TILES {
            let level = (self.texture).level_for(pixel.derivative_x, pixel.derivative_y);
            return (uv, level);
        }
        let Surface {
            tiles, tile_side, ..
        } = self.surface;
        let level =
            (self.texture).level_for(pixel.derivative_x / tiles, pixel.derivative_y / tiles);
        // As if the tile were a texture of its own, clamped: no neighbour lends a texel.
        let texels = (tile_side / (1_u32 << level) as f32).max(1.0);
        let rim = Vec2::splat(0.5 / texels);
        let tile = Vec2::new(pixel.flats[2], pixel.flats[3]);
        ((tile + uv.clamp(rim, Vec2::ONE - rim)) / tiles, level)
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
}
