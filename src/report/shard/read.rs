//! Reading `shard.jsonl`, a line at a time.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::{FILE, Head, SHARD_SCHEMA};
use crate::limits;
use crate::report::ReportError;

/// A shard whose head was read.
#[derive(Debug)]
pub(super) struct ShardFile {
    pub(super) folder: PathBuf,
    pub(super) head: Head,
    lines: BufReader<File>,
    line: usize,
}

impl ShardFile {
    /// Opens the file of a folder and reads its head.
    pub(super) fn open(folder: &Path) -> Result<Self, ReportError> {
        let path = folder.join(FILE);
        let fail = |message: String| ReportError::Shard {
            file: folder.to_owned(),
            line: 0,
            message,
        };
        let is_file = std::fs::metadata(&path).is_ok_and(|metadata| metadata.is_file());
        if !is_file {
            let wanted = "a folder that was written with --shard";
            return Err(fail(format!("holds no {FILE}, wanted {wanted}")));
        }
        let file =
            File::open(&path).map_err(|error| fail(format!("cannot read {FILE}: {error}")))?;
        let mut lines = BufReader::new(file);
        let head: Option<Head> = next_line(folder, 1, &mut lines)?;
        let head = head.ok_or_else(|| fail(format!("{FILE} is empty")))?;
        let shard = Self {
            folder: folder.to_owned(),
            head,
            lines,
            line: 1,
        };
        let (found, here) = (&shard.head, env!("CARGO_PKG_VERSION"));
        if found.schema != SHARD_SCHEMA {
            return Err(shard.fail(format!(
                "schema {:?}, wanted {SHARD_SCHEMA:?}",
                found.schema
            )));
        }
        if found.version != here {
            let message = format!("written by version {}, this is {here}", found.version);
            return Err(shard.fail(message));
        }
        if found.shard.index >= found.shard.count {
            return Err(shard.fail(format!("{} is no shard", found.shard)));
        }
        Ok(shard)
    }

    /// The next line, if there is one.
    pub(super) fn next<T: DeserializeOwned>(&mut self) -> Result<Option<T>, ReportError> {
        self.line += 1;
        next_line(&self.folder, self.line, &mut self.lines)
    }

    /// What is wrong with the line that was read last.
    pub(super) fn fail(&self, message: String) -> ReportError {
        fail(&self.folder, self.line, message)
    }
}

fn fail(folder: &Path, line: usize, message: String) -> ReportError {
    let file = folder.join(FILE);
    ReportError::Shard {
        file,
        line,
        message,
    }
}

fn next_line<T: DeserializeOwned>(
    folder: &Path,
    number: usize,
    lines: &mut BufReader<File>,
) -> Result<Option<T>, ReportError> {
    let fail = |message| fail(folder, number, message);
    let limit = limits::SHARD_LINE_BYTES;
    let mut line = Vec::new();
    let mut limited = lines.take(limit as u64 + 1);
    limited
        .read_until(b'\n', &mut line)
        .map_err(|error| fail(format!("cannot read: {error}")))?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.len() > limit {
        return Err(fail(format!("more than {limit} bytes")));
    }
    if line.last() != Some(&b'\n') {
        return Err(fail("ends in the middle of a line".to_owned()));
    }
    let value = serde_json::from_slice(&line).map_err(|error| fail(error.to_string()))?;
    Ok(Some(value))
}
