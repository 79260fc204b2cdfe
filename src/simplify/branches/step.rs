//! The scale of errors: whole steps of a sixteenth of an octave, so that a state is exact.

/// Steps that double an error.
const STEPS_PER_OCTAVE: u16 = 16;

/// The first step's error as a power of two, in metres: about a quarter of a millimetre.
const FIRST_OCTAVE: u16 = 12;

/// `2^(k/16)`, `k` from 0 to 15.
const ROOTS: [f64; STEPS_PER_OCTAVE as usize] = [
    1.0,
    1.044_273_782_427_413_8,
    1.090_507_732_665_257_7,
    1.138_788_634_756_691_6,
    1.189_207_115_002_721,
    1.241_857_812_073_484,
    1.296_839_554_651_009_6,
    1.354_255_546_936_892_7,
    std::f64::consts::SQRT_2,
    1.476_826_145_939_499_3,
    1.542_210_825_407_940_7,
    1.610_490_331_949_254_3,
    1.681_792_830_507_429,
    1.756_252_160_373_299_5,
    1.834_008_086_409_342_4,
    1.915_206_561_397_147_3,
];

/// An error `ε` of a level of branches: `2^(n/16 − 12)` metres for step `n`.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Default,
    serde::Serialize,
    serde::Deserialize,
)]
pub struct ErrorStep(u16);

impl ErrorStep {
    /// 2⁻¹² m, a quarter of a millimetre.
    pub const FINEST: Self = Self(0);

    /// 16 m.
    pub const COARSEST: Self = Self(STEPS_PER_OCTAVE * (FIRST_OCTAVE + 4));

    /// The step of a number, at most [`COARSEST`](Self::COARSEST).
    #[must_use]
    pub fn new(number: u16) -> Self {
        Self(number).min(Self::COARSEST)
    }

    /// The greatest step whose error is no more than `error` metres; the finest for less, and for NaN.
    #[must_use]
    pub fn within(error: f32) -> Self {
        let fits = |number: &u16| Self(*number).error() <= error;
        let last = (0..=Self::COARSEST.0).take_while(fits).last();
        last.map_or(Self::FINEST, Self)
    }

    /// `n`.
    #[must_use]
    pub fn number(self) -> u16 {
        self.0
    }

    /// `ε` in metres.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, reason = "a length, rounded once")]
    pub fn error(self) -> f32 {
        let number = self.0.min(Self::COARSEST.0);
        let octave = f64::from(1_u32 << (number / STEPS_PER_OCTAVE));
        let first = f64::from(1_u32 << FIRST_OCTAVE);
        (ROOTS[usize::from(number % STEPS_PER_OCTAVE)] * octave / first) as f32
    }

    /// The step at `done` of `all` even parts of the way to another, rounded down.
    #[must_use]
    pub fn towards(self, other: Self, done: u32, all: u32) -> Self {
        let way = i64::from(other.0) - i64::from(self.0);
        let all = all.max(1);
        let part = way * i64::from(done.min(all)) / i64::from(all);
        let number = i64::from(self.0) + part;
        // Between two steps, so it is one.
        Self(u16::try_from(number).unwrap_or(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_double_every_sixteen_and_find_themselves() {
        assert_eq!(ErrorStep::FINEST.error(), 1.0 / 4096.0);
        assert_eq!(ErrorStep::COARSEST.error(), 16.0);
        for number in 0..=ErrorStep::COARSEST.number() {
            let step = ErrorStep::new(number);
            assert_eq!(ErrorStep::within(step.error()), step);
            assert_eq!(ErrorStep::within(step.error() * 1.02), step);
            if number >= 16 {
                let half = ErrorStep::new(number - 16);
                assert_eq!(step.error(), 2.0 * half.error());
            }
        }
        for error in [0.0, -1.0, f32::NAN] {
            assert_eq!(ErrorStep::within(error), ErrorStep::FINEST);
        }
        assert_eq!(ErrorStep::within(f32::INFINITY), ErrorStep::COARSEST);
    }

    #[test]
    fn parts_of_a_way_end_where_it_ends() {
        let [from, to] = [10, 73].map(ErrorStep::new);
        assert_eq!(from.towards(to, 0, 7), from);
        assert_eq!(from.towards(to, 1, 7), ErrorStep::new(19));
        assert_eq!(from.towards(to, 9, 7), to);
        assert_eq!(to.towards(from, 7, 7), from);
        assert_eq!(from.towards(to, 1, 0), to);
    }
}
