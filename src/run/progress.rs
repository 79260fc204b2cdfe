//! How long work tells how far it is.

/// Is told what is done, and how much of it.
pub trait Progress: Sync {
    /// A piece of work of `total` steps begins; it ends when the next begins or with the run.
    fn begin(&self, what: &str, total: u64);

    /// One more step is done.
    fn step(&self);
}

/// Tells nobody.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _what: &str, _total: u64) {}

    fn step(&self) {}
}
