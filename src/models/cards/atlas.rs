//! Many baked views in two textures.
//!
//! ```text
//!  level 0          1      2        cells are powers of two wide and high and lie at multiples of
//! ┌────┬──┬──┐   ┌──┬┬┐   ┌┬┐      their sides, so that a texel of any level is of one cell: no
//! │    ├──┼──┤   │  ├┼┤   └┴┘      gutters, and nothing of a neighbour in a smaller version
//! └────┴──┴──┘   └──┴┴┘
//! ```
//!
//! Reading between texels stays within a cell by [`AtlasCell::clamped`].

use rayon::prelude::*;

use super::atlas_alpha::deal_out;
use super::bake_resolve::{BakedView, byte};
use crate::limits;
use crate::math::Vec2;
use crate::plant::Texture;

/// Views side by side: their colours and their normals, at the same places.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Atlas {
    /// Texels a row, and rows, of the largest level.
    pub(super) size: [u32; 2],
    /// Where each view lies.
    pub(super) cells: Vec<AtlasCell>,
    /// Colour as [`BakedView::colour`] has it, level by level, the largest first. Where nothing is,
    /// colours are those of what is nearest, with alpha 0.
    pub(super) colour: Vec<Vec<u8>>,
    /// Normals and depth as [`BakedView::normals`] has them, likewise.
    pub(super) normals: Vec<Vec<u8>>,
}

/// Where a view lies in an atlas, and how deep it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AtlasCell {
    /// The upper left corner, in texture coordinates.
    pub(super) least: Vec2,
    /// Width and height, in texture coordinates.
    pub(super) sides: Vec2,
    /// [`BakedView::depths`].
    pub(super) depths: [f32; 2],
}

impl AtlasCell {
    /// The coordinate in the atlas of one in the cell, kept half a texel within it.
    ///
    /// `texel` has the sides of a texel of the level that is read, in the atlas's coordinates.
    #[inline(always)]
    pub(super) fn clamped(&self, coordinate: Vec2, texel: Vec2) -> Vec2 {
        let (least, greatest) = (
            self.least + 0.5 * texel,
            self.least + self.sides - 0.5 * texel,
        );
        (self.least + coordinate * self.sides)
            .max(least)
            .min(greatest)
    }
}

impl Atlas {
    /// The atlas of views whose sides are powers of two; `None` where they do not fit a texture, or
    /// there is none.
    ///
    /// Each view has its own smaller versions down to a texel, whose alpha is [dealt out](super::atlas_alpha), so
    /// that each covers at all sizes what it covers at the largest, and where it does; there are as many
    /// levels as the smallest side of a cell allows. With a cutoff of 0 alpha stays a mean.
    pub(super) fn of(views: &[BakedView], alpha_cutoff: f32) -> Option<Self> {
        let sizes: Vec<[u32; 2]> = views.iter().map(|view| view.size).collect();
        let (size, places) = arrange(&sizes)?;
        let least_side = sizes.iter().flatten().min()?;
        let levels = 1 + least_side.ilog2();
        let chains: Vec<[Vec<Vec<u8>>; 2]> = views
            .par_iter()
            .map(|view| chain(view, alpha_cutoff))
            .collect();
        let [colour, normals] = [0, 1].map(|texture: usize| -> Vec<Vec<u8>> {
            let level = |level: u32| {
                let width = (size[0] >> level) as usize;
                let mut bytes = vec![0; 4 * width * (size[1] >> level) as usize];
                for ((chain, size), place) in chains.iter().zip(&sizes).zip(&places) {
                    let row_bytes = 4 * (size[0] >> level) as usize;
                    let [x, y] = place.map(|at| (at >> level) as usize);
                    let rows = chain[texture][level as usize].chunks_exact(row_bytes);
                    for (row, y) in rows.zip(y..) {
                        let first = 4 * (y * width + x);
                        bytes[first..first + row_bytes].copy_from_slice(row);
                    }
                }
                bytes
            };
            (0..levels).into_par_iter().map(level).collect()
        });
        let whole = Vec2::new(size[0] as f32, size[1] as f32);
        let cells = views.iter().zip(&places).map(|(view, place)| AtlasCell {
            least: Vec2::new(place[0] as f32, place[1] as f32) / whole,
            sides: Vec2::new(view.size[0] as f32, view.size[1] as f32) / whole,
            depths: view.depths,
        });
        Some(Self {
            size,
            cells: cells.collect(),
            colour,
            normals,
        })
    }

    /// Bytes of both textures with all their levels.
    pub(super) fn bytes(&self) -> u64 {
        let levels = self.colour.iter().chain(&self.normals);
        levels.map(|level| level.len() as u64).sum()
    }
}

/// The size of an atlas and the upper left corner of each view, in texels.
///
/// Views go from the highest and widest to the lowest, in rows of one height, so that each lies at
/// multiples of its sides. The narrowest power of two is taken that is no less than the atlas is high.
fn arrange(sizes: &[[u32; 2]]) -> Option<([u32; 2], Vec<[u32; 2]>)> {
    let powers = sizes.iter().flatten().all(|side| side.is_power_of_two());
    let widest = sizes.iter().map(|size| size[0]).max()?;
    if !powers {
        return None;
    }
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&view| (std::cmp::Reverse([sizes[view][1], sizes[view][0]]), view));
    let mut width = widest;
    while width <= limits::TEXTURE_SIDE {
        let mut places = vec![[0, 0]; sizes.len()];
        let (mut x, mut y, mut row) = (0, 0_u32, 0);
        for &view in &order {
            let [wide, high] = sizes[view];
            if high != row || x + wide > width {
                (x, y, row) = (0, y.saturating_add(row), high);
            }
            places[view] = [x, y];
            x += wide;
        }
        let height = y.saturating_add(row);
        if height <= width || (width == limits::TEXTURE_SIDE && height <= limits::TEXTURE_SIDE) {
            return Some(([width, height], places));
        }
        width *= 2;
    }
    None
}

/// All smaller versions of a view: of its colour, and of its normals.
fn chain(view: &BakedView, alpha_cutoff: f32) -> [Vec<Vec<u8>>; 2] {
    let [width, height] = view.size;
    let texture = Texture::new(width, height, view.colour.clone());
    let mut colour = texture.map_or_else(Vec::new, |texture| texture.mips(0.0));
    let mut level = Weighted::of(view);
    let mut normals = vec![view.normals.clone()];
    let mut weights = vec![level.weights()];
    while level.size != [1, 1] {
        level = level.halved();
        normals.push(level.bytes());
        weights.push(level.weights());
    }
    spread(
        &mut colour,
        view.size,
        |bytes, texel, _| bytes[4 * texel + 3] > 0,
        3,
    );
    deal_out(&mut colour, view.size, alpha_cutoff);
    spread(
        &mut normals,
        view.size,
        |_, texel, level| weights[level][texel],
        4,
    );
    [colour, normals]
}

/// Gives texels of which nothing is known the first `channels` bytes of the texel above them, the next
/// smaller version's, from the smallest version to the largest.
fn spread(
    levels: &mut [Vec<u8>],
    size: [u32; 2],
    is_known: impl Fn(&[u8], usize, usize) -> bool,
    channels: usize,
) {
    for level in (0..levels.len().saturating_sub(1)).rev() {
        let [width, height] = size.map(|side| (side >> level).max(1) as usize);
        let above_width = (size[0] >> (level + 1)).max(1) as usize;
        let above_height = (size[1] >> (level + 1)).max(1) as usize;
        let (below, above) = levels.split_at_mut(level + 1);
        let (Some(bytes), Some(above)) = (below.last_mut(), above.first()) else {
            continue;
        };
        for y in 0..height {
            for x in 0..width {
                let texel = y * width + x;
                if !is_known(bytes, texel, level) {
                    let from =
                        (y / 2).min(above_height - 1) * above_width + (x / 2).min(above_width - 1);
                    bytes[4 * texel..4 * texel + channels]
                        .copy_from_slice(&above[4 * from..4 * from + channels]);
                }
            }
        }
    }
}

/// Normals and depth times what of a texel is there, and that.
struct Weighted {
    size: [usize; 2],
    texels: Vec<[f32; 5]>,
}

impl Weighted {
    fn of(view: &BakedView) -> Self {
        let texels = view.normals.as_chunks::<4>().0.iter();
        let texels = texels.zip(view.colour.as_chunks::<4>().0);
        Self {
            size: view.size.map(|side| side as usize),
            texels: texels
                .map(|(normal, colour)| {
                    let weight = f32::from(colour[3]);
                    let [x, y, z, depth] = normal.map(|byte| weight * f32::from(byte));
                    [x, y, z, depth, weight]
                })
                .collect(),
        }
    }

    /// Half the size; a side of one texel stays.
    fn halved(&self) -> Self {
        let size = self.size.map(|side| (side / 2).max(1));
        let step = [0, 1].map(|axis| self.size[axis] / size[axis] - 1);
        let mut texels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            let rows = [y * (1 + step[1]), y * (1 + step[1]) + step[1]];
            for x in 0..size[0] {
                let columns = [x * (1 + step[0]), x * (1 + step[0]) + step[0]];
                let at = |row: usize, column: usize| &self.texels[row * self.size[0] + column];
                let four = [
                    at(rows[0], columns[0]),
                    at(rows[0], columns[1]),
                    at(rows[1], columns[0]),
                    at(rows[1], columns[1]),
                ];
                texels.push(std::array::from_fn(|channel| {
                    let [a, b, c, d] = four.map(|texel| texel[channel]);
                    0.25 * ((a + b) + (c + d))
                }));
            }
        }
        Self { size, texels }
    }

    fn bytes(&self) -> Vec<u8> {
        let texel = |&[x, y, z, depth, weight]: &[f32; 5]| {
            let share = if weight > 0.0 { 1.0 / weight } else { 0.0 };
            [x, y, z, depth].map(|sum| byte(sum * share))
        };
        self.texels.iter().flat_map(texel).collect()
    }

    /// Whether anything of each texel is there.
    fn weights(&self) -> Vec<bool> {
        self.texels.iter().map(|texel| texel[4] > 0.0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_lie_at_multiples_of_their_sides() {
        let sizes = [[4, 2], [8, 8], [2, 2], [4, 8], [8, 4], [2, 1]];
        let (size, places) = arrange(&sizes).expect("they fit");
        assert_eq!(size, [16, 15]);
        let mut taken = vec![false; (size[0] * size[1]) as usize];
        for (place, side) in places.iter().zip(&sizes) {
            assert!((0..2).all(|axis| place[axis].is_multiple_of(side[axis])));
            for y in place[1]..place[1] + side[1] {
                for x in place[0]..place[0] + side[0] {
                    let texel = &mut taken[(y * size[0] + x) as usize];
                    assert!(!std::mem::replace(texel, true), "{place:?} overlaps");
                }
            }
        }
        assert_eq!(
            arrange(&[[512, 512]; 64]).expect("they fit").0,
            [4096, 4096]
        );
        assert_eq!(
            arrange(&[[512, 512]; 256]).expect("they fit").0,
            [8192, 8192]
        );
        assert!(arrange(&[[512, 512]; 257]).is_none());
        assert!(arrange(&[[3, 4]]).is_none() && arrange(&[]).is_none());
    }

    /// 4 × 4 texels, of which the two on the left of the second row are there:
    /// facing +X, white, near, half there; and facing +Y, black, far.
    fn view() -> BakedView {
        let (mut colour, mut normals) = (vec![0; 64], vec![0; 64]);
        colour[16..24].copy_from_slice(&[255, 255, 255, 128, 0, 0, 0, 255]);
        normals[16..24].copy_from_slice(&[255, 128, 128, 255, 128, 255, 128, 0]);
        BakedView {
            size: [4, 4],
            depths: [0.0, 1.0],
            colour,
            normals,
        }
    }

    #[test]
    fn smaller_versions_weigh_by_what_is_there_and_colours_spread() {
        let atlas = Atlas::of(&[view(), view()], 0.0).expect("two fit");
        assert_eq!((atlas.size, atlas.colour.len()), ([8, 4], 3));
        assert_eq!(atlas.bytes(), 2 * 4 * (32 + 8 + 2));
        let texel = |levels: &[Vec<u8>], level: usize, x: usize, y: usize| {
            let at = 4 * (y * (8 >> level) + x);
            <[u8; 4]>::try_from(&levels[level][at..at + 4]).expect("four bytes")
        };
        // A third white, two thirds black: linear 0.335.
        let mean = texel(&atlas.colour, 1, 0, 0);
        assert_eq!((mean[0], mean[3]), (156, 96));
        assert_eq!(texel(&atlas.normals, 1, 0, 0), [170, 213, 128, 85]);
        for cell in [0, 1] {
            let left = 4 * cell;
            assert_eq!(texel(&atlas.colour, 0, left, 1), [255, 255, 255, 128]);
            // Beside it in the same square of the next version, and far off.
            for (x, y) in [(left + 1, 0), (left + 3, 3)] {
                let spread = texel(&atlas.colour, 0, x, y);
                assert_eq!((spread[0], spread[3]), (156, 0));
                assert_eq!(texel(&atlas.normals, 0, x, y), [170, 213, 128, 85]);
            }
        }
    }

    #[test]
    fn reading_stays_within_a_cell() {
        let atlas = Atlas::of(&[view(), view()], 0.0).expect("two fit");
        let texel = Vec2::new(1.0 / 8.0, 1.0 / 4.0);
        let clamped = |x: f32, y: f32| atlas.cells[1].clamped(Vec2::new(x, y), texel);
        assert_eq!(clamped(0.5, 0.5), Vec2::new(0.75, 0.5));
        assert_eq!(clamped(0.0, 1.0), Vec2::new(0.5625, 0.875));
        assert_eq!(clamped(1.0, 0.0), Vec2::new(0.9375, 0.125));
    }
}
