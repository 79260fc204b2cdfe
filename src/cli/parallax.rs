//! `spinney parallax`: how foliage moves when the camera moves sideways, model by model.

use std::sync::Arc;

use super::arguments::{ParallaxOptions, Shared};
use super::error::CliError;
use super::prepare::Prepared;
use super::run::folder;
use super::terminal::Terminal;
use crate::models::{CardLevel, Crown, Kind, ModelOptions, State, level};
use crate::raster::Counters;
use crate::report::{OutputFolder, parallax_json, parallax_text, write_parallax};
use crate::run::{self, ParallaxSubject, SessionOptions, World};
use crate::scene::{CardOptions, Transparency};

pub(super) fn parallax(
    options: &ParallaxOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let asked = options.models.iter().map(|label| Asked::named(label));
    let asked = asked.collect::<Result<Vec<Asked>, CliError>>()?;
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
    let cards = &prepared.options.model.cards;
    // Leaves in the planes of each level of impostors, which those are held against.
    let flattened: Vec<(u32, World)> = match asked.as_slice() {
        [] => (0..)
            .zip(cards.levels.as_slice())
            .map(|(level, &count)| (count, prepared.world.flattened_at(cards, level)))
            .collect(),
        _ => Vec::new(),
    };
    for (number, crown) in prepared.world.crowns.iter().enumerate() {
        let mut subjects: Vec<ParallaxSubject> = match asked.as_slice() {
            [] => usual(crown, &prepared.options),
            asked => asked
                .iter()
                .map(|asked| asked.subject(crown, &prepared.options))
                .collect(),
        };
        subjects.extend(flattened.iter().map(|(count, world)| ParallaxSubject {
            label: format!("flattened-{count}"),
            kind: Kind::Full,
            model: prepared.options.model,
            state: State::FINEST,
            crown: Some(Arc::clone(&world.crowns[number])),
        }));
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

/// What is measured where nothing is asked for: where leaves collapse half and nine tenths of the way to
/// the coarsest; impostors at each of their levels; and whatever else has cards.
fn usual(crown: &Crown, session: &SessionOptions) -> Vec<ParallaxSubject> {
    let levels: &[u32] = match crown.sequence().collapse_count() {
        0 => &[],
        _ => &[50, 90],
    };
    let asked = |kind: Kind, level: u32| Asked { kind, level };
    let leaves = levels.iter().map(|&level| asked(Kind::LodfStamps, level));
    let mut subjects: Vec<ParallaxSubject> = leaves
        .map(|leaves| leaves.subject(crown, session))
        .collect();
    // Indirect textures lie where direct ones do.
    let kind = Kind::Impostors;
    for (level, count) in (0..).zip(session.model.cards.levels.as_slice()) {
        subjects.push(ParallaxSubject {
            label: format!("{}-{count}", kind.label()),
            state: State::Cards(CardLevel(level * CardLevel::STEPS)),
            ..asked(kind, 0).subject(crown, session)
        });
    }
    let rivals = Kind::RIVALS.map(|kind| asked(kind, 0).subject(crown, session));
    subjects.extend(rivals);
    subjects
}

impl Asked {
    /// Such as `lodf-stamps@90`.
    fn named(label: &str) -> Result<Self, CliError> {
        let (name, level) = label.split_once('@').unwrap_or((label, "0"));
        let found = level.parse().ok().filter(|level| *level <= 100_u32);
        // Paint has no one surface whose flow could be told.
        let kind = Kind::labelled(name).filter(|kind| !kind.paints());
        let found = kind.zip(found);
        let (kind, level) = found.ok_or_else(|| {
            let known = Kind::ALL.into_iter().filter(|kind| !kind.paints());
            let known: Vec<String> = known.map(Kind::label).collect();
            CliError::Usage(format!(
                "--models: {label:?} is unknown; known are {}, each with levels also with one of them from \
                 0, full detail, to 100, such as lodf-stamps@90",
                known.join(", ")
            ))
        })?;
        Ok(Self { kind, level })
    }

    fn subject(self, crown: &Crown, session: &SessionOptions) -> ParallaxSubject {
        let label = self.kind.label();
        ParallaxSubject {
            label: match (self.kind.has_levels(), self.level) {
                (true, 1..) => format!("{label}@{}", self.level),
                _ => label,
            },
            kind: self.kind,
            model: ModelOptions {
                cards: CardOptions {
                    // What is blended has no one surface whose flow could be told.
                    transparency: match session.model.cards.transparency {
                        Transparency::Blend => Transparency::Test,
                        other => other,
                    },
                    ..session.model.cards
                },
                ..session.model
            },
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
