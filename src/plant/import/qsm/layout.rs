//! Which column of a table holds what.

use crate::plant::import::{Format, ImportError, Source};

/// How a cylinder's end is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// By its point.
    Point([usize; 3]),
    /// By the direction from the start, of unit length, and the length.
    Axis {
        /// The direction.
        axis: [usize; 3],
        /// The length.
        length: usize,
    },
}

/// The columns of a table of cylinders, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// How many there are.
    pub(super) count: usize,
    /// The least number that a cylinder has: parents below it are none.
    pub(super) first: i64,
    /// The cylinder's number; `None` where it is that of the row, from 1.
    pub(super) id: Option<usize>,
    /// The number of the cylinder that bears it.
    pub(super) parent: usize,
    /// Where it starts.
    pub(super) start: [usize; 3],
    /// Where it ends.
    pub(super) end: End,
    /// Its radius.
    pub(super) radius: usize,
    /// The number of the next one on its axis.
    pub(super) next: Option<usize>,
    /// The number of its axis.
    pub(super) axis_id: Option<usize>,
}

/// `TreeQSM`'s columns without a head: 17 from version 2.4 on, 15 before.
const TREE_QSM: [(usize, Layout); 2] = [
    (17, Layout::tree_qsm(17, 10)),
    (15, Layout::tree_qsm(15, 12)),
];

impl Layout {
    /// Radius, length, start, axis, parent and extension come first in all versions.
    const fn tree_qsm(count: usize, branch: usize) -> Self {
        Self {
            count,
            first: 1,
            id: None,
            parent: 8,
            start: [2, 3, 4],
            end: End::Axis {
                axis: [5, 6, 7],
                length: 1,
            },
            radius: 0,
            next: Some(9),
            axis_id: Some(branch),
        }
    }

    /// The layout of a table whose first line has these cells, and whether that line is a head.
    pub(super) fn of(
        format: Format,
        first: &[String],
        source: &Source<'_>,
    ) -> Result<(Self, bool), ImportError> {
        let is_number = |cell: &String| cell.parse::<f64>().is_ok();
        if format != Format::TreeQsm {
            return Self::of_points(format, first, source).map(|layout| (layout, true));
        }
        if !first.first().is_some_and(is_number) {
            return Self::of_axes(first, source).map(|layout| (layout, true));
        }
        let known = TREE_QSM
            .into_iter()
            .find(|(count, _)| *count == first.len());
        match known {
            Some((_, layout)) => Ok((layout, false)),
            None => Err(source.error(
                1,
                1,
                format!(
                    "{} columns without names, wanted 17, or 15 of versions before 2.4; add the line of names",
                    first.len()
                ),
            )),
        }
    }

    /// `TreeQSM` by names: start and axis are one name and three columns each.
    fn of_axes(names: &[String], source: &Source<'_>) -> Result<Self, ImportError> {
        let mut columns: Vec<String> = Vec::new();
        // Between blanks, units are names of their own.
        for name in names.iter().filter(|name| !name.starts_with('(')) {
            let name = plain(name);
            let part = ["start", "axis"]
                .into_iter()
                .find(|part| name.starts_with(part));
            match part {
                Some(part) if !name.ends_with(['x', 'y', 'z', '1', '2', '3']) || name == "axis" => {
                    columns.extend(["x", "y", "z"].map(|axis| format!("{part}{axis}")));
                }
                Some(part) => {
                    let axis = match &name[name.len() - 1..] {
                        "1" => "x",
                        "2" => "y",
                        "3" => "z",
                        letter => letter,
                    };
                    columns.push(format!("{part}{axis}"));
                }
                None => columns.push(name),
            }
        }
        let names = Names { columns, source };
        Ok(Self {
            count: names.columns.len(),
            first: 1,
            id: None,
            parent: names.find(&["parent"])?,
            start: names.point("start")?,
            end: End::Axis {
                axis: names.point("axis")?,
                length: names.find(&["length"])?,
            },
            radius: names.find(&["radius"])?,
            next: names.find(&["extension"]).ok(),
            axis_id: names.find(&["branch"]).ok(),
        })
    }

    /// `SimpleForest` and aRchi by names.
    fn of_points(
        format: Format,
        names: &[String],
        source: &Source<'_>,
    ) -> Result<Self, ImportError> {
        let columns = names.iter().map(|name| plain(name)).collect();
        let names = Names { columns, source };
        Ok(Self {
            count: names.columns.len(),
            first: i64::from(format != Format::SimpleForest),
            id: Some(names.find(&["id", "cylid", "cylinderid"])?),
            parent: names.find(&["parentid", "parent", "parentcylid"])?,
            start: names.point("start")?,
            end: End::Point(names.point("end")?),
            radius: names.find(&["radius", "radiuscyl", "cylradius", "radiusm"])?,
            next: names.find(&["extensionid", "extension"]).ok(),
            axis_id: names.find(&["branchid", "axisid", "branch"]).ok(),
        })
    }
}

/// A name without what programs vary: case, blanks, signs, and its unit.
fn plain(name: &str) -> String {
    let name = name.split('(').next().unwrap_or_default();
    let letters = name.chars().filter(|c| c.is_ascii_alphanumeric());
    letters.collect::<String>().to_lowercase()
}

/// The plain names of all columns.
#[derive(Debug)]
struct Names<'a> {
    columns: Vec<String>,
    source: &'a Source<'a>,
}

impl Names<'_> {
    /// The first column that has one of the names.
    fn find(&self, names: &[&str]) -> Result<usize, ImportError> {
        let has = |name: &&str| self.columns.iter().position(|column| column == *name);
        names.iter().find_map(has).ok_or_else(|| {
            let message = format!(
                "no column {:?} among {} of the line of names; there are: {}",
                names[0],
                self.columns.len(),
                self.columns.join(", ")
            );
            self.source.error(1, 1, message)
        })
    }

    fn point(&self, part: &str) -> Result<[usize; 3], ImportError> {
        let find = |axis: &str| self.find(&[&format!("{part}{axis}")]);
        Ok([find("x")?, find("y")?, find("z")?])
    }
}
