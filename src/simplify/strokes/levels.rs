//! Leaf strokes by shell and level, each stored once.
//!
//! ```text
//!   shell        0          1      …    34 (core)
//!   row 0     ■■■■■■■■   ■■■■■■■■    ■■■■■■■■■■■   one stroke a leaf
//!   row 1     ■■■■■■     ■■■■         ■■■■         wider thresholds
//!   row 2     ■■■        ■■           ■■
//!   row 3     ■          ■            ■
//! ```
//!
//! A stroke is made in one row and lasts until it becomes part of another in a later one, so it is
//! stored once with the rows in which it is there ("implicit" in [CQHCVL06](crate::references),
//! section 3). A node, a shell's strokes in a row, is a few runs of the list: one for every row that
//! strokes were made in, first the strokes that last longest.

use std::ops::Range;

use super::collapse::{CollapseThresholds, grouped, joined};
use super::leaf::LeafStroke;
use super::shells::Shells;
use crate::math::{det, index_u32};

/// How shells are simplified.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelOptions {
    /// The thresholds of each row after the first; they grow from row to row.
    pub thresholds: Vec<CollapseThresholds>,
    /// The most strokes that become one in one row, at least 2.
    pub most_at_once: u32,
    /// How much larger thresholds are in the innermost shell, as a share of their own: 0 for all
    /// alike. They grow evenly from shell to shell.
    pub inward: f32,
}

/// All levels of a plant's leaf strokes: a table of rows, finest first, by shells, outermost first.
#[derive(Debug, Clone, PartialEq)]
pub struct StrokeLevels {
    rows: u32,
    shells: u32,
    /// Shell by shell, then by the row in which they are made, then those that last longest first.
    strokes: Vec<LeafStroke>,
    /// The first stroke of each (shell, row in which it is made).
    firsts: Vec<u32>,
    /// How many strokes of a (shell, row in which they are made) are there in a row.
    lasting: Vec<u32>,
    totals: Vec<u32>,
}

impl StrokeLevels {
    /// Simplifies the strokes of every shell, row by row, each row from the one before. The shells'
    /// points are the strokes' centres.
    ///
    /// # Panics
    ///
    /// When a shell names a stroke that there is not.
    #[must_use]
    pub fn new(strokes: &[LeafStroke], shells: &Shells, options: &LevelOptions) -> Self {
        let unit = mean_length(strokes);
        let rows = index_u32(options.thresholds.len() + 1);
        let mut levels = Self {
            rows,
            shells: index_u32(shells.points.len()),
            strokes: Vec::new(),
            firsts: Vec::new(),
            lasting: Vec::new(),
            totals: vec![0; rows as usize],
        };
        let innermost = shells.points.len().saturating_sub(1).max(1) as f32;
        for (place, shell) in shells.points.iter().enumerate() {
            let growth = 1.0 + options.inward * (place as f32 / innermost);
            let shell = shell.iter().map(|leaf| strokes[*leaf as usize]);
            levels.add_shell(shell, options, unit, growth);
        }
        levels
    }

    fn add_shell(
        &mut self,
        shell: impl Iterator<Item = LeafStroke>,
        options: &LevelOptions,
        unit: f32,
        growth: f32,
    ) {
        // Strokes with the row in which they are made, and the first without them.
        let mut made: Vec<(u32, u32, LeafStroke)> =
            shell.map(|stroke| (0, self.rows, stroke)).collect();
        let mut there: Vec<u32> = (0_u32..).take(made.len()).collect();
        for (row, thresholds) in (1..).zip(&options.thresholds) {
            let current: Vec<LeafStroke> = there
                .iter()
                .map(|stroke| made[*stroke as usize].2)
                .collect();
            let distance = growth * thresholds.distance * unit;
            let angle = growth * thresholds.angle;
            let most = (options.most_at_once as usize).max(2);
            let mut next = Vec::new();
            for group in grouped(&current, distance, angle, most) {
                if let [alone] = group[..] {
                    next.push(there[alone as usize]);
                    continue;
                }
                for &part in &group {
                    made[there[part as usize] as usize].1 = row;
                }
                next.push(index_u32(made.len()));
                made.push((row, self.rows, joined(&current, &group)));
            }
            next.sort_unstable();
            there = next;
        }
        made.sort_by_key(|(first, end, _)| (*first, std::cmp::Reverse(*end)));
        for first in 0..self.rows {
            let of_row = || made.iter().filter(move |(made_in, ..)| *made_in == first);
            self.firsts.push(index_u32(self.strokes.len()));
            for row in 0..self.rows {
                let lasting = of_row().filter(|(made_in, end, _)| *made_in <= row && row < *end);
                let lasting = index_u32(lasting.count());
                self.lasting.push(lasting);
                self.totals[row as usize] += lasting;
            }
            self.strokes.extend(of_row().map(|(.., stroke)| *stroke));
        }
    }

    /// How many rows there are; row 0 has one stroke a leaf.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// How many shells there are.
    #[must_use]
    pub fn shells(&self) -> u32 {
        self.shells
    }

    /// All strokes, each once.
    #[must_use]
    pub fn strokes(&self) -> &[LeafStroke] {
        &self.strokes
    }

    /// The number of strokes of each row, over all shells.
    #[must_use]
    pub fn totals(&self) -> &[u32] {
        &self.totals
    }

    /// The runs of [`strokes`](Self::strokes) that are a shell's in a row; none is empty.
    ///
    /// # Panics
    ///
    /// When there is no such shell.
    pub fn node(&self, row: u32, shell: u32) -> impl Iterator<Item = Range<u32>> + '_ {
        assert!(shell < self.shells, "shell {shell} of {}", self.shells);
        let runs = (0..=row.min(self.rows - 1)).map(move |made_in| {
            let place = (shell * self.rows + made_in) as usize;
            let first = self.firsts[place];
            first..first + self.lasting[place * self.rows as usize + row as usize]
        });
        runs.filter(|run| !run.is_empty())
    }

    /// The run of [`strokes`](Self::strokes) that are a shell's in any row.
    ///
    /// # Panics
    ///
    /// When there is no such shell.
    #[must_use]
    pub fn of_shell(&self, shell: u32) -> Range<u32> {
        assert!(shell < self.shells, "shell {shell} of {}", self.shells);
        let first = |shell: u32| self.firsts.get((shell * self.rows) as usize).copied();
        let end = first(shell + 1).unwrap_or(index_u32(self.strokes.len()));
        first(shell).unwrap_or(end)..end
    }

    /// The tables that find a node: of each shell and row in which strokes are made the first of them, then
    /// how many of them there are in each row.
    pub fn words(&self) -> impl Iterator<Item = u32> + '_ {
        self.firsts.iter().chain(&self.lasting).copied()
    }

    /// How many strokes a shell has in a row.
    ///
    /// # Panics
    ///
    /// When there is no such shell.
    #[must_use]
    pub fn node_count(&self, row: u32, shell: u32) -> u32 {
        self.node(row, shell)
            .fold(0, |sum, run| sum + (run.end - run.start))
    }

    /// Bytes of the strokes with the tables that find a node: two numbers of 4 bytes for each row that
    /// a node's strokes may have been made in, the first stroke once for all rows.
    #[must_use]
    pub fn implicit_bytes(&self) -> u64 {
        let (rows, shells) = (u64::from(self.rows), u64::from(self.shells));
        let strokes = self.strokes.len() as u64 * u64::from(LeafStroke::STRIDE);
        // Strokes made in row b are counted in rows b, b + 1, …: a triangle of counts.
        strokes + 4 * shells * (rows + rows * (rows + 1) / 2) + 4 * rows
    }

    /// Bytes of a copy of every row, each with the first stroke of every node.
    #[must_use]
    pub fn copied_bytes(&self) -> u64 {
        let strokes: u64 = self.totals.iter().map(|total| u64::from(*total)).sum();
        let nodes = u64::from(self.rows) * u64::from(self.shells);
        strokes * u64::from(LeafStroke::STRIDE) + 4 * nodes + 4 * u64::from(self.rows)
    }
}

/// The thresholds at which rows have as nearly as possible the numbers of strokes wanted, from the
/// second row on: the angles are given, the distances are searched, each at least the one before.
///
/// # Panics
///
/// When a shell names a stroke that there is not.
#[must_use]
pub fn thresholds_for(
    strokes: &[LeafStroke],
    shells: &Shells,
    wanted: &[(u32, f32)],
    most_at_once: u32,
    inward: f32,
) -> Vec<CollapseThresholds> {
    let mut options = LevelOptions {
        thresholds: Vec::new(),
        most_at_once,
        inward,
    };
    let mut least = 0.01;
    for &(count, angle) in wanted {
        // Distances grow by powers of two, so halving is done on their logarithm.
        let (mut low, mut high) = (0.0_f32, 10.0_f32);
        let mut best = (u32::MAX, least);
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let distance = least * det::pow(2.0, middle);
            options
                .thresholds
                .push(CollapseThresholds { distance, angle });
            let levels = StrokeLevels::new(strokes, shells, &options);
            options.thresholds.pop();
            let total = *levels.totals.last().expect("there is a row");
            if total.abs_diff(count) < best.0 {
                best = (total.abs_diff(count), distance);
            }
            if total > count {
                low = middle;
            } else {
                high = middle;
            }
        }
        least = best.1;
        options.thresholds.push(CollapseThresholds {
            distance: best.1,
            angle,
        });
    }
    options.thresholds
}

/// How often a distance is halved in: to a hundred-thousandth of ten powers of two.
const STEPS: usize = 20;

/// The mean length of strokes; 1 where none has any.
fn mean_length(strokes: &[LeafStroke]) -> f32 {
    let lengths = strokes
        .iter()
        .map(|leaf| f64::from(2.0 * leaf.stroke.along.length()));
    let mean = lengths.fold(0.0, |sum, length| sum + length) / strokes.len().max(1) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "rounds")]
    let mean = mean as f32;
    if mean > 0.0 && mean.is_finite() {
        mean
    } else {
        1.0
    }
}
