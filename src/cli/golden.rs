//! `spinney golden`: scenes against their references.

use super::arguments::{GoldenCommand, GoldenDigestsOptions, GoldenOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use crate::golden::{Goldens, SceneDigests, digest_text};

pub(super) fn golden(
    options: &GoldenOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    match &options.command {
        GoldenCommand::Digests(options) => digests(options, shared, terminal),
    }
}

fn digests(
    options: &GoldenDigestsOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let goldens = Goldens {
        scenes: options.folder.clone(),
        ..Goldens::default()
    };
    let progress = terminal.progress();
    let digests = goldens.digests(&progress)?;
    drop(progress);
    if shared.json {
        return terminal.print(&digests_json(&digests));
    }
    terminal.print(&digest_text(&digests))
}

/// A list of objects, all digests in full.
fn digests_json(digests: &[SceneDigests]) -> String {
    let object = |digests: &SceneDigests| {
        let mut object = serde_json::Map::new();
        object.insert("scene".to_owned(), digests.scene.clone().into());
        object.insert("all".to_owned(), digests.all().to_string().into());
        for (name, part) in SceneDigests::PARTS.iter().zip(digests.parts()) {
            object.insert((*name).to_owned(), part.to_string().into());
        }
        serde_json::Value::Object(object)
    };
    let list: Vec<serde_json::Value> = digests.iter().map(object).collect();
    format!("{:#}", serde_json::Value::Array(list))
}
