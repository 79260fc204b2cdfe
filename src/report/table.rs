//! Tables, for terminals and as CSV; [`Page`](super::Page) shows the same as HTML.

use super::number::grouped;

/// A table: columns with headings, rows of cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows; a short row ends with [`Cell::Missing`], what a long one has too much is not
    /// shown.
    pub rows: Vec<Vec<Cell>>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// The heading, with the unit where there is one: `payload, B`.
    pub heading: String,
    /// Where its cells stand.
    pub align: Align,
}

/// Where the cells of a column stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// At the left, for words; gives way when the terminal is narrow.
    Left,
    /// At the right, for numbers.
    Right,
}

/// What stands in one place of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// An exact count.
    Count(u64),
    /// A measure.
    Number {
        /// The value.
        value: f64,
        /// Digits after the point that are shown to people; CSV has all.
        digits: usize,
    },
    /// Nothing: unknown, or not counted.
    Missing,
}

impl Column {
    /// A column of words.
    #[must_use]
    pub fn words(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            align: Align::Left,
        }
    }

    /// A column of numbers.
    #[must_use]
    pub fn numbers(heading: impl Into<String>) -> Self {
        Self {
            heading: heading.into(),
            align: Align::Right,
        }
    }
}

impl Cell {
    /// The cell for people, with a separator between groups of three digits.
    pub(super) fn shown(&self, separator: &str) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => grouped(*count, separator),
            Self::Number { value, digits } => {
                // All digits are kept, so that a column's points stand below each other.
                format!("{value:.digits$}")
            }
            Self::Missing => "–".to_owned(),
        }
    }

    /// The cell for programs.
    fn plain(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Count(count) => count.to_string(),
            Self::Number { value, .. } => value.to_string(),
            Self::Missing => String::new(),
        }
    }
}

impl Table {
    /// The least width of a column of words before the table becomes a list.
    const NARROWEST: usize = 8;

    /// What stands between columns.
    const GAP: &str = "  ";

    /// The table as text for a terminal of so many columns.
    ///
    /// Where it does not fit, columns of words are cut, the widest first; where that is not enough,
    /// each row becomes a list of `heading: cell`.
    #[must_use]
    pub fn to_text(&self, width: usize) -> String {
        let rows: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|row| {
                let cell = |index| row.get(index).unwrap_or(&Cell::Missing);
                let shown = |index| one_line(&Cell::shown(cell(index), ","));
                (0..self.columns.len()).map(shown).collect()
            })
            .collect();
        match self.widths(&rows, width) {
            Some(widths) => self.text_rows(&rows, &widths),
            None => self.text_list(&rows),
        }
    }

    /// The table as texts for a terminal of so many columns, each with the first column and as many
    /// others as fit beside its whole words.
    #[must_use]
    pub fn to_parts(&self, width: usize) -> Vec<String> {
        let mut parts = Vec::new();
        let mut next = 1;
        while next < self.columns.len() {
            let fits = |end: &usize| {
                let text = self.part(next, *end).to_text(usize::MAX);
                text.lines().all(|line| text_width(line) <= width)
            };
            let mut ends = (next + 1..=self.columns.len()).rev();
            let end = ends.find(fits).unwrap_or(next + 1);
            parts.push(self.part(next, end).to_text(width));
            next = end;
        }
        parts
    }

    /// The first column and some others.
    fn part(&self, from: usize, to: usize) -> Self {
        let kept = || std::iter::once(0).chain(from..to);
        let row = |row: &Vec<Cell>| kept().filter_map(|index| row.get(index).cloned()).collect();
        Self {
            columns: kept().map(|index| self.columns[index].clone()).collect(),
            rows: self.rows.iter().map(row).collect(),
        }
    }

    /// The table as CSV ([RFC 4180](https://www.rfc-editor.org/rfc/rfc4180)), headings first.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let headings = self.columns.iter().map(|column| column.heading.as_str());
        let mut csv = csv_row(headings);
        for row in &self.rows {
            let cell = |index| row.get(index).map(Cell::plain).unwrap_or_default();
            let cells: Vec<String> = (0..self.columns.len()).map(cell).collect();
            csv += &csv_row(cells.iter().map(String::as_str));
        }
        csv
    }

    /// The table in Markdown, as GitHub has it.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let row = |cells: &mut dyn Iterator<Item = String>| {
            let cells: Vec<String> = cells.map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = |column: &Column| match column.align {
            Align::Left => "---",
            Align::Right => "---:",
        };
        let mut text = row(&mut self.columns.iter().map(|column| column.heading.clone()));
        let rules: Vec<&str> = self.columns.iter().map(rule).collect();
        text += &format!("|{}|\n", rules.join("|"));
        for cells in &self.rows {
            let cell = |index| cells.get(index).unwrap_or(&Cell::Missing);
            let shown = |index| one_line(&Cell::shown(cell(index), ","));
            text += &row(&mut (0..self.columns.len()).map(shown));
        }
        text
    }

    /// The columns' widths, if the table fits.
    fn widths(&self, rows: &[Vec<String>], width: usize) -> Option<Vec<usize>> {
        let mut widths: Vec<usize> = self
            .columns
            .iter()
            .map(|column| text_width(&column.heading))
            .collect();
        for row in rows {
            for (widest, cell) in widths.iter_mut().zip(row) {
                *widest = (*widest).max(text_width(cell));
            }
        }
        let gaps = Self::GAP.len() * widths.len().saturating_sub(1);
        loop {
            if widths.iter().sum::<usize>() + gaps <= width {
                return Some(widths);
            }
            let words = self.columns.iter().zip(&mut widths);
            let widest = words
                .filter(|(column, width)| column.align == Align::Left && **width > Self::NARROWEST)
                .map(|(_, width)| width)
                .max_by_key(|width| **width)?;
            *widest -= 1;
        }
    }

    fn text_rows(&self, rows: &[Vec<String>], widths: &[usize]) -> String {
        let line = |cells: &mut dyn Iterator<Item = &str>| {
            let padded: Vec<String> = cells
                .zip(widths)
                .zip(&self.columns)
                .map(|((cell, width), column)| padded(cell, *width, column.align))
                .collect();
            format!("{}\n", padded.join(Self::GAP).trim_end())
        };
        let rule: Vec<String> = widths.iter().map(|width| "─".repeat(*width)).collect();
        let mut text = line(&mut self.columns.iter().map(|column| column.heading.as_str()));
        text += &line(&mut rule.iter().map(String::as_str));
        for row in rows {
            text += &line(&mut row.iter().map(String::as_str));
        }
        text
    }

    fn text_list(&self, rows: &[Vec<String>]) -> String {
        let blocks: Vec<String> = rows
            .iter()
            .map(|row| {
                let lines = self.columns.iter().zip(row);
                lines
                    .map(|(column, cell)| format!("{}: {cell}\n", column.heading))
                    .collect()
            })
            .collect();
        blocks.join("\n")
    }
}

/// One row of CSV, with the line's end (CR LF, as [RFC 4180](https://www.rfc-editor.org/rfc/rfc4180)
/// has it).
pub fn csv_row<'a>(fields: impl IntoIterator<Item = &'a str>) -> String {
    let fields: Vec<String> = fields
        .into_iter()
        .map(|field| match field.contains(['"', ',', '\r', '\n']) {
            true => format!("\"{}\"", field.replace('"', "\"\"")),
            false => field.to_owned(),
        })
        .collect();
    format!("{}\r\n", fields.join(","))
}

fn padded(text: &str, width: usize, align: Align) -> String {
    let missing = width.saturating_sub(text_width(text));
    match align {
        _ if text_width(text) > width => cut(text, width),
        Align::Left => format!("{text}{}", " ".repeat(missing)),
        Align::Right => format!("{}{text}", " ".repeat(missing)),
    }
}

/// The beginning of a text, with `…` at its end, in exactly so many columns.
fn cut(text: &str, width: usize) -> String {
    let mut beginning = String::new();
    let mut used = 0;
    for character in text.chars() {
        let next = used + character_width(character);
        if next + 1 > width {
            break;
        }
        beginning.push(character);
        used = next;
    }
    format!("{beginning}…{}", " ".repeat(width.saturating_sub(used + 1)))
}

fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

/// The columns that a text takes on a terminal.
fn text_width(text: &str) -> usize {
    text.chars().map(character_width).sum()
}

/// 0 for marks that stand on the character before them, 2 for the scripts of East Asia and for
/// pictographs, else 1: the blocks that names of trees may use, not all of Unicode.
fn character_width(character: char) -> usize {
    match u32::from(character) {
        0x0300..=0x036f | 0x200b..=0x200d | 0x20d0..=0x20ff | 0xfe00..=0xfe0f => 0,
        0x1100..=0x115f
        | 0x2e80..=0xa4cf
        | 0xac00..=0xd7a3
        | 0xf900..=0xfaff
        | 0xfe30..=0xfe6f
        | 0xff00..=0xff60
        | 0xffe0..=0xffe6
        | 0x1_f300..=0x1_faff
        | 0x2_0000..=0x3_fffd => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Table {
        let text = |text: &str| Cell::Text(text.to_owned());
        let number = |value| Cell::Number { value, digits: 2 };
        Table {
            columns: vec![
                Column::words("cause"),
                Column::numbers("payload, B"),
                Column::numbers("time, ms"),
            ],
            rows: vec![
                vec![text("slots"), Cell::Count(1_234_567), number(1.5)],
                vec![text("draw-count of clusters"), Cell::Count(4), number(12.0)],
                vec![text("松"), Cell::Missing],
            ],
        }
    }

    #[test]
    fn wide_terminals_get_columns() {
        let wanted = "\
cause                   payload, B  time, ms
──────────────────────  ──────────  ────────
slots                    1,234,567      1.50
draw-count of clusters           4     12.00
松                               –         –
";
        assert_eq!(example().to_text(80), wanted);
        assert_eq!(example().to_text(44), wanted, "it fits exactly");
    }

    #[test]
    fn narrow_terminals_cut_words() {
        let wanted = "\
cause         payload, B  time, ms
────────────  ──────────  ────────
slots          1,234,567      1.50
draw-count …           4     12.00
松                     –         –
";
        assert_eq!(example().to_text(34), wanted);
    }

    #[test]
    fn very_narrow_terminals_get_a_list() {
        let wanted = "\
cause: slots
payload, B: 1,234,567
time, ms: 1.50

cause: draw-count of clusters
payload, B: 4
time, ms: 12.00

cause: 松
payload, B: –
time, ms: –
";
        assert_eq!(example().to_text(20), wanted);
        assert_eq!(example().to_text(0), wanted);
        assert_eq!(Table::default().to_text(0), "\n\n");
    }

    #[test]
    fn parts_repeat_the_first_column() {
        let parts = example().to_parts(36);
        let headings = |part: &String| part.lines().next().map(str::to_owned);
        let found: Vec<_> = parts.iter().map(headings).collect();
        let wanted = [
            "cause                   payload, B",
            "cause                   time, ms",
        ];
        assert_eq!(found, wanted.map(|line| Some(line.to_owned())));
        assert_eq!(example().to_parts(44), [example().to_text(44)]);
    }

    #[test]
    fn csv_keeps_every_value_and_its_columns() {
        assert_eq!(
            example().to_csv(),
            "cause,\"payload, B\",\"time, ms\"\r\nslots,1234567,1.5\r\ndraw-count of clusters,4,12\r\n松,,\r\n"
        );
        assert_eq!(
            csv_row(["a\"b", "c,d", "e\nf", ""]),
            "\"a\"\"b\",\"c,d\",\"e\nf\",\r\n"
        );
    }

    #[test]
    fn markdown_keeps_columns_apart() {
        let mut table = example();
        table.rows.truncate(1);
        table.rows[0][0] = Cell::Text("a|b".to_owned());
        let wanted = "\
| cause | payload, B | time, ms |
|---|---:|---:|
| a\\|b | 1,234,567 | 1.50 |
";
        assert_eq!(table.to_markdown(), wanted);
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let mut table = example();
        table.rows = vec![vec![Cell::Text("a\u{1b}[2Jb\nc".to_owned())]];
        assert!(table.to_text(80).contains("a [2Jb c"));
    }

    #[test]
    fn cutting_never_splits_a_wide_character() {
        assert_eq!(cut("松松松", 4), "松… ");
        assert_eq!(cut("abc", 2), "a…");
    }
}
