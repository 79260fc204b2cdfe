//! Sixteen vectors at a time, for vertex stages of many vertices.
//!
//! Every operation is that of the vector or matrix of the same name, for each lane and in the same order,
//! none of them fused: so lanes have the bits of vectors alone, on any machine.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, f32x16};

use super::{Mat4, Quat, Vec3};

/// How many there are.
pub const LANES: usize = 16;

/// Sixteen vectors.
#[derive(Debug, Clone, Copy)]
pub struct Vec3Lanes<S: Simd> {
    /// The first coordinates.
    pub x: f32x16<S>,
    /// The second ones.
    pub y: f32x16<S>,
    /// The third ones.
    pub z: f32x16<S>,
}

impl<S: Simd> Vec3Lanes<S> {
    /// From coordinates, axis by axis.
    #[inline(always)]
    pub fn new(simd: S, at: &[[f32; LANES]; 3]) -> Self {
        Self {
            x: f32x16::from_slice(simd, &at[0]),
            y: f32x16::from_slice(simd, &at[1]),
            z: f32x16::from_slice(simd, &at[2]),
        }
    }

    /// One vector in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, vector: Vec3) -> Self {
        Self {
            x: f32x16::splat(simd, vector.x),
            y: f32x16::splat(simd, vector.y),
            z: f32x16::splat(simd, vector.z),
        }
    }

    /// `self + other`.
    #[inline(always)]
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    /// `self − other`.
    #[inline(always)]
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    /// `self · factor`.
    #[inline(always)]
    #[must_use]
    pub fn times(self, factor: f32x16<S>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// [`Vec3::dot`].
    #[inline(always)]
    pub fn dot(self, other: Self) -> f32x16<S> {
        (self.x * other.x) + (self.y * other.y) + (self.z * other.z)
    }

    /// [`Vec3::cross`].
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// [`Vec3::normalize_or_zero`].
    #[inline(always)]
    #[must_use]
    pub fn normalize_or_zero(self, simd: S) -> Self {
        let zero = f32x16::splat(simd, 0.0);
        let inverse = f32x16::splat(simd, 1.0) / self.dot(self).sqrt();
        let finite = inverse.simd_lt(f32x16::splat(simd, f32::INFINITY));
        let some = finite & inverse.simd_gt(zero);
        let scaled = self.times(inverse);
        Self {
            x: some.select(scaled.x, zero),
            y: some.select(scaled.y, zero),
            z: some.select(scaled.z, zero),
        }
    }

    /// [`Quat::mul_vec3`].
    #[inline(always)]
    #[must_use]
    pub fn rotated(self, simd: S, rotation: Quat) -> Self {
        let imaginary = Vec3::new(rotation.x, rotation.y, rotation.z);
        let square = imaginary.dot(imaginary);
        let b = Self::splat(simd, imaginary);
        let w = rotation.w;
        self.times(f32x16::splat(simd, w * w - square))
            .plus(b.times(self.dot(b) * f32x16::splat(simd, 2.0)))
            .plus(b.cross(self).times(f32x16::splat(simd, w * 2.0)))
    }

    /// [`Mat4::transform_point3`].
    #[inline(always)]
    #[must_use]
    pub fn transformed(self, simd: S, matrix: &Mat4) -> Self {
        let [x, y, z] = [
            transformed_row(simd, self, matrix, 0),
            transformed_row(simd, self, matrix, 1),
            transformed_row(simd, self, matrix, 2),
        ];
        Self { x, y, z }
    }

    /// [`Mat4::mul_vec4`] of the vector and 1: x, y, z and w.
    #[inline(always)]
    pub fn projected(self, simd: S, matrix: &Mat4) -> [f32x16<S>; 4] {
        [
            projected_row(simd, self, matrix, 0),
            projected_row(simd, self, matrix, 1),
            projected_row(simd, self, matrix, 2),
            projected_row(simd, self, matrix, 3),
        ]
    }
}

#[inline(always)]
fn transformed_row<S: Simd>(simd: S, point: Vec3Lanes<S>, matrix: &Mat4, row: usize) -> f32x16<S> {
    let x = f32x16::splat(simd, matrix.x_axis[row]) * point.x;
    let xy = f32x16::splat(simd, matrix.y_axis[row]) * point.y + x;
    let xyz = f32x16::splat(simd, matrix.z_axis[row]) * point.z + xy;
    f32x16::splat(simd, matrix.w_axis[row]) + xyz
}

#[inline(always)]
fn projected_row<S: Simd>(simd: S, point: Vec3Lanes<S>, matrix: &Mat4, row: usize) -> f32x16<S> {
    let x = f32x16::splat(simd, matrix.x_axis[row]) * point.x;
    let xy = x + f32x16::splat(simd, matrix.y_axis[row]) * point.y;
    let xyz = xy + f32x16::splat(simd, matrix.z_axis[row]) * point.z;
    xyz + f32x16::splat(simd, matrix.w_axis[row])
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};

    use super::*;

    #[test]
    fn lanes_have_the_bits_of_vectors() {
        let mut state = 7_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 22) as f32 - 2.0
        };
        for level in [Level::new(), Level::fallback()] {
            for _ in 0..50 {
                let at: [[f32; LANES]; 3] =
                    std::array::from_fn(|_| std::array::from_fn(|_| next()));
                let rotation = Quat::from_xyzw(next(), next(), next(), next()).normalize();
                let matrix = Mat4::from_cols_array(&std::array::from_fn(|_| next()));
                let mut affine = matrix;
                (
                    affine.x_axis.w,
                    affine.y_axis.w,
                    affine.z_axis.w,
                    affine.w_axis.w,
                ) = (0.0, 0.0, 0.0, 1.0);
                dispatch!(level, simd => check(simd, at, rotation, matrix, affine));
            }
        }
    }

    fn check<S: Simd>(simd: S, at: [[f32; LANES]; 3], rotation: Quat, matrix: Mat4, affine: Mat4) {
        let lanes = Vec3Lanes::new(simd, &at);
        let other = Vec3Lanes::splat(simd, Vec3::new(0.3, -1.1, 0.7));
        let projected = lanes.projected(simd, &matrix);
        let turned = [
            lanes.rotated(simd, rotation),
            lanes.transformed(simd, &affine),
            lanes.cross(other),
            lanes.normalize_or_zero(simd),
            lanes.minus(other),
        ];
        for lane in 0..LANES {
            let vector = Vec3::new(at[0][lane], at[1][lane], at[2][lane]);
            let alone = [
                rotation * vector,
                affine.transform_point3(vector),
                vector.cross(Vec3::new(0.3, -1.1, 0.7)),
                vector.normalize_or_zero(),
                vector - Vec3::new(0.3, -1.1, 0.7),
            ];
            for (lanes, alone) in turned.iter().zip(alone) {
                let found = [lanes.x, lanes.y, lanes.z].map(|axis| axis[lane].to_bits());
                assert_eq!(found, alone.to_array().map(f32::to_bits));
            }
            let alone = (matrix * vector.extend(1.0)).to_array().map(f32::to_bits);
            assert_eq!(projected.map(|axis| axis[lane].to_bits()), alone);
        }
        let none = Vec3Lanes::splat(simd, Vec3::ZERO).normalize_or_zero(simd);
        assert_eq!(none.x[0], 0.0);
    }
}
