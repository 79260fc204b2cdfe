//! Which instructions are used: the machine's best, or those that every machine has.
//!
//! Lanes compute what a sample alone would, operation by operation, none of them fused: so pictures know
//! nothing of them.

use fearless_simd::Level;

/// The instructions that loops over samples are compiled to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    /// The widest lanes that the machine has, found out when the program runs.
    Best,
    /// One sample after the other.
    Scalar,
}

impl Instructions {
    /// The same for those who write lanes themselves.
    #[must_use]
    pub fn level(self) -> Level {
        match self {
            Self::Best => Level::new(),
            Self::Scalar => Level::fallback(),
        }
    }
}
