//! Sound residents with a fault put in, for those who test a law by what it catches.

use std::fmt;

use crate::gpu::{Command, GpuError, Queue, Step};
use crate::models::{Change, Resident};

/// A resident that says what it should, and does something else.
pub struct Meddled<S> {
    inner: Box<dyn Resident<S>>,
    shown: S,
    meddling: Meddling<S>,
}

/// What is changed on the way to a sound resident, and from it.
pub struct Meddling<S> {
    /// The state that is committed in place of one that is asked for.
    pub committed: Box<dyn Fn(&S) -> S>,
    /// The steps that draw a state, made of those that should.
    pub drawn: Box<Redraw<S>>,
}

/// From a state and the steps that draw it to other steps.
pub type Redraw<S> = dyn Fn(&S, Vec<Step>) -> Vec<Step>;

impl<S: Clone + 'static> Meddling<S> {
    /// No fault yet.
    #[must_use]
    pub fn none() -> Self {
        Self {
            committed: Box::new(S::clone),
            drawn: Box::new(|_, steps| steps),
        }
    }
}

impl<S: Clone> Meddled<S> {
    /// The resident with this fault, standing where it stands.
    #[must_use]
    pub fn new(inner: Box<dyn Resident<S>>, meddling: Meddling<S>) -> Self {
        Self {
            shown: inner.state().clone(),
            inner,
            meddling,
        }
    }
}

impl<S: fmt::Debug> fmt::Debug for Meddled<S> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Meddled")
            .field("inner", &self.inner)
            .field("shown", &self.shown)
            .finish_non_exhaustive()
    }
}

impl<S> fmt::Debug for Meddling<S> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Meddling").finish_non_exhaustive()
    }
}

impl<S: Clone + fmt::Debug> Resident<S> for Meddled<S> {
    fn state(&self) -> &S {
        &self.shown
    }

    fn commit(&mut self, queue: &mut Queue<'_>, to: &S) -> Result<Change, GpuError> {
        self.shown = to.clone();
        self.inner.commit(queue, &(self.meddling.committed)(to))
    }

    fn price(&self, to: &S) -> u64 {
        self.inner.price(to)
    }

    fn cluster_price(&self, cluster: u32, collapses: u32) -> Option<u64> {
        self.inner.cluster_price(cluster, collapses)
    }

    fn host_bytes(&self) -> u64 {
        self.inner.host_bytes()
    }

    fn prepare(&self, commands: &mut Vec<Command>) {
        self.inner.prepare(commands);
    }

    fn draw(&self, steps: &mut Vec<Step>) {
        let mut sound = Vec::new();
        self.inner.draw(&mut sound);
        steps.extend((self.meddling.drawn)(&self.shown, sound));
    }

    fn reveal(&self, commands: &mut Vec<Command>) {
        self.inner.reveal(commands);
    }

    fn draw_revealed(&self, steps: &mut Vec<Step>) {
        self.inner.draw_revealed(steps);
    }
}
