//! Whether the laws still catch what they must: shipped mutants, each of which has to be found, and
//! sound models, which must not be.
//!
//! ```text
//!  MUTANTS ──┬─▶ cases in the order of size ──▶ the first that breaks a law: a smallest example
//!  sound  ───┘   (leaves, collapses, steps)     none: caught nothing, as it must be
//! ```
//!
//! No case is random: all histories and walks of a few leaves are tried, then some by seed.

mod enumerate;
mod mutants;
mod tamper;

use super::{Law, Tally, Violation};

/// What a selftest found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SelftestReport {
    /// Every mutant: caught, or not.
    pub mutants: Vec<MutantReport>,
    /// Every sound model: nothing found, or a false alarm.
    pub sound: Vec<MutantReport>,
    /// How many times each law was checked.
    pub tally: Tally,
}

/// What was found of one subject.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MutantReport {
    /// Its name.
    pub name: String,
    /// What is wrong with it; nothing for a sound one.
    pub fault: String,
    /// Cases tried, the one that failed among them.
    pub cases: u64,
    /// The first, and so a smallest, case that breaks a law.
    pub counterexample: Option<Counterexample>,
}

/// A case that breaks a law.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counterexample {
    /// The case in words.
    pub example: String,
    /// What it breaks.
    pub violation: Violation,
}

impl SelftestReport {
    /// Mutants that nothing caught.
    pub fn escaped(&self) -> impl Iterator<Item = &MutantReport> {
        let mutants = self.mutants.iter();
        mutants.filter(|mutant| mutant.counterexample.is_none())
    }

    /// Sound models that something was found against.
    pub fn false_alarms(&self) -> impl Iterator<Item = &MutantReport> {
        let sound = self.sound.iter();
        sound.filter(|model| model.counterexample.is_some())
    }

    /// Whether every mutant was caught, and nothing else.
    #[must_use]
    pub fn is_passed(&self) -> bool {
        self.escaped().next().is_none() && self.false_alarms().next().is_none()
    }
}

impl MutantReport {
    /// The law that caught it.
    #[must_use]
    pub fn caught_by(&self) -> Option<Law> {
        let counterexample = self.counterexample.as_ref();
        counterexample.map(|counterexample| counterexample.violation.law)
    }
}

/// Tries every mutant and every sound model.
#[must_use]
pub fn selftest() -> SelftestReport {
    let mut tally = Tally::default();
    let mut tried = |name: &str, fault: &str, subject: mutants::Subject| {
        let mut cases = 0;
        let counterexample = subject.first_failure(&mut cases, &mut tally);
        MutantReport {
            name: name.to_owned(),
            fault: fault.to_owned(),
            cases,
            counterexample,
        }
    };
    let mutants = mutants::MUTANTS
        .iter()
        .map(|(name, fault, subject)| tried(name, fault, *subject))
        .collect();
    let sound = mutants::sound()
        .iter()
        .map(|(name, subject)| tried(name, "", *subject))
        .collect();
    SelftestReport {
        mutants,
        sound,
        tally,
    }
}
