//! `spinney golden`: scenes against their references.

use std::path::Path;

use super::Verdict;
use super::arguments::{
    Annotate, GoldenBlessOptions, GoldenCheckOptions, GoldenCommand, GoldenDigestsOptions,
    GoldenFolders, GoldenOptions, Shared,
};
use super::error::CliError;
use super::terminal::Terminal;
use crate::golden::{
    Goldens, SceneDigests, Selection, Unused, digest_text, github_annotations, junit,
};
use crate::report::{OutputFolder, write_file};

pub(super) fn golden(
    options: &GoldenOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    match &options.command {
        GoldenCommand::Check(options) => check(options, shared, terminal),
        GoldenCommand::Bless(options) => bless(options, shared, terminal),
        GoldenCommand::Digests(options) => digests(options, shared, terminal),
    }
}

impl GoldenFolders {
    fn goldens(&self) -> Goldens {
        Goldens {
            scenes: self.folder.clone(),
            references: self.golden.clone(),
        }
    }

    fn selection(&self) -> Selection {
        Selection {
            only: self.only.clone(),
        }
    }
}

fn check(
    options: &GoldenCheckOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    if shared.json && options.annotate.is_some() {
        let message = "--json and --annotate both want standard output; wanted one of them";
        return Err(CliError::Usage(message.to_owned()));
    }
    let out = shared.out.as_deref().unwrap_or(Path::new("target/golden"));
    // Before the work, so that a path that cannot be written is told at once.
    let folder = OutputFolder::create(out)?;
    let progress = terminal.progress();
    let folders = &options.folders;
    let outcome = folders.goldens().check(&folders.selection(), &progress)?;
    drop(progress);
    outcome.write(&folder)?;
    folder.commit()?;
    if let Some(file) = &options.junit {
        write_file(file, junit(&outcome).as_bytes())?;
    }
    let text = match shared.json {
        true => outcome.to_json(),
        false => {
            let annotations = match options.annotate {
                Some(Annotate::Github) => github_annotations(&outcome),
                None => String::new(),
            };
            let page = out.join("report.html");
            format!("{annotations}{}{}\n", outcome.to_text(), page.display())
        }
    };
    terminal.print(&text)?;
    if outcome.is_all_unreadable() {
        return Err(nothing_drawn(folders));
    }
    Ok(verdict(outcome.is_same()))
}

fn bless(
    options: &GoldenBlessOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    if std::env::var_os("CI").is_some_and(|value| !value.is_empty()) {
        let message = "references are not blessed in CI, where nobody looks at them (the environment \
                       variable CI is set)";
        return Err(CliError::Usage(message.to_owned()));
    }
    let unused = match options.remove_unused {
        true => Unused::Remove,
        false => Unused::Keep,
    };
    let progress = terminal.progress();
    let folders = &options.folders;
    let blessing = folders
        .goldens()
        .bless(&folders.selection(), unused, &progress)?;
    drop(progress);
    let text = match shared.json {
        true => blessing.to_json(),
        false => blessing.to_text(),
    };
    terminal.print(&text)?;
    if blessing.outcome.is_all_unreadable() {
        return Err(nothing_drawn(folders));
    }
    Ok(verdict(!blessing.is_partial()))
}

fn nothing_drawn(folders: &GoldenFolders) -> CliError {
    let folder = folders.folder.display();
    CliError::Usage(format!("{folder}: no scene of this folder can be drawn"))
}

/// Whether all is well decides.
fn verdict(is_well: bool) -> Verdict {
    match is_well {
        true => Verdict::Passed,
        false => Verdict::Failed,
    }
}

fn digests(
    options: &GoldenDigestsOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let goldens = Goldens {
        scenes: options.folder.clone(),
        ..Goldens::default()
    };
    let progress = terminal.progress();
    let digests = goldens.digests(&progress)?;
    drop(progress);
    if shared.json {
        terminal.print(&digests_json(&digests))?;
    } else {
        terminal.print(&digest_text(&digests))?;
    }
    Ok(Verdict::Passed)
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
