//! Forests on our own device, as [`DeviceModel`]s: a state is the vector of all trees' states.

use super::device::{Change, Counted, DeviceModel, Picture, Reads, Resource};
use super::watch::Watch;
use crate::models::{TreeChange, TreeState};
use crate::run::{Frame, RunError, Session, SessionOptions, World};
use crate::scene::Scene;

/// A scene's session, seen by the camera of one of its frames.
///
/// Writes are recorded from the start. What is committed as a [`DeviceModel`] is dictated, one state a
/// tree; [`frame`](Self::frame) is what a run does: it selects, spends the scene's budget of bytes, or
/// has the device select.
#[derive(Debug)]
pub struct ForestStage<'w> {
    session: Session<'w>,
    frame: u32,
    watch: Watch,
}

impl<'w> ForestStage<'w> {
    /// A fresh device on which every tree stands in its state, seen by the camera of a frame.
    ///
    /// # Errors
    ///
    /// What the device refuses, above all for lack of memory.
    pub fn new(
        (scene, world): (&'w Scene, &'w World),
        options: &SessionOptions,
        states: &[TreeState],
        frame: u32,
    ) -> Result<Self, RunError> {
        let session = Session::standing(scene, world, options, states)?;
        let mut watch = Watch::of(session.device());
        watch.add(session.initial().clone());
        let mut stage = Self {
            session,
            frame,
            watch,
        };
        // The view is sent as it is first drawn.
        stage.draw(TreeChange::default())?;
        Ok(stage)
    }

    /// The session.
    #[must_use]
    pub fn session(&self) -> &Session<'w> {
        &self.session
    }

    /// Goes over to a frame of the scene as a run does, and draws it.
    ///
    /// # Errors
    ///
    /// None on this session's own device.
    pub fn frame(&mut self, frame: u32) -> Result<Frame, RunError> {
        self.frame = frame;
        let change = self.session.commit(frame)?;
        self.draw(change)
    }

    fn draw(&mut self, change: TreeChange) -> Result<Frame, RunError> {
        let frame = self.session.draw(self.frame, change)?;
        self.watch.add(frame.ledger.clone());
        Ok(frame)
    }

    fn drawn(&mut self) -> Frame {
        self.draw(TreeChange::default())
            .expect("a session draws on its own device")
    }
}

impl DeviceModel<Vec<TreeState>> for ForestStage<'_> {
    fn commit(&mut self, to: &Vec<TreeState>) {
        self.session
            .commit_states(to)
            .expect("a session's own device");
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        self.watch.resources(self.session.device())
    }

    fn reads(&mut self) -> Reads {
        self.session.device_mut().track_reads();
        self.drawn();
        self.watch.reads(self.session.device())
    }

    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]) {
        let device = self.session.device_mut();
        self.watch.overwrite(device, resource, at, bytes);
    }

    fn log(&self) -> Option<Vec<Change<'_>>> {
        self.watch.log(self.session.device())
    }

    fn counted(&mut self) -> Option<Counted> {
        self.watch.add(self.session.device_mut().take_ledger());
        Some(self.watch.counted())
    }

    fn picture(&mut self) -> Option<Picture> {
        Some(self.drawn().image)
    }
}
