//! Lines of a table as cells, whatever separates them.

use std::ops::RangeInclusive;

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::limits::TABLE_COLUMNS;
use crate::math::DVec3;
use crate::plant::import::number::{FARTHEST, bounded, whole};
use crate::plant::import::{ImportError, Source};

/// What stands between the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Separator {
    /// One byte: a tab, a semicolon or a comma. Cells may be quoted.
    Byte(u8),
    /// One or more blanks.
    Blanks,
}

impl Separator {
    /// What a line is separated by.
    fn of(line: &str) -> Self {
        let line = line.trim();
        let mut bytes = [b'\t', b';', b','].into_iter();
        let found = bytes.find(|byte| line.contains(char::from(*byte)));
        found.map_or(Self::Blanks, Self::Byte)
    }
}

/// A text's lines as cells: empty lines, and those that begin with `#`, are passed over.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rows<'t> {
    text: &'t str,
    /// The number of its first line in the file, from 1.
    first_line: usize,
}

impl<'t> Rows<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self {
            text,
            first_line: 1,
        }
    }

    /// The first line's cells, and the rows below it, which may be separated in another way: names hold
    /// blanks where numbers do not.
    pub(super) fn head(
        self,
        source: &Source<'_>,
    ) -> Result<Option<(Vec<String>, Self)>, ImportError> {
        let mut at = 0;
        for (line, text) in (self.first_line..).zip(self.text.split_inclusive('\n')) {
            let end = at + text.len();
            if is_content(text) {
                let one = Self {
                    text: &self.text[at..end],
                    first_line: line,
                };
                let mut cells = Vec::new();
                one.each(source, |row| {
                    cells.extend(row.cells.iter().map(str::to_owned));
                    Ok(())
                })?;
                while cells.last().is_some_and(String::is_empty) {
                    cells.pop();
                }
                let below = Self {
                    text: &self.text[end..],
                    first_line: line + 1,
                };
                return Ok(Some((cells, below)));
            }
            at = end;
        }
        Ok(None)
    }

    /// Gives every row in order.
    pub(super) fn each(
        self,
        source: &Source<'_>,
        mut give: impl FnMut(&Row<'_>) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        let lines = (self.first_line..).zip(self.text.lines());
        let mut lines = lines.filter(|(_, text)| is_content(text)).peekable();
        let separator = lines.peek().map(|(_, text)| Separator::of(text));
        let separator = separator.unwrap_or(Separator::Blanks);
        let mut builder = ReaderBuilder::new();
        builder.has_headers(false).flexible(true).trim(Trim::All);
        let mut cells = StringRecord::new();
        for (line, text) in lines {
            let count = match separator {
                Separator::Byte(byte) => 1 + text.matches(char::from(byte)).count(),
                Separator::Blanks => text.split_whitespace().count(),
            };
            source.limit("columns", count as u64, TABLE_COLUMNS as u64)?;
            cells.clear();
            match separator {
                // Line by line, so that a quote that nothing closes swallows no more than its own.
                Separator::Byte(byte) => {
                    let reader = builder.delimiter(byte).from_reader(text.as_bytes());
                    // The text is in memory and UTF-8, and may have any number of cells: this cannot fail.
                    let record = reader.into_records().next();
                    cells = record.and_then(Result::ok).unwrap_or_default();
                }
                Separator::Blanks => text
                    .split_whitespace()
                    .for_each(|cell| cells.push_field(cell)),
            }
            if cells.iter().any(|cell| !cell.is_empty()) {
                give(&Row {
                    line,
                    cells: &cells,
                    text,
                    separator,
                })?;
            }
        }
        Ok(())
    }
}

/// Whether a line is neither empty nor a comment.
fn is_content(line: &str) -> bool {
    let line = line.trim();
    !line.is_empty() && !line.starts_with('#')
}

/// A line of a table.
#[derive(Debug)]
pub(super) struct Row<'r> {
    /// Its number in the file, from 1.
    pub(super) line: usize,
    /// Its cells, without blanks and quotes around them.
    pub(super) cells: &'r StringRecord,
    /// Its text.
    text: &'r str,
    separator: Separator,
}

impl Row<'_> {
    /// The number in a cell, which has to lie in a range.
    pub(super) fn number(
        &self,
        source: &Source<'_>,
        cell: usize,
        name: &str,
        range: &RangeInclusive<f64>,
    ) -> Result<f64, ImportError> {
        bounded(&self.cells[cell], name, range)
            .map_err(|message| source.error(self.line, self.column(cell), message))
    }

    /// The whole number in a cell, in any form that numbers have.
    pub(super) fn whole(
        &self,
        source: &Source<'_>,
        cell: usize,
        name: &str,
    ) -> Result<i64, ImportError> {
        let text = &self.cells[cell];
        whole(text).ok_or_else(|| {
            let message = format!("{name} is {text:?}, wanted a whole number");
            source.error(self.line, self.column(cell), message)
        })
    }

    /// The whole number in a cell that may hold none.
    pub(super) fn perhaps(&self, cell: Option<usize>) -> Option<i64> {
        whole(&self.cells[cell?])
    }

    /// A point or direction in three cells.
    pub(super) fn vector(
        &self,
        source: &Source<'_>,
        cells: [usize; 3],
        names: [&str; 3],
    ) -> Result<DVec3, ImportError> {
        let mut point = [0.0; 3];
        for axis in 0..3 {
            let range = -FARTHEST..=FARTHEST;
            point[axis] = self.number(source, cells[axis], names[axis], &range)?;
        }
        Ok(point.into())
    }

    /// Refuses a line of another number of cells; empty ones at its end do not count.
    pub(super) fn check(&self, source: &Source<'_>, wanted: usize) -> Result<(), ImportError> {
        let found = self.cells.len();
        if found >= wanted && self.cells.iter().skip(wanted).all(str::is_empty) {
            return Ok(());
        }
        let column = self.column(found.min(wanted));
        Err(source.error(
            self.line,
            column,
            format!("{found} columns, wanted {wanted}"),
        ))
    }

    /// The column of the file in which a cell begins, from 1, or the one behind the last cell.
    pub(super) fn column(&self, cell: usize) -> usize {
        let mut cells = 0;
        let mut is_quoted = false;
        let mut is_blank = true;
        for (column, c) in (1..).zip(self.text.chars()) {
            let is_end = match self.separator {
                Separator::Byte(byte) => c == char::from(byte) && !is_quoted,
                Separator::Blanks => c.is_whitespace() && !is_blank,
            };
            is_quoted ^= c == '"' && matches!(self.separator, Separator::Byte(_));
            if is_end {
                cells += 1;
                is_blank = true;
            } else if !c.is_whitespace() {
                if cells == cell && is_blank {
                    return column;
                }
                is_blank = false;
            }
        }
        self.text.trim_end().chars().count() + 1
    }
}
