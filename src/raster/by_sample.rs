//! Opaque fragments that decide by the sample: those that move depth, and those whose alpha is coverage.
//!
//! What [`cover`](super::cover) leaves out before a fragment stage is asked must here wait for its
//! answer, or for the bound that the stage gives; so this goes pixel by pixel.

use super::pixels::{Along, SpanRows, gains};
use super::plane::{Attributes, Edges, depth_at};
use super::setup::Chunk;
use super::tile::{Choice, Tile};
use super::view::clamp_depth;
use super::{Counters, Fragment, Pixel, Samples};

/// What a fragment stage says of a pixel before it shades it.
#[expect(unnameable_types, reason = "seals `Kernel`: nobody else can make one")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The samples that are there, a bit each.
    pub(super) samples: u32,
    /// Added to the depth of the plane.
    pub(super) offset: f32,
}

impl Verdict {
    /// Asks a fragment stage.
    #[inline(always)]
    pub(super) fn of<F: Fragment>(kernel: &F, pixel: &Pixel<'_>, samples: Samples) -> Self {
        let samples = if F::COVERAGE {
            covered_by(kernel.alpha(pixel), samples)
        } else {
            Self::tested(kernel, pixel).samples
        };
        Self {
            samples,
            offset: offset_of(kernel, pixel),
        }
    }

    /// Asks one that is blended: alpha is tested, depth is the triangle's.
    #[inline(always)]
    pub(super) fn tested<F: Fragment>(kernel: &F, pixel: &Pixel<'_>) -> Self {
        let kept = !F::TESTS_ALPHA || kernel.keeps_all() || kernel.keeps(pixel);
        Self {
            samples: if kept { u32::MAX } else { 0 },
            offset: 0.0,
        }
    }

    /// The depth of a sample where the plane has this one.
    #[inline(always)]
    pub(super) fn depth(self, plane: f32) -> f32 {
        clamp_depth(plane + self.offset)
    }
}

/// The pixel as it is shaded: where the fragment stage has moved it to.
#[inline(always)]
pub(super) fn moved<'a, F: Fragment>(kernel: &F, pixel: &Pixel<'a>) -> Pixel<'a> {
    if !F::MOVES_DEPTH {
        return *pixel;
    }
    Pixel {
        depth: clamp_depth(pixel.depth + offset_of(kernel, pixel)),
        ..*pixel
    }
}

/// By how much a fragment stage moves the depth of a pixel, within the bound that it gives.
#[inline(always)]
fn offset_of<F: Fragment>(kernel: &F, pixel: &Pixel<'_>) -> f32 {
    if !F::MOVES_DEPTH {
        return 0.0;
    }
    let (offset, nearest) = (kernel.depth_offset(pixel), -bound_of(kernel));
    if offset.is_nan() {
        0.0
    } else if offset > nearest {
        offset
    } else {
        nearest
    }
}

/// How much nearer than their planes the fragments of a stage may be.
#[inline(always)]
pub(super) fn bound_of<F: Fragment>(kernel: &F) -> f32 {
    let bound = if F::MOVES_DEPTH {
        kernel.nearer_by()
    } else {
        0.0
    };
    if bound > 0.0 { bound } else { 0.0 }
}

/// From which alpha on each of four samples is there: opposite ones follow one another.
const APPEAR: [f32; 4] = [0.125, 0.875, 0.625, 0.375];

/// The samples of a pixel that an alpha covers, a bit each.
#[inline(always)]
pub(super) fn covered_by(alpha: f32, samples: Samples) -> u32 {
    match samples {
        Samples::One => u32::from(alpha >= 0.5),
        Samples::Four => {
            let bit = |(least, sample)| u32::from(alpha >= least) << sample;
            APPEAR
                .into_iter()
                .zip(0..)
                .map(bit)
                .fold(0, |mask, bit| mask | bit)
        }
    }
}

/// Decides triangles of a tile against what is there.
pub(super) fn cover<F: Fragment, const SAMPLES: usize>(
    kernel: &F,
    tile: &mut Tile<'_, '_>,
    chunk: &Chunk<'_>,
    choice: Choice<'_>,
) {
    let exact = tile.scene.counters == Counters::Exact;
    let samples = tile.scene.samples;
    let bound = bound_of(kernel);
    for place in 0..choice.count(chunk) {
        let number = choice.triangle(place);
        let triangle = &chunk.triangles[number];
        let Some(pixels) = tile.pixels.meet(triangle.pixels) else {
            continue;
        };
        if !exact && tile.hides(pixels, clamp_depth(triangle.nearest - bound).to_bits()) {
            continue;
        }
        let edges = Edges::of(triangle);
        let gains = gains::<SAMPLES>(samples, &edges);
        let mut attributes = None;
        let mut mark = None;
        let mut decide = |along: &Along, [x, y]: [i32; 2], covered: u32| {
            let index = tile.index(x, y);
            let planes = gains.map(|gain| depth_at(triangle, along.sample(gain)));
            if exact {
                tile.work(chunk.batch).covered += u64::from(covered.count_ones());
            } else {
                let may_show = |(sample, plane): (usize, &f32)| {
                    covered >> sample & 1 == 1
                        && clamp_depth(plane - bound).to_bits()
                            <= tile.depth[index * SAMPLES + sample]
                };
                if !planes.iter().enumerate().any(may_show) {
                    return;
                }
            }
            let attributes =
                attributes.get_or_insert_with(|| Attributes::of::<F>(triangle, &edges, chunk));
            let centre = along.centre();
            let position = [x, y].map(i32::unsigned_abs);
            let verdict =
                attributes.pixel::<F, _>(centre, position, depth_at(triangle, centre), |pixel| {
                    Verdict::of(kernel, pixel, samples)
                });
            let there = covered & verdict.samples;
            if exact {
                let work = tile.work(chunk.batch);
                work.texels += kernel.texels_tested();
                work.alpha_killed += u64::from((covered & !there).count_ones());
            }
            for (sample, &plane) in planes.iter().enumerate() {
                if there >> sample & 1 == 0 {
                    continue;
                }
                let place = index * SAMPLES + sample;
                let depth = verdict.depth(plane).to_bits();
                let wins = depth < tile.depth[place]
                    || (depth == tile.depth[place] && tile.wins_tie(chunk, number, place));
                if wins {
                    let mark = *mark.get_or_insert_with(|| tile.enter(number));
                    tile.depth[place] = depth;
                    tile.scratch.owner[place] = mark;
                }
            }
        };
        for spans in SpanRows::of(&edges, &gains, pixels) {
            let [first, last] = spans.columns();
            let mut along = Along::new(&edges, first, spans.y);
            for x in first..=last {
                let covered = spans.mask(x);
                if covered != 0 {
                    decide(&along, [x, spans.y], covered);
                }
                along.step();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_appear_one_by_one_as_alpha_grows() {
        let four = |alpha| covered_by(alpha, Samples::Four);
        let steps = [
            0.0, 0.124, 0.125, 0.374, 0.375, 0.624, 0.625, 0.874, 0.875, 1.0, 7.0,
        ];
        let masks = [
            0, 0, 0b1, 0b1, 0b1001, 0b1001, 0b1101, 0b1101, 0b1111, 0b1111, 0b1111,
        ];
        assert_eq!(steps.map(four), masks);
        assert_eq!([f32::NAN, -1.0].map(four), [0, 0]);
        let one = |alpha| covered_by(alpha, Samples::One);
        assert_eq!([0.0, 0.499, 0.5, 1.0, f32::NAN].map(one), [0, 0, 1, 1, 0]);
    }
}
