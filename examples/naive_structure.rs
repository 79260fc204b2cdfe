//! A level-of-detail structure of somebody else, tested by its properties. It has a bug.
//!
//! ```text
//! cargo run --example naive_structure --features testkit
//! ```

use proptest::test_runner::{TestError, TestRunner};
use spinney::math::index_u32;
use spinney::testkit::strategy::{self, WalkOptions};
use spinney::testkit::{History, Structure, Tally, Walk, check_structure};

/// Visible leaves in slots without gaps. A collapse puts the new leaf into the slot of its first
/// operand and the last visible leaf into that of its second.
struct Slots {
    history: History,
    slots: Vec<u32>,
    /// The slots of both operands of every collapse done.
    done: Vec<[usize; 2]>,
}

impl Slots {
    fn new(history: &History) -> Self {
        Self {
            history: history.clone(),
            slots: (0..history.leaf_count()).collect(),
            done: Vec::new(),
        }
    }

    fn visible_count(&self) -> usize {
        self.slots.len() - self.done.len()
    }
}

impl Structure for Slots {
    fn visible(&self) -> Vec<u32> {
        self.slots[..self.visible_count()].to_vec()
    }

    fn collapse(&mut self) {
        let (count, op) = (self.visible_count(), self.done.len());
        let old = self.history.collapses()[op];
        let [first, second] = old.map(|leaf| {
            let slot = self.slots[..count].iter().position(|&held| held == leaf);
            slot.expect("operands are visible")
        });
        self.slots[first] = self.history.sequence().new_leaf(index_u32(op));
        self.slots[second] = self.slots[count - 1];
        self.done.push([first, second]);
    }

    fn split(&mut self) {
        let count = self.visible_count();
        let slots = self.done.pop().expect("a collapse is done");
        let old = self.history.collapses()[self.done.len()];
        for (slot, leaf) in slots.into_iter().zip(old) {
            // The slot that was last "still holds what it held". Not if the new leaf went there.
            if slot < count {
                self.slots[slot] = leaf;
            }
        }
    }
}

/// The smallest walk that breaks a law, and how, if there is one.
pub(crate) fn counterexample() -> Option<(Walk, String)> {
    let walks = strategy::walk(WalkOptions {
        leaves: 2..=40,
        roots: 1..=5,
        steps: 1..=60,
    });
    let mut runner = TestRunner::deterministic();
    let found = runner.run(&walks, |walk| {
        check_structure(&walk, Slots::new, &mut Tally::default())?;
        Ok(())
    });
    match found {
        Err(TestError::Fail(reason, walk)) => Some((walk, reason.to_string())),
        _ => None,
    }
}

/// Succeeds if the bug is found: it is there. (A test has this file as a module.)
#[cfg(not(test))]
fn main() -> std::process::ExitCode {
    use std::io::Write as _;

    let Some((walk, reason)) = counterexample() else {
        return std::process::ExitCode::FAILURE;
    };
    match writeln!(std::io::stdout(), "{walk}\n{reason}") {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(_) => std::process::ExitCode::FAILURE,
    }
}
