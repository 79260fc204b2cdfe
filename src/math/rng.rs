//! Random numbers as a function of (seed, stream, index): no draw depends on another.
//!
//! The mixing function is the finalizer of `SplitMix64` ([SLF14](crate::references)) applied to a
//! combination of the three, so a generator can skip, branch and run in parallel without a state.

use super::det;

/// All the numbers of one (seed, stream) pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stream {
    key: u64,
}

impl Stream {
    /// The stream named `stream` of `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self {
            key: mix(mix(seed ^ 0x5350_494e_4e45_5931).wrapping_add(mix(stream))),
        }
    }

    /// A stream below this one, such as a branch's below its bearer's.
    #[must_use]
    pub fn child(self, index: u64) -> Self {
        Self {
            key: mix(self.key.wrapping_add(mix(index ^ 0x6368_696c_6400_0001))),
        }
    }

    /// The number at `index`, uniform over all 64-bit values.
    #[must_use]
    pub fn u64(self, index: u64) -> u64 {
        mix(self.key.wrapping_add(index.wrapping_mul(GOLDEN_GAMMA)))
    }

    /// The number at `index`, uniform in [0, 1) in steps of 2⁻²⁴.
    #[must_use]
    pub fn unit(self, index: u64) -> f32 {
        (self.u64(index) >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// The number at `index`, uniform in [-1, 1).
    #[must_use]
    pub fn signed(self, index: u64) -> f32 {
        2.0 * self.unit(index) - 1.0
    }

    /// The number at `index`, uniform in `0..bound`; 0 when `bound` is 0.
    #[must_use]
    pub fn below(self, index: u64, bound: u64) -> u64 {
        // The high half of a 128-bit product: its bias is below bound / 2^64.
        ((u128::from(self.u64(index)) * u128::from(bound)) >> 64) as u64
    }

    /// Reads the stream one number after another.
    #[must_use]
    pub fn draws(self) -> Draws {
        Draws {
            stream: self,
            next: 0,
        }
    }
}

/// A stream read in order; the state is only the next index.
#[derive(Debug, Clone)]
pub struct Draws {
    stream: Stream,
    next: u64,
}

impl Draws {
    fn advance(&mut self) -> u64 {
        let index = self.next;
        self.next += 1;
        index
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        let index = self.advance();
        self.stream.unit(index)
    }

    /// Uniform in [-1, 1).
    pub fn signed(&mut self) -> f32 {
        let index = self.advance();
        self.stream.signed(index)
    }

    /// Uniform in `0..bound`; 0 when `bound` is 0.
    pub fn below(&mut self, bound: u64) -> u64 {
        let index = self.advance();
        self.stream.below(index, bound)
    }

    /// Normal with mean 0 and deviation 1, by the polar form of Box and Muller's method.
    pub fn normal(&mut self) -> f32 {
        let radius = (-2.0 * det::log(1.0 - self.unit())).sqrt();
        radius * det::cos(std::f32::consts::TAU * self.unit())
    }
}

const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(GOLDEN_GAMMA);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_and_repeat() {
        let stream = Stream::new(7, 1);
        assert_eq!(stream.u64(5), Stream::new(7, 1).u64(5));
        assert_ne!(stream.u64(5), Stream::new(7, 2).u64(5));
        assert_ne!(stream.child(0).u64(5), stream.child(1).u64(5));
        let mean: f32 = (0..4096).map(|index| stream.unit(index)).sum::<f32>() / 4096.0;
        assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
    }

    #[test]
    fn bounded_draws_stay_below_the_bound() {
        let mut draws = Stream::new(3, 0).draws();
        assert!((0..1000).all(|_| draws.below(7) < 7));
        assert_eq!(draws.below(0), 0);
    }
}
