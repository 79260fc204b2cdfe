//! Drawing the frames of a scene that are kept.

use std::path::Path;

use super::GoldenError;
use super::digests::{DigestParts, SceneDigests};
use super::find::ReadScene;
use super::table::{Context, table};
use crate::run::{CrownStore, Frame, RunError, Session, Silent, World};

/// A frame that is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptFrame {
    /// What it shows and what it cost.
    pub frame: Frame,
    /// Its ledger as a table: the text of its second reference.
    pub table: String,
}

/// Draws the frames that a scene keeps, those of its `[golden]` table or else all, and tells them in
/// order; answers the scene's digests.
///
/// The frames between are committed, since a ledger counts what changed since the frame before.
pub(super) fn draw(
    read: &ReadScene,
    store: &CrownStore,
    tell: &mut dyn FnMut(KeptFrame),
) -> Result<SceneDigests, GoldenError> {
    drawn(read, store, tell).map_err(|source| GoldenError::Run {
        file: read.file.clone(),
        source: Box::new(source),
    })
}

fn drawn(
    read: &ReadScene,
    store: &CrownStore,
    tell: &mut dyn FnMut(KeptFrame),
) -> Result<SceneDigests, RunError> {
    let scene = &read.scene.scene;
    let options = &read.options;
    let folder = read.file.parent().unwrap_or(Path::new(""));
    let world = World::build_from(scene, folder, store, &Silent)?;
    let mut parts = DigestParts::new();
    for crown in &world.crowns {
        let model = options.kind.model(crown, options.model);
        parts.crown(crown, &model.host_bytes());
    }
    let mut session = Session::new(scene, &world, options)?;
    let context = Context {
        size: options.size,
        samples: options.samples,
        initial: session.initial().clone(),
    };
    let mut next = 0;
    for number in kept_frames(read) {
        for skipped in next..number {
            session.skip(skipped)?;
        }
        next = number + 1;
        let frame = session.frame(number)?;
        let table = table(&frame, &context);
        parts.frame(&frame, &table);
        tell(KeptFrame { frame, table });
    }
    Ok(parts.finish(&read.name))
}

/// The numbers of the frames that are kept, ascending.
fn kept_frames(read: &ReadScene) -> Vec<u32> {
    let scene = &read.scene.scene;
    match &scene.golden {
        Some(golden) => golden.frames.clone(),
        None => (0..scene.frames).collect(),
    }
}
