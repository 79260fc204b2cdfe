//! From texture coordinates to texels.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdInt, f32x8, i32x8};

/// What lies outside of the unit square of texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The nearest texel of the rim.
    Clamp,
}

/// The two texels around a coordinate, and how far it is from the first to the second.
#[inline(always)]
pub(super) fn neighbours(coordinate: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let position = coordinate * size as f32 - 0.5;
    match wrap {
        Wrap::Clamp => clamped(position, size),
        Wrap::Repeat => repeated(position, size),
    }
}

/// Without a branch: leaves are read at their rims as often as not.
#[inline(always)]
#[expect(clippy::cast_possible_wrap, reason = "sizes are at most 2^14")]
pub(super) fn clamped(position: f32, size: u32) -> (u32, u32, f32) {
    // Beyond a texel from the rim all is the rim. No number goes to the first texel.
    let position = if position > -1.0 { position } else { -1.0 };
    let furthest = size as f32;
    let position = if position < furthest {
        position
    } else {
        furthest
    };
    let sum = position + ROUND;
    let above = sum - ROUND > position;
    let floor = sum.to_bits().cast_signed() - ROUND.to_bits().cast_signed() - i32::from(above);
    let rest = position - floor as f32;
    let last = size as i32 - 1;
    let within = |texel: i32| texel.min(last).max(0).cast_unsigned();
    (within(floor), within(floor + 1), rest)
}

/// [`clamped`] of eight coordinates: the column or row of the square, and how far from its first texel to
/// its second.
#[inline(always)]
pub(super) fn clamped_lanes<S: Simd>(
    simd: S,
    coordinates: f32x8<S>,
    size: u32,
) -> (i32x8<S>, f32x8<S>) {
    let position = coordinates * f32x8::splat(simd, size as f32) - f32x8::splat(simd, 0.5);
    let before = f32x8::splat(simd, -1.0);
    let position = position.simd_gt(before).select(position, before);
    let furthest = f32x8::splat(simd, size as f32);
    let position = position.simd_lt(furthest).select(position, furthest);
    let round = f32x8::splat(simd, ROUND);
    let sum = position + round;
    let above = (sum - round).simd_gt(position);
    let bits: i32x8<S> = sum.bitcast();
    let (zero, one) = (i32x8::splat(simd, 0), i32x8::splat(simd, 1));
    let nearest = bits - i32x8::splat(simd, ROUND.to_bits().cast_signed());
    let floor = nearest - above.select(one, zero);
    let floored: f32x8<S> = floor.to_float();
    let last = i32x8::splat(simd, size.cast_signed());
    ((floor + one).min(last).max(zero), position - floored)
}

/// 1.5 · 2²³: adding it leaves no bits for a fraction, and the integer in the last bits.
const ROUND: f32 = 12_582_912.0;

#[inline(always)]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "rounds down, saturating where coordinates are absurd; sizes are at most 2^14"
)]
pub(super) fn repeated(position: f32, size: u32) -> (u32, u32, f32) {
    let cut = position as i32;
    let floor = cut.saturating_sub(i32::from(position < cut as f32));
    let rest = position - floor as f32;
    // No number and infinity end up at the first texel of the two.
    let rest = if rest > 0.0 && rest <= 1.0 { rest } else { 0.0 };
    let size = size as i32;
    let wrapped = |texel: i32| {
        let inside = if (0..size).contains(&texel) {
            texel
        } else {
            texel.rem_euclid(size)
        };
        inside.cast_unsigned()
    };
    (wrapped(floor), wrapped(floor.saturating_add(1)), rest)
}
