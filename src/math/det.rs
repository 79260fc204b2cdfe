//! Transcendental functions with one answer on every machine, over `libm`.
//!
//! The standard library's call the platform's C library, whose last bits differ between processors
//! and versions; `libm` is plain Rust arithmetic. `powf` costs about 50 ns: keep it out of hot loops.

macro_rules! unary {
    ($($(#[$doc:meta])* $name:ident $single:ident $double:ident;)*) => {$(
        $(#[$doc])*
        #[must_use]
        pub fn $name(value: f32) -> f32 {
            libm::$single(value)
        }

        $(#[$doc])*
        ///
        /// In double precision.
        #[must_use]
        pub fn $double(value: f64) -> f64 {
            libm::$name(value)
        }
    )*};
}

unary! {
    /// The sine of an angle in radians.
    sin sinf sin_f64;
    /// The cosine of an angle in radians.
    cos cosf cos_f64;
    /// The tangent of an angle in radians.
    tan tanf tan_f64;
    /// The angle in radians whose sine is `value`.
    asin asinf asin_f64;
    /// The angle in radians whose cosine is `value`.
    acos acosf acos_f64;
    /// The exponential function.
    exp expf exp_f64;
    /// The natural logarithm.
    log logf log_f64;
    /// The logarithm to base 2.
    log2 log2f log2_f64;
    /// The logarithm to base 10.
    log10 log10f log10_f64;
    /// The cube root.
    cbrt cbrtf cbrt_f64;
}

/// `base` to the power of `exponent`.
#[must_use]
pub fn pow(base: f32, exponent: f32) -> f32 {
    libm::powf(base, exponent)
}

/// `base` to the power of `exponent`, in double precision.
#[must_use]
pub fn pow_f64(base: f64, exponent: f64) -> f64 {
    libm::pow(base, exponent)
}

/// The angle in radians from the x axis to (x, y).
#[must_use]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Sine and cosine of an angle in radians, as (sine, cosine).
#[must_use]
pub fn sin_cos(angle: f32) -> (f32, f32) {
    (libm::sinf(angle), libm::cosf(angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn last_bits_are_pinned() {
        assert_eq!(sin(1.0).to_bits(), 0x3f57_6aa4);
        assert_eq!(exp(1.0).to_bits(), 0x402d_f854);
        assert_eq!(pow(2.0, 0.5).to_bits(), 0x3fb5_04f3);
        assert_eq!(sin_f64(1.0).to_bits(), 0x3fea_ed54_8f09_0cee);
    }
}
