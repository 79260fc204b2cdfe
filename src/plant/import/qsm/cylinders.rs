//! Tables with a cylinder a line.

use super::layout::{End, Layout};
use super::plant_of;
use super::rows::{Row, Rows};
use crate::math::{DVec3, index_u32};
use crate::plant::Plant;
use crate::plant::import::number::FARTHEST;
use crate::plant::import::wood::{Segment, Wood, place_of};
use crate::plant::import::{Format, ImportError, ImportOptions, ImportReport, ReportKind, Source};

/// Reads a table of `TreeQSM`, `SimpleForest` or aRchi.
///
/// # Errors
///
/// When the text is not UTF-8, columns are missing, a line has too few or too many of them, a number is not
/// one or out of range, or there are too many cylinders.
pub(in crate::plant::import) fn read(
    format: Format,
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let rows = Rows::new(source.text()?);
    let empty = || source.error(1, 1, "no cylinders, wanted at least one line of them");
    let (first, below) = rows.head(source)?.ok_or_else(empty)?;
    let (layout, has_head) = Layout::of(format, &first, source)?;
    let mut table = Table::new(layout);
    let rows = if has_head { below } else { rows };
    rows.each(source, |row| table.add(row, source, report))?;
    if table.parents.is_empty() {
        return Err(empty());
    }
    plant_of(&table.into_wood(source, report)?, source, options, report)
}

/// Cylinders, and the numbers by which they name one another.
#[derive(Debug)]
struct Table {
    layout: Layout,
    segments: Vec<Segment>,
    /// The number of each, if it has one of its own.
    ids: Vec<i64>,
    parents: Vec<i64>,
    next: Vec<Option<i64>>,
    axes: Vec<Option<i64>>,
}

impl Table {
    fn new(layout: Layout) -> Self {
        Self {
            layout,
            segments: Vec::new(),
            ids: Vec::new(),
            parents: Vec::new(),
            next: Vec::new(),
            axes: Vec::new(),
        }
    }

    fn add(
        &mut self,
        row: &Row<'_>,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<(), ImportError> {
        let layout = self.layout;
        row.check(source, layout.count)?;
        let radius = row.number(source, layout.radius, "radius", &(0.0..=FARTHEST))?;
        let start = row.vector(source, layout.start, ["start x", "start y", "start z"])?;
        let end = match layout.end {
            End::Point(end) => row.vector(source, end, ["end x", "end y", "end z"])?,
            End::Axis { axis, length } => {
                let length = row.number(source, length, "length", &(0.0..=FARTHEST))?;
                let axis = row.vector(source, axis, ["axis x", "axis y", "axis z"])?;
                start + length * unit(axis, row.line, report)
            }
        };
        if let Some(id) = layout.id {
            self.ids
                .push(row.whole(source, id, "the cylinder's number")?);
        }
        // R writes NA for none.
        let parent = match &row.cells[layout.parent] {
            "NA" | "NaN" => layout.first - 1,
            _ => row.whole(source, layout.parent, "the parent's number")?,
        };
        self.parents.push(parent);
        self.next.push(row.perhaps(layout.next));
        self.axes.push(row.perhaps(layout.axis_id));
        self.segments.push(Segment {
            parent: None,
            follows: None,
            start: Some(start),
            end,
            start_radius: Some(radius),
            end_radius: None,
            line: row.line,
        });
        Ok(())
    }

    /// The wood, with parents by place instead of by number.
    fn into_wood(
        self,
        source: &Source<'_>,
        report: &mut ImportReport,
    ) -> Result<Wood, ImportError> {
        let numbers = Numbers::new(&self, report);
        let mut wood = Wood::new("cylinders");
        for (place, segment) in self.segments.iter().enumerate() {
            let parent = numbers.find(self.parents[place]);
            if parent.is_none() && self.parents[place] >= self.layout.first {
                let message = "parents that are not there: their children become roots";
                report.add(ReportKind::Repaired, 1, place_of(segment.line), message);
            }
            let follows = parent.and_then(|parent| {
                let next = self.next[parent as usize].and_then(|next| numbers.find(next));
                match (next, self.axes[parent as usize], self.axes[place]) {
                    (Some(next), ..) => Some(next as usize == place),
                    (None, Some(bearer), Some(own)) => Some(bearer == own),
                    _ => None,
                }
            });
            let segment = Segment {
                parent,
                follows,
                ..*segment
            };
            wood.push(segment, source)?;
        }
        Ok(wood)
    }
}

/// A direction of unit length as it is, rounding included; any other made one.
fn unit(axis: DVec3, line: usize, report: &mut ImportReport) -> DVec3 {
    if (axis.length_squared() - 1.0).abs() < 0.02 {
        return axis;
    }
    let message = "axes that are not of length 1: taken as directions";
    report.add(ReportKind::Repaired, 1, place_of(line), message);
    axis.normalize_or_zero()
}

/// From numbers to places.
#[derive(Debug)]
struct Numbers {
    /// Numbers and places by number; empty where numbers are places counted from 1.
    sorted: Vec<(i64, u32)>,
    count: usize,
}

impl Numbers {
    fn new(table: &Table, report: &mut ImportReport) -> Self {
        let mut sorted: Vec<(i64, u32)> = table.ids.iter().copied().zip(0..).collect();
        sorted.sort_unstable();
        for pair in sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let place = place_of(table.segments[pair[1].1 as usize].line);
            let message = "numbers that stand twice: parents mean the first";
            report.add(ReportKind::Repaired, 1, place, message);
        }
        sorted.dedup_by_key(|(number, _)| *number);
        Self {
            sorted,
            count: table.segments.len(),
        }
    }

    fn find(&self, number: i64) -> Option<u32> {
        if self.sorted.is_empty() {
            let place = usize::try_from(number.checked_sub(1)?).ok()?;
            return (place < self.count).then(|| index_u32(place));
        }
        let found = self
            .sorted
            .binary_search_by_key(&number, |(number, _)| *number);
        found.ok().map(|place| self.sorted[place].1)
    }
}
