//! Alpha of smaller versions of a picture, for a test: as much of every neighbourhood passes as at full size.
//!
//! ```text
//! mean alpha   .2 .3 .6 .9     tested at ½: 0 0 1 1     tested after: 0 1 0 1
//!              .1 .3 .5 .8                  0 0 1 1                   0 0 1 1
//! ```
//!
//! A mean tells how much of some texels is there; a test makes all or nothing of it. Scaling all alphas until
//! as many texels pass as did keeps the sum, and the outlines of leaves that are seen one by one. Where most of what is there
//! lies in texels that it does not fill, it loses the place: what is dense fills up, what is sparse is gone,
//! and crowns shrink to their middle. From there on alphas are dealt out by the block: as much of it
//! passes as is there, and what it gets too much or too little goes to the next ([FS76](crate::references) does so
//! by the texel, and [Yuk18](crate::references) for alpha tests).

use std::cmp::Reverse;

use super::bake_resolve::byte;
use crate::plant::keep_coverage;

/// Texels a side of a block.
const BLOCK: usize = 4;

/// Places a side between the centres of four texels at which the test is tried.
const PLACES: u32 = 8;

/// How often the range that the gain lies in is halved.
const GAIN_STEPS: usize = 6;

/// Scales or deals out the mean alphas of all levels; of the first they stay if leaves are seen one by one.
///
/// `levels` are R, G, B, A a texel; `size` is that of the first one. A `cutoff` of 0 tests nothing: means stay.
pub(super) fn deal_out(levels: &mut [Vec<u8>], size: [u32; 2], cutoff: f32) {
    let least = byte((255.0 * cutoff).ceil());
    let Some(first) = levels.first() else {
        return;
    };
    let alphas = first.iter().skip(3).step_by(4);
    let sum: usize = alphas.map(|&alpha| usize::from(alpha)).sum();
    let (there, all) = ((sum + 127) / 255, first.len() / 4);
    if least == 0 || sum == 0 {
        return;
    }
    let test = Test {
        least,
        share: there as f32 / all as f32,
    };
    for (level, bytes) in (0..).zip(levels) {
        let (texels, _) = bytes.as_chunks_mut();
        let size = size.map(|side| (side >> level).max(1) as usize);
        if test.are_seen_one_by_one(texels, size[0]) {
            if level > 0 {
                keep_coverage(bytes, least, there, all);
            }
        } else {
            test.deal_out(texels, size);
        }
    }
}

/// What all levels share.
#[derive(Debug, Clone, Copy)]
struct Test {
    /// The least alpha that passes.
    least: u8,
    /// The share of all texels that is there.
    share: f32,
}

impl Test {
    /// Whether no more than half of what is there lies in texels that it does not fill, and as much passes as is
    /// there, but for an eighth: of each texel counts as unfilled what is there or what is not, whichever is less.
    fn are_seen_one_by_one(self, texels: &[[u8; 4]], width: usize) -> bool {
        let shares = texels.iter().map(|texel| f32::from(texel[3]) / 255.0);
        let [there, unfilled] = shares.fold([0.0_f32; 2], |[there, unfilled], share| {
            [there + share, unfilled + share.min((1.0 - share).max(0.0))]
        });
        2.0 * unfilled <= there && 8.0 * (self.passing(texels, width) - there).abs() <= there
    }

    /// On how many texels' area the test passes, between their centres too.
    fn passing(self, texels: &[[u8; 4]], width: usize) -> f32 {
        let rows: Vec<&[[u8; 4]]> = texels.chunks_exact(width).collect();
        let mut count = 0;
        for (y, upper) in rows.iter().enumerate() {
            let lower = rows[(y + 1).min(rows.len() - 1)];
            for x in 0..width {
                let right = (x + 1).min(width - 1);
                let corners = [upper[x], upper[right], lower[x], lower[right]];
                count += self.passing_between(corners.map(|texel| texel[3]));
            }
        }
        count as f32 / (PLACES * PLACES) as f32
    }

    /// At how many of the places between four texels' centres it passes.
    fn passing_between(self, alphas: [u8; 4]) -> u64 {
        let passing = alphas.iter().filter(|alpha| **alpha >= self.least).count();
        if passing == 0 || passing == 4 {
            return if passing == 0 {
                0
            } else {
                u64::from(PLACES * PLACES)
            };
        }
        // Places lie in the middle of their parts, so weights are odd numbers of half parts.
        let least = 4 * PLACES * PLACES * u32::from(self.least);
        let mix = |one: u32, other: u32, at: u32| one * (2 * PLACES - at) + other * at;
        let [a, b, c, d] = alphas.map(u32::from);
        let mut count = 0;
        for x in 0..PLACES {
            let [above, below] = [mix(a, b, 2 * x + 1), mix(c, d, 2 * x + 1)];
            for y in 0..PLACES {
                count += u64::from(mix(above, below, 2 * y + 1) >= least);
            }
        }
        count
    }

    /// Deals out as much as it takes for the area that passes to be what is there: lone texels pass on less than
    /// theirs, holes on more.
    ///
    /// Where an eighth is there, one texel is: a leaf too large is better than a hole.
    fn deal_out(self, texels: &mut [[u8; 4]], size: [usize; 2]) {
        let means: Vec<u8> = texels.iter().map(|texel| texel[3]).collect();
        let there = means.iter().map(|&mean| f32::from(mean) / 255.0).sum();
        let [mut least, mut most] = [0.5_f32, 2.0];
        for _ in 0..GAIN_STEPS {
            let gain = (least + most) / 2.0;
            for (texel, mean) in texels.iter_mut().zip(&means) {
                texel[3] = *mean;
            }
            self.deal_out_times(gain, texels, size);
            if self.passing(texels, size[0]) < there {
                least = gain;
            } else {
                most = gain;
            }
        }
        let passes = |texel: &[u8; 4]| texel[3] >= self.least;
        if self.share >= 0.125 && !texels.iter().any(passes) {
            // The first of the largest.
            let largest = texels.iter_mut().rev().max_by_key(|texel| texel[3]);
            if let Some(largest) = largest {
                largest[3] = self.least;
            }
        }
    }

    /// So many times what is there, block by block, row by row, there and back.
    fn deal_out_times(self, gain: f32, texels: &mut [[u8; 4]], [width, height]: [usize; 2]) {
        let columns = width.div_ceil(BLOCK);
        let mut owed = 0.0;
        let mut block = Vec::with_capacity(BLOCK * BLOCK);
        for row in 0..height.div_ceil(BLOCK) {
            for step in 0..columns {
                let column = if row % 2 == 0 {
                    step
                } else {
                    columns - 1 - step
                };
                block.clear();
                for y in BLOCK * row..height.min(BLOCK * (row + 1)) {
                    let first = y * width;
                    let at = BLOCK * column..width.min(BLOCK * (column + 1));
                    block.extend(at.map(|x| first + x).filter(|&texel| texels[texel][3] > 0));
                }
                if !block.is_empty() {
                    owed = self.settled(texels, &mut block, owed, gain);
                }
            }
        }
    }

    /// Makes `gain` times as many texels of a block pass as are there, and those that are owed from before;
    /// returns what is owed then.
    ///
    /// Less than a texel is left to the next block, so that outlines which are right stay.
    fn settled(self, texels: &mut [[u8; 4]], block: &mut [usize], owed: f32, gain: f32) -> f32 {
        let alphas = block.iter().map(|&texel| f32::from(texels[texel][3]));
        let there = alphas.fold(0.0, |sum: f32, alpha| sum + alpha) / 255.0;
        let wanted = owed + gain * there;
        block.sort_by_key(|&texel| Reverse(texels[texel][3]));
        let passing = block.partition_point(|&texel| texels[texel][3] >= self.least);
        let rest = wanted - passing as f32;
        if rest.abs() < 1.0 {
            return rest;
        }
        let share = there / block.len() as f32;
        let [absent, present] = [false, true].map(|is_there| self.alpha(is_there, share));
        let mut rest = wanted;
        for &texel in &*block {
            let is_there = rest >= 0.5;
            texels[texel][3] = if is_there { present } else { absent };
            rest -= f32::from(u8::from(is_there));
        }
        rest
    }

    /// The alpha of texels, by what is there of those around them.
    ///
    /// A lone texel of alpha 1 among texels of alpha `u` passes a test of ½ on `4 (1 - t + t ln t)` of a texel's
    /// area, where `t = (½ - u) / (1 - u)`: on .61 where `u` is 0, on all of it where `u` is .19. So where little is
    /// there, what is not gets that much; where much is there, what is gets as much less, for its holes. In
    /// between, where half of the texels are there, no area is lost.
    fn alpha(self, is_there: bool, share: f32) -> u8 {
        const LONE: f32 = 0.38;
        let lone = LONE * (4.0 * (0.5 - share)).clamp(-1.0, 1.0);
        let least = f32::from(self.least);
        if is_there {
            byte(255.0 + (255.0 - least) * lone.min(0.0))
        } else {
            byte((least - 1.0) * lone.max(0.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of the area that passes, by looking.
    fn area_passing(bytes: &[u8], [width, height]: [usize; 2]) -> f32 {
        let alpha = |x: f32, y: f32| {
            let (x, y) = (
                x.clamp(0.0, width as f32 - 1.0),
                y.clamp(0.0, height as f32 - 1.0),
            );
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "not less than 0"
            )]
            let [left, up] = [x as usize, y as usize];
            let at = |x: usize, y: usize| {
                f32::from(bytes[4 * (y.min(height - 1) * width + x.min(width - 1)) + 3])
            };
            let along =
                |y: usize| at(left, y) + (x - left as f32) * (at(left + 1, y) - at(left, y));
            along(up) + (y - up as f32) * (along(up + 1) - along(up))
        };
        let mut count = 0_u32;
        for y in 0..8 * height {
            for x in 0..8 * width {
                let [x, y] = [x, y].map(|at| (at as f32 + 0.5) / 8.0 - 0.5);
                count += u32::from(alpha(x, y) >= 127.5);
            }
        }
        count as f32 / (64 * width * height) as f32
    }

    /// A level of so many texels a side, and above it one whose half of texels is there.
    fn with_smaller(side: usize, alpha: impl Fn(usize, usize) -> u8) -> Vec<Vec<u8>> {
        let level = |side: usize, alpha: &dyn Fn(usize, usize) -> u8| -> Vec<u8> {
            (0..side * side)
                .flat_map(|k| [0, 0, 0, alpha(k % side, k / side)])
                .collect()
        };
        let full = |x: usize, _: usize| if x < side { 0 } else { 255 };
        vec![level(2 * side, &full), level(side, &alpha)]
    }

    #[test]
    fn as_much_passes_of_every_neighbourhood_as_is_there() {
        for eighths in 0_u8..=4 {
            // On the left so many eighths are there, on the right a half; no two neighbours alike.
            let mean = |x: usize| 255.0 * f32::from(if x < 32 { eighths } else { 4 }) / 8.0;
            let mut state = 1_u32;
            let mut noise = Vec::new();
            for _ in 0..64 * 64 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                noise.push((state >> 24) as f32 / 255.0 - 0.5);
            }
            let alpha = |x: usize, y: usize| {
                let mean = mean(x);
                byte(mean + noise[64 * y + x] * mean.min(255.0 - mean))
            };
            let mut levels = with_smaller(64, alpha);
            deal_out(&mut levels, [128, 128], 0.5);
            let half = |first: usize| -> Vec<u8> {
                let rows = levels[1].chunks_exact(4 * 64);
                rows.flat_map(|row| row[4 * first..4 * (first + 32)].to_vec())
                    .collect()
            };
            for first in [0, 32] {
                let wanted = mean(first) / 255.0;
                let got = area_passing(&half(first), [32, 64]);
                assert!((got - wanted).abs() < 0.05, "{wanted}: {got}");
            }
        }
    }

    /// Columns that are full, half there and empty, in turn: most of what is there fills its texel, and yet a test
    /// would lose a third of it.
    #[test]
    fn what_lies_beside_full_texels_is_not_lost_at_the_first_level() {
        const SIDE: usize = 48;
        let size = [SIDE, SIDE].map(crate::math::index_u32);
        let alpha = [255, 115, 0];
        let texels = (0..SIDE * SIDE).flat_map(|k| [0, 0, 0, alpha[k % SIDE % 3]]);
        let mut levels = vec![texels.collect()];
        deal_out(&mut levels, size, 0.5);
        let wanted = (255.0 + 115.0) / (3.0 * 255.0);
        let got = area_passing(&levels[0], [SIDE; 2]);
        assert!((got - wanted).abs() < 0.05, "{wanted}: {got}");
    }

    #[test]
    fn outlines_stay() {
        // What lies below a slanting line, and as much of the full size.
        let alpha = |x: usize, y: usize| {
            let above = 0.6 * x as f32 + 0.8 * y as f32 - 23.3;
            byte(255.0 * (0.5 - above).clamp(0.0, 1.0))
        };
        let mut levels = with_smaller(32, alpha);
        let sum: u32 = levels[1].iter().map(|&alpha| u32::from(alpha)).sum();
        let there = (4 * sum / 255) as usize;
        let full = (0..64 * 64).flat_map(|k| [0, 0, 0, if k < there { 255 } else { 0 }]);
        levels[0] = full.collect();
        let before = levels[1].clone();
        deal_out(&mut levels, [64, 64], 0.5);
        // Scaled by one number, if at all.
        let pairs = before.iter().zip(&levels[1]);
        assert!(
            pairs.clone().all(|(a, b)| a.abs_diff(*b) <= 16),
            "{:?}",
            pairs.max()
        );
    }

    #[test]
    fn where_nothing_is_nothing_gets_there() {
        let alpha = |x: usize, y: usize| if (x + y).is_multiple_of(3) { 85 } else { 0 };
        let mut levels = with_smaller(48, alpha);
        let there = 4 * 48 * 48 / 9;
        levels[0] = (0..96 * 96)
            .flat_map(|k| [0, 0, 0, if k < there { 255 } else { 0 }])
            .collect();
        deal_out(&mut levels, [96, 96], 0.5);
        let alphas = levels[1].iter().skip(3).step_by(4).enumerate();
        let passing: Vec<usize> = alphas
            .filter(|(_, alpha)| **alpha >= 128)
            .map(|(at, _)| at)
            .collect();
        assert!(passing.iter().all(|&at| alpha(at % 48, at / 48) > 0));
        let area = area_passing(&levels[1], [48, 48]);
        assert!((area - 1.0 / 9.0).abs() < 0.01, "{area}");
    }

    #[test]
    fn without_a_test_means_stay() {
        let mut levels = vec![vec![9, 9, 9, 200, 9, 9, 9, 10], vec![9, 9, 9, 105]];
        let before = levels.clone();
        deal_out(&mut levels, [2, 1], 0.0);
        assert_eq!(levels, before);
        deal_out(&mut levels, [2, 1], 0.5);
        assert!(levels[1][3] >= 128);
    }
}
