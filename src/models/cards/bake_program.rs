//! The program that bakes: leaves seen in parallel, and of each pixel what it takes to light it later.
//!
//! A pixel holds four floats, each a whole number of at most 24 bits or a depth, so that one pass is all:
//!
//! | channel | holds |
//! |---|---|
//! | red   | albedo: square root of linear red and green, 12 bits each, red above |
//! | green | the same of blue, 12 bits |
//! | blue  | depth from 0 (nearest to the viewer of the bake) to 1 |
//! | alpha | 1 + the normal on the side that is seen, 8 bits a coordinate, x above; 0 where nothing is |
//!
//! Square roots of 12 bits are at least eighteen times as fine as sRGB of 8 bits.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};

use crate::gpu::{
    Bindings, Blend, Fragment, Geometry, Kernel, Layout, MipMap, Pixel, PixelLanes, Program,
    Topology, VertexCall, Words, Wrap,
};
use crate::math::{Mat4, Vec2, Vec3, Vec4, index_u32};

/// The program that bakes.
///
/// Vertices are three a triangle, in order, never shared: position (3 × `f32`) and texture coordinate
/// (2 × `f32`), [`VERTEX_BYTES`](Self::VERTEX_BYTES) each.
#[derive(Debug, Clone, Copy)]
pub(super) struct BakeProgram;

/// The slot of the views: [`SheetView`]s, by instance.
pub(super) const SHEET_VIEW_SLOT: u32 = 0;
/// The slot of the material: a [`BakeMaterial`].
pub(super) const BAKE_MATERIAL_SLOT: u32 = 1;
/// The slot of the normals of triangles, 3 × `f32` each.
pub(super) const NORMAL_SLOT: u32 = 2;

impl BakeProgram {
    /// Bytes of a vertex.
    pub(super) const VERTEX_BYTES: u32 = 20;
}

/// A view on a sheet of many.
///
/// | words | field             | type |
/// |------:|-------------------|------|
/// | 0–15  | `clip_from_plant` | 16 × `f32`, columns first |
/// | 16–18 | `toward`          | 3 × `f32`, unit vector towards the viewer |
/// | 19–22 | `pixels`          | 4 × `f32`: first column and row, and one past the last |
///
/// Little-endian, 92 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SheetView {
    pub(super) clip_from_plant: Mat4,
    pub(super) toward: Vec3,
    pub(super) pixels: [f32; 4],
}

impl SheetView {
    const WORDS: usize = 23;

    pub(super) fn to_bytes(self) -> Vec<u8> {
        let floats = self.clip_from_plant.to_cols_array().into_iter();
        let floats = floats.chain(self.toward.to_array()).chain(self.pixels);
        floats.flat_map(f32::to_le_bytes).collect()
    }

    fn read(words: Words<'_>, number: u32) -> Self {
        let first = Self::WORDS * number as usize;
        Self {
            clip_from_plant: Mat4::from_cols_array(&words.f32s(first)),
            toward: Vec3::from_array(words.f32s(first + 16)),
            pixels: words.f32s(first + 19),
        }
    }
}

/// What leaves of a group look like: `base_color` (4 × `f32`, linear), `alpha_cutoff` (`f32`), 20 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BakeMaterial {
    pub(super) base_color: Vec4,
    pub(super) alpha_cutoff: f32,
}

impl BakeMaterial {
    pub(super) fn to_bytes(self) -> Vec<u8> {
        let floats = self.base_color.to_array().into_iter();
        let floats = floats.chain([self.alpha_cutoff]);
        floats.flat_map(f32::to_le_bytes).collect()
    }

    fn read(words: Words<'_>) -> Self {
        let [red, green, blue, alpha, alpha_cutoff] = words.f32s(0);
        Self {
            base_color: Vec4::new(red, green, blue, alpha),
            alpha_cutoff,
        }
    }
}

impl Program for BakeProgram {
    fn layout(&self) -> Layout {
        Layout {
            name: "bake",
            version: 1,
            topology: Topology::TriangleList,
            blend: Blend::Opaque,
            vertex_stride: Self::VERTEX_BYTES,
            pulled_primitive_bytes: 12,
            pulled_vertex_bytes: 0,
            storage_slots: 3,
            texture_slots: 0,
        }
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        let storage = |slot: u32| call.bindings.storage(slot as usize);
        let view = SheetView::read(storage(SHEET_VIEW_SLOT), call.instance);
        let (normals, vertices) = (storage(NORMAL_SLOT), call.bindings.vertices());
        for corners in call.corners.as_chunks::<3>().0 {
            let normal = Vec3::from_array(normals.f32s(corners[0] as usize / 3 * 3));
            let seen = if normal.dot(view.toward) < 0.0 {
                -normal
            } else {
                normal
            };
            let first = index_u32(geometry.clip.len());
            for &corner in corners {
                let [x, y, z, u, v] = vertices.f32s(5 * corner as usize);
                let point = Vec4::new(x, y, z, 1.0);
                geometry.clip.push(view.clip_from_plant * point);
                geometry.varyings.extend([u, v]);
            }
            geometry.vertex_ids.extend(corners);
            geometry.corners.extend([first, first + 1, first + 2]);
            geometry.flats.push(packed(seen));
            geometry.flats.extend(view.pixels);
        }
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        let words = bindings.storage(BAKE_MATERIAL_SLOT as usize);
        Box::new(BakeFragment {
            texture: bindings.texture(0),
            material: BakeMaterial::read(words),
        })
    }
}

/// A unit vector as 1 + a whole number of 24 bits: exact as `f32`, and never 0.
fn packed(normal: Vec3) -> f32 {
    let [x, y, z] = normal.to_array().map(|at| whole(at * 127.5 + 127.5, 255));
    (1 + (x << 16 | y << 8 | z)) as f32
}

/// What [`packed`] packed, a byte a coordinate: `n = byte / 127.5 − 1`.
pub(super) fn unpacked_normal(packed: f32) -> [u32; 3] {
    let bits = cut(packed - 1.0);
    [bits >> 16, bits >> 8 & 0xff, bits & 0xff]
}

/// The square root of a linear value in 4095ths, so that sorting and averaging need no table.
fn root(linear: f32) -> u32 {
    whole(linear.clamp(0.0, 1.0).sqrt() * ROOTS, 4095)
}

const ROOTS: f32 = 4095.0;

/// The linear albedo that a pixel holds.
pub(super) fn unpacked_albedo(pixel: Vec4) -> [f32; 3] {
    let (red_green, blue) = (cut(pixel.x), cut(pixel.y));
    [red_green >> 12, red_green & 4095, blue].map(|root| {
        let root = root as f32 / ROOTS;
        root * root
    })
}

/// The nearest whole number, at most `most`, of a value that is small enough to have halves.
fn whole(value: f32, most: u32) -> u32 {
    cut(value + 0.5).min(most)
}

/// The whole part, 0 for less and for no number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversion saturates"
)]
fn cut(value: f32) -> u32 {
    value as u32
}

/// Writes what is seen of a leaf, within the view's pixels.
#[derive(Debug)]
struct BakeFragment<'a> {
    texture: Option<&'a MipMap>,
    material: BakeMaterial,
}

impl BakeFragment<'_> {
    fn texels_read(&self) -> u64 {
        // A bilinear read takes four.
        if self.texture.is_some() { 4 } else { 0 }
    }
}

/// Whether a pixel is one of the view's: a view may cut through leaves, and others lie beside it.
#[inline(always)]
fn inside([x, y]: [u32; 2], flats: &[f32]) -> bool {
    let (x, y) = (x as f32, y as f32);
    x >= flats[1] && y >= flats[2] && x < flats[3] && y < flats[4]
}

impl Fragment for BakeFragment<'_> {
    const VARYINGS: usize = 2;
    const FLATS: usize = 5;
    const TESTS_ALPHA: bool = true;

    #[inline(always)]
    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let alpha = self.texture.map_or(1.0, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            let at = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
            texture.alpha(at, level, Wrap::Clamp)
        });
        alpha * self.material.base_color.w >= self.material.alpha_cutoff
            && inside(pixel.position, pixel.flats)
    }

    #[inline(always)]
    fn keeps_lanes<S: Simd>(&self, simd: S, pixels: &PixelLanes<'_, S>, wanted: u64) -> u64 {
        let Some(texture) = self.texture else {
            return pixels.each(wanted, |pixel| self.keeps(pixel));
        };
        let mut within = 0;
        for (lane, position) in pixels.positions.iter().enumerate() {
            within |= u64::from(inside(*position, pixels.flats)) << lane;
        }
        let levels = texture.level_for_lanes(simd, pixels.derivative_x, pixels.derivative_y);
        let at = [pixels.varyings[0], pixels.varyings[1]];
        let alpha = texture.alpha_lanes(simd, at, levels, Wrap::Clamp, wanted);
        let alpha = alpha * f32x8::splat(simd, self.material.base_color.w);
        let cutoff = f32x8::splat(simd, self.material.alpha_cutoff);
        alpha.simd_ge(cutoff).to_bitmask() & within
    }

    fn texels_tested(&self) -> u64 {
        self.texels_read()
    }

    fn texels_shaded(&self) -> u64 {
        self.texels_read()
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let texel = self.texture.map_or(Vec4::ONE, |texture| {
            let level = texture.level_for(pixel.derivative_x, pixel.derivative_y);
            let at = Vec2::new(pixel.varyings[0], pixel.varyings[1]);
            texture.sample(at, level, Wrap::Clamp)
        });
        let albedo = self.material.base_color.truncate() * texel.truncate();
        let [red, green, blue] = albedo.to_array().map(root);
        Vec4::new(
            (red << 12 | green) as f32,
            blue as f32,
            pixel.depth,
            pixel.flats[0],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_unpacked() {
        for normal in [Vec3::X, Vec3::NEG_Z, Vec3::new(0.6, -0.8, 0.0), -Vec3::ONE] {
            let bytes = unpacked_normal(packed(normal));
            for (byte, wanted) in bytes.into_iter().zip(normal.to_array()) {
                assert!((byte as f32 / 127.5 - 1.0 - wanted).abs() <= 0.5 / 127.5 + 1e-6);
            }
        }
        assert_eq!(packed(-Vec3::ONE), 1.0, "nothing is 0, a normal never");
        assert_eq!(packed(Vec3::ONE), 16_777_216.0);
        for channel in [0.0, 0.003, 0.2, 0.5, 1.0] {
            let code = root(channel);
            let pixel = Vec4::new((code << 12 | 4095) as f32, code as f32, 0.0, 1.0);
            let [red, green, blue] = unpacked_albedo(pixel);
            assert!((red - channel).abs() <= channel.sqrt() / ROOTS + 1e-7);
            assert_eq!((green, blue), (1.0, red));
        }
    }
}
