//! The folder of `run --export-frame`: what each frame draws, for other renderers.

use std::path::{Path, PathBuf};

use super::error::CliError;
use crate::report::OutputFolder;
use crate::run::{Frame, RunError, SessionOptions, World, export_frame};
use crate::scene::Scene;

/// The folder while it is written: of each frame `frame-0000.glb` and `frame-0000.camera.json`.
#[derive(Debug)]
pub(super) struct FrameFolder {
    folder: OutputFolder,
}

impl FrameFolder {
    /// Begins the folder that will be `target`, beside that of the run.
    pub(super) fn create(target: &Path, run: &Path) -> Result<Self, CliError> {
        let [ours, theirs] = [absolute(target), absolute(run)];
        if ours.starts_with(&theirs) || theirs.starts_with(&ours) {
            let (target, run) = (target.display(), run.display());
            return Err(CliError::Usage(format!(
                "--export-frame {target}: the run itself goes to {run}; wanted a folder beside it"
            )));
        }
        let folder = OutputFolder::create(target)?;
        Ok(Self { folder })
    }

    /// Writes what a frame draws.
    pub(super) fn add(
        &mut self,
        scene: &Scene,
        world: &World,
        options: &SessionOptions,
        frame: &Frame,
    ) -> Result<(), CliError> {
        let number = frame.frame;
        let view = scene.camera.at(number, options.size);
        let export = export_frame(&scene.name, world, options, &view, &frame.states);
        let export = export.map_err(RunError::from)?;
        let name = format!("frame-{number:04}");
        self.folder.write(&format!("{name}.glb"), &export.glb)?;
        let camera = export.camera.as_bytes();
        Ok(self.folder.write(&format!("{name}.camera.json"), camera)?)
    }

    /// Puts the folder in its place.
    pub(super) fn finish(self) -> Result<(), CliError> {
        Ok(self.folder.commit()?)
    }
}

/// From the root on; as it is where nobody knows where that is.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_unknown| path.to_owned())
}
