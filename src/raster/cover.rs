//! Which samples a triangle covers and which of them it wins: the visibility buffer.

use super::plane::{Attributes, Edges, coordinates, depth_at};
use super::setup::{PixelBox, SUBPIXELS};
use super::tile::Tile;
use super::{Counters, Fragment, Samples};
use crate::math::index_u32;

/// Decides the opaque triangles `entries` of a tile against what is there.
pub(super) fn cover<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entries: &[u32],
) {
    for &entry in entries {
        cover_triangle::<F, SAMPLES>(kernel, tile, entry as usize);
    }
}

#[inline]
fn cover_triangle<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_>,
    entry: usize,
) {
    let (triangle, chunk, batch) = tile.triangle(entry);
    let Some(pixels) = tile.pixels_of(triangle) else {
        return;
    };
    let exact = tile.scene.counters == Counters::Exact;
    let edges = Edges::of(triangle);
    let mut attributes = None;
    visit_pixels::<SAMPLES>(tile.scene.samples, &edges, pixels, |covered| {
        let first = tile.index(covered.x, covered.y) * SAMPLES;
        let mut winning = 0_u32;
        let mut depths = [0_u32; SAMPLES];
        for (sample, place) in depths.iter_mut().enumerate() {
            if SAMPLES > 1 && covered.mask >> sample & 1 == 0 {
                continue;
            }
            let depth = depth_at(triangle, covered.at(sample)).to_bits();
            let there = tile.depth[first + sample];
            let wins = depth < there || (depth == there && tile.wins_tie(entry, first + sample));
            winning |= u32::from(wins) << sample;
            *place = depth;
        }
        if exact {
            tile.work.covered += u64::from(covered.mask.count_ones());
        } else if winning == 0 {
            return;
        }
        if F::TESTS_ALPHA {
            let attributes = attributes
                .get_or_insert_with(|| Attributes::of::<F>(triangle, &edges, chunk, batch));
            let centre = coordinates(covered.centre);
            let depth = depth_at(triangle, centre);
            let keeps = attributes.pixel::<F, _>(centre, covered.position(), depth, |pixel| {
                kernel.keeps(pixel)
            });
            if exact {
                tile.work.texels += kernel.texels_tested();
            }
            if !keeps {
                if exact {
                    tile.work.alpha_killed += u64::from(covered.mask.count_ones());
                }
                return;
            }
        }
        for (sample, &depth) in depths.iter().enumerate() {
            if winning >> sample & 1 == 1 {
                tile.depth[first + sample] = depth;
                tile.scratch.owner[first + sample] = index_u32(entry) + 1;
            }
        }
    });
}

/// A pixel of which a triangle covers some sample.
pub(super) struct Covered<'a, const SAMPLES: usize> {
    pub(super) x: i32,
    pub(super) y: i32,
    /// A bit a covered sample.
    pub(super) mask: u32,
    /// The edge functions at the pixel's centre.
    pub(super) centre: [i64; 3],
    /// What the edge functions gain from the centre to each sample.
    to_samples: &'a [[i64; 3]; SAMPLES],
}

impl<const SAMPLES: usize> Covered<'_, SAMPLES> {
    /// The second and third edge functions at a sample.
    #[inline]
    pub(super) fn at(&self, sample: usize) -> [f32; 2] {
        if SAMPLES == 1 {
            return coordinates(self.centre);
        }
        let [_, second, third] = self.to_samples[sample];
        coordinates([0, self.centre[1] + second, self.centre[2] + third])
    }

    /// Column and row.
    #[inline]
    pub(super) fn position(&self) -> [u32; 2] {
        [self.x.unsigned_abs(), self.y.unsigned_abs()]
    }
}

/// Visits those of some pixels of which the triangle covers some sample.
#[inline]
pub(super) fn visit_pixels<const SAMPLES: usize>(
    samples: Samples,
    edges: &Edges,
    pixels: PixelBox,
    mut each: impl FnMut(&Covered<'_, SAMPLES>),
) {
    let mut to_samples = [[0_i64; 3]; SAMPLES];
    if SAMPLES > 1 {
        for (gain, offset) in to_samples.iter_mut().zip(samples.offsets()) {
            let [dx, dy] = offset.map(|offset| i64::from(offset - SUBPIXELS / 2));
            for (k, gain) in gain.iter_mut().enumerate() {
                *gain = edges.right[k] * dx + edges.down[k] * dy;
            }
        }
    }
    let [r0, r1, r2] = edges.right.map(|gain| gain * i64::from(SUBPIXELS));
    let [d0, d1, d2] = edges.down.map(|gain| gain * i64::from(SUBPIXELS));
    let [b0, b1, b2] = edges.bias;
    let [mut row0, mut row1, mut row2] = edges.at_pixel(pixels.first[0], pixels.first[1]);
    for y in pixels.first[1]..=pixels.last[1] {
        let [mut e0, mut e1, mut e2] = [row0, row1, row2];
        let mut entered = false;
        for x in pixels.first[0]..=pixels.last[0] {
            let mut mask = 0;
            for (sample, gain) in to_samples.iter().enumerate() {
                let inside = if SAMPLES == 1 {
                    (e0 + b0) | (e1 + b1) | (e2 + b2)
                } else {
                    (e0 + gain[0] + b0) | (e1 + gain[1] + b1) | (e2 + gain[2] + b2)
                };
                mask |= u32::from(inside >= 0) << sample;
            }
            if mask != 0 {
                entered = true;
                each(&Covered {
                    x,
                    y,
                    mask,
                    centre: [e0, e1, e2],
                    to_samples: &to_samples,
                });
            } else if SAMPLES == 1 && entered {
                // Triangles are convex: a row has one span.
                break;
            }
            e0 += r0;
            e1 += r1;
            e2 += r2;
        }
        row0 += d0;
        row1 += d1;
        row2 += d2;
    }
}
