//! Two run folders: frames by their numbers, ledgers by their fields, other files by their bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Read, Take};
use std::path::{Path, PathBuf};

use super::{ChannelDifferences, FieldDifference, LookDifference, Metrics, SizeMismatch};
use crate::document::read_file;
use crate::limits;
use crate::report::folder::files_below;
use crate::report::{
    ImageFile, LEDGER_SCHEMA, LedgerEntry, MARKER, Picture, ReportError, RunLedger,
};

/// Files that say again what is compared by its parts: that their bytes differ decides nothing.
const TOLD_ELSEWHERE: [&str; 2] = ["ledger.json", "report.html"];

/// What a comparison of two run folders found.
#[derive(Debug, Clone, PartialEq)]
pub struct RunDifference {
    /// The scenes' names: expected, actual.
    pub scenes: [String; 2],
    /// What differs of what was run; a difference of versions alone decides nothing.
    pub head: Vec<FieldDifference>,
    /// How many frames both have.
    pub compared: usize,
    /// Of these, the frames that differ in anything, ascending.
    pub frames: Vec<FrameDifference>,
    /// Frames that only the first has, ascending.
    pub only_expected: Vec<u32>,
    /// Frames that only the second has, ascending.
    pub only_actual: Vec<u32>,
    /// What was sent before the first frame: where the ledgers differ.
    pub initial: Vec<FieldDifference>,
    /// The sums over all frames: where the ledgers differ.
    pub totals: Vec<FieldDifference>,
    /// How many other files are equal.
    pub equal_files: usize,
    /// The other files that differ, or that one of the folders alone has, by name.
    pub files: Vec<FileDifference>,
}

/// A frame that differs.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameDifference {
    /// Its number.
    pub frame: u32,
    /// What was found in the pictures, if they are not equal.
    pub look: Option<Result<Metrics, SizeMismatch>>,
    /// Where the ledgers differ.
    pub ledger: Vec<FieldDifference>,
}

/// A file that differs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileDifference {
    /// Its path below the folders, with `/` between the parts.
    pub name: String,
    /// In which way.
    pub state: FileState,
    /// Of an EXR file: each channel that differs, in words.
    pub detail: Vec<String>,
}

/// In which way a file differs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileState {
    /// Both have it, with other bytes.
    Differs,
    /// Only the first has it.
    OnlyExpected,
    /// Only the second has it.
    OnlyActual,
}

impl FrameDifference {
    /// Whether the pictures are the same up to the tolerance.
    #[must_use]
    pub fn looks_same(&self) -> bool {
        match &self.look {
            None => true,
            Some(Ok(metrics)) => metrics.difference.is_within(),
            Some(Err(_)) => false,
        }
    }
}

impl FileDifference {
    fn decides(&self) -> bool {
        self.state != FileState::Differs || !TOLD_ELSEWHERE.contains(&self.name.as_str())
    }
}

impl RunDifference {
    /// Whether the runs are the same, with pictures up to the tolerance.
    #[must_use]
    pub fn is_within(&self) -> bool {
        let same_frame = |frame: &FrameDifference| frame.looks_same() && frame.ledger.is_empty();
        self.head.iter().all(|field| field.name == "version")
            && self.only_expected.is_empty()
            && self.only_actual.is_empty()
            && self.frames.iter().all(same_frame)
            && self.initial.is_empty()
            && self.totals.is_empty()
            && !self.files.iter().any(FileDifference::decides)
    }

    /// Compares two run folders; `see` gets the pictures of each frame that are not equal.
    ///
    /// Digests of pictures are compared where the pictures are equal: elsewhere they say nothing new.
    ///
    /// # Errors
    ///
    /// When a folder holds no whole run, a picture cannot be read, or `see` fails.
    pub fn between(
        expected: &Path,
        actual: &Path,
        tolerance: u8,
        see: &mut dyn FnMut(u32, &LookDifference) -> Result<(), ReportError>,
    ) -> Result<Self, ReportError> {
        let folders = [Run::read(expected)?, Run::read(actual)?];
        let [one, other] = &folders;
        let heads = [&one.ledger.head, &other.ledger.head];
        let [these, those] = [one, other].map(Run::frames);
        let mut found = Self {
            scenes: heads.map(|head| head.scene.clone()),
            head: FieldDifference::all(heads[0], heads[1]),
            compared: 0,
            frames: Vec::new(),
            only_expected: missing(&these, &those),
            only_actual: missing(&those, &these),
            initial: FieldDifference::all(&one.ledger.initial, &other.ledger.initial),
            totals: FieldDifference::all(&one.ledger.totals, &other.ledger.totals),
            equal_files: 0,
            files: Vec::new(),
        };
        for (number, entry) in &these {
            let Some(other_entry) = those.get(number) else {
                continue;
            };
            found.compared += 1;
            let look = compare_pictures(one, other, *number, tolerance)?;
            let mut ledger = FieldDifference::all(entry, other_entry);
            if let Some(look) = &look {
                see(*number, look)?;
                ledger.retain(|field| field.name != "image_digest");
            }
            if look.is_some() || !ledger.is_empty() {
                found.frames.push(FrameDifference {
                    frame: *number,
                    look: look.map(|look| look.found),
                    ledger,
                });
            }
        }
        found.compare_files(&folders)?;
        Ok(found)
    }

    fn compare_files(&mut self, [one, other]: &[Run; 2]) -> Result<(), ReportError> {
        let names: BTreeSet<&String> = one.files.union(&other.files).collect();
        for name in names {
            let state = match (one.files.contains(name), other.files.contains(name)) {
                (true, true) if are_equal(one, other, name)? => {
                    self.equal_files += 1;
                    continue;
                }
                (true, true) => FileState::Differs,
                (true, false) => FileState::OnlyExpected,
                _ => FileState::OnlyActual,
            };
            let mut detail = Vec::new();
            if state == FileState::Differs && name.ends_with(".exr") {
                let [one, other] = [one, other].map(|run| ImageFile::read(&run.folder.join(name)));
                if let (ImageFile::Exr(one), ImageFile::Exr(other)) = (one?, other?) {
                    detail = told(&ChannelDifferences::between(&one, &other, 0.0));
                }
            }
            self.files.push(FileDifference {
                name: name.clone(),
                state,
                detail,
            });
        }
        Ok(())
    }
}

/// Channels that differ, in words.
fn told(channels: &ChannelDifferences) -> Vec<String> {
    let differing = channels.both.iter().filter(|channel| !channel.is_within());
    let both = differing.map(|channel| format!("{}: {channel}", channel.name));
    let alone = |names: &[String], which: &'static str| -> Vec<String> {
        let words = |name: &String| format!("{name}: only in the {which}");
        names.iter().map(words).collect()
    };
    both.chain(alone(&channels.only_expected, "first"))
        .chain(alone(&channels.only_actual, "second"))
        .collect()
}

type Frames<'a> = BTreeMap<u32, &'a LedgerEntry>;

fn missing(these: &Frames<'_>, those: &Frames<'_>) -> Vec<u32> {
    let numbers = these.keys().copied();
    numbers
        .filter(|number| !those.contains_key(number))
        .collect()
}

/// What is found in the pictures of a frame, if they are not equal.
fn compare_pictures(
    one: &Run,
    other: &Run,
    number: u32,
    tolerance: u8,
) -> Result<Option<LookDifference>, ReportError> {
    let name = picture_name(number);
    if are_equal(one, other, &name)? {
        return Ok(None);
    }
    let expected = Picture::read(&one.folder.join(&name))?;
    let actual = Picture::read(&other.folder.join(&name))?;
    if expected == actual {
        return Ok(None);
    }
    Ok(Some(LookDifference::between([expected, actual], tolerance)))
}

fn picture_name(frame: u32) -> String {
    format!("frame-{frame:04}.png")
}

/// A run folder that is read.
struct Run {
    folder: PathBuf,
    ledger: RunLedger,
    /// All files but the pictures of frames and the folder's marker.
    files: BTreeSet<String>,
}

impl Run {
    fn read(folder: &Path) -> Result<Self, ReportError> {
        let fail = |message: String| ReportError::Run {
            folder: folder.to_owned(),
            message,
        };
        if !folder.is_dir() {
            return Err(fail("no folder".to_owned()));
        }
        let name = folder.join("ledger.json");
        if !name.is_file() {
            return Err(fail("no ledger.json".to_owned()));
        }
        let wrong = |error: &dyn std::fmt::Display| fail(format!("ledger.json: {error}"));
        let bytes = read_file(&name, limits::LEDGER_BYTES).map_err(|error| wrong(&error))?;
        let ledger: RunLedger = serde_json::from_slice(&bytes).map_err(|error| wrong(&error))?;
        let schema = &ledger.head.schema;
        if schema != LEDGER_SCHEMA {
            return Err(wrong(&format!(
                "schema {schema:?}, wanted {LEDGER_SCHEMA:?}"
            )));
        }
        let mut files = files_below(folder).map_err(|error| fail(error.to_string()))?;
        files.remove(MARKER);
        for frame in &ledger.frames {
            let Some(number) = frame.frame else {
                return Err(wrong(&"a frame without a number"));
            };
            let name = picture_name(number);
            if !files.remove(&name) {
                return Err(fail(format!(
                    "no {name}, or frame {number} stands twice in ledger.json"
                )));
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
            ledger,
            files,
        })
    }

    fn frames(&self) -> Frames<'_> {
        let frames = self.ledger.frames.iter();
        let numbered = frames.filter_map(|entry| Some((entry.frame?, entry)));
        numbered.collect()
    }
}

/// Whether a file of both folders has the same bytes.
fn are_equal(one: &Run, other: &Run, name: &str) -> Result<bool, ReportError> {
    let open = |run: &Run| {
        let fail = |error: std::io::Error| ReportError::Run {
            folder: run.folder.clone(),
            message: format!("{name}: {error}"),
        };
        let file = File::open(run.folder.join(name)).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        Ok((BufReader::new(file), length))
    };
    let ((mut this, length), (mut that, other_length)) = (open(one)?, open(other)?);
    if length != other_length {
        return Ok(false);
    }
    loop {
        let [these, those] = [part(&mut this, one, name)?, part(&mut that, other, name)?];
        if these != those {
            return Ok(false);
        }
        if these.is_empty() {
            return Ok(true);
        }
    }
}

/// The next bytes of a file; none at its end.
fn part(file: &mut BufReader<File>, run: &Run, name: &str) -> Result<Vec<u8>, ReportError> {
    const BYTES: u64 = 1 << 16;
    let mut bytes = Vec::new();
    let mut part: Take<&mut BufReader<File>> = file.take(BYTES);
    part.read_to_end(&mut bytes)
        .map_err(|error| ReportError::Run {
            folder: run.folder.clone(),
            message: format!("{name}: {error}"),
        })?;
    Ok(bytes)
}
