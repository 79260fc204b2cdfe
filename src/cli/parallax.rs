//! `spinney parallax`: how foliage moves when the camera moves sideways, model by model.

use std::sync::Arc;

use super::arguments::{ParallaxOptions, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::models::{CardLevel, Crown, Kind, State, level};
use crate::raster::Counters;
use crate::report::{OutputFolder, parallax_json, parallax_text, write_parallax};
use crate::run::{self, ParallaxSubject, SessionOptions};

pub(super) fn parallax(
    options: &ParallaxOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let asked: Vec<Asked> = match options.models.as_slice() {
        [] => usual(),
        labels => labels
            .iter()
            .map(|label| Asked::named(label))
            .collect::<Result<_, _>>()?,
    };
    let progress = terminal.progress();
    let prepared = Prepared::new(
        &options.scene,
        None,
        Counters::Visible,
        shared,
        terminal,
        &progress,
    )?;
    let target = folder(shared, &format!("{}-parallax", prepared.scene.name));
    // Before the work, so that a path that cannot be written is told at once.
    let output = OutputFolder::create(&target)?;
    let wanted = run::ParallaxOptions {
        side: options.side,
        steps: options.steps,
        ..run::ParallaxOptions::usual()
    };
    let mut plants = Vec::new();
    for crown in &prepared.world.crowns {
        let subjects: Vec<ParallaxSubject> = asked
            .iter()
            .map(|asked| asked.subject(crown, &prepared.options))
            .collect();
        let model = prepared.options.model;
        plants.push(run::parallax(crown, &subjects, model, &wanted, &progress)?);
    }
    drop(progress);
    write_parallax(&output, &plants)?;
    output.commit()?;
    if shared.json {
        return terminal.print(&parallax_json(&plants));
    }
    let mut text = parallax_text(&plants, terminal.width());
    text.push_str(&format!(
        "\n{}: tables, pictures of the flow and report.html\n",
        target.display()
    ));
    terminal.print(&text)
}

/// A model, and where on the axis of detail it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Asked {
    kind: Kind,
    /// How far towards its coarsest level, in hundredths.
    level: u32,
}

/// What is measured where nothing is asked for: half and a tenth of the leaves, and all cards.
fn usual() -> Vec<Asked> {
    let leaves = [50, 90].map(|level| Asked {
        kind: Kind::LodfStamps,
        level,
    });
    let cards = Kind::ALL.into_iter().filter(|kind| !kind.shows_leaves());
    let cards = cards.map(|kind| Asked { kind, level: 0 });
    leaves.into_iter().chain(cards).collect()
}

impl Asked {
    /// Such as `lodf-stamps@90`.
    fn named(label: &str) -> Result<Self, CliError> {
        let (name, level) = label.split_once('@').unwrap_or((label, "0"));
        let found = level.parse().ok().filter(|level| *level <= 100_u32);
        let found = Kind::labelled(name).zip(found);
        let (kind, level) = found.ok_or_else(|| {
            let known: Vec<String> = Kind::ALL.into_iter().map(Kind::label).collect();
            CliError::Usage(format!(
                "--models: {label:?} is unknown; known are {}, each with levels also with one of them from \
                 0, full detail, to 100, such as lodf-stamps@90",
                known.join(", ")
            ))
        })?;
        Ok(Self { kind, level })
    }

    fn subject(self, crown: &Arc<Crown>, session: &SessionOptions) -> ParallaxSubject {
        let label = self.kind.label();
        ParallaxSubject {
            label: match (self.kind.has_levels(), self.level) {
                (true, 1..) => format!("{label}@{}", self.level),
                _ => label,
            },
            kind: self.kind,
            model: session.model,
            state: match (self.kind.shows_leaves(), self.kind.has_levels()) {
                (true, true) => level(crown, self.level, 100),
                (true, false) => State::FINEST,
                (false, _) => {
                    let levels = self.kind.card_levels(&session.model.cards);
                    State::Cards(CardLevel::at_share(f64::from(self.level) / 100.0, levels))
                }
            },
            crown: None,
        }
    }
}
