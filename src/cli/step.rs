//! `spinney step`: one level after another, as somebody asks for them.
//!
//! ```text
//! standard input        standard output
//!                       {"schema":"spinney.step/1", …, "initial": …}
//! 0.25             ─▶   {"level":0.25, …}          a frame's entry of ledger.json
//! 0.25 12          ─▶   {"level":0.25, …}          seen from the camera of frame 12
//! model lodf-slots ─▶   {"schema":"spinney.step/1", …}
//! fine             ─▶   {"error": …}
//! ```
//!
//! An answer depends on the lines before it, since what a change of detail sends does; its picture does not.

use std::io::{self, BufRead, Read as _};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::arguments::{Drawing, Shared, StepOptions};
use super::error::CliError;
use super::prepare::Prepared;
use super::terminal::Terminal;
use crate::document::DocumentError;
use crate::models::{Kind, State};
use crate::raster::{Counters, Image};
use crate::report::{LedgerEntry, encode_png, write_file};
use crate::run::{Session, SessionOptions, Variant, World, finest};
use crate::scene::Scene;

/// The value of `schema` in the lines that begin a session.
const STEP_SCHEMA: &str = "spinney.step/1";

/// The longest line that is read, in bytes; what is longer is no level.
const LONGEST_LINE: u64 = 1024;

pub(super) fn step(
    options: &StepOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<(), CliError> {
    let picture = shared.out.as_deref().map(PictureFile::named).transpose()?;
    let drawing = Drawing {
        size: options.size,
        samples: options.samples,
        frames: None,
        counters: options.counters,
        shard: None,
    };
    let progress = terminal.progress();
    let prepared = Prepared::new(
        &options.scene,
        Some(&drawing),
        Counters::Visible,
        shared,
        terminal,
        &progress,
    )?;
    drop(progress);
    let scene = finest(&prepared.scene);
    let mut stage = Stage {
        scene: &scene,
        world: &prepared.world,
        usual: &prepared.options,
    };
    let own = Model {
        label: prepared.options.kind.label(),
        session: prepared.options,
    };
    let mut session = stage.begin(&own, terminal)?;
    let mut lines = Lines {
        input: io::stdin().lock(),
        read: 0,
    };
    while let Some(line) = lines.next()? {
        match line.and_then(|line| stage.asked(&line)) {
            Ok(Asked::Level { level, frame }) => {
                let frame = session.frame_at(frame, level)?;
                if let Some(picture) = &picture {
                    picture.write(&frame.image)?;
                }
                let counted = LedgerEntry::of(&frame);
                say(&Answer { level, counted }, terminal)?;
            }
            // What the device refuses leaves the session that stands.
            Ok(Asked::Model(model)) => match stage.begin(&model, terminal) {
                Ok(begun) => session = begun,
                Err(CliError::Run(error)) => lines.refuse(&error.to_string(), terminal)?,
                Err(error) => return Err(error),
            },
            Err(error) => lines.refuse(&error, terminal)?,
        }
    }
    Ok(())
}

/// What a session begins with.
#[derive(Debug, Serialize)]
struct Opening<'a> {
    schema: &'a str,
    version: &'a str,
    scene: &'a str,
    model: &'a str,
    trunk: String,
    link: &'a str,
    card: &'a str,
    size: [u32; 2],
    samples: u32,
    /// Frames of the camera's path.
    frames: u32,
    trees: usize,
    /// Leaves at full detail, over all trees.
    leaves: u64,
    /// What was sent before the first level.
    initial: LedgerEntry,
}

/// What a level took.
#[derive(Debug, Serialize)]
struct Answer {
    level: f32,
    #[serde(flatten)]
    counted: LedgerEntry,
}

/// What a line means that means nothing.
#[derive(Debug, Serialize)]
struct Refusal<'a> {
    error: &'a str,
    /// Which line, from 1.
    line: u64,
}

/// What a line asks for.
enum Asked {
    Level { level: f32, frame: u32 },
    Model(Box<Model>),
}

/// A model and how a session has it.
struct Model {
    label: String,
    session: SessionOptions,
}

/// What all sessions have in common.
#[derive(Clone, Copy)]
struct Stage<'w> {
    scene: &'w Scene,
    world: &'w World,
    usual: &'w SessionOptions,
}

impl<'w> Stage<'w> {
    /// Sends everything at full detail, and says what that took.
    fn begin(&mut self, model: &Model, terminal: &Terminal) -> Result<Session<'w>, CliError> {
        let session = Session::new(self.scene, self.world, &model.session)?;
        let trees = self.world.trees.iter();
        let leaves = trees.map(|tree| self.world.crowns[tree.crown].shown_leaves(&State::FINEST));
        let SessionOptions { size, samples, .. } = model.session;
        let opening = Opening {
            schema: STEP_SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            scene: &self.scene.name,
            model: &model.label,
            trunk: model.session.trunk.label(),
            link: model.session.link.name(),
            card: model.session.card.name(),
            size: [size.width(), size.height()],
            samples: samples.get(),
            frames: self.scene.frames,
            trees: self.world.trees.len(),
            leaves: leaves.sum(),
            initial: LedgerEntry::of_ledger(session.initial()),
        };
        say(&opening, terminal)?;
        Ok(session)
    }

    fn asked(&self, line: &str) -> Result<Asked, String> {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["model", label] => self.model(label).map(Box::new).map(Asked::Model),
            [level] => Ok(Asked::Level {
                level: level_of(level)?,
                frame: 0,
            }),
            [level, frame] => Ok(Asked::Level {
                level: level_of(level)?,
                frame: self.frame_of(frame)?,
            }),
            _ => Err(format!("{:?}: {WANTED}", line.trim())),
        }
    }

    fn frame_of(&self, word: &str) -> Result<u32, String> {
        let frames = self.scene.frames;
        let frame = word.parse().ok().filter(|frame| *frame < frames);
        frame.ok_or_else(|| format!("frame {word:?}: the scene has frames 0..{frames}"))
    }

    fn model(&self, label: &str) -> Result<Model, String> {
        let variant = Variant::labelled(label);
        if variant.is_some_and(|variant| variant.pruned) {
            let way = "pruned leaves are other collapses, wanted `model.simplifier` in the scene";
            return Err(format!("model {label:?}: {way}"));
        }
        let session = match (variant, Kind::labelled(label)) {
            (Some(variant), _) => variant.session(self.usual),
            (None, Some(kind)) => SessionOptions {
                kind,
                ..*self.usual
            },
            (None, None) => {
                let known: Vec<String> = Kind::ALL.iter().map(|kind| kind.label()).collect();
                let known = known.join(", ");
                return Err(format!(
                    "model {label:?} is unknown; known are {known}, and all of `sweep --models`"
                ));
            }
        };
        let card = session.card;
        if session.kind.selects() && !card.computes() {
            let name = card.name();
            return Err(format!(
                "model {label:?} wants a card that computes, not {name}: --card gtx770"
            ));
        }
        Ok(Model {
            label: label.to_owned(),
            session,
        })
    }
}

/// What a line may be.
const WANTED: &str =
    "wanted a level from 0 to 1, such as 0.25, a level and a frame, or `model LABEL`";

fn level_of(word: &str) -> Result<f32, String> {
    let level = word
        .parse()
        .ok()
        .filter(|level| (0.0..=1.0).contains(level));
    level.ok_or_else(|| format!("{word:?}: {WANTED}"))
}

/// Lines of text, each a bounded part of what may be endless.
struct Lines<R> {
    input: R,
    /// Lines read so far.
    read: u64,
}

impl<R: BufRead> Lines<R> {
    /// The next line, or why it is none; nothing at the end.
    fn next(&mut self) -> Result<Option<Result<String, String>>, CliError> {
        let mut line = Vec::new();
        let got = self.fill(&mut line).map_err(|error| DocumentError {
            file: "standard input".to_owned(),
            line: usize::try_from(self.read).unwrap_or(usize::MAX),
            column: 1,
            message: format!("cannot read: {error}"),
        })?;
        Ok(got.then(|| {
            if line.len() as u64 > LONGEST_LINE {
                return Err(format!(
                    "a line is longer than {LONGEST_LINE} bytes: {WANTED}"
                ));
            }
            String::from_utf8(line).map_err(|_invalid| format!("a line is no UTF-8: {WANTED}"))
        }))
    }

    /// Reads a line, of one that is too long its beginning; whether there was any.
    fn fill(&mut self, line: &mut Vec<u8>) -> io::Result<bool> {
        self.read += 1;
        let mut bounded = self.input.by_ref().take(LONGEST_LINE + 1);
        let got = bounded.read_until(b'\n', line)? > 0;
        let mut is_whole = line.len() as u64 <= LONGEST_LINE || line.ends_with(b"\n");
        while !is_whole {
            let more = self.input.fill_buf()?;
            let end = more.iter().position(|byte| *byte == b'\n');
            is_whole = end.is_some() || more.is_empty();
            let length = end.map_or(more.len(), |end| end + 1);
            self.input.consume(length);
        }
        Ok(got)
    }

    fn refuse(&self, error: &str, terminal: &Terminal) -> Result<(), CliError> {
        let line = self.read;
        say(&Refusal { error, line }, terminal)
    }
}

/// Prints a value as one line, at once.
fn say(value: &impl Serialize, terminal: &Terminal) -> Result<(), CliError> {
    let line = serde_json::to_string(value).map_err(|error| CliError::Write {
        place: "standard output".to_owned(),
        problem: error.to_string(),
    })?;
    terminal.print(&line)
}

/// The file in which the picture of the last answer is.
#[derive(Debug)]
struct PictureFile {
    path: PathBuf,
    form: PictureForm,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PictureForm {
    Png,
    /// R, G, B, A of each pixel, row by row from the top.
    Rows,
}

impl PictureFile {
    fn named(path: &Path) -> Result<Self, CliError> {
        let form = match path.extension().and_then(|ending| ending.to_str()) {
            Some("png") => PictureForm::Png,
            Some("rgba") => PictureForm::Rows,
            _ => {
                let path = path.display();
                return Err(CliError::Usage(format!(
                    "--out {path}: wanted a file that ends in .png or .rgba"
                )));
            }
        };
        Ok(Self {
            path: path.to_owned(),
            form,
        })
    }

    fn write(&self, image: &Image) -> Result<(), CliError> {
        let bytes = match self.form {
            PictureForm::Png => &encode_png(image.width, image.height, &image.rgba)?,
            PictureForm::Rows => &image.rgba,
        };
        Ok(write_file(&self.path, bytes)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_bounded_and_none_is_lost() {
        let long = usize::try_from(LONGEST_LINE).unwrap();
        let fits = "1".repeat(long - 1);
        let text = format!("0.5\n{fits}\n{}\n\n0 1\r\n{}", "2".repeat(3 * long), "3");
        // A small buffer, so that what is skipped comes in parts.
        let mut lines = Lines {
            input: io::BufReader::with_capacity(64, text.as_bytes()),
            read: 0,
        };
        let mut found = Vec::new();
        while let Some(line) = lines.next().unwrap() {
            found.push(line);
        }
        let read = |number: usize| found[number].as_deref().map(str::trim_end);
        assert_eq!(found.len(), 6);
        assert_eq!(read(0), Ok("0.5"));
        assert_eq!(read(1), Ok(fits.as_str()));
        assert!(found[2].as_ref().unwrap_err().contains("1024 bytes"));
        assert_eq!(read(3), Ok(""));
        assert_eq!(read(4), Ok("0 1"));
        assert_eq!(read(5), Ok("3"));
    }

    #[test]
    fn levels_go_from_0_to_1() {
        assert_eq!(level_of("0"), Ok(0.0));
        assert_eq!(level_of("1"), Ok(1.0));
        for word in ["1.01", "-0.1", "NaN", "inf", "", "0,5", "fine"] {
            assert!(level_of(word).unwrap_err().contains("0.25"), "{word}");
        }
    }
}
