//! Alpha of smaller versions of a picture, for a test: as much of every neighbourhood passes as at full size.
//!
//! ```text
//! mean alpha   .2 .3 .6 .9        tested: 0 0 1 1          dealt out: 0 1 0 1
//!              .1 .3 .5 .8                0 0 1 1                     0 0 1 1
//! ```
//!
//! A mean tells how much of some texels is there; a test makes all or nothing of it. So what is dense
//! fills up, what is sparse is gone, and crowns shrink to their middle, even where alpha is scaled until
//! as many texels pass as did. Dealt out instead, a texel is there or not, and what it gets too much or
//! too little goes to those that follow ([FS76](crate::references)), as [Yuk18](crate::references) proposes.
//!
//! Between texels alpha is interpolated, so that lone texels would cover less than their square, and lone
//! holes too; the alphas of those around them make up for that.

use super::bake_resolve::byte;

/// Replaces mean alphas of all levels but the first.
///
/// `levels` are R, G, B, A a texel; `size` is that of the first one. A `cutoff` of 0 tests nothing: means stay.
pub(super) fn deal_out(levels: &mut [Vec<u8>], size: [u32; 2], cutoff: f32) {
    let threshold = 255.0 * cutoff;
    let Some((first, smaller)) = levels.split_first_mut() else {
        return;
    };
    let alphas = first.iter().skip(3).step_by(4);
    let sum: u64 = alphas.clone().map(|&alpha| u64::from(alpha)).sum();
    let passing = alphas
        .filter(|&&alpha| f32::from(alpha) >= threshold)
        .count();
    if threshold <= 0.0 || sum == 0 {
        return;
    }
    // From an alpha byte to the share of the texel that passes.
    let scale = passing as f32 / sum as f32;
    let whole = 4.0 * passing as f32 / first.len() as f32;
    for (level, bytes) in (1..).zip(smaller) {
        let alphas = bytes.iter().skip(3).step_by(4);
        let shares: Vec<f32> = alphas.map(|&alpha| scale * f32::from(alpha)).collect();
        let there = diffused(
            &shares,
            size.map(|side| (side >> level).max(1) as usize),
            whole,
        );
        let alphas = bytes.iter_mut().skip(3).step_by(4);
        for ((alpha, there), share) in alphas.zip(there).zip(shares) {
            *alpha = byte(alpha_of(there, share, threshold));
        }
    }
}

/// The alpha of a texel in 255ths, by what is there of those around it.
///
/// A lone texel of alpha 1 among texels of alpha `u` passes a test of ½ on `4 (1 - t + t ln t)` of a texel's area,
/// where `t = (½ - u) / (1 - u)`: on .61 where `u` is 0, on all of it where `u` is .19. So where little is there,
/// what is not gets that much; where much is there, what is gets as much less, for its holes. In
/// between, where half of the texels are there, no area is lost.
fn alpha_of(there: bool, share: f32, threshold: f32) -> f32 {
    const LONE: f32 = 0.38;
    let lone = (4.0 * (0.5 - share)).clamp(-1.0, 1.0);
    if there {
        255.0 + LONE * (255.0 - threshold) * lone.min(0.0)
    } else {
        LONE * threshold * lone.max(0.0)
    }
}

/// Which texels are there, if each is there by such a share; `whole` is that of all of them.
///
/// Row by row, there and back: of what a texel has too much or too little, 7, 1, 5 and 3 parts go to the next, and
/// to those beyond, below and before in the next row. Nothing goes where nothing is: such parts go to the
/// others, and where there are none, to the next texel of which something is there.
/// Where an eighth is there, one texel is: a leaf too large is better than a hole.
fn diffused(shares: &[f32], [width, height]: [usize; 2], whole: f32) -> Vec<bool> {
    let mut owed = shares.to_vec();
    let mut there = vec![false; shares.len()];
    let mut left_over = 0.0;
    for y in 0..height {
        let backwards = y % 2 == 1;
        for step in 0..width {
            let texel = y * width + if backwards { width - 1 - step } else { step };
            if shares[texel] <= 0.0 {
                continue;
            }
            let wanted = owed[texel] + left_over;
            there[texel] = wanted >= 0.5;
            let rest = wanted - f32::from(u8::from(there[texel]));
            let beside = |at: usize, ahead: bool| match ahead == backwards {
                true => at.checked_sub(1),
                false => Some(at + 1),
            };
            let (first, last) = (step == 0, step + 1 == width);
            let below = (y + 1 < height).then_some(texel + width);
            let to = [
                (beside(texel, true).filter(|_| !last), 7.0),
                (below.and_then(|at| beside(at, true)).filter(|_| !last), 1.0),
                (below, 5.0),
                (
                    below.and_then(|at| beside(at, false)).filter(|_| !first),
                    3.0,
                ),
            ];
            let to = to.map(|(place, parts)| (place.filter(|&place| shares[place] > 0.0), parts));
            let parts = to.iter().filter(|(place, _)| place.is_some());
            let sum = parts.fold(0.0_f32, |sum, (_, parts)| sum + parts);
            left_over = if sum > 0.0 { 0.0 } else { rest };
            for (place, parts) in to {
                if let Some(place) = place {
                    owed[place] += rest * parts / sum;
                }
            }
        }
    }
    if whole >= 0.125 && !there.contains(&true) {
        let most = (0..shares.len())
            .rev()
            .max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
        if let Some(most) = most {
            there[most] = true;
        }
    }
    there
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of the area that passes, by looking.
    fn passing(bytes: &[u8], [width, height]: [usize; 2]) -> f32 {
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

    #[test]
    fn as_much_passes_of_every_neighbourhood_as_is_there() {
        // From left to right more and more of the texels; two bands of each share at least.
        let rows = |side: usize, of: fn(usize) -> u8| -> Vec<u8> {
            (0..side * side)
                .flat_map(|k| [0, 0, 0, of(k % side)])
                .collect()
        };
        for of in [
            (|x| if x < 32 { 64 } else { 191 }) as fn(usize) -> u8,
            |x| if x < 32 { 32 } else { 223 },
            |x| if x < 32 { 96 } else { 159 },
            |x| if x < 32 { 13 } else { 242 },
            |x| if x < 32 { 0 } else { 255 },
        ] {
            // As much is there of the first level as of this one: a half.
            let full = rows(128, |x| if x < 64 { 0 } else { 255 });
            let mut levels = vec![full, rows(64, of)];
            deal_out(&mut levels, [128, 128], 0.5);
            let half = |first: usize| -> Vec<u8> {
                let rows = levels[1].chunks_exact(4 * 64);
                rows.flat_map(|row| row[4 * first..4 * (first + 32)].to_vec())
                    .collect()
            };
            for first in [0, 32] {
                let (wanted, got) = (
                    f32::from(of(first)) / 255.0,
                    passing(&half(first), [32, 64]),
                );
                assert!((got - wanted).abs() < 0.04, "{wanted}: {got}");
            }
        }
    }

    #[test]
    fn nothing_is_owed_in_the_end() {
        for (width, height) in [(1, 1), (2, 1), (1, 7), (5, 3), (16, 16)] {
            for eighths in 0_u8..=8 {
                let share = f32::from(eighths) / 8.0;
                let there = diffused(&vec![share; width * height], [width, height], 0.0);
                let count = there.iter().filter(|&&there| there).count() as f32;
                let wanted = share * (width * height) as f32;
                assert!(
                    (count - wanted).abs() <= 0.5,
                    "{width} × {height}: {count}, {wanted}"
                );
            }
        }
        assert_eq!(
            diffused(&[0.1, 0.2, 0.2, 0.1], [2, 2], 0.15),
            [false, false, true, false]
        );
    }

    #[test]
    fn where_nothing_is_nothing_gets_there() {
        // Every third texel of every third row, by a third.
        let share = |k: usize| {
            if (k % 48).is_multiple_of(3) && (k / 48).is_multiple_of(3) {
                1.0 / 3.0
            } else {
                0.0
            }
        };
        let shares: Vec<f32> = (0..48 * 48).map(share).collect();
        let there = diffused(&shares, [48, 48], 1.0 / 27.0);
        assert!(
            there
                .iter()
                .zip(&shares)
                .all(|(&there, &share)| !there || share > 0.0)
        );
        let count = there.iter().filter(|&&there| there).count();
        assert!(count.abs_diff(256 / 3) <= 1, "{count}");
    }

    #[test]
    fn without_a_test_means_stay() {
        let mut levels = vec![vec![9, 9, 9, 200, 9, 9, 9, 10], vec![9, 9, 9, 105]];
        let before = levels.clone();
        deal_out(&mut levels, [2, 1], 0.0);
        assert_eq!(levels, before);
        deal_out(&mut levels, [2, 1], 0.5);
        assert_eq!(levels[0], before[0]);
        assert!(levels[1][3] >= 128);
    }
}
