//! What was counted, by batch.

use super::Work;

/// Work by batch; most blocks see few batches.
#[derive(Debug, Default)]
pub(super) struct Works {
    of_batch: Vec<Work>,
    touched: Vec<u32>,
}

impl Works {
    #[inline]
    pub(super) fn of(&mut self, batch: u32) -> &mut Work {
        let index = batch as usize;
        if self.of_batch.len() <= index {
            self.of_batch.resize(index + 1, Work::default());
        }
        if self.of_batch[index] == Work::default() {
            self.touched.push(batch);
        }
        &mut self.of_batch[index]
    }

    /// What was counted, by ascending batch; counting starts anew.
    pub(super) fn take(&mut self) -> Vec<(u32, Work)> {
        self.touched.sort_unstable();
        self.touched.dedup();
        let of_batch = &mut self.of_batch;
        let take = |batch: u32| (batch, std::mem::take(&mut of_batch[batch as usize]));
        self.touched.drain(..).map(take).collect()
    }
}
