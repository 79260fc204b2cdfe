//! The target: what every sample holds, and the picture it becomes.

use rayon::prelude::*;

use super::colour::{Encoder, unit_byte};
use super::{Key, Samples};
use crate::math::{Digest, Digester, Vec4, index_u32};

/// Colour, depth and what shows, for every sample.
///
/// Stored in blocks of 64 × 64 pixels, so that threads own what they write, and so that clearing
/// costs nothing until a block is drawn into.
#[derive(Debug, Clone)]
pub struct Target {
    width: u32,
    height: u32,
    samples: Samples,
    /// What samples of fresh blocks hold.
    clear_colour: Vec4,
    holds: Holds,
    clear_depth: u32,
    columns: usize,
    pub(super) blocks: Vec<Block>,
}

/// What a sample holds beside its depth and what shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Holds {
    Colour,
    Nothing,
}

/// Pixels a side of the blocks in which a target is stored.
pub(super) const BLOCK_SIDE: u32 = 64;

/// 64 × 64 pixels, rows from the top, the samples of a pixel together. Empty until first drawn into.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    /// Drawn into since the target was cleared; otherwise all samples are as cleared.
    used: bool,
    pub(super) depth: Vec<u32>,
    pub(super) colour: Vec<Vec4>,
    /// One more than the place of a key in `keys`, or [`NOTHING`].
    pub(super) shown: Vec<u32>,
    pub(super) keys: Vec<Key>,
}

/// What shows where nothing was drawn.
pub(super) const NOTHING: u32 = 0;

impl Target {
    /// The largest width or height in pixels.
    pub const MAX_SIDE: u32 = 16384;

    /// A target cleared to transparent black at depth 1.
    ///
    /// # Panics
    ///
    /// When a side is above [`Target::MAX_SIDE`]; sides are checked where they enter.
    #[must_use]
    pub fn new(width: u32, height: u32, samples: Samples) -> Self {
        Self::holding(Holds::Colour, width, height, samples)
    }

    /// The same without colour: nothing is shaded, and blended batches leave no trace. All of it is of
    /// the colour that it was cleared to.
    ///
    /// # Panics
    ///
    /// As [`new`](Self::new).
    #[must_use]
    pub fn of_depth(width: u32, height: u32, samples: Samples) -> Self {
        Self::holding(Holds::Nothing, width, height, samples)
    }

    fn holding(holds: Holds, width: u32, height: u32, samples: Samples) -> Self {
        assert!(
            width.max(height) <= Self::MAX_SIDE,
            "a target of {width} × {height} pixels passed the border, the most is {}",
            Self::MAX_SIDE
        );
        let blocks = |side: u32| side.div_ceil(BLOCK_SIDE) as usize;
        Self {
            width,
            height,
            samples,
            clear_colour: Vec4::ZERO,
            holds,
            clear_depth: 1.0_f32.to_bits(),
            columns: blocks(width),
            blocks: vec![Block::default(); blocks(width) * blocks(height)],
        }
    }

    /// Columns of pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Samples a pixel.
    #[must_use]
    pub fn samples(&self) -> Samples {
        self.samples
    }

    /// Whether samples have a colour.
    #[must_use]
    pub fn has_colour(&self) -> bool {
        self.holds == Holds::Colour
    }

    /// Gives all samples a linear colour and a depth within [0, 1], and lets nothing show.
    pub fn clear(&mut self, colour: Vec4, depth: f32) {
        self.clear_colour = colour;
        self.clear_depth = super::view::clamp_depth(depth).to_bits();
        for block in &mut self.blocks {
            block.used = false;
        }
    }

    /// What shows at the first sample of a pixel; `None` where nothing was drawn since the target
    /// was cleared, or where there is no pixel. Blended fragments show through.
    #[must_use]
    pub fn key(&self, x: u32, y: u32) -> Option<Key> {
        let (block, index) = self.place(x, y)?;
        let shown = block.shown[index * self.samples.count()];
        (shown != NOTHING).then(|| block.keys[shown as usize - 1])
    }

    /// How many pixels show something of a group, by their first sample.
    #[must_use]
    pub fn pixels_showing(&self, group: u32) -> u32 {
        let shows = |&(x, y): &(u32, u32)| self.key(x, y).is_some_and(|key| key.group == group);
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        index_u32(pixels.filter(shows).count())
    }

    /// The depth of the first sample of a pixel, from 0 (near) to 1 (far); the depth it was cleared
    /// to where there is no pixel.
    #[must_use]
    pub fn depth(&self, x: u32, y: u32) -> f32 {
        let depth = self.place(x, y).map_or(self.clear_depth, |(block, index)| {
            block.depth[index * self.samples.count()]
        });
        f32::from_bits(depth)
    }

    /// The greatest depth of the samples of a pixel: nothing that is farther all over it can show
    /// there. The depth it was cleared to where there is no pixel.
    #[must_use]
    pub fn farthest_depth(&self, x: u32, y: u32) -> f32 {
        let depth = self.place(x, y).map_or(self.clear_depth, |(block, index)| {
            let count = self.samples.count();
            let samples = &block.depth[index * count..(index + 1) * count];
            // Depths order as their bits.
            samples.iter().copied().max().unwrap_or(self.clear_depth)
        });
        f32::from_bits(depth)
    }

    /// The linear colour of a pixel: of four samples the mean, `((a + b) + (c + d)) / 4`.
    #[must_use]
    pub fn colour(&self, x: u32, y: u32) -> Vec4 {
        let place = self.place(x, y).filter(|_| self.has_colour());
        place.map_or(self.clear_colour, |(block, index)| {
            block.resolve(index, self.samples)
        })
    }

    /// The linear colours of all pixels, rows from the top.
    #[must_use]
    pub fn linear(&self) -> Vec<Vec4> {
        let mut colours = vec![self.clear_colour; self.width as usize * self.height as usize];
        let rows = colours.par_chunks_mut(self.width.max(1) as usize);
        rows.zip(0..self.height).for_each(|(row, y)| {
            for (colour, x) in row.iter_mut().zip(0..) {
                *colour = self.colour(x, y);
            }
        });
        colours
    }

    /// The picture: the mean of samples in linear light, then sRGB.
    #[must_use]
    pub fn resolve(&self) -> Image {
        let mut rgba = vec![0; 4 * self.width as usize * self.height as usize];
        let encoder = Encoder::new();
        let clear = encode(encoder, self.clear_colour);
        let rows = rgba.par_chunks_mut(4 * self.width.max(1) as usize);
        rows.zip(0..self.height).for_each(|(row, y)| {
            let (blocks, first) = self.blocks_of_row(y);
            // Neighbours are often alike to the bit, above all where nothing was drawn.
            let mut last = (self.clear_colour, clear);
            for (pixels, block) in row.chunks_mut(4 * BLOCK_SIDE as usize).zip(blocks) {
                for (index, pixel) in pixels.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                    *pixel = if block.used && self.has_colour() {
                        let colour = block.resolve(first + index, self.samples);
                        if colour != last.0 {
                            last = (colour, encode(encoder, colour));
                        }
                        last.1
                    } else {
                        clear
                    };
                }
            }
        });
        Image {
            width: self.width,
            height: self.height,
            rgba,
        }
    }

    /// The colour of blocks that nothing was drawn into.
    pub(super) fn clear_colour(&self) -> Vec4 {
        self.clear_colour
    }

    /// The bits of the depth of blocks that nothing was drawn into.
    pub(super) fn clear_depth(&self) -> u32 {
        self.clear_depth
    }

    /// The blocks of a row of pixels and of those below, from the left, and the place in each of the row's
    /// first pixel.
    pub(super) fn blocks_of_row(&self, y: u32) -> (&[Block], usize) {
        let blocks = &self.blocks[(y / BLOCK_SIDE) as usize * self.columns..];
        (blocks, ((y % BLOCK_SIDE) * BLOCK_SIDE) as usize)
    }

    /// The block of a pixel that was drawn into, and the pixel's place in it.
    fn place(&self, x: u32, y: u32) -> Option<(&Block, usize)> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let (column, row) = (x / BLOCK_SIDE, y / BLOCK_SIDE);
        let block = &self.blocks[row as usize * self.columns + column as usize];
        let index = (y % BLOCK_SIDE) * BLOCK_SIDE + x % BLOCK_SIDE;
        block.used.then_some((block, index as usize))
    }

    /// The blocks to draw into, with what it takes to make them ready.
    pub(super) fn parts(&mut self) -> (Ready, usize, &mut [Block]) {
        let ready = Ready {
            count: (BLOCK_SIDE * BLOCK_SIDE) as usize * self.samples.count(),
            colour: self.has_colour().then_some(self.clear_colour),
            depth: self.clear_depth,
        };
        (ready, self.columns, &mut self.blocks)
    }
}

/// Makes blocks ready to be drawn into.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ready {
    count: usize,
    colour: Option<Vec4>,
    depth: u32,
}

impl Ready {
    /// Fills a block that was not drawn into since the target was cleared.
    pub(super) fn make(self, block: &mut Block) {
        if !block.used {
            block.used = true;
            refill(&mut block.depth, self.count, self.depth);
            if let Some(colour) = self.colour {
                refill(&mut block.colour, self.count, colour);
            }
            refill(&mut block.shown, self.count, NOTHING);
            block.keys.clear();
        }
    }
}

fn refill<T: Copy>(values: &mut Vec<T>, count: usize, value: T) {
    values.clear();
    values.resize(count, value);
}

impl Block {
    /// Forgets keys that show nowhere, once there are more of them than samples.
    pub(super) fn tidy(&mut self) {
        if self.keys.len() <= self.shown.len() {
            return;
        }
        let mut moved = vec![NOTHING; self.keys.len() + 1];
        let mut kept = Vec::new();
        for shown in &mut self.shown {
            if *shown == NOTHING {
                continue;
            }
            let to = &mut moved[*shown as usize];
            if *to == NOTHING {
                kept.push(self.keys[*shown as usize - 1]);
                *to = index_u32(kept.len());
            }
            *shown = *to;
        }
        self.keys = kept;
    }

    /// Whether anything was drawn into it since the target was cleared.
    pub(super) fn is_used(&self) -> bool {
        self.used
    }

    /// The linear colour of the pixel of a place.
    #[inline]
    pub(super) fn resolve(&self, index: usize, samples: Samples) -> Vec4 {
        match samples {
            Samples::One => self.colour[index],
            Samples::Four => {
                let four = &self.colour[4 * index..4 * index + 4];
                ((four[0] + four[1]) + (four[2] + four[3])) * 0.25
            }
        }
    }
}

#[inline]
fn encode(encoder: Encoder, colour: Vec4) -> [u8; 4] {
    [
        encoder.srgb(colour.x),
        encoder.srgb(colour.y),
        encoder.srgb(colour.z),
        unit_byte(colour.w),
    ]
}

/// A picture as it is written to files: sRGB colour, linear alpha, 8 bits a channel.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// Columns of pixels.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// The bytes R, G, B, A of each pixel, row by row from the top.
    pub rgba: Vec<u8>,
}

impl Image {
    /// The picture's digest: BLAKE3 over width and height, each as a little-endian `u32`, and
    /// `rgba`, and nothing else.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut digester = Digester::plain();
        digester.u32(self.width).u32(self.height).raw(&self.rgba);
        digester.finish()
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (width, height) = (self.width, self.height);
        write!(out, "Image({width} × {height}, {})", self.digest())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cleared_target_is_its_clear_colour() {
        let mut target = Target::new(65, 2, Samples::Four);
        target.clear(Vec4::new(1.0, 0.0, 0.5, 1.0), 0.25);
        let image = target.resolve();
        assert_eq!(image.rgba.len(), 4 * 65 * 2);
        assert!(
            image
                .rgba
                .chunks(4)
                .all(|pixel| pixel == [255, 0, 188, 255])
        );
        assert_eq!(target.depth(64, 1), 0.25);
        assert_eq!(target.key(64, 1), None);
        assert_eq!(target.linear().len(), 130);
    }

    #[test]
    fn the_farthest_sample_of_a_pixel_is_its_farthest_depth() {
        let mut target = Target::new(65, 2, Samples::Four);
        target.clear(Vec4::ZERO, 0.75);
        assert_eq!(target.farthest_depth(0, 0), 0.75);
        let (ready, _, blocks) = target.parts();
        ready.make(&mut blocks[0]);
        let depths = [0.25_f32, 0.5, 0.125, 0.5].map(f32::to_bits);
        blocks[0].depth[4..8].copy_from_slice(&depths);
        let along = [0, 1, 2, 64, 65].map(|x| target.farthest_depth(x, 0));
        assert_eq!(along, [0.75, 0.5, 0.75, 0.75, 0.75]);
        assert_eq!(target.depth(1, 0), 0.25, "of the first sample");
    }

    #[test]
    fn an_empty_target_is_an_empty_picture() {
        let target = Target::new(0, 3, Samples::One);
        assert!(target.resolve().rgba.is_empty());
        assert!(target.linear().is_empty());
        assert_eq!(target.key(0, 0), None);
    }

    #[test]
    fn a_digest_covers_size_and_bytes_and_nothing_else() {
        let image = Image {
            width: 1,
            height: 1,
            rgba: vec![1, 2, 3, 4],
        };
        let bytes = [1, 0, 0, 0, 1, 0, 0, 0, 1, 2, 3, 4];
        assert_eq!(image.digest(), Digest(*blake3::hash(&bytes).as_bytes()));
    }
}
